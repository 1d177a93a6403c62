"""The accuracy study: orders and orderings on counted work, failures that stay in the picture, its table, components alone."""

import csv
import json
import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.report.studies.accuracy import for_accuracy
from cosimo.orchestrator.harness.studies.accuracy import OWN, Accuracy, Point, accuracy, front_of, with_finer_errors
from cosimo.orchestrator.harness.studies.component_accuracy import ComponentRun, component_accuracy
from cosimo.orchestrator.harness.studies.settings_axes import couplings, macro_steps, pinned, settings, without_effects
from cosimo.orchestrator.scene.shorter_steps import meshes
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.slopes import slope

SCENE = load_scene("mass-on-spring").with_changes({"stop_time": 2.0})


PLENTY = 1000.0  # s: some are needed, and nothing is left out on a machine that is busy


@pytest.fixture(scope="module")
def measured():
    return accuracy(SCENE, budget=PLENTY, repeats=1)


def line(measured, name):
    return sorted((p for p in measured.points if p.series == name and p.outcome == "done"), key=lambda p: p.size)


@pytest.mark.parametrize(("degree", "order"), [("held", 1), ("linear", 2), ("quadratic", 2)])
def test_errors_fall_with_the_order_of_the_inputs(measured, degree, order):
    """Parabolas give no third order here: a run begins without a past, and what its first step holds is wrong by h²."""
    points = [p for p in line(measured, f"gauss-seidel, {degree}") if p.size <= 1e-2]
    steps, errors = (np.log([getattr(p, key) for p in points]) for key in ("size", "error"))
    assert np.polyfit(steps, errors, 1)[0] == pytest.approx(order, abs=0.35)


def test_linear_inputs_need_at_most_half_the_macro_steps_of_held_ones_at_two_percent(measured):
    def steps(name):
        return min(p.work["macro_steps"] for p in line(measured, name) if p.error_with_finer <= 0.02)

    held = line(measured, "jacobi, held")
    assert all(p.error_with_finer > 0.02 or p.work["macro_steps"] >= 2 * steps("gauss-seidel, linear") for p in held)


@pytest.mark.full
def test_what_became_unstable_stays_with_its_reason():
    """A mass of 1 kg that gets a held force from spring and damper is stable up to min(2 d/k, 2 m/d), in closed form."""
    given = SCENE.units["spring"].parameters
    limit = min(2.0 * given["damping"] / given["stiffness"], 2.0 / given["damping"])
    found = accuracy(SCENE.with_changes({"master.step": 0.5 * limit, "stop_time": 10.0}), budget=PLENTY, repeats=1)
    unstable = [p for p in found.points if p.series == "jacobi, held" and p.size > 1.5 * limit]
    stable = [p for p in found.points if p.series == "jacobi, held" and p.size < 0.9 * limit]
    assert len(unstable) == len(stable) == 2
    assert all(p.outcome in ("failed", "useless") and p.reason and p.error_with_finer == math.inf for p in unstable)
    assert all(p.outcome == "done" for p in stable)
    assert not any(p in found.front(cost) for p in unstable for cost in ("seconds", "calls"))


def test_the_front_has_nothing_that_is_dearer_and_worse(measured):
    for cost in ("seconds", "calls"):
        front = measured.front(cost)
        assert [p.cost(cost) for p in front] == sorted(p.cost(cost) for p in front)
        assert [p.error_with_finer for p in front] == sorted((p.error_with_finer for p in front), reverse=True)
        for p in front:
            assert not any(
                q.outcome == "done" and q.cost(cost) < p.cost(cost) and q.error_with_finer < p.error_with_finer
                for q in measured.points
            )


def test_a_small_error_by_chance_is_not_held():
    points = [
        Point("a", "coupling", size, {}, "done", error=error, error_with_finer=error, seconds=1.0 / size)
        for size, error in ((4.0, 0.001), (2.0, 0.1), (1.0, 0.05))
    ]
    assert [p.error_with_finer for p in with_finer_errors(points)] == [0.1, 0.1, 0.05]
    assert [p.size for p in front_of(with_finer_errors(points), "seconds")] == [4.0, 1.0]


def test_the_setting_as_it_is_comes_first(measured):
    assert measured.points[0].series == OWN
    assert measured.own.changes == pinned(SCENE)
    other = SCENE.with_changes({"master.step": 1e-3, "master.algorithm": "jacobi", "mass.substep": 1e-4})
    assert other.with_changes(measured.own.changes).master == SCENE.master
    assert other.with_changes(measured.own.changes).units["mass"].parameters["substep"] == 1e-3
    assert measured.own.outcome == "done"


def test_what_the_budget_does_not_reach_is_named():
    short = accuracy(SCENE, budget=1e-3, repeats=1)
    assert {p.outcome for p in short.points[1:]} == {"skipped"}
    assert "budget of 0.001 s" in short.points[-1].reason


