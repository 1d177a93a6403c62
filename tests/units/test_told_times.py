"""What foreign FMUs are told of a run: start, stop, tolerance and steps, from their own default experiment or a scene's."""

from __future__ import annotations

import json
import os
import shutil

import numpy as np
import pytest
from cosimo import BadInput, compare, load_scene, read_scene, run, write_scene
from cosimo.orchestrator.cli.application import app
from cosimo.orchestrator.units.fmu_messages import FmuLog
from cosimo.tests.units.native import STATE, native_fmu
from typer.testing import CliRunner

WAYS = [(2, "none"), (3, "none"), (2, "process"), (3, "process")]


def told(fmi, experiment="", flags=""):
    """Path of the FMU with a default experiment."""
    change = ("</TypeDefinitions>", f"</TypeDefinitions><DefaultExperiment {experiment}/>")
    return native_fmu("told", fmi, flags, *([change] if experiment else []))


def scene(fmu, isolation="none", master=None, record=None, **more):
    """The FMU alone, from 10 to 11 s."""
    parameters = more.pop("parameters", {})
    times = {"start_time": 10.0, "stop_time": 11.0} | more
    return read_scene(
        {
            **times,
            "units": {"f": {"fmu": fmu, "isolation": isolation, "parameters": parameters}},
            "master": {"step": 0.1, **(master or {})},
            "record": record or {},
        }
    )


@pytest.mark.parametrize(("fmi", "isolation"), WAYS)
def test_every_unit_is_told_start_stop_and_tolerance(fmi, isolation):
    result = run(scene(told(fmi, 'tolerance="1e-5"'), isolation), verify="no")
    assert result.time.tolist() == [10.0, 10.1, 10.2, 10.3, 10.4, 10.5, 10.6, 10.7, 10.8, 10.9, 11.0]
    assert result["f.now"] == pytest.approx(result.time, rel=1e-15)
    last = {name: result[f"f.{name}"][-1] for name in ("start", "stop", "tolerance")}
    assert last == {"start": 10.0, "stop": 11.0, "tolerance": 1e-5}
    assert result.info.timing.simulated == pytest.approx(1.0)


TIMES = [  # default experiment, changes -> start, stop, step
    ('startTime="10" stopTime="20" stepSize="0.5"', {}, (10.0, 20.0, 0.5)),
    ('startTime="-1" stopTime="1" stepSize="0.5"', {}, (-1.0, 1.0, 0.5)),
    ('startTime="10"', {}, (10.0, 11.0, 1e-3)),
    ('startTime="10" stopTime="5"', {}, (10.0, 11.0, 1e-3)),
    ('stopTime="2"', {"master.step": 0.5}, (0.0, 2.0, 0.5)),
    ('stopTime="2" stepSize="0.5"', {"start_time": 1.0}, (1.0, 2.0, 0.5)),
    ('stopTime="2" stepSize="0.5"', {"stop_time": 0.25}, (0.0, 0.25, 0.25)),
    ('stopTime="2" stepSize="4"', {"master.step": 0.5}, (0.0, 2.0, 0.5)),
]


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_default_experiment_is_used_and_options_are_judged_with_it(fmi):
    for experiment, changes, expected in TIMES:
        alone = load_scene(told(fmi, experiment), changes)
        assert (alone.start_time, alone.stop_time, alone.master.step) == expected, experiment


def test_the_fixed_internal_step_is_the_default_step():
    fmu = told(3, 'stopTime="10"', 'fixedInternalStepSize="0.25"')
    assert load_scene(fmu).master.step == 0.25
    assert load_scene(fmu, {"master.step": 0.5}).coupling
    with pytest.raises(BadInput, match=r"master.step: got 0.3 s, expected a multiple of 0.25 s, the fixed internal step"):
        assert load_scene(fmu, {"master.step": 0.3}).coupling
    given = told(3, 'stopTime="10" stepSize="0.3"', 'fixedInternalStepSize="0.25"')
    assert CliRunner().invoke(app, ["run", given, "--step", "0.5", "--no-verify"]).exit_code == 0


