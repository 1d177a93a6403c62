"""Runs: times, labels, recording, failures, and FMU against in-process."""

import io
import json
import signal
import sys
from time import perf_counter, sleep

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene, write_report
from cosimo.components.core.variables import output
from cosimo.orchestrator.interrupts import STOPPING, Interrupted
from cosimo.orchestrator.run import progress
from cosimo.orchestrator.run.run import Run, run
from cosimo.orchestrator.scene import scene as checked
from cosimo.tests.contract.configurations import in_plain_python
from cosimo.tests.scene_runs import assert_fmus_give_the_same_bits
from cosimo.tests.short_run import FIRST_OF_SYSTEM, covering_scenes
from cosimo.tests.support import Linear, OfTime, Probe, signal_inside_a_library, two_masses
from numba.core import event

PROBE = {"stop_time": 1.0, "units": {"p": {"component": "cosimo.tests.support:Probe"}}, "master": {"step": 0.1}}


def test_samples_carry_their_own_time():
    result = run(read_scene(PROBE))
    assert len(result.time) == 11
    # t + h in the unit and the tick in the master are rounded separately: two roundings of numbers below 1
    assert np.abs(result["p.time"] - result.time).max() <= 2 * np.finfo(float).eps


def test_end_is_met_exactly_with_a_shorter_last_step():
    result = run(read_scene({**PROBE, "stop_time": 1.05}))
    assert result.time[-1] == 1.05
    assert result.time[-2] == 1.0


@pytest.mark.parametrize(("interval", "rows"), [(0.1, 11), (0.25, 5), (0.04, 11), (1e-3, 11)])
def test_a_macro_step_longer_than_the_interval_gives_a_row_each(interval, rows):
    result = run(read_scene(PROBE | {"record": {"interval": interval}}))
    assert result.rows == rows
    assert result["p.time"] == pytest.approx(result.time)


def test_recording_at_intervals_with_snapshots():
    record = {"signals": ["p.time"], "interval": 0.25, "snapshots": ["p.profile"], "snapshot_interval": 0.5}
    result = run(read_scene({**PROBE, "record": record, "units": {"p": {**PROBE["units"]["p"], "parameters": {"length": 4.0}}}}))
    # multiples of 0.25 s, each at the first macro step not before it, and the end
    assert result.time.tolist() == [0.0, 0.3, 0.5, 0.8, 1.0]
    assert list(result.columns) == ["p.time"]
    snapshot = result.snapshots["p.profile"]
    assert snapshot.time.tolist() == [0.0, 0.5, 1.0]
    assert snapshot.values.tolist() == [[4.0, 8.0, 12.0]] * 3


def test_array_elements_are_recorded_only_on_request():
    assert list(run(read_scene(PROBE)).columns) == ["p.time"]
    result = run(read_scene({**PROBE, "record": {"signals": ["p.profile"]}}))
    assert list(result.columns) == ["p.profile[1]", "p.profile[2]", "p.profile[3]"]
    assert result.measures["p.profile[2]"] == "mm"


def test_units_of_measure_are_converted():
    scene = {
        **PROBE,
        "connections": ["m.x_out -> p.length"],
        "record": {"signals": ["m.x_out", "p.profile[1]"]},
        "units": {**PROBE["units"], "m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}}},
    }
    result = run(read_scene(scene))
    # the mass moves freely: x = 2 t in m, and the probe sees it in mm; one rounding of the conversion
    np.testing.assert_allclose(result["p.profile[1]"], 2000.0 * result.time, rtol=1e-14)
    # an input that its polynomial has led to the fresh value but for rounding is left there
    np.testing.assert_allclose(result["p.profile[1]"], 1000.0 * result["m.x_out"], rtol=1e-14)


def test_a_failing_unit_leaves_a_partial_result(tmp_path):
    scene = {**PROBE, "units": {"p": {**PROBE["units"]["p"], "parameters": {"fail_at": 0.45}}}}
    result = run(read_scene(scene))
    assert result.outcome == "failed"
    assert "p failed at t = 0.4 s" in result.message
    assert result.time.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4]
    result.save(tmp_path)
    assert json.loads((tmp_path / "run.json").read_text())["outcome"] == "failed"
    assert len((tmp_path / "result.csv").read_text().splitlines()) == 1 + 5


def test_a_result_is_shown_in_one_line():
    scene = {**PROBE, "units": {"p": {**PROBE["units"]["p"], "parameters": {"fail_at": 0.45}}}}
    assert repr(run(read_scene(scene))).endswith(": failed; 5 rows to t = 0.4 s, 1 signal>")


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # it overflows, as it should
def test_a_diverging_coupling_is_reported_and_not_handed_out():
    scene = read_scene({**two_masses("jacobi", 0.2, 2), "stop_time": 200.0})
    result = run(scene)
    assert result.outcome == "unstable"
    assert np.isfinite(np.array(list(result.columns.values()))).all()


