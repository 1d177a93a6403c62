"""Hard cases of the ball bearing with two degrees of freedom."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.bearings.dimensionless import dimensionless
from cosimo.components.bearings.two_dof import bearing_derivatives, constants
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.tests.support import RPM, ball_bearing
from scipy.integrate import solve_ivp

pytestmark = pytest.mark.full


def with_gap(micrometres, rpm=1000.0, **inputs):
    return ball_bearing(["clearance"], {"clearance.radial_clearance": 1e-6 * micrometres}, rpm, **inputs)


def run(bearing, duration, h=1e-3):
    """Outputs at the end of every step by name, each (n,)."""
    rows = []
    for k in range(round(duration / h)):
        bearing.step(k * h, h)
        rows.append(bearing.y.copy())
    return dict(zip(bearing.outputs, np.array(rows).T, strict=True))


def test_zero_clearance_is_no_clearance():
    zero, off = with_gap(0.0), ball_bearing()
    run(zero, 0.1)
    run(off, 0.1)
    assert zero.y.tobytes() == off.y.tobytes()


@pytest.mark.parametrize("micrometres", [-1e-3, -5.0, -50.0])
def test_preload_needs_no_load(micrometres):
    """All balls carry K |c_r|^1.5, in balance with one another; nothing moves the shaft out of the middle."""
    bearing = with_gap(micrometres, rpm=3000.0, load=0.0)
    seen = run(bearing, 0.1)
    expected = 1.334e10 * (-1e-6 * micrometres) ** 1.5
    np.testing.assert_allclose(seen["max_ball_load"], expected, rtol=1e-9)  # rounding over the deformation of 1 nm
    assert (seen["loaded_balls"] == 8).all()
    assert np.abs(seen["displacement_x"]).max() < 1e-12 * 50e-6


def test_one_ball_on_the_line_of_the_load_carries_it():
    bearing = ball_bearing(["clearance"], {"balls": 1}, rpm=0.0)
    seen = run(bearing, 0.1)
    x = 10e-6 + (196.0 / 1.334e10) ** (2.0 / 3.0)
    np.testing.assert_allclose(seen["displacement_x"], x, rtol=1e-12)  # the start is the equilibrium, to rounding
    assert not seen["displacement_y"].any()  # no stiffness across, and nothing that pushes


@pytest.mark.parametrize("balls", [1, 2])
def test_balls_that_cannot_carry_the_load_let_the_shaft_fall(balls):
    """No ball in the load's direction: no equilibrium, and a start in the middle says so by falling."""
    bearing = ball_bearing(["clearance"], {"balls": balls, "start_cage_angle": 0.5 * math.pi}, rpm=0.0)
    assert (bearing["displacement_x"], bearing["displacement_y"]) == (0.0, 0.0)
    seen = run(bearing, 0.02)
    assert seen["displacement_x"][-1] > 100e-6
    assert np.isfinite(bearing.x).all()


def test_a_single_turning_ball_hits_and_lets_go():
    bearing = ball_bearing(["clearance"], {"balls": 1, "damping": 2e4}, rpm=3000.0)
    seen = run(bearing, 0.2)
    assert set(np.unique(seen["loaded_balls"])) == {0.0, 1.0}
    assert seen["max_ball_load"].min() == 0.0


def test_the_exponent_at_zero():
    """Deformation zero, a rounding error below it, and denormal: force zero or tiny, never NaN."""
    bearing = with_gap(10.0, rpm=0.0, load=0.0)
    dx = np.empty(6)
    for delta in (0.0, -1e-21, -1e-5, 1e-21, 5e-324, 1e-12):
        x = np.array([10e-6 + delta, 0.0, 0.0, 0.0, 0.0, 0.0])
        bearing_derivatives(0.0, x, bearing.u[0], dx, *bearing.arguments)
        present = x[0] - 10e-6
        assert dx[2] == pytest.approx(-1.334e10 * max(present, 0.0) ** 1.5 / 20.0, rel=1e-12)
        assert np.isfinite(dx).all()


