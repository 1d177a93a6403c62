"""Coefficients of the generalised-alpha method, for components that integrate structures implicitly."""

from __future__ import annotations

from typing import NamedTuple

from .kernels import kernel, kernel_tuple


@kernel_tuple
class Method(NamedTuple):
    """Coefficients of the generalised-alpha method for one step length."""

    step: float  # s
    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float


@kernel
def generalized_alpha(step, spectral_radius):
    """`Method` for a step in s with a given damping of the highest frequencies (1: none, the midpoint rule), of second order.

    Source: Chung & Hulbert, J. Appl. Mech. 60 (1993) 371-375, eqs. (17), (18), (25).
    """
    alpha_m = (2.0 * spectral_radius - 1.0) / (spectral_radius + 1.0)
    alpha_f = spectral_radius / (spectral_radius + 1.0)
    return Method(step, alpha_m, alpha_f, 0.5 - alpha_m + alpha_f, 0.25 * (1.0 - alpha_m + alpha_f) ** 2)