@pytest.mark.parametrize("number", STOPPING)
def test_a_signal_takes_effect_after_the_step_and_keeps_what_was_computed(number, monkeypatch):
    steps, handlers = iter(range(100)), [signal.getsignal(one) for one in STOPPING]

    def interrupted(self, t, h):
        if next(steps) == 4:
            signal.raise_signal(number)
        return 0

    monkeypatch.setattr(Probe, "_step", interrupted)
    result = run(read_scene(PROBE))
    assert (result.outcome, result.message) == ("stopped", f"stopped by {number.name} at t = 0.5 s")
    assert result.info.signal == number.name
    assert len(result.time) == 6
    assert [signal.getsignal(one) for one in STOPPING] == handlers


def test_a_signal_in_a_library_s_code_at_the_start_is_no_failure_of_that_library(monkeypatch):
    monkeypatch.setattr(Run, "prepare", lambda self: signal_inside_a_library(signal.SIGINT))
    with pytest.raises(Interrupted) as stopped:
        run(read_scene(PROBE))
    assert stopped.value.signal == signal.SIGINT


def test_a_study_stops_with_its_run(monkeypatch):
    """A run keeps what it has after Ctrl-C; of a study of many runs it ends the whole."""
    monkeypatch.setattr(Probe, "_step", lambda self, t, h: signal.raise_signal(signal.SIGINT) or 0)
    stopped = run(read_scene(PROBE))
    with pytest.raises(KeyboardInterrupt):
        stopped.unless_stopped()
    monkeypatch.undo()
    done = run(read_scene(PROBE))
    assert done.unless_stopped() is done


def test_an_interrupt_with_a_checkpoint_says_from_which_file_the_run_goes_on(monkeypatch, tmp_path):
    signals, file = [], tmp_path / "kept"

    def interrupted(self, t, h):
        if t > 0.35 and not signals:  # in the step that ends at 0.5
            signals.append(signal.raise_signal(signal.SIGINT))
        return 0

    monkeypatch.setattr(Probe, "_step", interrupted)
    message = run(read_scene(PROBE), checkpoint_every=0.9, checkpoint_to=file).message
    assert message == f"stopped by SIGINT at t = 0.5 s. resume = {str(file)!r} goes on from there"
    assert file.is_file()


def test_progress_shows_only_on_a_terminal(monkeypatch):
    for terminal in (True, False):
        stream = io.StringIO()
        monkeypatch.setattr(stream, "isatty", lambda terminal=terminal: terminal)
        monkeypatch.setattr(sys, "stderr", stream)
        run(read_scene({**PROBE, "title": "a probe"}), progress=True)
        assert ("a probe" in stream.getvalue()) == terminal
        assert ("x real time" in stream.getvalue()) == terminal


def test_initial_values_that_do_not_settle_are_reported_with_what_is_left():
    """Each probe gives what it gets, and one way adds 1 mm: x = x + 1 mm has no solution."""
    back = {"source": "q.profile[1]", "target": "p.length", "offset": 1.0}
    result = run(
        read_scene(
            {
                **PROBE,
                "units": {"p": PROBE["units"]["p"], "q": PROBE["units"]["p"]},
                "connections": ["p.profile[1] -> q.length", back],
            }
        )
    )
    assert result.outcome == "failed"
    assert "did not converge in 30 sweeps" in result.message
    assert "no common equilibrium" in result.message
    assert result.info.counters.master["initial_residual"] > 1e-3
    assert result.time.size == 0


def test_csv_keeps_every_bit(tmp_path):
    result = run(read_scene(two_masses()))
    result.save(tmp_path)
    with open(tmp_path / "result.csv") as file:
        header = file.readline().replace('"', "").strip().split(",")
    table = np.loadtxt(tmp_path / "result.csv", delimiter=",", skiprows=1)
    assert header == ["time", *result.columns]
    np.testing.assert_array_equal(table.T, [result.time, *result.columns.values()])


@pytest.mark.interpreted
def test_run_json_says_what_was_on_and_off_and_why(tmp_path):
    scene = {**PROBE, "units": {"q": {"component": "Pantograph", "preset": "EN 50318:2018", "effects": ["contact_loss"]}}}
    info = json.loads(json.dumps(run(read_scene(scene), in_process=True).info.to_json()))
    assert info["effects"]["q"]["on"] == {"contact_loss": "named in the scene", "lower_frame": "preset 'EN 50318:2018'"}
    assert "bump_stops" in info["effects"]["q"]["off"]
    assert "q.wire_height" in info["settings"]["undriven_inputs"]
    assert info["counters"]["master"]["steps"] == 10
    assert info["counters"]["units"]["q"]["derivative_calls"] > 0
    assert {"simulated", "start", "compile", "run", "cpu"} == info["timing"].keys()
    assert info["timing"]["simulated"] == 1.0


