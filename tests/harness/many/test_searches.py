"""Fits and designs: the same for any number of workers and starts, kept as points, going on where they were ended."""

import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from itertools import pairwise

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.derivatives import tangent_run
from cosimo.orchestrator.derivatives.along import PointDerivatives
from cosimo.orchestrator.harness.journal import Stopped
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.evaluations import evaluations
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.many.searches import jacobian, run_searches
from cosimo.orchestrator.interrupts import Interrupted
from cosimo.orchestrator.settings.answers import RangeSettings
from cosimo.orchestrator.settings.plan import KeepSettings
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.harness.many.points import formula
from cosimo.tests.harness.many.test_answers import measured
from cosimo.tests.harness.many.test_runs import contents, parts
from cosimo.tests.harness.test_sweep import MASS
from pyarrow import feather

TWO = {  # (a - 1)² + (b - 2)² = 2 and a + b = 3: at (2, 1) and at (0, 3)
    "vary": {"f.a": {"low": -3.0, "high": 4.0, "start": 1.5}, "f.b": {"low": -3.0, "high": 6.0, "start": 1.5}},
    "targets": [
        {"quantity": "f.parabola, end", "value": 2.0, "deviation": 0.1},
        {"quantity": "f.total, end", "value": 3.0, "deviation": 0.1},
    ],
}

OSCILLATOR = load_scene("mass-on-spring").with_changes({"stop_time": 0.2})  # kernels alone: workers are threads
STIFF = {
    "vary": {"spring.stiffness": {"low": 50.0, "high": 200.0}, "mass.mass": {"low": 1.0, "high": 2.0}},
    "minimise": "mass.base_x, maximum",
    "constraints": {"spring.second_force_x, maximum": {"high": 6.0}},
}


def test_a_fit_does_not_depend_on_the_number_of_workers(tmp_path):
    targets = [{"quantity": "mass.base_x, maximum", "value": 0.08, "deviation": 0.005}]
    settings = {"vary": {"spring.stiffness": STIFF["vary"]["spring.stiffness"]}, "targets": targets, "starts": 2}
    one, two = (fit(OSCILLATOR, settings, tmp_path / str(jobs), jobs=jobs) for jobs in (1, 2))
    assert one.fit.values.tobytes() == two.fit.values.tobytes()
    assert one.fit.covariance.tobytes() == two.fit.covariance.tobytes()
    assert one.runs == one.computed == two.computed == len(one.sweeps[0].outcomes)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_fit_has_exact_jacobians_where_the_scene_has_derivatives():
    """Its own numbers are found to the last of their digits, with a run a step, and with rows that are not those of macro steps."""
    scene = OSCILLATOR.with_changes({"record.interval": 0.007})
    true = {"spring.stiffness": 120.0, "mass.mass": 1.2}
    kept = cosimo.gradient(
        scene.with_changes(true), of=["mass.base_x, maximum", "mass.base_velocity_x, minimum"], halved=False, by="mass.mass"
    )
    targets = [{"quantity": s.figure, "value": s.value, "deviation": 1e-3} for s in kept.slopes]
    vary = {"spring.stiffness": {"low": 100.0, "high": 200.0}, "mass.mass": {"low": 1.0, "high": 2.0}}
    found = fit(scene, {"vary": vary, "targets": targets}, verify=False)
    assert dict.fromkeys(vary, "exact") == found.derivatives
    steps = found.fit.evaluations
    assert 0 < found.jacobians <= steps <= found.runs <= steps + 1  # the start is one of them, but for rounding
    assert found.fit.values == pytest.approx(list(true.values()), rel=1e-8)
    step = vary | {"mass.substep": {"low": 1e-4, "high": 2e-3}}
    other = fit(scene, {"vary": step, "targets": [*targets, targets[0]], "evaluations": 2}, verify=False)
    assert other.derivatives["mass.mass"] == "exact"
    assert other.derivatives["mass.substep"].startswith("differences (it sets the numerical error alone")
    assert other.runs > other.jacobians
    by_runs = fit(
        scene.with_changes({"master.algorithm": "iterative"}), {"vary": vary, "targets": targets, "evaluations": 1}, verify=False
    )
    assert "iterative" in by_runs.derivatives["mass.mass"]
    assert by_runs.jacobians == 0
    assert by_runs.runs >= 3


