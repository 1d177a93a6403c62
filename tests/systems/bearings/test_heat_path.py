"""Finite volumes against closed forms: walls, shells, fins, spots on half spaces, a ball; then the lumped path against them."""

import math
from functools import cache

import numpy as np
import pytest
from cosimo.components.bearings.conductance import AngularContactConductance
from cosimo.components.bearings.constriction import ball_spreading, constriction, finite_ring
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.systems.bearings import finite_volumes
from cosimo.orchestrator.systems.bearings.finite_volumes import Bodies, cylindrical, graded, spherical
from cosimo.orchestrator.systems.bearings.heat_path import RingPart, Surroundings, solve_bearing, solve_path, solve_rings
from cosimo.tests.slopes import slope

pytestmark = pytest.mark.interpreted

ROUND = 1e-10  # a few thousand cells, solved directly


def through(grid, axis):
    """Heat in W for 1 K between the first and the last faces along an axis."""
    bodies = Bodies()
    index = bodies.add(grid)
    first, last = np.take(index, 0, axis), np.take(index, -1, axis)
    bodies.hold(first, 1.0 / np.take(grid.half[axis][0], 0, axis), 1.0)
    bodies.hold(last, 1.0 / np.take(grid.half[axis][1], -1, axis), 0.0)
    return bodies.solve(0.5)[1]


def test_heat_along_one_coordinate_is_exact():
    """The half resistances are integrals: cylinder's wall, part of a ring, spherical shell, cone between two shells."""
    rough = np.array([0.0, 0.1, 0.4, 1.0])
    wall = cylindrical(0.01 + 0.02 * rough, 2.0 * rough, 0.015 * rough, 46.0)
    shell = spherical(0.01 + 0.02 * rough, 0.3 + rough, rough, 46.0)
    solid = math.cos(0.3) - math.cos(1.3)
    expected = [
        (wall, 0, 46.0 * 2.0 * 0.015 / math.log(3.0)), (wall, 1, 46.0 * 0.015 * math.log(3.0) / 2.0),
        (wall, 2, 46.0 * 0.5 * (0.03**2 - 0.01**2) * 2.0 / 0.015),
        (shell, 0, 46.0 * solid / (1.0 / 0.01 - 1.0 / 0.03)),
        (shell, 1, 46.0 * 0.02 / math.log(math.tan(0.65) / math.tan(0.15))),
        (shell, 2, 46.0 * 0.02 * math.log(math.tan(0.65) / math.tan(0.15))),
    ]  # fmt: skip
    for grid, axis, conductance in expected:
        heat = through(grid, axis)
        assert heat[0] == pytest.approx(conductance, rel=ROUND)
        assert heat[1] == pytest.approx(-conductance, rel=ROUND)


def test_conjugate_gradients_give_the_direct_solution(monkeypatch):
    """Of a closed ring of an odd number of cells and a node of air, both of which no chessboard covers, and of a body on its own."""
    bodies = Bodies()
    ring = bodies.add(
        cylindrical(np.linspace(0.03, 0.04, 5), np.linspace(0.0, 2.0 * math.pi, 8), np.linspace(0.0, 0.01, 4), 46.0), closed=1
    )
    apart = bodies.add(cylindrical(np.linspace(0.0, 0.01, 4), np.linspace(0.0, 1.0, 4), np.linspace(0.0, 0.01, 4), 1.0))
    air = bodies.node()
    bodies.link(ring[-1], air, np.linspace(0.001, 0.01, 21).reshape(7, 3))
    bodies.hold(ring[0, :2], 3.0, 300.0)
    bodies.hold(air, 0.1, 280.0)
    bodies.hold(apart[-1], 1.0, 290.0)
    direct = bodies.solve()
    monkeypatch.setattr(finite_volumes, "DIRECT", 0)
    iterated = bodies.solve()
    assert np.ptp(direct[0]) > 5.0
    for one, other in zip(iterated, direct, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)


def test_areas_add_up():
    ball = spherical(np.linspace(0.0, 2.0, 5), np.linspace(0.0, math.pi, 9), np.linspace(0.0, 0.5 * math.pi, 4), 1.0)
    assert ball.area[0][-1].sum() == pytest.approx(math.pi * 4.0, rel=1e-14)  # a quarter of the sphere
    disc = cylindrical(np.linspace(0.0, 2.0, 5), np.linspace(0.0, 2.0 * math.pi, 4), [0.0, 1.0], 1.0)
    assert disc.area[2][:, :, 0].sum() == pytest.approx(math.pi * 4.0, rel=1e-14)


