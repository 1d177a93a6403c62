"""Results are written as they come: what is left after kills, full disks and limits of memory, and who may write where."""

import json
import os
import random
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from time import monotonic, sleep

import cosimo
import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_result, read_scene
from cosimo.orchestrator import output
from cosimo.orchestrator.output import UNFINISHED, locked
from cosimo.orchestrator.run import recording, results
from cosimo.orchestrator.run.rows import Rows
from cosimo.orchestrator.run.run import run
from cosimo.tests.support import Oscillator, two_masses

PATIENCE = 120.0  # s until a busy machine must have written a chunk
posix = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")
PROBE = {
    "stop_time": 1.0,
    "units": {"p": {"component": "cosimo.tests.support:Probe", "parameters": {"length": 4.0}}},
    "master": {"step": 0.1},
    "record": {"signals": ["p.time"], "snapshots": ["p.profile"], "snapshot_interval": 0.5},
}


def masses(stop: float = 2.0):
    return read_scene({**two_masses("jacobi", 5e-3, 1), "stop_time": stop})


def same(one, other):
    assert one.time.tobytes() == other.time.tobytes()
    assert list(one.columns) == list(other.columns)
    assert all(one[name].tobytes() == other[name].tobytes() for name in one.columns)
    assert {n: (s.time.tolist(), s.values.tolist()) for n, s in one.snapshots.items()} == {
        n: (s.time.tolist(), s.values.tolist()) for n, s in other.snapshots.items()
    }
    assert (one.outcome, one.message, dict(one.measures)) == (other.outcome, other.message, dict(other.measures))


@pytest.mark.parametrize("scene", [masses, lambda: read_scene(PROBE)], ids=["masses", "snapshots"])
def test_what_is_written_is_the_result(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "CHUNK_ROWS", 7)  # many parts
    whole = run(scene())
    stored = run(scene(), output=tmp_path / "streamed")
    whole.save(tmp_path / "saved")
    for result in (stored, read_result(tmp_path / "streamed"), read_result(tmp_path / "saved")):
        same(whole, result)
        assert result.scene.settings() == {**whole.scene.settings(), **result.scene.settings()}
    texts = [(tmp_path / d / "result.csv").read_bytes() for d in ("streamed", "saved")]
    assert texts[0] == texts[1]
    table = np.loadtxt(tmp_path / "saved" / "result.csv", delimiter=",", skiprows=1, ndmin=2)
    assert table[:, 0].tobytes() == whole.time.tobytes()
    assert not (tmp_path / "streamed" / UNFINISHED).exists()


def test_rows_wait_in_memory_only_until_a_chunk_is_full(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "CHUNK_ROWS", 16)
    seen = []
    call = recording.ResultFiles.__call__

    def watched(files, tick, t):
        call(files, tick, t)
        seen.append(max(recorder.pending for recorder in files._recorders))

    monkeypatch.setattr(recording.ResultFiles, "__call__", watched)
    run(masses(), output=tmp_path)
    assert len(seen) >= 401 // 16
    assert max(seen) < 16
    chunks = [time.size for time, *_ in Rows.read(tmp_path / "result.parquet").chunks()]
    assert max(chunks) < 16 + 1
    assert sum(chunks) == 401


def test_a_result_that_fills_the_memory_stays_on_disk(tmp_path, monkeypatch):
    whole = run(masses())
    monkeypatch.setattr(results, "HELD", 100)
    stored = run(masses(), output=tmp_path)
    assert not stored.held
    assert (stored.rows, stored.end) == (whole.rows, whole.end)
    assert repr(stored) == repr(whole)
    same(whole, stored)
    for name in whole.columns:
        assert stored.extremes(name) == whole.extremes(name)
    with pytest.raises(BadInput, match="a recorded signal"):
        stored["nothing"]


