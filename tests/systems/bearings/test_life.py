"""Rating life: against a commercial program in the case `iso16281`; here its laws, its limits and the life of a run."""

import math

import cosimo
import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.life import life_share, lubrication_factor, ring_ratings
from cosimo.components.bearings.motion import DISPLACEMENT

pytestmark = pytest.mark.interpreted


def bearing(effects=("rating_life",), load=(1000.0, 0.0, 0.0, 0.0, 0.0), speed=100.0, **parameters) -> DeepGrooveBearing:
    """At rest under an external load, N."""
    unit = DeepGrooveBearing(effects, parameters, preset="6205")
    unit.initialize(0.0)
    rest = unit.equilibrium(np.array(load)).displacement
    for name, value in zip((*DISPLACEMENT, "speed"), (*rest.tolist(), speed), strict=True):
        unit.set(name, value)
    unit.refresh()
    return unit


@pytest.mark.known_answers(DeepGrooveBearing="rating_life")
def test_a_thrust_bearing_has_the_life_of_its_ratings():
    """All balls alike under an axial load: both means are the load itself, whatever their exponents."""
    inner, outer = ring_ratings(9, 0.2, 0.52, 0.53, 20e3)
    expected = ((800.0 / inner) ** (10.0 / 3.0) + (800.0 / outer) ** (10.0 / 3.0)) ** 0.9
    for turning in (False, True):
        assert life_share(np.full(9, 800.0), np.full(9, 800.0), inner, outer, turning) == pytest.approx(expected, rel=1e-13)
    assert life_share(np.zeros(9), np.zeros(9), inner, outer, False) == 0.0


def test_the_rating_is_the_radial_load_of_a_million_revolutions():
    """With many balls and half of them loaded, as the rating is defined: P = F within what ISO rounds 0.407 and 0.389 to, 1 %."""
    unit = bearing(load=(2000.0, 0.0, 0.0, 0.0, 0.0), **{"rating_life.load_rating": 14.8e3})
    assert unit["rating_life.equivalent_load"] == pytest.approx(2000.0, rel=0.02)
    lighter = bearing(load=(1000.0, 0.0, 0.0, 0.0, 0.0), **{"rating_life.load_rating": 14.8e3})
    assert unit["rating_life.rate"] / lighter["rating_life.rate"] == pytest.approx(8.0, rel=1e-3)
    assert unit["rating_life.rate"] == pytest.approx(
        100.0 / (2.0 * math.pi) / (1e6 * (14.8e3 / unit["rating_life.equivalent_load"]) ** 3)
    )


def test_a_load_that_turns_with_the_shaft_wears_the_inner_ring_more():
    standing, turning = (bearing(**{"rating_life.load": load}) for load in ("standing", "turning"))
    assert 1.0 < turning["rating_life.rate"] / standing["rating_life.rate"] < 1.2


@pytest.mark.known_answers(DeepGrooveBearing="life_factor")
def test_the_factor_is_continuous_between_its_ranges_and_ends_at_both():
    for kappa in (0.4, 1.0):
        below, above = (lubrication_factor(kappa * s, 0.5, 1000.0, 2000.0) for s in (1.0 - 1e-9, 1.0))
        assert below == pytest.approx(above, rel=1e-3)  # 1.9987 and 2.2649 are rounded to 5e-5 of 0.19
    assert lubrication_factor(2.0, 0.0, 1000.0, 2000.0) == 0.1  # no trust in contaminated oil
    assert lubrication_factor(4.0, 1.0, 1000.0, 10.0) == 50.0
    assert lubrication_factor(4.0, 1.0, 1000.0, 0.0) == 50.0
    values = [lubrication_factor(k, 0.6, 1000.0, 3000.0) for k in np.geomspace(0.1, 4.0, 60)]
    assert np.all(np.diff(values) > 0.0)
    with_factor = bearing(("rating_life", "life_factor"), **{"life_factor.reliability": 0.62})
    factor = 0.62 * with_factor["life_factor.a_iso"]
    assert with_factor["rating_life.rate"] == pytest.approx(bearing()["rating_life.rate"] / factor, rel=1e-13)


def test_the_life_of_a_run_is_that_of_its_mean_rate():
    scene = cosimo.load_scene("rotor-run-up").with_changes({"left.effects.rating_life": True, "stop_time": 0.003})
    scene = scene.with_changes({"record.signals": [*scene.record.signals, "left.rating_life.rate"]})
    result = cosimo.run(scene, in_process=True, verify="no")
    rows = {row.name: row for row in cosimo.summary(result)}
    mean = float(result["left.rating_life.rate"].mean())
    assert rows["rotor.bearing_a.rating_life"].unit == "h"
    assert rows["rotor.bearing_a.rating_life"].value == pytest.approx(1.0 / (3600.0 * mean), rel=1e-12)
