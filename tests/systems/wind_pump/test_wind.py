"""The wind: ramps, gusts and the course of a day against their formulas; turbulence against Dryden's correlation."""

import math

import numpy as np
import pytest
from cosimo.components.core.random_numbers import normal_number
from cosimo.components.wind_pump.wind import Wind

pytestmark = pytest.mark.interpreted

ONLY = {"mean_speed": 5.0}


def at(effects, parameters, times):
    """Speeds at the times, reached in steps from one to the next."""
    wind = Wind(effects, parameters)
    wind.initialize(0.0)
    speeds, now = [], 0.0
    for t in times:
        if t > now:
            wind.step(now, t - now)
        now = t
        speeds.append(wind["speed"])
    return np.array(speeds)


@pytest.mark.known_answers(Wind="ramp")
def test_a_ramp_rises_stays_and_returns():
    ramp = {"ramp.end_speed": 8.0, "ramp.rate": 0.5, "ramp.start_time": 10.0, "ramp.return_time": 20.0}
    speeds = at(["ramp"], ONLY | ramp, [0.0, 10.0, 13.0, 16.0, 19.0, 20.0, 22.0, 26.0, 40.0])
    assert speeds == pytest.approx([5.0, 5.0, 6.5, 8.0, 8.0, 8.0, 7.0, 5.0, 5.0], abs=1e-12)


def test_a_ramp_that_turns_back_halfway_turns_back_from_where_it_is():
    ramp = {"ramp.end_speed": 2.0, "ramp.rate": 0.5, "ramp.return_time": 4.0}
    assert at(["ramp"], ONLY | ramp, [3.0, 4.0, 6.0, 8.0, 9.0]) == pytest.approx([3.5, 3.0, 4.0, 5.0, 5.0], abs=1e-12)


@pytest.mark.known_answers(Wind="gusts")
def test_gusts_come_every_period():
    gusts = {"gusts.start_time": 10.0, "gusts.rise": 2.0, "gusts.stay": 3.0, "gusts.period": 20.0}
    times = np.array([9.0, 11.0, 12.0, 14.9, 16.0, 17.0, 29.0, 31.0, 34.0, 51.0])
    expected = 5.0 + 7.0 * np.array([0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.5, 1.0, 0.5])
    assert at(["gusts"], ONLY | gusts, times) == pytest.approx(expected, abs=1e-12)


def test_a_gust_without_rise_is_a_step():
    gusts = {"gusts.start_time": 1.0, "gusts.rise": 0.0, "gusts.stay": 2.0}
    assert list(at(["gusts"], ONLY | gusts, [0.999, 1.0, 2.999, 3.0, 1e6])) == [5.0, 12.0, 12.0, 5.0, 5.0]


@pytest.mark.known_answers(Wind="daily")
def test_a_day_has_its_strongest_and_its_weakest_hour():
    speeds = at(["daily"], ONLY, [10800.0, 32400.0, 54000.0, 54000.0 + 86400.0])
    assert speeds == pytest.approx([3.5, 5.0, 6.5, 6.5], abs=1e-12)


def test_the_wind_does_not_blow_backwards():
    gusts = {"gusts.start_time": 1.0, "gusts.amplitude": -9.0}
    assert at(["gusts"], ONLY | gusts, [5.0])[0] == 0.0


def samples(n, **parameters):
    """Turbulence of unit variance at n instants an interval of 0.5 s apart."""
    given = ONLY | {f"turbulence.{k}": v for k, v in parameters.items()}
    return (at(["turbulence"], given, 0.5 * np.arange(n)) / 5.0 - 1.0) / 0.15


@pytest.mark.known_answers(Wind="turbulence")
def test_turbulence_has_drydens_correlation():
    """exp(-U tau / L) with U / L = 1/6 per s. 40 000 samples hold n_eff = 1700 independent ones: 3 / sqrt(n_eff) = 0.07."""
    xi = samples(40_000, length=30.0)
    assert abs(xi.mean()) < 0.07
    for lag in (0, 1, 4, 12, 24):
        product = np.mean(xi[: xi.size - lag] * xi[lag:])
        assert product == pytest.approx(math.exp(-lag * 0.5 / 6.0), abs=0.09)


def test_turbulence_is_normal():
    """Short memory, so that samples count: moments and tails of the normal distribution within three deviations."""
    xi = samples(20_000, length=0.5)
    n = xi.size
    assert abs(np.mean(xi**3)) < 3.0 * math.sqrt(15.0 / n)
    assert np.mean(xi**4) == pytest.approx(3.0, abs=3.0 * math.sqrt(96.0 / n))
    assert np.mean(np.abs(xi) > 1.959964) == pytest.approx(0.05, abs=3.0 * math.sqrt(0.05 * 0.95 / n))


def test_numbers_of_neighbouring_seeds_and_counts_are_independent():
    grid = np.array([[normal_number(seed, k) for k in range(4000)] for seed in (0, 1, 2, 2**31 - 1)])
    correlation = np.corrcoef(grid) - np.eye(4)
    assert np.abs(correlation).max() < 4.0 / math.sqrt(4000)
    assert abs(np.mean(grid[:, 1:] * grid[:, :-1])) < 4.0 / math.sqrt(4 * 3999)


@pytest.mark.parametrize("h", [0.05, 0.3, 1.7])
def test_turbulence_is_the_same_whatever_the_steps(h):
    times = np.arange(0.0, 60.0, h)
    fine = Wind(["turbulence", "daily"], ONLY)
    fine.initialize(0.0)
    fine.step(0.0, float(times[-1]))
    assert at(["turbulence", "daily"], ONLY, times)[-1] == pytest.approx(fine["speed"], rel=1e-12)


def test_seeds_make_other_winds_and_the_same_seed_the_same():
    assert np.array_equal(samples(50, seed=3), samples(50, seed=3))
    assert not np.array_equal(samples(50, seed=3), samples(50, seed=4))
