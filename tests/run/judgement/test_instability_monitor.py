"""Runs that become unstable are stopped on the way, with connection and limit; nothing else is."""

import json

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.engine.algorithms import Master
from cosimo.orchestrator.engine.stepping.loop import Needs
from cosimo.orchestrator.judgement.advice import remedy
from cosimo.orchestrator.run.instability import InstabilityMonitor
from cosimo.orchestrator.run.recorded_growth import LookRecord
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import two_masses


def spring(step, degree=0, d=4.0, steps=4000, ground=(0.0, 0.0), **more):
    """1 kg on 100 N/m: held forces are stable up to d/50, the closed form of a mass on a spring and damper."""
    return read_scene(
        {
            "stop_time": steps * step,
            "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
            "units": {
                "m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": ground[0], "c": ground[1]}},
                "s": {"component": "cosimo.tests.support:SpringDamper", "parameters": {"d": d}},
            },
            "master": {"algorithm": "jacobi", "step": step, "extrapolation": degree} | more,
        }
    )


@pytest.mark.first
@pytest.mark.parametrize(("degree", "limit"), [(0, 0.08), (1, 0.1213169), (2, 0.1301332)])
def test_just_beyond_the_limit_a_run_is_stopped_and_just_below_it_is_not(degree, limit):
    """Limits: roots of the characteristic polynomials at a fifth of critical damping, ω = 10 rad/s."""
    finished(spring(0.98 * limit, degree))
    wild = run(spring(1.02 * limit, degree))
    assert wild.outcome == "unstable"
    assert "the coupling is unstable" in wild.message
    assert wild.message.endswith("Reduce the macro step")  # the units are in plain Python: no limit is told
    assert 0.0 < wild.time[-1] < 0.8 * 4000 * limit
    assert np.abs(wild["m.x_out"]).max() < 1e10  # long before what no number can hold
    assert len(wild.time) == round(wild.time[-1] / (1.02 * limit)) + 1  # all that was computed is kept


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_what_grows_too_fast_to_be_watched_names_the_limit_too():
    result = run(
        load_scene("mass-on-spring").with_changes({"master.step": 0.24, "stop_time": 960.0}), in_process=True, remedy=remedy
    )
    assert result.outcome == "unstable"
    assert "has grown to" in result.message
    assert "Reduce the macro step: the coupling is stable up to 0.121 s with master.extrapolation = 1" in result.message


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_coupling_without_a_stable_step_is_told_so():
    changes = {"master.step": 0.05, "master.extrapolation": 0, "spring.damping": 0.0, "stop_time": 200.0}
    result = run(load_scene("mass-on-spring").with_changes(changes), in_process=True, remedy=remedy)
    assert "Change master.extrapolation: with master.extrapolation = 0 no macro step" in result.message


def test_a_motion_that_swings_up_and_is_followed_goes_on():
    """A negative damper on the ground: e-fold in 2 s, by e^20 in all; the steps are a sixtieth of the period."""
    result = finished(spring(0.01, 1, d=0.0, ground=(0.0, -1.0)))
    assert np.abs(result["m.x_out"]).max() > 1e6


def test_what_an_unstable_run_has_missed_does_not_depend_on_batches():
    """Steps in batches are looked at again up to the one that ends the run; each look counts once."""
    scene = load_scene("mass-on-spring").with_changes({"master.step": 0.124, "stop_time": 960.0})
    batches, single = (run(scene, in_process=here) for here in (True, False))
    assert (batches.outcome, single.outcome, batches.rows) == ("unstable", "unstable", single.rows)
    assert batches.info.missed == single.info.missed


def test_energy_that_the_coupling_makes_ends_a_run(monkeypatch):
    """By the account of the bond alone: the inputs' own growth is not looked at here."""
    made = InstabilityMonitor.__init__

    def without_inputs(self, *arguments):
        made(self, *arguments)
        self._free[:] = False

    monkeypatch.setattr(InstabilityMonitor, "__init__", without_inputs)
    data = two_masses("jacobi", 0.03, 1) | {"stop_time": 100.0}
    wild = run(read_scene(data).with_changes({"master.bonds": ("a.v_out * b.force",)}))
    assert wild.outcome == "unstable"
    assert "the coupling makes energy at the bond" in wild.message
    finished(read_scene(data).with_changes({"master.bonds": ("a.v_out * b.force",), "master.step": 0.0137}))


def test_the_watch_cuts_batches_of_steps_where_it_looks_only(monkeypatch):
    """Counted: one look in 29 steps, and as many batches more than without it, at most."""
    batches, looks = [], []
    taken, looked = Master.take_steps, InstabilityMonitor.__call__

    def counted(self, times, *more):
        batches.append(len(times))
        return taken(self, times, *more)

    def seen(self, tick, t):
        looks.append(tick)
        looked(self, tick, t)

    scene = spring(0.01, 1, steps=6000)
    monkeypatch.setattr("cosimo.orchestrator.engine.stepping.loop.BATCH_SECONDS", 1e6)  # no batch ends for its duration
    monkeypatch.setattr(Master, "take_steps", counted)
    monkeypatch.setattr(InstabilityMonitor, "__call__", seen)
    run(scene)
    with_it, batches[:] = len(batches), []
    monkeypatch.setattr(InstabilityMonitor, "__call__", lambda self, tick, t: None)
    monkeypatch.setattr(InstabilityMonitor, "needs", lambda self, tick, length: Needs())
    run(scene)
    assert len(batches) <= with_it <= len(batches) + len(looks)
    assert len(looks) <= 6000 / 29 + 4


def test_exit_code_and_results_of_a_run_that_became_unstable(tmp_path, capsys):
    assert exit_code("run", "mass-on-spring", "--in-process", "--step", "0.13", "--stop", "200", "-o", str(tmp_path)) == 3
    error = capsys.readouterr().err
    assert "unstable" in error
    assert "the coupling is stable up to 0.121 s" in error
    info = json.loads((tmp_path / "run.json").read_text())
    assert info["outcome"] == "unstable"
    assert (tmp_path / "result.csv").read_text().count("\n") > 100
    assert (tmp_path / "report.html").exists()


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("at", [1, 2, 5])
def test_an_input_that_is_switched_on_is_not_missed_by_its_coupling(degree, at):
    """A jump and then no motion: extrapolation misses the jump by itself, in degree + 1 steps, and by more than its deviation."""
    values = np.where(np.arange(50) < at, 0.0, 0.5)
    assert largest_miss(values, degree) is None


@pytest.mark.parametrize(("degree", "share"), [(0, 2.0), (1, 4.0), (2, 8.0)])
def test_an_input_that_alternates_is_missed_all_along(degree, share):
    """Differences of order d + 1 of (-1)^n are 2^(d + 1), and the deviation is 1."""
    assert largest_miss((-1.0) ** np.arange(400), degree) == pytest.approx(share, rel=0.01)


def largest_miss(values, degree):
    """Of an input that is led by the polynomial through its last values, as many as there are up to the degree."""
    missed = [
        abs(np.diff(values[max(0, n - degree - 1) : n + 1], n=min(degree + 1, n))[-1]) if n else 0.0 for n in range(values.size)
    ]
    record, _ = LookRecord.nothing(np.ones(1), None, None).after(
        values[:, None], np.array(missed)[:, None], np.arange(values.size), lambda step: None
    )
    found = record.largest_miss()
    return found and found[1]
