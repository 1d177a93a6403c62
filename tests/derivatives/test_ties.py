"""Decisions at their very boundary are told, where they change a number; initial values whose derivatives follow later than they."""

from __future__ import annotations

from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.derivatives.test_tangent_run import short

if COMPILED:
    from cosimo.fmus.derivatives.compiled import Arena, Compiled
    from cosimo.orchestrator.derivatives.tangent_block import TangentBlock
    from cosimo.orchestrator.derivatives.tangent_run import tangent_run

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
LARGER = """  %more = fcmp ogt double %a, %b
  %m = select i1 %more, double %a, double %b"""
KEPT = "  store double %m, ptr %first"
JUDGED = """  %small = fcmp olt double %m, 1.000000e+01
  %y = select i1 %small, double %a, double 1.000000e+00
  store double %y, ptr %first"""
COUNTED = """  %n = fptosi double %m to i64
  %y = sitofp i64 %n to double
  store double %y, ptr %first"""


def told(lines: str, a: float, b: float) -> tuple[list[bool], float]:
    """Of the directions of a, of b and of both, whether a tie was told; and what has become of a."""
    text = f"""define i32 @model_step(double %t, double %h, i64 %address) {{
  %first = inttoptr i64 %address to ptr
  %second = getelementptr double, ptr %first, i64 1
  %a = load double, ptr %first
  %b = load double, ptr %second
{lines}
  ret i32 0
}}
"""
    arena = Arena(2, 4)
    arena.cells[:2], arena.tangents[:2, :3] = (a, b), [[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
    code = Compiled([text], 4)
    assert code.entry("model_step", 2)(0.0, 1.0, *arena.given()) == 0
    return [bool(int(arena.ties[0]) >> k & 1) for k in range(3)], float(arena.cells[0])


def test_the_larger_of_two_equal_numbers_is_told_where_it_is_kept():
    assert told(f"{LARGER}\n{KEPT}", 2.0, 2.0)[0] == [True, True, False]
    assert told(f"{LARGER}\n{KEPT}", 2.0, 3.0)[0] == [False, False, False]


@pytest.mark.parametrize("use", [JUDGED, COUNTED])
def test_it_is_not_told_where_it_only_decides_something_far_from_its_boundary(use):
    assert told(f"{LARGER}\n{use}", 2.5, 2.5)[0] == [False, False, False]


def test_a_decision_at_its_boundary_by_a_number_with_a_kink_is_told_for_all_directions():
    """The tangent of the larger of 10 and 10 is that of b, which does not move in the first direction; the number does, above 10."""
    assert told(f"{LARGER}\n{JUDGED}", 10.0, 10.0) == ([True, True, True], 1.0)


def test_initial_values_that_stand_at_once_pass_their_derivatives_on():
    """The error of a controller at a sleeve that starts at 0, which the controller was handed as 0 already: -1 m/m from the start on."""
    scene = short("friction-drive-step", 2, {"controller.effects.quantisation": False})
    with ExitStack() as stack:
        block = TangentBlock(scene, stack)
        rows = tangent_run(block, ["wheels.start_feed"])
    error = block.signals.index(("controller", "feed_error"))
    assert rows.values[0, error] == 0.0
    np.testing.assert_allclose(rows.tangents[0, error], [-1.0], rtol=1e-12)


@pytest.mark.full
@pytest.mark.parametrize("name", ["gimbal-rotor", "rotor-run-up"])
def test_derivatives_that_are_rounding_alone_stand(name):
    """Such as those of a bearing's force of 1e-13 N by a shear modulus of 8e10 Pa, 1e-25 N/Pa, in every sweep another one."""
    with ExitStack() as stack:
        block = TangentBlock(short(name, 2), stack)
        assert np.isfinite(tangent_run(block, block.parameters()).tangents).all()


@pytest.mark.full
@pytest.mark.parametrize(
    ("parameter", "signal"), [("controller.thruster_x[5]", "hull.pitch_rate"), ("tether.anchor_east", "tether.force_east")]
)
def test_an_exact_zero_decides_no_derivative(parameter, signal):
    """Rows of a regular arrangement are orthogonal already; a tether in a plane has no slope across it."""
    scene, d = short("rov-manoeuvre", 3), 1e-3
    with ExitStack() as stack, cosimo.open(scene) as session:
        block = TangentBlock(scene, stack)
        value, place = block.value(parameter), block.signals.index(tuple(signal.split(".")))
        exact = tangent_run(block, [parameter]).tangents[:, place, 0]
        runs = []
        for way in (d, -d):
            session.reset()
            session[parameter] = value + way
            session.initialize()
            session.record()
            session.until(scene.stop_time)
            runs.append(session.result()[signal])
    differences = (runs[0] - runs[1]) / (2.0 * d)
    assert np.max(np.abs(differences)) > 0.0
    np.testing.assert_allclose(exact, differences, rtol=1e-5, atol=1e-5 * np.max(np.abs(differences)))
