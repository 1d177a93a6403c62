"""Water under waves: what a linear wave is by its equations, a sea by its spectrum, and a hull that moves with the water."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.components.rov.current import WaterCurrent
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.waves import GRAVITY, jonswap, wave_number

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


def waves(**parameters: float) -> WaterCurrent:
    current = WaterCurrent(("waves",), STILL | SLANTING | {f"waves.{n}": v for n, v in parameters.items()})
    current.initialize(0.0)
    return current


@pytest.mark.parametrize("kh", [1e-3, 0.1, 1.0, 3.0, 50.0])
def test_wave_numbers_satisfy_the_dispersion_relation_in_any_depth(kh):
    depth = 4.0
    frequency = math.sqrt(GRAVITY * kh / depth * math.tanh(kh))
    assert wave_number(np.array([frequency]), depth)[0] == pytest.approx(kh / depth, rel=1e-13)


def test_wave_numbers_in_ten_metres_of_water():
    """Another solver's: periods of 4, 6 and 8 s."""
    np.testing.assert_allclose(wave_number(2.0 * np.pi / np.array([4.0, 6.0, 8.0]), 10.0), [0.2546, 0.1298, 0.0886], rtol=5e-4)


@pytest.mark.parametrize("parameters", [{}, {"water_depth": 500.0}, {"period": 12.0}])
def test_the_flow_has_a_potential_and_keeps_volume_bottom_and_surface(parameters):
    """Laplace's equation: no divergence, no curl, what the bottom and the surface ask for, and Newton at a fixed place."""
    current, step = waves(**parameters), 1e-4
    h = current.parameters["waves.water_depth"]
    gradient = np.array([(at(current, PLACE + d)[0] - at(current, PLACE - d)[0]) / (2.0 * step) for d in step * np.eye(3)])
    size = np.abs(gradient).max()
    assert abs(np.trace(gradient)) < 1e-6 * size
    assert np.abs(gradient - gradient.T).max() < 1e-6 * size
    slope = (at(current, PLACE, step)[0] - at(current, PLACE, -step)[0]) / (2.0 * step)
    np.testing.assert_allclose(at(current, PLACE)[1], slope, atol=1e-6 * np.abs(slope).max())
    assert abs(at(current, np.array([1.3, -2.1, h]))[0, 2]) < 1e-15
    top = np.array([1.3, -2.1, 0.0])
    at(current, top, step)
    rise = current["waves.elevation"]
    at(current, top, -step)
    rise = (rise - current["waves.elevation"]) / (2.0 * step)
    velocity, acceleration = at(current, top)
    assert -velocity[2] == pytest.approx(rise, rel=1e-6)  # the surface rises with the water
    # and its pressure is constant: along the surface the water is accelerated by the weight of what stands higher
    slopes = []
    for d in step * np.eye(3)[:2]:
        at(current, top + d)
        high = current["waves.elevation"]
        at(current, top - d)
        slopes.append((high - current["waves.elevation"]) / (2.0 * step))
    np.testing.assert_allclose(acceleration[:2], -GRAVITY * np.array(slopes), rtol=1e-6)


def test_in_deep_water_orbits_are_circles_that_shrink_with_depth():
    current = waves(water_depth=1000.0, direction=0.0)
    k = wave_number(np.array([2.0 * np.pi / 5.0]), 1000.0)[0]
    for depth in (0.0, 2.0, 10.0):
        speeds = [np.linalg.norm(at(current, np.array([0.0, 0.0, depth]), t)[0]) for t in (0.0, 0.7, 1.9)]
        np.testing.assert_allclose(speeds, 0.4 * 2.0 * np.pi / 5.0 * math.exp(-k * depth), rtol=1e-12)


