"""Points of the unit cube, and quantiles of distributions: all that is random comes from one seed."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ....components.core.errors import BadInput
from ...settings.plan import Distribution

SMALLEST = 2.0**-53  # of a probability: quantiles at 0 and 1 may be infinite


def unit_points(method: str, n: int, d: int, seed: int) -> np.ndarray:
    """(n, d) in (0, 1). The first points of "sobol" and "random" do not depend on n, so that more can be added; those of a Latin
    hypercube do. Sequences are SciPy's (`scipy.stats.qmc`), Sobol's scrambled."""
    from scipy.stats import qmc

    if method == "random":
        u = np.random.default_rng(seed).random((n, d))
    elif method == "latin-hypercube":
        u = qmc.LatinHypercube(d, seed=seed).random(n)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # n is no power of two: see `Points.remarks`
            u = qmc.Sobol(d, seed=seed).random(n)
    return np.clip(u, SMALLEST, 1.0 - SMALLEST, out=u)


def other_starts(starts: int, d: int, seed: int) -> list[np.ndarray]:
    """Where searches start besides the first one, (d,) each in (0, 1): a Latin hypercube."""
    return list(unit_points("latin-hypercube", starts - 1, d, seed)) if starts > 1 else []


def correlated(u: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (n, d) of the unit cube whose normal scores have the correlation `matrix` (d, d): a normal copula, by Cholesky.

    Raises `BadInput` for a matrix that no correlations have. A Latin hypercube keeps its strata in the first of two only.
    """
    from scipy.special import ndtr, ndtri

    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise BadInput("correlation", "correlations that contradict one another", "a positive definite matrix") from None
    return np.clip(ndtr(ndtri(u) @ lower.T), SMALLEST, 1.0 - SMALLEST)


def quantile(d: Distribution, u: np.ndarray) -> np.ndarray:
    """The numbers below which a share u (n,) of the distribution lies."""
    from scipy.special import ndtr, ndtri

    if d.shape == "uniform":
        return d.low + u * (d.high - d.low)
    if d.shape == "triangular":
        width, rise = d.high - d.low, d.mode - d.low
        return np.where(u * width < rise, d.low + np.sqrt(u * width * rise), d.high - np.sqrt((1.0 - u) * width * (width - rise)))
    below, above = ndtr((d.low - d.mean) / d.deviation), ndtr((d.high - d.mean) / d.deviation)
    if not below < above:
        raise BadInput("vary", f"a normal distribution cut off from {d.low:g} to {d.high:g}", "ends nearer to its mean")
    return np.clip(d.mean + d.deviation * ndtri(below + u * (above - below)), d.low, d.high)


def matrix_of(names: Sequence[str], pairs: Sequence[tuple[str, str, float]]) -> np.ndarray:
    """Correlation matrix of names from pairs."""
    matrix, place = np.eye(len(names)), {n: k for k, n in enumerate(names)}
    for first, second, r in pairs:
        matrix[place[first], place[second]] = matrix[place[second], place[first]] = r
    return matrix
