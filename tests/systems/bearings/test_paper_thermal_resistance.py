"""The paper of the thermal resistance: its measures against closed forms and another equilibrium."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems.bearings import least_energy
from cosimo.orchestrator.systems.bearings.cases import paper_thermal_resistance as paper
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipkm1


def test_resistance_under_axial_load_is_that_of_equal_balls():
    """All balls alike: load from the angle that the axial force gives, constrictions by SciPy's elliptic integral."""
    model = paper.bearing("7210B")
    p, geometry = model.parameters, model.geometry()
    distance = (p["inner_conformity"] + p["outer_conformity"] - 1.0) * p["ball_diameter"]
    stiffness = geometry.stiffness(model.material())

    def balance(angle):
        stretched = distance * math.cos(p["contact_angle"]) / math.cos(angle)
        return 16 * stiffness * max(stretched - distance, 0.0) ** 1.5 * math.sin(angle) - 1000.0

    angle = brentq(balance, p["contact_angle"], 0.9)
    load = 1000.0 / (16 * math.sin(angle))
    total = 0.0
    for race in ("inner", "outer"):
        minor, major = (0.5 * axis for axis in geometry.contact(race, model.material()).axes(load))
        total += 2.0 * ellipkm1((minor / major) ** 2) / (2.0 * math.pi * 46.0 * major)
    assert paper.resistance(model, 1000.0) == pytest.approx(total / 16, rel=1e-6)


@pytest.mark.parametrize("preset", paper.ANGLES)
def test_exponent_is_the_slope_of_a_wide_difference(preset):
    model = paper.bearing(preset)
    wide = -math.log(paper.resistance(model, 220.0) / paper.resistance(model, 180.0)) / math.log(220.0 / 180.0)
    assert paper.exponent(model, 200.0) == pytest.approx(wide, abs=1e-3)


@pytest.mark.parametrize("epsilon", [0.7, 1.25, 2.5])
def test_ratio_of_the_load_zone_is_that_of_its_integrals(epsilon):
    edge = math.acos(max(1.0 - 2.0 * epsilon, -1.0))

    def mean(power):
        return quad(lambda t: max(1.0 - (1.0 - math.cos(t)) / (2.0 * epsilon), 0.0) ** power, 0.0, edge)[0] / math.pi

    assert paper.zone(epsilon) == pytest.approx(mean(1.5) ** (1.0 / 3.0) / mean(0.5), rel=0.01)


def test_shares_sum_to_one_and_solids_in_series_take_from_the_contacts():
    parts = paper.shares("7008C", 100.0)
    assert list(parts) == ["contacts", "gas", "convection", "radiation"]
    assert sum(parts.values()) == pytest.approx(1.0, abs=1e-12)
    assert all(v > 0.0 for v in parts.values())
    assert paper.shares("7008C", 100.0, within=paper.BULK)["contacts"] < parts["contacts"]


def test_least_energy_under_axial_load_is_that_of_equal_balls_with_a_grown_angle():
    """One equation for the angle, and the textbook's load of each ball."""
    one = paper.like(paper.bearing("7008C"))
    load = least_energy.loads(one, 500.0, 0.0)
    distance = (one.inner + one.outer - 1.0) * one.ball
    stiffness = sum(least_energy.contact(one, race).stiffness ** (-2.0 / 3.0) for race in ("inner", "outer")) ** -1.5
    grown = math.acos(distance * math.cos(one.angle) / (distance + (load[0] / stiffness) ** (2.0 / 3.0)))
    assert load == pytest.approx(np.full(16, 500.0 / (16.0 * math.sin(grown))), rel=1e-9)


def test_least_energy_balances_both_forces_and_refuses_what_has_none():
    one = paper.like(paper.bearing("7210B"))
    load = least_energy.loads(one, 1000.0, 3000.0)
    assert (load > 0.0).sum() == 3
    assert load[1] == pytest.approx(load[-1], rel=1e-9)
    with pytest.raises(ArithmeticError, match="no equilibrium"):
        least_energy.loads(one, math.nan, 0.0)


@pytest.mark.parametrize("preset", paper.ANGLES)
def test_without_load_the_side_paths_are_left(preset):
    model = paper.bearing(preset, paper.SIDE, **paper.ANNULUS)
    assert 1.0 / paper.resistance(model, 0.0) == pytest.approx(paper.side_paths(preset), rel=1e-9)


def test_conductances_of_the_balls_sum_to_the_bearing_and_follow_the_cube_root():
    model = paper.bearing("7210B")
    whole = 1.0 / paper.resistance(model, 1000.0, 1000.0)
    each = paper.ball_conductances(model)
    assert each.sum() == pytest.approx(whole, rel=1e-12)
    assert each / each.max() == pytest.approx(np.cbrt(model.ball_loads / model.ball_loads.max()), abs=1e-12)
    areas = paper.areas(model, model.ball_loads)
    assert areas / areas.max() == pytest.approx((each / each.max()) ** 2, abs=1e-9)


@pytest.mark.parametrize("preset", paper.ANGLES)
def test_under_light_loads_all_balls_grow_in_proportion(preset):
    """Ten times both loads are ten times the load of every ball, at any ratio: so 1/3 is no matter of axial load."""
    model = paper.bearing(preset)
    for ratio in paper.MIXED:
        loads = []
        for force in (1e-5, 1e-4):
            paper.resistance(model, force, ratio * force)
            loads.append(np.array(model.ball_loads))
        assert loads[1] == pytest.approx(10.0 * loads[0], abs=1e-3 * loads[1].max())
