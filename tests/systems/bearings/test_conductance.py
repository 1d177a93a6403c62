"""The bearing's conductance: an independent equilibrium, scaling laws, closed forms of every path."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.conductance import AngularContactConductance
from cosimo.components.bearings.hertz import effective_modulus
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.tests.support import initialized
from scipy.optimize import minimize
from scipy.special import ellipk

pytestmark = pytest.mark.interpreted

# K/W, computed independently with another solver; no tilt, k = 46 W/(m.K), E = 2.07e11 Pa: axial force, radial force, value
TABLE = {
    "7008C": [
        (50, 0, 10.80),
        (100, 0, 8.631),
        (500, 0, 5.204),
        (1000, 0, 4.218),
        (5000, 0, 2.641),
        (1000, 200, 4.222),
        (1000, 500, 4.243),
        (1000, 1000, 4.330),
        (1000, 2000, 5.312),
    ],
    "7210B": [
        (50, 0, 11.79),
        (100, 0, 9.358),
        (500, 0, 5.481),
        (1000, 0, 4.356),
        (5000, 0, 2.564),
        (1000, 200, 4.385),
        (1000, 500, 4.575),
        (1000, 1000, 7.256),
        (1000, 2000, 11.69),
    ],
}
BALLS = {"7008C": {2000: 13}, "7210B": {1000: 9, 2000: 3}}


def started(preset="7008C", effects=(), parameters=None, **inputs):
    """An initialized instance."""
    return initialized(AngularContactConductance(effects, {**(parameters or {}), **inputs}, preset=preset))


@pytest.mark.known_answers(AngularContactConductance="ball_bulk")
@pytest.mark.parametrize(("preset", "axial", "radial", "resistance"), [(p, *row) for p, rows in TABLE.items() for row in rows])
def test_against_an_independent_computation(preset, axial, radial, resistance):
    made = started(preset, axial_force=axial, radial_force=radial)
    assert 1.0 / made["conductance"] == pytest.approx(resistance, rel=5e-4)  # four digits, down to 10.80
    assert made["loaded_balls"] == (BALLS[preset].get(radial, 16) if radial else 16)


@pytest.mark.parametrize(("axial", "radial"), [(200.0, 0.0), (1000.0, 700.0), (300.0, 900.0)])
def test_ball_loads_by_minimising_the_energy(axial, radial):
    """Written again from the distances of the groove centres, with SciPy's minimiser; then every ball as two ellipses."""
    made = started(axial_force=axial, radial_force=radial)
    g = made.geometry()
    modulus = effective_modulus(2.07e11, 0.3, 2.07e11, 0.3)
    K, d, alpha = g.stiffness(modulus), g.ball_diameter, g.contact_angle
    length = (g.inner_conformity + g.outer_conformity - 1.0) * d
    beta = 2.0 * np.pi * np.arange(g.balls) / g.balls

    def loads(q):
        r, z = length * math.cos(alpha) + 1e-6 * q[0] * np.cos(beta), length * math.sin(alpha) + 1e-6 * q[1]
        return np.maximum(np.hypot(r, z) - length, 0.0)

    best = minimize(
        lambda q: 1e6 * (0.4 * K * np.sum(loads(q) ** 2.5) - 1e-6 * (radial * q[0] + axial * q[1])),
        [1.0, 10.0],
        method="Nelder-Mead",
        options={"xatol": 1e-6, "fatol": 1e-9, "maxiter": 4000},
    )
    Q = K * loads(best.x) ** 1.5
    total = 0.0
    for load in Q[Q > 0.0]:
        ball = 0.0
        for race in ("inner", "outer"):
            minor, major = (0.5 * axis for axis in g.contact(race, modulus).axes(load))
            ball += 2.0 * ellipk(1.0 - (minor / major) ** 2) / (2.0 * math.pi * 46.0 * major)
        total += 1.0 / ball
    assert made["max_ball_load"] == pytest.approx(Q.max(), rel=1e-4)  # the minimiser stops 1e-6 um from the minimum, or near it
    assert made["conductance"] == pytest.approx(total, rel=1e-4)
    assert 1e6 * made["radial_displacement"] == pytest.approx(best.x[0], abs=2e-3)
    assert 1e6 * made["axial_displacement"] == pytest.approx(best.x[1], abs=2e-3)


