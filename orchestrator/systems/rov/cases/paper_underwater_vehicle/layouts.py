"""The two layouts that are compared, their limits, and the power of ideal thrusters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.rov.arrangement import eight_arrangement, wrench_matrix, y_arrangement

AXES = ("X", "Y", "Z", "K", "M", "N")
AHEAD, ASTERN = 51.44, 39.90  # N, T200 at 16 V, ends of the maker's sheet
MATRICES = {"six": wrench_matrix(*y_arrangement()), "eight": wrench_matrix(*eight_arrangement())}
SCENES = {"six": "rov-waves", "eight": "rov-waves-eight-thrusters"}
WATER_DENSITY, DIAMETER = 1025.0, 0.076  # kg/m3, m
IDEAL = 1.0 / math.sqrt(2.0 * WATER_DENSITY * math.pi / 4.0 * DIAMETER**2)  # W/N^1.5, momentum theory at rest


def ideal_power(thrusts: Any) -> Any:
    """Power of the jets, W: the sum of |F|^1.5 / sqrt(2 rho A) over the first axis of thrusts in N, (n, ...)."""
    return IDEAL * (np.abs(np.asarray(thrusts)) ** 1.5).sum(axis=0)
