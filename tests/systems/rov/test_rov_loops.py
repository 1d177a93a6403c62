"""Thrusters and controller in a loop: dead band, reverse thrust, far set points."""

import math

import numpy as np
import pytest
from cosimo.components.rov.arrangement import HORIZONTAL_RADIUS
from cosimo.components.rov.thrust_curve import ROWS, T200_COMMAND, T200_THRUST, curve_command, curve_thrust
from cosimo.components.rov.thruster import Thruster
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.scene_runs import finished

JUMP = {
    f"{name}[{k + 1}]": v
    for k in range(ROWS)
    for name, v in (
        ("command", (-1.0, -0.1, -0.1, 0.1, 0.1, 1.0)[min(k, 5)]),
        ("thrust", (-40.0, -4.0, 0.0, 0.0, 4.0, 40.0)[min(k, 5)]),
    )
}


def turned(inverse: bool, stop: float = 60.0):
    """A neutral vehicle in still water that is to turn by 0.3 rad, with much integral action; thrusters with a dead band."""
    result = finished(
        load_scene("rov-station-keeping").with_changes(
            {
                "stop_time": stop,
                "units.current.effects": [],
                "units.current.parameters": {"speed": 0.0},
                "units.hull.parameters": {"restoring.buoyancy": 112.8, "start_depth": 5.0},
                "units.controller.effects": ["inverse_curve"] if inverse else [],
                "units.controller.parameters": {"set_depth": 5.0, "set_yaw": 0.3, "attitude_integral_gain[3]": 6.0},
            }
        )
    )
    return result


def heading_alone(stop: float, h: float = 0.005) -> np.ndarray:
    """The same turn as one equation of the heading, in Python: sampled PID, static curve, lag, inertia and drag; every 20 ms."""
    commands, thrusts = np.array(T200_COMMAND), np.array(T200_THRUST)
    yaw = rate = integral = thrust = 0.0
    rows = []
    for _ in range(round(stop / 0.02)):
        rows.append(yaw)
        moment = integral + 4.0 * (0.3 - yaw) - 1.8 * rate
        integral += 0.02 * 6.0 * (0.3 - yaw)
        wanted = moment / (3.0 * HORIZONTAL_RADIUS)
        given = curve_thrust(wanted / (51.44 if wanted > 0.0 else 39.90), commands, thrusts)
        for _ in range(round(0.02 / h)):
            thrust = given + (thrust - given) * math.exp(-h / 0.1)
            rate += h * (3.0 * HORIZONTAL_RADIUS * thrust - 0.07 * rate - 1.55 * abs(rate) * rate) / 0.28
            yaw += h * rate
    return np.array(rows)


@pytest.mark.full
def test_a_dead_band_makes_a_limit_cycle_as_one_equation_has_it():
    result = turned(inverse=False)
    alone = heading_alone(60.0)
    late = slice(-1500, None)  # 30 s
    assert np.ptp(result["hull.yaw"][late]) > 0.2
    assert np.ptp(result["hull.yaw"][late]) == pytest.approx(np.ptp(alone[late]), rel=0.05)
    # it neither grows nor dies
    assert np.ptp(result["hull.yaw"][1000:1500]) == pytest.approx(np.ptp(result["hull.yaw"][late]), rel=0.05)

    def crossings(yaw: np.ndarray) -> float:
        return float(np.mean(np.diff(np.flatnonzero((yaw[:-1] < 0.3) & (yaw[1:] >= 0.3)))))

    assert crossings(result["hull.yaw"][late]) == pytest.approx(crossings(alone[late]), rel=0.05)


@pytest.mark.full
def test_the_inverse_curve_ends_the_limit_cycle():
    result = turned(inverse=True)
    assert np.abs(result["hull.yaw"][-1500:] - 0.3).max() < 1e-4
    assert np.abs(result["hull.depth"][-1500:] - 5.0).max() < 1e-4


