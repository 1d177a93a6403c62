"""Largest eigenvalues, of a small matrix or of a mass on damper and spring, and the step they allow an explicit method."""

from __future__ import annotations

import math

from .kernels import kernel

SQUARINGS = 24  # the matrix is raised to the power 2^24: the result is some 1e-6 too large at most


@kernel
def spectral_radius(A, B):
    """max |eigenvalue| of A (n, n), by squaring: |A^m|^(1/m) (Gelfand). B: (n, n) workspace; A is lost."""
    n = A.shape[0]
    exponent, power = 0.0, 1.0  # the matrix that A stands for is A e^exponent, and the power of the first one
    for _ in range(SQUARINGS):
        norm = 0.0
        for i in range(n):
            for j in range(n):
                norm = max(norm, abs(A[i, j]))
        if not norm > 0.0 or not math.isfinite(norm):
            return norm
        for i in range(n):
            for j in range(n):
                A[i, j] /= norm
        exponent += math.log(norm)
        for i in range(n):
            for j in range(n):
                B[i, j] = 0.0
            for k in range(n):
                factor = A[i, k]
                if factor != 0.0:
                    for j in range(n):
                        B[i, j] += factor * A[k, j]
        for i in range(n):
            for j in range(n):
                A[i, j] = B[i, j]
        exponent, power = 2.0 * exponent, 2.0 * power
    norm = 0.0
    for i in range(n):
        for j in range(n):
            norm = max(norm, abs(A[i, j]))
    return math.exp((exponent + math.log(norm)) / power) if norm > 0.0 else 0.0


@kernel
def step_within(radius, largest):
    """Longest step, s, for a method's stability radius and the largest |eigenvalue|, 1/s; infinite where nothing moves."""
    return radius / largest if largest > 0.0 else math.inf


@kernel
def fastest_rate(mass, damping, stiffness):
    """max |z| of mass z² + damping z + stiffness = 0, 1/s; mass > 0, the others not negative."""
    half = 0.5 * damping
    discriminant = half * half - mass * stiffness
    if discriminant < 0.0:
        return math.sqrt(stiffness / mass)
    return (half + math.sqrt(discriminant)) / mass
