"""The closed forms themselves: each put back into the equation it is to solve, or compared with an independent method."""

import itertools
import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.closed_forms import (
    SmallMotion,
    damped_motion,
    friction_turning_points,
    governor,
    governor_speed,
    small_motion,
)
from cosimo.tests.systems.two_axis_joint.exact_motions import (
    inertial_period,
    nutation_frequency,
    pendulum_motion,
    pendulum_period,
    precession_rate,
    proportional_dampers,
    quartic,
)
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.special import ellipk

G = 9.81
GENERAL = {
    "first_mass": 1.3,
    "first_length": 0.8,
    "first_centre": 0.5,
    "first_inertia": 0.04,
    "second_mass": 0.6,
    "second_centre": 0.4,
    "second_inertia": 0.03,
}


def differentiated(f, t: np.ndarray, h: float = 0.02) -> np.ndarray:
    """Derivative by central differences of eighth order; with h = 0.02 s and rates of 10 rad/s better than 1e-7 relative."""
    weights = np.array([4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0])
    return sum(w * (f(t + k * h) - f(t - k * h)) for k, w in enumerate(weights, 1)) / h


def chain(effects=("gravity", "viscous"), **parameters) -> TwoLinkChain:
    return TwoLinkChain(effects, parameters)


@pytest.mark.parametrize(("preset", "squares"), [
    ("equal point masses", (2.0 - math.sqrt(2.0), 2.0 + math.sqrt(2.0))),
    ("equal rods", (3.0 - 6.0 / math.sqrt(7.0), 3.0 + 6.0 / math.sqrt(7.0))),
])  # fmt: skip
def test_textbook_frequencies_solve_the_quartic(preset, squares):
    """w² = (g/l)(2 -+ sqrt 2) and (g/l)(3 -+ 6/sqrt 7), put in; rounding of coefficients near 200."""
    coefficients = quartic(small_motion(TwoLinkChain(preset=preset)))
    for square in squares:
        assert abs(np.polyval(coefficients, 1j * math.sqrt(G * square))) <= 1e-10


def test_quartic_of_the_damped_chain():
    """Coefficients by hand for m = l = 1, d1 = 0.1, d2 = 0.05: M = [[2, 1], [1, 1]], D = [[.15, -.05], [-.05, .05]]."""
    c = chain(**{"viscous.first": 0.1, "viscous.second": 0.05})
    assert quartic(small_motion(c)) == pytest.approx([1.0, 0.35, 4.0 * G + 0.005, 0.15 * G + 0.1 * G, 2.0 * G * G], rel=1e-14)


@pytest.mark.parametrize("effects", [("gravity", "viscous"), ("viscous",), ("gravity",)])
def test_quartic_has_the_eigenvalues_of_the_first_order_form(effects):
    motion = small_motion(chain(effects, **GENERAL))
    A = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(motion.mass, motion.stiffness), -np.linalg.solve(motion.mass, motion.damping)],
        ]
    )
    assert np.poly(A) == pytest.approx(quartic(motion) / quartic(motion)[0], rel=1e-10, abs=1e-12)


PROPORTIONAL = {"viscous.first": 0.3, "viscous.second": 0.3}
HEAVY = {**PROPORTIONAL, "viscous.first": 60.0, "viscous.second": 60.0}  # both modes overdamped
SOLVED = [
    (("gravity", "viscous"), PROPORTIONAL),
    (("gravity", "viscous"), HEAVY),
    (("viscous",), GENERAL),
    (("viscous",), {**GENERAL, "viscous.first": 0.0}),
    (("gravity",), GENERAL),
    ((), GENERAL),
]


@pytest.mark.parametrize(("effects", "parameters"), SOLVED)
def test_the_exact_damped_motion_satisfies_its_equation(effects, parameters):
    motion = small_motion(chain(effects, **parameters))
    start = (0.1, -0.05), (0.4, 0.3)
    t = np.linspace(0.5, 5.0, 40)
    angles, rates = damped_motion(motion, *start, t)
    h = 0.02 if parameters is not HEAVY else 0.002  # the fastest mode dies with 205 1/s
    slopes = differentiated(lambda s: damped_motion(motion, *start, s)[0], t, h)
    accelerations = differentiated(lambda s: damped_motion(motion, *start, s)[1], t, h)
    np.testing.assert_allclose(slopes, rates, atol=1e-8)
    residual = motion.mass @ accelerations + motion.damping @ rates + motion.stiffness @ angles
    assert np.abs(residual).max() <= 1e-7  # N.m, of some 1: what the differences leave
    first = damped_motion(motion, *start, 0.0)
    np.testing.assert_allclose(np.ravel(first), [0.1, -0.05, 0.4, 0.3], rtol=1e-13)


