"""What each fault of a scene changes, checked before the run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ....components.core.errors import BadInput, nearest
from ...settings import FaultSettings, SceneSettings
from ...units import Interface
from .graph import Endpoint, Link


def targets(
    fault: FaultSettings,
    where: str,
    end: Endpoint | None,
    scene: SceneSettings,
    interfaces: Mapping[str, Interface],
    links: Iterable[Link],
) -> tuple[Endpoint, ...]:
    """The inputs that a fault changes; raises `BadInput` for one that would change nothing, or cannot be.

    `where`: the fault as messages name it. `end`: its signal, None for a lost unit.
    """
    if fault.begin >= scene.stop_time:
        raise BadInput(f"{where}.begin", f"{fault.begin:g} s", f"a time before the end of the run, {scene.stop_time:g} s")
    for key, time in (("begin", fault.begin), ("end", fault.end)):
        rest = (time or 0.0) / scene.master.step % 1.0
        if min(rest, 1.0 - rest) > 1e-9:
            for name, interface in interfaces.items():
                if not interface.variable_step:
                    raise BadInput(
                        f"{where}.{key}",
                        f"{time:g} s",
                        f"a multiple of master.step, {scene.master.step:g} s; {name} cannot make a step shorter",
                    )
    if end is None:
        if fault.unit not in interfaces:
            raise BadInput(f"{where}.unit", repr(fault.unit), "a unit of the scene", nearest(fault.unit, interfaces))
        return ()
    unit, name = end
    fed = tuple(link for link in links if end in (link.source, link.target))
    if not fed:
        interface = interfaces[unit]
        if name in interface.inputs or name in interface.outputs:
            raise BadInput(
                f"{where}.signal",
                f"{fault.signal!r}, which nothing is connected to",
                "a connected signal",
                "A value for such an input stands in its unit's parameters." if name in interface.inputs else "",
            )
        raise BadInput(
            f"{where}.signal",
            repr(fault.signal),
            f"an output or input of {unit}",
            nearest(name, [*interface.outputs, *interface.inputs]),
        )
    for link in fed:
        _check_kind(fault, where, link, interfaces)
    return tuple(link.target for link in fed)


def _check_kind(fault: FaultSettings, where: str, link: Link, interfaces: Mapping[str, Interface]) -> None:
    signal = interfaces[link.target[0]].inputs[link.target[1]]
    name, value = ".".join(link.target), fault.value
    if signal.is_text:
        raise BadInput(f"{where}.signal", f"{fault.signal!r}, a text", "a number")
    if fault.kind == "offset" and signal.kind in ("boolean", "enumeration"):
        raise BadInput(f"{where}.kind", f"'offset' of {name}", f"override, freeze or drop for a signal of kind {signal.kind}")
    if value is not None and signal.kind != "real":
        if not value.is_integer():
            raise BadInput(f"{where}.value", f"{value:g}", f"a whole number for {name}")
        if signal.kind == "boolean" and value not in (0.0, 1.0):
            raise BadInput(f"{where}.value", f"{value:g}", f"0 or 1 for {name}")
    if fault.kind == "offset" and value == 0.0:
        raise BadInput(f"{where}.value", "0", "another offset; this one has no effect")
