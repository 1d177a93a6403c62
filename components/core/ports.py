"""Ports: signals of a component that go to one partner together, as FMUs have them as terminals and drawings as one line.

A component declares them on its class, own signals by name and all those of an effect as "effect.*":

    ports = {"shaft": ("displacement_x", "displacement_y", "linearisation.*")}

What no declared port takes is a port of its effect; own signals that are left over are the port "".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

Declared = Mapping[str, tuple[str, ...]]  # port -> own signals, and effects as "effect.*"


def port_of(signal: str, declared: Declared) -> str:
    """The port of an input or output, which may be an element of an array."""
    effect = signal.rpartition(".")[0]
    whole = signal.partition("[")[0]
    for port, signals in declared.items():
        if whole in signals or (effect and f"{effect}.*" in signals):
            return port
    return effect


def gathered(signals: Iterable[str], declared: Declared) -> dict[str, dict[str, str]]:
    """Port -> member -> signal, each in the order of the signals. A member is what a signal is called within its port."""
    ports: dict[str, dict[str, str]] = {}
    for signal in signals:
        ports.setdefault(port_of(signal, declared), {})[signal.rpartition(".")[2]] = signal
    return ports
