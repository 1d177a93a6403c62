"""Beam rotor in time: against modal closed forms, conservation laws, order of convergence, and its own ports."""

import math

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.modal import modes
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized

FRISWELL = ("gyroscopic", "disks", "linear_supports")
SUPPORTED = {"bearing_a": 0.0, "bearing_b": 1.5}


def started(effects, **parameters) -> BeamRotor:
    return initialized(BeamRotor(effects, parameters))


def steady_unbalance(rotor: BeamRotor, speed: float, moment: float, node: int) -> np.ndarray:
    """(x + i y) exp(-i phi) of every node under a force U w² exp(i phi) at one of them, from the frequency response."""
    m = rotor.matrices()
    force = np.zeros(m.mass.shape[0], dtype=complex)
    force[4 * node], force[4 * node + 1] = moment * speed**2, -1j * moment * speed**2
    dynamic = m.stiffness + speed * m.circulatory - speed**2 * m.mass + 1j * speed * (m.damping + speed * m.gyroscopic)
    q = np.linalg.solve(dynamic, force)
    return 0.5 * (q[0::4] + 1j * q[1::4]), 0.5 * np.conj(q[0::4] - 1j * q[1::4])


@pytest.mark.known_answers(BeamRotor="unbalance")
@pytest.mark.first
@pytest.mark.parametrize("speed", [70.0, 150.0, -150.0, 400.0])
def test_steady_unbalance_response_is_that_of_the_frequency_domain(speed):
    damping = {f"linear_supports.damping_{axis}[{k}]": 2000.0 for axis in "xy" for k in (1, 2)}
    anisotropic = {"linear_supports.stiffness_x[1]": 7e5}
    rotor = started(
        (*FRISWELL, "unbalance", "internal_damping"),
        start_speed=speed,
        substep=2e-5,
        **damping,
        **anisotropic,
        **{"internal_damping.time_constant": 1e-5, "unbalance.phase[1]": 0.4},
    )
    forward, backward = steady_unbalance(rotor, speed, 1e-3, 2)
    slowest = modes(rotor.matrices(), speed).decay.min()
    assert slowest > 0.0
    rotor.step(0.0, 20.0 / slowest)
    turn = np.exp(1j * (rotor["angle"] + 0.4))
    expected = forward[2] * turn + backward[2] * np.conj(turn)
    found = complex(rotor["displacement_x"], rotor["displacement_y"])
    # midpoint rule: frequencies shift by (w h)²/12, the response by that over its distance from resonance; e^-20 of the start
    assert abs(found - expected) <= 3e-4 * abs(expected)


@pytest.mark.interpreted
@pytest.mark.parametrize("radius", [1.0, 0.5])
def test_order_in_time_is_two(radius):
    """Free whirl in the four lowest modes of the turning rotor, whose closed form is sum phi exp(lambda t)."""
    found = modes(started(FRISWELL, start_speed=200.0).matrices(), 200.0, 4)
    shape, value = found.shape, 1j * found.frequency - found.decay
    exact = (shape * np.exp(0.05 * value)).sum(axis=1).real
    errors, steps = [], np.array([4e-4, 2e-4, 1e-4, 5e-5])
    for h in steps:
        rotor = started(FRISWELL, start_speed=200.0, substep=float(h), spectral_radius=radius)
        for k, part in enumerate((shape, shape * value, shape * value**2)):
            rotor.x[k * shape.shape[0] : (k + 1) * shape.shape[0]] = part.sum(axis=1).real
        rotor.step(0.0, 0.05)
        errors.append(np.abs(rotor.x[0 : exact.size : 4] - exact[0::4]).max())
    assert slope(steps, errors) == pytest.approx(2.0, abs=0.05)
    assert errors[-1] < 1e-3 * np.abs(exact[0::4]).max()


def test_the_first_acceleration_is_that_of_the_unbalance_that_sets_in():
    """A method with a spectral radius below 1 begins with it: M a = U w² (cos, sin), everything else is in equilibrium."""
    rotor = started((*FRISWELL, "unbalance", "gravity", "internal_damping"), start_speed=150.0, start_angle=0.8)
    m = rotor.matrices()
    N = m.mass.shape[0]
    force = m.mass @ rotor.x[2 * N : 3 * N]
    expected = np.zeros(N)
    expected[8:10] = 1e-3 * 150.0**2 * math.cos(0.8), 1e-3 * 150.0**2 * math.sin(0.8)
    np.testing.assert_allclose(force, expected, atol=1e-6)  # N; rounding of 1e9 N/m times the sag of 1 mm


