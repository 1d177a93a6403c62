"""Recurrence of states in phase space, and its quantification (RQA).

Definitions of Marwan, Romano, Thiel and Kurths, "Recurrence plots for the analysis of complex systems", Physics Reports 438
(2007) 237-329: R[i, j] = 1 where the states at the samples i and j are at most a threshold apart.

Written in NumPy because no library fits: PyRQA and pyunicorn are published as sources only, so they need a compiler at
installation, and besides that OpenCL (PyRQA) or igraph (pyunicorn). 1500 states take 0.03 s here, so nothing is compiled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....components.core.errors import BadInput

METRICS = {"euclidean": "euclidean", "maximum": "chebyshev"}
MOST = 10_000  # samples; the matrix holds the square of it in bytes, the distances eight times that


@dataclass(frozen=True)
class Quantification:
    """Measures of a recurrence matrix; lengths in samples. Shares lie between 0 and 1.

    What needs lines is NaN where there are none (mean_diagonal, trapping_time), `divergence` infinite.
    """

    rate: float  # RR: recurrent pairs over all pairs
    determinism: float  # DET: share of the recurrent points that lie on diagonal lines
    mean_diagonal: float  # L: a state's neighbours stay neighbours that long on the average
    longest_diagonal: int  # Lmax
    entropy: float  # ENTR: Shannon entropy of the lengths of diagonal lines, in nats
    laminarity: float  # LAM: share of the recurrent points that lie on vertical lines
    trapping_time: float  # TT: mean length of the vertical lines
    longest_vertical: int  # Vmax

    @property
    def divergence(self) -> float:
        """DIV, 1 / Lmax; related to the largest Lyapunov exponent, not equal to it."""
        return 1.0 / self.longest_diagonal if self.longest_diagonal else np.inf


def embed(x: np.ndarray, dimension: int, delay: int = 1) -> np.ndarray:
    """States (n - (dimension - 1) delay, dimension) of a signal (n,) by delay coordinates, oldest first; delay in samples."""
    if dimension < 1 or delay < 1 or x.size <= (dimension - 1) * delay:
        actual = f"{dimension} coordinates, {delay} samples apart, of {x.size} samples"
        raise BadInput("embedding", actual, "positive numbers that leave at least one state")
    n = x.size - (dimension - 1) * delay
    return np.stack([x[k * delay : k * delay + n] for k in range(dimension)], axis=1)


def standardised(states: np.ndarray) -> np.ndarray:
    """States (n, d) with every coordinate centred and divided by its standard deviation; a constant one becomes zero."""
    centred = states - states.mean(axis=0)
    spread = centred.std(axis=0)
    # A coordinate that only rounds is constant; blown up to size one it would drown the others.
    still = spread <= 1e-12 * np.abs(states).max(axis=0, initial=0.0)
    return np.where(still, 0.0, centred / np.where(still, 1.0, spread))


def recurrence_matrix(states: np.ndarray, threshold: float, metric: str = "euclidean") -> np.ndarray:
    """Whether two states (n, d) are at most `threshold` apart, (n, n) of bool; metric: "euclidean" or "maximum"."""
    if metric not in METRICS:
        raise BadInput("recurrence", f"metric {metric!r}", "one of " + ", ".join(METRICS))
    if not threshold > 0.0:
        raise BadInput("recurrence", f"threshold {threshold:g}", "a positive distance")
    if not 2 <= len(states) <= MOST or not np.isfinite(states).all():
        raise BadInput("recurrence", f"{len(states)} states", f"2 to {MOST} finite ones", "Take every k-th sample.")
    from scipy.spatial.distance import cdist

    return cdist(states, states, METRICS[metric]) <= threshold


def quantify(matrix: np.ndarray, shortest: int = 2, theiler: int = 1) -> Quantification:
    """The measures of a symmetric recurrence matrix (n, n).

    shortest: lines of fewer points count as single points, diagonal and vertical ones alike.
    theiler: pairs with |i - j| < theiler are no recurrences, but neighbours in time: they are left out of all measures, of the
        number of pairs the rate is related to as well, and they end lines. 1 leaves out the main diagonal only.
    """
    n = len(matrix)
    if matrix.shape != (n, n) or not np.array_equal(matrix, matrix.T):
        raise BadInput("recurrence", f"a matrix of shape {matrix.shape} that is not symmetric", "R[i, j] = R[j, i]")
    if shortest < 2 or not 1 <= theiler < n:
        actual = f"lines of at least {shortest}, Theiler window {theiler} of {n} samples"
        raise BadInput("recurrence", actual, "lines of two or more, and a window of at least one that leaves pairs")
    diagonal = run_lengths(_diagonals(matrix, theiler))
    vertical = run_lengths(np.triu(matrix, theiler) | np.tril(matrix, -theiler))
    lines, columns = diagonal[diagonal >= shortest], vertical[vertical >= shortest]
    points = int(diagonal.sum())  # of one triangle; the other has the same
    _, counts = np.unique(lines, return_counts=True)
    shares = counts / max(lines.size, 1)
    return Quantification(
        rate=2.0 * points / ((n - theiler) * (n - theiler + 1)),
        determinism=float(lines.sum() / points) if points else 0.0,
        mean_diagonal=float(lines.mean()) if lines.size else np.nan,
        longest_diagonal=int(lines.max(initial=0)),
        entropy=float(-(shares * np.log(shares)).sum()) if lines.size else 0.0,
        laminarity=float(columns.sum() / vertical.sum()) if points else 0.0,
        trapping_time=float(columns.mean()) if columns.size else np.nan,
        longest_vertical=int(columns.max(initial=0)),
    )


def _diagonals(matrix: np.ndarray, first: int) -> np.ndarray:
    """The diagonals j - i = first ... n - 1 of a matrix (n, n) as rows (n - first, n), filled up with False."""
    n = len(matrix)
    wide = np.zeros((n, 2 * n), dtype=bool)
    wide[:, :n] = matrix
    down, right = wide.strides
    return np.lib.stride_tricks.as_strided(wide[:, first:], (n - first, n), (right, down + right), writeable=False)


def run_lengths(rows: np.ndarray) -> np.ndarray:
    """Lengths of all uninterrupted runs of True within the rows of (m, n), row by row."""
    m, n = rows.shape
    fenced = np.zeros((m, n + 1), dtype=bool)  # a False after each row keeps runs from crossing into the next
    fenced[:, :n] = rows
    flat = fenced.ravel()
    edges = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    if flat[0]:
        edges = np.concatenate(([0], edges))
    return edges[1::2] - edges[::2]


def line_survival(matrix: np.ndarray, theiler: int = 1) -> np.ndarray:
    """Number of diagonal lines with at least l points, for l = 1 ... Lmax, (Lmax,), of one triangle.

    Falls as exp(-K2 l) with K2 the correlation entropy per sample, where lines are long and the threshold small.
    """
    counts = np.bincount(run_lengths(_diagonals(matrix, theiler)))
    return counts[:0:-1].cumsum()[::-1]
