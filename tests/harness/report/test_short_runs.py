"""A report of a run that ended early shows what there is, and says what there is not."""

from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.analysis.signals import FINER, uniform
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, load_scene, read_scene
from cosimo.tests.support import two_masses


def page(result, directory):
    return report.for_run(result, directory, SYSTEMS).read_text(encoding="utf-8")


@pytest.mark.parametrize(("stop", "there", "not_there"), [
    (2.0, "Uplift of the contact wire", "Shape of the contact wire"),
    (4.0, "Shape of the contact wire", "All key results"),
])  # fmt: skip
def test_a_run_that_ends_before_or_in_its_window_shows_what_there_is(stop, there, not_there, tmp_path):
    html = page(run(load_scene("en50318-2002").with_changes({"stop_time": stop}), in_process=True), tmp_path)
    assert there in html
    assert not_there not in html
    assert "No statistics" in html
    assert "Contact force at 250 km/h" in html


@pytest.mark.interpreted
@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_run_that_failed_at_its_start_has_a_report(rows, tmp_path):
    for scene in (read_scene(two_masses()), load_scene("lumped-catenary").with_changes({"stop_time": 0.01})):
        whole = run(scene, in_process=True)
        columns = {name: values[:rows] for name, values in whole.columns.items()}
        partial = replace(
            whole, time=whole.time[:rows], columns=columns, info=replace(whole.info, outcome="failed", message="it broke")
        )
        assert "it broke" in page(partial, tmp_path)


@pytest.mark.full
def test_a_vehicle_whose_run_fails_has_its_figures_as_far_as_it_went(tmp_path):
    """An added mass above the mass, told as a force once a step: the acceleration grows from step to step."""
    told = {"algorithm": "gauss-seidel", "feedthrough": "delayed", "extrapolation": 0, "iteration": None}
    result = run(load_scene("rov-added-mass").with_changes({f"master.{k}": v for k, v in told.items()}), in_process=True)
    assert (result.outcome, result.time.size > 10) == ("unstable", True)
    html = page(result, tmp_path)
    assert "This run is unstable. The report shows the results up to that point. " in html
    assert "feedthrough" in result.message  # a shorter step fails earlier: it is not what to advise
    assert "Reduce" not in " ".join([result.message, *result.info.warnings])
    assert "Depth and attitude" in html


def test_a_unit_that_fails_in_the_run_leaves_a_report(tmp_path):
    scene = {"stop_time": 1.0, "units": {"p": {"component": "cosimo.tests.support:Probe", "parameters": {"fail_at": 0.5}}},
             "master": {"step": 0.1}}  # fmt: skip
    result = run(read_scene(scene), in_process=True)
    assert result.outcome == "failed"
    html = page(result, tmp_path)
    assert result.message in unescape(html)
    assert 'class="badge failed"' in html


def test_a_very_short_step_does_not_blow_up_a_record():
    time = np.array([0.0, 0.1, 0.1 + 1e-9, 0.2, 0.3])
    rate, even, (values,) = uniform(time, 2.0 * time)
    assert even.size == FINER * 4 + 1
    assert values == pytest.approx(2.0 * even)
    assert rate == pytest.approx(FINER * 4 / 0.3)
