"""The passive walker against published gaits, and against equations of the papers integrated by SciPy; a latch's impacts."""

import math

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.walker import PassiveWalker
from cosimo.fmus.native.instance import reasons_of
from cosimo.orchestrator.systems import read_scene
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

LIMIT = {"hip_mass": 1.0, "leg_mass": 1e-9}  # legs without mass


def walked(steps: int, preset: str, **parameters) -> PassiveWalker:
    walker = PassiveWalker((), parameters, preset=preset)
    walker.initialize(0.0)
    k = 0
    while walker["steps"] < steps:
        walker.step(0.05 * k, 0.05)
        k += 1
    return walker


def simplest_step(z: np.ndarray, slope: float) -> tuple[np.ndarray, float]:
    """Stance angle and rate right after the next impact, and its time: the equations of Garcia and others, legs without mass."""

    def right(t, y):
        theta, rate, phi, phi_rate = y
        pull = math.sin(theta - slope)
        return [rate, pull, phi_rate, pull + math.sin(phi) * (rate**2 - math.cos(theta - slope))]

    def strike(t, y):
        return y[2] - 2.0 * y[0]

    start = [z[0], z[1], 2.0 * z[0], z[1] * (1.0 - math.cos(2.0 * z[0]))]
    motion = solve_ivp(right, (0.0, 8.0), start, method="DOP853", rtol=1e-13, atol=1e-14, events=strike)
    time, y = next((t, y) for t, y in zip(motion.t_events[0], motion.y_events[0], strict=True) if t > 1.0 and y[0] < -0.05)
    return np.array([-y[0], math.cos(2.0 * y[0]) * y[1]]), float(time)


def gait(slope: float) -> np.ndarray:
    return fsolve(lambda z: simplest_step(z, slope)[0] - z, [0.2003, -0.1998], xtol=1e-13)


def test_the_simplest_walker_stays_at_its_published_gait():
    """Bhounsule's fixed point, hip of a thousand feet, to the digits given."""
    walker = walked(5, "simplest walker")
    assert walker["strike_angle"] == pytest.approx(0.200161072169750, abs=1e-12)
    assert walker["strike_rate"] == pytest.approx(-0.199906060087682, abs=1e-12)
    assert walker["strike_rate"] - walker["strike_swing_rate"] == pytest.approx(-0.015805473227965, abs=1e-12)


def test_legs_without_mass_walk_as_garcias_equations_say():
    z = gait(0.009)
    assert z == pytest.approx([0.200310900544287, -0.199832473004977], abs=1e-10)
    swing = z[1] * math.cos(2.0 * z[0])
    start = dict(zip(("stance_angle", "swing_angle", "stance_rate", "swing_rate"), (z[0], -z[0], z[1], swing), strict=True))
    walker = walked(1, "simplest walker", **LIMIT, **{f"start_{n}": v for n, v in start.items()})
    after, time = simplest_step(z, 0.009)
    assert [walker["strike_angle"], walker["strike_rate"]] == pytest.approx(after, abs=1e-8)
    assert walker["step_duration"] == pytest.approx(time, abs=1e-7)