@pytest.mark.parametrize(("effects", "parameters"), SOLVED)
def test_the_exact_damped_motion_is_the_matrix_exponential(effects, parameters):
    motion = small_motion(chain(effects, **parameters))
    M, D, K = motion
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    for t in (0.01, 0.7, 6.0):
        angles, rates = damped_motion(motion, (0.1, -0.05), (0.4, 0.3), t)
        np.testing.assert_allclose([*angles[:, 0], *rates[:, 0]], expm(A * t) @ [0.1, -0.05, 0.4, 0.3], rtol=1e-9, atol=1e-12)


def test_the_exact_damped_motion_where_a_mode_is_critical():
    """Two equal roots: q = (q0 + (v0 + w q0) t) exp(-w t) in that mode."""
    motion = SmallMotion(np.eye(2), np.diag([4.0, 1.0]), np.diag([4.0, 9.0]))
    angles, rates = damped_motion(motion, (1.0, 0.0), (0.5, 0.0), 1.5)
    assert angles[0, 0] == pytest.approx((1.0 + 2.5 * 1.5) * math.exp(-3.0), rel=1e-13)
    assert rates[0, 0] == pytest.approx((2.5 - 2.0 * (1.0 + 2.5 * 1.5)) * math.exp(-3.0), rel=1e-13)


@pytest.mark.parametrize(("parameters", "ratio"), [({}, 1.0), (GENERAL, None)])
def test_dampers_of_proportional_damping(parameters, ratio):
    """D = mu M + nu K, the defining property; equal point masses need equal dampers."""
    first = proportional_dampers(chain(("gravity",), **parameters), 0.2)
    M, D, K = small_motion(chain(**parameters, **{"viscous.first": first, "viscous.second": 0.2}))
    columns = np.array([M.ravel(), K.ravel()]).T
    mix, *_ = np.linalg.lstsq(columns, D.ravel(), rcond=None)
    np.testing.assert_allclose(columns @ mix, D.ravel(), atol=1e-15)
    assert ratio is None or first == pytest.approx(0.2 * ratio, rel=1e-14)


def test_what_has_no_closed_form_is_refused():
    with pytest.raises(BadInput, match="couples the modes"):
        damped_motion(small_motion(chain(**{"viscous.first": 0.1, "viscous.second": 0.05})), (0.1, 0.0), (0.0, 0.0), 1.0)
    with pytest.raises(BadInput, match="without weight"):
        proportional_dampers(chain(()), 0.1)
    with pytest.raises(BadInput, match="first damper of -"):
        proportional_dampers(chain(("gravity",), first_inertia=10.0), 0.1)
    with pytest.raises(BadInput, match="cross inertia"):
        governor_speed(1.0, 0.02, 0.06)
    with pytest.raises(BadInput, match="momentum"):
        inertial_period(0.0, 0.1, 0.02, 0.05, 0.03, 0.06)


@pytest.mark.parametrize(("amplitude", "ratio"), [(0.1, 1.00062536), (math.pi / 2.0, 1.18034060), (3.0, 2.57123395)])
def test_pendulum_period(amplitude, ratio):
    """Published ratios to the period of small swings, and SciPy's elliptic integral."""
    period = pendulum_period(2.0, amplitude)
    assert period / math.pi == pytest.approx(ratio, abs=5e-9)
    assert period == pytest.approx(2.0 * ellipk(math.sin(0.5 * amplitude) ** 2), rel=1e-13)


@pytest.mark.parametrize("amplitude", [0.1, 1.5, 3.0])
def test_pendulum_motion_satisfies_its_equation_and_returns_after_its_period(amplitude):
    t = np.linspace(0.0, 6.0, 60)
    angles, rates = pendulum_motion(2.0, amplitude, t)
    np.testing.assert_allclose(differentiated(lambda s: pendulum_motion(2.0, amplitude, s)[0], t), rates, atol=1e-9)
    accelerations = differentiated(lambda s: pendulum_motion(2.0, amplitude, s)[1], t)
    np.testing.assert_allclose(accelerations, -4.0 * np.sin(angles), atol=1e-8)
    last, rate = pendulum_motion(2.0, amplitude, pendulum_period(2.0, amplitude))
    assert last == pytest.approx(amplitude, rel=1e-12)
    assert rate == pytest.approx(0.0, abs=1e-9)