def test_the_table_has_names_with_units(measured, tmp_path):
    path = measured.save(tmp_path)
    with open(path, encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    assert header[:4] == ["series", "axis", "size, s or tolerance", "outcome"]
    assert "error of mass.base_x, time history" in header
    assert len(rows) == len(measured.points) + 2
    assert {len(row) for row in rows} == {len(header)}
    shared = header.index("shared with the reference")
    assert {row[shared] for row in rows} == {"the components' equations"}
    assert [row[0] for row in rows[-2:]] == ["agreement of the reference", "mesh error of the reference"]
    for point, row in zip(measured.points, rows, strict=False):
        assert json.loads(row[header.index("changes")]) == dict(point.changes)
        assert float(row[header.index("error with finer settings")]) == pytest.approx(point.error_with_finer, rel=1e-5)


def test_settings_make_sense_for_the_connections():
    lone = read_scene({"stop_time": 1.0, "master": {"step": 1e-2}, "units": {"m": {"component": "cosimo.tests.support:Mass"}}})
    assert [name for name, _ in couplings(lone)] == ["macro step"]
    chain = read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 1e-2},
            "connections": ["m.x_out -> s.position"],
            "units": {"m": {"component": "cosimo.tests.support:Mass"}, "s": {"component": "cosimo.tests.support:SpringDamper"}},
        }
    )
    assert not any(name.startswith("iterative") for name, _ in couplings(chain))
    assert any(name.startswith("iterative") for name, _ in couplings(SCENE))
    sizes = macro_steps(SCENE)
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] == SCENE.master.step / 2
    assert all(SCENE.with_changes(s.changes).master for s in settings(SCENE))


@pytest.mark.parametrize(
    ("mesh", "word"), [("mass.base_x", "length"), ("mas.substep", "unit.parameter"), ("mass", "unit.parameter")]
)
def test_a_mesh_is_a_parameter_of_a_component(mesh, word):
    with pytest.raises(BadInput, match=word):
        meshes(SCENE.with_changes({"study.mesh": [mesh]}))


def test_a_mesh_has_its_own_line():
    scene = SCENE.with_changes({"study.mesh": ["mass.substep"]})
    assert [s.changes for s in settings(scene) if s.axis == "mesh"] == [{"mass.substep": 2e-3}, {"mass.substep": 2.5e-4}]


def test_an_effect_less_is_shown_but_advised_by_no_front():
    scene = load_scene("link-split").with_changes({"stop_time": 0.05})
    named = {s.series: s.changes for s in without_effects(scene)}
    assert named["without joint.rotation"] == {
        "units.joint.effects": [],
        "units.joint.parameters": {"stiffness": 1e5, "damping": 100.0},
    }
    assert scene.with_changes(named["without second.gravity"]).units["second"].effects == ()
    cheap = Point("without a.gravity", "effect", 1.0, {}, "done", error=1e-9, error_with_finer=1e-9, seconds=1e-9)
    assert front_of([cheap], "seconds") == []


@pytest.mark.full
def test_a_component_alone_has_the_order_of_its_integrator():
    found = component_accuracy("BallBearing", stop=0.1, budget=10.0, repeats=1)
    own = [p for p in found.points if p.axis == "substep" and 1e-6 < p.error < 5e-3]
    assert len(own) >= 3
    assert slope([p.size for p in own], [p.error for p in own]) == pytest.approx(4.0, abs=0.3)
    assert found.smallest_known < 1e-7
    assert {p.series for p in found.points} > {"SciPy DOP853", "SciPy Radau", OWN}
    assert min(p.error for p in found.points if p.series == "SciPy DOP853") < 1e-3


def test_the_inputs_of_a_component_alone_go_through_the_wave_it_is_told():
    one = ComponentRun("PlanarLink", ("gravity",), stop=1.0)
    ends = np.einsum("j,kjm->km", one.step ** np.arange(3.0), one.inputs)
    np.testing.assert_allclose(ends[:-1], one.inputs[1:, 0], rtol=1e-12, atol=1e-14)  # without a jump between steps
    k = one.steps // 4  # a quarter of two waves: the top
    nominal = one.make().variables[one.make().inputs[0]].nominal
    assert one.inputs[k, 0, 0] == pytest.approx(0.05 * nominal, rel=1e-3)


@pytest.mark.parametrize("name", ["WaterCurrent", "RovController"])
def test_what_integrates_nothing_is_refused(name):
    with pytest.raises(BadInput, match="nothing that is integrated"):
        component_accuracy(name)


def test_an_accuracy_without_results_has_no_front():
    empty = Accuracy("a", "a", (Point(OWN, "own", 1.0, {}, "failed", "why"),), "", "", {}, "", "")
    assert empty.front() == []
    assert empty.smallest_known == math.inf


@pytest.mark.full
@pytest.mark.parametrize("own", [0.0, 1e-3])
@pytest.mark.parametrize("outcome", ["done", "failed"])
def test_a_page_of_runs_without_any_error_is_written(own, outcome, tmp_path):
    """Errors of zero have no place on an axis of logarithms, and no limit of one."""
    points = [Point(OWN, "own", 1e-3, {}, "done", error=own, error_with_finer=own, seconds=1.0, work={"calls": 9})]
    error = 0.0 if outcome == "done" else math.inf
    points += [
        Point("jacobi, held", "coupling", h, {}, outcome, error=error, error_with_finer=error, seconds=1.0) for h in (1e-3, 2e-3)
    ]
    text = for_accuracy(Accuracy("a", "a", tuple(points), "by hand", "by hand", {"x, end": 0.0}, "here", "now"), tmp_path)
    assert "Infinity" not in text.read_text(encoding="utf-8").partition("<main")[2].partition("</main")[0]


def test_a_scene_without_connections_is_measured():
    """A degree of extrapolation would have no effect there, and a scene with one is refused."""
    link = {"component": "PlanarLink", "effects": ["pinned", "gravity"], "parameters": {"start_angle": 0.5}}
    record = {"signals": ["link.angle"]}
    scene = read_scene({"stop_time": 0.1, "units": {"link": link}, "master": {"step": 1e-2}, "record": record})
    found = accuracy(scene, budget=PLENTY, repeats=1)
    assert {p.outcome for p in found.points} == {"done"}
