"""Water under waves: what a linear wave is by its equations, and a sea by its spectrum."""

import math

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.components.rov.current import WaterCurrent
from cosimo.components.rov.waves import AMPLITUDE, FREQUENCY, GRAVITY, NUMBER, jonswap, wave_number
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

STILL = {"speed": 0.0}
SLANTING = {"waves.height": 0.8, "waves.period": 5.0, "waves.direction": 0.6, "waves.phase": 0.3, "waves.water_depth": 7.0}
PLACE = np.array([1.3, -2.1, 2.5])  # m: north, east, depth


def at(current: WaterCurrent, place: np.ndarray, t: float = 0.0) -> np.ndarray:
    """Velocity and acceleration, (2, 3), at a place and a time."""
    for name, value in zip(("position_north", "position_east", "depth"), place, strict=True):
        current.set(f"waves.{name}", float(value))
    current.t = t
    current.refresh()
    return current.y[:6].reshape(2, 3).copy()


def waves(*, mean: float = 0.0, **parameters: float) -> WaterCurrent:
    """Waves that slant, on a current along them."""
    flow = {"speed": abs(mean), "direction": SLANTING["waves.direction"] + (math.pi if mean < 0.0 else 0.0)}
    return initialized(WaterCurrent(("waves",), flow | SLANTING | {f"waves.{n}": v for n, v in parameters.items()}))


def components(current: WaterCurrent) -> np.ndarray:
    """What the sea consists of, (5, n)."""
    s = current.arguments[0]
    return s.sea[:, : s.taken[0]]


@pytest.mark.parametrize("kh", [1e-3, 0.1, 1.0, 3.0, 50.0])
def test_wave_numbers_satisfy_the_dispersion_relation_in_any_depth(kh):
    depth = 4.0
    frequency = math.sqrt(GRAVITY * kh / depth * math.tanh(kh))
    assert wave_number(frequency, depth, 0.0) == pytest.approx(kh / depth, rel=1e-13)


def test_wave_numbers_in_ten_metres_of_water():
    """Another solver's: periods of 4, 6 and 8 s."""
    numbers = [wave_number(2.0 * math.pi / period, 10.0, 0.0) for period in (4.0, 6.0, 8.0)]
    np.testing.assert_allclose(numbers, [0.2546, 0.1298, 0.0886], rtol=5e-4)


@pytest.mark.known_answers(WaterCurrent="waves")
@pytest.mark.parametrize("parameters", [{}, {"water_depth": 500.0}, {"period": 12.0}])
@pytest.mark.parametrize("mean", [0.0, 0.7, -0.3])
def test_the_flow_has_a_potential_and_keeps_volume_bottom_and_surface(parameters, mean):
    """Laplace's equation: no divergence, no curl, what the bottom and the surface ask for, and Newton for the water itself.

    What holds at the surface is of first order, so that the wave is low.
    """
    current, step = waves(**{"height": 1e-4} | parameters, mean=mean), 1e-4
    h = current.parameters["waves.water_depth"]
    gradient = np.array([(at(current, PLACE + d)[0] - at(current, PLACE - d)[0]) / (2.0 * step) for d in step * np.eye(3)])
    size = np.abs(gradient).max()
    assert abs(np.trace(gradient)) < 1e-6 * size
    assert np.abs(gradient - gradient.T).max() < 1e-6 * size
    carried = mean * np.array([math.cos(SLANTING["waves.direction"]), math.sin(SLANTING["waves.direction"]), 0.0])
    slope = (at(current, PLACE + carried * step, step)[0] - at(current, PLACE - carried * step, -step)[0]) / (2.0 * step)
    np.testing.assert_allclose(at(current, PLACE)[1], slope, atol=1e-4 * np.abs(slope).max())  # and k a, of second order
    assert abs(at(current, np.array([1.3, -2.1, h]))[0, 2]) < 1e-15
    top = np.array([1.3, -2.1, 0.0])
    at(current, top + carried * step, step)
    rise = current["waves.elevation"]
    at(current, top - carried * step, -step)
    rise = (rise - current["waves.elevation"]) / (2.0 * step)
    velocity, acceleration = at(current, top)
    assert -velocity[2] == pytest.approx(rise, rel=1e-4)  # the surface rises with the water
    # and its pressure is constant: along the surface the water is accelerated by the weight of what stands higher
    slopes = []
    for d in step * np.eye(3)[:2]:
        at(current, top + d)
        high = current["waves.elevation"]
        at(current, top - d)
        slopes.append((high - current["waves.elevation"]) / (2.0 * step))
    np.testing.assert_allclose(acceleration[:2], -GRAVITY * np.array(slopes), rtol=1e-3)