def test_edges_must_grow():
    with pytest.raises(BadInput, match="edges of axis 1"):
        cylindrical([0.0, 1.0], [0.0, 1.0, 0.5], [0.0, 1.0], 1.0)


def fin(n):
    """Heat in W into a rod, 50 mm by 4 mm diameter, h = 200 W/(m2.K), its end insulated, root 10 K above the air."""
    x = np.linspace(0.0, 0.05, n + 1)
    rod = cylindrical([0.0, 2e-3], [0.0, 2.0 * math.pi], x, 46.0)
    bodies = Bodies()
    index = bodies.add(rod)
    bodies.hold(index[:, :, 0], 1.0 / rod.half[2][0][:, :, 0], 303.15)
    bodies.hold(index.ravel(), 200.0 * math.pi * 4e-3 * np.diff(x), 293.15)
    return bodies.solve()[1]


def test_a_fin_with_second_order():
    """sqrt(h P k A) tanh(m L), with convection from the cells' middles as in one dimension."""
    m = math.sqrt(200.0 * 4.0 / (46.0 * 4e-3))
    exact = math.sqrt(200.0 * math.pi * 4e-3 * 46.0 * math.pi * 4e-6) * math.tanh(m * 0.05) * 10.0
    cells = np.array([10, 20, 40, 80])
    heat = np.array([fin(n) for n in cells])
    np.testing.assert_allclose(heat.sum(axis=1), 0.0, rtol=0.0, atol=ROUND * exact)
    errors = np.abs(heat[:, 0] - exact)
    assert errors[-1] < 3e-4 * exact
    assert -slope(cells, errors) == pytest.approx(2.0, abs=0.1)


def test_radiation_of_a_plate_between_two_temperatures():
    """A thin plate sees 600 K on one side and 300 K on the other: T⁴ is the mean."""
    bodies = Bodies()
    plate, hot, cold = bodies.node(), bodies.node(), bodies.node()
    for node, temperature in ((hot, 600.0), (cold, 300.0)):
        bodies.hold(node, 1e6, temperature)
        bodies.radiate(plate, node, 0.01)
    bodies.link(plate, hot, 0.0)  # a network must have a link
    found, heat = bodies.solve()
    assert found[plate] == pytest.approx((0.5 * (600.0**4 + 300.0**4)) ** 0.25, rel=1e-6)  # 1e6 W/K over 34 W
    assert heat[0] == pytest.approx(5.670374419e-8 * 0.01 * 0.5 * (600.0**4 - 300.0**4), rel=1e-6)


def test_radiation_that_does_not_settle_is_an_error():
    """1 kW into a node that radiates only: T = P / (c T³), in which every round triples an error."""
    bodies = Bodies()
    hot, cold = bodies.node(), bodies.node()
    bodies.hold(cold, 1e6, 300.0)
    bodies.hold(hot, 1e-3, 1e6)
    bodies.radiate(hot, cold, 0.01)
    bodies.link(hot, cold, 0.0)
    with pytest.raises(RuntimeError, match="radiation"):
        bodies.solve()


def spot(n, across=1.0, size=150.0):
    """Resistance times k of an isothermal ellipse, semi-axes 1 and `across`, on a tall cylinder; cells at its edge of 1/(4 n)."""
    first, growth, along = 0.25 / n, 1.0 + 1.0 / n, 1.0
    inner = along - graded(first, growth, along)[::-1]
    inner[0] = 0.0
    edges = np.linspace(along, across, round((across - along) / first) + 1)
    rho = np.concatenate([inner, edges[1:], across + graded(first, growth, size - across)[1:]])
    phi = [0.0, 0.5 * math.pi] if along == across else graded(0.5 / across / n, 1.0 + 0.5 / n, 0.5 * math.pi)
    body = cylindrical(rho, phi, graded(first, growth, size), 1.0)
    middle = 0.5 * (np.asarray(phi)[:-1] + np.asarray(phi)[1:])
    edge = 1.0 / ((np.cos(middle) / across) ** 2 + (np.sin(middle) / along) ** 2)
    share = np.clip((edge - rho[:-1, None] ** 2) / np.diff(rho**2)[:, None], 0.0, 1.0)
    bodies = Bodies()
    index = bodies.add(body)
    bodies.hold(index[:, :, 0], share / body.half[2][0][:, :, 0], 1.0)
    bodies.hold(index[:, :, -1], 1.0 / body.half[2][1][:, :, -1], 0.0)
    return 1.0 / (4.0 * bodies.solve(0.0)[1][0]) - size / (math.pi * size**2)


