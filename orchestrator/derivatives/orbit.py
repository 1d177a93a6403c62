"""Periodic orbits: fixed points of the map over a period, by shooting with the exact derivative of its macro steps.

The period is that of a forcing, or unknown: then an angle that turns, or a phase condition, fixes the instant. Angles close modulo
2 pi. The multipliers (Floquet) are the eigenvalues of the map's derivative, without the one along the motion. Where a contact
opens or closes inside a step, the tangents of that step hold: they are those of the run.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from math import ceil, lcm, pi

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..scene.names import parameter_of
from ..scene.scene import Scene
from .coupled_step import sampling_periods
from .newton import newton
from .state_map import Image, StateMap

TURN = 2.0 * pi
ACTS = 1e-12  # derivatives below are none
LATER = 7  # common periods to a second look
SHIFT = 1e-7  # singular values of motions that act on nothing, such as one of all bodies
BACK = 1e-6  # of the length of a step: a difference by the period
INSIDE = 1e-8  # of the sizes: what residuals may leave
NEUTRAL = 1e-6  # of a multiplier from 1: nothing restores such a motion; folds are passed by wider steps
REPEATS = 1e-4  # of a signal's range, times the largest multiplier: what a second period may differ by
ROOM = 1e-9  # of a macro step: a period of whole steps has no further one


@dataclass(frozen=True)
class Forcing:
    """What the period follows from.

    period: s, of what depends on time.  frequency: a parameter with it in Hz or rad/s.  angle: a state, or an output that is one, that
    turns; its turn over `turns` is the period.  Without any of them: what turns by itself and acts on others, else a free oscillation.
    multiple: so many periods to an orbit.
    """

    period: float = 0.0
    frequency: str = ""
    angle: str = ""
    turns: float = 1.0
    multiple: int = 1


@dataclass(frozen=True)
class Orbit:
    """value: of the parameter.  period: s.  multipliers: (k,), the largest first.  low, high, first: (S,) of the recorded signals.

    sections: (multiple, S), signals at the beginning of each period of the forcing.  unknown: state, period, parameter.
    refused: why this is no orbit that stands alone, though it closes.
    """

    value: float
    period: float
    multipliers: np.ndarray
    low: np.ndarray
    high: np.ndarray
    sections: np.ndarray
    unknown: np.ndarray
    refused: str = ""

    @property
    def stable(self) -> bool:
        """Whether all small deviations die out."""
        return bool(np.abs(self.multipliers).max(initial=0.0) < 1.0)


class Shooting:
    """The equations of an orbit of a scene: unknown are state, period and, where there is one, a parameter."""

    def __init__(self, scene: Scene, stack: ExitStack, forcing: Forcing, parameter: str = "", steps: int = 0):
        """parameter: that orbits are followed over.  steps: macro steps of a period, at least. Raises `BadInput`."""
        self.scene, self.forcing, self.parameter, self.where = scene, forcing, parameter, f"orbit of {scene.name}"
        if periods := sampling_periods(scene):
            remedy = "An orbit needs a map that depends on the state alone."
            raise BadInput(self.where, f"a sampled controller ({min(periods)})", "units without samples of their own", remedy)
        ends = [(u, n) for u in scene.units for n, s in scene.coupling.interfaces[u].outputs.items() if not s.is_text]
        self._outputs = [".".join(end) for end in ends]
        self._units = {".".join(end): scene.coupling.interfaces[end[0]].outputs[end[1]].unit for end in ends}
        self.map = StateMap(scene, stack, self.where, (parameter,) if parameter else (), self._outputs)
        self.signals = [".".join(end) for end in scene.coupling.signals]
        order = [".".join(end) for end in self.map.block.signals]
        self._shown = [order.index(name) for name in self.signals]
        self._every, self._steps = lcm(*(unit.every for unit in scene.units.values())), steps
        self._rate = self._rate_of(forcing.frequency) if forcing.frequency else None
        self.map.begin()
        self.map.find_nearby()
        self._phase()
        self.multiple = forcing.multiple

    def _rate_of(self, name: str) -> float:
        """2 pi of a frequency in rad/s, 1 of one in Hz: over it, the frequency is the period."""
        known = parameter_of(self.scene, name)
        unit, variable = self.scene.split(name)
        inputs = self.scene.coupling.interfaces[unit].inputs if unit in self.scene.units else {}
        measure = known.unit if known is not None else inputs[variable].unit if variable in inputs else ""
        if measure not in ("Hz", "rad/s"):
            raise BadInput(f"{self.where}: frequency", repr(name), "a parameter or a free input in Hz or rad/s")
        return 1.0 if measure == "Hz" else TURN

    # -- what turns, and what is left out ----------------------------------------------------------------------------
    def _phase(self) -> None:
        """The cell that fixes the phase, those that are angles, and those that act on nothing and are left out."""
        self.map.begin(steps=self._every)  # over a period the motion itself is a direction that is kept
        z, names = self.map.z, self.map.names()
        n = z.size
        later = self.map.run(z, LATER * self.map.step.steps)
        other, image = self.map(later), self.map(z)
        matrices = [one.by_state[:n] - np.eye(n) for one in (other, image)]
        acts = np.maximum(*np.abs(matrices)) > ACTS
        by_outputs = np.abs(image.by_state[n:])
        self.angles = np.zeros(n, dtype=bool)
        aliases: dict[str, int] = {name: k for k, name in enumerate(names)}
        for row, name in enumerate(self._outputs):
            same = np.flatnonzero(by_outputs[row] > ACTS)
            if same.size == 1 and abs(by_outputs[row, same[0]] - 1.0) < 1e-9:
                aliases.setdefault(name, int(same[0]))
                self.angles[same[0]] |= self._units[name] == "rad"
        free = ~acts.any(axis=1) & acts.any(axis=0)  # nothing acts on it, it acts on others: a clock where it moves
        turning = np.flatnonzero(free & (image.z != z))
        self.turning: int | None = None
        if self.forcing.angle:
            if self.forcing.angle not in aliases:
                known = ", ".join([n for n, k in aliases.items() if self.angles[k]][:8]) or ", ".join(names[:8])
                raise BadInput(f"{self.where}: angle", repr(self.forcing.angle), "a state or an output that is one", known)
            self.turning = aliases[self.forcing.angle]
        elif not (self.forcing.period or self.forcing.frequency) and turning.size:
            self.turning = int(turning[0])
        self.angles[turning] = True
        if self.turning is not None:
            self.angles[self.turning] = True
        self.kept = acts.any(axis=0) | (np.arange(n) == (-1 if self.turning is None else self.turning))
        self.unknown_period = not (self.forcing.period or self.forcing.frequency)
        shifts = _shifts(np.vstack([m[np.ix_(self.kept, self.kept)] for m in matrices]))
        self.across = np.eye(len(shifts)) - shifts @ shifts.T
        self.normal: np.ndarray | None = None

    def refresh(self, z: np.ndarray) -> bool:
        """Whether the state has more cells where the scene stands at z, (n,); they are part of it from then on."""
        if not self.map.find(z):
            return False
        self._phase()
        return True

    # -- the map over a period ---------------------------------------------------------------------------------------
    def period(self, p: np.ndarray) -> float:
        """Of the forcing, times the multiple, s; of given periods."""
        if self.forcing.period:
            return self.forcing.period * self.multiple
        value = p[0] if self.parameter == self.forcing.frequency else self.map.block.value(self.forcing.frequency)
        assert self._rate is not None
        if not value > 0.0:
            raise StepFailed(self.scene.name, 0.0, f"a frequency of {value:g}", "")
        return self._rate / value * self.multiple

    def steps_of(self, period: float) -> int:
        """Macro steps in a period, s: none longer than the scene's, whole common periods of units with rates of their own."""
        parts = self._every * self.multiple
        shortest = max(period / self.scene.master.step * (1.0 - ROOM), self._steps * self.multiple)
        return max(ceil(shortest / parts), 1) * parts

    def split(self, unknown: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
        """State (n,), period in s, parameter (0 or 1,) of the unknown."""
        n = int(self.kept.sum())
        z = self.base.copy()
        z[self.kept] = unknown[:n]
        p = unknown[len(unknown) - 1 :] if self.parameter else np.zeros(0)
        return z, float(unknown[n]) if self.unknown_period else self.period(p), p

    def image(self, unknown: np.ndarray) -> tuple[Image, np.ndarray]:
        """Behind a period, with the derivative of the state by the period, (n,)."""
        z, period, p = self.split(unknown)
        if not period > 0.0:
            raise StepFailed(self.scene.name, 0.0, f"a period of {period:g} s", "")
        h, by_period = period / self.steps, np.zeros(z.size)
        if moves := self.unknown_period or (self.parameter and self.parameter == self.forcing.frequency):
            self.map.begin(p, h * (1.0 - BACK), self.steps)
            before = self.map.run(z)
        self.map.begin(p, h, self.steps)
        image = self.map(z)
        if moves:
            by_period = (image.z - before) / (BACK * period)
        return image, by_period

    def equations(self, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residual (m,) and matrix (m, m) or, with a parameter, (m, m + 1)."""
        z, period, p = self.split(unknown)
        image, by_period = self.image(unknown)
        n, kept = self.map.cells.size, self.kept
        residual = image.z - z
        wound = TURN * np.round(residual / TURN)
        if self.turning is not None:
            way = np.sign(residual[self.turning]) or 1.0
            wound[self.turning] = way * TURN * self.multiple / self.forcing.turns
        residual = (residual - np.where(self.angles, wound, 0.0))[kept]
        matrix = (image.by_state[:n] - np.eye(n))[np.ix_(kept, kept)]
        along = np.eye(len(residual)) - self.across
        residual = self.across @ residual + along @ (unknown[: residual.size] - self.pinned)
        matrix = self.across @ matrix + along
        self.derivative, self.along = (
            self.across @ image.by_state[:n][np.ix_(kept, kept)] @ self.across,
            self.across @ by_period[kept],
        )
        if self.unknown_period:
            normal = self._normal()
            residual = np.append(residual, normal @ (unknown[: normal.size] - self.pinned))
            matrix = np.block([[matrix, self.along[:, None]], [normal[None, :], np.zeros((1, 1))]])
        if self.parameter:
            column = self.across @ image.by_parameters[:n, 0][kept]
            if self.forcing.frequency == self.parameter:
                column = column - self.along * period / p[0]
            matrix = np.column_stack([matrix, np.append(column, 0.0) if self.unknown_period else column])
        return residual, matrix

    def _normal(self) -> np.ndarray:
        """Of the surface in which the orbit begins: an angle's, or across the motion where it was last."""
        if self.turning is not None:
            return np.asarray((np.flatnonzero(self.kept) == self.turning).astype(float))
        assert self.normal is not None
        return self.normal

    def multipliers(self) -> np.ndarray:
        """Eigenvalues of the last derivative, without that along the motion where the period is unknown, the largest first."""
        values = np.linalg.eigvals(self._across_motion())
        values = values[np.argsort(-np.abs(values), kind="stable")]
        return values[: values.size - self.unknown_period - round(values.size - np.trace(self.across))]

    def _across_motion(self) -> np.ndarray:
        """The last derivative, without what goes along the motion where the period is unknown."""
        matrix = self.derivative
        if self.unknown_period:
            normal = self._normal()
            across = normal @ self.along
            matrix = matrix - np.outer(self.along, normal @ matrix) / across if across else matrix
        return matrix

    def _refused(self, rows: np.ndarray, multipliers: np.ndarray) -> str:
        """Why an orbit with these rows (steps, S), behind which the scene stands, is none that stands alone; "" if it is."""
        change = self._rows_on() - rows
        largest = np.abs(multipliers).max(initial=1.0)
        if (np.ptp(change, axis=0) > REPEATS * largest * np.ptp(rows, axis=0) + ACTS).any():
            return "its second period is not its first: a mode, such as sticking, is another at its end than at its start"
        if np.abs(multipliers - 1.0).min(initial=1.0) < NEUTRAL:
            values, left = np.linalg.eig(self._across_motion().T)  # what keeps its value, such as a momentum
            cell = np.flatnonzero(self.kept)[np.abs(left[:, np.abs(values - 1.0).argmin()]).argmax()]
            what = "orbits lie side by side at one value, or a joint sticks all the time"
            return f"nothing restores {self.map.names()[cell]} (a multiplier of 1): {what}"
        return ""

    # -- finding one -------------------------------------------------------------------------------------------------
    def start(self, value: float | None, periods: int, guess: float = 0.0) -> np.ndarray:
        """An unknown to search from at a value of the parameter: the scene's start, and so many periods on; raises `StepFailed`.

        guess: of the period, s, of a free oscillation.
        """
        p = np.array([value]) if self.parameter else np.zeros(0)
        self.map.begin(p, self.scene.master.step, 1)
        self.map.stand()
        self.base = self.map.z
        if self.unknown_period:
            ahead = self.map.run(self.base)
            if self.turning is not None:
                guess = TURN * self.multiple / self.forcing.turns * self.map.block.h / abs((ahead - self.base)[self.turning])
            elif not guess:
                guess = self._crossing_period(periods)
        period = guess if self.unknown_period else self.period(p)
        self.steps = self.steps_of(period)
        self.map.begin(p, period / self.steps, self.steps)
        begun = self.map.run(self.base, 0)
        z = self.map.run(begun, self.steps * periods) if periods else begun
        self.map.hold()
        z = np.where(self.angles, begun, z)
        if self.refresh(z):
            return self.start(value, periods, guess)
        self.base = z
        self._pin(z, p)
        return np.concatenate([z[self.kept], [period] if self.unknown_period else [], p])

    def near(self, unknown: np.ndarray) -> None:
        """Orbits are sought next to an unknown from now on, by as many macro steps as its period asks for."""
        self.base, self.pinned = self.split(unknown)[0], unknown[: int(self.kept.sum())].copy()
        self.steps = self.steps_of(float(unknown[-2]) if self.unknown_period else self.period(unknown[-1:]))

    def _pin(self, z: np.ndarray, p: np.ndarray) -> None:
        self.pinned = z[self.kept].copy()
        if self.unknown_period and self.turning is None:
            flow = (self.map.run(z, 1) - z)[self.kept]
            size = np.maximum(np.abs(self.pinned), np.abs(flow)) + 1e-12
            self.normal = flow / size**2
            self.normal /= np.linalg.norm(self.normal * size)

    def _crossing_period(self, periods: int) -> float:
        """Of a free oscillation, s: mean distance of the times at which its most moving state passes its mean, at the end of a run."""
        h, count = self.map.block.h, round((self.scene.stop_time - self.scene.start_time) / self.scene.master.step)
        self.map.stand()
        states = np.empty((count, self.map.cells.size))
        for k in range(count):
            self.map.block.advance(1)
            states[k] = self.map.z
        late = states[count // 2 :, self.kept]
        late = late - late.mean(axis=0)
        moving = late[:, np.argmax(np.ptp(late, axis=0) / (np.abs(states[count // 2 :, self.kept]).max(axis=0) + 1e-300))]
        up = np.flatnonzero((moving[:-1] < 0.0) & (moving[1:] >= 0.0))
        if up.size < 2:
            raise BadInput(self.where, "a motion that does not come back before stop_time", "a period, an angle, or a longer run")
        return float((up[-1] - up[0]) / (up.size - 1) * h) * self.multiple

    def solve(self, unknown: np.ndarray) -> np.ndarray | None:
        """The orbit that Newton's method reaches, at the same parameter; None where it reaches none."""

        def square(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            residual, matrix = self.equations(np.append(x, unknown[-1:]) if self.parameter else x)
            return residual, matrix[:, : x.size]

        x = unknown[:-1] if self.parameter else unknown
        try:
            solution = newton(square, x)
        except StepFailed:
            return None
        if not (solution.left <= (INSIDE if solution.converged else 0.0)).all():  # where a joint sticks, no correction vanishes
            return None
        return np.append(solution.x, unknown[-1:]) if self.parameter else solution.x

    def orbit(self, unknown: np.ndarray) -> Orbit:
        """All of an orbit that was found."""
        z, period, p = self.split(unknown)
        self.equations(unknown)
        rows = self.rows(z)
        places = np.arange(self.multiple) * (self.steps // self.multiple)
        value = float(p[0]) if self.parameter else 0.0
        multipliers = self.multipliers()
        refused = self._refused(rows, multipliers)
        return Orbit(value, period, multipliers, rows.min(axis=0), rows.max(axis=0), rows[places], unknown.copy(), refused)

    def rows(self, z: np.ndarray) -> np.ndarray:
        """The recorded signals behind each macro step of a period, (steps, S), the last of them first."""
        self.map.stand(z)
        return self._rows_on()

    def _rows_on(self) -> np.ndarray:
        parts = [values[:, self._shown] for values, _ in self.map.block.rows(self.steps)]
        return np.roll(np.concatenate(parts), 1, axis=0)


def _shifts(rows: np.ndarray) -> np.ndarray:
    """Directions that rows (m, n) take to nothing, (n, k) with orthogonal columns, whatever the units of rows and columns are."""
    rows = rows[np.abs(rows).max(axis=1) > ACTS]
    scale = np.ones(rows.shape[1])
    for _ in range(3):
        rows = rows / np.abs(rows).max(axis=1, keepdims=True)
        size = np.maximum(np.abs(rows).max(axis=0, initial=0.0), ACTS)
        rows, scale = rows / size, scale / size
    _, values, vectors = np.linalg.svd(rows)
    return np.linalg.qr(scale[:, None] * vectors[int((values > SHIFT).sum()) :].T)[0]