@pytest.mark.parametrize("effect", ["inner_defect", "outer_defect", "ball_defect"])
def test_a_pit_narrower_than_a_step_is_refused(effect):
    with pytest.raises(BadInput, match=r"substep = 5e-05 .*at most .*Reduce substep or widen the defect"):
        ball_bearing([effect], {f"{effect}.width": 1e-3}, rpm=3000.0)
    ball_bearing([effect], {f"{effect}.width": 1e-3}, rpm=0.0)  # at rest nothing passes it
    ball_bearing([effect], {f"{effect}.width": 1e-3, "substep": 1e-7}, rpm=-3000.0)


def test_steps_become_shorter_where_the_speed_outgrows_a_pit():
    """At rest any step sees the pit. At 400 rad/s a ball passes it in 32 us, less than the given step of 50 us."""
    pit, effects = {"outer_defect.width": 0.005, "outer_defect.depth": 3e-6}, ("clearance", "outer_defect")

    def displacement(effects, parameters):
        bearing = ball_bearing(effects, parameters, rpm=0.0)
        bearing.set("speed", 400.0)
        return run(bearing, 0.1)["displacement_x"], bearing.work["steps"]

    seen, steps = displacement(effects, pit)
    fine, _ = displacement(effects, pit | {"substep": 5e-7})
    without, given = displacement(effects[:1], {})
    assert given == 2000
    assert steps == 100 * math.ceil(1e-3 / (0.25 * 0.005 / (0.5 * (1.0 - 11.9 / 52.0) * 400.0)))  # a quarter of the passage
    # what the pit does to the motion is there: 2 % of it is the accuracy of eight points over a raised cosine
    assert np.abs(fine - without).max() > 1e-9
    assert np.abs(seen - fine).max() < 0.02 * np.abs(fine - without).max()


@pytest.mark.parametrize(("ring", "share"), [("inner", 0.5 * (1.0 + 11.9 / 52.0)), ("outer", 0.5 * (1.0 - 11.9 / 52.0))])
def test_a_wave_shorter_than_a_step_is_refused(ring, share):
    """801 waves at 3000 rpm: a ball passes half of one in 20 or 33 us; the given 50 us would see other waves instead."""
    waves = {f"{ring}_waviness.order[2]": 801, f"{ring}_waviness.amplitude[2]": 1e-7}
    needed = 0.25 * math.pi / 801.0 / (share * 3000.0 * RPM)  # a quarter of the passage of half a wave
    with pytest.raises(BadInput, match=rf"at most {needed:.3g}, .*half a wave of {ring}_waviness of order 801"):
        ball_bearing([f"{ring}_waviness"], waves, rpm=3000.0)
    ball_bearing([f"{ring}_waviness"], waves | {"substep": 0.99 * needed}, rpm=3000.0)
    ball_bearing([f"{ring}_waviness"], waves | {f"{ring}_waviness.amplitude[2]": 0.0}, rpm=3000.0)  # left out: nothing to see


def test_steps_become_shorter_where_the_speed_outgrows_a_wave():
    """The first step that follows a wave of a high order moves the shaft as many short ones do, and a long one does not."""
    waves = {"outer_waviness.order[1]": 801, "outer_waviness.amplitude[1]": 1e-6, "clearance.radial_clearance": -5e-6}

    def moved(**given):
        bearing = ball_bearing(["clearance", "outer_waviness"], waves | given, rpm=0.0)
        bearing.set("speed", 3000.0 * RPM)
        return run(bearing, 0.02)["displacement_x"], bearing.work["steps"]

    seen, steps = moved()
    fine, _ = moved(substep=5e-7)
    assert steps == 20 * math.ceil(1e-3 / (0.25 * math.pi / 801.0 / (0.5 * (1.0 - 11.9 / 52.0) * 3000.0 * RPM)))
    # eight points a wave, as for a pit
    assert np.abs(seen - fine).max() < 0.02 * np.ptp(fine)


