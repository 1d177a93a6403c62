"""Random stable linear systems, cut at random places, under every algorithm, against the matrix exponential of the whole."""

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import IterationSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.blocks import BLOCKS, System, system
from cosimo.tests.engine.algorithms.oscillators import give_past, open_master
from cosimo.tests.slopes import orders
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm


@st.composite
def systems(draw, loops: bool = True) -> System:
    """Two or three blocks, any that hand on at once (without `loops` at most one), any edges that make at least one circle."""
    n = draw(st.integers(2, BLOCKS))
    if loops:
        direct = tuple(draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    else:
        one = draw(st.integers(-1, n - 1))
        direct = tuple(k == one for k in range(n))
    edges = np.array(draw(st.lists(st.booleans(), min_size=n * n, max_size=n * n))).reshape(n, n) & ~np.eye(n, dtype=bool)
    assume(np.trace(np.linalg.matrix_power(edges.astype(int), 2) + np.linalg.matrix_power(edges.astype(int), 3)) > 0)
    return system(draw(st.integers(0, 2**32 - 1)), direct, tuple(edges.ravel().tolist()))


def largest_error(found: System, algorithm: str, degree: int, step: float) -> float:
    """Of all outputs and instants, started with the exact past."""
    iteration = IterationSettings(tolerance=1e-11, max_iterations=60)
    master = open_master(found.scene(step, algorithm=algorithm, extrapolation=degree), (), iteration)
    give_past(master, found.exact, step, degree)
    worst, states, forth = 0.0, found.start, expm(found.whole * step)
    rows = [found.row(end) for end in master.positions]
    for k in range(round(1.0 / step)):
        master.step(k * step, step)
        states = forth @ states
        worst = max(worst, float(np.abs(master.sample() - (found.outputs @ states)[rows]).max()))
    return worst


ROUNDING = 1e-10  # the iteration's tolerance is a tenth of it
STEPS = (1 / 64, 1 / 128)  # s; eigenvalues are of size 1 to 5


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "iterative"])
@settings(max_examples=12)
@given(found=systems(), degree=st.integers(0, 2))
def test_error_falls_with_the_expected_order(algorithm, found, degree):
    errors = [largest_error(found, algorithm, degree, step) for step in STEPS]
    if errors[-1] > ROUNDING:
        order = orders(errors)[0]
        assert order > degree + 1 - (0.15 if degree < 2 else 0.5), errors


@settings(max_examples=10)
@given(found=systems(loops=False), degree=st.integers(0, 2), seed=st.integers(0, 100))
def test_order_of_units_and_connections_is_irrelevant_to_jacobi(found, degree, seed):
    scene = found.scene(1 / 16, algorithm="jacobi", extrapolation=degree)
    rng = np.random.default_rng(seed)
    units, connections = list(scene["units"].items()), list(scene["connections"])
    rng.shuffle(connections)
    mixed = {**scene, "units": dict(units[k] for k in rng.permutation(len(units))), "connections": connections}
    one, other = run(read_scene(scene)), run(read_scene(mixed))
    for name in one.columns:
        assert one[name].tobytes() == other[name].tobytes()
