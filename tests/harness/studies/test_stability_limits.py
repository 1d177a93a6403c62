"""Limits of the macro step as a study: over maps, schemes without derivatives, refusals, files. Limits: `test_stability`."""

import csv
import math

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.harness.report.studies.stability import limit_cells
from cosimo.orchestrator.harness.studies.stability import SchemeLimit, StabilityMap, schemes_of, stability
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.derivatives.coupled_masses import HERE
from cosimo.tests.run.judgement.closed_form import longest_step

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def spring(c=4.0, ground=0.0, **master):
    """1 kg on 100 N/m and a damper, which are another unit; ground: a damper of its own."""
    return read_scene(
        {
            "stop_time": 30.0,
            "connections": ["s.force -> m.force", "m.x_out -> s.x1", "m.v_out -> s.v1"],
            "units": {
                "m": {"component": f"{HERE}:Owner", "parameters": {"c": ground, "x0": 1.0}},
                "s": {"component": f"{HERE}:Between", "parameters": {"cc": c}},
            },
            "master": {"algorithm": "jacobi", "step": 0.02} | master,
        }
    )


def limit(scene, algorithm, degree):
    (found,) = stability(scene, [(algorithm, degree)]).limits
    return found


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_shipped_scene_meets_the_closed_form_over_its_map(degree):
    """At the corners of the map: damping from a twentieth to four fifths of the critical one."""
    scene = load_scene("mass-on-spring")
    table = scene.study.stability
    corners = {name: [min(values), max(values)] for name, values in table.items()}
    found = stability(scene.with_changes({"study.stability": corners}), [("gauss-seidel", degree)])
    assert list(found.varied.values()) == ["N/m", "kg"]
    assert len(found.limits) == 4
    for one in found.limits:
        k, m = one.point["spring.stiffness"], one.point["mass.mass"]
        assert one.longest == pytest.approx(longest_step(k / m, 4.0 / m, degree), rel=1e-6), one.point
        assert one.how == "eigenvalue"


@pytest.mark.full
def test_growth_along_the_run_has_a_limit_of_one_per_cent():
    found = limit(load_scene("lumped-catenary"), "gauss-seidel", 1)
    assert found.how == "growth along the run"
    assert 8e-3 < found.longest < found.tried < 1.02 * found.longest < 1.2e-2


def test_what_grows_by_itself_is_said():
    """A mass that a negative damper drives grows at every step."""
    assert "grow by themselves" in stability(spring(0.0, -0.2), [("jacobi", 2)]).remarks[0]
    assert stability(spring(), [("jacobi", 2)]).remarks == ()


@pytest.mark.parametrize(("algorithm", "words"), [("interface-model", "contacts"), ("iterative", "iterative")])
def test_a_scheme_that_is_not_examined_is_in_the_table_with_its_reason(algorithm, words):
    found = limit(spring(), algorithm, 1)
    assert math.isnan(found.longest)
    assert words in found.seen


def test_every_algorithm_whose_steps_have_derivatives_is_measured_unless_some_are_named():
    assert schemes_of() == [(name, degree) for name in ("jacobi", "gauss-seidel") for degree in (0, 1, 2)]
    assert schemes_of(["iterative"], [1]) == [("iterative", 1)]


@pytest.mark.parametrize(
    ("longest", "tried", "told"),
    [
        (0.2, 0.3, "stable"),
        (0.09, 0.1, "unstable"),
        (math.inf, 0.2, "stable"),
        (math.inf, 0.05, "–"),
        (0.0, 0.05, "unstable"),
        (0.0, 0.2, "–"),
        (math.nan, 0.1, "–"),
    ],
)
def test_the_table_says_what_the_scenes_own_step_is(longest, tried, told):
    """Of a step of 0.1 s; beyond the steps that were tried nothing is known."""
    scene = spring().with_changes({"master.step": 0.1, "stop_time": 10.0})
    limits = tuple(SchemeLimit({}, "jacobi", degree, longest, "", tried) for degree in (scene.master.extrapolation, 2))
    cells = limit_cells(StabilityMap(scene, {}, limits, ()))
    assert "the scene's 0.1 s" in cells.header
    assert [row[2] for row in cells.rows] == [told, told]
    assert [("(the scene's)" in row[0]) for row in cells.rows] == [scene.master.algorithm == "jacobi", False]


def test_order_control_and_faults_of_a_scene_do_not_stand_in_the_way():
    scene = spring(algorithm="gauss-seidel", order=["s", "m"], control={"method": "milne"})
    found = stability(scene, [("jacobi", 0), ("gauss-seidel", 0)])
    assert [one.longest for one in found.limits] == pytest.approx([0.08, 0.08], rel=1e-6)
    assert "without step control" in found.remarks[0]


def test_what_has_no_coupling_that_could_grow_is_refused():
    with pytest.raises(BadInput, match="feeds back"):
        stability(load_scene("double-pendulum"))


def test_the_table_of_a_map(tmp_path):
    scene = spring().with_changes({"study.stability": {"s.cc": [1.0, 4.0]}})
    found = stability(scene, [("jacobi", 0), ("jacobi", 1)])
    rows = list(csv.reader(found.save(tmp_path).open(encoding="utf-8")))
    assert rows[0] == [
        "s.cc, N.s/m",
        "algorithm",
        "extrapolation",
        "longest stable macro step, s",
        "told by",
        "growth with short steps, 1/s",
        "seen",
        "tried, s",
    ]
    assert len(rows) == 1 + 2 * 2
    assert [float(row[0]) for row in rows[1:]] == [1.0, 1.0, 4.0, 4.0]
    assert [float(row[3]) for row in rows[1:]] == [one.longest for one in found.limits]
