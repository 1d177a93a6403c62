"""Curves of wind turbines: their maxima against closed forms and printed numbers, Betz's limit, standstill, beyond the fits."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.curves import BETZ, CURVES, FARM, FAST, HEIER, SIMPLE, VARIANT, torque_coefficient
from scipy.optimize import minimize_scalar

FITS = (HEIER, SIMPLE, VARIANT)


def power_coefficient(curve, ratio, pitch=0.0):
    """C_p as the ratio times C_Q of the component's kernel; farm windmill with its defaults."""
    return ratio * torque_coefficient(curve, ratio, pitch, 0.5, 2.4)


def maximum(curve, pitch, low, high):
    """(ratio, C_p) at the maximum."""
    optimum = minimize_scalar(
        lambda r: -power_coefficient(curve, r, pitch), bounds=(low, high), method="bounded", options={"xatol": 1e-10}
    )
    return optimum.x, -optimum.fun


@pytest.mark.parametrize(
    ("curve", "pitch", "ratio", "largest"),
    [
        (HEIER, 0.0, 8.100117, 0.4800119),
        (HEIER, 5.0, 9.2302, 0.3576175),
        (HEIER, 10.0, 7.4934, 0.2561231),
        (SIMPLE, 0.0, 7.954026, 0.4109631),
        (VARIANT, 0.0, 6.324973, 0.4382090),
        (FARM, 0.0, 1.2, 0.30),
    ],
)
def test_maxima_are_those_computed_elsewhere(curve, pitch, ratio, largest):
    """Computed from the published formulas with another program; the ratio of a flat maximum to half of the digits."""
    optimum, value = maximum(curve, pitch, 0.6, 14.0)
    assert value == pytest.approx(largest, rel=2e-7)
    assert optimum == pytest.approx(ratio, rel=2e-5)


@pytest.mark.parametrize(("curve", "factor", "decay"), [(SIMPLE, 0.5, 21.0), (VARIANT, 0.22, 12.5)])
def test_maximum_of_an_exponential_fit_in_closed_form(curve, factor, decay):
    """d/dy (116 y - 5) exp(-decay y) = 0 at y = 1/decay + 5/116; the ratio is 1/(y + 0.035)."""
    y = 1.0 / decay + 5.0 / 116.0
    ratio, value = maximum(curve, 0.0, 2.0, 14.0)
    assert value == pytest.approx(factor * (116.0 * y - 5.0) * math.exp(-decay * y), rel=1e-13)
    assert ratio == pytest.approx(1.0 / (y + 0.035), rel=1e-6)


@pytest.mark.parametrize("curve", range(len(CURVES)), ids=CURVES)
def test_no_curve_exceeds_betz(curve):
    pitches = (0.0,) if curve == FARM else np.linspace(0.0, 45.0, 31)
    ratios = np.concatenate((np.linspace(-5.0, 20.0, 1001), np.geomspace(20.0, 1e6, 200)))
    values = [power_coefficient(curve, r, b) for b in pitches for r in ratios]
    assert np.isfinite(values).all()
    assert max(values) < BETZ


@pytest.mark.parametrize("curve", FITS)
@pytest.mark.parametrize("pitch", [0.0, 3.0, 20.0])
def test_near_standstill_the_torque_coefficient_is_an_ordinary_number(curve, pitch):
    """Only what 0/0 would be is replaced: where the curve begins, its exponential has faded, but for a pitch far off."""
    values = [torque_coefficient(curve, r, pitch, 0.5, 2.4) for r in (-3.0, -1e-300, 0.0, 1e-300, 1e-9, 0.1, 0.5)]
    assert len(set(values)) == 1
    if pitch == 0.0:
        assert values[0] == pytest.approx(0.0068 if curve == HEIER else 0.0, abs=1e-8)


@pytest.mark.parametrize("curve", FITS)
def test_an_overspeeding_fit_gives_neither_drive_nor_brake(curve):
    """One of the fits would grow again with its linear term beyond a ratio of 1438."""
    assert torque_coefficient(curve, 30.0, 0.0, 0.5, 2.4) == 0.0
    assert torque_coefficient(curve, 1.01 * FAST, 0.0, 0.5, 2.4) == 0.0
    assert torque_coefficient(curve, math.inf, 0.0, 0.5, 2.4) == 0.0


def test_a_negative_pitch_counts_as_none():
    """The fit divides by pitch³ + 1."""
    assert torque_coefficient(HEIER, 8.0, -1.0, 0.5, 2.4) == torque_coefficient(HEIER, 8.0, 0.0, 0.5, 2.4)
