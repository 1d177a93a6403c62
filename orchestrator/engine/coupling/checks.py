"""What the settings of a scene demand of its units; checked before a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ....components.core.errors import BadInput, nearest
from ...settings import FaultSettings, MasterSettings, SceneSettings
from ...units import Interface
from .bonds import Bond
from .graph import Endpoint, Link, smooth


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
            "a connection whose value changes within a step, for the estimate of the step error; this scene has none",
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
    if fault.end is not None and fault.end <= scene.start_time:
        raise BadInput(f"{where}.end", f"{fault.end:g} s", f"a time after the start of the run, {scene.start_time:g} s")
    for key, time in (("begin", fault.begin), ("end", fault.end)):
        rest = max((time or 0.0) - scene.start_time, 0.0) / scene.master.step % 1.0
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
        raise BadInput(f"{where}.value", "0", "an offset other than 0")
