"""Bearings as tables for a rotor: the film against quadrature of its pressure, a published example and thresholds in closed form;
the ball bearing's tangents against differences of its equilibrium."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.short_bearing import ShortBearing, film_load, film_state
from cosimo.components.core.errors import BadInput
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.modal import eigenvalues
from cosimo.orchestrator.systems.bearings.support_tables import ANGLES, ball_rows, film_rows, save
from cosimo.tests.commands import exit_code

pytestmark = pytest.mark.interpreted

BEARING = ShortBearing(0.1, 0.03, 1e-4, 0.1)
RPM = math.pi / 30.0
DAMPER = {"damping.factor": 1e-5}


def film_force(bearing: ShortBearing, place, velocity, speed: float) -> np.ndarray:
    """Force on the journal, N: the pressure of Reynolds' equation over the half in which the gap narrows, by the trapezoidal rule."""
    e, angle = math.hypot(*place) / bearing.clearance, math.atan2(place[1], place[0])
    out = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-out[1], out[0]])
    rate, turn = (out @ velocity) / bearing.clearance, (across @ velocity) / math.hypot(*place)
    a = np.linspace(-math.pi, 0.0, 40001)
    gap = bearing.clearance * (1.0 - e * np.cos(a))
    squeezed = bearing.clearance * (rate * np.cos(a) + e * (turn - 0.5 * speed) * np.sin(a))  # -dh/dt and the wedge's part
    pressure = bearing.viscosity * bearing.length**3 * squeezed / gap**3  # over the length, N/m
    return sum(
        -np.trapezoid(pressure * f, a) * 0.5 * bearing.diameter * way for f, way in ((np.cos(a), out), (np.sin(a), across))
    )


@pytest.mark.parametrize("load", [(0.0, -525.0), (3.0, 1.0), (-4e4, 1e3)])
def test_the_film_is_that_of_reynolds_equation(load):
    """Equilibrium, stiffness and damping, at relative eccentricities of 0.002, 0.27 and 0.9."""
    speed = 1500.0 * RPM
    state = film_state(BEARING, load, speed)
    angle = math.atan2(load[1], load[0]) + state.attitude
    place = BEARING.clearance * state.eccentricity * np.array([math.cos(angle), math.sin(angle)])
    still = np.zeros(2)
    np.testing.assert_allclose(film_force(BEARING, place, still, speed), -np.array(load), atol=1e-7 * math.hypot(*load))
    away, quick = 1e-4 * BEARING.clearance * state.eccentricity, 1e-6
    stiffness, damping = np.zeros((2, 2)), np.zeros((2, 2))
    for k, way in enumerate(np.eye(2)):
        ends = [film_force(BEARING, place + sign * away * way, still, speed) for sign in (1.0, -1.0)]
        stiffness[:, k] = (ends[1] - ends[0]) / (2.0 * away)
        ends = [film_force(BEARING, place, sign * quick * way, speed) for sign in (1.0, -1.0)]
        damping[:, k] = (ends[1] - ends[0]) / (2.0 * quick)
    np.testing.assert_allclose(state.stiffness, stiffness, atol=1e-6 * np.abs(stiffness).max())
    np.testing.assert_allclose(state.damping, damping, atol=1e-7 * np.abs(damping).max())


def test_friswells_example_5_5_1():
    """Numbers as the tests and the documentation of ROSS 2.3.0 have them of the book."""
    state = film_state(BEARING, (0.0, -525.0), 1500.0 * RPM)
    assert state.eccentricity == pytest.approx(0.2663, abs=5e-5)
    np.testing.assert_allclose(state.stiffness / 1e6, [[12.81, 16.39], [-25.06, 8.815]], rtol=5e-4)
    np.testing.assert_allclose(state.damping / 1e3, [[232.9, -81.92], [-81.92, 294.9]], rtol=5e-4)
    assert 1.0 / film_load(state.eccentricity) == pytest.approx(1.009798, abs=5e-7)


