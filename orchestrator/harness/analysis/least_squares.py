"""Nonlinear least squares within bounds, with the uncertainty of the fitted parameters, and those that the data do not determine.

    r(p) residuals over their standard deviations,  J = dr/dp at the fit,  C = s² (JᵀJ)⁻¹,  s² = |r|² / (m - n)

(Nonlinear regression, linearised at the fit: Bates and Watts, Nonlinear Regression Analysis, 1988, chapter 2; from memory.) Where
the standard deviations of the data are known, s = 1. With another loss ρ than squares, C = H⁻¹ (Σ ψ² jᵀj) H⁻¹, of the score ψ of each
residual and the Hessian H of the loss (Huber 1964; recalled). Identifiability is read off the singular values of J scaled by the
parameters' sizes, so that it does not depend on units of measure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....components.core.errors import BadInput

LARGEST_CONDITION = 1e6  # of the scaled Jacobian: beyond it a direction is known a million times worse than another
LARGEST_CORRELATION = 0.98  # of two fitted parameters that the data can hardly distinguish (our choice)
AT_BOUND = 1e-6  # of the range between the bounds
COVERAGE = 0.95  # of the intervals
FAILED = 1e3  # a residual of a run that fails, in deviations
TUNING = (
    1.345  # standard deviations: with normal noise, Huber's estimate has then 95 % of the efficiency of least squares (recalled)
)
PROFILED, PROFILES = 0.01, 12  # relative accuracy of the ends of a profile; fits for one end


@dataclass(frozen=True)
class Fit:
    """Fitted parameters, in the order of `names`, and how well the data determine them.

    values, deviations: (n,), the latter standard deviations, infinite where the data do not determine a parameter.
    covariance, correlation: (n, n).  intervals: (n, 2) at 95 %, by Student's t.
    residuals: (m,) at the fit.  variance: of them, 1 where the deviations of the data are known.  condition: of the scaled
    Jacobian.  messages: what a user should know.
    """

    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    covariance: np.ndarray
    correlation: np.ndarray
    intervals: np.ndarray
    residuals: np.ndarray
    variance: float
    condition: float
    evaluations: int
    converged: bool
    messages: tuple[str, ...]

    @property
    def rms(self) -> float:
        """Root mean square of the residuals; about 1 where they are over their true standard deviations."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def chi_square(self, other: Fit) -> float:
        """How much worse another fit is: difference of the sums of squares over the variance of the residuals."""
        return (float(other.residuals @ other.residuals) - float(self.residuals @ self.residuals)) / self.variance

    @property
    def largest_chi_square(self) -> float:
        """Below this `chi_square`, the data do not distinguish two fits at 95 %."""
        from scipy.stats import chi2

        return float(chi2.ppf(COVERAGE, len(self.names)))

    def rows(self) -> list[tuple[str, float, float, float, float]]:
        """(name, value, standard deviation, low, high) of every parameter."""
        return [
            (n, float(v), float(s), float(i[0]), float(i[1]))
            for n, v, s, i in zip(self.names, self.values, self.deviations, self.intervals, strict=True)
        ]


