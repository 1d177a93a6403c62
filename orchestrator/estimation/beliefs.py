"""Three ways to carry a belief over a step of a scene: by exact derivatives, by points, by an ensemble.

Each has columns T of the live cells, and of the numbers q of the unknowns, which `update` changes alike.
"""

from __future__ import annotations

import numpy as np

from .model import Model


class Extended:
    """Columns by the derivatives of the coupled step (extended Kalman filter).

    The scene stands at the mean. Where `model.held` says where constants are linearised, it stands where constants are these, and all
    else is as the measurements say if they are; the mean of the constants is carried beside by derivatives, as the columns are.

    sensitivities, q_sensitivities: (l, s) and (p, s) of the mean by suspected numbers, whose fixed cells move along `by` (f, s).
    """

    exact = True

    def __init__(self, model: Model, cells: np.ndarray | None = None, by: np.ndarray | None = None):
        """cells: of suspected numbers, and what follows from them, (f,), which move along by, (f, s)."""
        self.model = model
        model.begin()
        expected, self._q = np.array([u.mean for u in model.unknowns]), model.at.copy()
        model.follow(self._q)
        deviations = np.array([u.deviation for u in model.unknowns])
        slopes = np.array([u.bounds.slope(v) for u, v in zip(model.unknowns, self._q, strict=True)])
        moved, numbers = model.kicks(True, 0.0)
        along = model.prior(model.cells) * slopes
        self.T = np.hstack([along * deviations, moved])
        self.Tq = np.hstack([np.diag(deviations), numbers])
        self._held_rows = model.constants[:0] if model.held is None else model.constants
        self._off_q = expected - self._q
        self._off = along @ self._off_q
        self.forgets = np.array([model.block.h / u.memory for u in model.unknowns])
        cells = model.derived[:0] if cells is None else cells
        self._held = np.union1d(model.derived, cells)
        self._derived, self._suspected = np.searchsorted(self._held, model.derived), np.searchsorted(self._held, cells)
        count = 0 if by is None else by.shape[1]
        self._by, self.sensitivities = np.zeros((self._held.size, count)), np.zeros((model.live.size, count))
        self.q_sensitivities = np.zeros((len(model.unknowns), count))
        if by is not None:
            self._by[self._suspected] = by

    @property
    def live(self) -> np.ndarray:
        """The mean of the live cells, (l,)."""
        return self.model.block.cells[self.model.live] + self._off

    @property
    def q(self) -> np.ndarray:
        """The mean of the numbers of the unknowns, (p,)."""
        return self._q + self._off_q

    def put(self, cells: np.ndarray, numbers: np.ndarray) -> None:
        """Inputs that are known from here on, (n,)."""
        self.model.block.initial[cells] = self.model.block.cells[cells] = numbers

    def predict(self, dt: float) -> None:
        """Over a macro step, dt, s: columns of disturbances come behind those that there are."""
        moved, numbers = self.model.kicks(False, dt)
        self.T, self.Tq = np.hstack([self.T, moved]), np.hstack([self.Tq, numbers])
        self.carry()
        keeps = np.exp(-self.forgets)
        if (keeps < 1.0).any():
            start = np.array([u.mean for u in self.model.unknowns])
            self._q = np.where(keeps < 1.0, start + keeps * (self._q - start), self._q)
            self._off_q, self.Tq = keeps * self._off_q, self.Tq * keeps[:, None]
            self.q_sensitivities = self.q_sensitivities * keeps[:, None]
            self.model.follow(self._q)

    def carry(self) -> None:
        """A macro step on, without disturbances."""
        model, c = self.model, self.T.shape[1]
        off = self._off_q.any() or self._off.any()
        columns = [self.T, *([self._off[:, None]] if off else []), self.sensitivities]
        of_unknowns = np.hstack([self.Tq, *([self._off_q[:, None]] if off else []), self.q_sensitivities])
        held = np.zeros((self._held.size, of_unknowns.shape[1]))
        held[self._derived] = model.along @ of_unknowns
        if self._by.shape[1]:
            held[:, -self._by.shape[1] :] += self._by
        cells = np.concatenate([model.live, self._held])
        moved = model.propagate(cells, np.vstack([np.hstack(columns), held]))
        self.T, self.sensitivities = moved[:, :c], moved[:, c + off :]
        if off:
            self._off = moved[:, c]

    def doubt(self, w: np.ndarray) -> None:
        """How the coming `take` moves by suspected numbers, (c, s)."""
        self.sensitivities = self.sensitivities - self.T @ w
        self.q_sensitivities = self.q_sensitivities - self.Tq @ w

    def take(self, w: np.ndarray, W: np.ndarray) -> None:
        """What an update says: the mean moves by the columns times w, (c,), they become columns times W, (c, d)."""
        moved, moved_q = self._off + self.T @ w, self._off_q + self.Tq @ w
        self.T, self.Tq = self.T @ W, self.Tq @ W
        if not w.any():
            return
        rows, self._off, self._off_q = self._held_rows, np.zeros(moved.size), np.zeros(moved_q.size)
        if rows.size:  # what constants off their place bring along; the scene moves by the rest
            sizes = np.array([self.model.unknowns[k].deviation for k in rows])
            a = np.linalg.lstsq(self.Tq[rows] / sizes[:, None], moved_q[rows] / sizes, rcond=None)[0]
            self._off, self._off_q = self.T @ a, self.Tq @ a
            self._off_q[rows] = moved_q[rows]
        self.model.block.cells[self.model.live] += moved - self._off
        if (further := moved_q - self._off_q).any():
            self._q = self._q + further
            self.model.follow(self._q)


