"""Operating points: where the rates of a coupled set vanish, and whether it stays there, by the eigenvalues of its linearisation.

The rates are any function of the state, x' = f(x), or those of a scene whose units are components:

    rates = SceneRates(scene, {"turbine": [0], "converter": [0]})
    point = operating_point(rates, rates.start)

Rotating angles and modes, which are whole numbers, have no equilibrium: they are omitted and keep their values of the start. A set that
pulsates, such as a piston pump, has no operating point; its cycle average has one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....components.core.component import Component
from ....components.core.errors import BadInput, StepFailed
from ...scene.scene import Scene
from ...units.component import make

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
            f"{self._where}: operating point",
            f"inputs that still change by {changed:.2g} after {SWEEPS} exchanges",
            "outputs that converge",
            "Units in an algebraic loop may belong into one component.",
        )


Rates = Callable[[np.ndarray], np.ndarray]
ITERATIONS = 50
HALVINGS = 30  # of a Newton step that leads to larger rates
SETTLED = 1e-9  # last Newton step over the scales
DIFFERENCE = 1e-5  # of a scale: the error of a central difference is 1e-10 of the third derivative, and rounding's 1e-11
STEP = 1e-4  # s


@dataclass(frozen=True)
class OperatingPoint:
    """An equilibrium x, (n,), the derivative of the rates there, (n, n), and its eigenvalues, (n,), the least damped first."""

    state: np.ndarray
    matrix: np.ndarray
    eigenvalues: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether every small deviation dies out."""
        return bool(self.eigenvalues[0].real < 0.0)

    @property
    def time_constant(self) -> float:
        """What the slowest deviation takes to fall to 1/e, or the fastest to grow by e, s."""
        return 1.0 / abs(float(self.eigenvalues[0].real))


@dataclass(frozen=True)
class OperatingLine:
    """Operating points over the values of a parameter, (k,); states and eigenvalues are NaN where none was found.

    states: (k, n).  eigenvalues: (k, n), the least damped first.
    """

    values: np.ndarray
    states: np.ndarray
    eigenvalues: np.ndarray

    @property
    def exists(self) -> np.ndarray:
        """Where there is a point, (k,)."""
        return np.isfinite(self.states).all(axis=1)

    @property
    def stable(self) -> np.ndarray:
        """Where there is one that deviations return to, (k,)."""
        return self.exists & (np.nan_to_num(self.eigenvalues[:, 0].real, nan=1.0) < 0.0)


def linearised(rates: Rates, state: np.ndarray, scales: np.ndarray | None = None) -> np.ndarray:
    """The derivative of the rates (n,) by the state (n,), (n, n), by central differences of a small share of the scales."""
    steps = DIFFERENCE * _scales(state, scales)
    columns = []
    for i, step in enumerate(steps):
        shift = np.zeros_like(state)
        shift[i] = step
        columns.append((rates(state + shift) - rates(state - shift)) / (2.0 * step))
    return np.array(columns).T


def operating_point(rates: Rates, start: Sequence[float] | np.ndarray, scales: np.ndarray | None = None) -> OperatingPoint:
    """The equilibrium that Newton's method reaches from `start`, (n,); its steps are shortened where the rates grow.

    scales: magnitudes of the states, (n,), against which differences and corrections are small; without it those of the start,
        and no less than 1. Raises `BadInput` where no equilibrium is reached.
    """
    state = np.array(start, dtype=float)
    size = _scales(state, scales)
    value = np.asarray(rates(state), dtype=float)
    for _ in range(ITERATIONS):
        matrix = linearised(rates, state, size)
        if not (np.isfinite(value).all() and np.isfinite(matrix).all()):
            break
        change = np.linalg.lstsq(matrix * size, -value, rcond=1e-14)[0]  # in scales
        answered = SETTLED * np.abs(matrix * size).sum(axis=1)  # rates that a small step may leave, unless nothing answers them
        if np.abs(change).max() <= SETTLED and (np.abs(value) <= 2.0 * answered).all():
            state += change * size
            values = np.linalg.eigvals(matrix)
            return OperatingPoint(state, matrix, values[np.argsort(-values.real, kind="stable")])
        least = np.abs(value / size).max()
        for halving in range(HALVINGS):
            trial = state + 0.5**halving * change * size
            derivatives = np.asarray(rates(trial), dtype=float)
            if np.abs(derivatives / size).max() < least:
                break
        else:
            break  # nowhere along the step are the rates smaller
        state, value = trial, derivatives
    shown = ", ".join(f"{x:.4g}" for x in state)
    raise BadInput(
        "operating point",
        f"rates up to {np.abs(value).max():.3g} at the state ({shown})",
        "a state at which they vanish",
        "Start closer to it; there may be none.",
    )