def fit(
    residuals: Callable[[np.ndarray], np.ndarray],
    start: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]],
    *,
    noise_known: bool = False,
    step: float | None = None,
    most: int | None = None,
    jacobian: Callable[[np.ndarray], np.ndarray] | None = None,
    loss: str = "linear",
) -> Fit:
    """Minimise the sum of squares of `residuals(p)`, (m,) with p (n,) in the order of `start`.

    `bounds`: (low, high) of every parameter; `noise_known`: the residuals are over the true standard deviations of the data.
    `step`: relative step of the differences, above the noise of the computed residuals (default: SciPy's 1.5e-8).
    `jacobian`: J(p), (m, n), in the place of differences. `most`: evaluations. `loss`: of SciPy, for known noise.
    Raises `BadInput` for fewer residuals than parameters, a start outside of its bounds, or residuals that are not finite at the start.
    """
    from scipy.optimize import least_squares

    names = tuple(start)
    low, high = (np.array([bounds[n][k] for n in names], dtype=float) for k in (0, 1))
    first = np.array([start[n] for n in names], dtype=float)
    for name, value, bottom, top in zip(names, first, low, high, strict=True):
        if not bottom <= value <= top or not bottom < top:
            raise BadInput(
                f"fit: {name}", f"start {value:g} with bounds {bottom:g} to {top:g}", "a start within bounds that differ"
            )
    at_start = np.asarray(residuals(first), dtype=float)
    if at_start.size < len(names):
        raise BadInput(
            "fit",
            f"{at_start.size} residuals for {len(names)} parameters",
            "at least as many residuals",
            "Give more data, or fit fewer parameters.",
        )
    if not np.isfinite(at_start).all():
        raise BadInput(
            "fit",
            "residuals that are not finite at the start",
            "a start where the model can be computed",
            "Give another start or narrower bounds.",
        )
    count = 0

    def counted(p: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        r = np.asarray(residuals(p), dtype=float)
        return np.where(np.isfinite(r), r, 1e3 * (1.0 + float(np.abs(at_start).max())))  # a failed run is a bad one, not the end

    more: dict[str, Any] = {"jac": jacobian} if jacobian is not None else {"diff_step": step}
    solution = least_squares(counted, first, bounds=(low, high), x_scale="jac", max_nfev=most, loss=loss, f_scale=TUNING, **more)
    judged = _judged(names, solution, low, high, noise_known, count)
    return judged if loss == "linear" else _of_scores(judged, solution, loss, counted, jacobian)


def _of_scores(
    judged: Fit,
    solution: Any,
    loss: str,
    residuals: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray] | None,
) -> Fit:
    """A fit with the covariance of another loss than squares."""
    from scipy.optimize import approx_fprime
    from scipy.stats import norm

    J = approx_fprime(solution.x, residuals) if jacobian is None else jacobian(solution.x)
    z = (solution.fun / TUNING) ** 2
    slope = {"soft_l1": (1.0 + z) ** -0.5, "huber": np.minimum(1.0, np.maximum(z, 1e-300) ** -0.5), "cauchy": 1.0 / (1.0 + z)}[
        loss
    ]
    score = J * (slope * solution.fun)[:, None]
    inverse = np.linalg.pinv(solution.jac.T @ solution.jac)
    covariance = np.where(np.isfinite(judged.covariance), inverse @ (score.T @ score) @ inverse, judged.covariance)
    deviations = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviations, deviations)
    reach = float(norm.ppf(0.5 + 0.5 * COVERAGE)) * deviations
    intervals = np.stack([judged.values - reach, judged.values + reach], axis=1)
    outside = int((z > 1.0).sum())
    text = f"{outside} of {z.size} residuals are beyond {TUNING} standard deviations, and count less; of normal noise 18 % are"
    return replace(
        judged,
        deviations=deviations,
        covariance=covariance,
        correlation=correlation,
        intervals=intervals,
        messages=(*judged.messages, text),
    )


def profile_end(
    best: Fit, residuals: Callable[[np.ndarray], np.ndarray], jacobian: Callable[[np.ndarray], np.ndarray], k: int, way: float
) -> tuple[float, str]:
    """One end of the 95 % interval of a parameter, all between 0 and 1, and what a user should know.

    It is where the least sum of squares with this parameter held has risen by the square of the quantile that an interval of the
    Jacobian reaches to, in variances of the residuals; 0 or 1 where it does not rise so far.
    """
    from scipy.optimize import least_squares
    from scipy.stats import norm, t

    n, p, least = best.values.size, best.values, float(best.residuals @ best.residuals)
    free = best.residuals.size - n
    reach = float(norm.ppf(0.5 + 0.5 * COVERAGE)) if best.variance == 1.0 else float(t.ppf(0.5 + 0.5 * COVERAGE, free))
    others, known = np.delete(np.arange(n), k), np.isfinite(best.deviations[k]) and best.deviations[k] > 0.0
    slope = best.covariance[others, k] / best.covariance[k, k] if known else np.zeros(n - 1)

    def whole(v: float, q: np.ndarray) -> np.ndarray:
        return np.insert(q, k, v)

    def held(v: float) -> float:
        """Root of the rise."""
        start = np.clip(p[others] + np.nan_to_num(slope) * (v - p[k]), 1e-9, 1.0 - 1e-9)
        if not n - 1:
            r = np.nan_to_num(residuals(whole(v, start)), nan=FAILED)
        else:
            solution = least_squares(
                lambda q: np.nan_to_num(residuals(whole(v, q)), nan=FAILED),
                start,
                jac=lambda q: jacobian(whole(v, q))[:, others],
                bounds=(0.0, 1.0),
                x_scale="jac",
            )
            r = solution.fun
        rise = (float(r @ r) - least) / best.variance
        if rise < -PROFILED:
            texts.append(f"a profile of {best.names[k]} has met a better fit: give more starts")
        return float(np.sqrt(max(rise, 0.0)))

    texts: list[str] = []
    bound = 0.0 if way < 0.0 else 1.0
    inside, height, v = p[k], 0.0, p[k] + way * (reach * best.deviations[k] if known else 1.0)
    outside = None  # the nearest place that is known to be beyond the end, and the root of the rise there
    for _ in range(PROFILES):
        v = min(max(v, 0.0), 1.0)
        root = held(v)
        if abs(root - reach) < PROFILED * reach or (v == bound and root < reach):
            break
        if root < reach:
            inside, height = v, root
        else:
            outside = v, root
        if outside is None:
            v = p[k] + (v - p[k]) * min(1.1 * reach / max(root, 1e-3), 4.0)
        else:
            share = (reach - height) / (outside[1] - height)
            v = inside + (outside[0] - inside) * min(max(share, 0.05), 0.95)
    else:
        texts.append(f"a profile of {best.names[k]} has not found its end: its interval is that of the last fit")
    if v == bound and root < reach:
        end = "lower" if way < 0.0 else "upper"
        texts.append(f"the data leave {best.names[k]} open up to its {end} bound, where its interval ends")
    return float(v), "; ".join(dict.fromkeys(texts))