def test_a_circle_on_a_half_space_by_refinement():
    """1/(4 a) with the tube's first-order term taken off; the flux is singular at the edge, so the order is 1."""
    exact = constriction(1.0, 1.0, 1.0) - finite_ring(150.0, 1.0)
    n = np.array([2, 4, 8, 16])
    found = np.array([spot(i) for i in n])
    errors = found - exact
    assert (errors > 0.0).all()
    assert -slope(n, errors) == pytest.approx(1.1, abs=0.15)
    extrapolated = 2.0 * found[-1] - found[-2]
    assert extrapolated == pytest.approx(exact, rel=3e-3)  # what order 1 leaves after extrapolation, a tenth of the last error


def test_a_tube_takes_off_what_yovanovich_says():
    """The same grid with a wide and a narrow tube: the difference is the closed form's, discretisation cancels."""
    wide, narrow = spot(8), spot(8, 1.0, 10.0)
    expected = finite_ring(10.0, 1.0) - finite_ring(150.0, 1.0)
    assert wide - narrow == pytest.approx(expected, rel=0.03)  # next term 0.34 (a/b)³ of 1.41 a/b: 0.3 %; grids differ a little


@pytest.mark.full
def test_an_ellipse_on_a_half_space_by_refinement():
    """Semi-axes 1 and 6. Its edge cuts the cells, so the error need not fall evenly."""
    exact = constriction(6.0, 1.0, 1.0) - finite_ring(900.0, 1.0)
    errors = [abs(spot(n, 6.0, 900.0) / exact - 1.0) for n in (1, 2, 3)]
    assert errors[2] < errors[1] < errors[0]
    assert errors[2] < 0.025


# -- the path ----------------------------------------------------------------------------------------------------------
RADIUS = 4e-3


def bare_ball(ratio, fineness):
    """Resistance of a ball between two discs that conduct a thousand times better; cells at the edge of radius/fineness^1.5."""
    spot_radius = ratio * RADIUS
    part = RingPart(spot_radius, spot_radius, (RADIUS, RADIUS), 4.0 * RADIUS, math.pi * (8.0 * RADIUS) ** 2, 46e3)
    return 1.0 / solve_path(part, part, RADIUS, 46.0, fineness=fineness).conductance


@pytest.mark.first
@pytest.mark.parametrize("ratio", [0.05, 0.1])
def test_a_ball_against_its_closed_form(ratio):
    """By refinement and extrapolation; the discs add a thousandth of the constriction."""
    a = ratio * RADIUS
    closed = 2.0 * (constriction(a, a, 46.0) * 1.001 + ball_spreading(a, a, RADIUS, 46.0))
    cells = np.array([2.0, 3.0, 4.0, 6.0]) ** -1.5
    found = np.array([bare_ball(ratio, n) for n in (2, 3, 4, 6)])
    assert slope(cells, found / closed - 1.0) == pytest.approx(1.0, abs=0.15)
    extrapolated = found[3] - (found[2] - found[3]) * cells[3] / (cells[2] - cells[3])
    assert extrapolated == pytest.approx(closed, rel=0.004)
    # what the ball adds behind the spots is 6 to 9 %: more than the error that is left
    assert closed > 1.05 * 2.0 * constriction(a, a, 46.0)


def part(load_scale=1.0, conductivity=46.0):
    """A ring's part with a slender contact, nearly that of a 7008C under 1 kN."""
    return RingPart(8e-5 * load_scale, 5e-4 * load_scale, (3.4e-3, 0.1), 3.5e-3, 1.4e-4, conductivity)


@cache
def path(load_scale=1.0, **around):
    """The path with that part at both rings, coarse."""
    return solve_path(part(load_scale), part(load_scale), RADIUS, 46.0, Surroundings(**around), fineness=3)


def test_what_comes_in_goes_out():
    for around in ({}, {"gas_conductivity": 0.026}, {"convection": 20.0, "emissivity": 0.5, "gas_conductivity": 0.1}):
        assert abs(path(**around).imbalance) < 1e-6  # residual of the conjugate gradients over a heat flow through few cells


def test_more_paths_conduct_more():
    bare, gas = path().conductance, path(gas_conductivity=0.026).conductance
    everything = path(gas_conductivity=0.026, convection=50.0, emissivity=0.8).conductance
    assert bare < gas < everything


