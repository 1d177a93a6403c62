"""The method of order eight: its coefficients, its order on motions with a closed form, its limit, inputs that move."""

import math
import types

import numpy as np
import pytest
from cosimo import DONE, BadInput
from cosimo.components.core import high_order
from cosimo.components.core.high_order import MATRIX, NODES, ROWS, STAGES, WEIGHTS, smooth_step
from cosimo.components.core.high_order import RK8_STABILITY_RADIUS as STABILITY_RADIUS
from cosimo.components.rotor.jeffcott import JeffcottRotor
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.tests.slopes import orders
from scipy.linalg import expm
from scipy.special import ellipj, ellipk

pytestmark = pytest.mark.interpreted


def test_the_coefficients_meet_the_conditions_of_quadrature_and_of_the_inner_stages():
    assert MATRIX.sum(axis=1) == pytest.approx(NODES, abs=1e-14)
    assert not np.triu(MATRIX).any()
    for k in range(8):
        assert WEIGHTS @ NODES**k == pytest.approx(1.0 / (k + 1), abs=1e-14)
    for i in (3, 4, 5, 6, 7, 8, 9, 10, 11):  # second order within the stages that carry weight
        assert MATRIX[i] @ NODES == pytest.approx(0.5 * NODES[i] ** 2, abs=1e-14)


def amplification(z):
    """|R(z)| of the method for x' = lambda x, by its stages."""
    k = []
    for i in range(STAGES):
        k.append(1.0 + z * sum(MATRIX[i, j] * k[j] for j in range(i)))
    return abs(1.0 + z * sum(w * s for w, s in zip(WEIGHTS, k, strict=True)))


def test_the_limit_is_that_of_the_stages_in_every_direction_of_the_left_half_plane():
    angles = np.radians(np.linspace(90.0, 180.0, 46))
    assert max(amplification(STABILITY_RADIUS * np.exp(1j * a)) for a in angles) <= 1.0
    assert max(amplification(1.02 * STABILITY_RADIUS * np.exp(1j * a)) for a in angles) > 1.0


@pytest.mark.known_answers(GimbalBody="high_order", TwoLinkChain="high_order")
def test_a_pendulum_of_any_amplitude_converges_with_order_eight():
    """The chain with a second link whose mass is a billionth is a rod that swings: sin(q/2) = k sn(w t + K), exactly."""
    given = {
        "first_mass": 1.0,
        "first_length": 1.0,
        "first_centre": 1.0,
        "first_inertia": 0.0,
        "second_mass": 0.0,
        "second_inertia": 1.0,
        "second_centre": 0.0,
        "start_first_angle": 2.0,
        "start_second_angle": 0.0,
    }
    k, w, end = math.sin(1.0), math.sqrt(9.81), 4.0
    sn = ellipj(w * end + ellipk(k * k), k * k)[0]
    exact = 2.0 * math.asin(k * sn)
    errors = []
    for substep in (0.2, 0.1, 0.05):
        chain = TwoLinkChain(("gravity", "high_order"), {**given, "substep": substep})
        chain.initialize(0.0)
        chain.step(0.0, end)
        errors.append(abs(chain["first_angle"] - exact))
    assert min(orders(errors)) > 7.4
    assert errors[-1] < 1e-8


@pytest.mark.known_answers(JeffcottRotor="high_order")
def test_a_rotor_in_free_motion_is_the_matrix_exponential():
    """Order eight by the error after a second against the exact linear motion; whirl with internal damping."""
    given = {"start_speed": 150.0, "internal_damping.coefficient": 30.0}
    errors = []
    for substep in (0.02, 0.01, 0.005):
        rotor = JeffcottRotor(("internal_damping", "high_order"), {**given, "substep": substep})
        rotor.initialize(0.0)
        rotor.x[:4] = 1e-3, -5e-4, 0.02, 0.05
        start = rotor.x[:4].copy()
        rotor.step(0.0, 1.0)
        m, k, c, ci, spin = 10.0, 1e5, 40.0, 30.0, 150.0
        A = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-np.array([[k, ci * spin], [-ci * spin, k]]) / m, -(c + ci) / m * np.eye(2)]]
        )
        errors.append(float(np.abs(rotor.x[:2] - (expm(A) @ start)[:2]).max()))
    assert min(orders(errors)) > 7.3
    assert errors[-1] < 1e-9


def test_an_input_that_moves_within_the_step_is_followed_exactly():
    """x' = u with u = a + b s + c s²: a step of any length is the integral."""

    def derivatives(t, x, u, dx, s, p, e):
        dx[0] = u[0]

    def outputs(t, s, p, e):
        s.y[0] = s.x[0]

    names = {"derivatives": derivatives, "outputs": outputs}
    parts = {part: plain(getattr(high_order, part), **names) for part in smooth_step.parts}
    method = plain(smooth_step, **parts)
    s = types.SimpleNamespace(
        u=np.array([[2.0], [-3.0], [5.0]]),
        x=np.zeros(1),
        y=np.zeros(1),
        counts=np.zeros(2),
        work=np.zeros((ROWS, 1)),
        limits=np.array([2.0 / 3.0, math.inf]),
    )
    assert method(0.0, 2.0, s, None, types.SimpleNamespace(high_order=True)) == DONE
    assert s.y[0] == pytest.approx(2.0 * 2.0 - 3.0 * 2.0 + 5.0 * 8.0 / 3.0, rel=1e-14)
    assert s.counts.tolist() == [3, 36]
    assert s.u[:, 0] == pytest.approx([2.0 - 6.0 + 20.0, 0.0, 0.0])


def plain(template, **names):
    """The template in plain Python with the given functions."""
    return types.FunctionType(template.__code__, {**template.__globals__, **names})


def test_a_step_beyond_its_limit_is_refused_and_named():
    """What RK4 refuses is accepted up to 5.9 / 2.61 times the step, and refused beyond."""
    given = {"stiffness": 1e5, "mass": 10.0, "damping": 0.0}
    limit = JeffcottRotor((), given).stable_step()
    assert JeffcottRotor(("high_order",), given).stable_step() == pytest.approx(limit * STABILITY_RADIUS / 2.61)
    for effects, share in (((), 1.01), (("high_order",), 1.01 * STABILITY_RADIUS / 2.61)):
        with pytest.raises(BadInput, match=r"order eight" if effects else "RK4"):
            JeffcottRotor(effects, {**given, "substep": share * limit}).initialize(0.0)


@pytest.mark.parametrize("effect", ["stick_friction", "stops", "lugre_friction"])
@pytest.mark.parametrize("component", [GimbalBody, TwoLinkChain])
def test_what_has_kinks_is_excluded(component, effect):
    with pytest.raises(BadInput, match="high_order"):
        component(("high_order", effect))