def test_the_compass_gait_is_that_of_its_equations_in_other_coordinates():
    """Absolute angles from the vertical, mass matrix and impact by points of mass: nothing of the component's algebra."""
    preset = PassiveWalker.presets["compass gait"].parameters
    hip, leg, slope, g = preset["hip_mass"], preset["leg_mass"], preset["slope"], preset["gravity"]

    def places(q):  # hip, centre of the standing leg, of the swinging one, swinging foot, from the standing foot
        s, w = q
        up = np.array([-math.sin(s), math.cos(s)])
        down = np.array([math.sin(w), -math.cos(w)])
        return np.array([up, 0.5 * up, up + 0.5 * down, up + down])

    def slopes(q):
        s, w = q
        ds, dw = np.array([-math.cos(s), -math.sin(s)]), np.array([math.cos(w), math.sin(w)])
        zero = np.zeros(2)
        return np.array([[ds, zero], [0.5 * ds, zero], [ds, 0.5 * dw], [ds, dw]])  # point, angle, direction

    masses = np.array([hip, leg, leg, 0.0])
    weight = g * np.array([math.sin(slope), -math.cos(slope)])  # in axes of the slope

    def right(t, x):
        q, v = x[:2], x[2:]
        j, r = slopes(q), places(q)
        mass = np.einsum("p,pad,pbd->ab", masses, j, j)
        up, down = r[0], r[3] - r[0]
        turning = np.array([-(v[0] ** 2) * up, -0.5 * v[0] ** 2 * up, -(v[0] ** 2) * up - 0.5 * v[1] ** 2 * down, 0.0 * up])
        force = np.einsum("p,pad,pd->a", masses, j, weight - turning)
        return [*v, *np.linalg.solve(mass, force)]

    def strike(t, x):
        return places(x[:2])[3, 1]

    def impact(x):
        q, v = x[:2], x[2:]
        r, velocities = places(q), np.einsum("pad,a->pd", slopes(q), v)
        cross = lambda a, b: a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]  # noqa: E731
        about_foot = (masses * cross(r - r[3], velocities)).sum()
        about_hip = masses[1] * cross(r[1] - r[0], velocities[1])
        turned = np.array([q[1], q[0]])
        r, j = places(turned), slopes(turned)
        rows = [[(masses * cross(r, j[:, k])).sum() for k in range(2)], [leg * cross(r[2] - r[0], j[2, k]) for k in range(2)]]
        return np.array([*turned, *np.linalg.solve(rows, [about_foot, about_hip])])

    def step(x):
        motion = solve_ivp(right, (0.0, 2.0), x, method="DOP853", rtol=1e-12, atol=1e-13, events=strike)
        found = [(t, y) for t, y in zip(motion.t_events[0], motion.y_events[0], strict=True) if t > 0.4 and y[1] > 0.1]
        return impact(found[0][1]), found[0][0]

    x = fsolve(lambda x: step(x)[0] - x, [0.271, -0.271, -1.09, -0.377], xtol=1e-12)
    walker = walked(40, "compass gait")
    found = [walker[f"strike_{n}"] for n in ("angle", "rate", "swing_rate")]
    assert found == pytest.approx([x[0], x[2], x[3]], abs=1e-7)
    assert walker["step_duration"] == pytest.approx(step(x)[1], abs=1e-7)
    # from memory of the paper, in its angles: from the vertical
    assert [x[0] - slope, -x[0] - slope, x[2], x[3]] == pytest.approx([0.2187, -0.3234, -1.0918, -0.3772], abs=6e-5)


def test_energy_and_what_impacts_take_make_a_whole():
    walker = PassiveWalker(preset="compass gait")
    walker.initialize(0.0)
    start = walker.energy()
    for k in range(100):
        walker.step(0.05 * k, 0.05)
        assert walker.energy() + walker["lost_energy"] == pytest.approx(start, rel=1e-10)
    assert walker["lost_energy"] > 20.0


@pytest.mark.parametrize("torque", [0.5, -0.5])
def test_a_torque_in_the_hip_does_work_between_the_legs(torque):
    walker = PassiveWalker(preset="compass gait")
    walker.set("hip_torque", torque)
    walker.initialize(0.0)
    start, between = walker.energy(), walker["swing_angle"] - walker["stance_angle"]
    for k in range(6):
        walker.step(0.05 * k, 0.05)
    assert walker["steps"] == 0
    work = torque * (walker["swing_angle"] - walker["stance_angle"] - between)
    assert walker.energy() - start == pytest.approx(work, rel=1e-8)


def test_the_grounds_force_is_that_of_the_whole_bodys_momentum():
    """Difference of the momentum of all masses over a short time, along the slope and its normal."""
    p = PassiveWalker.presets["compass gait"].parameters
    hip, leg, slope, g = p["hip_mass"], p["leg_mass"], p["slope"], p["gravity"]

    def momentum(w):
        s, q, a, b = (w[n] for n in ("stance_angle", "swing_angle", "stance_rate", "swing_rate"))
        up, across = a * np.array([-math.cos(s), -math.sin(s)]), 0.5 * b * np.array([math.cos(q), math.sin(q)])
        return hip * up + leg * 0.5 * up + leg * (up + across)

    walker = PassiveWalker(preset="compass gait")
    walker.initialize(0.0)
    walker.step(0.0, 0.1)
    before, h = momentum(walker), 1e-5
    walker.step(0.1, h)
    force = np.array([walker["tangential_force"], walker["normal_force"]])
    middle, after = force, momentum(walker)
    weight = (hip + 2.0 * leg) * g * np.array([math.sin(slope), -math.cos(slope)])
    assert (after - before) / h - weight == pytest.approx(middle, rel=1e-3)


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_multipliers_of_the_gait_hold_through_impacts():
    """The tangent of an impact has the shift of its instant in it; SciPy's return map by differences."""
    z = gait(0.009)
    differences = [simplest_step(z + d, 0.009)[0] - simplest_step(z - d, 0.009)[0] for d in 1e-5 * np.eye(2)]
    expected = np.linalg.eigvals(np.array(differences).T / 2e-5)
    unit = {"component": "PassiveWalker", "preset": "simplest walker", "parameters": LIMIT}
    record = {"signals": ["unit.stance_angle", "unit.swing_angle"]}
    scene = read_scene({"stop_time": 40.0, "units": {"unit": unit}, "master": {"step": 0.01}, "record": record})
    with cosimo.open(scene) as session:
        orbit = session.orbit(guess=3.88, after=20).branches[0].points[0]
    assert orbit.period == pytest.approx(simplest_step(z, 0.009)[1], abs=1e-6)
    assert np.sort_complex(orbit.multipliers[:2]) == pytest.approx(np.sort_complex(expected), abs=1e-5)
    assert np.abs(orbit.multipliers[2:]).max(initial=0.0) < 1e-4  # 0: the impact leaves two of the four states


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_derivatives_through_impacts_are_those_of_differences():
    def scene(**parameters):
        unit = {"component": "PassiveWalker", "preset": "compass gait", "parameters": parameters}
        record = {"signals": ["unit.strike_angle", "unit.lost_energy"]}
        return read_scene({"stop_time": 3.0, "units": {"unit": unit}, "master": {"step": 0.01}, "record": record})

    figures = ["unit.strike_angle, last", "unit.lost_energy, last"]
    base = PassiveWalker.presets["compass gait"].parameters
    for name in ("slope", "leg_mass", "start_swing_rate"):
        runs = [cosimo.run(scene(**{name: base[name] * (1.0 + d)}), verify="no") for d in (1e-6, -1e-6)]
        for figure in figures:
            signal = figure.partition(",")[0]
            difference = (runs[0][signal][-1] - runs[1][signal][-1]) / (2e-6 * base[name])
            slope = cosimo.gradient(scene(), figure, f"unit.{name}")[figure, f"unit.{name}"]
            assert slope.derivative == pytest.approx(difference, rel=1e-5)


