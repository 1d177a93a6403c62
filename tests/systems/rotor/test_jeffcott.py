"""Jeffcott rotor against its closed forms: amplitude and phase, whirl, onset of instability, energy, order in time."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rotor.jeffcott import JeffcottRotor
from cosimo.tests.slopes import slope

MASS, STIFFNESS, DAMPING = 10.0, 1e5, 40.0
CRITICAL = 100.0  # rad/s, sqrt(k/m); damping ratio 0.02


def stepped(rotor: JeffcottRotor, duration: float, h: float = 1e-3, every: int = 1) -> np.ndarray:
    """(time, x, y, velocity_x, velocity_y, speed, angle) at every `every`-th step, (n, 7)."""
    rows = []
    for k in range(round(duration / h)):
        rotor.step(k * h, h)
        if (k + 1) % every == 0:
            rows.append([(k + 1) * h, *rotor.y])
    return np.array(rows)


def settled_response(speed: float, effects=("unbalance",), **parameters) -> complex:
    """(x + i y) in the frame that turns with the rotor, once the start has died away (20 time constants)."""
    rotor = JeffcottRotor(effects, {"start_speed": speed, "substep": 5e-5, **parameters})
    rotor.initialize(0.0)
    rotor.step(0.0, 20.0 * 2.0 * MASS / DAMPING)
    return complex(rotor["displacement_x"], rotor["displacement_y"]) * np.exp(-1j * rotor["angle"])


@pytest.mark.known_answers(JeffcottRotor="unbalance")
@pytest.mark.parametrize("ratio", [-1.5, -1.0, 0.0, 0.3, 0.9, 1.0, 1.1, 2.0, 5.0])
def test_amplitude_and_phase_of_the_unbalance_response(ratio):
    """(x + i y) exp(-i phi) = e r² / (1 - r² + 2 i zeta r), also for a rotor that turns backwards."""
    e, zeta = 1e-5, DAMPING / (2.0 * math.sqrt(MASS * STIFFNESS))
    closed = e * ratio**2 / (1.0 - ratio**2 + 2j * zeta * ratio)
    found = settled_response(ratio * CRITICAL)
    # RK4 at 5e-5 s, 500 rad/s: (w h)^4 / 120 = 3e-9 a radian, some hundred radians count; what is left of the start: e^-20
    assert abs(found - closed) <= 1e-6 * e + 1e-7 * abs(closed)
    if abs(ratio) == 1.0:
        assert abs(np.angle(found)) == pytest.approx(math.pi / 2.0, abs=1e-5)  # a quarter behind, whichever way


@pytest.mark.full
def test_phase_of_the_unbalance_turns_the_response():
    ahead = settled_response(80.0, **{"unbalance.phase": 0.7})
    assert ahead == pytest.approx(settled_response(80.0) * np.exp(0.7j), rel=1e-9)


def test_amplitude_is_largest_above_the_critical_speed():
    """Peak e / (2 zeta sqrt(1 - zeta²)) at r = 1 / sqrt(1 - 2 zeta²); damped enough to tell it from r = 1."""
    zeta = 0.2
    damping = 2.0 * zeta * math.sqrt(MASS * STIFFNESS)
    peak = CRITICAL / math.sqrt(1.0 - 2.0 * zeta**2)
    low, top, high = (abs(settled_response(w, damping=damping)) for w in (0.98 * peak, peak, 1.02 * peak))
    assert top == pytest.approx(1e-5 / (2.0 * zeta * math.sqrt(1.0 - zeta**2)), rel=1e-6)
    assert top > low
    assert top > high


@pytest.mark.known_answers(JeffcottRotor="orthotropy")
@pytest.mark.full
def test_orthotropic_supports_split_the_critical_speed_and_whirl_backwards_in_between():
    """x and y are two oscillators under e w² cos and sin; between their frequencies the orbit runs against the rotation."""
    ratio, speed = 1.44, 110.0
    rotor = JeffcottRotor(["unbalance", "orthotropy"], {"start_speed": speed, "orthotropy.ratio": ratio, "substep": 5e-5})
    rotor.initialize(0.0)
    rotor.step(0.0, 12.0)
    orbit = []
    for axis, (k, drive) in enumerate(((STIFFNESS, 1.0), (ratio * STIFFNESS, -1j))):
        turned = np.exp(1j * rotor["angle"])
        z = MASS * 1e-5 * speed**2 * drive * turned / (k - MASS * speed**2 + 1j * DAMPING * speed)
        orbit.append(z)
        assert rotor.x[axis] == pytest.approx(z.real, abs=1e-6 * 1e-5), axis  # e^-24 of the start, and RK4 as above
    direction = (np.conj(orbit[0]) * orbit[1]).imag  # negative: from x to y
    assert direction > 0.0
    assert rotor["displacement_x"] * rotor["velocity_y"] - rotor["displacement_y"] * rotor["velocity_x"] < 0.0


@pytest.mark.known_answers(JeffcottRotor="internal_damping")
@pytest.mark.full
@pytest.mark.parametrize("internal", [10.0, 40.0, 120.0])
def test_onset_of_instability_by_internal_damping(internal):
    """Neutral at w = w_0 (1 + c_external / c_internal): the growth rate of the forward whirl changes sign there."""
    onset = CRITICAL * (1.0 + DAMPING / internal)
    for share, sign in ((0.97, -1.0), (1.03, 1.0)):
        rate = growth_rate(share * onset, internal)
        exact = forward_rate(share * onset, internal)
        assert rate == pytest.approx(exact, rel=1e-4)
        assert rate * sign > 0.0
    assert abs(growth_rate(onset, internal)) < 1e-5  # 1/s, of 2 to 8 that damping alone would give


def forward_rate(speed: float, internal: float) -> float:
    """Largest real part of m s² + (c_e + c_i) s + k - i w c_i = 0, the equation of z = x + i y."""
    return float(np.roots([MASS, DAMPING + internal, STIFFNESS - 1j * speed * internal]).real.max())


def growth_rate(speed: float, internal: float) -> float:
    """Growth of the orbit over two seconds, 1/s, after the backward whirl has died away."""
    rotor = JeffcottRotor(["internal_damping"], {"start_speed": speed, "internal_damping.coefficient": internal, "substep": 5e-5})
    rotor.initialize(0.0)
    rotor.x[:4] = 1e-4, 0.0, 0.0, 1e-4 * CRITICAL
    rotor.step(0.0, 3.0)
    before = math.log(abs(complex(*rotor.x[:2])))
    rotor.step(3.0, 2.0)
    return 0.5 * (math.log(abs(complex(*rotor.x[:2]))) - before)


@pytest.mark.interpreted
@pytest.mark.first(2)
@pytest.mark.parametrize("seed", range(5))
def test_energy_balance_at_random_states(seed):
    """dE/dt = F v - c v² - c_i (v + w S q) v, along an exact solution: central difference of a short step, order h²."""
    rng = np.random.default_rng(seed)
    effects = ["gravity", "internal_damping", "orthotropy"]
    speed, h = 130.0, 2e-5
    rotor = JeffcottRotor(effects, {"start_speed": speed, "substep": 1e-5})
    rotor.set("force_x", 7.0)
    rotor.set("force_y", -3.0)
    rotor.initialize(0.0)
    rotor.x[:4] = 1e-4 * rng.normal(size=4) * (1.0, 1.0, CRITICAL, CRITICAL)
    start = rotor.energy()
    rotor.step(0.0, h)
    x, y, vx, vy, _ = rotor.x
    power = 7.0 * vx - 3.0 * vy - DAMPING * (vx**2 + vy**2) - 10.0 * (vx * (vx + speed * y) + vy * (vy - speed * x))
    rotor.step(h, h)
    change = (rotor.energy() - start) / (2.0 * h)
    # the third derivative of E is of size E (2 w)³ = 2e-3 J * 8e6 / s³; h²/6 of it is 1e-6 W, of 0.01 to 0.1 W
    assert change == pytest.approx(power, abs=3e-6)


@pytest.mark.interpreted
def test_energy_is_kept_without_damping():
    rotor = JeffcottRotor(["gravity"], {"damping": 0.0})
    rotor.initialize(0.0)
    rotor.x[0], rotor.x[3] = 3e-4, 0.05
    bending = 0.5 * (STIFFNESS * 9e-8 + MASS * 0.0025)
    before = rotor.energy()
    rows = stepped(rotor, 5.0)
    # RK4 loses (w h)^6 / 72 a step of the swinging energy: 25 000 steps of w h = 0.02; its next order is (w h)² of that
    assert before - rotor.energy() == pytest.approx(25_000 * 0.02**6 / 72.0 * bending, rel=0.01)
    assert rows[:, 2].mean() == pytest.approx(-9.81 * MASS / STIFFNESS, rel=0.01)  # it swings about the sag


@pytest.mark.interpreted
def test_order_in_time_is_four():
    errors, steps = [], np.array([4e-3, 2e-3, 1e-3, 5e-4])
    for h in steps:
        rotor = JeffcottRotor(["unbalance", "internal_damping"], {"start_speed": 90.0, "substep": float(h)})
        rotor.initialize(0.0)
        rotor.step(0.0, 0.48)
        errors.append(abs(complex(rotor["displacement_x"], rotor["displacement_y"]) - started_from_rest()))
    assert slope(steps, errors) == pytest.approx(4.0, abs=0.1)


def started_from_rest() -> complex:
    """Closed form of the start from rest: z = Z (exp(i w t) - A exp(s1 t) - B exp(s2 t)), checked in its equation."""
    w, c, ci, e = 90.0, DAMPING, 10.0, 1e-5
    s1, s2 = np.roots([MASS, c + ci, STIFFNESS - 1j * w * ci])
    Z = MASS * e * w**2 / (STIFFNESS - 1j * w * ci - MASS * w**2 + 1j * w * (c + ci))
    A = (s2 - 1j * w) / (s2 - s1)
    B = 1.0 - A

    def z(t, k=0):
        terms = ((1.0, 1j * w), (-A, s1), (-B, s2))
        return sum(Z * a * s**k * np.exp(s * t) for a, s in terms)

    assert abs(z(0.0)) < 1e-18
    assert abs(z(0.0, 1)) < 1e-16
    t = 0.123
    residual = MASS * z(t, 2) + (c + ci) * z(t, 1) + (STIFFNESS - 1j * w * ci) * z(t) - MASS * e * w**2 * np.exp(1j * w * t)
    assert abs(residual) < 1e-12
    return complex(z(0.48))


@pytest.mark.interpreted
def test_run_up_turns_by_the_integral_of_its_speed():
    """From 20 to 220 rad/s at 100 rad/s² from 0.5 s on: 10 rad, then 240 rad in two seconds, then 220 rad/s."""
    rotor = JeffcottRotor(
        ["run_up"],
        {
            "start_speed": 20.0,
            "run_up.acceleration": 100.0,
            "run_up.end_speed": 220.0,
            "run_up.start_time": 0.5,
            "start_angle": 0.3,
        },
    )
    rotor.initialize(0.0)
    rows = stepped(rotor, 3.0, 7e-4)
    t = rows[:, 0]
    s = np.clip(t - 0.5, 0.0, 2.0)
    np.testing.assert_allclose(rows[:, 5], 20.0 + 100.0 * s, rtol=1e-14)
    angle = 0.3 + 20.0 * t + 50.0 * s**2 + 200.0 * np.clip(t - 2.5, 0.0, None)
    # rounding: 4300 additions of numbers below 7
    np.testing.assert_allclose(np.exp(1j * rows[:, 6]), np.exp(1j * angle), atol=1e-11)
    assert (rows[:, 6] >= 0.0).all()
    assert (rows[:, 6] < 2.0 * math.pi).all()


@pytest.mark.known_answers(JeffcottRotor="run_up")
@pytest.mark.full
@pytest.mark.parametrize("acceleration", [2.0, 20.0, 100.0])
def test_run_up_through_the_critical_speed_is_its_convolution_integral(acceleration):
    """z(t) = integral of the impulse response exp(-d s) sin(w_d s) / (m w_d) times -m e (exp(i phi))'', by quadrature."""
    rows = run_up(acceleration)
    t = np.linspace(0.0, 150.0 / acceleration, 400_001)
    phi = 50.0 * t + 0.5 * acceleration * t**2
    force = MASS * 1e-5 * ((50.0 + acceleration * t) ** 2 - 1j * acceleration) * np.exp(1j * phi)
    decay = 0.5 * DAMPING / MASS
    damped = math.sqrt(CRITICAL**2 - decay**2)
    # sin(w (t - s)) = Im ..., so that one running integral of exp((d + i w) s) f(s) and its conjugate partner serve all t
    parts = [_running(np.exp((decay - sign * 1j * damped) * (t - t[-1])) * force, t[1]) for sign in (1.0, -1.0)]
    growth = [np.exp((-decay + sign * 1j * damped) * (t - t[-1])) for sign in (1.0, -1.0)]
    z = (growth[0] * parts[0] - growth[1] * parts[1]) / (2j * MASS * damped)
    closed = np.interp(rows[:, 0], t, z.real) + 1j * np.interp(rows[:, 0], t, z.imag)
    found = rows[:, 1] + 1j * rows[:, 2]
    # trapezoidal rule and linear interpolation: (200 rad/s * 0.19 ms)² / 8 = 2e-4 at the coarsest grid
    assert np.abs(found - closed).max() <= 3e-4 * np.abs(closed).max()


def _running(values: np.ndarray, d: float) -> np.ndarray:
    """Integral from the start to every point, trapezoidal rule."""
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1])) * d)


def run_up(acceleration: float) -> np.ndarray:
    rotor = JeffcottRotor(["unbalance", "run_up"], {"run_up.acceleration": acceleration, "run_up.end_speed": 200.0})
    rotor.initialize(0.0)
    return stepped(rotor, 150.0 / acceleration, 5e-3)


@pytest.mark.full
def test_a_quicker_run_up_has_a_lower_and_later_peak():
    steady = 1e-5 / (2.0 * 0.02 * math.sqrt(1.0 - 0.02**2))
    peaks = []
    for acceleration in (2.0, 20.0, 100.0):
        rows = run_up(acceleration)
        amplitude = np.hypot(rows[:, 1], rows[:, 2])
        peaks.append((amplitude.max() / steady, rows[amplitude.argmax(), 5]))
    heights, speeds = np.array(peaks).T
    assert heights[0] < 1.0
    assert (np.diff(heights) < 0.0).all()
    assert speeds[0] > CRITICAL
    assert (np.diff(speeds) > 0.0).all()


def test_a_substep_beyond_the_limit_is_refused():
    stiff = JeffcottRotor(parameters={"stiffness": 1e12})
    limit = stiff.stable_step()
    assert limit == pytest.approx(2.61 / math.sqrt(1e11), rel=1e-3)
    with pytest.raises(BadInput, match="substep"):
        stiff.initialize(0.0)