@pytest.mark.full
def test_energy_is_kept_without_damping():
    """The midpoint rule keeps a quadratic energy, gyroscopic forces do no work: rounding of 20 000 steps."""
    rotor = started((*FRISWELL, "gravity"), start_speed=500.0)
    sag = rotor.energy()
    rotor.x[: rotor.nodes.size * 4 : 4] += 1e-3
    start = rotor.energy()
    rotor.step(0.0, 2.0)
    assert start - sag > 0.5  # J
    assert abs(rotor.energy() - start) <= 1e-9 * (start - sag)


def test_a_free_rotor_keeps_its_momenta():
    """No support: the momentum, and with the gyroscopic moments the angular momentum, do not change while it whirls."""
    rotor = started(("gyroscopic", "disks"), start_speed=300.0)
    m = rotor.matrices()
    n, N = rotor.nodes.size, 4 * rotor.nodes.size
    rng = np.random.default_rng(3)
    bent = np.linalg.solve(m.stiffness + 1e6 * m.mass, rng.normal(size=N) * 1e3)
    rotor.x[:N] = bent
    move, tilt_y, tilt_x = np.zeros((3, N))
    move[0::4] = 1.0
    tilt_y[0::4], tilt_y[3::4] = rotor.nodes, 1.0
    tilt_x[1::4], tilt_x[2::4] = -rotor.nodes, 1.0

    def momenta():
        q, v = rotor.x[:N], rotor.x[N : 2 * N]
        p = m.mass @ v
        spin = 300.0 * m.gyroscopic @ q  # d/dt of it is the gyroscopic force
        return np.array([move @ p, tilt_y @ (p + spin), tilt_x @ (p + spin)])

    assert n == 7
    before = momenta()
    scale = 300.0 * np.abs(m.gyroscopic).max() * np.abs(bent).max() + np.abs(m.mass @ np.ones(N)).max() * 1e-3
    for k in range(50):
        rotor.step(k * 0.01, 0.01)
    assert np.abs(rotor.x[N : 2 * N]).max() > 1e-4  # it whirls
    # the elastic forces of the stiffest mode, 1e10 N/m times 1e-5 m, cancel to rounding: 1e-11 N over 0.5 s
    np.testing.assert_allclose(momenta(), before, atol=1e-7 * scale)


@pytest.mark.known_answers(BeamRotor="gravity")
def test_sag_is_that_of_beam_theory():
    """Simply supported under its own weight: 5 w L^4 / (384 EI) + w L² / (8 kappa G A) in the middle, exact at the nodes."""
    pinned = {f"linear_supports.stiffness_{axis}[{k}]": 1e15 for axis in "xy" for k in (1, 2)}
    rotor = started(("gravity", "linear_supports"), watched_position=0.75, **pinned)
    area, inertia = math.pi / 4.0 * 0.05**2, math.pi / 64.0 * 0.05**4
    nu = 0.5 * 211.0 / 81.2 - 1.0
    kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    load = 7810.0 * area * 9.81
    sag = 5.0 * load * 1.5**4 / (384.0 * 211e9 * inertia) + load * 1.5**2 / (8.0 * kappa * 81.2e9 * area)
    assert rotor["displacement_y"] == pytest.approx(-sag, rel=1e-6)  # rounding of springs of 1e15 N/m beside 1e8 N/m
    assert rotor["displacement_x"] == 0.0
    for k in range(10):
        rotor.step(k * 1e-3, 1e-3)
    assert rotor["displacement_y"] == pytest.approx(-sag, rel=1e-6)  # it stays there