def test_equal_balls_carry_the_axial_force():
    """sum Q sin(angle) = Fa with the angle that the displacement gives."""
    made = started(axial_force=800.0)
    g = made.geometry()
    length = (g.inner_conformity + g.outer_conformity - 1.0) * g.ball_diameter
    z = length * math.sin(g.contact_angle) + made["axial_displacement"]
    angle = math.atan2(z, length * math.cos(g.contact_angle))
    assert 16 * made["max_ball_load"] * math.sin(angle) == pytest.approx(800.0, rel=1e-9)  # the equilibrium's 1e-11


def slope(preset, low, high):
    """d ln R / d ln F between two axial forces."""
    a, b = (started(preset, axial_force=f)["conductance"] for f in (low, high))
    return -math.log(b / a) / math.log(high / low)


def test_resistance_falls_with_the_cube_root_of_the_load():
    """Of a ball exactly; of the bearing as far as the contact angle stays: at 40 degrees it grows by 1.5."""
    made = started()
    low, high = (started(axial_force=f) for f in (10.0, 5000.0))
    per_load = [m["conductance"] / m["max_ball_load"] ** (1.0 / 3.0) for m in (low, high)]
    assert per_load[1] == pytest.approx(per_load[0], rel=1e-12)  # roundings
    assert made["conductance"] == 0.0
    assert slope("7210B", 50.0, 100.0) == pytest.approx(-1.0 / 3.0, abs=1e-3)
    assert slope("7210B", 50.0, 5000.0) == pytest.approx(-1.0 / 3.0, abs=3e-3)
    assert -1.0 / 3.0 < slope("7008C", 50.0, 5000.0) < -0.30  # the angle grows from 15.6 to 23 degrees, the loads less


def test_radial_force_does_not_help_as_long_as_the_axial_one_prevails():
    """Beyond that it does: the few balls left carry more and more."""
    previous = math.inf
    for radial in (0.0, 100.0, 300.0, 600.0, 1000.0):
        made = started("7210B", axial_force=1000.0, radial_force=radial)
        assert made["conductance"] < previous
        previous = made["conductance"]


def test_the_sign_of_the_radial_force_does_not_matter():
    """Sixteen balls lie opposite one another."""
    one, other = (started(axial_force=500.0, radial_force=f) for f in (400.0, -400.0))
    assert other["conductance"] == pytest.approx(one["conductance"], rel=1e-12)
    assert other["radial_displacement"] == pytest.approx(-one["radial_displacement"], rel=1e-9)


def test_a_row_carries_one_direction_only():
    assert started(axial_force=-300.0)["conductance"] == 0.0
    assert started(axial_force=-300.0, radial_force=200.0)["conductance"] == started(radial_force=200.0)["conductance"]


# -- paths -------------------------------------------------------------------------------------------------------------
AREA = math.pi * 54e-3 * 15e-3  # of 7008C


@pytest.mark.known_answers(AngularContactConductance=("gas_path", "convection", "radiation"))
def test_side_paths_have_their_closed_forms():
    bare = started(axial_force=400.0)["conductance"]
    convection = started(effects=["convection"], axial_force=400.0)["conductance"] - bare
    assert convection == pytest.approx(0.5 * 10.0 * AREA, rel=1e-9)  # rounding of the difference
    radiation = started(
        effects=["radiation"], parameters={"radiation.inner_temperature": 350.0, "radiation.outer_temperature": 300.0}
    )["conductance"]
    assert radiation * 50.0 == pytest.approx(0.2 * 5.670374419e-8 * AREA * (350.0**4 - 300.0**4), rel=1e-12)
    still = started(effects=["gas_path"], parameters={"gas_path.widest_gap": 0.0})["conductance"]
    assert still == pytest.approx(0.026 * AREA / 8e-3, rel=1e-12)


def test_side_paths_in_round_figures():
    """Reference figures for this bearing: 320 K/W by radiation near 300 K, 121 K/W through 8 mm of still air."""
    warm = {"radiation.inner_temperature": 300.0, "radiation.outer_temperature": 300.0}
    assert 1.0 / started(effects=["radiation"], parameters=warm)["conductance"] == pytest.approx(320.0, rel=0.01)
    air = started(effects=["gas_path"], parameters={"gas_path.widest_gap": 0.0})["conductance"]
    assert 1.0 / air == pytest.approx(121.0, rel=0.01)


