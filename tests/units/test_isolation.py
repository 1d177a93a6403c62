"""Units in worker processes: bit-identical, one message a step, side by side; crashes and hangs end the unit, not the run.

The start of a worker takes a second of CPU time: where one will do, only one unit is isolated.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.units import open_unit
from cosimo.orchestrator.units.process import WorkerSimulator
from cosimo.tests.rest import at_rest
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import two_masses
from cosimo.tests.units.exchange_fmu import exchange_fmu
from cosimo.tests.units.native import native_fmu
from cosimo.tests.units.troubled import LONG, PATIENCE

TROUBLED = "cosimo.tests.units.troubled:Troubled"
PRINTS, CLOSES, MOVES, RECURSES, WRITES, ABORTS = 1, 2, 3, 5, 6, 7  # of moody.h
ROOT = Path(__file__).resolve().parents[3]
needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks /proc for the processes")


def isolated(data: dict) -> dict:
    """The scene data with all units in workers."""
    return {**data, "units": {n: {**u, "isolation": "process"} for n, u in data["units"].items()}}


def troubled(trouble: str, when: float = 0.25, *, both: bool = False, **unit) -> dict:
    """Two units, the first of which gets into trouble, one second in ten steps. `both`: both of them are isolated."""
    first = {"component": TROUBLED, "isolation": "process", "parameters": {"trouble": trouble, "when": when}, **unit}
    return {
        "stop_time": 1.0,
        "units": {"a": first, "b": {"component": TROUBLED, "isolation": "process" if both else "none"}},
        "connections": ["a.steps -> b.driven", "b.steps -> a.driven"],
        "master": {"algorithm": "jacobi", "step": 0.1, "extrapolation": 0},
    }


def alive(process: float) -> bool:
    """Whether a process is there, and not only its entry for a parent that has not looked yet."""
    status = Path(f"/proc/{int(process)}/stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


def gone(processes) -> bool:
    """Whether all of the processes end, on a busy machine after a while."""
    end = time.monotonic() + PATIENCE
    while any(map(alive, processes)) and time.monotonic() < end:
        time.sleep(0.01)
    return not any(map(alive, processes))


FULL = pytest.mark.full


@pytest.mark.parametrize(
    ("algorithm", "degree"), [pytest.param("jacobi", 0, marks=FULL), ("jacobi", 2), pytest.param("gauss-seidel", 1, marks=FULL)]
)
def test_the_results_are_those_without_isolation(algorithm, degree):
    data = two_masses(algorithm, 1e-2, degree)
    here, there = run(read_scene(data)), run(read_scene(isolated(data)))
    assert there.outcome == "done", there.message
    for name in here.columns:
        assert here[name].tobytes() == there[name].tobytes(), name


@pytest.mark.full
@pytest.mark.parametrize("in_process", [True, False])
def test_a_wide_connection_and_an_fmu_lose_no_bit(in_process):
    """More numbers than a list carries go as arrays; a catalogue unit is an FMU in its worker or a component."""
    changes = {"stop_time": 0.01, "record.snapshots": []}
    scene = load_scene("rotor-bearings-heat").with_changes(changes)
    there = scene.with_changes({f"units.{n}.isolation": "process" for n in scene.units})
    one, other = run(scene, in_process=in_process), run(there, in_process=in_process)
    assert (one.outcome, other.outcome) == ("done", "done"), other.message
    for name in one.columns:
        assert one[name].tobytes() == other[name].tobytes(), name
    assert one.info.effects == other.info.effects
    kinds = {u.kind for u in other.info.units.values()}
    assert kinds == {"component in a worker process" if in_process else "FMU in a worker process"}


def test_a_master_that_repeats_steps_gets_the_same_through_workers():
    """Saved states, located events of an FMU and repeated steps; the FMU is for model exchange."""
    data = {
        "stop_time": 0.6,
        "connections": ["p.time -> f.u", "f.y -> p.length"],
        "units": {"p": {"component": "cosimo.tests.support:Probe"}, "f": {"fmu": exchange_fmu()}},
        "master": {"algorithm": "iterative", "step": 0.05, "extrapolation": 1},
    }
    here, there = run(read_scene(data)), run(read_scene(isolated(data)))
    assert (here.outcome, there.outcome) == ("done", "done"), here.message + there.message
    assert here["f.bounces"][-1] == 1
    assert here.time.tobytes() == there.time.tobytes()
    for name in here.columns:
        assert here[name].tobytes() == there[name].tobytes(), name


def test_a_run_goes_on_from_a_checkpoint_in_other_workers(tmp_path):
    data = {
        "stop_time": 0.6,
        "connections": ["p.time -> f.u"],
        "master": {"step": 0.05},
        "units": {
            "p": {"component": "cosimo.tests.support:Probe"},
            "f": {"fmu": exchange_fmu(), "parameters": {"period": 0.13}, "isolation": "process"},
        },
    }
    scene = read_scene(data)
    whole = run(scene, checkpoint_every=0.4, checkpoint_to=tmp_path / "half")
    resumed = run(scene, resume=tmp_path / "half")
    assert (whole.outcome, resumed.outcome) == ("done", "done"), resumed.message
    for name in whole.columns:
        assert whole[name].tobytes() == resumed[name].tobytes(), name


def test_a_step_is_one_request():
    """What a run of 100 steps asks for beyond one of 50 are the 50 steps, and for the mass alone nothing else."""

    def requests(stop_time):
        data = {**two_masses(), "stop_time": stop_time}
        data["units"]["a"]["isolation"] = "process"
        result = run(read_scene(data))
        return result.info.counters.units["a"]["requests"]

    assert requests(1.0) - requests(0.5) == 50


def test_units_in_workers_step_at_the_same_time(tmp_path, monkeypatch):
    """Each step of either unit ends only if the other one is in its own: one after the other they would fail."""
    monkeypatch.setenv("COSIMO_TEST_MEETING", str(tmp_path))
    meeting = "cosimo.tests.units.troubled:Meeting"
    data = {
        "stop_time": 1.0,
        "master": {"algorithm": "jacobi", "step": 0.1},
        "units": {"a": {"component": meeting}, "b": {"component": meeting, "parameters": {"me": 2.0}}},
        "connections": ["a.met -> b.driven", "b.met -> a.driven"],
    }
    result = finished(read_scene(isolated(data)))
    assert result["a.met"][-1] == result["b.met"][-1] == 10


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ("segfault", "ended by signal 11 (Segmentation fault)"),
        pytest.param("kill", "ended by signal 9 (Killed)", marks=FULL),
        pytest.param("exit", "ended itself with code 7", marks=FULL),
        ("exception", "ZeroDivisionError: division by zero"),
        pytest.param("memory", "MemoryError", marks=pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")),
        ("print", "ended itself with code 7\n  log: a line of the unit\n  log: and one of its library"),
    ],
)
def test_a_unit_that_dies_is_a_failed_step_and_the_run_keeps_its_results(trouble, said, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    both = trouble == "segfault"  # the worker that is well ends, too
    result = run(read_scene(troubled(trouble, both=both)))
    assert result.outcome == "failed"
    assert result.message.startswith("a failed at t = 0.2 s: ")
    assert said in result.message
    assert result.time.tolist() == [0.0, 0.1, 0.2]
    assert result["b.steps"].tolist() == [0, 1, 2]
    assert gone([result[f"{unit}.process"][0] for unit in ("ab" if both else "a")])
    assert list(tmp_path.iterdir()) == []
    assert result.info.units["a"].parameters["trouble"] == trouble
    assert result.info.counters.units["a"]["requests"] > 3


def test_step_control_does_not_hide_why_a_worker_has_died():
    """A shorter step needs the state before it, which a dead process cannot take back."""
    scene = troubled("segfault")
    result = run(
        read_scene(scene | {"master": {"step": 0.1, "control": {"method": "doubling", "relative": 1e-3, "absolute": 1e-3}}})
    )
    assert (result.outcome, "ended by signal 11 (Segmentation fault)" in result.message) == ("failed", True), result.message


def killed_before(method, monkeypatch):
    """Every worker dies right before a call of a method."""
    original = getattr(WorkerSimulator, method)

    def call(self, *arguments):
        self._process.kill()
        self._process.wait()
        return original(self, *arguments)

    monkeypatch.setattr(WorkerSimulator, method, call)


@pytest.mark.parametrize("method", [pytest.param("parameters", marks=FULL), pytest.param("work", marks=FULL), "close"])
def test_a_worker_that_dies_behind_the_last_step_costs_no_result(method, monkeypatch):
    killed_before(method, monkeypatch)
    result = finished(read_scene(troubled("none")))
    assert result["b.steps"][-1] == 10


def test_a_worker_that_the_system_does_not_start_is_bad_input_and_leaves_no_folder(tmp_path, monkeypatch):
    scene = read_scene(troubled("none"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no-such-python"))
    with pytest.raises(BadInput, match=r"units\.a: got a worker process that the system does not start.*No such file"):
        run(scene)
    assert list(tmp_path.iterdir()) == []


def test_a_worker_that_dies_at_its_start_is_bad_input(monkeypatch):
    killed_before("wire", monkeypatch)
    with pytest.raises(
        BadInput,
        match=r"units\.a: the unit cannot be started in a worker process: its worker "
        "process was ended by signal 9",
    ):
        run(read_scene(troubled("none")))


def test_what_a_crashing_library_has_logged_and_printed_is_told():
    data = {
        "stop_time": 1.0,
        "master": {"step": 0.1},
        "units": {"f": {"fmu": exchange_fmu(), "parameters": {"crash": 0.25}, "isolation": "process"}},
    }
    result = run(read_scene(data))
    assert result.message == (
        "f failed at t = 0.2 s: its worker process was ended by signal 11 (Segmentation fault)\n"
        "  log: printed before the end\n  log: f: logged before the end"
    )
    assert result.time.tolist() == [0.0, 0.1, 0.2]


def test_a_crash_in_the_initialization_is_a_failed_run():
    result = run(read_scene(troubled("segfault", -1.0)))
    assert (result.outcome, len(result.time)) == ("failed", 0)
    assert "a failed at t = 0 s: its worker process was ended by signal 11" in result.message


def test_a_unit_that_hangs_is_given_up_after_its_time_limit():
    result = run(read_scene(troubled("hang", time_limit=3.0)))
    assert result.message == "a failed at t = 0.2 s: no answer within 3 s; its worker process was ended"
    assert len(result.time) == 3
    assert gone([result["a.process"][0]])
    assert result.info.timing.run < LONG / 3


def test_a_time_limit_without_isolation_is_refused():
    with pytest.raises(BadInput, match=r"units\.a.*time_limit: got 1 s without isolation"):
        run(read_scene(troubled("none", time_limit=1.0, isolation="none")))


def test_a_worker_that_does_not_start_is_bad_input(monkeypatch):
    scene = read_scene(troubled("none"))
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(
        BadInput,
        match=r"units\.a: the unit cannot be started in a worker process: its worker "
        "process ended itself with code 1",
    ):
        run(scene)


def misbehaving(how: int, isolation: str = "process") -> dict:
    """An FMU that does something at 0.55 s that no unit should, see moody.h."""
    return {
        "stop_time": 1.0,
        "master": {"step": 0.1},
        "record": {"signals": ["f.now"]},
        "units": {"f": {"fmu": native_fmu("moody", 3), "parameters": {"exit_at": 0.55, "mischief": how}, "isolation": isolation}},
    }


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (PRINTS, ""),
        (MOVES, ""),
        (WRITES, "something else than answers came from its worker process, which was ended"),
        pytest.param(CLOSES, "its worker process ended itself with code 1", marks=FULL),
        pytest.param(RECURSES, "was ended by signal 11", marks=FULL),
        pytest.param(ABORTS, "was ended by signal 6", marks=FULL),
    ],
)
def test_what_a_library_does_to_its_process_stays_there(how, said, capfd):
    """Many lines, another directory, garbage in all its open files, none of them open any more ..."""
    here = os.getcwd()
    result = run(read_scene(misbehaving(how)))
    assert result.outcome == ("failed" if said else "done"), result.message
    assert said in result.message
    assert result.time[-1] == pytest.approx(0.5 if said else 1.0)
    assert (os.getcwd(), capfd.readouterr().out) == (here, "")


def test_a_library_that_changes_the_directory_of_the_run_does_not_move_its_results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(read_scene(misbehaving(MOVES, "none")))
    assert Path.cwd() == tmp_path
    assert any("has changed the working directory" in text for text in result.info.warnings)
    assert result.save("out").resolve() == tmp_path / "out"


def test_warnings_of_a_unit_reach_the_run_and_a_time_limit_does_nothing_to_a_unit_that_answers():
    result = run(read_scene(troubled("warning", time_limit=60.0)))
    assert (result.outcome, result.info.warnings) == ("done", ("the oil is old",))


def test_rollback_and_packed_states_through_a_worker():
    """A state, saved there, restored, and packed for an instance in another worker."""
    loaded = read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 0.1},
            "units": {"p": {"component": "cosimo.tests.support:Oscillator", "isolation": "process"}},
        }
    ).units["p"]

    def stepped(unit):
        unit.drive([0.002], [0.1], None, 1e-3)
        unit.step(1e-3, 1e-3)
        return unit.get()

    def started():
        unit = open_unit("p", loaded, in_process=True)
        unit.wire(["position"], ["force", "v_out"])
        unit.initialize(0.0, [0.0])
        unit.start()
        return unit

    first, second = started(), started()
    first.drive([0.001], [0.5], [20.0], 1e-3)
    first.step(0.0, 1e-3)
    before, state = first.get(), first.save()
    after = stepped(first)
    first.restore(state)
    assert first.get() == before != after
    assert stepped(first) == after
    packed = first.pack(state)
    second.restore(second.unpack(packed))
    assert stepped(second) == after
    read = second.reader(["x_out", "force"])()
    assert read[1] == after[0]
    first.release(state)
    first.close()
    second.close()


def test_a_unit_that_has_died_fails_again_when_it_is_asked_again():
    unit = open_unit("a", read_scene(troubled("exit", 0.0)).units["a"], in_process=True)
    unit.wire(["driven"], ["steps"])
    unit.initialize(0.0, [0.0])
    unit.start()
    unit.step(0.0, 0.1)
    for said in ("ended itself with code 7", "has ended"):
        with pytest.raises(StepFailed, match="its worker process " + said):
            unit.get()
    unit.close()
    unit.close()


RUN = """
import sys
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
scene = read_scene({scene!r})
print("ready", flush=True)
result = run(scene)
print(result.outcome, result.message, len(result.time), flush=True)
"""


def started(scene: dict, folder: Path) -> tuple[subprocess.Popen, list[int]]:
    """A process that runs the scene, and its workers; a session of its own, as a terminal gives."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN.format(scene=scene)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        start_new_session=True,
        env={**os.environ, "TMPDIR": str(folder)},
    )
    process.stdout.readline()
    end, workers = time.monotonic() + PATIENCE, []
    while len(workers) < 2 and time.monotonic() < end:
        time.sleep(0.05)
        workers = [int(w) for w in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
    return process, workers


def wait_for_cpu_rest(processes: list[int]) -> None:
    """Wait until the run and its workers have stopped computing: what is left is the unit that hangs."""
    before, same = None, 0
    while same < 8:
        now = [Path(f"/proc/{w}/stat").read_text().split()[13:15] for w in processes]
        same = same + 1 if now == before else 0
        before = now
        time.sleep(0.05)


@needs_proc
@pytest.mark.parametrize("way", ["killed", pytest.param("interrupted", marks=FULL)])
def test_no_worker_outlives_the_run_even_if_its_unit_hangs(way, tmp_path):
    process, workers = started(troubled("hang", -1.0 if way == "killed" else 0.25, both=True), tmp_path)
    assert len(workers) == 2
    wait_for_cpu_rest([process.pid, *workers])
    if way == "killed":
        process.kill()
    else:
        for _ in range(2):  # the first waits for the end of the step, which does not come
            os.killpg(process.pid, signal.SIGINT)
            time.sleep(0.2)
        assert process.stdout.read() == "stopped stopped by SIGINT at t = 0.2 s 3\n"
    process.wait(PATIENCE)
    process.stdout.close()
    assert gone(workers)


def of_group(group: int) -> list[int]:
    """Processes of a group that live."""
    members = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            state, _, its_group, *_ = path.read_text().rpartition(")")[2].split()
            members += [int(path.parent.name)] if int(its_group) == group and state != "Z" else []
    return members


@needs_proc
def test_what_a_unit_has_started_ends_with_it(monkeypatch):
    groups = []

    def kill(unit, _kill=WorkerSimulator._kill):
        groups.append(of_group(unit._process.pid))
        _kill(unit)

    monkeypatch.setattr(WorkerSimulator, "_kill", kill)
    assert run(read_scene(troubled("fork"))).outcome == "done"
    assert any(groups)  # the child was still there
    assert gone([child for children in groups for child in children])


@needs_proc
@pytest.mark.full
def test_repeated_runs_leave_no_files_threads_or_processes_behind(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def held():
        return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task")), len(os.listdir(tmp_path))

    def children():  # pools of earlier tests keep a process of their own, multiprocessing's resource tracker
        return set(Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())

    scene = read_scene(isolated({**two_masses(), "stop_time": 0.05}))
    run(scene)
    before, others = at_rest(held), at_rest(children)
    for _ in range(5):
        assert run(scene).outcome != "failed"
    assert at_rest(held, before) == before
    assert at_rest(lambda: children() - others, set()) == set()
    assert np.isfinite(run(scene)["a.x_out"]).all()
