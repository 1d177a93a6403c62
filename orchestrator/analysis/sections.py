"""Sections of a motion: its signals each time an angle has advanced by the same amount (stroboscopic, Poincaré)."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from components.core.errors import BadInput


def section(angle: np.ndarray, spacing: float, *signals: np.ndarray) -> list[np.ndarray]:
    """Each signal (n,) where the angle (n,), rad and possibly wrapped, passes multiples of `spacing` rad, (k,).

    Between samples by cubic splines over the angle: the speed may vary, its sign may not.
    """
    turned = np.unwrap(angle)
    if turned.size and turned[-1] < turned[0]:
        turned = -turned
    if turned.size < 4 or not (np.diff(turned) > 0.0).all():
        raise BadInput("section", "an angle that stands or turns back", "one that always turns the same way",
                       "Leave out the part of the run in which it does not.")
    if np.diff(turned).max() > 0.5 * np.pi:
        came = f"steps of {np.diff(turned).max():.2g} rad"
        raise BadInput("section", came, "four samples a turn or more", "Record more often.")
    at = spacing * np.arange(np.ceil(turned[0] / spacing), np.floor(turned[-1] / spacing) + 1)
    return [CubicSpline(turned, s)(at) for s in signals]
