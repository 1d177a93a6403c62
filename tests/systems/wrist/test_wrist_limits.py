"""Hard cases of the wrist: parallel axes, hard limits, too many constraints and their drift, hardly any inertia, long steps."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import StepFailed
from cosimo.components.wrist.kinematics import PROXIMAL_TILT, RULES, Axes, forward, inverse, small_angle_matrix
from cosimo.components.wrist.wrist import Wrist
from cosimo.components.wrist.wrist_equations import wrist_derivatives
from cosimo.tests.support import initialized

pytestmark = pytest.mark.full

FREE = {"proximal_damping": 0.0, "distal_damping": 0.0}
ALL = ("morphology", "constraint", "interaction", "load")


def wrist(effects=("morphology",), inputs=None, **parameters) -> Wrist:
    return initialized(Wrist(effects, {name.replace("__", "."): value for name, value in parameters.items()}), inputs)


# -- limits ------------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("stiffness", [200.0, 2000.0, 2e4])
def test_a_hard_limit_stops_the_hand_within_what_its_energy_allows(stiffness):
    """Thrown at the limit of deviation: depth at most sqrt(2 E / k), less energy behind than before, then rest."""
    substep = 1e-4 * math.sqrt(200.0 / stiffness) * 5.0
    made = wrist(
        ALL,
        interaction__stiffness=stiffness,
        substep=substep,
        start_proximal_rate=30.0,
        start_distal_rate=-35.0,
        interaction__contact_lower=-2.0,
    )
    before, deepest = made.energy(), 0.0
    for k in range(60):
        made.step(1e-3 * k, 1e-3)
        deepest = max(deepest, made["deviation"] - 0.610865)
    assert 0.0 < deepest < math.sqrt(2.0 * before / stiffness)
    assert 0.0 < made.energy() < before


def test_rest_against_a_limit():
    """Far beyond the range: tau = k_limit depth + k e, held for 3 s."""
    made = wrist(
        ALL,
        {"tau_deviation": 4.0},
        proximal_damping=0.1,
        distal_damping=0.1,
        interaction__contact_lower=-2.0,
        load__gravity_x=0.0,
        **{f"constraint__stiffness[{j}]": 0.0 for j in range(1, 6)},
    )
    made.step(0.0, 3.0)
    expected = (4.0 + 200.0 * 0.610865) / 201.0
    assert made["deviation"] == pytest.approx(expected, abs=1e-9)
    assert made["flexion"] == pytest.approx(0.0, abs=1e-9)


def test_grazing_a_limit_acts_the_less_the_less_it_is_touched():
    """The swing of the linear wrist ends at rate / frequency. A limit beyond does nothing, to the last bit; one before it by d
    acts for a time as sqrt(d) with a torque as d, and turns the rest of the motion by d^1.5."""
    inertia = 0.45 * 0.07**2 + 1e-3
    start = {**FREE, "row_inertia": 0.0, "start_proximal_rate": 2.0, "substep": 1e-4}
    end = 2.0 * math.cos(PROXIMAL_TILT) * math.sqrt(inertia / 1.0)
    free = wrist((), **start)
    free.step(0.0, 0.13)

    def changed(before: float) -> float:
        made = wrist(("interaction",), **start, interaction__stiffness=2.0, interaction__flexion_upper=end - before)
        made.step(0.0, 0.13)
        return float(np.abs(made.x - free.x).max())

    assert changed(-1e-6) == 0.0
    assert math.log(changed(4e-4) / changed(1e-4), 4.0) == pytest.approx(1.5, abs=0.05)


# -- constraints -----------------------------------------------------------------------------------------------------------
def test_a_row_that_rigid_ligaments_hold_does_not_drift():
    held = wrist(
        ("morphology", "constraint"), **FREE, constraint__kind="rigid", constraint__cut=2, start_distal_rate=3.0, substep=1e-2
    )
    held.step(0.0, 10.0)
    assert [held["proximal_angle"], held["proximal_rate"]] == [0.0, 0.0]


@pytest.mark.parametrize("stiffness", [1e5, 1e6])
def test_five_stiff_springs_hold_both_rows_by_their_tension(stiffness):
    """A small torque; a ligament under tension T that is shortest at rest is a stiffness T far beside share² / length."""
    strain = 0.1
    made = wrist(
        ("morphology", "constraint"),
        {"tau_flexion": 1e-3},
        proximal_damping=0.1,
        distal_damping=0.1,
        substep=5e-4,
        constraint__prestrain=strain,
        constraint__toe=0.0,
        row_inertia=0.0,
        **{f"constraint__stiffness[{j}]": stiffness for j in range(1, 6)},
    )
    made.step(0.0, 0.9)

    def held(far: float, share: float) -> float:
        per_length = stiffness * strain / (1.0 + strain)
        return per_length * far * 3e-3 * share**2

    rows = [held(12e-3, 0.7) + held(6e-3, 0.3) + held(6e-3, 0.15) + held(14e-3, 0.85), held(8e-3, 1.0)]
    A = small_angle_matrix()
    expected = np.linalg.solve(np.diag(rows) + A.T @ A, A.T @ [1e-3, 0.0])
    assert made.x[:2] == pytest.approx(expected, rel=1e-4)


# -- long steps and lost hands -----------------------------------------------------------------------------------------------
def test_one_long_step_is_many_short_ones():
    start = {"start_proximal_angle": 0.5, "start_distal_angle": -0.6, "substep": 4e-3}
    long, short = wrist(ALL, **start), wrist(ALL, **start)
    long.step(0.0, 4.0)
    for k in range(100):
        short.step(0.04 * k, 0.04)
    assert long.x == pytest.approx(short.x, abs=1e-13)
    assert long.work == short.work


@pytest.mark.parametrize(("angles", "fine"), [((0.0, 1.5), True), ((0.0, 1.53), False), ((2.9, 0.0), True), ((3.05, 0.0), False)])
def test_angles_of_the_hand_are_told_up_to_the_pole_of_deviation_and_nearly_a_half_turn(angles, fine):
    """Cosine of the deviation 0.05, flexion 3 rad, about axes that reach so far; nothing moves, nothing else ends the run."""
    axes = Axes(RULES, math.pi / 6.0, math.pi / 3.0, 0.0)
    there = dict(zip(("start_proximal_angle", "start_distal_angle"), inverse(*angles, axes)[:2], strict=True))
    made = wrist(
        flexion_stiffness=0.0,
        deviation_stiffness=0.0,
        morphology__proximal_tilt=math.pi / 6.0,
        morphology__distal_tilt=math.pi / 3.0,
        **there,
    )
    if fine:
        made.step(0.0, 1e-3)
        assert [made["flexion"], made["deviation"]] == pytest.approx(angles, abs=1e-9)
    else:
        with pytest.raises(StepFailed, match="farther than angles of a wrist can tell"):
            made.step(0.0, 1e-3)


@pytest.mark.parametrize(("rate", "fine"), [(990.0, True), (1010.0, False), (-1010.0, False)])
def test_a_row_that_turns_by_a_radian_within_a_substep_ends_the_run(rate, fine):
    """Linear, so that nothing else fails, and with one inertia of a tonne: it does not slow down."""
    made = wrist((), start_distal_rate=rate, transverse_inertia=1e3)
    if fine:
        made.step(0.0, 1e-3)
    else:
        with pytest.raises(StepFailed, match="a row by over a radian within a substep"):
            made.step(0.0, 1e-3)


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.5, -0.65), (-0.5, -0.71), (0.75, 0.29)])
@pytest.mark.parametrize("of_ligaments", [False, True])
def test_the_stable_step_holds_wherever_the_wrist_is(q, of_ligaments):
    """2.83, RK4's limit for what hardly damps itself, over the eigenvalues of the derivatives by differences.

    All limits are just touched, or all ligaments taut; the arms of these are taken at their longest, so it is far less there.
    """
    flexion, deviation, _ = forward(*q)
    stiffness = 0.0 if of_ligaments else 2000.0
    given = {f"interaction__{name}_{end}": there - off for end, off in (("upper", 1e-4), ("lower", 9.0))
             for name, there in (("flexion", flexion), ("deviation", deviation), ("contact", q[1]))}  # fmt: skip
    given |= {f"constraint__stiffness[{j}]": 1e6 * of_ligaments for j in range(1, 6)}
    made = wrist(
        ALL,
        **given,
        interaction__stiffness=stiffness,
        interaction__contact_stiffness=0.1 * stiffness,
        substep=1e-6,
        interaction__dissipation=0.0,
        constraint__toe=0.0,
        constraint__prestrain=0.1 * of_ligaments,
    )
    x, d, columns = np.r_[q, 0.0, 0.0], 1e-7, []
    for step in d * np.eye(4):
        ends = np.zeros((2, 4))
        for end, sign in zip(ends, (1.0, -1.0), strict=True):
            wrist_derivatives(0.0, x + sign * step, made.u[0], end, *made.arguments)
        columns.append((ends[0] - ends[1]) / (2.0 * d))
    limit = 2.83 / np.abs(np.linalg.eigvals(np.array(columns))).max()
    assert made.stable_step() < limit
    assert of_ligaments or made.stable_step() > limit / 1.2