class Unscented(Extended):
    """Columns by points at either side of the mean, along each column (cubature rule: all points have equal weight).

    Half the difference of two opposite points is the column behind the step; their mean off that of all points is one more column.
    """

    exact = False

    def carry(self) -> None:
        model, block = self.model, self.model.block
        count, before = self.T.shape[1], block.save()
        block.seed()
        ends = np.empty((2, count, model.live.size))
        for side, way in enumerate((np.sqrt(count), -np.sqrt(count))):
            for k in range(count):
                block.restore(before)
                model.block.cells[model.live] += way * self.T[:, k]
                model.follow(self._q + way * self.Tq[:, k])
                block.advance(1)
                ends[side, k] = model.block.cells[model.live]
        block.restore(before)
        model.follow(self._q)
        block.advance(1)
        mean = ends.mean(axis=(0, 1)) if count else self.live
        model.block.cells[model.live] = mean
        odd, even = (ends[0] - ends[1]).T / 2.0, (ends[0] + ends[1] - 2.0 * mean).T / 2.0
        self.T = np.hstack([odd, even]) / np.sqrt(max(count, 1))
        self.Tq = np.hstack([self.Tq, np.zeros((self.Tq.shape[0], count))])


class Ensemble:
    """Members that run as the scene does, each with disturbances of its own; modes of sticking and counters are those of each member."""

    exact = False

    def __init__(self, model: Model, members: int, inflation: float, seed: int):
        self.model, self._rng, self._inflation = model, np.random.default_rng(seed), inflation
        first = Extended(model)
        a = self._rng.standard_normal((members, first.T.shape[1]))
        a = (a - a.mean(axis=0)) / np.maximum(a.std(axis=0, ddof=1), 1e-300)
        self._q = first.q + a @ first.Tq.T
        self._live = first.live + a @ first.T.T
        self._keeps = np.exp(-first.forgets)
        self._cells = np.repeat(model.block.cells[None], members, axis=0)
        self.sensitivities = np.zeros((model.live.size, 0))

    @property
    def q(self) -> np.ndarray:
        return self._q.mean(axis=0)

    @property
    def live(self) -> np.ndarray:
        return self._live.mean(axis=0)

    @property
    def T(self) -> np.ndarray:
        return (self._live - self.live).T / np.sqrt(len(self._live) - 1.0)

    @property
    def Tq(self) -> np.ndarray:
        return (self._q - self.q).T / np.sqrt(len(self._q) - 1.0)

    def put(self, cells: np.ndarray, numbers: np.ndarray) -> None:
        self.model.block.initial[cells] = self._cells[:, cells] = numbers

    def predict(self, dt: float) -> None:
        model, now = self.model, self.model.block.save()
        start = np.array([u.mean for u in model.unknowns])
        moved, numbers = model.kicks(False, dt)
        model.block.seed()
        for k, cells in enumerate(self._cells):
            model.block.restore(now._replace(cells=cells))
            model.block.cells[model.live] = self._live[k]
            kick = self._rng.standard_normal(moved.shape[1])
            model.block.cells[model.live] += moved @ kick
            model.follow(self._q[k] + numbers @ kick)
            model.block.advance(1)
            self._q[k] = start + self._keeps * (self._q[k] + numbers @ kick - start)
            self._live[k], cells[:] = model.block.cells[model.live], model.block.cells

    def take(self, w: np.ndarray, W: np.ndarray) -> None:
        scale = np.sqrt(len(self._live) - 1.0)
        inflation = self._inflation if w.any() else 1.0
        for values in (self._live, self._q):
            mean, A = values.mean(axis=0), values - values.mean(axis=0)
            values[:] = mean + (A.T @ w) / scale + W.T @ (A * inflation)


Belief = Extended | Unscented | Ensemble
