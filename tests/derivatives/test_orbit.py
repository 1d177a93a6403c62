"""Periodic orbits against closed forms and against shooting by SciPy; bifurcations where the multipliers of that say so, too."""

from __future__ import annotations

import json
import math
from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from scipy.integrate import solve_ivp

if COMPILED:
    from cosimo.orchestrator.derivatives.continuation import DOUBLING, FOLD, TORUS, orbits
    from cosimo.orchestrator.derivatives.orbit import Forcing, Shooting

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def alone(component: str, effects: list[str], step: float, **parameters):
    unit = {"component": component, "effects": effects, "parameters": parameters}
    return read_scene({"stop_time": 1.0, "units": {"unit": unit}, "master": {"step": step}})


def test_a_rotor_with_unbalance_whirls_as_the_closed_form():
    """e r² / sqrt((1 - r²)² + (2 D r)²), and multipliers exp(-D w0 T) in pairs; its angle tells the period."""
    scene = alone("JeffcottRotor", ["unbalance"], 1e-3)
    with cosimo.open(scene) as session:
        session.initialize()
        m, k, c, w = (session[f"unit.{name}"] for name in ("mass", "stiffness", "damping", "speed"))
        (branch,) = session.orbit().branches
    orbit = branch.points[0]
    w0, damping = math.sqrt(k / m), c / (2.0 * math.sqrt(k * m))
    r = w / w0
    amplitude = 1e-5 * r**2 / math.hypot(1.0 - r**2, 2.0 * damping * r)
    names = [f"unit.{name}" for name in ("displacement_x", "displacement_y")]
    signals = [".".join(end) for end in scene.coupling.signals]
    assert orbit.period == pytest.approx(2.0 * math.pi / w, rel=1e-9)
    for name in names:
        assert orbit.high[signals.index(name)] == pytest.approx(amplitude, rel=1e-3)  # of so many instants
    assert np.abs(orbit.multipliers) == pytest.approx(4 * [math.exp(-damping * w0 * orbit.period)], rel=1e-6)


def robot(amplitude: float, frequency: float, *effects: str, **parameters):
    driven = {"harmonic_force.amplitude": amplitude, "harmonic_force.frequency": frequency}
    return alone("PipeRobot", ["harmonic_force", *effects], 1e-3, **driven, **parameters)


@pytest.mark.parametrize(("amplitude", "frequency"), [(40.0, 60.0), (20.0, 110.0), (40.0, 85.0)])
def test_orbits_with_sticking_are_those_of_the_run(amplitude, frequency):
    """Friction that sticks for a part of the period: its mode at the start of the run is another."""
    scene = robot(amplitude, frequency)
    (branch,) = orbits(scene).branches
    period = 2.0 * math.pi / frequency
    steps = math.ceil(period / 1e-3)
    changes = {"master.step": period / steps, "stop_time": 200 * period}
    velocity = cosimo.run(scene.with_changes(changes), verify="no")["unit.velocity"][-steps:]
    orbit = branch.points[0]
    k = [".".join(end) for end in scene.coupling.signals].index("unit.velocity")
    assert [orbit.low[k], orbit.high[k]] == pytest.approx([velocity.min(), velocity.max()], abs=1e-3 * np.ptp(velocity))


def test_what_closes_once_and_not_again_is_no_orbit():
    """Sought from the very start, where the robot rests: the mode of friction there is another than a period later."""
    with ExitStack() as stack:
        shooting = Shooting(robot(40.0, 85.0), stack, Forcing())
        found = shooting.solve(shooting.start(None, 0))
        assert "its second period is not its first" in shooting.orbit(found).refused


def test_a_robot_that_sticks_all_the_time_is_refused_by_the_state_that_nothing_restores():
    """A force of 10 N at 20 rad/s does not overcome its friction: where it rests is where it was put."""
    with pytest.raises(BadInput, match=r"nothing restores unit.x\[1\] .* or a joint sticks all the time"):
        orbits(robot(10.0, 20.0))


def test_a_motion_that_nothing_restores_has_no_orbit_that_stands_alone():
    """Without friction the robot as a whole goes on at any speed."""
    scene = robot(20.0, 60.0, "smoothed_friction", "cubic_spring", forward_friction=0.0, backward_friction=0.0)
    with pytest.raises(BadInput, match=r"nothing restores unit.x\[[13]\] \(a multiplier of 1\)"):
        orbits(scene)


