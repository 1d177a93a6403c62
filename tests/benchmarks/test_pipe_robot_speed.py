"""Speed of a minute of a pipe robot with exact friction, and of the cheaper laws beside it.

Run with `pytest -n 0 tests/benchmarks --write-page`. Nothing here is a statement about another machine.
"""

import time

import numpy as np
from cosimo.components.pipe_robot.robot import PipeRobot
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

MINUTE = 60.0
LAWS = {"exact": (), "smoothed": ("smoothed_friction",), "lugre": ("lugre_friction",)}


def best(effects, steps, runs=3):
    """Shortest time of some warm runs of a minute in `steps` equal macro steps, s, and the robot after the last one."""
    seconds = []
    for _ in range(runs + 1):  # the first compiles
        robot = PipeRobot(("harmonic_force", *effects))
        robot.initialize(0.0)
        h = MINUTE / steps
        begin = time.perf_counter()
        for i in range(steps):
            robot.step(i * h, h)
        seconds.append(time.perf_counter() - begin)
    return min(seconds[1:]), robot


def test_a_minute_with_exact_friction(told):
    """About 19 changes of mode a second, each found to rounding: under half a second in one process, in steps of 10 ms."""
    whole, robot = best((), 1)
    steps, robot_of_steps = best((), 6000)
    switches = robot.work["events"] / MINUTE
    told("systems", f"pipe robot, a minute, {switches:.0f} switches of friction a second, one step", s=whole)
    told("systems", "the same in steps of 10 ms", s=steps)
    assert 18.0 < switches < 21.0
    assert np.isclose(robot["position"], robot_of_steps["position"], rtol=1e-4)
    assert steps < 0.5


def test_price_of_the_laws_of_friction(told):
    """What exact friction costs beside laws that creep."""
    seconds = {name: best(effects, 1)[0] for name, effects in LAWS.items()}
    for law in ("smoothed", "lugre"):
        told("systems", f"the same minute, {law} friction", s=seconds[law])
    assert seconds["exact"] < 3.0 * seconds["smoothed"]


def test_the_scenes_take_less_than_ten_seconds(told):
    for name in ("pipe-robot-level", "pipe-robot-climb", "pipe-robot-resonance", "pipe-robot-motor-start", "pipe-robots-in-tow"):
        scene = load_scene(name)
        run(scene.with_changes({"stop_time": 20.0 * scene.master.step}))
        result = run(scene)
        assert result.outcome == "done", result.message
        told("systems", f"`{name}` as FMUs", s=result.info.timing.run)
        assert result.info.timing.run < 10.0
