"""A filter over all measurements of a scene, and the smoother behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...components.core.errors import StepFailed
from .beliefs import Belief, Ensemble
from .measurements import Measurements
from .model import Model
from .update import fewer, update

SAME = 1e-9  # of a step: two instants are one


@dataclass
class Track:
    """What a filter has found at each instant k of its steps, behind the measurements up to there.

    time: s.  values, columns: of the live rows that are kept, (n,) and (n, c).  q, q_columns: of the unknowns.
    back: (w, A, C) of the step to the next instant: a[k] = w + A b + noise of covariance C, with b that of the instant behind.
    end: mean and covariance of a at the last instant, where they are known otherwise than by the filter.
    """

    time: list[float] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)
    columns: list[np.ndarray] = field(default_factory=list)
    q: list[np.ndarray] = field(default_factory=list)
    q_columns: list[np.ndarray] = field(default_factory=list)
    back: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)
    end: tuple[np.ndarray, np.ndarray] | None = None

    def at_end(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean (c,) and covariance (c, c) of a at the last instant."""
        count = self.q_columns[-1].shape[1]
        return self.end or (np.zeros(count), np.eye(count))


@dataclass
class Innovations:
    """Of each measurement that was used, in order; sensitivities: how its normalised one moves by suspected numbers, (n, s).

    predicted, deviation: before it was used.  residual: what it is off the estimate behind it.  between: what the step leaves open
    between two instants, in units of the noise.
    """

    which: list[int] = field(default_factory=list)
    time: list[float] = field(default_factory=list)
    measured: list[float] = field(default_factory=list)
    predicted: list[float] = field(default_factory=list)
    deviation: list[float] = field(default_factory=list)
    normalised: list[float] = field(default_factory=list)
    residual: list[float] = field(default_factory=list)
    between: list[float] = field(default_factory=list)
    sensitivities: list[np.ndarray] = field(default_factory=list)
    log_likelihood: float = 0.0

    def forget(self, kept: int) -> None:
        """All but the last ones."""
        for name, values in vars(self).items():
            if name != "log_likelihood":
                del values[:-kept]


