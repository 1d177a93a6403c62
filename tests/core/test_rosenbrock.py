"""The linearly implicit method: its order, its stability, its invariants."""

import math
from collections import namedtuple

import numpy as np
import pytest
from cosimo.components.core.kernels import DONE, NOT_FINITE, bind, kernel
from cosimo.components.core.rosenbrock import rodas3
from cosimo.tests.slopes import slope

pytestmark = pytest.mark.interpreted
Memory = namedtuple("Memory", "u y x counts limits work")


@kernel
def stiff_derivatives(t, x, u, dx, s, p, e):
    """Prothero and Robinson: x0' = -stiffness (x0 - cos u) - sin(u) u'; x1' = -x1² (Riccati); x0 and x2 exchange nothing."""
    dx[0] = -p[0] * (x[0] - math.cos(u[0])) - math.sin(u[0]) * p[1]
    dx[1] = -x[1] * x[1] + u[0] - u[0]
    dx[2] = -dx[1]


@kernel
def stiff_jacobian(t, x, u, band, s, p, e):
    """Derivatives of `stiff_derivatives` by x."""
    band[0, 2] = -p[0]
    band[1, 2] = -2.0 * x[1]
    band[2, 1] = 2.0 * x[1]


@kernel
def stiff_outputs(t, s, p, e):
    """The state."""
    s.y[0] = s.x[0]
    return DONE


advance = bind(rodas3, __name__, derivatives=stiff_derivatives, jacobian=stiff_jacobian, outputs=stiff_outputs)


def run(n, stiffness, h=1.0, rate=1.0, start=(1.0, 2.0, 0.0)):
    """State after n steps over h, x0 following cos(rate t), and the status."""
    s = Memory(
        np.array([[0.0], [rate], [0.0]]),
        np.zeros(1),
        np.array(start),
        np.zeros(2, dtype=np.int64),
        np.array([h / n, math.inf]),
        np.zeros((10, 5)),
    )
    status = advance(0.0, h, s, (stiffness, rate), None)
    assert s.counts.tolist() == [n, 4 * n]
    assert s.u[:, 0].tolist() == [h * rate, 0.0, 0.0]
    np.testing.assert_array_equal(s.y[0], s.x[0])
    return s.x, status


@pytest.mark.parametrize("stiffness", [1.0, 5.0])
def test_third_order(stiffness):
    steps = np.array([10, 20, 40, 80])
    exact = np.array([math.cos(1.0), 2.0 / 3.0])
    errors = np.array([np.abs(run(n, stiffness)[0][:2] - exact).max() for n in steps])
    assert slope(1.0 / steps, errors) == pytest.approx(3.0, abs=0.15)


@pytest.mark.parametrize("stiffness", [1e3, 1e8, 1e14])
def test_a_stiff_equation_does_not_limit_the_step(stiffness):
    """One step of 0.1 with h times stiffness up to 1e13: the error is that of the slow solution, far below 1e-3."""
    x, status = run(1, stiffness, h=0.1)
    assert status == DONE
    assert x[0] == pytest.approx(math.cos(0.1), abs=1e-4)


def test_what_starts_far_off_is_gone_after_one_long_step():
    """L-stable: the amplification is 0 at infinity, of the order 1/(h times stiffness) before."""
    x, _ = run(1, 1e10, h=1.0, start=(1e3, 2.0, 0.0))
    assert abs(x[0] - math.cos(1.0)) < 1.0  # of 1e3


def test_linear_invariants_are_kept_to_rounding():
    """x1 + x2 does not change."""
    x, _ = run(7, 10.0)
    assert x[1] + x[2] == pytest.approx(2.0, abs=1e-14)  # seven steps of four stages


def test_what_is_not_finite_is_told():
    assert run(1, math.nan)[1] == NOT_FINITE
