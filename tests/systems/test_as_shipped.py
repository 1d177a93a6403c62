"""Every shipped scene and case once by its command, with the default packaging and its report, as a reader of the README does.

The short run has a case of each system, in process. What a run of a few steps has to show follows here, where all kernels are in
memory.
"""

import json
from contextlib import suppress

import pytest
from cosimo import BadInput
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.validation.case import Case, outcome
from cosimo.orchestrator.harness.validation.questions import Options
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, cases, load_scene, summary
from cosimo.tests.commands import exit_code
from cosimo.tests.short_run import FIRST_OF_SYSTEM, full_but, price, shipped_scenes
from cosimo.tests.systems.bearings.test_thermal_case import assert_another_route
from cosimo.tests.systems.two_axis_joint.test_joint_cases import assert_plain_coupling_is_lost
from cosimo.tests.systems.wind_pump.test_converter_case import assert_held_speeds_are_closer

SHORTEST = min(shipped_scenes(), key=lambda name: price(shipped_scenes()[name]))
UNDECIDED = ("passed", "unconfirmed", "undecided")
SHORT = ("jeffcott", "rov-allocation", "wind-pump-equilibrium", "four-bar")  # others in their own files
WITH_ERRORS = ("jeffcott", "four-bar", "wind-pump-equilibrium")  # every run is repeated with half of its steps
FURTHER = {  # what the findings of a case show beside its verdict; each case is computed once
    "inertial-converter": assert_held_speeds_are_closer,
    "link-split": assert_plain_coupling_is_lost,
    "thermal-scaling": assert_another_route,
}
OUTSIDE = {  # papers whose rows are looked at one by one -> the measures of those outside, as their reviews say
    "paper-pantograph": {
        *("max.250", "min.250", "uplift_mm.250"),
        *("std.300", "statistical_max.300", "statistical_min.300", "max.300", "min.300", "uplift_mm.300"),
    },
    "paper-pipe-robots": set(),
    "paper-servo-drive": set(),
    "paper-two-links": set(),
    "paper-underwater-vehicle": set(),
    "paper-wind-pump": {"gust.lever"},  # the lever of the scene is too thin for gusts of 12 m/s
    "paper-wrist": {
        *("roll.stiffness", "strain.lunate_radius", "strain.trapezium_scaphoid", "cut.several"),
        # a living wrist denies one axis of the proximal row
        *(f"poses.left.{bone}" for bone in ("sca", "lun", "trq")),
        *("poses.apart.errors", "poses.carried.left", "poses.radial.errors", "poses.ulnar.errors", "poses.halves"),
    },
}


def done(command, name, folder, *options):
    """Whether a command ends with exit code 0, which a row outside of its range is not."""
    assert exit_code(command, name, "-o", str(folder), *options) == 0


def assert_figures(scene, html):
    """Of the system, or why there are none, before the signals."""
    assert "Recorded signals" in html
    if scene.analysis.system:
        assert "<figure" in html.partition("Recorded signals")[0] or "There are no figures of system" in html


@pytest.mark.full
@pytest.mark.parametrize("name", shipped_scenes())
def test_a_scene_runs_by_its_command_and_raises_no_alarm(name, tmp_path, capsys):
    done("run", name, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert len(page) > 10_000
    assert_figures(load_scene(name), page)
    info = json.loads((tmp_path / "run.json").read_text())
    assert info["outcome"] == "done"  # and not "unstable"
    assert info["verification"]["done"], info["verification"]
    printed = capsys.readouterr()
    assert "Traceback" not in printed.out + printed.err


@pytest.mark.parametrize(
    ("name", "steps"),
    full_but(
        ((SHORTEST, 1), (SHORTEST, 10)),
        [*((name, 1) for name in shipped_scenes()), *((name, 10) for name in sorted({SHORTEST, *FIRST_OF_SYSTEM.values()}))],
    ),
)
def test_a_run_of_few_steps_has_a_report(name, steps, tmp_path, monkeypatch):
    if steps > 1:  # natural frequencies are of the scene, however long it runs
        monkeypatch.setattr("cosimo.orchestrator.systems.rotor.figures.whirl", lambda result, record: None)
    scene = load_scene(name)
    step = scene.master.step
    snapshots = {"record.snapshot_interval": step} if scene.record.snapshots else {}
    every = {"record.interval": None, "faults": []}  # faults come later in a run, and a scene whose faults never come is refused
    result = run(scene.with_changes({"stop_time": round(steps * step, 12), **snapshots, **every}), in_process=True)
    assert result.time.size == steps + 1
    html = report.for_run(result, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    with suppress(BadInput):  # where the statistics' window or transient is beyond these few steps
        names = [row.name for row in summary(result)]
        assert len(set(names)) == len(names)
        assert all(name.partition(".")[0] in {u.partition(".")[0] for u in scene.units} | {"links"} for name in names)
    assert_figures(scene, html)


@pytest.mark.parametrize("name", SHORT)
def test_a_case_passes(name):
    found = cases()[name].findings(Options(in_process=True))
    assert outcome(found.rows) == "passed", [(r.reference.measure, r.simulated) for r in found.rows if not r.inside]
    assert found.complete
    assert found.charts
    assert {r.reference.measure for r in found.rows} == {r.measure for r in load_table(name).rows}


@pytest.mark.full
@pytest.mark.parametrize("name", sorted(cases()))
def test_a_case_is_validated_by_its_command(name, tmp_path, capsys, monkeypatch):
    found, findings = [], Case.findings
    monkeypatch.setattr(Case, "findings", lambda *given: found.append(findings(*given)) or found[-1])
    done("validate", name, tmp_path, *([] if name in WITH_ERRORS else ["--no-verify"]))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert len(page) > 10_000
    assert "<figure" in page or page.count("<table") > 1  # what the case shows, beside its rows
    (case,) = json.loads((tmp_path / "validation.json").read_text())["cases"]
    assert case["outcome"] in UNDECIDED, case["verdict"]
    outside = [row for row in case["rows"] if not row["inside"] and row["standing"] != "unconfirmed"]
    assert outside == [] or case.get("claims")  # of a paper the claims decide, see `CaseResult.outcome`
    if name in OUTSIDE:
        measures = {(row.quantity, row.condition): row.measure for row in load_table(name).rows}
        assert {measures[row["quantity"], row["condition"]] for row in case["rows"] if not row["inside"]} == OUTSIDE[name]
    assert name not in WITH_ERRORS or any(row["error"] for row in case["rows"])
    assert "Traceback" not in capsys.readouterr().err
    FURTHER.get(name, bool)(found[0])
