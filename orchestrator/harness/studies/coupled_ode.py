"""A scene as one ordinary differential equation, where all its units are smooth: solved without a master, by SciPy's methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ....components.core.component import Component
from ....components.core.contract import KernelComponent
from ....components.core.errors import BadInput
from ...scene.scene import Scene
from ...units.component import make
from .quantities import TimeHistory

SWEEPS = 50
CONVERGED = 1e-13  # relative change of an input from one sweep to the next


class Connected:
    """Components whose inputs follow their outputs within the instant, without a master.

    components: by the unit's name, each behind those that feed it where there is no circle. Raises `BadInput` for units that
    are no components.
    """

    def __init__(self, scene: Scene):
        if others := [name for name in scene.units if name not in scene.component_classes]:
            raise BadInput(f"{scene.name}: {others[0]}", "a unit from an FMU", "a component, whose state can be set")
        coupling = scene.coupling
        names = [name for name in coupling.order() if name in scene.units]
        self.components = {name: make(name, scene.units[name]) for name in names}
        self._where, self._start = scene.name, scene.start_time
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
        """All components at the start of a run, as they give one another their inputs; raises `BadInput` where these do not converge."""
        self._exchange(lambda component: component.initialize(self._start))

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
            if changed <= CONVERGED:
                return
        raise BadInput(
            f"{self._where}: differential equation",
            f"inputs that still change by {changed:.2g} after {SWEEPS} exchanges",
            "outputs that converge",
            "Units in an algebraic loop may belong into one component.",
        )


def rate_kernel(cls: type[Component]) -> Callable[..., None] | None:
    """The kernel `derivatives(t, x, u, dx, s, p, e)` of a component; None where there is none.

    What advances a component with events, samples or a method of its own is no smooth differential equation.
    """
    return cls.kernels.derivatives if issubclass(cls, KernelComponent) else None


class CoupledOde:
    """x' = f(t, x) of all states of a scene, its units as they are connected.

    start: (n,), at the start of the run.  calls: evaluations of the rates so far. Raises `BadInput` where the scene is no smooth ODE:
    contacts, faults, FMUs, components with events, with samples, or with an integrator of their own, loops that do not converge.
    """

    def __init__(self, scene: Scene):
        def refuse(what: str) -> BadInput:
            return BadInput(f"{scene.name}: differential equation", what, "smooth components and plain connections")

        if scene.contacts or scene.faults:
            raise refuse("contacts or faults")
        self._connected = Connected(scene)
        components = self._connected.components
        kernels = {name: rate_kernel(type(c)) for name, c in components.items()}
        self._connected.initialize()
        for name, component in components.items():
            if kernels[name] is None and component.x.size:
                raise refuse(f"unit {name!r}, which is no smooth differential equation")
        self._parts: list[tuple[Any, Any, slice]] = []
        place = 0
        for name, component in components.items():
            if component.x.size:
                self._parts.append((component, kernels[name], slice(place, place + component.x.size)))
                place += component.x.size
        if not place:
            raise refuse("no states")
        self.start = np.concatenate([component.x for component, _, _ in self._parts])
        self._all = list(components.values())
        self._linked = len(self._all) > 1
        self.calls = 0

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        """Rates, (n,)."""
        self._put(t, x)
        rates = np.empty_like(self.start)
        for component, kernel, place in self._parts:
            kernel(t, component.x, component.u[0], rates[place], *component.arguments)
        self.calls += 1
        return rates

    def _put(self, t: float, x: np.ndarray, outputs: bool = False) -> None:
        for component, _, place in self._parts:
            component.x[:] = x[place]
        for component in self._all:
            component.t = t
        if self._linked or outputs:
            self._connected.refresh()

    def history(self, time: np.ndarray, states: np.ndarray, signals: Sequence[str]) -> TimeHistory:
        """Outputs "unit.name" along states (k, n) at the instants (k,)."""
        components = self._connected.components
        ends = []
        for signal in signals:
            unit = max((u for u in components if signal.startswith(u + ".")), key=len)
            component = components[unit]
            ends.append((component.y, int(component.output_positions([signal[len(unit) + 1 :]])[0])))
        values = np.empty((time.size, len(ends)))
        for k, (t, x) in enumerate(zip(time.tolist(), states, strict=True)):
            self._put(t, x, outputs=True)
            values[k] = [y[i] for y, i in ends]
        return TimeHistory(time, dict(zip(signals, values.T, strict=True)))
