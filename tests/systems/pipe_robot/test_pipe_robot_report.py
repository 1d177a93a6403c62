"""Figures and tables of pipe robots carry what made-up signals hold: mean speeds, modes, energies, standstill, frequencies."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import SYSTEMS, read_scene
from cosimo.orchestrator.systems.pipe_robot.figures import ways
from cosimo.orchestrator.systems.pipe_robot.records import (
    amplitude,
    mean_over,
    mean_speed,
    robots,
    standing_since,
    steady_speed,
    switches,
)
from cosimo.tests.harness.figures import assert_valid_with_units, drawn, figures, numbers, tables

pytestmark = pytest.mark.full

UNIT = re.compile(r", (m|m/s|mm|N|s|rad/s|degrees)$")
FREQUENCY, SPEED, SWING, STRETCH = 20.0 * np.pi, 0.3, 0.8, 5e-3  # rad/s: a period of 0.1 s
T = np.linspace(0.0, 4.0, 4001)


def moving(t=T, speed=SPEED, frequency=FREQUENCY):
    """Signals of a body that swings about a mean speed, and of an inner mass that swings against it."""
    velocity = speed + SWING * np.cos(frequency * t)
    position = speed * t + SWING / frequency * np.sin(frequency * t)
    return {
        "position": position, "velocity": velocity, "inner_position": position + STRETCH * np.sin(frequency * t),
        "inner_velocity": velocity + STRETCH * frequency * np.cos(frequency * t), "mode": np.sign(velocity),
        "friction_force": np.where(velocity > 0.0, -2.0, 8.0), "exciter_power": np.full(t.size, 3.0),
        "dissipation": np.full(t.size, 2.0),
    }  # fmt: skip


def run_of(columns, exciter="harmonic_force", analysis=None):
    """A result of robots by unit -> signal -> (n,)."""
    given = {"harmonic_force.frequency": FREQUENCY} if exciter == "harmonic_force" else {}
    units = {u: {"component": "PipeRobot", "effects": [exciter], "parameters": given} for u in columns}
    scene = {"title": "Made-up robots", "stop_time": float(T[-1]), "master": {"step": 1e-3}, "units": units,
             "analysis": {"system": "pipe_robot", **(analysis or {})}}  # fmt: skip
    named = {f"{u}.{n}": v for u, own in columns.items() for n, v in own.items()}
    return SimpleNamespace(scene=read_scene(scene), time=T, columns=named, measures=dict.fromkeys(named, "1"),
                           snapshots={}, outcome="done", message="", info=RunRecord(outcome="done"))  # fmt: skip


def test_every_figure_is_valid_and_every_axis_has_its_unit():
    standing = {**moving(), **{n: np.zeros(T.size) for n in ("position", "velocity", "mode")}}
    blocks = SYSTEMS["pipe_robot"].figures(run_of({"one": moving(), "two": standing}, analysis={"transient": 1.0}))
    assert list(figures(blocks)) == ["Way and speed", "What stands and what creeps", "In detail"]
    assert list(tables(blocks)) == ["Travel", "Energy"]
    for figure in figures(blocks).values():
        assert_valid_with_units(figure, UNIT)


def test_a_mean_over_a_period_knows_no_swing():
    (robot,) = robots(run_of({"robot": moving()}))
    speed = mean_speed(robot)
    inner = (T > 0.06) & (T < 3.94)
    assert speed[inner] == pytest.approx(SPEED, abs=1e-9)
    assert np.isnan(speed[[0, -1]]).all()
    # chords of 1 ms instead of the sine
    assert amplitude(robot)[inner] == pytest.approx(STRETCH, rel=1e-3)
    assert mean_over(robot, robot.signals["velocity"])[inner] == pytest.approx(SPEED, abs=1e-3)
    assert steady_speed(robot, slice(1234, None)) == pytest.approx(SPEED, abs=1e-4)  # not whole periods, but taken so
    assert switches(robot, slice(0, None)) == pytest.approx(20.0, abs=0.5)


def test_the_table_has_way_speed_modes_and_energies():
    by_title = tables(SYSTEMS["pipe_robot"].figures(run_of({"robot": moving()}, analysis={"transient": 2.0})))
    _, way, speed, forwards, rest, backwards, changes = (
        c if k == 0 else float(c) for k, c in enumerate(by_title["Travel"].rows[0])
    )
    assert (way, speed, rest) == pytest.approx((2.0 * SPEED, SPEED, 0.0), rel=1e-3)
    share = 100.0 * np.arccos(-SPEED / SWING) / np.pi
    assert (forwards, backwards, changes) == pytest.approx((share, 100.0 - share, 20.0), abs=1.0)  # 100 samples a period
    gave, lost, cost = (float(v) for v in by_title["Energy"].rows[0][1:])
    assert (gave, lost, cost) == pytest.approx((6.0, 4.0, 6.0 / (2.0 * SPEED)), rel=1e-3)


def test_the_one_that_stands_is_said_and_the_others_are_drawn_from_then_on():
    stops = np.minimum(T, 1.0)
    halting = {**moving(), "position": stops, "velocity": np.where(T < 1.0, 1.0, 0.0)}
    creeping = {**moving(), "position": 1e-4 * T, "velocity": np.full(T.size, 1e-4)}
    result = run_of({"exact": halting, "smoothed": creeping})
    assert [standing_since(r) for r in robots(result)] == [pytest.approx(1.0), None]
    (block,) = [b for b in SYSTEMS["pipe_robot"].figures(result) if b.title == "What stands and what creeps"]
    assert "does not move at all: exact" in block.caption
    assert "smoothed 0.0003 m" in block.caption
    (curve,) = drawn(block.figure, "smoothed")
    assert np.nanmax(numbers(curve["y"])) == pytest.approx(3e-4, rel=1e-3)
    assert not drawn(block.figure, "exact")


def test_a_sweep_is_drawn_up_and_down_over_its_frequency():
    sweep = 100.0 - 20.0 * np.abs(T - 2.0)
    result = run_of({"robot": {**moving(), "unbalance.rate": sweep}}, "unbalance")
    blocks = SYSTEMS["pipe_robot"].figures(result)
    figure = figures(blocks)["Against the exciter's frequency"]
    names = {t["name"] for t in figure["data"]}
    assert {"robot, rising", "robot, falling", "resonance, body free"} <= names
    x = numbers(drawn(figure, "robot, rising")[0]["x"])
    assert (np.nanmin(x), np.nanmax(x)) == pytest.approx((60.0, 100.0), abs=0.1)
    swinging = np.minimum(50.0 * T, 100.0) + np.sin(20.0 * T)  # a motor about its speed
    assert [way for way, _ in ways(swinging)] == ["rising"]


def test_the_detail_is_the_part_that_was_asked_for():
    figure = figures(SYSTEMS["pipe_robot"].figures(run_of({"robot": moving()}, analysis={"detail": [1.0, 1.2]})))["In detail"]
    x = numbers(drawn(figure, "body")[0]["x"])
    assert (x[0], x[-1]) == pytest.approx((1.0, 1.2))


def test_a_run_without_robots_has_no_blocks():
    result = run_of({"robot": moving()})
    result.columns = {"robot.mode": np.zeros(T.size)}
    assert SYSTEMS["pipe_robot"].figures(result) == []
