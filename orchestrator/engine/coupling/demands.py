"""What steps of changing length, events and power bonds demand of units; checked before a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ....components.core.errors import BadInput
from ...settings import MasterSettings
from ...units import Interface
from .bonds import Bond
from .graph import Link, smooth


def check_stepping(
    master: MasterSettings,
    interfaces: Mapping[str, Interface],
    links: Iterable[Link],
    bonds: tuple[Bond, ...],
    rates: Iterable[str],
) -> None:
    """Raises `BadInput` for `master.control`, `events` or `bonds` that a unit cannot serve, or that would have no effect."""
    if master.control is not None:
        _check_control(master, interfaces, links)
    if master.events:
        _all("master.events", "a list of signals", "change the length of a step", {n: free(i) for n, i in interfaces.items()})
        _all(
            "master.events",
            "a list of signals",
            "save their state, so that a step can end at an event",
            {n: i.saves_state for n, i in interfaces.items()},
        )
    for bond in bonds:
        for unit, _ in bond.given:
            if unit in rates:
                raise BadInput(
                    f"master.bonds: {bond.text!r}",
                    f"{unit}, which steps at a rate of its own",
                    "units that step in every macro step",
                )
    if master.energy_correction:
        _check_correction(interfaces, bonds)


def _check_control(master: MasterSettings, interfaces: Mapping[str, Interface], links: Iterable[Link]) -> None:
    control, where = master.control, "master.control"
    assert control is not None
    smallest, longest = control.min_step, control.max_step
    for label, limit, beyond in (
        ("min_step", smallest, smallest is not None and master.step < smallest),
        ("max_step", longest, longest is not None and master.step > longest),
    ):
        if beyond:
            raise BadInput(
                "master.step",
                f"{master.step:g} s",
                f"{'at least' if label == 'min_step' else 'at most'} {where}.{label}, {limit:g} s; it is the first step",
            )
    _all(f"{where}.method", repr(control.method), "change the length of a step", {n: free(i) for n, i in interfaces.items()})
    if control.method == "doubling":
        _all(f"{where}.method", "'doubling'", "save their state", {n: i.saves_state for n, i in interfaces.items()})
    if not smooth(interfaces, links):
        raise BadInput(
            f"{where}.method",
            repr(control.method),
            "connections whose values change inside a step; there are none, and so no error to go by",
            "Remove master.control.",
        )


def free(interface: Interface) -> bool:
    """Whether a unit takes steps of any length."""
    return interface.variable_step and not interface.fixed_step


def _all(where: str, actual: str, able: str, units: Mapping[str, bool]) -> None:
    unable = [name for name, can in units.items() if not can]
    if unable:
        raise BadInput(where, actual, f"units that {able}; {', '.join(unable)} cannot")


def _check_correction(interfaces: Mapping[str, Interface], bonds: tuple[Bond, ...]) -> None:
    """A unit that holds its inputs ends a step with the correction still on them: its outputs must not depend on them."""
    for unit, name in (link.target for bond in bonds for link in bond.links):
        held = interfaces[unit].input_degree < 2
        if held and any(name in (output.feedthrough or ()) for output in interfaces[unit].outputs.values()):
            raise BadInput(
                "master.energy_correction",
                "true",
                f"units that take inputs as polynomials; {unit} holds them, and its outputs depend on {name} at once",
            )
