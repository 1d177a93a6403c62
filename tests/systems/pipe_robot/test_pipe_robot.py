"""Pipe robot: closed forms, an event-driven reference of other origin, balance of power and momentum, levels of bristles."""

import math
from itertools import product

import numpy as np
import pytest
from cosimo.components.pipe_robot.robot import PipeRobot, robot_derivatives
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from cosimo.tests.systems.pipe_robot.another_solver import reference
from scipy.linalg import expm
from scipy.optimize import brentq

pytestmark = pytest.mark.interpreted

G = 9.81


def robot(*effects: str, **parameters) -> PipeRobot:
    """With the effects of most tests, so that few kernels are compiled; the cubic share of the spring is zero."""
    values = {"cubic_spring.stiffness": 0.0} | {k.replace("__", "."): v for k, v in parameters.items()}
    return PipeRobot((*effects, "cubic_spring", "tow", "route"), values)


def started(*effects: str, **parameters) -> PipeRobot:
    return initialized(robot(*effects, **parameters))


# -- power -------------------------------------------------------------------------------------------------------------
EXCITERS = ("harmonic_force", "prescribed_motion", "unbalance")
FRICTION = ("", "smoothed_friction", "lugre_friction")
CASES = [
    *product(EXCITERS, ("",), (1.0, -1.0)),
    *product(("harmonic_force",), FRICTION[1:], (1.0, -1.0)),
    ("harmonic_force", "", 0.0),
    ("unbalance", "lugre_friction", 1.0),
]


@pytest.mark.parametrize(("exciter", "friction", "mode"), CASES)
def test_energy_grows_by_what_comes_in_less_what_is_lost(exciter, friction, mode):
    """dE/dt along the derivative, by central differences, at random states, equals the sum of the powers."""
    random = np.random.default_rng(3)
    unit = robot(
        *[e for e in (exciter, friction) if e],
        cubic_spring__stiffness=1e6,
        static_ratio=1.0 if friction == "smoothed_friction" else 1.3,
    )
    for _ in range(5):
        for name, value in {"tow.force": -2.0, "route.slope": 0.3, "route.friction_factor": 1.2}.items():
            unit.set(name, value)
        unit.initialize(random.uniform(0.0, 1.0))
        unit.x[:4] = random.uniform(-1.0, 1.0, 4) * [0.02, 0.5, 0.02, 0.5]
        unit.x[1] = mode * abs(unit.x[1])
        unit.x[4] = random.normal() * 2e-5 if friction == "lugre_friction" else mode
        if exciter == "harmonic_force":
            unit.x[5] = random.uniform(0.0, 6.0)
        if exciter == "unbalance":
            unit.set("unbalance.torque", 0.05)
            unit.x[5:] = random.uniform(0.0, 6.0), random.uniform(-90.0, 90.0)
        unit.refresh()
        power = unit["exciter_power"] + unit["tow.force"] * unit["velocity"] + unit["route.weight_power"] - unit["dissipation"]
        # second order in d: third derivative of the energy, at 90 rad/s below 1e6 W/s² , times d² / 6; rounding 1e-16 / d
        assert energy_rate(unit, robot_derivatives)[0] == pytest.approx(power, abs=1e-6, rel=1e-6)


# -- closed forms ------------------------------------------------------------------------------------------------------
def sliding(t: float) -> np.ndarray:
    """(x1, v1, x2, v2) of a robot that is pulled by 30 N and slides forwards all the time, from rest, by matrix exponential."""
    m1, m2, k, c, force, w = 1.0, 0.5, 2000.0, 5.0, 20.0, 60.0
    A = np.zeros((7, 7))  # x1, v1, x2, v2, sin, cos, 1
    A[0, 1] = A[2, 3] = 1.0
    A[1, :4] = np.array([-k, -c, k, c]) / m1
    A[3, :4] = np.array([k, c, -k, -c]) / m2
    A[1, 4], A[3, 4], A[1, 6] = force / m1, -force / m2, (30.0 - 2.0) / m1
    A[4, 5], A[5, 4] = w, -w
    return (expm(A * t) @ [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0])[:4]