class Filter:
    """A belief that goes on from step to step of a scene and takes what was measured meanwhile."""

    def __init__(
        self,
        model: Model,
        belief: Belief,
        seen: Sequence[str],
        noise: np.ndarray,
        rows: np.ndarray,
        smooth: bool,
        most: int | None = None,
    ):
        """seen: measured signals, with noise (k,).  rows: of the live cells that the track keeps.  smooth: keep the way back.

        most: innovations that are kept, with the last instant of the track alone; None: all of both.
        """
        self.model, self.belief, self.noise, self.rows, self._smooth = model, belief, noise, rows, smooth
        self._most, self._waiting = most, [np.zeros(0), np.zeros(0, dtype=np.intp), np.zeros(0)]
        self._y = np.array([model.y_rows[model.signals.index(n)] for n in seen], dtype=np.intp)
        self._kept = np.unique(np.concatenate([model.state_rows, self._y]))
        self.dt = model.block.h
        self.track, self.innovations = Track(), Innovations()
        self._older = belief.live[self._y]
        self._note()

    def step(self, time: np.ndarray, which: np.ndarray, values: np.ndarray) -> None:
        """A macro step on, with the measurements, (m,), of the time behind the instant and up to the next one."""
        belief, y, start = self.belief, self._y, self.model.block.time
        before, first, first_sensitivity = belief.live[y], belief.T[y], belief.sensitivities[y]
        count = belief.T.shape[1]
        try:
            belief.predict(self.dt)
        except StepFailed as error:
            reason = "the scene cannot go on from what is estimated here"
            raise StepFailed(
                error.unit, start, reason, "State smaller deviations and walks, or leave out what the scene hardly sees"
            ) from error
        c = belief.T.shape[1]
        w, W = np.zeros(c), np.eye(c)
        if time.size:
            share = np.clip((time - start) / self.dt, 0.0, 1.0)
            after, k = belief.live[y], which
            first = np.hstack([first, np.zeros((y.size, c - count))])
            rows = (1.0 - share)[:, None] * first[k] + share[:, None] * belief.T[y][k]
            predicted = (1.0 - share) * before[k] + share * after[k]
            done = update(rows, values - predicted, self.noise[k])
            moves = (1.0 - share)[:, None] * first_sensitivity[k] + share[:, None] * belief.sensitivities[y][k]
            if (
                not isinstance(belief, Ensemble) and belief.sensitivities.shape[1]
            ):  # behind the numbers of the scene come offsets, then delays of the signals
                moves[:, -2 * y.size :] += np.hstack(
                    [np.eye(y.size)[k], np.eye(y.size)[k] * ((before - after) / self.dt)[k][:, None]]
                )
                belief.doubt(done.gain @ moves)
            w, W, i = done.w, done.W, self.innovations
            i.which += k.tolist()
            i.time += time.tolist()
            i.measured += values.tolist()
            i.predicted += predicted.tolist()
            i.deviation += np.sqrt((rows**2).sum(axis=1) + self.noise[k] ** 2).tolist()
            i.normalised += done.normalised.tolist()
            i.residual += (values - predicted - rows @ w).tolist()
            bend = np.abs(after - 2.0 * before + self._older)[k] / 2.0 * share * (1.0 - share)
            i.between += (bend / self.noise[k]).tolist()
            i.sensitivities += list(done.whiten @ moves)
            i.log_likelihood += done.log_density
        self._older = before
        Q = None
        if not isinstance(belief, Ensemble):
            Q = fewer(np.vstack([belief.T[self._kept] @ W, belief.Tq @ W]))
        kept = W if Q is None else W @ Q
        if self._smooth:
            A, whole = kept[:count], W[:count]
            self.track.back.append((w[:count], A, whole @ whole.T - A @ A.T if Q is not None else np.zeros((count, count))))
        if time.size or Q is not None:
            belief.take(w, kept)
        self._note()

    def _note(self) -> None:
        track, belief = self.track, self.belief
        if self._most is not None:
            self.track = track = Track()
            self.innovations.forget(self._most)
        track.time.append(self.model.block.time)
        track.values.append(belief.live[self.rows])
        track.columns.append(belief.T[self.rows] if self._smooth else np.sqrt((belief.T[self.rows] ** 2).sum(axis=1))[:, None])
        track.q.append(belief.q.copy())
        track.q_columns.append(belief.Tq.copy())

    def assimilate(self, horizon: float, time: np.ndarray, which: np.ndarray, values: np.ndarray) -> None:
        """Take measurements, (m,), and go on over all macro steps that end at a horizon, s, or before it.

        All that was measured up to there has come; what was measured behind the last of these steps waits.
        """
        given = (time, which, values) if not self._waiting[0].size else map(np.append, self._waiting, (time, which, values))
        time, which, values = given
        tolerance = SAME * self.dt
        while (end := self.model.block.time + self.dt) <= horizon + tolerance:
            now = time <= end + tolerance
            order = np.argsort(time[now], kind="stable")
            self.step(time[now][order], which[now][order], values[now][order])
            time, which, values = time[~now], which[~now], values[~now]
        self._waiting = [time, which, values]

    def run(self, measured: Measurements) -> None:
        """All measurements behind the present instant, one after the other as they have come, and on to the end of the last step."""
        time, tolerance = measured.time, SAME * self.dt
        ends = [*(np.flatnonzero(np.diff(time) > tolerance) + 1), time.size]
        for first, last in pairwise([0, *ends]):
            self.assimilate(time[last - 1], time[first:last], measured.which[first:last], measured.values[first:last])
        if self._waiting[0].size:
            self.assimilate(self.model.block.time + self.dt, time[:0], measured.which[:0], measured.values[:0])


@dataclass(frozen=True)
class History:
    """Means and standard deviations over time, (k,) s: of kept rows (k, n), and of the numbers q of the unknowns (k, p)."""

    time: np.ndarray
    values: np.ndarray
    deviations: np.ndarray
    q: np.ndarray
    q_deviations: np.ndarray


def history(track: Track, smooth: bool) -> History:
    """Of a track, by the measurements up to each instant, or by all of them.

    The smoother (Rauch, Tung, Striebel) goes back over what each column was made of; no covariance is inverted.
    """
    values, deviations, q, q_deviations = [], [], [], []
    beta, gamma = track.at_end()
    for k in range(len(track.time) - 1, -1, -1):
        T, Tq = track.columns[k], track.q_columns[k]
        if smooth and k < len(track.back):
            w, A, C = track.back[k]
            beta, gamma = w + A @ beta, C + A @ gamma @ A.T
        if not smooth:
            beta, gamma = np.zeros(Tq.shape[1]), np.eye(Tq.shape[1])
        own = (beta, gamma) if T.shape[1] == beta.size else (np.zeros(T.shape[1]), np.eye(T.shape[1]))
        values.append(track.values[k] + T @ own[0])
        deviations.append(np.sqrt(np.maximum(((T @ own[1]) * T).sum(axis=1), 0.0)))
        q.append(track.q[k] + Tq @ beta)
        q_deviations.append(np.sqrt(np.maximum(((Tq @ gamma) * Tq).sum(axis=1), 0.0)))
    parts = (np.array(one[::-1]) for one in (values, deviations, q, q_deviations))
    return History(np.array(track.time), *parts)