def test_the_speed_within_a_step_counts_not_only_that_at_its_ends():
    """Up to 400 rad/s and back to 0 within one step; and against a ramp, whose end is the fastest moment."""
    pit, passage = {"outer_defect.width": 0.005}, 0.25 * 0.005 / (0.5 * (1.0 - 11.9 / 52.0) * 400.0)
    bearing = ball_bearing(["outer_defect"], pit, rpm=0.0)
    bearing.u[:, bearing.inputs.index("speed")] = 0.0, 1600.0 / 0.01, -1600.0 / 0.01**2
    bearing.step(0.0, 0.01)
    assert bearing.work["steps"] == math.ceil(0.01 / passage)
    ramp = {"speed_ramp.acceleration": 1e5, "speed_ramp.duration": 0.004}
    bearing = ball_bearing(["outer_defect", "speed_ramp"], pit | ramp, rpm=0.0)
    bearing.u[1, bearing.inputs.index("speed")] = -4e4
    bearing.step(0.0, 0.01)  # 0, then 240 rad/s at 4 ms, then 0
    assert bearing.work["steps"] == math.ceil(0.01 / (passage * 400.0 / 240.0))


LIGHT = {"mass": 0.1, "damping": 0.0, "clearance.radial_clearance": 10e-6}


def test_impacts_too_short_for_the_step_are_refused_at_the_start():
    """0.1 kg at 0.1 m/s: with 50 us most of the energy is gone in 0.1 s, and the run stays finite. None may go."""
    effects, moving = ["clearance", "given_start"], LIGHT | {"given_start.velocity_x": 0.1, "given_start.velocity_y": 3e-3}
    with pytest.raises(BadInput, match=r"substep = 5e-05; expected at most 2.*e-05.*impacts"):
        ball_bearing(effects, moving, rpm=0.0, load=0.0)
    bearing = ball_bearing(effects, moving | {"substep": 5e-6}, rpm=0.0, load=0.0)
    before = bearing.energy()
    run(bearing, 0.1)
    assert bearing.energy() == pytest.approx(before, rel=2e-3)  # RK4 across the openings of 260 contacts; measured 6e-4


@pytest.mark.parametrize("dimension", ["dimensional", "dimensionless"])
def test_impacts_that_become_too_short_stop_the_run(dimension):
    """A load that comes later: nothing is known of it at the start. The message says what the contact needs."""
    bearing = ball_bearing(["clearance"], LIGHT | {"damping": 1.0}, rpm=0.0, load=1e-3)
    h, length = 1e-3, 1.0
    if dimension == "dimensionless":
        bearing, by = dimensionless(bearing)
        bearing.initialize(0.0)
        h, length = 1e-3 / by.time, by.length
    bearing.set("load", bearing["load"] * 1e6)
    with pytest.raises(StepFailed, match=r"pressed in by .* Reduce substep to .* or less") as failed:
        bearing.step(0.0, h)  # 10 um are fallen through in 45 us
    deepest, needed = (float(v) for v in re.search(r"in by (\S+), .* to (\S+) or less", str(failed.value)).groups())
    assert needed < bearing["substep"]
    assert deepest * length > (1e3 / 1.334e10) ** (2.0 / 3.0)  # of one ball at rest under the load


def test_a_strong_contact_damper_needs_short_steps():
    """k = 1e4 s/m: at 196 N the damper alone decays with 1.5 k Q / m = 1.5e5 1/s, seven times within a step of 50 us."""
    strong = {"contact_damping.coefficient": 1e4}
    with pytest.raises(BadInput, match=r"substep = 5e-05; expected at most"):
        ball_bearing(["contact_damping"], strong)
    # at rest without a load nothing is pressed in; the load comes later
    bearing = ball_bearing(["clearance", "contact_damping"], strong, load=0.0)
    bearing.set("load", 196.0)
    with pytest.raises(StepFailed, match="Reduce substep"):
        run(bearing, 0.1)