@pytest.mark.known_answers(PipeRobot="harmonic_force")
def test_sliding_one_way_is_linear_and_of_fourth_order():
    errors = []
    for substep in (4e-3, 2e-3, 1e-3):
        unit = started("harmonic_force", tow__force=30.0, substep=substep)
        unit.step(0.0, 0.4)
        assert unit["mode"] == 1.0
        errors.append(np.abs(unit.y[:4] - sliding(0.4)))
    positions = np.array(errors)[:, [0, 2]]  # errors of the velocities change their sign at this time
    assert orders(positions) == pytest.approx(4.0, abs=0.1)
    assert errors[-1].max() < 1e-6  # (w h)^5 / 120 = 3e-8 a step at 80 rad/s and 0.3 m/s, damped at 7.5 1/s


def test_a_rigid_robot_stops_after_its_braking_distance():
    """Prescribed motion of amplitude 0: one mass M; v0² M / (2 F) after v0 M / F, and not a bit further."""
    for v0, level in ((0.7, 2.0), (-0.7, 8.0)):
        unit = started("prescribed_motion", prescribed_motion__amplitude=0.0, start_velocity=v0)
        distance, duration = math.copysign(0.5 * v0 * v0 * 1.5 / level, v0), abs(v0) * 1.5 / level
        unit.step(0.0, 0.9 * duration)
        assert unit["position"] == pytest.approx(0.99 * distance, rel=1e-13)
        assert unit["friction_force"] == -math.copysign(level, v0)
        unit.step(0.9 * duration, 2.0)
        assert unit["position"] == pytest.approx(distance, rel=1e-13)
        assert (unit["mode"], unit["velocity"]) == (0.0, 0.0)
        assert unit.work["events"] == 1


def periodic_speed(forward: float, backward: float, w: float, b: float = 1.0, weight: float = 0.0) -> float:
    """Mean speed of the periodic motion under a prescribed one in which the body swings with +-b about the common centre, m/s."""
    period = 2.0 * math.pi / w
    unit = robot(
        "prescribed_motion",
        body_mass=1.0,
        inner_mass=1.0,
        prescribed_motion__amplitude=2.0 * b / w,
        prescribed_motion__frequency=w,
        forward_friction=forward,
        backward_friction=backward,
        tow__force=-weight,
        substep=period / 64,
    )

    def gain(start: float) -> float:
        unit.set("start_velocity", start)
        unit.initialize(0.0)
        unit.step(0.0, period)
        return unit["velocity"] - start

    brentq(gain, -2.0 * b + 1e-3, -1e-3, xtol=1e-13)
    return unit["position"] / period


@pytest.mark.known_answers(PipeRobot="prescribed_motion")
@pytest.mark.parametrize(("forward", "backward"), [(0.1, 0.3), (0.2, 0.3), (0.05, 0.4)])
def test_mean_speed_at_weak_friction_and_its_convergence(forward, backward):
    """V = b cos(pi F+ / (F+ + F-)) where friction changes the motion within a period little: its mean vanishes.

    Result of the theory of locomotion by vibration (Bolotnik, Zeidis, Pivovarov, Zimmermann announce it); derived here for one
    rubbing body: F+ p = F- (1 - p), where p is the share of the period in which V + b cos(w t) > 0. The next order in the
    friction vanishes for a periodic motion: friction is even about the middle of sliding forwards, so the change of velocity is
    odd there, and both ends of the sliding shift by the same time.
    """
    exact = math.cos(math.pi * forward / (forward + backward))
    w = np.array([400.0, 800.0, 1600.0])
    errors = np.array([periodic_speed(forward * 2.0 * G, backward * 2.0 * G, f) - exact for f in w])
    small = backward * G / w  # friction over M b w, the small number of the expansion
    assert (np.abs(errors) < small**2).all()
    assert orders(errors) == pytest.approx(2.0, abs=0.1)


@pytest.mark.known_answers(PipeRobot="route")
@pytest.mark.parametrize("slope", [0.02, 0.05, 0.0997, 0.2])
def test_mean_speed_on_a_slope_and_where_it_turns_back(slope):
    """V = -b cos(pi (F- - W) / (F+ + F-)), so zero at W = (F- - F+) / 2: tan(slope) = (mu- - mu+) / 2 = 0.1."""
    weight, cosine = 2.0 * G * math.sin(slope), 2.0 * G * math.cos(slope)
    exact = -math.cos(math.pi * (0.3 - math.tan(slope)) / 0.4)
    assert periodic_speed(0.1 * cosine, 0.3 * cosine, 2000.0, weight=weight) == pytest.approx(exact, abs=1e-3)
    if slope == 0.05:
        assert exact == pytest.approx(0.38238, abs=5e-6)
    if slope == 0.0997:
        assert abs(exact) < 3e-4  # tan(0.0997) = 0.10003


