"""Complete elliptic integrals in kernels, by the arithmetic-geometric mean.

Source: Abramowitz & Stegun, Handbook of Mathematical Functions, 17.6.
"""

from __future__ import annotations

import math

from .kernels import kernel


@kernel
def complete_elliptic(m1):
    """(K, E) of the parameter m = 1 - m1, for 0 < m1 <= 1; m1 is given, for m close to 1 loses it."""
    a, b, total, weight = 1.0, math.sqrt(m1), 0.5 * (1.0 - m1), 0.5
    for _ in range(40):
        c = 0.5 * (a - b)
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        weight *= 2.0
        total += weight * c * c
        if not abs(c) > 1e-17 * a:
            break
    first = 0.5 * math.pi / a
    return first, first * (1.0 - total)