@pytest.mark.parametrize("name", ["units.mass.parameters.mass", "catenary.span_length"])
@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_point_with_what_derivatives_do_not_know_has_differences(name):
    """Structural ones, other spellings: the run that tangents follow cannot have these numbers."""
    scene = load_scene("en50318-2002") if name.startswith("catenary") else OSCILLATOR
    other = "pantograph.static_force" if name.startswith("catenary") else "spring.stiffness"
    with ExitStack() as stack:
        derivatives = PointDerivatives(scene, [other, name], stack)
        assert derivatives({other: 100.0, name: 50.0}, lambda result: np.zeros(1)).shape == (0, 2)
    assert all(name in derivatives.how(n) for n in (other, name))


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_design_with_another_spelling_of_a_parameter():
    bounds = STIFF["vary"]
    vary = {"units.mass.parameters.mass": bounds["mass.mass"], "spring.stiffness": bounds["spring.stiffness"]}
    found = design(OSCILLATOR, STIFF | {"vary": vary, "method": "SLSQP", "evaluations": 1}, verify=False)
    assert found.steps


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_an_aim_and_its_limits_have_derivatives_of_one_run(monkeypatch):
    points, kept = [], tangent_run.recorded
    monkeypatch.setattr(
        tangent_run, "recorded", lambda block, point, names: points.append(dict(point)) or kept(block, point, names)
    )
    assert design(OSCILLATOR, STIFF | {"method": "SLSQP", "evaluations": 3}, verify=False).steps
    assert len(points) > 1
    assert all(one != other for one, other in pairwise(points))


def test_the_runs_of_a_fit_are_kept_with_their_signals(tmp_path):
    scene = read_scene(MASS | {"sweep": {}, "master": {"step": 1e-2}})
    settings = {
        "vary": {"m.k": {"low": 300.0, "high": 500.0, "start": 380.0}, "m.v0": {"low": 1.0, "high": 3.0}},
        "curves": [measured(tmp_path)],
    }
    one = fit(scene, settings, tmp_path / "out", folder=tmp_path)
    again = fit(scene, settings, tmp_path / "out", folder=tmp_path)
    assert (again.computed, again.runs) == (0, one.runs)
    assert again.fit.values.tobytes() == one.fit.values.tobytes()
    # the data set has the signals of every run: x = v0/ω sin ωt
    time, x = list(one.sweeps[0].signals("m.x_out"))[-1]
    k, v0 = one.sweeps[0].varied["m.k"][-1], one.sweeps[0].varied["m.v0"][-1]
    np.testing.assert_allclose(x, v0 / np.sqrt(k) * np.sin(np.sqrt(k) * time), atol=1e-9)


def test_a_design_by_differences_does_not_depend_on_the_number_of_workers(tmp_path):
    one, two = (design(OSCILLATOR, STIFF | {"method": "SLSQP", "starts": 3}, tmp_path / str(jobs), jobs=jobs) for jobs in (1, 2))
    assert one.steps == two.steps
    assert one.starts == 3
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
    assert design(OSCILLATOR, STIFF | {"method": "SLSQP", "starts": 3}, tmp_path / "2").computed == 0


def test_several_starts_find_what_one_start_does_not_see():
    one = fit(read_scene(formula()), TWO)
    assert not any("another fit" in text for text in one.fit.messages)
    several = fit(read_scene(formula()), TWO | {"starts": 6})
    places = sorted(tuple(map(round, np.array(p))) for p in (several.fit.values, _named(several.fit.messages)))
    assert places == [(0, 3), (2, 1)]


def _named(messages):
    """The values in the message on another fit."""
    text = next(t for t in messages if t.startswith("another fit explains the data as well, within 95 %"))
    return [float(part.split(" = ")[1]) for part in text.split(": ")[1].split(", ")]


