"""How long a macro step may be: a mass that gets the force of a spring and damper through a master, in closed form.

The mass is moved exactly by a force whose course over a step is the polynomial of degree p through its samples at the last
p + 1 instants; the force follows from the motion within the instant (immediate), or is one step old (delayed). With
w = k H²/m, z = d H/m and the mean b(λ) and the mean weighted by the time left g(λ) of that polynomial, the motion goes like
λⁿ with

    (λ - 1)² + (λ - 1) (b z + g w) + b w = 0.

Held and immediate, that is λ² + (w/2 + z - 2) λ + 1 + w/2 - z: stable for H < min(2 d/k, 2 m/d), never without damping.
Gauss-Seidel has the same limit as Jacobi where feedthrough is immediate: a force that has no state of its own comes out the same,
whether it or the motion is extrapolated.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

# integrals of the Lagrange polynomials through s = 0, -1, -2 over 0..1, plain and weighted by 1 - s; newest sample first
MEANS = (
    ((Fraction(1),), (Fraction(1, 2),)),
    ((Fraction(3, 2), Fraction(-1, 2)), (Fraction(2, 3), Fraction(-1, 6))),
    ((Fraction(23, 12), Fraction(-4, 3), Fraction(5, 12)), (Fraction(19, 24), Fraction(-5, 12), Fraction(1, 8))),
)
SHORTEST_TRIED, LONGEST_TRIED = 3e-3, 1e2  # of the shortest time of the contact itself, between which a limit is looked for
GRID = 600
PARTS = 32  # of an interval in which the limit lies, looked at together
UNITY = 1.0 + 1e-12  # a root beyond it grows


def radii(w: np.ndarray, z: np.ndarray, degree: int, delay: int = 0) -> np.ndarray:
    """Largest |λ| of each (k,): what remains of a motion after one step. `delay`: 1 where the force is one step old, else 0."""
    b, g = (np.array([float(x) for x in terms]) for terms in MEANS[degree])
    polynomial = np.zeros((w.size, degree + delay + 3))
    polynomial[:, :3] = 1.0, -2.0, 1.0
    linear = b * z[:, None] + g * w[:, None]
    n = len(b)
    polynomial[:, 1 + delay : 1 + delay + n] += linear
    polynomial[:, 2 + delay : 2 + delay + n] += b * w[:, None] - linear
    m = polynomial.shape[1] - 1
    companion = np.zeros((w.size, m, m))  # of each polynomial, whose first coefficient is 1
    companion[:, 1:, :-1] = np.eye(m - 1)
    companion[:, 0] = -polynomial[:, 1:]
    return np.abs(np.linalg.eigvals(companion)).max(axis=1)


def longest_step(omega2: float, damping: float, degree: int, delay: int = 0) -> float:
    """The longest stable macro step, s; 0 where none is stable that could be used, infinity where none is unstable.

    omega2: stiffness over mass, 1/s². damping: damper over mass, 1/s. Where there is no closed form for the limit itself, steps
    are tried upwards, and the first that lets a motion grow is the limit; longer ones may be stable again.
    """
    if omega2 <= 0.0 and damping <= 0.0:
        return np.inf
    if degree == 0 and delay == 0:
        return min(2.0 * damping / omega2 if omega2 > 0.0 else np.inf, 2.0 / damping if damping > 0.0 else np.inf)
    scale = 1.0 / max(np.sqrt(max(omega2, 0.0)), damping)

    def grows(h: np.ndarray) -> np.ndarray:
        return radii(omega2 * h * h, damping * h, degree, delay) > UNITY

    steps = scale * np.geomspace(SHORTEST_TRIED, LONGEST_TRIED, GRID)
    unstable = grows(steps)
    if not unstable.any():
        return np.inf
    first = int(np.argmax(unstable))
    if first == 0:
        return 0.0
    low, high = steps[first - 1], steps[first]
    while high - low > 1e-9 * high:
        between = np.linspace(low, high, PARTS + 1)
        k = int(np.argmax(grows(between[1:])))  # the last of them grows
        low, high = between[k], between[k + 1]
    return float(low)