def test_steps_become_shorter_along_a_ramp():
    ramp = {"speed_ramp.acceleration": 4e3, "speed_ramp.duration": 0.1, "outer_defect.width": 0.005}
    bearing = ball_bearing(["outer_defect", "speed_ramp"], ramp, rpm=0.0)
    done = [0]
    for k in range(150):
        bearing.step(k * 1e-3, 1e-3)
        done.append(bearing.work["steps"])
    per_step = np.diff(done)
    assert per_step[0] == 20  # the given substep
    assert (np.diff(per_step) >= 0).all()
    assert (per_step[100:] == 124).all()  # 1 ms over a quarter of 32.4 us


def test_without_speed_nothing_turns_and_nothing_moves():
    bearing = with_gap(20.0, rpm=0.0)
    before = bearing.y.copy()
    run(bearing, 0.5)
    np.testing.assert_allclose(bearing.y, before, rtol=1e-12, atol=1e-12)
    assert (bearing["inner_angle"], bearing["cage_angle"]) == (0.0, 0.0)


def test_reversed_speed_is_the_mirror_image():
    """y and all angles change sign. Sums of the balls' loads are taken in another order: rounding, not yet amplified."""
    forth, back = with_gap(2.0, rpm=1000.0), with_gap(2.0, rpm=-1000.0)
    a, b = run(forth, 0.1), run(back, 0.1)
    for name, sign in (("displacement_x", 1.0), ("displacement_y", -1.0), ("velocity_x", 1.0), ("velocity_y", -1.0)):
        np.testing.assert_allclose(b[name], sign * a[name], rtol=0.0, atol=1e-10 * np.abs(a[name]).max())
    assert back["inner_angle"] == pytest.approx(2.0 * math.pi - forth["inner_angle"], rel=1e-12)


def test_ten_million_steps_do_not_drift_the_angle():
    """Against the angle in extended precision. Each step rounds once, at most half a unit of 2 pi: 4.4e-16 rad."""
    speed, h, steps = 314.159, 1e-5, 1000
    alone = {"balls": 1, "clearance.radial_clearance": 1.0, "substep": h}
    bearing = ball_bearing(["clearance"], alone, rpm=speed / RPM, load=0.0)
    for k in range(10_000):
        bearing.step(k * steps * h, steps * h)
    assert bearing.work["steps"] == 10_000_000
    turn, cage = np.longdouble("6.28318530717958647692528676655900577"), constants(bearing.arguments[0]).cage_ratio
    for name, ratio in (("inner_angle", np.longdouble(1)), ("cage_angle", np.longdouble(cage))):
        exact = np.longdouble(bearing["speed"]) * ratio * np.longdouble(100)
        off = float((np.longdouble(bearing[name]) - exact) % turn)
        assert min(off, 2.0 * math.pi - off) < 1e7 * 4.4e-16
        assert 0.0 <= bearing[name] < 2.0 * math.pi


END = 0.1  # s


def by_scipy(bearing, end, **options):
    """Displacements found by SciPy on a fixed grid of times, (2, 400)."""
    dx = np.empty(bearing.x.size)

    def right_hand_side(t, x):
        bearing_derivatives(t, x, bearing.u[0], dx, *bearing.arguments)
        return dx.copy()

    found = solve_ivp(right_hand_side, (0.0, end), bearing.x, t_eval=np.linspace(0.0, end, 400), **options)
    assert found.success
    return found.y[:2]


def by_weight(mass, stiffness):
    """The bearing of 20 um clearance at 3000 rpm, and bearings of any mass and stiffness that are the same, dimensionless."""
    load, large = mass * 9.8, BallBearing()
    factor = (load / 196.0 * large["contact_stiffness"] / stiffness) ** (2.0 / 3.0)  # of the lengths
    faster = factor**-0.5  # of the frequencies, sqrt(W / (m x_s)), with the load the weight of the mass in both
    parameters = {
        "mass": mass,
        "contact_stiffness": stiffness,
        "clearance.radial_clearance": 20e-6 * factor,
        "damping": large["damping"] * mass / 20.0 * faster,
        "substep": large["substep"] / faster,
    }
    return ball_bearing(["clearance"], parameters, rpm=3000.0 * faster, load=load), END / faster