@pytest.mark.known_answers(AngularContactConductance="ring_walls")
def test_rings_are_cylinder_walls_with_less_constriction():
    one = started(effects=["ring_walls", "convection"], parameters={"convection.coefficient": 1e4})
    across = 7.938e-3 * math.cos(math.radians(15.0))
    walls = sum(math.log(b / a) / (2.0 * math.pi * 46.0 * 15e-3) for a, b in ((40e-3, 54e-3 - across), (54e-3 + across, 68e-3)))
    # no ball touches: the wall is in series with convection alone
    assert 1.0 / one["conductance"] == pytest.approx(walls + 2.0 / (1e4 * AREA), rel=1e-12)
    walled, bare = started(effects=["ring_walls"], axial_force=1000.0), started(axial_force=1000.0)
    radii = [math.sqrt(diameter * 15e-3 / 16) for diameter in (54e-3 - across, 54e-3 + across)]
    relief = sum(1.4098 / (4.0 * 46.0 * r) for r in radii) / 16
    assert 1.0 / walled["conductance"] == pytest.approx(1.0 / bare["conductance"] + walls - relief, rel=1e-9)


@pytest.mark.known_answers(AngularContactConductance="film")
def test_a_film_is_in_series_over_the_area_of_the_ellipse():
    bare, wet = started(axial_force=1000.0), started(effects=["film"], parameters={"film.thickness": 4e-7}, axial_force=1000.0)
    g, load, modulus = bare.geometry(), bare["max_ball_load"], effective_modulus(2.07e11, 0.3, 2.07e11, 0.3)
    films = 0.0
    for race in ("inner", "outer"):
        x, y = g.contact(race, modulus).axes(load)
        films += 4e-7 / (0.14 * math.pi * 0.25 * x * y)
    assert 1.0 / wet["conductance"] == pytest.approx(1.0 / bare["conductance"] + films / 16, rel=1e-9)


@pytest.mark.known_answers(AngularContactConductance="lubricant_path")
def test_lubricant_beside_the_contact_conducts_more_than_gas():
    bare = started(axial_force=200.0)["conductance"]
    gas = started(effects=["gas_path"], axial_force=200.0)["ball_conductance"]
    both = started(effects=["gas_path", "lubricant_path"], axial_force=200.0)["ball_conductance"]
    assert bare < gas < both
    none = {"lubricant_path.conductivity": 0.026, "lubricant_path.meniscus_height": 1e-5}
    same = started(effects=["gas_path", "lubricant_path"], parameters=none, axial_force=200.0)["ball_conductance"]
    assert same == pytest.approx(gas, rel=2e-3)  # the same gap in two ladders; a ladder's own error is 1e-3


@pytest.mark.parametrize("axial", [0.0, 1000.0])
@pytest.mark.parametrize("path", ["lubricant_path", "gas_path"])
def test_a_gap_is_continuous_down_to_what_conducts_nothing(path, axial):
    """The constriction from the contact to the meniscus stays where the lubricant conducts nothing, and the gas begins beyond."""
    least, none = (
        started(effects=["ball_bulk", "gas_path", "lubricant_path"], parameters={f"{path}.conductivity": k}, axial_force=axial)
        for k in (1e-12, 0.0)
    )
    assert none["ball_conductance"] == pytest.approx(least["ball_conductance"], rel=1e-9)  # 1e-12 over 0.026 W/(m.K), times 10
    assert none["ball_conductance"] > 0.0


def test_nothing_passes_an_unloaded_bearing_whose_gaps_conduct_nothing():
    nothing = {"gas_path.conductivity": 0.0, "lubricant_path.conductivity": 0.0}
    assert started(effects=["gas_path", "lubricant_path"], parameters=nothing)["conductance"] == 0.0


@pytest.mark.parametrize("name", ["gas_path.widest_gap", "lubricant_path.meniscus_height"])
def test_gaps_that_reach_beyond_the_ball_are_refused(name):
    """The unloaded gap opens as x²/(2 Ry) across the groove, Ry = 0.52 d / 0.04; x is at most the ball's radius."""
    effect = name.partition(".")[0]
    limit = (0.5 * 7.938e-3) ** 2 * 0.04 / (2.0 * 0.52 * 7.938e-3)
    assert started(effects=["ball_bulk", effect], parameters={name: 0.999 * limit}, axial_force=5e3)["conductance"] > 0.0
    with pytest.raises(BadInput, match=f"{name}.*at most"):
        started(effects=["ball_bulk", effect], parameters={name: 1.001 * limit})


def test_contacts_as_large_as_the_ball_are_out_of_range():
    made = started(axial_force=1000.0)
    made.set("axial_force", 1e7)
    with pytest.raises(StepFailed, match="range"):
        made.refresh()