@pytest.mark.parametrize(("speed", "flexible"), [(30.0, False), (300.0, False), (3000.0, False), (300.0, True)])
def test_a_jeffcott_rotor_on_short_bearings_is_unstable_beyond_the_mass_of_the_closed_form(tmp_path, speed, flexible):
    """There, if it exists, K + i w C - k 1 is singular with k = m w² s / (s - m w²), s and m of half the shaft and half the mass."""
    load, length, diameter = 2000.0, 1.0, 0.05 if flexible else 0.4
    rows = film_rows(BEARING, (0.0, -load), [speed])
    (kxx, kxy), (kyx, kyy) = rows[0].stiffness
    (cxx, cxy), (cyx, cyy) = rows[0].damping
    k = (kxx * cyy + kyy * cxx - kxy * cyx - kyx * cxy) / (cxx + cyy)
    whirl2 = ((kxx - k) * (kyy - k) - kxy * kyx) / (cxx * cyy - cxy * cyx)
    second, area = math.pi / 64.0 * diameter**4, math.pi / 4.0 * diameter**2
    kappa = 6.0 * 1.3 / (7.0 + 6.0 * 0.3)
    bending, sheared = length**3 / (48.0 * 2.08e11 * second), length / (4.0 * kappa * 8e10 * area)
    s = 0.5 / (bending + sheared)
    threshold = float(k * s / (whirl2 * (s + k)))
    assert (k / s > 0.3) == flexible
    table = save(rows, 0.0, tmp_path).read_text()
    numbers = table.splitlines()[-1]
    assert (threshold < 0.0) == (speed == 30.0)  # so heavily loaded that no mass is too large
    for share, stable in ((0.999, True), (1.001, False)) if threshold > 0.0 else ((-1e-2, True), (-1e2, True)):
        rotor = BeamRotor(
            ("disks", "disk_table", "support_table"),
            {
                "length": length,
                "outer_diameter": diameter,
                "youngs_modulus": 2.08e11,
                "shear_modulus": 8e10,
                "density": 1e-4,
                "element": 0.5,
                "start_speed": speed,
                "disk_table.table": f"position [m],mass [kg],Ip [kg.m2],Id [kg.m2]\n0.5,{2.0 * share * threshold},0,0\n",
                "support_table.table": table + f"{length}{numbers[numbers.index(',') :]}\n",
            },
        )
        rotor.initialize(0.0)
        assert (eigenvalues(rotor.matrices(), speed).real.max() < 0.0) == stable


def test_hard_films():
    light = film_state(BEARING, (0.0, -1e-6), 100.0)
    assert light.eccentricity == pytest.approx(
        4e-6 / math.pi / (0.1 * 0.03**3 * 0.1 / 2e-8 * 100.0), rel=1e-9
    )  # f = pi e B w / 4
    assert light.stiffness[0, 1] == pytest.approx(50.0 * light.damping[0, 0], rel=1e-6)  # whirl of half the speed
    heavy = film_state(BEARING, (0.0, -1e9), 100.0)
    assert 0.999 < heavy.eccentricity < 1.0
    assert np.isfinite(heavy.stiffness).all()
    mirrored = film_state(BEARING, (525.0, 0.0), 100.0).stiffness  # a load along x is one along -y, turned
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    np.testing.assert_allclose(mirrored, turn @ film_state(BEARING, (0.0, -525.0), 100.0).stiffness @ turn.T, rtol=1e-9)


@pytest.mark.parametrize(
    ("bearing", "load", "speed", "expected"),
    [
        (BEARING, (0.0, 0.0), 100.0, "a load, and a positive speed"),
        (BEARING, (0.0, -1.0), 0.0, "no film"),
        (BEARING, (0.0, -1.0), -10.0, "the other direction"),
        (BEARING, (0.0, math.nan), 10.0, "a load, and"),
        (BEARING._replace(clearance=0.0), (0.0, -1.0), 10.0, "clearance = 0"),
        (BEARING, (0.0, -1e30), 10.0, "a load that the film carries"),
        (BEARING._replace(clearance=0.06), (0.0, -1.0), 10.0, "far thinner than the journal"),
        (ShortBearing(100.0, 30.0, 0.1, 0.1), (0.0, -525.0), 10.0, "a diameter of 100 m.*Are these mm"),
    ],
)
def test_what_no_film_carries_is_refused(bearing, load, speed, expected):
    with pytest.raises(BadInput, match=expected):
        film_state(bearing, load, speed)


