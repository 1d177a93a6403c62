"""Limits of the macro step: against closed forms, against a table computed with sympy, and against a coupled run."""

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.run.judgement.closed_form import longest_step, radii

SHARES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.5**0.5, 1.0)  # of critical damping
# ω H of the roots' first leaving the unit circle, from the characteristic polynomials of each case by computer algebra
LIMITS = {
    (0, 0): (0.040000, 0.080000, 0.200000, 0.400000, 0.800000, 2.000000, 1.414214, 1.000000),
    (1, 0): (0.395364, 0.501644, 0.694174, 0.902731, 1.213169, 1.101021, 0.739315, 0.510875),
    (2, 0): (0.989325, 1.009576, 1.063371, 1.143517, 1.301332, 0.593485, 0.401216, 0.277997),
    (0, 1): (0.013332, 0.026654, 0.066469, 0.131753, 0.254046, 0.481608, 0.494085, 0.426159),
    (1, 1): (0.019995, 0.039957, 0.099339, 0.194849, 0.362215, 0.577724, 0.517580, 0.397808),
    (2, 1): (0.020000, 0.040003, 0.100040, 0.200274, 0.400131, 0.683044, 0.526808, 0.367602),
}


@pytest.mark.parametrize(("degree", "delay"), LIMITS)
def test_limits_of_the_table(degree, delay):
    for share, limit in zip(SHARES, LIMITS[degree, delay], strict=True):
        assert longest_step(1.0, 2.0 * share, degree, delay) == pytest.approx(limit, abs=6e-7)  # as it is rounded


@pytest.mark.parametrize("share", [0.001, 0.3, 3.0])
def test_held_force_has_a_closed_form(share):
    omega, damping = 50.0, 2.0 * share * 50.0
    limit = longest_step(omega**2, damping, 0)
    assert limit == min(2.0 * damping / omega**2, 2.0 / damping)
    h = np.array([0.999, 1.001]) * limit
    assert (radii(omega**2 * h * h, damping * h, 0) > 1.0).tolist() == [False, True]


def test_without_damping_held_and_linear_forces_are_never_stable():
    assert longest_step(1.0, 0.0, 0) == longest_step(1.0, 0.0, 1) == longest_step(1.0, 0.0, 0, 1) == 0.0
    # |λ|² = 1 + w/2 for a held force
    assert radii(np.array([0.01]), np.zeros(1), 0) == pytest.approx(np.sqrt(1.005), rel=1e-12)


def test_nothing_coupled_is_always_stable():
    assert longest_step(0.0, 0.0, 1) == np.inf
    assert longest_step(0.0, 4.0, 0) == 0.5  # a damper alone


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_a_coupled_run_decays_below_and_grows_above_the_limit(algorithm, degree):
    """1 kg on 100 N/m and 2 N s/m: ω = 10 rad/s, a tenth of critical damping."""
    limit = longest_step(100.0, 2.0, degree)
    for factor, grows in ((0.98, False), (1.02, True)):
        step = round(factor * limit, 9)
        result = run(
            read_scene(
                {
                    "stop_time": 600 * step,
                    "connections": [
                        "spring.force -> mass.force",
                        "mass.x_out -> spring.position",
                        "mass.v_out -> spring.velocity",
                    ],
                    "units": {
                        "mass": {"component": "cosimo.tests.support:Mass"},
                        "spring": {"component": "cosimo.tests.support:SpringDamper", "parameters": {"d": 2.0}},
                    },
                    "master": {"algorithm": algorithm, "step": step, "extrapolation": degree},
                }
            )
        )
        motion = np.abs(result["mass.v_out"])
        assert (motion[-50:].max() > motion[100:150].max()) == grows
