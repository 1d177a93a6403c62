"""A rotor in a frame that turns: moment on the frame, and the motion, against closed forms and absolute coordinates."""

import math

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.model import DOFS
from cosimo.tests.support import initialized
from scipy.linalg import expm

SPEED = 300.0
EFFECTS = ("gyroscopic", "disks", "linear_supports", "frame_rotation")
RATES = {"frame_rotation.rate_x": 0.3, "frame_rotation.rate_y": -0.2}


def started(effects=EFFECTS, **parameters) -> BeamRotor:
    return initialized(BeamRotor(effects, {"start_speed": SPEED, **parameters}))


def moment(rotor: BeamRotor) -> np.ndarray:
    return np.array([rotor["frame_rotation.moment_x"], rotor["frame_rotation.moment_y"]])


def polar_inertia(rotor: BeamRotor) -> float:
    """Of the disks and of the bare shaft of the defaults, rho pi d^4 / 32 L, kg.m2."""
    shaft = 7810.0 * math.pi / 32.0 * 0.05**4 * 1.5
    return shaft + sum(rotor.get(f"disks.polar_inertia[{k}]") for k in (1, 2))


def rigid(rotor: BeamRotor) -> np.ndarray:
    """Rotations of the whole about x and y, through the middle, (2, N)."""
    about = np.zeros((2, DOFS * rotor.nodes.size))
    about[0, 1::DOFS], about[0, 2::DOFS] = -(rotor.nodes - 0.75), 1.0
    about[1, 0::DOFS], about[1, 3::DOFS] = rotor.nodes - 0.75, 1.0
    return about


@pytest.mark.known_answers(BeamRotor="frame_rotation")
@pytest.mark.parametrize("speed", [300.0, -80.0, 0.0])
@pytest.mark.parametrize("rate", [(0.3, 0.0), (0.0, 0.3), (-0.1, 0.25)])
def test_the_steady_moment_is_polar_inertia_times_speed_times_rate(speed, rate):
    """-w x H with H = I_p Omega along z; the rotor starts in that equilibrium and stays there."""
    rotor = started(start_speed=speed, **dict(zip(RATES, rate, strict=True)))
    expected = polar_inertia(rotor) * speed * np.array([-rate[1], rate[0]])
    scale = polar_inertia(rotor) * 300.0 * 0.3
    np.testing.assert_allclose(moment(rotor), expected, rtol=0.0, atol=1e-9 * scale)
    rotor.step(0.0, 0.05)
    np.testing.assert_allclose(moment(rotor), expected, rtol=0.0, atol=1e-6 * scale)  # rounding of the stiffest mode
    assert np.dot(moment(rotor), rate) == pytest.approx(0.0, abs=1e-6 * scale)  # no power: no work on the frame


def test_the_moment_is_a_couple_and_does_not_depend_on_where_it_is_taken():
    here, there = (started(**RATES, **{"frame_rotation.position": z}) for z in (0.2, 3.0))
    np.testing.assert_allclose(moment(here), moment(there), rtol=1e-9)


def test_a_force_off_the_axes_is_a_moment_on_the_frame():
    """A force F at z beside the gyroscopic moment: (-F_y, F_x) times the lever; also through ports."""
    lever = 0.5 - 0.1
    for effects in (EFFECTS, ("gyroscopic", "disks", "bearing_a", "bearing_b", "frame_rotation")):
        rotor = BeamRotor(effects, {"frame_rotation.position": 0.1, "start_speed": SPEED})
        for port in ("bearing_a", "bearing_b") if "bearing_a" in effects else ():
            for place, value in ((1, 1e6), (7, 2e6), (19, 3e3), (25, 2e3)):
                rotor.set(f"{port}.stiffness[{place}]", value)
            rotor.set(f"{port}.force_y", 20.0)  # of the bearing on the shaft, and so no load from outside
            rotor.set(f"{port}.moment_x", -4.0)
        rotor.set("force_x", 30.0)
        rotor.set("force_y", -50.0)
        rotor.set("frame_rotation.rate_y", 0.1)
        rotor.initialize(0.0)
        gyroscopic = polar_inertia(rotor) * SPEED * np.array([-0.1, 0.0])
        np.testing.assert_allclose(moment(rotor) - gyroscopic, [50.0 * lever, 30.0 * lever], rtol=0.0, atol=1e-6)