def test_differences_stay_within_bounds_and_go_around_failed_runs():
    """Of (u², u v): columns (2 u, v) and (0, u), but for half a step."""
    asked = []

    def values_unless(failed):
        def values(points):
            asked.extend(points)
            return [np.full(2, np.nan) if failed(u, v) else np.array([u * u, u * v]) for u, v in points]

        return values

    def found(failed, u, v):
        return jacobian(values_unless(failed), np.array([u, v]), 1e-3, ["u", "v"], np.empty((0, 2)))

    np.testing.assert_allclose(found(lambda u, v: False, 0.5, 1.0), [[1.001, 0.0], [1.0, 0.5]], rtol=1e-9)
    np.testing.assert_allclose(found(lambda u, v: u > 0.5, 0.5, 0.3), [[0.999, 0.0], [0.3, 0.5]], rtol=1e-9)
    with pytest.raises(BadInput, match="search: v"):
        found(lambda u, v: v != 0.3, 0.5, 0.3)
    assert all(p.min() >= 0.0 and p.max() <= 1.0 for p in asked)
    asked.clear()
    exact = np.array([[1.0, np.nan], [0.3, np.nan]])  # columns that are known are taken, and no run is asked for
    mixed = jacobian(values_unless(lambda u, v: False), np.array([0.5, 0.3]), 1e-3, ["u", "v"], exact)
    np.testing.assert_allclose(mixed, [[1.0, 0.0], [0.3, 0.5]], atol=1e-12)
    assert len(asked) == 2
    exact[:, 1] = 0.0, 0.5
    assert jacobian(values_unless(lambda u, v: False), np.array([0.5, 0.3]), 1e-3, ["u", "v"], exact) is exact


def test_searches_ask_together_and_a_failed_one_ends_all():
    batches = []

    def compute(points):
        batches.append([p.tolist() for p in points])
        return [p.sum() for p in points]

    def search(first, times):
        def work(ask):
            return sum(ask([np.array([first + k])])[0] for k in range(times))

        return work

    assert run_searches([search(0.0, 2), search(10.0, 3)], compute) == [1.0, 33.0]
    assert batches == [[[0.0], [10.0]], [[1.0], [11.0]], [[12.0]]]
    before = threading.active_count()

    def fails(ask):
        ask([np.array([1.0])])
        raise BadInput("here", "a fault", "none")

    with pytest.raises(BadInput, match="a fault"):
        run_searches([search(0.0, 9), fails, search(5.0, 9)], compute)
    assert threading.active_count() == before


SCENE = """
stop_time = 1.0
[units.d]
component = "cosimo.tests.harness.many.points:Doubler"
parameters = { pause = 0.1 }
[master]
step = 1.0
"""
PLAN = """
starts = 3
[vary]
"d.value" = { low = 0.0, high = 10.0, start = 1.0 }
[[targets]]
quantity = "d.twice, end"
value = 6.0
deviation = 0.1
"""


@pytest.mark.full
def test_a_stopped_fit_goes_on_with_what_it_has(tmp_path, monkeypatch):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "fit.toml").write_text(PLAN)
    options = ["--plan", tmp_path / "fit.toml", "--jobs", "1", "-o", tmp_path / "out"]
    command = [sys.executable, "-m", "cosimo.orchestrator.cli", "fit", tmp_path / "scene.toml", *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        while len(parts(tmp_path / "out")) < 5:
            assert process.poll() is None
            time.sleep(0.05)
    finally:
        process.terminate()
        _, messages = process.communicate()
    assert process.returncode == 128 + signal.SIGTERM
    assert "stopped by SIGTERM" in messages
    assert "the same command goes on" in messages
    kept = sum(feather.read_table(p).num_rows for p in parts(tmp_path / "out"))
    assert kept >= 5
    monkeypatch.setattr(time, "sleep", lambda seconds: None)  # in the runs
    scene = load_scene(tmp_path / "scene.toml")
    rest = fit(scene, tmp_path / "fit.toml", tmp_path / "out")
    whole = fit(scene, tmp_path / "fit.toml", tmp_path / "whole")
    assert rest.computed == whole.computed - kept
    assert contents(tmp_path / "out") == contents(tmp_path / "whole")
    (row,) = rest.fit.rows()
    assert row[1:3] == (pytest.approx(3.0, abs=1e-6), pytest.approx(0.05, rel=1e-6))


def test_a_search_that_is_stopped_between_its_runs_tells_what_it_keeps(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE.replace("0.1", "0.0"))
    scene = load_scene(tmp_path / "scene.toml")
    bounds = {"d.value": RangeSettings(low=0.0, high=10.0)}

    def search():
        with evaluations(scene, bounds, KeepSettings(), {}, tmp_path / "out") as runs:
            runs([np.array([1.0]), np.array([2.0])])
            raise Interrupted(signal.SIGTERM)

    with pytest.raises(Stopped) as told:
        search()
    assert (told.value.signal, told.value.kept) == (signal.SIGTERM, 2)