@pytest.mark.parametrize("mean", [0.3, 2.0, -0.3, -0.9])
@pytest.mark.parametrize("period", [3.0, 8.0])
def test_a_current_shifts_the_frequency(period, mean):
    """In deep water (w - k U)² = g k is a quadratic in k."""
    w = 2.0 * math.pi / period
    if (discriminant := GRAVITY * (GRAVITY + 4.0 * w * mean)) < 0.0:
        assert math.isnan(wave_number(w, 1e4, mean))
        return
    k = (2.0 * w * mean + GRAVITY - math.sqrt(discriminant)) / (2.0 * mean**2)
    assert wave_number(w, 1e4, mean) == pytest.approx(k, rel=1e-9)


def test_the_acceleration_is_that_of_the_water_that_is_there():
    """Of a steep wave on a current, by a difference along the path of the water, and not at a fixed place."""
    current, step, apart = waves(height=1.2, period=4.0, mean=0.8), 1e-4, []
    for t in (0.0, 0.7, 1.9, 3.1):
        velocity, acceleration = at(current, PLACE, t)
        ahead, behind = (at(current, PLACE + h * velocity, t + h)[0] for h in (step, -step))
        slope = (ahead - behind) / (2.0 * step)
        np.testing.assert_allclose(acceleration, slope, atol=1e-5 * np.linalg.norm(acceleration))
        fixed = (at(current, PLACE, t + step)[0] - at(current, PLACE, t - step)[0]) / (2.0 * step)
        apart.append(np.linalg.norm(acceleration - fixed) / np.linalg.norm(acceleration))
    assert max(apart) > 0.1


@pytest.mark.parametrize(("period", "mean", "blocked"), [(4.0, -1.6, True), (4.0, -1.5, False), (2.0, -0.8, True)])
def test_a_current_blocks_waves_that_travel_slower(period, mean, blocked):
    """Deep water: U = -g / 4 w is the strongest current that lets a wave through."""
    if blocked:
        with pytest.raises(BadInput, match="The current blocks these waves"):
            waves(height=0.01, period=period, water_depth=1e3, mean=mean)
    else:
        waves(height=0.01, period=period, water_depth=1e3, mean=mean)


def test_a_sea_leaves_out_what_the_current_blocks_and_refuses_to_leave_out_much():
    def sea(speed: float) -> np.ndarray:
        current = WaterCurrent(("waves", "spectrum"), {"speed": speed, "direction": math.pi, "waves.water_depth": 1e3})
        current.initialize(0.0)
        return components(current)

    whole, fewer = sea(0.0), sea(0.4)
    assert fewer.shape[1] < whole.shape[1]
    assert (fewer[AMPLITUDE] ** 2).sum() > 0.99 * (whole[AMPLITUDE] ** 2).sum()
    assert np.isfinite(fewer[NUMBER]).all()
    with pytest.raises(BadInput, match="blocks"):
        sea(1.0)