def test_figures_of_a_scene_without_connections_are_read_again(tmp_path):
    """run.json has all settings of the master: those that would have no effect were refused when the result was read."""
    scene = load_scene("double-pendulum").with_changes({"stop_time": 0.5})
    written = cosimo.run(scene, in_process=True, output=tmp_path / "out")
    read = read_result(tmp_path / "out")
    assert read.summary == written.summary
    assert read.scene.coupling.links == ()
    assert cosimo.compare(tmp_path / "out", written).figures


def test_texts_are_kept_as_well(tmp_path):
    """Units without texts are the rule; the table takes them with numbers whose names start alike."""
    (tmp_path / UNFINISHED).mkdir()
    table = Rows(["a.x", "a.x.y"], ["a.s"], directory=tmp_path, name="t", units={"a.x": "m"}, title="title")
    table.begin()
    texts = np.array([["one"], ['zwölf, "\n']], dtype=object)
    for k in range(3):
        table.append(np.array([k, k + 0.5]), np.array([[1.0, np.nan], [2.0, np.inf]]) * (k + 1), texts)
    table.store()
    for file in ("t.arrows", "t.parquet"):
        again = Rows.read(tmp_path / UNFINISHED / file)
        assert (again.names, again.texts, again.title, again.rows) == (["a.x", "a.x.y"], ["a.s"], "title", 6)
        assert again.units["a.x"] == "m"
        assert again.column("a.x").tolist() == [1.0, 2.0, 2.0, 4.0, 3.0, 6.0]
        assert again.column("a.s").tolist() == ["one", 'zwölf, "\n'] * 3
        with pytest.raises(KeyError):
            again.column("a")


def test_a_stream_is_read_up_to_its_last_whole_chunk_wherever_it_ends(tmp_path):
    (tmp_path / UNFINISHED).mkdir()
    table = Rows(["x"], ["s"], directory=tmp_path, name="t")
    table.begin()
    ends, file = [], tmp_path / UNFINISHED / "t.arrows"
    for k in range(3):
        ends.append(file.stat().st_size)
        table.append(np.array([2.0 * k, 2.0 * k + 1.0]), np.full((2, 1), k), np.array([["a"], ["b"]], dtype=object))
    content = file.read_bytes()
    for size in range(ends[0], len(content) + 1):
        file.write_bytes(content[:size])
        whole = sum(size >= end for end in [*ends[1:], len(content)])
        assert Rows.read(file).rows == 2 * whole
        assert Rows.read(file).column("time").tolist() == [float(t) for t in range(2 * whole)]


