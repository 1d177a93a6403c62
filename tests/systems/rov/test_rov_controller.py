"""The controller's law by hand, its samples, its way through a manoeuvre, and what flows back into its integrals."""

import math

import numpy as np
import pytest
from cosimo.components.rov.arrangement import wrench_matrix, y_arrangement
from cosimo.components.rov.controller import RovController
from cosimo.tests.support import initialized
from scipy.spatial.transform import Rotation

pytestmark = pytest.mark.interpreted

MATRIX = wrench_matrix(*y_arrangement())
POSE = ("position_north", "position_east", "depth")
QUATERNION = tuple(f"quaternion_{n}" for n in "wxyz")
MOTION = ("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")


def started(*effects, inputs=(), **parameters) -> RovController:
    controller = RovController(effects, {k.replace("__", "."): v for k, v in parameters.items()})
    see(controller, inputs)
    return initialized(controller)


def see(controller: RovController, inputs) -> None:
    for name, value in dict(inputs).items():
        controller[name] = value


def attitude(turn: Rotation, sign: float = 1.0) -> dict[str, float]:
    x, y, z, w = turn.as_quat()
    return dict(zip(QUATERNION, (sign * w, sign * x, sign * y, sign * z), strict=True))


def wrench(controller: RovController) -> np.ndarray:
    """What ideal thrusters make of the commands, N and N.m, (6,)."""
    commands = np.array([controller[f"command[{k}]"] for k in range(1, 7)])
    return MATRIX @ np.where(commands > 0.0, 51.44 * commands, 39.90 * commands)


def test_the_wrench_is_the_law_at_random_poses():
    """Rotations and rotation vectors of another library, gains as declared, no sample before this one."""
    rng = np.random.default_rng(0)
    gains = np.array([24.0, 34.0, 37.0]), np.array([35.0, 50.0, 55.0]), 4.0, 1.8
    for _ in range(30):
        here, there = Rotation.random(random_state=rng), rng.uniform(-1.0, 1.0, size=3) * (math.pi, 1.4, math.pi)
        position, motion, goal = rng.uniform(-0.2, 0.2, 3), rng.normal(size=6) * 0.1, rng.uniform(-0.2, 0.2, 3)
        controller = started(
            inputs={**dict(zip(POSE, position, strict=True)), **attitude(here), **dict(zip(MOTION, motion, strict=True))},
            set_north=goal[0],
            set_east=goal[1],
            set_depth=goal[2],
            set_roll=there[0],
            set_pitch=there[1],
            set_yaw=there[2],
        )
        force = gains[0] * here.inv().apply(goal - position) - gains[1] * motion[:3]
        error = (here.inv() * Rotation.from_euler("ZYX", there[::-1])).as_rotvec()
        wanted = np.concatenate((force, gains[2] * error - gains[3] * motion[3:]))
        np.testing.assert_allclose(wrench(controller), controller["scale"] * wanted, atol=1e-10)
        np.testing.assert_allclose([controller[f"error_{n}"] for n in ("roll", "pitch", "yaw")], error, atol=1e-12)


def test_integrals_grow_with_the_error_and_turn_with_the_vehicle():
    """A force gathered against a current from the north stays a force to the north when the vehicle turns."""
    controller = started(inputs={"position_north": -0.1}, unwinding_time=1e9)
    controller.step(0.0, 0.98)  # 50 samples with the one at the start, each adds period * gain * error
    gathered = 50 * 0.02 * 6.0 * 0.1
    see(controller, {"position_north": 0.0, **attitude(Rotation.from_euler("Z", 0.5 * math.pi)), "yaw_rate": 0.0})
    controller.step(0.98, 0.02)
    before = wrench(controller)
    assert before[0] == pytest.approx(0.0, abs=1e-9)
    assert before[1] == pytest.approx(-gathered, rel=1e-9)  # the north is to port


def test_commands_are_held_between_samples_whatever_the_macro_step():
    """Commands at the samples' instants are of the inputs there, also where a step has several samples, or none."""

    def run(steps):
        controller, t, seen = started(), 0.0, {}
        for h in steps:
            controller.u[1, controller.inputs.index("surge")] = 1.0
            controller.step(t, h)
            t += h
            seen[round(t, 9)] = wrench(controller)[0]
        return controller, seen

    fine, seen = run([0.002] * 100)
    for t, force in seen.items():
        sample = 0.02 * math.floor(t / 0.02 + 1e-6)
        assert force == pytest.approx(-35.0 * sample, abs=1e-9)
    coarse, other = run([0.05] * 4)
    assert fine.work["samples"] == coarse.work["samples"] == 10
    for t, force in other.items():
        assert force == pytest.approx(seen[t], abs=1e-12)