def test_in_deep_water_orbits_are_circles_that_shrink_with_depth():
    current = waves(water_depth=1000.0, direction=0.0)
    k = wave_number(2.0 * math.pi / 5.0, 1000.0, 0.0)
    for depth in (0.0, 2.0, 10.0):
        speeds = [np.linalg.norm(at(current, np.array([0.0, 0.0, depth]), t)[0]) for t in (0.0, 0.7, 1.9)]
        np.testing.assert_allclose(speeds, 0.4 * 2.0 * np.pi / 5.0 * math.exp(-k * depth), rtol=1e-12)


@pytest.mark.known_answers(WaterCurrent="spectrum")
@pytest.mark.parametrize(
    ("height", "period", "speeds", "accelerations"),
    [
        (0.5, 4.0, (0.110, 0.049, 0.015, 0.002), (0.191, 0.076, 0.022, 0.003)),
        (1.0, 6.0, (0.213, 0.137, 0.075, 0.026), (0.274, 0.157, 0.079, 0.026)),
        (1.5, 7.0, (0.301, 0.212, 0.131, 0.057), (0.345, 0.215, 0.123, 0.050)),
    ],
)
def test_a_sea_has_its_height_and_its_motion_at_depth(height, period, speeds, accelerations):
    """Significant height 4 sqrt(m0); root mean squares at 2, 5, 10 and 20 m of another program, printed to 1 mm/s."""
    current = WaterCurrent(
        ("waves", "spectrum"), STILL | {"waves.height": height, "waves.period": period, "waves.water_depth": 1e3}
    )
    current.initialize(0.0)
    amplitude, frequency, number = components(current)[[AMPLITUDE, FREQUENCY, NUMBER]]
    assert 4.0 * math.sqrt(0.5 * (amplitude**2).sum()) == pytest.approx(height, rel=0.005)
    for z, speed, acceleration in zip((2.0, 5.0, 10.0, 20.0), speeds, accelerations, strict=True):
        orbit = amplitude * frequency * np.exp(-number * z)
        assert math.sqrt(0.5 * (orbit**2).sum()) == pytest.approx(speed, rel=0.01, abs=6e-4)
        assert math.sqrt(0.5 * ((frequency * orbit) ** 2).sum()) == pytest.approx(acceleration, rel=0.01, abs=6e-4)


def test_peakedness_one_is_the_spectrum_of_pierson_and_moskowitz():
    f = np.linspace(0.05, 0.6, 7)
    pierson = 5.0 / 16.0 * 1.2**2 * 0.2**4 * f**-5 * np.exp(-1.25 * (0.2 / f) ** 4)
    np.testing.assert_allclose([jonswap(float(f0), 1.2, 5.0, 1.0) for f0 in f], pierson, rtol=1e-14)


def test_a_seed_is_a_sea_that_does_not_repeat():
    def sea(seed: int) -> np.ndarray:
        current = WaterCurrent(("waves", "spectrum"), STILL | {"spectrum.seed": seed})
        current.initialize(0.0)
        return np.array([(at(current, PLACE, t)[0, 0]) for t in np.arange(0.0, 40.0, 0.5)])

    one, again, other = sea(1), sea(1), sea(2)
    assert one.tobytes() == again.tobytes()
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.6
    current = WaterCurrent(("waves", "spectrum"), STILL)
    current.initialize(0.0)
    frequency = components(current)[FREQUENCY]
    period = 1.0 / (frequency[1] - frequency[0])  # after which evenly spaced components would repeat
    later = np.array([(at(current, PLACE, t + 2.0 * np.pi * period)[0, 0]) for t in np.arange(0.0, 40.0, 0.5)])
    assert abs(np.corrcoef(one, later)[0, 1]) < 0.6


def test_above_still_water_and_below_the_bottom_the_value_at_the_end_holds():
    current = waves()
    for outside, end in ((-3.0, 0.0), (20.0, 7.0)):
        beyond, there = (at(current, np.array([1.3, -2.1, z])) for z in (outside, end))
        np.testing.assert_array_equal(beyond, there)