def test_friction_turning_points_keep_the_balance_of_work():
    """m g l (cos b - cos a) = T (a + b) at each; the last lies where friction holds the weight; small swings lose 2 T / k."""
    turns = friction_turning_points(2.0, 0.3, G)
    for a, b in itertools.pairwise(turns):
        assert G * (math.cos(b) - math.cos(a)) == pytest.approx(0.3 * abs(a - b), rel=1e-12)
    assert [math.copysign(1.0, t) for t in turns[:-1]] == [(-1.0) ** k for k in range(len(turns) - 1)]
    assert abs(math.sin(turns[-1])) <= 0.3 / G < abs(math.sin(turns[-2]))
    small = friction_turning_points(1e-3, 1e-3, G)
    assert np.diff(np.abs(small))[:3] == pytest.approx(-2e-3 / G, rel=1e-5)
    assert friction_turning_points(0.01, 0.3, G) == [0.01]


@pytest.mark.parametrize(("cross", "axial", "amplitude"), [(0.03, 0.06, 0.5), (0.03, 0.06, 1.4), (0.06, 0.03, 0.8)])
def test_inertial_period_by_quadrature_and_by_integration(cross, axial, amplitude):
    """Against adaptive quadrature of dt = db / b' and the time the equation of motion takes for a quarter."""
    frame, inner, p = 0.02, 0.05, 0.4
    middle = 0.0 if axial > cross else math.pi / 2.0

    def inertia(e):
        return frame + cross * math.sin(middle + e) ** 2 + axial * math.cos(middle + e) ** 2

    def falling(root):  # e = amplitude - root²: takes the singularity at the turning point away
        e = amplitude - root * root
        return 2.0 * root / math.sqrt(p * p * max(1.0 / inertia(amplitude) - 1.0 / inertia(e), 1e-300) / inner)

    quarter, _ = quad(falling, 0.0, math.sqrt(amplitude), epsabs=1e-12, epsrel=1e-12)
    period = inertial_period(p, amplitude, frame, inner, cross, axial)
    assert period == pytest.approx(4.0 * quarter, rel=1e-8)

    def right(t, x):
        b = middle + x[0]
        return [x[1], (cross - axial) * (p / inertia(x[0])) ** 2 * math.sin(b) * math.cos(b) / inner]

    def passes(t, x):
        return x[0]

    passes.terminal = True
    sol = solve_ivp(right, (0.0, 10.0), [amplitude, 0.0], method="DOP853", rtol=1e-11, atol=1e-13, events=passes)
    assert period == pytest.approx(4.0 * sol.t_events[0][0], rel=1e-8)


def test_inertial_period_of_small_swings_and_published_one():
    """Limit 2 pi / W, W = p / (J_o + C) sqrt((C - B) / A)."""
    limit = 2.0 * math.pi / (0.4 / 0.08 * math.sqrt(0.03 / 0.05))
    assert inertial_period(0.4, 0.0, 0.02, 0.05, 0.03, 0.06) == pytest.approx(limit, rel=1e-14)
    assert inertial_period(0.4, 0.5, 0.02, 0.05, 0.03, 0.06) == pytest.approx(1.6162719, abs=5e-8)


@pytest.mark.parametrize("share", [0.5, 1.2, 3.0])
def test_governor_is_an_equilibrium_of_its_equation_with_its_linearisation(share):
    A, B, C, moment = 0.05, 0.06, 0.02, 2.0 * G * 0.15
    speed = share * governor_speed(moment, B, C)

    def acceleration(b):
        return ((B - C) * speed**2 * math.sin(b) * math.cos(b) - moment * math.sin(b)) / A

    angle, frequency = governor(speed, moment, A, B, C)
    assert acceleration(angle) == pytest.approx(0.0, abs=1e-12)
    assert (angle > 0.0) == (share > 1.0)
    slope = (acceleration(angle + 1e-5) - acceleration(angle - 1e-5)) / 2e-5
    assert slope == pytest.approx(-(frequency**2), rel=1e-8)


def test_governor_speed_published():
    assert governor_speed(2.0 * G * 0.15, 0.06, 0.02) == pytest.approx(8.5775871, abs=5e-8)


def test_nutation_is_the_eigenvalue_of_the_linearised_gimbal():
    """J_a a'' = -h b', J_b b'' = h a': rates turn into one another with h / sqrt(J_a J_b)."""
    values = np.linalg.eigvals([[0.0, -2.0 / 0.02], [2.0 / 0.015, 0.0]])
    assert nutation_frequency(2.0, 0.02, 0.015) == pytest.approx(np.abs(values[0]), rel=1e-14)
    assert nutation_frequency(-2.0, 0.02, 0.015) == pytest.approx(115.4701, abs=5e-5)


def test_precession_holds_its_torque():
    """h a' cos b is the gyroscopic torque on the inner axis; the rate grows without bound towards pi/2."""
    for b in (0.0, 1.0, 1.57):
        assert 2.0 * precession_rate(0.3, 2.0, b) * math.cos(b) == pytest.approx(0.3, rel=1e-14)