@pytest.mark.known_answers(BeamRotor="internal_damping")
@pytest.mark.full
def test_internal_damping_drives_the_rotor_above_the_onset_speed():
    """Growth rates in time are those of the eigenvalues on both sides of the onset."""
    damping = {f"linear_supports.damping_{axis}[{k}]": 200.0 for axis in "xy" for k in (1, 2)}
    rates = []
    for speed in (60.0, 600.0):
        rotor = started((*FRISWELL, "internal_damping"), start_speed=speed, **damping, **{"internal_damping.time_constant": 1e-3})
        found = modes(rotor.matrices(), speed)
        least = int(found.decay.argmin())
        N = rotor.nodes.size * 4
        shape, value = found.shape[:, least], complex(-found.decay[least], found.frequency[least])
        rotor.x[:N], rotor.x[N : 2 * N] = 1e-3 * shape.real, 1e-3 * (value * shape).real
        size = math.log(abs(complex(rotor.x[8], rotor.x[9])))
        rotor.step(0.0, 1.0)
        rates.append(math.log(abs(complex(rotor.x[8], rotor.x[9]))) - size)
        assert rates[-1] == pytest.approx(-found.decay[least], rel=2e-3, abs=1e-3)  # (w h)²/12 in the frequency, 1e-4 in the rate
    assert rates[0] < 0.0 < rates[1]


@pytest.mark.known_answers(BeamRotor="run_up")
@pytest.mark.full
def test_a_run_up_passes_the_critical_speed_between_supports_with_damping():
    """Largest amplitude a little above the critical speed at 86.9 rad/s; the unbalance force is that of the run-up's angle."""
    damping = {f"linear_supports.damping_{axis}[{k}]": 300.0 for axis in "xy" for k in (1, 2)}
    rotor = started(
        (*FRISWELL, "unbalance", "run_up"),
        start_speed=40.0,
        substep=5e-4,
        **damping,
        **{"run_up.acceleration": 10.0, "run_up.end_speed": 160.0},
    )
    speeds, amplitudes = [], []
    for k in range(2600):
        rotor.step(k * 5e-3, 5e-3)
        speeds.append(rotor["speed"])
        amplitudes.append(math.hypot(rotor["displacement_x"], rotor["displacement_y"]))
    assert speeds[-1] == 160.0
    peak = speeds[int(np.argmax(amplitudes))]
    assert 86.9 < peak < 95.0
    assert max(amplitudes) > 5.0 * amplitudes[0]
    # Afterwards the amplitude is that of the steady state; the midpoint rule is off by (w h)²/12 in the frequency and
    # (w h)²/8 in the force, 1.3e-3 together, and a factor of 1.4 for the distance from resonance.
    rotor.step(13.0, 40.0)
    forward, _ = steady_unbalance(rotor, 160.0, 1e-3, 2)
    assert math.hypot(rotor["displacement_x"], rotor["displacement_y"]) == pytest.approx(abs(forward[2]), rel=4e-3)


def give(rotor: BeamRotor, port: str, tangent: np.ndarray, damping: np.ndarray, force=(0.0,) * 4) -> None:
    """Set a port's inputs from 4 x 4 tangents in the order x, y, tilt_x, tilt_y."""
    order = (0, 1, 3, 4)
    for name, matrix in (("stiffness", tangent), ("damping", damping)):
        for i, row in enumerate(order):
            for j, column in enumerate(order):
                rotor.set(f"{port}.{name}[{5 * row + column + 1}]", matrix[i, j])
    for name, value in zip(("force_x", "force_y", "moment_x", "moment_y"), force, strict=True):
        rotor.set(f"{port}.{name}", value)


@pytest.mark.known_answers(BeamRotor=("bearing_a", "bearing_b"))
def test_a_tangent_through_the_port_is_a_spring_in_the_rotor():
    """To rounding: the port's matrices stand in the same places as those of linear supports."""
    springs = {
        f"linear_supports.{n}_{axis}[{k}]": v * (1.0 + 0.5 * (axis == "y"))
        for axis in "xy"
        for k in (1, 2)
        for n, v in (("stiffness", 3e6), ("damping", 500.0))
    }
    effects = ("gyroscopic", "disks", "unbalance", "gravity")
    inside = started((*effects, "linear_supports"), **springs)
    outside = BeamRotor((*effects, "bearing_a", "bearing_b"))
    for port in SUPPORTED:
        give(outside, port, np.diag([3e6, 4.5e6, 0.0, 0.0]), np.diag([500.0, 750.0, 0.0, 0.0]))
    outside.initialize(0.0)
    for k in range(100):
        inside.step(k * 1e-3, 1e-3)
        outside.step(k * 1e-3, 1e-3)
    np.testing.assert_allclose(outside.y[:6], inside.y[:6], rtol=0.0, atol=1e-12)  # m; of 1e-3
    assert abs(inside["displacement_x"]) > 1e-6


