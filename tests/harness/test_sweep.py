"""Sweeps: every combination runs, what is measured is right, failures stay in their rows, bad input starts nothing."""

import csv
import signal

import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.components.core.variables import output, parameter
from cosimo.orchestrator.harness.many import point_runs
from cosimo.orchestrator.harness.sweep import points, sweep
from cosimo.orchestrator.interrupts import STOPPING
from cosimo.orchestrator.run.run import run
from cosimo.tests.commands import exit_code
from cosimo.tests.support import OfTime

MASS = {
    "stop_time": 2.0,
    "units": {"m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}}},
    "master": {"step": 1e-3},
    "sweep": {"m": {"k": [400.0, 1600.0], "m": {"from": 1.0, "to": 4.0, "points": 3}}},
}


class Wheel(OfTime):
    """Turns at a constant speed; a signal follows `multiple` times the angle."""

    speed = parameter(7.0, "rad/s", "speed of turning")
    multiple = parameter(1.0, "1", "periods of the signal in a turn")
    angle = output("rad", "angle, from 0 to a full turn")
    height = output("m", "cosine of the multiple of the angle")

    def _outputs(self, t):
        angle = self.parameters["speed"] * t
        self.y[:] = angle % (2.0 * np.pi), np.cos(self.parameters["multiple"] * angle)


def test_every_combination_is_run_and_measured():
    found = sweep(read_scene(MASS))
    k, m = found.varied["m.k"], found.varied["m.m"]
    assert k.tolist() == [400.0] * 3 + [1600.0] * 3
    assert m.tolist() == [1.0, 2.5, 4.0] * 2
    # x = v0 / omega sin(omega t); the samples, 1 ms apart, miss the top by (omega h)^2 / 8 < 2e-4 at most
    np.testing.assert_allclose(found.measures["m.x_out, maximum"], 2.0 / np.sqrt(k / m), rtol=2e-4)
    assert set(found.outcomes) == {"done"}
    assert found.units["m.x_out, maximum"] == "m"


def test_a_section_takes_the_signal_at_equal_angles():
    scene = {
        "stop_time": 9.0,
        "units": {"w": {"component": "cosimo.tests.harness.test_sweep:Wheel"}},
        "master": {"step": 1e-2},
        "sweep": {"w.multiple": [1.0, 0.5, 1.0 / 3.0]},
        "analysis": {"transient": 1.0, "section": {"signal": "w.height", "angle": "w.angle", "turns": 1}},
    }
    one, two, three = sweep(read_scene(scene)).section
    assert one.size == two.size == three.size == 9  # whole turns from angle 7 to angle 63
    # cubic interpolation of a cosine over steps of 0.07 rad: 0.07^4 / 384 * 9, below 1e-6
    np.testing.assert_allclose(one, 1.0, atol=1e-6)
    np.testing.assert_allclose(two, np.cos(np.pi * np.arange(2, 11)), atol=1e-6)
    np.testing.assert_allclose(three, np.cos(2.0 / 3.0 * np.pi * np.arange(2, 11)), atol=1e-6)


def test_a_failing_point_keeps_its_reason_and_the_others_go_on(tmp_path):
    scene = {
        "stop_time": 1.0,
        "units": {"p": {"component": "cosimo.tests.support:Probe"}},
        "master": {"step": 0.1},
        "sweep": {"p.fail_at": [0.5, 9.0]},
    }
    found = sweep(read_scene(scene), directory=tmp_path)
    assert "finite" in found.outcomes[0]
    assert found.outcomes[1] == "done"
    assert np.isnan(found.measures["p.time, maximum"][0])
    assert found.measures["p.time, maximum"][1] == pytest.approx(1.0, rel=1e-15)
    rows = list(csv.reader((tmp_path / "sweep.csv").open()))
    assert rows[0][:2] == ["p.fail_at, s", "p.time, minimum, s"]
    assert [row[-1] == "done" for row in rows[1:]] == [False, True]


@pytest.mark.parametrize(
    ("table", "named"),
    [
        ({"m": {"kk": [1.0]}}, "'k'"),
        ({"n.k": [1.0]}, "unit 'n'"),
        ({"m": [1.0]}, "unit.parameter"),
        ({"m.k": []}, "at least one"),
        ({"m.m": [1.0, -1.0]}, "m = -1.0"),
        ({"m.k": {"from": 0.0, "to": 1.0}}, "points"),
        ({"m.k": {"from": 0.0, "to": 1.0, "points": 1}}, "points"),
        ({}, "sweep"),
    ],
)
def test_bad_sweeps_start_nothing(table, named):
    with pytest.raises(BadInput, match=named):
        points(read_scene(MASS | {"sweep": table}))


@pytest.mark.parametrize(
    ("analysis", "named"),
    [
        ({"transient": 5.0}, "transient"),
        ({"section": {"signal": "m.x_out"}}, "section"),
        ({"section": "m.x_out"}, "section"),
        ({"section": {"signal": "m.x_ot", "angle": "m.x_out"}}, "'m.x_out'"),
        ({"section": {"angle": "m.x_out"}}, "section.signal"),
    ],
)
def test_bad_analysis_is_named_before_the_first_run(analysis, named):
    with pytest.raises(BadInput, match=named):
        sweep(read_scene(MASS | {"analysis": analysis}))


def test_a_point_without_a_section_keeps_its_measures():
    scene = {
        "stop_time": 9.0,
        "units": {"w": {"component": "cosimo.tests.harness.test_sweep:Wheel"}},
        "master": {"step": 1e-2},
        "sweep": {"w.speed": [7.0, 0.0]},
        "analysis": {"section": {"signal": "w.height", "angle": "w.angle"}},
    }
    found = sweep(read_scene(scene))
    assert found.outcomes[0] == "done"
    assert "rests" in found.outcomes[1]
    assert found.measures["w.height, maximum"].tolist() == pytest.approx([1.0, 1.0], abs=1e-3)  # samples 0.07 rad apart


@pytest.mark.interpreted
def test_a_point_that_cannot_start_keeps_its_reason():
    scene = {
        "stop_time": 0.01,
        "units": {"b": {"component": "BallBearing"}},
        "master": {"step": 1e-3},
        "sweep": {"b.substep": [1e-5, 1.0]},
    }
    found = sweep(read_scene(scene))
    assert found.outcomes[0] == "done"
    assert "substep" in found.outcomes[1]


def test_the_command_writes_a_table_and_a_page(tmp_path, capsys):
    scene = tmp_path / "mass.toml"
    scene.write_text('stop_time = 1.0\nunits.m.component = "cosimo.tests.support:Mass"\nmaster.step = 1e-2\n', encoding="utf-8")
    assert exit_code("sweep", scene, "--over", "m.k=100:400:4", "-o", tmp_path / "out") == 0
    assert "4 points, 0 failed" in capsys.readouterr().out
    assert len((tmp_path / "out/sweep.csv").read_text(encoding="utf-8").splitlines()) == 5
    assert "m.k" in (tmp_path / "out/report.html").read_text(encoding="utf-8")
    assert exit_code("sweep", scene, "--over", "m.k=100:400") == 2


class Stopping(Wheel):
    """Raises a signal in the run with one value of its parameter, once."""

    raised: list[float] = []
    number = signal.SIGTERM

    def _step(self, t, h):
        if self.parameters["multiple"] == 3.0 and t > 0.5 and not self.raised:
            self.raised.append(t)
            signal.raise_signal(self.number)
        return super()._step(t, h)


@pytest.mark.parametrize("number", STOPPING)
def test_a_sweep_that_is_stopped_keeps_its_points_and_goes_on(number, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(Stopping, "raised", [])
    monkeypatch.setattr(Stopping, "number", number)
    path, out = tmp_path / "s.toml", tmp_path / "out"
    path.write_text(
        f'stop_time = 1.0\nunits.w.component = "{__name__}:Stopping"\nmaster.step = 0.1\n'
        'sweep."w.multiple" = [1.0, 2.0, 3.0, 4.0]\n'
    )
    handlers = [signal.getsignal(one) for one in STOPPING]
    assert exit_code("sweep", path, "-o", out) == 128 + number
    assert [signal.getsignal(one) for one in STOPPING] == handlers
    err = capsys.readouterr().err
    assert f"stopped by {number.name}, 2 points were not run" in err
    with open(out / "sweep.csv", newline="") as file:
        assert [row["outcome"] for row in csv.DictReader(file)] == ["done", "done", "not run", "not run"]
    (next((out / "points").iterdir()) / "torn.arrow").write_bytes(b"ARROW1")  # as a failing disk leaves it
    runs = []
    monkeypatch.setattr(point_runs, "run", lambda *a, **k: runs.append(a) or run(*a, **k))
    assert exit_code("sweep", path, "-o", out, "--no-verify") == 0
    assert len(runs) == 2  # points that are done are not run again
    resumed = (out / "sweep.csv").read_text()
    assert exit_code("sweep", path, "-o", tmp_path / "whole") == 0
    assert resumed == (tmp_path / "whole" / "sweep.csv").read_text()
