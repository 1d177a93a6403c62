"""Errors and orders of accuracy of every algorithm on two masses cut in three ways, against a table and as slopes."""

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import STATES, TwoMasses, give_past, open_master
from cosimo.tests.short_run import full_but
from cosimo.tests.slopes import orders, slope
from cosimo.tests.support import exact_two_masses, two_masses

LIM = TwoMasses()  # case 1
STEPS = (1e-2, 5e-3, 2.5e-3, 1.25e-3)  # s

# Largest error of the four states at t = 1, for held, linear and quadratic inputs and the steps above, with the exact
# solution as past. Computed with a separate program that knows only the matrices.
ERRORS = {
    ("FF", "jacobi", "immediate"): (
        (15.89, 7.650, 3.748, 1.855),
        (9.032, 2.208, 0.5443, 0.1349),
        (0.3101, 0.02986, 0.008159, 0.001293),
    ),
    ("FD", "jacobi", "immediate"): (
        (15.45, 7.205, 3.482, 1.712),
        (1.648, 0.4017, 0.09887, 0.02451),
        (0.06237, 0.004462, 0.001336, 0.0002152),
    ),
    ("FD", "jacobi", "delayed"): (
        (80.89, 32.46, 14.52, 6.873),
        (3.189, 0.8080, 0.2054, 0.05188),
        (0.3643, 0.04125, 0.004910, 0.0005994),
    ),
    ("DD", "jacobi", "immediate"): (
        (5.964, 2.948, 1.465, 0.7306),
        (1.480, 0.3597, 0.08831, 0.02186),
        (0.1593, 0.02147, 0.002744, 0.0003457),
    ),
    ("FD", "gauss-seidel", "immediate"): (
        (20.87, 9.546, 4.566, 2.234),
        (1.140, 0.2834, 0.07069, 0.01765),
        (0.03317, 0.002646, 0.0007195, 0.000115),
    ),
    ("DD", "gauss-seidel", "immediate"): (
        (1.799, 0.9035, 0.4526, 0.2265),
        (0.6172, 0.1520, 0.03726, 0.009194),
        (0.1407, 0.01977, 0.002574, 0.0003271),
    ),
    ("FF", "iterative", "immediate"): (
        (13.38, 7.018, 3.590, 1.815),
        (1.705, 0.4271, 0.1068, 0.02671),
        (0.04988, 0.008711, 0.001240, 0.0001644),
    ),
    ("FD", "iterative", "immediate"): (
        (11.82, 6.304, 3.257, 1.655),
        (0.3080, 0.07753, 0.01941, 0.004856),
        (0.008010, 0.001443, 0.0002071, 0.00002754),
    ),
    ("DD", "iterative", "immediate"): (
        (5.715, 2.884, 1.449, 0.7266),
        (0.2744, 0.06904, 0.01729, 0.004324),
        (0.01930, 0.002448, 0.0003077, 0.00003855),
    ),
}


def exact_signals(t: float) -> dict:
    """Every output of every split at t."""
    x1, v1, x2, v2 = LIM.exact(t)
    force = LIM.kc * (x2 - x1) + LIM.cc * (v2 - v1)
    return dict(zip(STATES, (x1, v1, x2, v2), strict=True)) | {("b", "force"): force, ("f", "force"): force}


def final_error(split, algorithm, feedthrough, degree, step) -> float:
    """Largest error of the states at t = 1, started with the exact past."""
    scene = LIM.scene(split, step, algorithm=algorithm, extrapolation=degree, feedthrough=feedthrough)
    master = open_master(scene)
    give_past(master, exact_signals, step, degree)
    for k in range(round(1.0 / step)):
        master.step(k * step, step)
    reached = np.array([master.signals[master.positions[end]] for end in STATES])
    return float(np.abs(reached - LIM.exact(1.0)).max())


@pytest.mark.parametrize("degree", full_but((1,), (0, 1, 2)))
@pytest.mark.parametrize("scheme", ERRORS, ids=" ".join)
def test_errors_and_order_of_two_masses(scheme, degree):
    errors = np.array([final_error(*scheme, degree, step) for step in STEPS])
    # the table has four digits, the smallest numbers three; neighbouring schemes differ by much more
    np.testing.assert_allclose(errors, ERRORS[scheme][degree], rtol=5e-3)
    order = orders(errors)[-1]
    # quadratic Jacobi and Gauss-Seidel reach their asymptotes late: the error changes its sign at such steps
    assert abs(order - (degree + 1)) < (0.15 if degree < 2 else 0.5)


@pytest.mark.parametrize("split", full_but(("FD",), ("FF", "FD", "DD")))
def test_the_iteration_finds_the_implicit_step(split):
    """The table's numbers are those of the fixed point."""
    for degree, expected in enumerate(ERRORS[split, "iterative", "immediate"]):
        assert final_error(split, "iterative", "immediate", degree, 5e-3) == pytest.approx(expected[1], rel=5e-3)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "iterative"])
def test_order_from_a_start_without_a_past(algorithm):
    """The start with lower degree costs nothing up to linear inputs."""
    for degree in (0, 1):
        errors = []
        for step in (2.5e-3, 1.25e-3, 6.25e-4):
            result = run(read_scene(two_masses(algorithm, step, degree)))
            reached = [result[f"{u}.{n}"][-1] for u, n in STATES]
            errors.append(np.abs(reached - exact_two_masses(1.0)).max())
        assert abs(slope([4.0, 2.0, 1.0], errors) - (degree + 1)) < 0.15, degree
