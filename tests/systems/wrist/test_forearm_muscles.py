"""Muscles at their ends: all at once, one alone against the limits, torn fibres, no numbers, a linkage that toggles in a run."""

import math

import numpy as np
import pytest
from cosimo import read_scene
from cosimo.components.wrist.tendons import COUNT, ForearmTendons
from cosimo.orchestrator.run.run import run

pytestmark = pytest.mark.interpreted

ALL = ("fibres", "force_velocity", "varying_arms")


def moved(excitation, effects=("fibres", "force_velocity"), stop=1.5, step=1e-3):
    """A wrist with limits and its muscles at a constant excitation; the run."""
    return run(read_scene({
        "stop_time": stop, "master": {"step": step, "extrapolation": 1},
        "units": {"wrist": {"component": "Wrist", "effects": ["morphology", "interaction"]},
                  "tendons": {"component": "ForearmTendons", "effects": list(effects),
                              "parameters": {"excitation": list(excitation)}}},
        "connections": ["wrist.* -> tendons.*", "tendons.flexion_torque -> wrist.tau_flexion",
                        "tendons.deviation_torque -> wrist.tau_deviation"],
        "record": {"signals": ["wrist.flexion", "wrist.deviation", "tendons.flexion_torque", "tendons.deviation_torque"]},
    }), in_process=True)  # fmt: skip


def test_all_muscles_at_once_leave_the_hand_at_a_place_between():
    """Co-contraction: 489 N press on the wrist, and it comes to rest where flexors and extensors balance.

    Without Hill's hyperbola, whose damping of half a N.m.s/rad makes it creep there for many seconds.
    """
    result = moved([1.0] * COUNT, ("fibres",), 2.5, 2e-3)
    assert result.outcome == "done"
    flexion = np.degrees(result["wrist.flexion"])
    assert abs(flexion[-1] - flexion[-100]) < 0.02
    assert -60.0 < flexion[-1] < 60.0
    assert result["tendons.flexion_torque"][-1] == pytest.approx(result["wrist.flexion"][-1], abs=1e-3)  # 1 N.m/rad


@pytest.mark.first
@pytest.mark.parametrize("muscle", range(COUNT))
def test_one_muscle_alone_at_full_force_stays_within_the_limits(muscle):
    """Against the elastic limits, 200 N.m/rad: beyond them by the torque over the stiffness, no more than a degree."""
    result = moved([float(i == muscle) for i in range(COUNT)])
    assert result.outcome == "done"
    for name, low, high in (("flexion", -1.22173, 1.22173), ("deviation", -0.436332, 0.610865)):
        angle = result[f"wrist.{name}"]
        room = np.abs(result[f"tendons.{name}_torque"]).max() / 200.0
        assert angle.min() > low - 2.0 * room  # twice: it swings into the limit
        assert angle.max() < high + 2.0 * room


def test_fibres_that_are_torn_pull_without_overflow():
    made = ForearmTendons(ALL)
    made.set("flexion", 1e6)
    made.initialize(0.0)
    made.step(0.0, 1e-3)
    assert math.isfinite(made["flexion_torque"])
    assert math.isfinite(made.energy())


def test_a_run_into_the_toggle_keeps_what_it_computed():
    """A link turns the rocker of a crank-rocker: at the toggle the run fails with a word for the user, its results stay."""
    rocker = {"crank": 0.040, "coupler": 0.050, "rocker": 0.020, "ground": 0.055}
    turning = {"start_angle": 1.0, "start_rate": 1.0}
    result = run(read_scene({
        "stop_time": 2.0, "master": {"step": 1e-3, "extrapolation": 1},
        "units": {"link": {"component": "PlanarLink", "effects": ["pinned"], "parameters": turning},
                  "bar": {"component": "FourBar", "parameters": rocker}},
        "connections": ["link.angle -> bar.input_angle", "link.rate -> bar.input_rate"],
    }), in_process=True)  # fmt: skip
    assert result.outcome == "failed"
    assert "toggle" in result.message
    assert "bar" in result.message
    assert result.time[-1] == pytest.approx(math.radians(93.5833) - 1.0, abs=2e-3)
    assert np.isfinite(result["bar.ratio"]).all()
