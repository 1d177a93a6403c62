"""Studies that are stopped or killed keep what they have computed, and go on with it to the same result."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from time import monotonic, sleep

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness import journal
from cosimo.orchestrator.harness.journal import Stopped, kept_study, once
from cosimo.orchestrator.harness.studies import stability as stability_study
from cosimo.orchestrator.harness.studies import trial as trials
from cosimo.orchestrator.harness.studies.accuracy import accuracy
from cosimo.orchestrator.harness.studies.effects import effects
from cosimo.orchestrator.harness.studies.stability import stability
from cosimo.orchestrator.output import UNFINISHED
from cosimo.orchestrator.scene.scene import write_scene
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import signal_inside_a_library, two_masses

KILL = 9
PATIENCE = 120.0  # s until a busy machine must have kept a piece
SCENE = load_scene("mass-on-spring").with_changes({"stop_time": 0.5, "study.stability": {}})
ENDS = [signal.SIGINT, *([] if os.name == "nt" else [signal.SIGTERM, signal.SIGHUP])]


def pieces(folder) -> set[str]:
    return {p.name for p in (folder / UNFINISHED / journal.FOLDER).glob("*")}


def counted(monkeypatch, module, name: str, stop_at: int | None = None) -> list[int]:
    """Calls of a function of a module; the `stop_at`-th of them ends in a signal."""
    calls: list[int] = []
    real = getattr(module, name)

    def call(*arguments, **named):
        calls.append(len(calls) + 1)
        if len(calls) == stop_at:
            signal.raise_signal(ENDS[-1])
        return real(*arguments, **named)

    monkeypatch.setattr(module, name, call)
    return calls


def kept(study, folder, *, resume: bool = True, error: type[Exception] | None = None):
    """What a study gives that keeps its pieces; with an `error`, which is raised behind it, they stay."""
    with kept_study(folder, resume=resume):
        result = study()
        if error is not None:
            raise error(result)
    return result


def stopped_at(study, module, name, stop_at, folder, monkeypatch, *, resume: bool) -> list[int]:
    """Calls of a function until the one in which a signal comes."""
    with monkeypatch.context() as patch:
        calls = counted(patch, module, name, stop_at)
        with pytest.raises(Stopped) as stopped:
            kept(study, folder, resume=resume)
    assert stopped.value.signal == ENDS[-1]
    assert stopped.value.kept == len(pieces(folder)) >= stop_at - 1
    return calls


def interrupted_and_resumed(study, module, name, stop_at, folder, monkeypatch):
    """(result of the whole study, of one that goes on, calls of a function in each)."""
    with monkeypatch.context() as patch:
        every = counted(patch, module, name)
        whole = kept(study, folder)
    assert not (folder / UNFINISHED).exists()
    stopped_at(study, module, name, stop_at, folder, monkeypatch, resume=False)
    with monkeypatch.context() as patch:
        rest = counted(patch, module, name)
        again = kept(study, folder)
    assert not (folder / UNFINISHED).exists()
    return whole, again, every, rest


def test_limits_of_stability_go_on(tmp_path, monkeypatch):
    def study():
        return stability(SCENE, [("jacobi", 0), ("gauss-seidel", 0), ("gauss-seidel", 1)])

    whole, again, every, rest = interrupted_and_resumed(study, stability_study, "_measured", 3, tmp_path, monkeypatch)
    assert again.limits == whole.limits
    assert (len(every), len(rest)) == (3, 1)


@pytest.mark.interpreted  # each trial is another combination of effects
def test_the_smallest_set_of_effects_goes_on(tmp_path, monkeypatch):
    scene = load_scene("gimbal-scan").with_changes({"stop_time": 0.01})
    whole, again, every, rest = interrupted_and_resumed(lambda: effects(scene, 0.01), trials, "_trial", 4, tmp_path, monkeypatch)
    assert [(f.name, f.actual, f.chosen) for f in again.findings] == [(f.name, f.actual, f.chosen) for f in whole.findings]
    assert again.runs == whole.runs
    assert len(rest) == len(every) - 3


@pytest.mark.full
def test_an_accuracy_study_keeps_runs_times_and_the_reference(tmp_path, monkeypatch):
    """What was measured before stands in a further call with the same times to the last bit."""

    def study():
        return accuracy(SCENE, budget=60.0, repeats=1)  # plenty, on a busy machine, too

    stopped_at(study, trials, "_trial", 6, tmp_path, monkeypatch, resume=False)
    first = pieces(tmp_path)
    assert len(stopped_at(study, trials, "_trial", 3, tmp_path, monkeypatch, resume=True)) == 3
    assert first < pieces(tmp_path)
    with pytest.raises(RuntimeError) as raised:
        kept(study, tmp_path, error=RuntimeError)
    monkeypatch.setattr(trials, "_trial", None)  # nothing is run any more
    assert repr(kept(study, tmp_path).points) == repr(raised.value.args[0].points)


def test_a_damaged_or_foreign_piece_is_computed_again(tmp_path):
    def value(scene, number):
        return once("number", (scene, number), lambda: computed.append(number) or float(number))

    def study():
        return [value(scene, 1), value(scene, 2), value(scene, 1)]

    computed: list[int] = []
    scene = read_scene(two_masses("jacobi", 0.05, 1))
    with pytest.raises(RuntimeError):
        kept(study, tmp_path, error=RuntimeError)
    assert computed == [1, 2]
    damaged, *_ = (tmp_path / UNFINISHED / journal.FOLDER).glob("*")
    content = bytearray(damaged.read_bytes())
    content[-1] ^= 1
    damaged.write_bytes(content)
    with kept_study(tmp_path, resume=True):
        assert study() == [1.0, 2.0, 1.0]
        assert len(computed) == 3
        value(scene.with_changes({"a.k": 11.0}), 1)
        value(scene.with_changes({"title": "Another name for the same"}), 1)
    assert len(computed) == 4
    assert value(scene, 1) == 1.0  # without a study nothing is kept
    assert len(computed) == 5


def hold(folder, number=None, come=signal.raise_signal):
    with kept_study(folder):
        if number is not None:
            come(number)


@pytest.mark.parametrize("come", [signal.raise_signal, signal_inside_a_library])
@pytest.mark.parametrize("number", ENDS)
def test_each_signal_that_ends_a_process_stops_a_study(number, come, tmp_path):
    with pytest.raises(Stopped) as stopped:
        hold(tmp_path, number, come)
    assert (stopped.value.signal, stopped.value.kept) == (number, 0)


def test_two_studies_do_not_share_a_directory(tmp_path):
    code = (
        f"from cosimo.orchestrator.harness.journal import kept_study\nimport sys\n"
        f"with kept_study({str(tmp_path)!r}):\n    print('held', flush=True)\n    sys.stdin.read()\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        with pytest.raises(BadInput, match=f"process {process.pid} "):
            hold(tmp_path)
        process.stdin.close()


@pytest.mark.skipif(os.name == "nt", reason="there a process is ended, not sent a signal")
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(KILL, marks=pytest.mark.full)])
def test_a_command_that_is_stopped_or_killed_goes_on(number, tmp_path):
    """A map of which the first limits are there when the signal comes."""
    file = write_scene(SCENE, tmp_path / "case.toml", [])
    command = [
        sys.executable,
        "-m",
        "cosimo.orchestrator.cli",
        "stability",
        str(file),
        "--over",
        "spring.stiffness=25:400:5",
        "--algorithm",
        "jacobi",
        "--extrapolation",
        "0",
        "-o",
        str(tmp_path),
    ]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    end = monotonic() + PATIENCE
    while len(pieces(tmp_path)) < 3 and process.poll() is None and monotonic() < end:
        sleep(0.01)
    process.send_signal(number)
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == (-number if number == KILL else 128 + number), errors
    assert "Traceback" not in errors
    assert number == KILL or f"stopped by {number.name}; " in errors
    kept = {p.name: p.stat().st_mtime_ns for p in (tmp_path / UNFINISHED / journal.FOLDER).glob("*")}
    assert len(kept) >= 3
    assert not (tmp_path / "stability.csv").exists()
    done = subprocess.run([*command, "--resume"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "stability.csv").read_text().splitlines()) == 1 + 5
    assert not (tmp_path / UNFINISHED).exists()
