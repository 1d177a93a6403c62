"""What steps of the ball bearing must see, and what tolerances and rounding do to its motion."""

import math
import re

import numpy as np
import pytest
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.bearings.dimensionless import dimensionless
from cosimo.components.bearings.two_dof import bearing_derivatives
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.tests.support import RPM, ball_bearing
from scipy.integrate import solve_ivp


def with_gap(micrometres, rpm=1000.0, **inputs):
    return ball_bearing(["clearance"], {"clearance.radial_clearance": 1e-6 * micrometres}, rpm, **inputs)


def run(bearing, duration, h=1e-3):
    """Outputs at the end of every step by name, each (n,)."""
    rows = []
    for k in range(round(duration / h)):
        bearing.step(k * h, h)
        rows.append(bearing.y.copy())
    return dict(zip(bearing.outputs, np.array(rows).T, strict=True))


@pytest.mark.full
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


@pytest.mark.full
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


@pytest.mark.full
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


@pytest.mark.full
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


@pytest.mark.full
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


@pytest.mark.full
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


@pytest.mark.full
def test_ten_million_steps_do_not_drift_the_angle():
    """Against the angle in extended precision. Each step rounds once, at most half a unit of 2 pi: 4.4e-16 rad."""
    speed, h, steps = 314.159, 1e-5, 1000
    alone = {"balls": 1, "clearance.radial_clearance": 1.0, "substep": h}
    bearing = ball_bearing(["clearance"], alone, rpm=speed / RPM, load=0.0)
    for k in range(10_000):
        bearing.step(k * steps * h, steps * h)
    assert bearing.work["steps"] == 10_000_000
    turn, cage = np.longdouble("6.28318530717958647692528676655900577"), bearing.arguments[0].constants.cage_ratio
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


@pytest.mark.full
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


@pytest.mark.full
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
