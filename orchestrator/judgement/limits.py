"""What to say of a macro step that has made a run unstable."""

from __future__ import annotations

from contextlib import ExitStack

from ...components.core.errors import BadInput, StepFailed
from ..engine.algorithms import master_of
from ..open_all import open_units
from ..scene.scene import Scene
from .probing import Contact, contacts


def remedy(scene: Scene) -> str:
    """That the macro step is to be reduced, and below what where a closed form tells."""
    degree = scene.master.extrapolation
    short = min((c for c in _limits(scene) if c.longest[degree] < scene.master.step), key=lambda c: c.longest[degree],
                default=None)
    if short is None:
        return "Reduce the macro step; cosimo stability tells how long it may be"
    if not (limit := short.longest[degree]):
        return (f"Reduce the macro step, or take another master.extrapolation: with {degree}, {short.pair} is stable at no step "
                "unless something damps it elsewhere")
    return f"Reduce the macro step: {short.pair} is stable up to {limit:.3g} s with master.extrapolation = {degree}"


def _limits(scene: Scene) -> tuple[Contact, ...]:
    """The scene is started anew to ask its units, in this process; nothing where it does not start."""
    coupling = scene.coupling
    with ExitStack() as stack:
        try:
            units = open_units(scene, stack, in_process=True)
            master = master_of(scene, units, coupling)
            master.initialize(0.0)
            return contacts(scene, coupling, master, units)[0]
        except (BadInput, StepFailed):
            return ()
