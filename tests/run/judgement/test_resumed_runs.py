"""A run that was interrupted and goes on is judged as one that was not: its verdict, its errors, its counted work and its warnings."""

import signal

import pytest
from cosimo import read_scene
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.orchestrator.run import work
from cosimo.tests.engine.algorithms.bonded import bonded
from cosimo.tests.support import Linear, Mass, two_masses


class Complaining(Mass):
    """Says once that something is doubtful, early in a run."""

    def _step(self, t, h):
        if 0.05 < t < 0.06:
            import warnings

            warnings.warn("the mass was cold", stacklevel=2)
        return super()._step(t, h)


def coupled(step=5e-3, degree=0, algorithm="jacobi", **changes):
    return read_scene({**two_masses(algorithm, step, degree), **changes})


def complaining():
    data = two_masses("jacobi", 5e-3)
    data["units"]["a"]["component"] = f"{__name__}:Complaining"
    return read_scene(data)


SCENES = {  # name -> (scene, share of it at which it was interrupted)
    "grows from before": (lambda: coupled(0.05, stop_time=5.0), 0.7),
    "grows up to its end": (lambda: coupled(0.05, stop_time=4.0), 0.95),
    "bonds": (lambda: read_scene(bonded("Link", "jacobi", 0.05, 0)), 0.5),
    "iterations": (lambda: coupled(algorithm="iterative"), 0.6),
    "a warning of a component": (complaining, 0.5),
    "is followed": (lambda: coupled(degree=1), 0.5),
}


def judged(result):
    """All that a result says of itself but times and where it came from."""
    info = result.info.to_json()
    info.get("verification", {}).pop("seconds", None)
    return {key: value for key, value in info.items() if key not in ("timing", "checkpoints", "resumed")}


def both(scene, file, share, **how):
    """What a run says of itself, and what one says that goes on from a checkpoint of the same."""
    options = {"in_process": True, **how}
    whole = run_verified(scene, **options)
    checkpoints = run_verified(scene, checkpoint_every=share * scene.duration, checkpoint_to=file, **options)
    assert judged(checkpoints) == judged(whole)
    resumed = run_verified(scene, resume=file, **options)
    assert resumed.info.resumed.at < scene.stop_time
    return judged(whole), judged(resumed)


@pytest.mark.parametrize("name", SCENES)
def test_a_resumed_run_says_the_same_of_itself(name, tmp_path):
    scene, share = SCENES[name]
    whole, resumed = both(scene(), tmp_path / "checkpoint", share)
    assert whole["outcome"] == ("unstable" if "grows" in name else "done")
    assert resumed == whole


LONG = {  # runs whose windows alone are repeated
    "two masses": lambda: coupled(degree=1, stop_time=8.0, record={"interval": 0.02}),
    "bonds": lambda: read_scene(bonded("Link", "jacobi", 0.01, 0, energy_correction=True) | {"stop_time": 8.0}),
}


@pytest.mark.parametrize(("name", "share"), [("two masses", 0.3), ("two masses", 0.55), ("two masses", 0.8), ("bonds", 0.6)])
def test_windows_of_a_resumed_run_are_those_of_the_whole(name, share, tmp_path, monkeypatch):
    monkeypatch.setattr(work, "BUDGET", 0.0)
    whole, resumed = both(LONG[name](), tmp_path / "checkpoint", share)
    assert whole["verification"]["windows"]["begins"][0] == 0.0
    assert resumed == whole


def test_a_run_that_a_signal_has_stopped_is_judged_as_a_whole_one(tmp_path, monkeypatch):
    """At several instants one after the other: all that watches the steps has seen the last one."""
    monkeypatch.setattr(work, "BUDGET", 0.0)
    scene, file, reached = LONG["two masses"](), tmp_path / "checkpoint", []
    whole = judged(run_verified(scene, in_process=True))
    for stop in (2.385, 2.39, 2.395, 2.4):
        sent = []

        def step(unit, t, h, _step=Linear._step, stop=stop, sent=sent):
            if t > stop - 0.5 * h and not sent:
                sent.append(signal.raise_signal(signal.SIGINT))
            return _step(unit, t, h)

        with monkeypatch.context() as patch:
            patch.setattr(Linear, "_step", step)
            stopped = run_verified(scene, in_process=True, checkpoint_every=7.9, checkpoint_to=file)
        assert stopped.outcome == "stopped"
        resumed = run_verified(scene, in_process=True, resume=file)
        reached.append(resumed.info.resumed.at)
        assert judged(resumed) == whole
    assert len({*reached}) > 2


def test_windows_that_were_not_kept_are_missed(tmp_path, monkeypatch):
    """A run that was to have no errors keeps no states for them: those of its rest are not the run's."""
    monkeypatch.setattr(work, "BUDGET", 0.0)
    scene, file = coupled(stop_time=8.0), tmp_path / "checkpoint"
    run_verified(scene, verify="no", in_process=True, checkpoint_every=3.0, checkpoint_to=file)
    verification = run_verified(scene, in_process=True, resume=file).info.verification
    assert not verification.done
    assert "the part before the checkpoint has kept none" in verification.why
