"""The new measures of the paper's case against independent answers."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems.rov.cases.paper_underwater_vehicle import losses, sea, tasks, wrench_sets
from cosimo.orchestrator.systems.rov.cases.paper_underwater_vehicle.layouts import AHEAD, ASTERN, MATRICES, ideal_power
from cosimo.orchestrator.systems.rov.cases.paper_underwater_vehicle.power import flat, given
from scipy.optimize import linprog

pytestmark = pytest.mark.interpreted


def by_linear_programme(matrix: np.ndarray, direction: np.ndarray) -> float:
    """Largest multiple of a wrench within the limits: maximise s subject to T F = s d."""
    n = matrix.shape[1]
    solution = linprog(
        np.r_[np.zeros(n), -1.0], A_eq=np.c_[matrix, -direction], b_eq=np.zeros(6), bounds=[(-ASTERN, AHEAD)] * n + [(0.0, None)]
    )
    return float(solution.x[-1])


@pytest.mark.parametrize("layout", MATRICES)
def test_facets_give_what_a_linear_programme_gives(layout):
    directions = np.random.default_rng(3).normal(size=(25, 6)) * [1.0, 1.0, 1.0, 0.2, 0.2, 0.2]
    directions = np.vstack((directions, np.eye(6), -np.eye(6)))
    for matrix in (MATRICES[layout], np.delete(MATRICES["eight"], 2, axis=1)):
        wanted = [by_linear_programme(matrix, d) for d in directions]
        np.testing.assert_allclose(wrench_sets.largest(matrix, directions), wanted, rtol=1e-7)


def test_the_volume_is_that_of_a_box_where_thrusts_are_the_wrench():
    assert wrench_sets.volume(np.eye(6)) == pytest.approx((AHEAD + ASTERN) ** 6, rel=1e-14)
    doubled = np.hstack((np.eye(6), np.eye(6)[:, :1]))  # one axis has two thrusters
    assert wrench_sets.volume(doubled) == pytest.approx(2.0 * (AHEAD + ASTERN) ** 6, rel=1e-14)


def test_a_lost_thruster_takes_its_axes():
    """Heave of six needs each of its three; eight keep what the other seven give."""
    left = wrench_sets.largest(np.delete(MATRICES["six"], 3, axis=1), np.eye(6))
    assert left[2] == left[4] == 0.0
    assert (left[[0, 1, 3, 5]] > 0.0).all()
    assert (wrench_sets.largest(np.delete(MATRICES["eight"], 3, axis=1), np.eye(6)) > 0.0).all()


def test_power_of_a_shared_force_falls_with_the_root_of_the_number():
    one, four = ideal_power(np.array([8.0])), ideal_power(np.full(4, 2.0))
    assert one / four == pytest.approx(2.0, rel=1e-14)
    # 10 N from a disc of 76 mm in sea water: induced speed sqrt(F / (2 rho A)), power F times that
    assert ideal_power(np.array([10.0])) == pytest.approx(10.0 * math.sqrt(10.0 / (2050.0 * math.pi * 0.038**2)), rel=1e-14)


def test_the_controller_gives_no_more_than_can_be_attained():
    for matrix in MATRICES.values():
        directions = wrench_sets.circle(0, 1, 36)
        assert (given(matrix, 1e3 * directions) <= wrench_sets.largest(matrix, directions) * (1.0 + 1e-9)).all()
    assert not flat(MATRICES["eight"])[3:5, :4].any()


def test_forces_on_a_held_hull_are_those_of_the_linear_wave():
    """(rho V + m_a) du/dt and d1 u + d2 u² of Wu's set, in deep water: k = w²/g."""
    w = 2.0 * math.pi / 6.0
    u = 0.5 * w * math.exp(-w * w / 9.80665 * 5.0)
    inertia, drag = sea.held("Wu 2018, BlueROV2 Heavy")
    assert inertia == pytest.approx((114.8 / 9.80665 + 5.5) * w * u, rel=1e-9)
    assert drag == pytest.approx(4.03 * u + 18.18 * u * u, rel=1e-9)


def test_tasks_and_losses_are_checked_scenes():
    for layout, count in (("six", 6), ("eight", 8)):
        for task in tasks.TASKS:
            assert tasks.scene(task, layout).stop_time >= 60.0
        faults = losses.failing(layout, count).faults
        assert [f.signal for f in faults] == [f"thruster_{count}.thrust", f"thruster_{count}.status.available"]