def test_rows_that_cannot_be_written_leave_the_earlier_ones_and_are_written_when_they_can(tmp_path, monkeypatch):
    (tmp_path / UNFINISHED).mkdir()
    table = Rows(["x"], directory=tmp_path, name="t", with_csv=True)
    table.begin()
    rows = np.arange(2.0), np.ones((2, 1)), np.zeros((2, 0), dtype=object)
    table.append(*rows)
    before = {file: file.read_bytes() for file in (tmp_path / UNFINISHED).iterdir()}

    def full(_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("cosimo.orchestrator.run.rows._csv_lines", full)  # the stream has been written by then
        with pytest.raises(OSError, match="No space"):
            table.append(*rows)
    assert {file: file.read_bytes() for file in before} == before
    table.append(*rows)
    assert table.rows == Rows.read(tmp_path / UNFINISHED / "t.arrows").rows == 4


def test_a_result_of_an_earlier_version_whose_parts_lie_in_a_folder_is_read(tmp_path):
    whole = run(masses(), output=tmp_path)
    (tmp_path / "result.parquet").rename(tmp_path / "part-000000.parquet")
    (tmp_path / "result.parquet").mkdir()
    (tmp_path / "part-000000.parquet").rename(tmp_path / "result.parquet" / "part-000000.parquet")
    same(whole, read_result(tmp_path))
    same(whole, run(masses(), output=tmp_path))  # takes its place
    assert (tmp_path / "result.parquet").is_file()


def command(folder, *options: str) -> list[str]:
    return [sys.executable, "-m", "cosimo.orchestrator.cli", "run", "mass-on-spring", "--in-process", "-o", str(folder), *options]


def started(folder, *options: str, **named):
    """A long run in a process of its own, in plain Python."""
    return subprocess.Popen(
        command(folder, "--stop", "1e5", *options),
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        stderr=subprocess.PIPE,
        text=True,
        stdout=subprocess.DEVNULL,
        **named,
    )


def until_written(process, folder) -> int:
    """Number of rows that a run has written."""
    end = monotonic() + PATIENCE
    while monotonic() < end and process.poll() is None:
        with suppress(OSError, ValueError):  # it is not there, or empty
            if rows := Rows.read(folder / UNFINISHED / "result.arrows").rows:
                return rows
        sleep(0.02)
    raise AssertionError(process.communicate()[1])


@posix
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.full) for k in range(2, 11))])
def test_a_killed_run_leaves_its_chunks_and_the_earlier_result(seed, tmp_path):
    scene = cosimo.load_scene("mass-on-spring")
    earlier = run(scene.with_changes({"stop_time": 0.1}), in_process=True, output=tmp_path)
    same(earlier, read_result(tmp_path))
    process = started(tmp_path)
    try:
        until_written(process, tmp_path)
        sleep(random.Random(seed).uniform(0.0, 2.0))
        acknowledged = until_written(process, tmp_path)
        process.kill()
    finally:
        process.communicate()
    left = read_result(tmp_path)
    assert (left.outcome, left.message) == ("failed", f"the run was killed; its rows up to t = {left.end:.9g} s were written")
    assert left.rows >= acknowledged > 0
    again = run(scene.with_changes({"stop_time": left.end}), in_process=True)
    assert left.time.tobytes() == again.time.tobytes()
    for name in left.columns:
        assert left[name][:-2].tobytes() == again[name][:-2].tobytes()  # the last step of `again` is a shorter one
    assert json.loads((tmp_path / "run.json").read_text())["outcome"] == "done"  # of the earlier one, which is whole
    final = run(scene.with_changes({"stop_time": 0.2}), in_process=True, output=tmp_path)
    same(final, read_result(tmp_path))
    assert not (tmp_path / UNFINISHED).exists()


@posix
def test_a_second_run_into_the_same_directory_is_refused_with_its_holder(tmp_path):
    process = started(tmp_path)
    try:
        until_written(process, tmp_path)
        with pytest.raises(BadInput, match=f"process {process.pid} on .* writes, expected one of its own"):
            run(masses(), output=tmp_path)
    finally:
        process.kill()
        process.communicate()
    run(masses(0.1), output=tmp_path)  # the lock has gone with its process


def test_a_lock_is_one_for_what_its_holder_writes(tmp_path):
    with locked(tmp_path):
        run(masses(0.1), output=tmp_path)
    assert sorted(os.listdir(tmp_path)) == ["result.csv", "result.parquet", "run.json"]


@pytest.mark.parametrize("without_locks", [False, True], ids=["locks", "a file system without locks"])
def test_a_second_thread_is_refused_as_a_second_process_is(without_locks, tmp_path, monkeypatch):
    if without_locks:
        monkeypatch.setattr(output, "lock_folder", lambda path: lambda: None)
    with ThreadPoolExecutor(1) as threads, locked(tmp_path):
        refused = threads.submit(lambda: run(masses(0.1), output=tmp_path)).exception()
        assert isinstance(refused, BadInput)
        assert f"process {os.getpid()} on" in str(refused)
        with locked(tmp_path):  # the one that has it may enter again
            pass
        assert isinstance(threads.submit(lambda: run(masses(0.1), output=tmp_path)).exception(), BadInput)
    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(lambda: run(masses(0.1), output=tmp_path)).result().outcome == "done"