def test_compilation_is_no_part_of_the_times_of_starting_and_running(monkeypatch):
    """Compile events around waits of known length, nested as Numba has them: all of it is `compile`, and nothing twice."""

    def compiles(seconds):
        with event.trigger_event("numba:compile"), event.trigger_event("numba:compile"):
            sleep(seconds)

    def initialize(unit, t, _initialize=Linear._initialize):
        compiles(0.05)
        return _initialize(unit, t)

    def step(unit, t, h, _step=Linear._step):
        if t == 0.0:
            compiles(0.1)
        return _step(unit, t, h)

    monkeypatch.setattr(Linear, "_initialize", initialize)
    monkeypatch.setattr(Linear, "_step", step)
    since = perf_counter()
    timing = run(read_scene(two_masses()), in_process=True).info.timing
    whole = perf_counter() - since
    assert timing.compile >= 2 * (0.05 + 0.1)  # of two masses
    assert timing.start + timing.compile + timing.run <= whole  # a second counted twice would be beyond it
    monkeypatch.undo()
    assert run(read_scene(two_masses()), in_process=True).info.timing.compile == 0.0


def test_missing_column_names_the_near_ones():
    with pytest.raises(BadInput, match=r"p\.time"):
        run(read_scene(PROBE))["p.tine"]


@pytest.mark.parametrize(
    ("name", "least"),
    in_plain_python(
        [
            *((name, 0.0) for name in FIRST_OF_SYSTEM.values()),
            *(pytest.param(name, 0.02, marks=pytest.mark.full) for name in covering_scenes()),
        ]
    ),
)
@pytest.mark.uncompiled
def test_shipped_scenes_run_alike_as_fmus_and_in_process(name, least):
    """One a system over 20 macro steps, and scenes that have all components over 20 ms or 100 macro steps.

    A line's wires with long elements: bits are the same or not on any mesh, and plain Python takes a sixth of the time.
    """
    scene = load_scene(name)
    stop = max(min(least, 100 * scene.master.step), 20 * scene.master.step)
    short = {"stop_time": stop, "record.interval": None, "faults": []}
    if (scene.record.snapshot_interval or 0.0) > stop:
        short["record.snapshot_interval"] = stop
    short |= {f"{name}.element": 2.5 for name, unit in scene.units.items() if unit.component == "Catenary"}
    assert_fmus_give_the_same_bits(scene.with_changes(short))


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_fmu_equals_in_process_to_the_last_bit(algorithm, degree):
    """A mass under a pantograph's contact force, which moves the wire: the pantograph as FMU and in process."""
    scene = read_scene(
        {
            "stop_time": 0.2,
            "connections": ["pantograph.contact_force -> wire.force", "wire.x_out -> pantograph.wire_height"],
            "units": {
                "pantograph": {
                    "component": "Pantograph",
                    "effects": ["contact_loss", "bump_stops"],
                    "parameters": {"bump_stops.travel": 0.03, "speed": 50.0},
                },
                "wire": {"component": "cosimo.tests.support:Mass", "parameters": {"m": 40.0, "k": 4000.0, "c": 150.0, "v0": 0.2}},
            },
            "master": {"algorithm": algorithm, "step": 2e-3, "extrapolation": degree},
        }
    )
    fmu, here = run(scene), run(scene, in_process=True)
    assert fmu.outcome == here.outcome == "done"
    for name in here.columns:
        assert fmu[name].tobytes() == here[name].tobytes(), name
    assert np.ptp(here["pantograph.contact_force"]) > 1.0  # N; something did move


class Forgetful(OfTime):
    """Counts its steps where `save` does not look."""

    steps = output("1", "steps")
    taken = 0

    def _outputs(self, t):
        self.y[0] = self.taken

    def _step(self, t, h):
        self.taken += 1
        return super()._step(t, h)


def test_components_that_cannot_repeat_a_step_are_found_where_steps_are_repeated(tmp_path):
    data = {"stop_time": 1.0, "units": {"f": {"component": "cosimo.tests.run.test_run:Forgetful"}}, "master": {"step": 0.1}}
    scene = read_scene(data)
    assert run(scene)["f.steps"][-1] == 10.0
    located = read_scene({**data, "master": {"step": 0.1, "events": ["f.steps"]}})
    for result in (run(located), run(scene, checkpoint_every=0.5, checkpoint_to=tmp_path / "checkpoint")):
        assert result.message.startswith("f failed at t = 0 s: a step that is repeated from the same state gives another result")


def test_a_run_with_its_report_resolves_the_coupling_once(tmp_path, monkeypatch):
    counted = []
    original = checked.resolve_coupling
    monkeypatch.setattr(checked, "resolve_coupling", lambda scene: counted.append(scene.name) or original(scene))
    result = run(load_scene("mass-on-spring").with_changes({"stop_time": 0.5}), in_process=True)
    write_report(result, tmp_path)
    assert len(counted) == 2  # the shipped scene, and the changed one


def test_a_run_of_hours_is_a_warning_once(monkeypatch, capsys):
    """After five seconds with a thousandth of the run, from the first step on, which compiles; a run of minutes has none."""
    for stop, said in ((1e3, 1), (1e2, 0)):
        clock = iter([21.0, 22.0, 26.0, 27.0])
        monkeypatch.setattr(progress, "perf_counter", lambda clock=clock: next(clock))
        with progress.Progress("a run", stop) as observer:
            for t in (0.2, 0.4, 1.2, 1.4):
                observer(0, t)
        assert capsys.readouterr().err.count("at this speed the run takes 1.4 h more") == said
