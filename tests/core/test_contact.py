"""Elastic stops: torque and depth on both sides, no pull, work over a stroke."""

import numpy as np
import pytest
from cosimo.components.core.contact import stop_depth, stop_torque

STOP = (-0.2, 0.5, 100.0, 0.3)  # lower, upper, stiffness, dissipation


@pytest.mark.parametrize(
    ("angle", "rate", "torque"),
    [
        (0.1, 5.0, 0.0),
        (0.5, 5.0, 0.0),
        (0.6, 0.0, -10.0),
        (-0.3, 0.0, 10.0),
        (0.6, 2.0, -16.0),
        (0.6, -2.0, -4.0),
        (-0.3, -2.0, 16.0),
        (-0.3, 2.0, 4.0),  # more into a stop than out of it
        (0.6, -4.0, 0.0),
        (-0.3, 4.0, 0.0),  # never pulling
    ],
)
def test_torque_of_a_stop(angle, rate, torque):
    assert stop_torque(angle, rate, *STOP) == pytest.approx(torque, abs=1e-12)


def test_depth_is_what_the_torque_is_of():
    for angle in (-0.35, -0.2, 0.0, 0.5, 0.75):
        assert abs(stop_torque(angle, 0.0, *STOP)) == pytest.approx(100.0 * stop_depth(angle, -0.2, 0.5), abs=1e-12)


def test_a_stroke_at_constant_rate_loses_work_in_proportion_to_it():
    """In and out at the rate v to the depth d: the work lost is 2 * k d² / 2 * (dissipation v)."""
    depths, v, d = np.linspace(0.0, 0.1, 1001), 0.5, 0.1
    way_in = -np.trapezoid([stop_torque(0.5 + s, v, *STOP) for s in depths], depths)
    way_out = -np.trapezoid([stop_torque(0.5 + s, -v, *STOP) for s in depths], depths)
    assert way_in - way_out == pytest.approx(100.0 * d**2 * 0.3 * v, rel=1e-9)
