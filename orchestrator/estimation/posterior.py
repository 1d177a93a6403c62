"""What a record says of constants where nothing disturbs the scene: the run follows from them, so their likelihood is that of a run.

Friction that sticks and balls that roll through a clearance give the likelihood several maxima. Starts spread over what was expected, and
along what was found, climb to these by the derivatives of runs (Levenberg and Marquardt). Around each maximum stands a Student
distribution of the shape that the derivatives give it; numbers are drawn from the mixture and weighted by what a run says of them over
what the mixture does, and the mixture is fitted to them anew (adaptive multiple importance sampling: Cornuet, Marin, Mira, Robert 2012;
recalled). So bands are those of the likelihood itself, of all maxima that were found. Two numbers say when they are not: how far the
weights are from equal, and the weight of maxima that one start alone has found: about as much is still unseen (Good 1953; recalled).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import TypeVar

import numpy as np

from ...components.core.errors import StepFailed
from ..derivatives.tangent_run import tangent_run
from .beliefs import Belief
from .measurements import Measurements
from .model import Model, Unknown

T = TypeVar("T")
BATCH, MOST = 8, 32  # starts: so many at once, and at most
CLIMBS, SETTLED = 20, 0.03  # runs of a climb at most; the step, in deviations, that ends it
SAME = 1.0  # deviations between two ends of climbs that are one maximum
BELOW = 8.0  # log units below the best: a maximum that far down has no weight
DRAWN, ROUNDS, TAIL = 64, 4, 4.0  # numbers of a round; rounds; degrees of freedom of the Student distribution
PRIOR = 3.0  # draws that the shape of a maximum counts as, when the mixture is fitted anew
APART = 2.0 * 1.96  # deviations: two groups whose bands do not meet
EFFECTIVE = 50.0  # draws of equal weight that say as much: ends of bands are then known to 2 % of probability
MAY_NOT = "Bands may not hold"
UNSEEN, NAMED = 0.05, 0.05  # weight of maxima found once, and of a group that is named, from which on a remark says so


@dataclass(frozen=True)
class Maximum:
    """u: (p,) in deviations of what was expected.  value: log of likelihood and expectation.  starts: that ended there.

    covariance: by derivatives.
    """

    u: np.ndarray
    value: float
    covariance: np.ndarray
    starts: int = 1


@dataclass(frozen=True)
class Posterior:
    """Constants by a record, all as numbers q, (p,).

    at: the best maximum.  mean, covariance: of the group of draws around it.  low, high: of 95 %, of all groups.
    groups: (weight, mean) of each, those apart alone.  effective: number of draws.  unseen: weight of maxima found once.
    deviation: about the mean, of all groups.
    """

    at: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    deviation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    groups: tuple[tuple[float, np.ndarray], ...]
    effective: float
    unseen: float
    starts: int

    def columns(self, belief: Belief) -> tuple[np.ndarray, np.ndarray]:
        """Mean (c,) and covariance (c, c) of the columns of a filter at its end, which leave constants as they are known here."""
        inverse = np.linalg.pinv(belief.Tq)
        mean = inverse @ (self.mean - belief.q)
        return mean, np.eye(mean.size) - inverse @ belief.Tq + inverse @ self.covariance @ inverse.T

    def remarks(self, unknowns: Sequence[Unknown]) -> list[str]:
        """What is to be known of the bands."""
        texts = []
        named = [(weight, mean) for weight, mean in self.groups if weight >= NAMED]
        if len(named) > 1:
            each = []
            for weight, mean in named:
                values = (f"{u.name} = {u.bounds.outer(q):.4g} {u.unit}" for u, q in zip(unknowns, mean, strict=True))
                each.append(f"{' with '.join(values)} ({weight:.0%})")
            text = f"several values explain the measurement: {', or '.join(each)}"
            texts.append(f"{text}. States, figures and what was learnt over time are those of the first")
        if self.unseen > UNSEEN:
            text = (
                f"of {self.starts} starts one alone has found what has {self.unseen:.0%} of the weight: there may be other values"
            )
            texts.append(f"{text}. {MAY_NOT}")
        if self.effective < EFFECTIVE:
            texts.append(f"what was drawn of the constants says as much as {self.effective:.0f} draws. {MAY_NOT}")
        return texts

    def moved(self, by: np.ndarray) -> Posterior:
        """With all numbers so far on, (p,)."""
        groups = tuple((weight, mean + by) for weight, mean in self.groups)
        return replace(self, at=self.at + by, mean=self.mean + by, low=self.low + by, high=self.high + by, groups=groups)


class Runs:
    """The logarithm of likelihood and expectation by runs of a model without disturbances; `u` in deviations of what was expected.

    beside: the same for further threads.
    """

    beside: tuple[Runs, ...] = ()

    def __init__(self, model: Model, measured: Measurements, noise: np.ndarray, threads: int = 1):
        """noise: (k,) of the signals."""
        self.model, self._measured, self._noise = model, measured, noise[measured.which]
        self._block = model.block
        self.mean = np.array([u.mean for u in model.unknowns])
        self.deviation = np.array([u.deviation for u in model.unknowns])
        self._signals = np.array([model.signals.index(n) for n in measured.signals], dtype=np.intp)[measured.which]
        self.beside = tuple(self._another() for _ in range(1, threads))

    def _another(self) -> Runs:
        other = copy(self)
        other._block = self._block.another()
        return other

    def each(self, what: Callable[[Runs, np.ndarray], T], points: Iterable[np.ndarray]) -> list[T]:
        """What runs say of points, (p,) each, in their order, whichever thread it is that has run them."""
        free: SimpleQueue[Runs] = SimpleQueue()
        for one in (self, *self.beside):
            free.put(one)

        def work(u: np.ndarray) -> T:
            one = free.get()
            try:
                return what(one, u)
            finally:
                free.put(one)

        if not self.beside:
            return [work(u) for u in points]
        with ThreadPoolExecutor(1 + len(self.beside), "cosimo-constants") as executor:
            return list(executor.map(work, points))

    def __call__(self, u: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """(value, residuals over noise (n,), derivatives of the predictions over noise (n, p)); -inf where no run goes on."""
        model, p = self.model, u.size
        q = self.mean + self.deviation * u
        self._block.set({one.name: one.bounds.outer(v) for one, v in zip(model.unknowns, q, strict=True)})
        try:
            rows = tangent_run(self._block, [one.name for one in model.unknowns])
        except StepFailed:
            return -np.inf, np.zeros(0), np.zeros((0, p))
        time, k = self._measured.time, self._signals
        last = np.clip(np.searchsorted(rows.time, time), 1, rows.time.size - 1)
        share = (time - rows.time[last - 1]) / (rows.time[last] - rows.time[last - 1])
        predicted = (1.0 - share) * rows.values[last - 1, k] + share * rows.values[last, k]
        J = (1.0 - share)[:, None] * rows.tangents[last - 1, k] + share[:, None] * rows.tangents[last, k]
        slopes = np.array([one.bounds.slope(v) for one, v in zip(model.unknowns, q, strict=True)]) * self.deviation
        v, J = (self._measured.values - predicted) / self._noise, J * slopes / self._noise[:, None]
        value = -0.5 * float(v @ v + u @ u)
        return (value, v, J) if np.isfinite(value) and np.isfinite(J).all() else (-np.inf, v, np.zeros_like(J))

    def climb(self, u: np.ndarray) -> Maximum:
        """To a maximum from u."""
        value, v, J = self(u)
        damping = 0.0
        for _ in range(CLIMBS):
            H = J.T @ J + np.eye(u.size)
            step = np.linalg.solve(H + damping * np.diag(np.diag(H)), J.T @ v - u)
            small = float(step @ H @ step) < SETTLED**2
            after = self(u + step)
            if after[0] > value:
                u, (value, v, J), damping = u + step, after, damping / 10.0 if damping > 1e-3 else 0.0
            else:
                damping = max(10.0 * damping, 0.1)
            if small:
                break
        return Maximum(u, value, np.linalg.inv(J.T @ J + np.eye(u.size)))


def posterior(runs: Runs) -> Posterior:
    """Raises `StepFailed` where no start goes on."""
    maxima, starts = _maxima(runs)
    mixture = _Mixture(maxima)
    for _ in range(ROUNDS):
        mixture.draw(lambda points: runs.each(lambda one, u: one(u)[0], points))
    u, weights, shares = mixture.u, mixture.weights, mixture.shares()
    labels = _groups(mixture)
    of_groups = np.array([shares[labels == k].sum(axis=0) for k in range(labels.max() + 1)]) * weights
    order = np.argsort(-of_groups.sum(axis=1))
    means = [(float(w.sum()), w @ u / max(w.sum(), 1e-300)) for w in of_groups[order]]
    own, center = of_groups[order[0]] / means[0][0], means[0][1]
    first = max((m for m, label in zip(maxima, labels, strict=True) if label == order[0]), key=lambda m: m.value)
    covariance = (u - center).T * own @ (u - center)
    scale, mean = runs.deviation, runs.mean
    ends = np.array([_quantiles(u[:, k], weights) for k in range(u.shape[1])]) * scale[:, None] + mean[:, None]
    once = np.array([m.starts == 1 for m in maxima])
    return Posterior(
        mean + scale * first.u,
        mean + scale * center,
        covariance * np.outer(scale, scale),
        scale * np.sqrt(weights @ (u - center) ** 2),
        ends[:, 0],
        ends[:, 1],
        tuple((weight, mean + scale * at) for weight, at in means),
        1.0 / float(weights @ weights),
        float(shares[once].sum(axis=0) @ weights),
        starts,
    )


def _maxima(runs: Runs) -> tuple[list[Maximum], int]:
    """Those that have weight, from more and more starts, until each end of a climb was found twice; the number of starts.

    Starts are spread over what was expected and, every second batch, as the ends so far are: maxima often lie in one narrow valley, where
    several numbers give way to one another.
    """
    from scipy.stats import norm, qmc

    spread = norm.ppf(qmc.Sobol(runs.mean.size, scramble=True, seed=0).random(MOST))
    spread[0] = 0.0
    maxima: list[Maximum] = []
    ends: list[np.ndarray] = []
    for count in range(BATCH, MOST + 1, BATCH):
        starts, again = spread[count - BATCH : count], count % (2 * BATCH) == 0
        if again and len(ends) > runs.mean.size:
            root = np.linalg.cholesky(np.atleast_2d(np.cov(np.array(ends).T)) + SETTLED**4 * np.eye(runs.mean.size))
            starts = np.mean(ends, axis=0) + starts @ root.T
        for one in runs.each(lambda one, u: one.climb(u), starts):
            if one.value > -np.inf:
                ends.append(one.u)
                same = (k for k, m in enumerate(maxima) if (d := one.u - m.u) @ np.linalg.solve(m.covariance, d) < SAME**2)
                if (k := next(same, None)) is None:
                    maxima.append(one)
                else:
                    maxima[k] = replace(max(one, maxima[k], key=lambda m: m.value), starts=maxima[k].starts + 1)
        if maxima and all(m.starts > 1 for m in maxima) and (again or len(maxima) == 1):
            break
    if not maxima:
        scene = runs.model.scene
        raise StepFailed(scene.name, scene.start_time, "no run goes on with what is expected", "State smaller deviations")
    best = max(m.value for m in maxima)
    return [m for m in maxima if m.value > best - BELOW], count


def _laplace(maxima: Sequence[Maximum]) -> np.ndarray:
    """Weights by height and shape (Laplace), (m,)."""
    logs = np.array([m.value + 0.5 * np.linalg.slogdet(m.covariance)[1] for m in maxima])
    weights = np.exp(logs - logs.max())
    return weights / weights.sum()


class _Mixture:
    """Student distributions around maxima, and what was drawn from all that they have been: u (n, p), with weights (n,)."""

    def __init__(self, maxima: Sequence[Maximum]):
        self._rng = np.random.default_rng(0)
        self.means = [m.u for m in maxima]
        self.covariances = [m.covariance for m in maxima]
        self.share, self.u, self._values = _laplace(maxima), np.zeros((0, maxima[0].u.size)), np.zeros(0)
        self._before: list[tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]] = []

    def draw(self, values: Callable[[np.ndarray], list[float]]) -> None:
        """A round: draw, weigh, fit. values: of points, (n, p)."""
        count, p = len(self.means), self.means[0].size
        spread = 0.9 * self.share + 0.1 / count  # a maximum without weight is looked at, too
        self._before.append((spread, list(self.means), list(self.covariances)))
        roots = [np.linalg.cholesky(C) for C in self.covariances]
        of = self._rng.choice(count, size=DRAWN, p=spread)
        sizes = np.sqrt(self._rng.chisquare(TAIL, DRAWN) / TAIL)
        z = self._rng.standard_normal((DRAWN, p)) / sizes[:, None]
        new = np.array([self.means[k] + roots[k] @ one for k, one in zip(of, z, strict=True)])
        self.u = np.vstack([self.u, new])
        self._values = np.append(self._values, values(new))
        density = np.mean([share @ _densities(self.u, *shape) for share, *shape in self._before], axis=0)
        logs = self._values - np.log(density)
        self.weights = np.exp(logs - logs.max())
        self.weights /= self.weights.sum()
        self._fit(self.shares() * self.weights)

    def shares(self) -> np.ndarray:
        """Of each draw how much it belongs to each maximum, (m, n)."""
        parts = np.maximum(self.share, 1e-6)[:, None] * _densities(self.u, self.means, self.covariances)
        return parts / parts.sum(axis=0)

    def _fit(self, parts: np.ndarray) -> None:
        for k, w in enumerate(parts):
            if (total := float(w.sum())) > 0.0:
                own, effective = w / total, total**2 / float(w @ w)
                mean = own @ self.u
                covariance = (self.u - mean).T * own @ (self.u - mean)
                known = effective / (effective + PRIOR)
                self.means[k] = known * mean + (1.0 - known) * self.means[k]
                self.covariances[k] = known * covariance + (1.0 - known) * self.covariances[k]
        self.share = parts.sum(axis=1)


def _densities(u: np.ndarray, means: Sequence[np.ndarray], covariances: Sequence[np.ndarray]) -> np.ndarray:
    """Student distributions at u, (n, p): (m, n), but for a factor that all share."""
    p, rows = u.shape[1], []
    for mean, covariance in zip(means, covariances, strict=True):
        root = np.linalg.cholesky(covariance)
        z = np.linalg.solve(root, (u - mean).T)
        rows.append((1.0 + (z**2).sum(axis=0) / TAIL) ** (-0.5 * (TAIL + p)) / np.diag(root).prod())
    return np.array(rows)


def _groups(mixture: _Mixture) -> np.ndarray:
    """Of each maximum the group that it belongs to: bands of different groups do not meet."""
    from scipy.sparse.csgraph import connected_components

    count = len(mixture.means)
    meet = np.zeros((count, count), dtype=bool)
    for i in range(count):
        for j in range(count):
            d = mixture.means[i] - mixture.means[j]
            both = (mixture.covariances[i] + mixture.covariances[j]) / 2.0
            meet[i, j] = d @ np.linalg.solve(both, d) < APART**2
    return connected_components(meet)[1]


def _quantiles(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The ends of the 95 % in the middle, (2,): of n draws the k-th has k / (n + 1) below it in the mean (Weibull 1939; recalled)."""
    order, n = np.argsort(values), 1.0 / float(weights @ weights)
    below = (n * (np.cumsum(weights[order]) - 0.5 * weights[order]) + 0.5) / (n + 1.0)
    return np.interp([0.025, 0.975], below, values[order])