def test_equal_friction_and_a_symmetric_force_lead_nowhere():
    assert periodic_speed(4.0, 4.0, 100.0) == pytest.approx(0.0, abs=1e-12)


# -- an independent solution -------------------------------------------------------------------------------------------
@pytest.mark.first
@pytest.mark.parametrize(("amplitude", "cycle"), [(20.0, [1, -1]), (1.5, [0, 1])])
def test_stick_and_slip_are_those_of_another_solver(amplitude, cycle):
    wanted, modes = reference(3.0, amplitude, (2.0, 8.0))
    unit = started("harmonic_force", harmonic_force__amplitude=amplitude)
    unit.step(0.0, 3.0)
    assert unit.work["events"] == len(modes) - 1
    assert {*modes[-10:]} == {*cycle}
    # RK4 at 80 rad/s and 0.5 ms: (w h)^5 / 120 = 9e-10 a step of 0.6 m/s at most, 6000 steps, damped at 7.5 1/s: 300 of them
    np.testing.assert_allclose(unit.y[:4], wanted, atol=2e-7)


@pytest.mark.first
@pytest.mark.parametrize(("w", "speed"), [(60.0, 0.36017), (77.46, 1.00825)])
def test_mean_speed_of_the_default_robot(w, speed):
    """Figures of a run from event to event by another program; 77.46 rad/s is the resonance of both masses on the spring."""
    unit = started("harmonic_force", harmonic_force__frequency=w, substep=1e-3)
    period = 2.0 * math.pi / w
    unit.step(0.0, 60 * period)
    before = unit["position"]
    unit.step(60 * period, 20 * period)
    assert (unit["position"] - before) / (20 * period) == pytest.approx(speed, abs=1e-5)


@pytest.mark.known_answers(PipeRobot="tow")
def test_mean_friction_is_the_weight_down_the_pipe():
    """Over a steady period the momentum comes back: mean R = (m1 + m2) g sin(slope) - tow, whatever the spring does."""
    unit = started("harmonic_force", route__slope=0.05, tow__force=-0.3)
    period, n = 2.0 * math.pi / 60.0, 400
    unit.step(0.0, 40 * period)
    before = unit["velocity"] + 0.5 * unit["inner_velocity"]
    impulse = 0.0
    for k in range(n):
        h = period / n
        first = unit["friction_force"]
        mode, events = unit["mode"], unit.work["events"]
        unit.step(40 * period + k * h, h)
        if unit.work["events"] == events and mode:
            impulse += h * first
        else:  # a jump within the step
            impulse += 0.5 * h * (first + unit["friction_force"])
    after = unit["velocity"] + 0.5 * unit["inner_velocity"]
    assert after == pytest.approx(before, abs=1e-6)
    jumps = 2 * (period / n) * 0.5 * 10.0  # two in a period, each known to half a step
    assert impulse == pytest.approx((1.5 * G * math.sin(0.05) + 0.3) * period, abs=jumps)


# -- bristles, unbalance, static friction ------------------------------------------------------------------------------
@pytest.mark.known_answers(PipeRobot="bristles")
@pytest.mark.parametrize(("degrees", "mu"), [(60.0, 0.3), (30.0, 0.3), (45.0, 0.8), (0.0, 0.5)])
def test_levels_of_bristles(degrees, mu):
    """F± = mu n N0 / (1 ± mu tan theta), read from the friction on a sliding robot."""
    angle = math.radians(degrees)
    normal = 8.0 * 0.019 / (0.03 * math.cos(angle))
    for sign in (1.0, -1.0):
        unit = started("harmonic_force", "bristles", bristles__angle=angle, bristles__friction=mu, start_velocity=sign)
        assert unit["friction_force"] == pytest.approx(-sign * mu * normal / (1.0 + sign * mu * math.tan(angle)), rel=1e-14)


def test_bristles_at_60_degrees_rub_3_times_as_much_backwards():
    """mu+ = 0.1974, mu- = 0.6245 at mu = 0.3: of the press of a straight bristle."""
    preset = PipeRobot.presets["bristles at 60 degrees"].parameters
    forward, backward = (
        abs(started("harmonic_force", "bristles", start_velocity=v, **preset)["friction_force"]) for v in (1.0, -1.0)
    )
    press = 8.0 * 0.019 / (0.03 * 0.5)
    assert forward / press == pytest.approx(0.1974, abs=5e-5)
    assert backward / press == pytest.approx(0.6245, abs=5e-5)


