"""Checkpoints of runs with a result directory: they refer to its rows, and grow with nothing."""

import random
import shutil
from time import monotonic, sleep

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_result, read_scene
from cosimo.orchestrator.output import UNFINISHED
from cosimo.orchestrator.run import recording
from cosimo.orchestrator.run.rows import Rows
from cosimo.orchestrator.run.run import run
from cosimo.tests.run.test_checkpoint import SCENES, oscillator, same
from cosimo.tests.run.test_result_files import PATIENCE, posix, started
from cosimo.tests.support import two_masses


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(recording, "CHUNK_ROWS", 16)


def csv_of(folder) -> np.ndarray:
    return np.loadtxt(folder / "result.csv", delimiter=",", skiprows=1, ndmin=2)


@pytest.mark.parametrize(
    ("name", "where"),
    [
        ("jacobi", "the same"),
        ("wide", "the same"),
        ("wide", "another"),
        ("intervals", "memory"),
        ("jacobi", "moved"),
        *(pytest.param("milne", where, marks=pytest.mark.full) for where in ("the same", "another", "memory", "moved")),
    ],
)
def test_a_resumed_run_gives_the_same_bits_wherever_it_writes(name, where, tmp_path):
    scene, out = SCENES[name](), tmp_path / "out"
    whole = run(scene)
    same(whole, run(scene, checkpoint_every=0.34 * scene.stop_time, checkpoint_to=tmp_path / "c", output=out))
    shutil.move(tmp_path / "c", out / "checkpoint")
    if where == "moved":
        shutil.move(out, tmp_path / "elsewhere")
        out = tmp_path / "elsewhere"
    target = {"the same": out, "another": tmp_path / "new", "memory": None, "moved": out}[where]
    resumed = run(scene, resume=out / "checkpoint", output=target)
    same(whole, resumed)
    assert resumed.info.resumed.at > 0.6 * scene.stop_time
    if target is not None:
        same(whole, read_result(target))
        assert csv_of(target)[:, 0].tobytes() == whole.time.tobytes()
        assert not (target / UNFINISHED).exists()
    if where == "another":
        same(whole, read_result(out))


def test_a_checkpoint_does_not_grow_with_the_run(tmp_path):
    sizes = []
    for stop in (20.0, 200.0):
        scene = read_scene({**two_masses("jacobi", 5e-3, 1), "stop_time": stop})
        run(scene, checkpoint_every=0.9 * stop, checkpoint_to=tmp_path / "c", output=tmp_path / "out")
        sizes.append((tmp_path / "c").stat().st_size)
    assert max(sizes) < 20_000  # bytes, of the monitor 320 looks at three inputs at most; all rows are 190 kB and 1.9 MB


def test_rows_that_are_not_there_any_more_are_one_message(tmp_path):
    scene, out, file = oscillator(), tmp_path / "out", tmp_path / "c"
    run(scene, checkpoint_every=0.5, checkpoint_to=file, output=out)
    part = out / "result.parquet"
    content = part.read_bytes()
    part.write_bytes(content[:100] + bytes([content[100] ^ 1]) + content[101:])
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    with pytest.raises(
        BadInput, match=r"resume: got a checkpoint whose \d+ rows are not in '.*out' any more, expected the result"
    ):
        run(scene, resume=file, output=out)
    assert {p: p.read_bytes() for p in before} == before
    part.write_bytes(content)
    same(run(scene), run(scene, resume=file, output=out))
    run(scene.with_changes({"a.k": 11.0}), output=out)
    with pytest.raises(BadInput, match="Another run has written there"):
        run(scene, resume=file, output=tmp_path / "new")


def test_a_run_without_files_goes_on_into_a_directory(tmp_path):
    scene = oscillator()
    whole = run(scene, checkpoint_every=0.5, checkpoint_to=tmp_path / "c")
    (tmp_path / "out" / UNFINISHED).mkdir(parents=True)
    killed = Rows(["x"], directory=tmp_path / "out", name="result")
    killed.begin()
    killed.append(np.zeros(1), np.zeros((1, 1)), np.zeros((1, 0), dtype=object))
    same(whole, run(scene, resume=tmp_path / "c", output=tmp_path / "out"))
    same(whole, read_result(tmp_path / "out"))


@posix
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.full) for k in range(2, 6))])
def test_a_run_that_is_killed_again_and_again_goes_on_to_the_same_bits(seed, tmp_path):
    """`kill -9` twice, at random moments behind a checkpoint, the second time perhaps while the run takes up its rows."""
    rng, folder = random.Random(seed), tmp_path / "out"
    checkpoint = folder / "checkpoint"
    for more in ((), ("--resume", str(checkpoint))):
        old = checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
        process = started(folder, "--checkpoint-every", "5", *more)
        try:
            end = monotonic() + PATIENCE
            while not (checkpoint.exists() and checkpoint.stat().st_mtime_ns > old) and process.poll() is None:
                assert monotonic() < end
                sleep(0.01)
            sleep(rng.uniform(0.0, 1.0))
            process.kill()
        finally:
            _, errors = process.communicate()
        assert process.returncode == -9, errors
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 1e5})
    left = read_result(folder)
    assert left.end >= 10.0
    again = run(scene.with_changes({"stop_time": left.end}), in_process=True)
    for name in left.columns:
        assert left[name][:-2].tobytes() == again[name][:-2].tobytes()