def _judged(names: tuple[str, ...], solution: Any, low: np.ndarray, high: np.ndarray, noise_known: bool, count: int) -> Fit:
    from scipy.stats import norm, t

    p, r, m, n = solution.x, solution.fun, solution.fun.size, len(names)
    scale = np.where(p != 0.0, np.abs(p), np.where(np.isfinite(high - low), high - low, 1.0))
    _, sigma, basis = np.linalg.svd(solution.jac * scale, full_matrices=False)
    condition = float(sigma[0] / sigma[-1]) if sigma[-1] > 0.0 else float("inf")
    known = sigma > sigma[0] * max(m, n) * np.finfo(float).eps
    unknown = np.abs(basis[~known]).max(axis=0, initial=0.0) > 1e-3  # parameters that take part in what the data say nothing of
    inverse = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=known)
    factor = 1.0 if noise_known else float(r @ r) / (m - n) if m > n else float("inf")
    half = (basis.T * inverse) * scale[:, None]
    covariance = half @ half.T * factor if np.isfinite(factor) else np.full((n, n), np.inf)
    covariance[unknown, :] = covariance[:, unknown] = np.inf
    deviations = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviations, deviations)
    reach = float(norm.ppf(0.5 + 0.5 * COVERAGE)) if noise_known or m <= n else float(t.ppf(0.5 + 0.5 * COVERAGE, m - n))
    intervals = np.stack([p - reach * deviations, p + reach * deviations], axis=1)
    messages = [] if solution.success else [f"the search ended before it had converged: {solution.message}"]
    messages += _identifiability(names, basis, condition, correlation)
    if m == n and not noise_known:
        messages.append("as many parameters as residuals: the data leave nothing to estimate their uncertainty from")
    width = np.where(np.isfinite(high - low), high - low, np.inf)
    for name, value, bottom, top, near in zip(names, p, low, high, AT_BOUND * width, strict=True):
        if value - bottom <= near < np.inf or top - value <= near < np.inf:
            end = "lower" if value - bottom <= top - value else "upper"
            messages.append(f"{name} has stopped at its {end} bound: its uncertainty holds to one side at most")
    return Fit(
        names,
        p,
        deviations,
        covariance,
        correlation,
        intervals,
        r,
        factor,
        condition,
        count,
        bool(solution.success),
        tuple(messages),
    )


def _identifiability(names: Sequence[str], basis: np.ndarray, condition: float, correlation: np.ndarray) -> list[str]:
    """Which parameters the data do not determine, one by one or together."""
    texts = []
    if condition > LARGEST_CONDITION:
        weak = np.abs(basis[-1])
        part = ", ".join(names[k] for k in np.argsort(-weak) if weak[k] > 0.1)
        texts.append(f"the data do not identify {part}: condition number {condition:.2g}; fix one of them or add data")
    for i in range(len(names)):
        for j in range(i):
            if abs(correlation[i, j]) > LARGEST_CORRELATION:
                texts.append(f"{names[j]} and {names[i]} can hardly be told apart: correlation {correlation[i, j]:.4f}")
    return texts