def test_friction_of_the_pipe_makes_bristles_lean_more():
    unit = started("harmonic_force", "bristles", route__friction_factor=1.4, start_velocity=-1.0)
    mu = 0.42
    wanted = mu * 8.0 * 0.019 / 0.03 / (math.cos(1.0472) - mu * math.sin(1.0472))
    assert unit["friction_force"] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.known_answers(PipeRobot="unbalance")
def test_an_unbalance_shakes_as_a_force_of_its_centrifugal_size():
    """A rotor so heavy that it keeps its rate: the inner mass moves as under q w² sin(psi), by linear response."""
    w, q = 40.0, 0.1 * 0.02
    unit = started(
        "unbalance",
        unbalance__inertia=1e6,
        unbalance__damping=0.0,
        unbalance__start_rate=w,
        forward_friction=1e4,
        backward_friction=1e4,
    )  # a body that stands
    unit.step(0.0, 4.0)
    phasor = q * w * w / (2000.0 - 0.5 * w * w + 5j * w)  # of e^(i psi)
    wanted = (phasor * np.exp(1j * (w * 4.0))).imag
    assert unit["unbalance.rate"] == pytest.approx(w, rel=1e-7)
    # what is left of the start: exp(-c / 2 m2 * 4 s) = 2e-9
    assert unit["inner_position"] == pytest.approx(wanted, abs=1e-6 * abs(phasor))
    assert unit["position"] == 0.0


def test_static_friction_holds_up_to_its_own_level():
    for pull, moves in ((2.59, 0.0), (2.61, 1.0), (-10.39, 0.0), (-10.41, -1.0)):
        unit = started("prescribed_motion", prescribed_motion__amplitude=0.0, static_ratio=1.3, tow__force=pull)
        unit.step(0.0, 0.1)
        assert unit["mode"] == moves
        if moves:  # then kinetic friction brakes
            level = 2.0 if moves > 0.0 else 8.0
            assert unit["velocity"] == pytest.approx((pull - moves * level) / 1.5 * 0.1, rel=1e-12)


@pytest.mark.parametrize(("pull", "after"), [(2.5, 0.0), (2.7, 1.0), (-10.3, 0.0), (-10.5, -1.0)])
def test_a_robot_that_stops_stays_up_to_the_static_level(pull, after):
    """It comes to rest against the pull, which lies above the kinetic level: 2 N and 8 N, static 1.3 times as much."""
    unit = started(
        "prescribed_motion",
        prescribed_motion__amplitude=0.0,
        static_ratio=1.3,
        tow__force=pull,
        start_velocity=-math.copysign(0.05, pull),
    )
    unit.step(0.0, 0.1)
    assert unit["mode"] == after
    assert unit.work["events"] == 1


@pytest.mark.first(2)
@pytest.mark.parametrize(("pull", "slides"), [(2.3, False), (2.7, True), (-9.2, False), (-10.6, True)])
def test_bristles_of_lugre_let_go_at_the_static_level(pull, slides):
    """1.3 times 2 N and 8 N. The pull comes slowly: bristles that bend at the Stribeck velocity would bear less."""
    unit = started("harmonic_force", "lugre_friction", harmonic_force__amplitude=0.0, static_ratio=1.3)
    unit.u[1, unit.input_positions(["tow.force"])] = 0.25 * pull
    unit.step(0.0, 4.0)
    unit.step(4.0, 0.5)
    assert (abs(unit["velocity"]) > 0.05) == slides
    if not slides:
        assert abs(unit["velocity"]) < 1e-5
        assert unit["friction_force"] == pytest.approx(-pull, abs=1e-3)


@pytest.mark.known_answers(PipeRobot=("smoothed_friction", "lugre_friction"))
@pytest.mark.parametrize("friction", ["smoothed_friction", "lugre_friction"])
@pytest.mark.parametrize("v", [0.3, -0.3])
def test_other_frictions_have_the_same_levels_in_steady_sliding(friction, v):
    unit = started("harmonic_force", friction, harmonic_force__amplitude=0.0, start_velocity=v)
    unit.step(0.0, 0.02)
    assert unit["friction_force"] == pytest.approx(-2.0 if v > 0.0 else 8.0, rel=1e-6)