def monodromy(rates, y: np.ndarray, period: float, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """State behind a period and its derivative, by differences, with DOP853."""

    def behind(start):
        return solve_ivp(rates, (0.0, period), start, method="DOP853", rtol=1e-11, atol=1e-14 * np.ones(start.size)).y[:, -1]

    columns = [(behind(y + d) - behind(y - d)) / (2.0 * d.max()) for d in np.diag(steps)]
    return behind(y), np.array(columns).T


BALLS, RATIO = 8, 0.5 * (1.0 - 11.9e-3 / 52e-3)


def bearing(clearance: float = 10e-6):
    return cosimo.load_scene("ball-bearing-clearance").with_changes({"bearing.clearance.radial_clearance": clearance})


def bearing_rates(speed: float, angle: float, clearance: float = 10e-6):
    """m x'' + c x' + sum K delta^1.5 cos = W, written down independently; the cage begins at an angle."""

    def rates(t, y):
        at = angle + RATIO * speed * t + 2.0 * math.pi * np.arange(BALLS) / BALLS
        load = 1.334e10 * np.maximum(y[0] * np.cos(at) + y[1] * np.sin(at) - clearance, 0.0) ** 1.5
        force = np.array([196.0 - load @ np.cos(at), -load @ np.sin(at)])
        return np.concatenate([y[2:], (force - 200.0 * y[2:]) / 20.0])

    return rates


@pytest.mark.parametrize(("speed", "clearance"), [(200.0, 10e-6), (300.0, 10e-6), (130.0, 2e-6)])
def test_orbits_of_a_ball_bearing_are_those_of_scipy(speed, clearance):
    """Balls come into load and out of it during a period; at 2 um the motion is so small that angles hardly act in numbers of SI."""
    forcing = Forcing(angle="bearing.cage_angle", turns=BALLS)
    (branch,) = orbits(bearing(clearance).with_changes({"bearing.speed": speed}), forcing, steps=400).branches
    orbit = branch.points[0]
    start, angle = orbit.unknown[:4], orbit.unknown[4]
    assert orbit.period == pytest.approx(2.0 * math.pi / BALLS / (RATIO * speed), rel=1e-9)
    end, matrix = monodromy(bearing_rates(speed, angle, clearance), start, orbit.period, np.array([1e-10, 1e-10, 1e-7, 1e-7]))
    np.testing.assert_allclose(end - start, 0.0, atol=1e-5 * np.abs(start).max())
    expected = np.sort(np.abs(np.linalg.eigvals(matrix)))[::-1]
    np.testing.assert_allclose(np.abs(orbit.multipliers), expected, rtol=1e-3)
    assert orbit.stable == (expected[0] < 1.0)


def test_at_bifurcations_a_multiplier_of_scipy_lies_on_the_unit_circle():
    """Two folds, between which the branch turns back, and two Neimark-Sacker points, over the speed."""
    forcing = Forcing(angle="bearing.cage_angle", turns=BALLS)
    (branch,) = orbits(bearing(), forcing, ("bearing.speed", np.linspace(63.0, 66.6, 7)), steps=600).branches
    assert [mark.kind for mark in branch.marks] == [FOLD, FOLD, TORUS, TORUS]
    assert branch.marks[0].orbit.value > branch.marks[1].orbit.value
    for mark in branch.marks:
        orbit = mark.orbit
        rates = bearing_rates(orbit.value, orbit.unknown[4])
        _, matrix = monodromy(rates, orbit.unknown[:4], orbit.period, np.array([1e-10, 1e-10, 1e-7, 1e-7]))
        nearest = min(np.linalg.eigvals(matrix), key=lambda value: abs(abs(value) - 1.0))
        assert abs(nearest) == pytest.approx(1.0, abs=1e-3)
        assert (abs(nearest.imag) > 0.1) == (mark.kind == TORUS)


@pytest.mark.full
def test_at_a_period_doubling_a_branch_of_two_periods_begins_that_scipy_closes():
    """Between two doublings of the branch of one period that of two is stable; DOP853 comes back behind two periods."""
    forcing = Forcing(angle="bearing.cage_angle", turns=BALLS)
    study = orbits(bearing(), forcing, ("bearing.speed", np.linspace(73.8, 74.6, 9)), steps=400, doublings=1)
    doublings = [mark.orbit.value for mark in study.marks if mark.kind == DOUBLING and mark.orbit.period < 0.03]
    assert doublings == pytest.approx([74.112, 74.226], abs=2e-3)
    (twice,) = [branch for branch in study.branches if branch.multiple == 2]
    assert twice.ends[-1].startswith("merges with the branch of half its period at 74.226")
    assert len(twice.points) < 50  # not followed round and round, its halves exchanged
    orbit = next(point for point in twice.points if point.stable and doublings[0] + 0.02 < point.value < doublings[1] - 0.02)
    single = 0.5 * orbit.period
    y = orbit.unknown[:4]
    rates = bearing_rates(orbit.value, orbit.unknown[4])
    for _ in range(2):
        y = solve_ivp(rates, (0.0, single), y, method="DOP853", rtol=1e-10, atol=1e-14).y[:, -1]
    np.testing.assert_allclose(y, orbit.unknown[:4], atol=1e-3 * np.abs(orbit.unknown[:4]).max())
    assert np.abs(orbit.sections[0] - orbit.sections[1]).max() > 0.0


@pytest.mark.full
def test_motions_are_those_of_runs_by_scipy():
    """25 um: a section of one point at 150 rad/s, and two runs that part at the measured exponent at 190 rad/s."""
    forcing, clearance, periods = Forcing(angle="bearing.cage_angle", turns=BALLS), 25e-6, 400
    over = ("bearing.speed", np.linspace(150.0, 190.0, 5))
    motions = orbits(bearing(clearance), forcing, over, exponents=2000).motions
    assert [(m.kind, m.periods) for m in (motions[0], motions[-1])] == [("periodic", 1), ("chaotic", 0)]
    assert motions[0].exponent == pytest.approx(-5.0, rel=1e-3)  # a pair of multipliers: half of the damping over the mass
    found, sizes = {}, np.array([1e-5, 1e-5, 1e-3, 1e-3])
    for speed in (150.0, 190.0):
        single, rates = 2.0 * math.pi / BALLS / (RATIO * speed), bearing_rates(speed, 0.0, clearance)

        def both(t, y, rates=rates):
            return np.concatenate([rates(t, y[:4]), rates(t, y[4:])])

        y, growth, section = np.array([3e-5, 0.0, 0.0, 0.0]), np.zeros(periods), np.zeros((periods, 4))
        apart = np.array([1e-7, 0.0, 0.0, 0.0])
        for k in range(periods):
            end = solve_ivp(
                both, (0.0, single), np.concatenate([y, y + apart * sizes]), method="DOP853", rtol=1e-8, atol=1e-15
            ).y[:, -1]
            y, apart = end[:4], (end[4:] - end[:4]) / sizes
            growth[k], apart, section[k] = math.log(np.linalg.norm(apart) / 1e-7), 1e-7 * apart / np.linalg.norm(apart), y
        means = [part.mean() / single for part in np.array_split(growth[periods // 4 :], 15)]
        found[speed] = np.mean(means), 2.0 * np.std(means, ddof=1) / math.sqrt(15), np.ptp(section[-50:], axis=0) / sizes
    assert found[150.0][2].max() < 1e-3
    assert found[150.0][0] == pytest.approx(-5.0, abs=0.1)
    exponent, error, spread = found[190.0]
    assert spread.min() > 0.1
    assert exponent - error > 0.0
    assert abs(exponent - motions[-1].exponent) < 1.5 * math.hypot(error, motions[-1].error)


def test_a_map_of_orbits_over_two_parameters(tmp_path, capsys):
    over = ("--over", "bearing.speed=100:120:3", "--over", "bearing.clearance.radial_clearance=10e-6,25e-6", "--exponents", "200")
    assert exit_code("orbit", "ball-bearing-clearance", *over, "-o", tmp_path, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert [row["value"] for row in data["rows"]] == [10e-6, 25e-6]
    first, second = ([motion[:4] for motion in row["motions"]] for row in data["rows"])
    assert first == [[100.0, "periodic", 1, 1], [110.0, "periodic", 1, 1], [120.0, "periodic", 1, 1]]
    assert second[-1] == [120.0, "chaotic", 0, 0]
    assert len((tmp_path / "motions.csv").read_text().splitlines()) == 7
    page = (tmp_path / "report.html").read_text()
    assert "largest exponent" in page
    assert all(axis in page for axis in ("bearing.speed, rpm", "bearing.clearance.radial_clearance, µm"))


def test_what_has_no_orbit_is_refused_with_the_reason():
    with pytest.raises(BadInput, match="sampled controller"):
        orbits(cosimo.load_scene("gimbal-scan"))
    with pytest.raises(BadInput, match="angle"):
        orbits(bearing(), Forcing(angle="bearing.cage"))
    with pytest.raises(BadInput, match="Hz or rad/s"):
        orbits(bearing(), Forcing(frequency="bearing.mass"))
    with pytest.raises(BadInput, match="no orbit of 1 period"):
        orbits(bearing(), Forcing(period=0.013), after=5)
    with pytest.raises(BadInput, match="two at least"):
        orbits(bearing(), Forcing(angle="bearing.cage_angle", turns=8), ("bearing.speed", [60.0]))


def test_the_command_writes_tables_and_a_page_by_the_section_of_the_scene(tmp_path, capsys):
    clearance = ("--set", "bearing.clearance.radial_clearance=10e-6")
    options = (*clearance, "--over", "bearing.speed=62:68:7", "-o", str(tmp_path), "--json")
    assert exit_code("orbit", "ball-bearing-clearance", *options) == 0
    (branch,) = json.loads(capsys.readouterr().out)["branches"]
    kinds = [mark["kind"] for mark in branch["bifurcations"]]
    assert kinds == ["fold", "fold", "Neimark-Sacker", "Neimark-Sacker", "fold", "fold"]
    assert (tmp_path / "bifurcations.csv").read_text().count("fold") == 4
    assert "unstable" in (tmp_path / "orbits.csv").read_text()
    page = (tmp_path / "report.html").read_text()
    assert "Neimark-Sacker" in page
    assert "bearing.speed, rpm" in page