LATCHED = {"first_inertia": 10.0, "first_mass": 0.0, "first_centre": 0.0, "first_length": 0.5, "second_centre": 0.4}


@pytest.mark.known_answers(TwoLinkChain="latch")
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_an_impact_keeps_the_moment_of_momentum_and_takes_its_share_of_the_energy(restitution):
    """½ (C - B² / A) (1 - e²) rate²: the energy of the motion between the links, A, B, C of the mass matrix at the latch."""
    given = {**LATCHED, "start_second_rate": 1.0, "latch.restitution": restitution, "latch.capture_rate": 0.9}
    given["latch.capture_rate"] = 1e-6 if restitution else 5.0
    chain = TwoLinkChain(["latch"], given)
    chain.initialize(0.0)
    momentum, before = chain["angular_momentum"], chain.energy()
    k, rate = 0, 0.0
    while chain["latch.impacts"] == 0:
        rate = chain["relative_rate"]
        chain.step(1e-3 * k, 1e-3)
        k += 1
    a, b, c = 10.0 + 0.25 + 2 * 0.2 * math.cos(0.5 * math.pi) + 0.16, 0.2 * math.cos(0.5 * math.pi) + 0.16, 0.16
    assert chain["angular_momentum"] == pytest.approx(momentum, rel=1e-12)
    assert before - chain.energy() == pytest.approx(0.5 * (c - b * b / a) * (1.0 - restitution**2) * rate**2, rel=2e-3)
    assert chain["latch.latched"] == (restitution == 0.0)
    if not restitution:
        assert (chain["relative_rate"], chain["relative_angle"]) == (0.0, pytest.approx(0.5 * math.pi, abs=1e-12))
        assert chain["first_rate"] == pytest.approx(momentum / a, rel=1e-12)


def test_a_ball_that_bounces_on_the_end_comes_back_by_the_square_of_the_restitution():
    """Weight drives the second link of a heavy hub against an end below: heights 1 : e² : e⁴, in the small."""
    given = {"first_inertia": 1e9, "latch.angle": 0.0, "latch.restitution": 0.6, "latch.capture_rate": 1e-4,
             "start_second_angle": 0.01}  # fmt: skip
    chain = TwoLinkChain(["gravity", "latch"], given)
    chain.initialize(0.0)
    # behind each impact with the end at the lowest place the link swings up by e of the angle before
    tops, angles = [], []
    for k in range(4000):
        chain.step(1e-3 * k, 1e-3)
        angles.append(chain["relative_angle"])
    angles = np.array(angles)
    tops = [angles[k] for k in range(1, angles.size - 1) if angles[k - 1] < angles[k] > angles[k + 1]]
    assert np.array(tops[:3]) == pytest.approx(0.01 * 0.6 ** np.arange(1, 4), rel=1e-4)


def test_a_native_build_has_a_message_for_each_end_of_walking():
    """It asks for it before any run, when no end is there yet."""
    walker = PassiveWalker()
    walker.initialize(0.0)
    texts = [text for _, text, _ in reasons_of(walker)]
    assert any("leaves the ground" in text for text in texts)
