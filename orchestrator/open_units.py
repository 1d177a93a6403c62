"""The units of a scene, started for a run, or to be asked something."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING

from .engine.algorithms.contact import ContactSimulator
from .engine.coupling import Endpoint
from .scene.scene import Scene
from .units import Simulator, open_unit
from .units.exit_guard import ExitGuard

if TYPE_CHECKING:
    from .units.native import NativeFmu


def open_units(
    scene: Scene,
    stack: ExitStack,
    in_process: bool,
    rescue: Callable[[str], None] | None = None,
    native: Mapping[str, NativeFmu] | None = None,
) -> dict[str, Simulator]:
    """The running units of a scene by name, and its contacts, which are units of the graph; `stack` closes them.

    `rescue` is called with what has happened where an FMU ends this process. `native`: native FMUs of components.
    """
    stack.enter_context(ExitGuard([n for n, unit in scene.units.items() if unit.fmu and unit.isolation == "none"], rescue))
    units: dict[str, Simulator] = {}
    for name, unit in scene.units.items():
        units[name] = open_unit(name, unit, in_process=in_process, native=(native or {}).get(name))
        stack.callback(units[name].close)
    return units | {contact.name: ContactSimulator(contact, scene.master.extrapolation) for contact in scene.contacts}


def read_in_every_step(scene: Scene) -> tuple[Endpoint, ...]:
    """Recorded outputs that the master reads in every step, and goes by at the start, although no connection may need them."""
    record, master = scene.record, scene.master
    each = record.interval is None or (record.interval == master.step and master.control is None)
    return scene.coupling.signals if each else ()