@pytest.mark.full
def test_a_curve_with_a_true_jump_has_one_answer_at_every_command_and_thrust():
    """Dead band to either side of 0 and jumps of 4 N at its ends: nothing in between can be had; the inverse says the edge."""
    thruster = Thruster(("static_curve",), {f"static_curve.{k}": v for k, v in JUMP.items()})
    thruster.initialize(0.0)
    for command, thrust in (
        (-0.1, 0.0),
        (np.nextafter(-0.1, -1.0), -4.0),
        (0.0, 0.0),
        (np.nextafter(0.1, 0.0), 0.0),
        (0.1, 4.0),
        (0.55, 22.0),
        (3.0, 40.0),
    ):
        thruster["command"] = command
        thruster.refresh()
        assert thruster["thrust"] == pytest.approx(thrust, abs=1e-12)
    commands, thrusts = (np.array([JUMP[f"{n}[{k + 1}]"] for k in range(ROWS)]) for n in ("command", "thrust"))
    for thrust in (0.5, 3.999, 4.0):
        assert curve_command(thrust, commands, thrusts) == pytest.approx(0.1, abs=1e-15)
    for thrust in (-0.5, -3.999, -4.0):
        assert curve_command(thrust, commands, thrusts) == pytest.approx(-0.1, abs=1e-15)
    assert curve_command(0.0, commands, thrusts) == 0.0
    assert curve_command(1e9, commands, thrusts) == 1.0


@pytest.mark.full
@pytest.mark.parametrize("advance", [0.5, 2.0, 4.0])
def test_reverse_thrust_against_the_motion_is_greater_and_no_gift(advance):
    """Braking at speed: more thrust astern than at rest, mirrored for the other direction, and still work done on the water."""
    braking = {}
    for sign in (1.0, -1.0):
        thruster = Thruster(("propeller",))
        thruster["command"], thruster["propeller.advance_speed"] = -sign, sign * advance
        thruster.initialize(0.0)
        braking[sign] = thruster["thrust"]
        thruster.step(0.0, 1.0)
        assert thruster["thrust"] == pytest.approx(braking[sign], rel=1e-9)  # the start was the equilibrium
        assert thruster["propeller.torque"] * thruster["propeller.speed"] > 0.0
        assert thruster["thrust"] * sign * advance < 0.0
        thruster["propeller.advance_speed"] = 0.0
        thruster.initialize(0.0)
        assert abs(braking[sign]) > abs(thruster["thrust"])
    assert braking[1.0] == -braking[-1.0]


@pytest.mark.full
@pytest.mark.parametrize(("reach", "kept"), [(1.0, True), (100.0, False)])
def test_a_far_set_point_is_reached(reach, kept):
    """Tens of metres off. Within a reach of 1 m thrusters have enough left for the attitude; answered in full, the error takes
    nearly all of the wrench, which is scaled as a whole, and the vehicle turns over on its way; it arrives either way."""
    way = np.array([15.0, -12.0, 5.0])
    result = finished(
        load_scene("rov-station-keeping").with_changes(
            {
                "stop_time": 90.0,
                "units.current.effects": [],
                "units.current.parameters": {"speed": 0.0},
                "units.controller.parameters": {
                    "set_north": way[0],
                    "set_east": way[1],
                    "set_depth": 5.0 + way[2],
                    "reach": reach,
                },
            }
        )
    )
    position = np.array([result[f"hull.{n}"] for n in ("position_north", "position_east", "depth")]) - [[0.0], [0.0], [5.0]]
    np.testing.assert_allclose(position[:, -1], way, atol=0.05)
    assert (np.abs(result["hull.yaw"]).max() < 0.3 and np.abs(result["hull.pitch"]).max() < 0.3) == kept
    assert (result["controller.scale"].min() == 1.0) == kept
    along = way / np.linalg.norm(way) @ position
    assert along.max() < (1.02 if kept else 1.5) * np.linalg.norm(way)  # no windup on the long way; tumbling, it brakes late
