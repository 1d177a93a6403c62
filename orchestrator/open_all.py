"""The units of a scene, started for a run, or to be asked something."""

from __future__ import annotations

from contextlib import ExitStack

from .engine.algorithms.contact import ContactUnit
from .scene.scene import Scene
from .units import Unit, open_unit


def open_units(scene: Scene, stack: ExitStack, in_process: bool) -> dict[str, Unit]:
    """The running units of a scene by name, and its contacts, which are units of the graph; `stack` closes them."""
    units: dict[str, Unit] = {}
    for name, unit in scene.units.items():
        units[name] = open_unit(name, unit, in_process=in_process)
        stack.callback(units[name].close)
    return units | {contact.name: ContactUnit(contact, scene.master.extrapolation) for contact in scene.contacts}