def test_without_contact_and_gas_only_air_and_radiation_are_left():
    """The ball floats: ring - air - ring, two convection resistances in series over all of a ring's face, beside radiation."""
    open_ = solve_path(part(0.0), part(0.0), RADIUS, 46.0, Surroundings(convection=10.0), fineness=3)
    assert open_.conductance == pytest.approx(0.5 * 10.0 * 1.4e-4, rel=2e-3)  # the ring's own resistance: 1e-3 of it
    radiating = solve_path(part(0.0), part(0.0), RADIUS, 46.0, Surroundings(emissivity=0.5), (350.0, 300.0), fineness=3)
    assert radiating.conductance * 50.0 == pytest.approx(0.25 * 5.670374419e-8 * 1.4e-4 * (350.0**4 - 300.0**4), rel=2e-3)


def test_the_ball_is_between_its_rings():
    coldest, mean, hottest = path().ball
    assert 293.15 < coldest < mean < hottest < 303.15
    assert mean == pytest.approx(298.15, abs=1e-4)  # both ends are alike


def test_resistance_times_cube_root_of_load_is_nearly_constant():
    """Twice the contact's size, eight times the load: half the constriction, while ball and rings stay."""
    once, twice = path(1.0), path(2.0)
    behind = 2.0 * (3.5e-3 / (46.0 * 1.4e-4) - finite_ring(math.sqrt(1.4e-4 / math.pi), 46.0))
    spreading = [2.0 * ball_spreading(8e-5 * s, 5e-4 * s, RADIUS, 46.0) for s in (1.0, 2.0)]
    constrictions = [1.0 / p.conductance - behind - s for p, s in zip((once, twice), spreading, strict=True)]
    assert constrictions[0] / constrictions[1] == pytest.approx(2.0, rel=0.02)
    assert constrictions[0] == pytest.approx(4.0 * constriction(5e-4, 8e-5, 46.0), rel=0.03)


# -- the whole bearing -------------------------------------------------------------------------------------------------
DIAMETERS = (0.04, 0.0463, 0.0617, 0.068)


def walls(conductivity):
    """Resistance of both rings of `DIAMETERS`, 15 mm wide, K/W."""
    logs = math.log(DIAMETERS[1] / DIAMETERS[0]) + math.log(DIAMETERS[3] / DIAMETERS[2])
    return logs / (2.0 * math.pi * conductivity * 0.015)


def test_rings_with_equal_balls_are_walls_in_series():
    balls = np.full(16, 0.015)
    expected = 1.0 / (walls(46.0) + 1.0 / balls.sum())
    assert solve_rings(balls, DIAMETERS, 0.015, 46.0) == pytest.approx(expected, rel=1e-9)  # nothing flows round: exact


def test_rings_with_unequal_balls_lie_between_two_bounds():
    """Raceways at one temperature each, or no heat round the rings at all."""
    balls = np.zeros(16)
    balls[[0, 1, 15]] = 0.3, 0.1, 0.1
    found = solve_rings(balls, DIAMETERS, 0.015, 46.0)
    isothermal = 1.0 / (walls(46.0) + 1.0 / balls.sum())
    separate = sum(1.0 / (16.0 * walls(46.0) + 1.0 / g) for g in balls if g)
    assert 1.001 * separate < found < 0.999 * isothermal
    assert solve_rings(balls, DIAMETERS, 0.015, 46e6) == pytest.approx(balls.sum(), rel=1e-5)  # walls that cost nothing
    assert solve_rings(np.roll(balls, 5), DIAMETERS, 0.015, 46.0) == pytest.approx(found, rel=1e-9)


def test_a_bearing_without_load_and_surroundings_conducts_nothing():
    made = AngularContactConductance()
    made.initialize(0.0)
    assert abs(solve_bearing(made, 40e-3, 68e-3)) < 1e-11  # rounding of rings that conduct 20 W/K


def test_a_bearing_with_equal_loads_is_its_balls_in_parallel():
    made = AngularContactConductance((), {"axial_force": 1000.0})
    made.initialize(0.0)
    lumped = AngularContactConductance(("ball_bulk", "ring_walls"), {"axial_force": 1000.0})
    lumped.initialize(0.0)
    assert solve_bearing(made, 40e-3, 68e-3, fineness=3) == pytest.approx(lumped["conductance"], rel=0.03)  # grid 2 %, rings 1 %