def test_balls_have_the_slope_of_their_equilibrium():
    """Mean over the places of the balls of the inverse of the compliance, from equilibria under loads a little apart."""
    load, given = np.array([100.0, -500.0, 0.0, 0.0, 0.0]), {"diametral_clearance": 5e-6}
    (row,) = ball_rows(given, ["damping"], "6205", (100.0, -500.0, 0.0), [0.0])
    bearing = DeepGrooveBearing([], given, preset="6205")
    bearing.initialize(0.0)
    found = []
    for k in range(ANGLES):
        bearing.x[1] = 2.0 * math.pi * k / (9 * ANGLES)
        compliance = np.zeros((2, 2))
        for axis in range(2):
            ends = []
            for sign in (1.0, -1.0):
                beside = load.copy()
                beside[axis] += sign * 0.01
                ends.append(bearing.equilibrium(beside, held=("z", "tilt_x", "tilt_y")).displacement[:2])
            compliance[:, axis] = (ends[0] - ends[1]) / 0.02
        found.append(np.linalg.inv(compliance))
    np.testing.assert_allclose(row.stiffness, np.mean(found, axis=0), rtol=1e-4)
    np.testing.assert_allclose(
        row.damping, 2.5e-5 * row.stiffness, rtol=0.05
    )  # without what turning contacts add to the stiffness


def test_balls_follow_the_speed_by_their_film_alone():
    given = {"diametral_clearance": 0.0}
    bare = ball_rows(given, [], "6205", (0.0, -500.0, 0.0), [0.0, 500.0])
    assert (bare[0].stiffness == bare[1].stiffness).all()
    assert not bare[0].damping.any()
    film = ball_rows(given, ["film"], "6205", (0.0, -500.0, 0.0), [0.0, 500.0])
    np.testing.assert_allclose(film[0].stiffness, bare[0].stiffness, rtol=1e-12)
    assert film[1].stiffness[0, 0] > 1.02 * bare[0].stiffness[0, 0]  # a film is a preload
    axial = ball_rows(given, [], "6205", (0.0, 0.0, 300.0), [0.0])[0].stiffness
    assert axial[0, 0] == pytest.approx(axial[1, 1], rel=1e-9)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["balls", "--load", "0,-500", "--preset", "6205", "--set", "ball_diametr=1"], "Did you mean 'ball_diameter'"),
        (["balls", "--load", "0,0", "--set", "diametral_clearance=10 um"], "no ball is loaded"),
        (["balls", "--load", "0"], "numbers along x and y and z"),
        (["balls", "--load", "0,-5e9"], "no equilibrium"),
        (["balls", "--load", "0,-500", "--speeds", "100 rpm,50 rpm"], "speeds that rise"),
        (["balls", "--load", "0,-500", "--effects", "flim"], "film"),
        (["balls", "--load", "0,-500", "--speeds", "nan"], "--speeds: got 'nan', expected a number"),
        (["balls", "--load", "0,-500", "--speeds", "1500 rpm,3000"], "3000 beside '1500 rpm', expected a unit at each number"),
        (["balls", "--load", "0,-0.5 kN,300"], "300 beside '-0.5 kN'"),
        (["film", "--load", "0,-500,1"], "across the shaft"),
    ],
)
def test_what_cannot_be_a_table_is_one_message(words, expected, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sizes = ["--speeds", "100 rpm", "--diameter", "0.1", "--length", "0.03", "--clearance", "1e-4", "--viscosity", "0.1"]
    assert exit_code("bearings", *words, *(sizes if words[0] == "film" else [])) == 2
    assert expected in capsys.readouterr().err


def test_a_table_of_the_command_is_one_of_the_rotor(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sizes = ["--diameter", "100 mm", "--length", "60 mm", "--clearance", "0.1 mm", "--viscosity", "0.1 Pa.s", "--position", "1 m"]
    assert exit_code("bearings", "film", "--load", "0,-525", "--speeds", "500 rpm,1500 rpm", *sizes, "-o", "out") == 0
    assert "0.6 diameters long" in capsys.readouterr().err
    rotor = BeamRotor(["support_table"], {"support_table.table": (tmp_path / "out" / "supports.csv").read_text()})
    rotor.initialize(0.0)
    node = 4 * int(np.abs(rotor.nodes - 1.0).argmin())
    held = rotor.matrices(1500.0 * RPM).stiffness
    expected = film_state(BEARING._replace(length=0.06), (0.0, -525.0), 1500.0 * RPM).stiffness
    loose = rotor.matrices(500.0 * RPM).stiffness
    there = slice(node, node + 2)
    base = loose[there, there] - film_state(BEARING._replace(length=0.06), (0.0, -525.0), 500.0 * RPM).stiffness
    np.testing.assert_allclose(held[there, there] - base, expected, rtol=1e-9)