def operating_line(
    rates: Callable[[float], Rates],
    values: Iterable[float],
    start: Sequence[float] | np.ndarray,
    scales: np.ndarray | None = None,
) -> OperatingLine:
    """Operating points of `rates(value)` at each value, the first sought from `start`, each next from the last one found."""
    state = np.array(start, dtype=float)
    given = [float(v) for v in values]
    states, eigenvalues = np.full((len(given), state.size), np.nan), np.full((len(given), state.size), np.nan, dtype=complex)
    for k, value in enumerate(given):
        here = rates(value)
        try:
            point = operating_point(here, state, scales)
        except BadInput:
            continue
        state = states[k] = point.state
        eigenvalues[k] = point.eigenvalues
    return OperatingLine(np.array(given), states, eigenvalues)


class SceneRates:
    """Rates of the chosen states of a scene's components, as they are connected, at the scene's start.

    A rate is what a step of each component that is short against all its motions makes of its state while its inputs stand
    still, extrapolated from two lengths to length zero: no component has to offer its equations. An equilibrium is one to the
    last digits, whatever the length. Outputs that depend on one another within the instant are exchanged until they stand.

    states: unit -> elements of its x that belong to the equilibrium; modes and angles stay as the scene starts.
    step: s.  start: the chosen states as the scene starts, (n,).
    Raises `BadInput` for units that are no components, and where outputs do not converge.
    """

    def __init__(self, scene: Scene, states: Mapping[str, Sequence[int]], step: float = STEP):
        self._connected = Connected(scene)
        if unknown := states.keys() - scene.units.keys():
            raise BadInput(f"{scene.name}: states", f"unit {min(unknown)!r}", "units of the scene: " + ", ".join(scene.units))
        self._components = self._connected.components
        self._step = step
        self._connected.initialize()
        self._saved = {name: component.save() for name, component in self._components.items()}
        for name, chosen in states.items():
            size = self._components[name].x.size
            if not all(0 <= i < size for i in chosen):
                raise BadInput(f"{scene.name}: states of {name}", f"{list(chosen)}", f"elements of a state of {size} numbers")
        self._states = {name: list(chosen) for name, chosen in states.items()}
        self.start = np.concatenate([self._components[n].x[i] for n, i in self._states.items()])

    def __call__(self, state: np.ndarray) -> np.ndarray:
        """Rates (n,) at the chosen states (n,); NaN at states from which a component cannot step."""
        place = 0
        for name, component in self._components.items():
            component.restore(self._saved[name])
        for name, chosen in self._states.items():
            self._components[name].x[chosen] = state[place : place + len(chosen)]
            place += len(chosen)
        self._connected.refresh()
        rates = []
        for name, chosen in self._states.items():
            component = self._components[name]
            before, saved, slopes = component.x[chosen], component.save(), []
            for length in (self._step, 0.5 * self._step):
                try:
                    component.step(0.0, length)
                except StepFailed:
                    return np.full_like(state, np.nan)
                slopes.append((component.x[chosen] - before) / length)
                component.restore(saved)
            rates.append(2.0 * slopes[1] - slopes[0])
        return np.concatenate(rates)

    def outputs(self, state: np.ndarray) -> dict[str, float]:
        """Every output, "unit.name", at the chosen states."""
        self(state)
        return {f"{name}.{output}": unit[output] for name, unit in self._components.items() for output in unit.outputs}


def _scales(state: np.ndarray, scales: np.ndarray | None) -> np.ndarray:
    return np.maximum(np.abs(state), 1.0) if scales is None else np.asarray(scales, dtype=float)
