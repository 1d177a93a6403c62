"""Distribution of a load over the balls of a rigid ring: Stribeck's number, Sjövall's integrals, and the discrete sums.

The ring is displaced radially, by delta_r, and along the shaft; a ball at psi from the load line carries

    Q(psi) = Q_max (1 - (1 - cos psi) / (2 epsilon))^1.5

where it is positive. epsilon is the share of the circumference that is loaded, projected: 1/2 without clearance and without
axial load, less with clearance, 1 and more if all balls carry. Equal contact angles are assumed. With many balls

    Fr = Z Q_max cos(alpha) Jr(epsilon),    Fa = Z Q_max sin(alpha) Ja(epsilon)

Sources: Stribeck (1901), Sjövall (1933), as in textbooks on rolling bearings.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.errors import BadInput

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def ball_share(psi: np.ndarray, epsilon: float) -> np.ndarray:
    """Load of balls at angles psi from the load line over that of a ball on it, same shape."""
    return np.maximum(1.0 - (1.0 - np.cos(psi)) / (2.0 * epsilon), 0.0) ** 1.5


def load_integrals(epsilon: float) -> tuple[float, float]:
    """Jr and Ja, the means over the circumference of the balls' shares with and without the factor cos(psi); epsilon > 0."""
    if not epsilon > 0.0:
        raise BadInput("load zone", f"epsilon = {epsilon:g}", "a number above 0")
    edge = math.acos(max(1.0 - 2.0 * epsilon, -1.0))
    # psi = edge sin(t): the integrand goes to zero at the edge with the power 1.5, which this turns into a smooth one
    t = 0.25 * math.pi * (NODES + 1.0)
    psi = edge * np.sin(t)
    share = ball_share(psi, epsilon) * edge * np.cos(t) * (0.25 * math.pi * WEIGHTS / math.pi)
    return float(share @ np.cos(psi)), float(share.sum())


def stribeck_number(epsilon: float = 0.5) -> float:
    """Z Q_max / Fr of a radial bearing with many balls, 1 / Jr; 4.37 without clearance."""
    return 1.0 / load_integrals(epsilon)[0]