def test_the_command_gives_start_and_stop(tmp_path):
    fmu = told(2, 'startTime="10" stopTime="20" stepSize="0.1"')
    made = CliRunner().invoke(
        app, ["run", fmu, "--start", "12", "--stop", "13", "--record", "fmu.start,fmu.stop", "-o", str(tmp_path), "--no-verify"]
    )
    assert made.exit_code == 0, made.output
    _, *rows = (tmp_path / "result.csv").read_text().splitlines()
    assert [float(x) for x in rows[-1].split(",")] == [13.0, 12.0, 13.0]
    assert json.loads((tmp_path / "run.json").read_text())["scene"]["start_time"] == 12.0


REFUSED = [
    ({"start_time": 11.0}, "stop_time: got 11 s, expected a time after start_time, 11 s"),
    ({"start_time": "2 m"}, "start_time"),
    ({"start_time": 1e15, "stop_time": 1e15 + 1.0}, "have no digits for shorter steps"),
    ({"start_time": 10.0, "stop_time": 10.05}, "at most the length of the run, 0.05 s"),
    ({"record": {"interval": 2.0}}, "record.interval: got 2 s, expected at most the length of the run, 1 s"),
]


def test_times_that_cannot_be_are_refused_in_one_sentence():
    for changes, words in REFUSED:
        with pytest.raises(BadInput) as caught:
            scene(told(2), **changes)
        assert words in str(caught.value)


def test_ways_to_write_a_start_time(tmp_path):
    """A text with its unit, a change, a file of TOML and one of SSP, whose FMUs' own times count where it has none."""
    fmu = told(2, 'startTime="3" stopTime="4" stepSize="0.1"')
    later = scene(fmu, start_time="10000 ms")
    assert later.start_time == 10.0
    assert later.with_changes({"start_time": 10.5}).duration == 0.5
    assert load_scene(write_scene(later, tmp_path / "later.toml")).start_time == 10.0
    packed = CliRunner().invoke(app, ["ssp", str(tmp_path / "later.toml"), "-o", str(tmp_path / "later.ssp"), "--force"])
    assert packed.exit_code == 0, packed.output
    (ssp,) = tmp_path.glob("*.ssp")
    assert (load_scene(ssp).start_time, load_scene(ssp).stop_time) == (10.0, 11.0)
    assert load_scene(ssp, {"stop_time": 12.0}).stop_time == 12.0


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_run_that_starts_later_is_the_same_run_later(fmi, tmp_path):
    """Rates, records, checkpoints, repetition and adaptive steps count from the start."""
    flags = STATE[fmi]
    fmu = native_fmu("van_der_pol", fmi, flags)
    now, later = (scene(fmu, start_time=t, stop_time=t + 1.0, record={"interval": 0.25}) for t in (0.0, 64.0))
    a, b = run(now), run(later)
    assert b.time == pytest.approx(a.time + 64.0, rel=1e-15)
    assert np.allclose(a["f.x0"], b["f.x0"], rtol=1e-12)
    assert b.info.verification.done
    assert b.info.verification.signals["f.x0"].rms == pytest.approx(a.info.verification.signals["f.x0"].rms, rel=1e-6)
    whole = later.with_changes({"record.interval": None})
    run(whole, verify="no", checkpoint_every=0.4, checkpoint_to=tmp_path / "c")
    resumed = run(whole, verify="no", resume=tmp_path / "c")
    assert resumed.info.resumed.at == 64.8
    assert resumed["f.x0"].tolist() == run(whole, verify="no")["f.x0"].tolist()


def test_component_controllers_and_faults_at_times():
    """A ramp by a fault begins at its time, and what began before the run is there from its start."""

    def spring(start, begin):
        data = load_scene("mass-on-spring").settings() | {"start_time": start, "stop_time": start + 0.2}
        data["faults"] = [
            {"signal": "spring.second_force_x", "kind": "override", "value": 1.0, "begin": begin, "end": start + 0.1}
        ]
        return run(read_scene(data), in_process=True, verify="no")

    a, b = spring(0.0, 0.05), spring(8.0, 8.05)
    assert np.allclose(b.time, a.time + 8.0)
    for name in a.columns:
        assert np.allclose(a[name], b[name], rtol=1e-9, atol=1e-12)
    early = spring(8.0, 0.0)
    assert early["spring.second_force_x"].size == a["spring.second_force_x"].size
    with pytest.raises(BadInput, match="a time after the start of the run, 9 s"):
        read_scene(
            load_scene("mass-on-spring").settings()
            | {"start_time": 9.0, "stop_time": 9.2, "faults": [{"signal": "spring.second_force_x", "kind": "freeze", "end": 8.0}]}
        )


