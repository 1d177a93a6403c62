"""The macro step as a map: its state and Jacobian by tangents against matrices written down by hand, and made in Python."""

from __future__ import annotations

from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.derivatives.coupled_masses import as_kernels
from cosimo.tests.engine.algorithms.oscillators import TwoMasses, radius

if COMPILED:
    from cosimo.orchestrator.derivatives.cells import cell_name
    from cosimo.orchestrator.derivatives.coupled_step import CoupledStep, common_steps
    from cosimo.orchestrator.derivatives.tangent_block import TangentBlock

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STEPS = 5e-3, 2e-2, 0.06, 0.115


def by_hand(degree: int, h: float, m: float = 1.0, k: float = 100.0, c: float = 6.0) -> np.ndarray:
    """A step of a mass whose spring's force is extrapolated: position, velocity, forces at 0, -h, -2 h."""
    value, slope, bend = np.zeros((3, degree + 1))
    value[0] = 1.0
    if degree == 1:
        slope[:] = np.array([1.0, -1.0]) / h
    if degree == 2:
        slope[:], bend[:] = np.array([1.5, -2.0, 0.5]) / h, np.array([0.5, -1.0, 0.5]) / h**2
    step = np.zeros((degree + 3, degree + 3))
    step[0, :2], step[1, 1] = (1.0, h), 1.0
    step[0, 2:] = (value * h**2 / 2.0 + slope * h**3 / 6.0 + bend * h**4 / 12.0) / m
    step[1, 2:] = (value * h + slope * h**2 / 2.0 + bend * h**3 / 3.0) / m
    step[2] = -(k * step[0] + c * step[1])
    step[3:, 2:-1] = np.eye(degree)
    return step


def largest(matrix: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def coupling_radius(step: CoupledStep) -> float:
    state = step.state()
    return max((largest(state.jacobian[np.ix_(block, block)]) for block in step.coupling_blocks(state)), default=0.0)


def opened(scene, stack: ExitStack) -> CoupledStep:
    step = CoupledStep(TangentBlock(scene, stack))
    step.begin()
    return step


def on_spring(**changes):
    return cosimo.load_scene("mass-on-spring").with_changes({"spring.damping": 6.0, **changes})


@pytest.mark.parametrize("velocity", [1.0, 0.0])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_radius_of_a_mass_on_a_spring_is_that_of_the_matrix_by_hand(algorithm, degree, velocity):
    """At rest, too, where no input moves at all."""
    scene = on_spring(**{"master.algorithm": algorithm, "master.extrapolation": degree, "mass.start_velocity_x": velocity})
    with ExitStack() as stack:
        block = TangentBlock(scene, stack)
        for h in STEPS:
            step = CoupledStep(block, h)
            step.begin()
            assert coupling_radius(step) == pytest.approx(largest(by_hand(degree, h)), abs=1e-13)


def test_the_state_is_what_is_read_before_it_is_written():
    with ExitStack() as stack:
        step = opened(on_spring(**{"master.extrapolation": 2}), stack)
        names = [cell_name(step.block, cell) for cell in step.state().cells]
        assert names == [f"mass.x[{k}]" for k in range(6)] + [
            f"mass.base_force_x ({s})" for s in ("present", "before", "earlier")
        ]
        assert step.block.time == pytest.approx(2.0 * step.block.h)


@pytest.mark.parametrize(
    ("split", "algorithm", "feedthrough"),
    [
        ("FF", "jacobi", "immediate"),
        ("FD", "jacobi", "immediate"),
        ("FD", "jacobi", "delayed"),
        ("DD", "jacobi", "immediate"),
        ("FD", "gauss-seidel", "delayed"),
        ("DD", "gauss-seidel", "immediate"),
    ],
)
def test_radii_of_two_masses_are_those_of_the_matrix_made_in_python(split, algorithm, feedthrough):
    for degree in (0, 1, 2):
        settings = {"algorithm": algorithm, "extrapolation": degree, "feedthrough": feedthrough}
        with ExitStack() as stack:
            block = TangentBlock(read_scene(as_kernels(TwoMasses().scene(split, 1e-2, **settings))), stack)
            for h in (1e-3, 1e-2, 3e-2):
                step = CoupledStep(block, h)
                step.begin()
                expected = radius(TwoMasses().scene(split, h, 1.0, **settings))
                assert coupling_radius(step) == pytest.approx(expected, abs=2e-13)


def test_a_unit_with_a_rate_of_its_own_has_the_map_of_its_period():
    """Held inputs: the mass steps once in three macro steps, under the force of their beginning."""
    h, k, c = 0.01, 100.0, 6.0
    period = 3.0 * h
    hand = np.array([[1.0 - k * period**2 / 2.0, period - c * period**2 / 2.0], [-k * period, 1.0 - c * period]])
    scene = on_spring(**{"master.extrapolation": 0, "master.step": h, "units.mass.every": 3})
    with ExitStack() as stack:
        step = opened(scene, stack)
        assert step.steps == 3
        for _ in range(4):  # at each phase
            assert coupling_radius(step) == pytest.approx(largest(hand), abs=1e-12)
            step.block.advance(1)


def test_products_are_those_of_the_jacobian_and_of_differences():
    rng = np.random.default_rng(1)
    with ExitStack() as stack:
        step = opened(on_spring(**{"master.algorithm": "jacobi"}), stack)
        block = step.block
        block.advance(7)
        cells, jacobian, _ = step.state()
        directions = rng.standard_normal((cells.size, 11))
        np.testing.assert_allclose(step.derivative(cells, directions, cells), jacobian @ directions, rtol=0, atol=1e-13)
        five = step.derivative(cells, directions, cells, 5)
        np.testing.assert_allclose(five, step.derivative(cells, np.eye(cells.size), cells, 5) @ directions, rtol=0, atol=1e-12)
        numbers, before = block.cells, block.save()
        moved = []
        for way in (1e-6, -1e-6):
            numbers[cells] += way * directions[:, 0]
            block.advance(5)
            moved.append(numbers[cells])
            block.restore(before)
        np.testing.assert_allclose((moved[0] - moved[1]) / 2e-6, five[:, 0], rtol=1e-6, atol=1e-8)


def test_a_session_is_taken_where_it_stands():
    """A pendulum has another Jacobian at each instant: that of the session's is that of a run of its own to there."""
    scene = cosimo.load_scene("double-pendulum")
    with ExitStack() as stack, cosimo.open(scene) as session:
        session.initialize()
        session.step(40)
        step = CoupledStep(TangentBlock(scene, stack))
        step.take(session._master, session.time)
        there = step.state().jacobian
        step.begin()
        at_start = step.state().jacobian
        step.block.advance(40 - step.block.taken)
        np.testing.assert_allclose(step.state().jacobian, there, rtol=1e-10, atol=1e-12)
        assert np.abs(there - at_start).max() > 1e-3


def test_periods_that_do_not_meet_are_refused():
    scene = cosimo.load_scene("friction-drive-step")
    assert common_steps(scene, scene.master.step) == 2
    with pytest.raises(BadInput, match="periods that meet"):
        common_steps(scene, 1.2345e-4)