@posix
def test_a_disk_that_is_full_ends_the_run_with_what_is_written(tmp_path):
    """A limit of the size of a file stands for the disk: the same calls fail, with another number of the error."""
    import resource

    limit = 200_000  # bytes
    process = started(tmp_path, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    try:
        errors = process.communicate(timeout=PATIENCE)[1]
    finally:
        process.kill()
    assert process.returncode == 3, errors
    assert "Traceback" not in errors
    result = read_result(tmp_path)
    assert result.outcome == "failed"
    assert "the results cannot be written to" in result.message
    assert "the results cannot be written to" in errors
    assert result.rows > 10
    rows = (tmp_path / "result.csv").read_text().splitlines()
    assert 0 < len(rows) - 1 <= result.rows
    assert all(len(row.split(",")) == len(result.columns) + 1 for row in rows)


class Hungry(Oscillator):
    """Takes ever more memory."""

    def _step(self, t, h):
        self.kept = [*getattr(self, "kept", []), np.ones(4_000_000)]
        return super()._step(t, h)


@posix
def test_a_run_without_memory_left_keeps_what_it_has(tmp_path):
    program = f"""
import resource
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import two_masses
scene = two_masses("jacobi", 5e-3, 1)
scene["units"]["b"]["component"] = "{__name__}:Hungry"
scene = read_scene({{**scene, "stop_time": 50.0}})
run(scene.with_changes({{"stop_time": 0.005}}), output={str(tmp_path)!r})  # all is loaded now
taken = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + 400_000_000,) * 2)
result = run(scene, output={str(tmp_path)!r})
print(result.outcome, result.message)
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("failed"), done.stdout
    assert "memory" in done.stdout.lower()
    result = read_result(tmp_path)
    assert result.outcome == "failed"
    assert result.rows > 3


@posix
@pytest.mark.first
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_leaves_a_whole_result(number, tmp_path):
    process = started(tmp_path)
    try:
        until_written(process, tmp_path)
        process.send_signal(number)
        errors = process.communicate(timeout=PATIENCE)[1]
    finally:
        process.kill()
    assert process.returncode == 128 + number, errors
    result = read_result(tmp_path)
    assert (result.outcome, result.info.signal) == ("stopped", number.name)
    assert len((tmp_path / "result.csv").read_text().splitlines()) == 1 + result.rows


@pytest.mark.parametrize("content", ["", "{", "[]", '{"scene": 3}', '{"scene": {"units": {}}}', "[" * 5000])
def test_what_is_no_result_is_refused_in_one_message(content, tmp_path):
    with pytest.raises(BadInput, match="a directory that a run has written"):
        read_result(tmp_path)
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(BadInput):
        read_result(tmp_path)


def test_runs_of_threads_do_not_meet(tmp_path):
    """The lock is of the process: what its own threads do is theirs to order; separate directories work side by side."""
    threads = [threading.Thread(target=lambda k=k: run(masses(0.1), output=tmp_path / str(k))) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    same(read_result(tmp_path / "0"), read_result(tmp_path / "1"))


@pytest.mark.parametrize(
    ("name", "inside"),
    [("report.html", ""), ("result.csv", "mine.txt"), ("snapshots", "holiday.jpg"), ("result.parquet", "notes.txt")],
)
def test_what_somebody_else_put_there_is_not_replaced(name, inside, tmp_path):
    """A folder with the name of a file of the result, or with files that are none of a result: refused before the run."""
    (tmp_path / name).mkdir()
    if inside:
        (tmp_path / name / inside).write_text("mine")
    with pytest.raises(BadInput, match=name.replace(".", r"\.")):
        run(read_scene(two_masses()), in_process=True, output=tmp_path)
    assert (tmp_path / name).is_dir()
    assert not inside or (tmp_path / name / inside).read_text() == "mine"
    assert not (tmp_path / "run.json").exists()


def test_a_result_takes_the_place_of_an_earlier_one_with_all_that_was_made_of_it(tmp_path):
    run(read_scene(two_masses()), in_process=True, output=tmp_path)
    (tmp_path / "summary.json").write_text("{}")
    (tmp_path / "mine.txt").write_text("mine")
    run(read_scene(two_masses()), in_process=True, output=tmp_path)
    assert not (tmp_path / "summary.json").exists()
    assert (tmp_path / "mine.txt").read_text() == "mine"