def test_compare_looks_where_both_have_been():
    fmu = native_fmu("van_der_pol", 2, STATE[2])
    a, b = (scene(fmu, start_time=t, stop_time=2.0) for t in (0.0, 1.0))
    assert compare(a, b, verify="no").signals


@pytest.mark.parametrize(("fmi", "isolation"), WAYS)
def test_an_output_that_is_no_number_ends_a_run_only_where_it_matters(fmi, isolation):
    fmu = told(fmi)
    result = run(scene(fmu, isolation, parameters={"known_from": 10.35}), verify="no")
    assert result.outcome == "done"
    assert np.isnan(result["f.sensor"]).tolist() == [True] * 4 + [False] * 7
    assert [w for w in result.info.warnings if "sensor" in w] == ["f.sensor was no number at t = 10 s; no connection uses it"]
    wished = scene(fmu, isolation, parameters={"known_from": 10.35}, study={"quantities": ["f.sensor, maximum"]})
    failed = run(wished, verify="no")
    assert failed.outcome == "failed"
    assert "f failed at t = 10 s: output sensor, of which study.quantities asks a figure, was no number" in failed.message
    data = wished.settings() | {"connections": ["f.sensor -> g.u"], "study": {}}
    data["units"]["g"] = {"fmu": native_fmu("integrator", 2)}
    used = run(read_scene(data), verify="no")
    assert used.outcome == "failed"
    assert used.message.startswith("f failed at t = 10 s: output sensor is nan")


@pytest.mark.parametrize(("fmi", "isolation"), WAYS)
def test_what_a_foreign_fmu_says_is_counted_kept_and_told(fmi, isolation, tmp_path):
    result = run(scene(told(fmi), isolation, parameters={"chatty": 30}), verify="no", output=tmp_path / "out")
    assert result.outcome == "done"
    assert result.info.fmu_log["f"].counts == {"warning": 300, "returned a warning": 10}
    first, *others = (tmp_path / "out" / "fmu.log").read_text().splitlines()
    assert first == "t = 10 s  f  warning: step 1: the table was left at 10 s"
    assert (len(others), others[-1]) == (100, "f  warning: 200 more messages, which were counted only")
    assert others[31].startswith("t = 10.1 s")
    (warning,) = [w for w in result.info.warnings if "the table" in w]
    assert warning == "f: 300 messages of level warning, the first at t = 10 s: step 1: the table was left at 10 s"
    silent = run(scene(told(fmi), isolation), verify="no", output=tmp_path / "out", fmu_log="info")
    assert not silent.info.fmu_log
    assert not (tmp_path / "out" / "fmu.log").exists()
    only_errors = run(scene(told(fmi), isolation, parameters={"chatty": 1}), verify="no", fmu_log="error")
    assert only_errors.info.fmu_log["f"] == FmuLog({"warning": 10, "returned a warning": 10}, ())
    with pytest.raises(
        BadInput, match=r"fmu_log: got 'warnings', expected one of none, info, warning, .* Did you mean 'warning'"
    ):
        run(scene(told(fmi)), fmu_log="warnings")


@pytest.mark.parametrize(("fmi", "isolation"), WAYS)
def test_a_repetition_leaves_the_files_of_the_run(fmi, isolation, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(told(fmi), tmp_path / "told.fmu")
    result = run(scene("told.fmu", isolation, parameters={"writes": 1}), verify="whole")
    assert result.info.verification.done, result.info.verification
    assert result.info.verification.runs > 1
    assert (tmp_path / "written-by-the-fmu").read_text() == "a step\n" * 10
    assert os.getcwd() == str(tmp_path)
