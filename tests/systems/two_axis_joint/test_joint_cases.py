"""The case of the split chain passes, its table follows from the matrices of the linearised links, and another joint fails it."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.validation import Options, Runs
from cosimo.orchestrator.harness.validation.case import compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems.two_axis_joint.cases import link_split
from scipy.linalg import expm
from scipy.optimize import brentq

MASS, LENGTH, CENTRE, INERTIA, GRAVITY = 1.0, 1.0, 0.5, 1.0 / 12.0, 9.81
STIFFNESS, DAMPING, TURNING = 1e5, 100.0, 0.05
# q = (angle of the first link, place of the second's centre across, its angle); opening = OPENING q
OPENING = np.array([-LENGTH, 1.0, -CENTRE])
M = np.diag([INERTIA + MASS * CENTRE**2, MASS, INERTIA])
K = MASS * GRAVITY * np.diag([CENTRE + LENGTH, 0.0, CENTRE])  # its own weight, and the second link's at the joint
D = TURNING * np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 1.0]])


def first_order(stiffness, damping):
    zero, one = np.zeros((3, 3)), np.eye(3)
    return np.block([[zero, one], [-np.linalg.solve(M, stiffness), -np.linalg.solve(M, damping)]])


def rows():
    return {r.measure: r for r in load_table("link-split").rows}


def test_the_table_has_the_eigenvalues_of_the_linearised_links():
    joint = np.outer(OPENING, OPENING)
    values = np.linalg.eigvals(first_order(K + STIFFNESS * joint, D + DAMPING * joint))
    slow = sorted(values[(values.imag > 0.0) & (values.imag < 100.0)], key=lambda v: v.imag)
    measured = {f"{n}.{k}": v for k, s in enumerate(slow, 1) for n, v in (("frequency", s.imag), ("decay", -s.real))}
    compared = compare(tuple(rows()[n] for n in measured), measured)
    assert all(abs(r.simulated - 0.5 * (r.reference.low + r.reference.high)) < 1e-5 * r.simulated for r in compared)


def test_the_table_has_the_limit_of_held_forces():
    """Spectral radius of a macro step: the links move exactly under forces that are held from its start."""
    push = np.vstack((np.zeros((3, 2)), np.linalg.solve(M, np.column_stack((-OPENING, [1.0, 0.0, -1.0])))))
    held = np.vstack((np.r_[STIFFNESS * OPENING, DAMPING * OPENING], np.r_[0.0, 0.0, 0.0, -TURNING, 0.0, TURNING]))

    def growth(step):
        system = np.zeros((8, 8))
        system[:6, :6], system[:6, 6:] = first_order(K, np.zeros((3, 3))), push
        over = expm(step * system)
        return np.abs(np.linalg.eigvals(over[:6, :6] + over[:6, 6:] @ held)).max() - 1.0

    limit = 1e3 * brentq(growth, 1.5e-3, 2.5e-3)
    row = rows()["limit"]
    assert limit == pytest.approx(0.5 * (row.low + row.high), rel=1e-6)
    assert limit == pytest.approx(2e3 * DAMPING / STIFFNESS, rel=1e-3)


def assert_plain_coupling_is_lost(findings):
    """Where the iteration is not."""
    _, table, _ = findings.charts
    last = {row[0]: row[-1] for row in table.rows}
    assert [kind for kind, text in last.items() if text != "lost"] == ["iterative, held"]


def test_a_joint_with_another_stiffness_fails(monkeypatch):
    """A tenth of the stiffness shows in the second mode's frequency, by 1e-5 of it."""
    monkeypatch.setattr(link_split, "STIFFNESS", 1e4)
    motion = link_split.small_motion(Runs(Options(in_process=True), {}))
    measured = {f"{n}.{k}": v for n, values in motion.items() for k, v in enumerate(values, 1)}
    inside = {r.reference.measure: r.inside for r in compare(load_table("link-split").rows, measured)}
    assert not inside["frequency.1"]
    assert not inside["frequency.2"]