def test_a_start_between_samples_samples_at_once_and_then_on_the_grid():
    controller = RovController()
    controller.initialize(0.013)
    assert controller.work["samples"] == 0  # of steps
    controller.step(0.013, 0.007)
    assert controller.work["samples"] == 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_both_signs_of_the_quaternion_are_one_attitude(sign):
    turn = Rotation.from_euler("ZYX", [3.0, 0.4, -2.0])
    controller = started(inputs=attitude(turn, sign), set_yaw=-2.5)
    np.testing.assert_array_equal(wrench(controller), wrench(started(inputs=attitude(turn), set_yaw=-2.5)))


def test_the_shorter_way_is_taken():
    """From a heading of 170 to one of -170 degrees it is 20 degrees to starboard."""
    controller = started(inputs=attitude(Rotation.from_euler("Z", math.radians(170.0))), set_yaw=math.radians(-170.0))
    assert controller["error_yaw"] == pytest.approx(math.radians(20.0), rel=1e-12)
    assert wrench(controller)[5] > 0.0


TABLE = {
    "manoeuvre.time[1]": 1.0,
    "manoeuvre.time[2]": 3.0,
    "manoeuvre.time[3]": 3.0,
    "manoeuvre.time[4]": 5.0,
    "manoeuvre.north[2]": 2.0,
    "manoeuvre.north[3]": 3.0,
    "manoeuvre.north[4]": 3.0,
    "manoeuvre.yaw[4]": 1.0,
}


def at(t: float, **inputs) -> RovController:
    controller = RovController(("manoeuvre",), {**TABLE, "set_north": 10.0})
    see(controller, inputs)
    controller.initialize(t)
    return controller


@pytest.mark.known_answers(RovController="manoeuvre")
@pytest.mark.parametrize(
    ("t", "north", "yaw"),
    [
        (0.0, 10.0, 0.0),
        (1.5, 10.0 + 2.0 * 5.0 / 32.0, 0.0),
        (2.0, 11.0, 0.0),
        (3.0, 13.0, 0.0),
        (4.0, 13.0, 0.5),
        (5.0, 13.0, 1.0),
        (60.0, 13.0, 1.0),
    ],
)
def test_a_manoeuvre_goes_through_its_poses(t, north, yaw):
    """s² (3 - 2 s) of each way, a jump at 3 s, and the last pose for ever."""
    controller = at(t)
    assert controller["error_north"] == pytest.approx(north, rel=1e-14)
    assert controller["error_yaw"] == pytest.approx(yaw, rel=1e-12)


def test_a_vehicle_that_follows_perfectly_gets_no_command():
    """The wanted velocity is the derivative of the wanted pose, in turning body axes."""
    controller = at(2.0, position_north=11.0, surge=1.5)  # 6 s (1 - s) / 2 s * 2 m at s = 1/2
    np.testing.assert_allclose(wrench(controller), 0.0, atol=1e-12)
    controller = at(4.0, position_north=13.0, yaw_rate=0.75, **attitude(Rotation.from_euler("Z", 0.5)))
    np.testing.assert_allclose(wrench(controller), 0.0, atol=1e-12)


def test_what_limits_keep_back_does_not_wind_up():
    """A vehicle held 0.9 m off for a minute: the integral stays where wanted and given differ by a second's worth of growth."""
    held = started(inputs={"position_north": -0.9})
    held.step(0.0, 60.0)
    # wanted = 24 N/m * 0.9 m + integral, given = 69.1 N of all thrusters, wanted - given = 1 s * 6 N/(m s) * 0.9 m
    assert held.x[7] == pytest.approx(69.11 + 5.4 - 21.6, abs=0.01)
    assert wrench(held)[0] == pytest.approx(69.11, abs=0.01)


def test_an_error_beyond_the_reach_counts_as_the_reach():
    far = started(inputs={"position_north": -30.0, "depth": -40.0})
    np.testing.assert_allclose(wrench(far), wrench(started(inputs={"position_north": -0.6, "depth": -0.8})), atol=1e-10)
    assert far["error_north"] == 30.0  # told in full
    far.step(0.0, 10.0)
    np.testing.assert_allclose(wrench(far), wrench(started(inputs={"position_north": -0.6, "depth": -0.8})), atol=1e-10)


def test_a_lost_thruster_is_not_asked_for():
    controller = started(inputs={"available[4]": 0.0, "depth": -1.0, "roll_rate": 0.1})
    assert controller["command[4]"] == 0.0
    assert wrench(controller)[2] == pytest.approx(37.0, rel=0.02)  # heave has priority
