"""Radiation as a conductance that depends on both temperatures."""

from __future__ import annotations

from ..core.kernels import kernel

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m2.K4), CODATA 2018


@kernel
def radiative_coefficient(one, other):
    """sigma (T1⁴ - T2⁴) / (T1 - T2) for temperatures in K, W/(m2.K); exact, and 4 sigma T³ where they are equal.

    Below 0 K, where only extrapolated inputs lead, a temperature counts as 0: the coefficient is never negative.
    """
    one, other = max(one, 0.0), max(other, 0.0)
    return STEFAN_BOLTZMANN * (one * one + other * other) * (one + other)