def test_the_fifth_row_and_column_do_not_count():
    """z and what couples to it: the rotor has no axial motion."""
    one, other = (BeamRotor(("gravity", "bearing_a", "bearing_b")) for _ in range(2))
    for rotor in (one, other):
        for port in SUPPORTED:
            give(rotor, port, np.diag([3e6, 4e6, 10.0, 20.0]), np.zeros((4, 4)))
    for k in (3, 8, 11, 12, 13, 14, 15, 18, 23):
        other.set(f"bearing_a.stiffness[{k}]", 1e9)
        other.set(f"bearing_b.damping[{k}]", 1e9)
    for rotor in (one, other):
        rotor.initialize(0.0)
        rotor.step(0.0, 0.01)
    assert np.array_equal(one.y, other.y)


def test_force_and_moment_at_a_port_act_like_the_beam_says():
    """Cantilever held by one port's tangent; unit loads at the other end: L³/3EI + L/(kappa G A), L²/2EI, L/EI."""
    rotor = BeamRotor(("bearing_a", "bearing_b"), {"watched_position": 1.5})
    EI = 211e9 * math.pi / 64.0 * 0.05**4
    shear = 0.8861 * 81.2e9 * math.pi / 4.0 * 0.05**2
    L = 1.5
    bend, turn, both = L**3 / (3.0 * EI) + L / shear, L / EI, L**2 / (2.0 * EI)
    clamp = np.diag([1e14, 1e14, 1e14, 1e14])
    loads = {
        "force_x": (bend, 0.0, 0.0, both),
        "force_y": (0.0, bend, -both, 0.0),
        "moment_x": (0.0, -both, turn, 0.0),
        "moment_y": (both, 0.0, 0.0, turn),
    }
    for name, expected in loads.items():
        give(rotor, "bearing_a", clamp, np.zeros((4, 4)))
        give(rotor, "bearing_b", np.zeros((4, 4)), np.zeros((4, 4)), [float(n == name) for n in loads])
        rotor.initialize(0.0)
        found = [rotor[f"bearing_b.{n}"] for n in ("displacement_x", "displacement_y", "tilt_x", "tilt_y")]
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-10 * bend)  # kappa to four digits


def test_a_tangent_that_changes_within_the_step_is_followed():
    """A stiffness that grows linearly in time at a port, against many small steps with held values."""
    effects = ("disks", "bearing_a", "bearing_b")

    def run(n):
        rotor = BeamRotor(effects, {"substep": 1e-5})
        give(rotor, "bearing_a", np.diag([1e6, 1e6, 0.0, 0.0]), np.zeros((4, 4)), (1000.0, 0.0, 0.0, 0.0))
        give(rotor, "bearing_b", np.diag([1e6, 1e6, 0.0, 0.0]), np.zeros((4, 4)))
        rotor.initialize(0.0)
        column = rotor.input_positions(["bearing_a.stiffness[1]"])[0]
        h = 0.02 / n
        for k in range(n):
            rotor.set("bearing_a.stiffness[1]", 1e6 + 1e8 * k * h)
            rotor.u[1, column] = 1e8
            rotor.step(k * h, h)
        return rotor["bearing_a.displacement_x"]

    whole, cut = run(1), run(10)
    assert whole == pytest.approx(cut, rel=1e-9)  # the same polynomial, developed anew
    held = BeamRotor(effects, {"substep": 1e-5})
    for port in SUPPORTED:
        give(held, port, np.diag([1e6, 1e6, 0.0, 0.0]), np.zeros((4, 4)), (1000.0 * (port == "bearing_a"), 0.0, 0.0, 0.0))
    held.initialize(0.0)
    held.step(0.0, 0.02)
    assert abs(whole) < 0.8 * abs(held["bearing_a.displacement_x"])


def test_a_rotor_that_nothing_holds_starts_where_it_is_put():
    free = started(("gravity", "bearing_a", "bearing_b"), start_fall=3e-5)
    for name in ("bearing_a.displacement_y", "bearing_b.displacement_y", "displacement_y"):
        assert free[name] == pytest.approx(-3e-5, rel=1e-15)
    assert started(("gravity",))["displacement_y"] == 0.0  # without ports it would fall wherever it started
    assert started(("bearing_a", "bearing_b"))["displacement_y"] == 0.0