@pytest.mark.parametrize(("height", "period", "speeds", "accelerations"), [
    (0.5, 4.0, (0.110, 0.049, 0.015, 0.002), (0.191, 0.076, 0.022, 0.003)),
    (1.0, 6.0, (0.213, 0.137, 0.075, 0.026), (0.274, 0.157, 0.079, 0.026)),
    (1.5, 7.0, (0.301, 0.212, 0.131, 0.057), (0.345, 0.215, 0.123, 0.050)),
])
def test_a_sea_has_its_height_and_its_motion_at_depth(height, period, speeds, accelerations):
    """Significant height 4 sqrt(m0); root mean squares at 2, 5, 10 and 20 m of another program, printed to 1 mm/s."""
    current = WaterCurrent(("waves", "spectrum"), STILL | {"waves.height": height, "waves.period": period,
                                                          "waves.water_depth": 1e3})
    current.initialize(0.0)
    sea = current.arguments[1].waves
    assert 4.0 * math.sqrt(0.5 * (sea.amplitude**2).sum()) == pytest.approx(height, rel=0.005)
    for z, speed, acceleration in zip((2.0, 5.0, 10.0, 20.0), speeds, accelerations, strict=True):
        orbit = sea.amplitude * sea.frequency * np.exp(-sea.number * z)
        assert math.sqrt(0.5 * (orbit**2).sum()) == pytest.approx(speed, rel=0.01, abs=6e-4)
        assert math.sqrt(0.5 * ((sea.frequency * orbit) ** 2).sum()) == pytest.approx(acceleration, rel=0.01, abs=6e-4)


def test_peakedness_one_is_the_spectrum_of_pierson_and_moskowitz():
    f = np.linspace(0.05, 0.6, 7)
    pierson = 5.0 / 16.0 * 1.2**2 * 0.2**4 * f**-5 * np.exp(-1.25 * (0.2 / f) ** 4)
    np.testing.assert_allclose(jonswap(f, 1.2, 5.0, 1.0), pierson, rtol=1e-14)


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
    frequency = current.arguments[1].waves.frequency
    period = 1.0 / (frequency[1] - frequency[0])  # after which evenly spaced components would repeat
    later = np.array([(at(current, PLACE, t + 2.0 * np.pi * period)[0, 0]) for t in np.arange(0.0, 40.0, 0.5)])
    assert abs(np.corrcoef(one, later)[0, 1]) < 0.6


def test_above_still_water_and_below_the_bottom_the_value_at_the_end_holds():
    current = waves()
    for outside, end in ((-3.0, 0.0), (20.0, 7.0)):
        beyond, there = (at(current, np.array([1.3, -2.1, z])) for z in (outside, end))
        np.testing.assert_array_equal(beyond, there)


@pytest.mark.parametrize(("height", "period", "depth", "breaks"), [
    (4.0, 4.0, 1e3, True), (3.4, 4.0, 1e3, False), (1.0, 8.0, 1.0, True), (0.8, 8.0, 1.0, False)])
def test_waves_that_would_have_broken_are_refused(height, period, depth, breaks):
    current = WaterCurrent(("waves",), {"waves.height": height, "waves.period": period, "waves.water_depth": depth})
    if breaks:
        with pytest.raises(BadInput, match="break at this period"):
            current.initialize(0.0)
    else:
        current.initialize(0.0)


@pytest.mark.parametrize("displaced", [11.5, 11.7, 14.0])
def test_a_neutral_hull_moves_with_the_water_of_a_wave(displaced):
    """|V/u| = |(rho V + m_a) i w + d| / |(m + m_a) i w + d|, 1 where the hull weighs what it displaces; linear drag."""
    mass, added, drag, w, amplitude = 11.5, 5.5, 4.03, 1.2, 0.2
    hull = RovHull(("added_mass", "linear_drag", "current", "pressure_gradient"),
                   {"pressure_gradient.displaced_mass": displaced, "centre_of_gravity_z": 0.0})
    hull.set("current.velocity_north", 0.0)
    response = complex(drag, w * (displaced + added)) / complex(drag, w * (mass + added))
    hull.parameters["start_surge"] = amplitude * response.imag
    hull.initialize(0.0)
    step = 0.02
    for k in range(400):
        t = k * step
        for name, value, rate, bend in (
            ("velocity", math.sin(w * t), w * math.cos(w * t), -w * w * math.sin(w * t)),
            ("acceleration", w * math.cos(w * t), -w * w * math.sin(w * t), -(w**3) * math.cos(w * t)),
        ):
            i = hull.input_positions([f"current.{name}_north"])[0]
            hull.u[:, i] = amplitude * np.array([value, rate, 0.5 * bend])
        hull.step(t, step)
    t = 400 * step
    wanted = amplitude * (response * complex(math.cos(w * t), math.sin(w * t))).imag
    assert hull["surge"] == pytest.approx(wanted, abs=1e-6)  # of inputs as parabolas in each step
