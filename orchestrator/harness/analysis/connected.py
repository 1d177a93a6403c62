"""The components of a scene as they are connected, at one instant: every input what the outputs say, nothing stepped."""

from __future__ import annotations

from collections.abc import Callable

from ....components.core.component import Component
from ....components.core.errors import BadInput
from ...scene.scene import Scene
from ...units.component import make

SWEEPS = 50
STANDING = 1e-13  # relative change of an input from one sweep to the next


class Connected:
    """Components whose inputs follow their outputs within the instant, without a master.

    components: by the unit's name, each behind those that feed it where there is no circle. Raises `BadInput` for units that
    are no components.
    """

    def __init__(self, scene: Scene):
        for name, unit in scene.units.items():
            if not unit.component:
                raise BadInput(f"{scene.name}: {name}", "a unit from an FMU", "a component, whose state can be set")
        coupling = scene.coupling
        names = [name for name in coupling.order() if name in scene.units]
        self.components = {name: make(name, scene.units[name]) for name in names}
        self._where = scene.name
        self._links = [
            (
                self.components[link.source[0]],
                link.source[1],
                self.components[link.target[0]],
                link.target[1],
                link.factor,
                link.offset,
            )
            for link in coupling.links
            if link.source[0] in self.components and link.target[0] in self.components
        ]

    def initialize(self) -> None:
        """All components at t = 0, as they give one another their inputs; raises `BadInput` where these do not converge."""
        self._exchange(lambda component: component.initialize(0.0))

    def refresh(self) -> None:
        """Outputs that follow the present states and one another; raises `BadInput` where they do not converge."""
        self._exchange(Component.refresh)

    def _exchange(self, update: Callable[[Component], None]) -> None:
        """Update the components, and hand outputs over, until no input changes."""
        for _ in range(SWEEPS):
            for component in self.components.values():
                update(component)
            changed = 0.0
            for source, output, target, name, factor, offset in self._links:
                value = factor * source[output] + offset
                changed = max(changed, abs(value - target[name]) / max(abs(value), 1e-3 * target.variables[name].nominal))
                target.set(name, value)
            if changed <= STANDING:
                return
        raise BadInput(
            f"{self._where}: operating point",
            f"inputs that still change by {changed:.2g} after {SWEEPS} exchanges",
            "outputs that converge",
            "Units in an algebraic loop may belong into one component.",
        )
