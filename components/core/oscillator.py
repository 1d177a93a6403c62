"""Eigenvalues of a mass on a damper and a spring, in kernels: what limits the step of an explicit method."""

from __future__ import annotations

import math

from .kernels import kernel


@kernel
def fastest_rate(mass, damping, stiffness):
    """max |z| of mass z² + damping z + stiffness = 0, 1/s; mass > 0, the others not negative."""
    half = 0.5 * damping
    discriminant = half * half - mass * stiffness
    if discriminant < 0.0:
        return math.sqrt(stiffness / mass)
    return (half + math.sqrt(discriminant)) / mass