@pytest.fixture(scope="module")
def exact():
    """The dimensionless motion, (2, 400), and its swing."""
    other, by = dimensionless(by_weight(20.0, 1.334e10)[0])
    other.initialize(0.0)
    motion = by_scipy(other, END / by.time, method="DOP853", rtol=1e-12, atol=1e-12)
    return motion, np.ptp(motion, axis=1).max()


@pytest.mark.parametrize(("mass", "stiffness"), [(20.0, 1.334e10), (1e-6, 1e14)], ids=["20 kg", "1 mg on a huge stiffness"])
def test_the_tolerance_trap_of_small_lengths(mass, stiffness, exact):
    """SciPy's default absolute tolerance, 1e-6, in metres and dimensionless; the motions are the same but for the scales.

    In metres a relative tolerance of 1e-3 or of 1e-9 makes no difference: the absolute one decides, and it is a sixteenth
    of the swing of the large bearing, and two million times that of the small one. Dimensionless it means the same for both.
    """
    bearing, end = by_weight(mass, stiffness)
    other, by = dimensionless(bearing)
    other.initialize(0.0)
    motion, swing = exact
    metres = [np.abs(by_scipy(bearing, end, method="LSODA", rtol=r) / by.length - motion).max() / swing for r in (1e-3, 1e-9)]
    scaled = [np.abs(by_scipy(other, end / by.time, method="LSODA", rtol=r) - motion).max() / swing for r in (1e-3, 1e-9)]
    assert scaled[0] < 0.02
    assert scaled[1] < 1e-4
    assert metres[1] > 100.0 * scaled[1]
    assert metres[1] > 0.3 * metres[0]
    # the component's own fixed substep needs no tolerance, in either form
    h = end / 399.0
    seen = run(bearing, end, h)
    assert np.abs(seen["displacement_x"] / by.length - motion[0, 1:]).max() < 2e-3 * swing


def test_tiny_mass_on_a_huge_stiffness():
    """1 mg on 1e14 N/m^1.5: refused above its stable step, and one motion in both forms below it."""
    light = {"mass": 1e-6, "contact_stiffness": 1e14, "damping": 1e-3, "clearance.radial_clearance": 1e-8}
    with pytest.raises(BadInput, match="substep"):
        ball_bearing(["clearance"], light, load=1.0)
    limit = BallBearing(["clearance"], light | {"substep": 1e-9})
    limit.set("load", 1.0)
    light["substep"] = 0.05 * limit.stable_step()
    bearing = ball_bearing(["clearance"], light, rpm=60000.0, load=1.0)
    other, by = dimensionless(bearing)
    other.initialize(0.0)
    h = 100.0 * light["substep"]
    for k in range(20):
        bearing.step(k * h, h)
        other.step(k * h / by.time, h / by.time)
    assert np.isfinite(bearing.y).all()
    # roundings of 8000 evaluations, as for bearings of ordinary size
    assert other["displacement_x"] * by.length == pytest.approx(bearing["displacement_x"], rel=1e-10)
    assert 0.0 < bearing["displacement_x"] < 1e-6


def test_a_state_that_is_not_finite_stops_the_run():
    bearing = with_gap(20.0)
    bearing.set("load", math.inf)
    with pytest.raises(StepFailed, match="not finite"):
        bearing.step(0.0, 1e-3)


def test_chaos_is_bounded_and_repeats_to_the_last_bit():
    """Of a chaotic motion only this can be said: it stays between the races, and the same start is bit-identical."""
    first, second = with_gap(30.0), with_gap(30.0)
    seen = run(first, 2.0)
    run(second, 2.0)
    assert first.y.tobytes() == second.y.tobytes()
    radius = np.hypot(seen["displacement_x"], seen["displacement_y"])
    # energy of a fall through the whole clearance, as in stable_step: 2/5 K d^2.5 <= W (d + 2 c_r)
    assert radius.max() < 30e-6 + (2.5 * 196.0 / 1.334e10 * (60e-6 + 20e-6)) ** 0.4
