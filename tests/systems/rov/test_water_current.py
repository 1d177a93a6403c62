"""The current of the water: its parts in closed form, and an acceleration that is the velocity's derivative."""

import math

import numpy as np
import pytest
from cosimo.components.rov.current import WaterCurrent

pytestmark = pytest.mark.interpreted

WAYS = ("north", "east", "down")
EVERYTHING = WaterCurrent(
    ("tide", "ramp", "gust"),
    {
        "direction": 0.7,
        "downwelling": -0.1,
        "tide.period": 60.0,
        "tide.phase": 0.4,
        "tide.direction": -2.0,
        "ramp.start_time": 3.0,
        "gust.direction": 1.2,
        "gust.amplitude": -0.3,
    },
)


def at(current: WaterCurrent, t: float) -> np.ndarray:
    """Velocity and acceleration, (2, 3)."""
    current.initialize(t)
    return np.array([[current[f"{what}_{way}"] for way in WAYS] for what in ("velocity", "acceleration")])


def test_the_mean_sets_in_its_direction():
    velocity, acceleration = at(WaterCurrent(parameters={"speed": 0.5, "direction": math.pi / 6, "downwelling": 0.1}), 7.0)
    np.testing.assert_allclose(velocity, [0.5 * math.sqrt(0.75), 0.25, 0.1], rtol=1e-14)
    assert not acceleration.any()


@pytest.mark.known_answers(WaterCurrent="ramp")
@pytest.mark.parametrize("t", [0.5, 3.0, 3.01, 8.0, 12.9, 13.0, 11.3, 14.99, 15.0, 20.0])
def test_acceleration_is_the_derivative_of_the_velocity(t):
    h = 1e-4
    slope = (at(EVERYTHING, t + h)[0] - at(EVERYTHING, t - h)[0]) / (2.0 * h)
    # h times the jump of the jerk, at most 0.24 m/s³ where a gust begins, and rounding of 1e-12
    np.testing.assert_allclose(at(EVERYTHING, t)[1], slope, atol=0.3 * h)


@pytest.mark.known_answers(WaterCurrent=("tide", "gust"))
def test_a_gust_and_a_tide_peak_where_they_should():
    gust = WaterCurrent(("gust",), {"speed": 0.0, "gust.direction": math.pi / 2})
    np.testing.assert_allclose(at(gust, 12.5), [[0.0, 0.2, 0.0], [0.0, 0.0, 0.0]], atol=1e-16)
    assert not at(gust, 10.0).any()
    np.testing.assert_allclose(at(gust, 40.0), 0.0, atol=1e-16)
    tide = WaterCurrent(("tide",), {"speed": 0.0, "tide.period": 80.0})
    np.testing.assert_allclose(at(tide, 20.0), [[0.2, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-16)
    np.testing.assert_allclose(at(tide, 40.0)[1], [-0.2 * math.pi / 40.0, 0.0, 0.0], rtol=1e-12)


def test_steps_lead_where_a_start_at_their_end_does():
    current = EVERYTHING
    current.initialize(0.0)
    for k in range(40):
        current.step(0.37 * k, 0.37)
    reached = current.y.copy()
    current.initialize(40 * 0.37)
    np.testing.assert_allclose(reached, current.y, atol=1e-14)