def test_the_motion_is_that_of_absolute_coordinates():
    """The same matrices in a space that does not turn, with supports that do: the matrix exponential of

        M Q'' + (C + Omega G) Q' + K Q = (K t + C) R w,    Q = q + R w t

    for a frame that turns at constant rates from the first instant on, with the rotor at rest in it. R w t moves the
    supports only, as a rigid rotation does not bend the shaft.
    """
    damping = {f"linear_supports.damping_{axis}[{k}]": 300.0 for axis in "xy" for k in (1, 2)}
    rotor = started(substep=2e-6, **damping)
    m, rates = rotor.matrices(), np.array(list(RATES.values()))
    N = m.mass.shape[0]
    turning = rates @ rigid(rotor)
    system = np.zeros((2 * N + 2, 2 * N + 2))  # Q, Q', t, 1
    system[:N, N : 2 * N] = np.eye(N)
    system[N : 2 * N] = np.linalg.solve(
        m.mass, np.column_stack((-m.stiffness, -m.damping - SPEED * m.gyroscopic, m.stiffness @ turning, m.damping @ turning))
    )
    system[2 * N, 2 * N + 1] = 1.0
    start = np.concatenate((np.zeros(N), turning, [0.0, 1.0]))
    end = 0.04
    absolute = expm(end * system) @ start
    for name, value in RATES.items():
        rotor.set(name, value)  # after the initialization: the rotor was at rest
    rotor.step(0.0, end)
    expected = absolute[:N] - end * turning
    found, size = rotor.x[:N], np.abs(expected).max()
    for axis in (0, 1):  # the midpoint rule is off by w t (w h)²/12: the tilts have a share of stiffer modes
        np.testing.assert_allclose(found[axis::DOFS], expected[axis::DOFS], rtol=0.0, atol=3e-5 * size)
        np.testing.assert_allclose(found[axis + 2 :: DOFS], expected[axis + 2 :: DOFS], rtol=0.0, atol=1e-3 * size)
    spring = m.stiffness @ expected + m.damping @ (absolute[N : 2 * N] - turning)
    np.testing.assert_allclose(moment(rotor), rigid(rotor) @ spring, rtol=2e-3)
    assert size > 1e-4


def test_what_the_frame_gives_the_rotor_has():
    """At random states d/dt (E + w . R' M q') + w . moment on the frame + dissipation = 0: gyroscopic forces do no work."""
    damping = {f"linear_supports.damping_{axis}[{k}]": 300.0 for axis in "xy" for k in (1, 2)}
    rotor = started((*EFFECTS, "internal_damping"), **RATES, **damping)
    m, about, rates = rotor.matrices(), rigid(rotor), np.array(list(RATES.values()))
    N, rng = m.mass.shape[0], np.random.default_rng(4)
    for _ in range(20):
        q, v = 1e-5 * rng.normal(size=N), 1e-2 * rng.normal(size=N)
        rotor.x[:N], rotor.x[N : 2 * N] = q, v
        rotor.refresh()
        force = m.damping @ v + SPEED * m.circulatory @ q  # what dissipates or feeds, beside the springs
        inertia = -m.stiffness @ q - force - SPEED * m.gyroscopic @ (v + rates @ about)
        changes = [v @ (inertia + m.stiffness @ q), rates @ about @ inertia, rates @ moment(rotor), v @ force]
        assert abs(sum(changes)) <= 1e-9 * np.abs(changes).max()


def test_a_rate_that_changes_within_the_step_is_followed():
    """A ramp over one long step is that over many short ones with the same polynomial."""
    ends = []
    for n in (1, 8):
        rotor = started()
        column = rotor.input_positions(["frame_rotation.rate_x"])[0]
        h = 0.02 / n
        for k in range(n):
            rotor.u[:, column] = 5.0 * k * h, 5.0, 0.0
            rotor.step(k * h, h)
        ends.append(moment(rotor))
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-6, atol=1e-9)