@pytest.mark.known_answers(PipeRobot="cubic_spring")
def test_a_robot_on_a_slope_starts_with_its_mass_hanging_still():
    for stiffness in (0.0, 1e6):
        unit = started(
            "harmonic_force",
            route__slope=0.2,
            backward_friction=9.0,
            stiffness=400.0,
            harmonic_force__amplitude=0.0,
            cubic_spring__stiffness=stiffness,
        )
        stretch = unit["inner_position"]
        assert 400.0 * stretch + stiffness * stretch**3 == pytest.approx(-0.5 * G * math.sin(0.2), rel=1e-14)
        unit.step(0.0, 1.0)
        assert unit["inner_position"] == pytest.approx(stretch, abs=1e-15)
        assert unit["position"] == 0.0


@pytest.mark.parametrize("duration", [0.01, 0.1])
def test_a_stretched_spring_swings_on_a_body_that_stands(duration):
    """From start_stretch at rest: m2 x'' = -k x - c x'."""
    unit = started("harmonic_force", harmonic_force__amplitude=0.0, start_stretch=1e-3, forward_friction=1e4)
    unit.step(0.0, duration)
    decay = 5.0 / (2.0 * 0.5)
    w = math.sqrt(2000.0 / 0.5 - decay**2)
    swing = math.cos(w * duration) + decay / w * math.sin(w * duration)
    assert unit["inner_position"] == pytest.approx(1e-3 * math.exp(-decay * duration) * swing, abs=1e-10)
    assert unit["position"] == 0.0


# -- stable steps ------------------------------------------------------------------------------------------------------
def fastest(unit: PipeRobot, modes: tuple[float, ...] = (1.0, 0.0), stretch: float = 0.0, v: float = 0.1) -> float:
    """Largest |eigenvalue| of the derivatives by central differences, 1/s; modes: of exact friction, none for other laws."""
    moving = [i for i in range(unit.x.size) if i != 4 or not modes]
    largest = 0.0
    for mode in modes or (0.0,):
        x = np.zeros(unit.x.size)
        x[1], x[2], x[3], x[4] = mode * v if modes else v, stretch, mode * v if modes else v, mode
        columns = []
        for i in moving:
            d, ends = 1e-7 * np.eye(x.size)[i], np.zeros((2, x.size))
            for end, sign in zip(ends, (1.0, -1.0), strict=True):
                robot_derivatives(0.0, x + sign * d, unit.u[0], end, *unit.arguments)
            columns.append((ends[0] - ends[1])[moving] / 2e-7)
        largest = max(largest, float(np.abs(np.linalg.eigvals(np.array(columns))).max()))
    return largest


@pytest.mark.parametrize(("effects", "parameters", "where"), [
    (("harmonic_force",), {"cubic_spring__stiffness": 1e6}, {"stretch": 0.0499999}),
    (("unbalance",), {}, {}),
    (("harmonic_force", "smoothed_friction"), {"route__friction_factor": 1.5}, {"modes": (), "v": -1e-6}),
    (("harmonic_force", "lugre_friction"), {}, {"modes": (), "v": 0.0}),
], ids=lambda v: "+".join(v) if isinstance(v, tuple) else "")  # fmt: skip
def test_the_stable_step_is_that_of_the_stiffest_state(effects, parameters, where):
    """2.61, RK4's limit, over the largest eigenvalue at the largest stretch and factor of friction, body free and stuck."""
    unit = started(*effects, **parameters, substep=1e-5)
    assert unit.stable_step() == pytest.approx(2.61 / fastest(unit, **where), rel=1e-4)


def test_stable_steps_of_a_prescribed_motion_and_of_bristles():
    """One mass of 1.5 kg: 8 N over 5 mm/s, half as much again at the largest factor; bristles of 1e5 N/m. Levels of bristles."""
    assert robot("prescribed_motion").stable_step() == math.inf
    smoothed = robot("prescribed_motion", "smoothed_friction")
    assert smoothed.stable_step() == pytest.approx(2.61 / (1.5 * 8.0 / 5e-3 / 1.5), rel=1e-12)
    assert robot("prescribed_motion", "lugre_friction").stable_step() == pytest.approx(2.61 / math.sqrt(1e5 / 1.5), rel=1e-12)
    mu, press = 0.3 * 1.5, 8.0 * 0.019 / 0.03
    backward = mu * press / (math.cos(1.0472) - mu * math.sin(1.0472)) / 1.5  # over the factor, which counts again
    given = robot("harmonic_force", "smoothed_friction", backward_friction=backward).stable_step()
    assert robot("harmonic_force", "smoothed_friction", "bristles").stable_step() == pytest.approx(given, rel=1e-12)


# -- refusals ----------------------------------------------------------------------------------------------------------
