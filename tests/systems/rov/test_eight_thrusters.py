"""Eight thrusters by the effect `further_thrusters`: hull and controller use the same arrangement, and lose any one of them."""

import numpy as np
import pytest
from cosimo.components.rov.arrangement import EIGHT, eight_arrangement, wrench_matrix
from cosimo.components.rov.controller import RovController
from cosimo.components.rov.hull import RovHull
from scipy.optimize import linprog

pytestmark = pytest.mark.interpreted

MATRIX = wrench_matrix(*eight_arrangement())
NAMES = [*(f"thrust[{i}]" for i in range(1, 7)), "further_thrusters.thrust[1]", "further_thrusters.thrust[2]"]
COMMANDS = [*(f"command[{i}]" for i in range(1, 7)), "further_thrusters.command[1]", "further_thrusters.command[2]"]
AVAILABLE = [*(f"available[{i}]" for i in range(1, 7)), "further_thrusters.available[1]", "further_thrusters.available[2]"]


def accelerated(**thrusts: float) -> np.ndarray:
    """Accelerations of the hull alone, (6,), without anything but thrust."""
    hull = RovHull((*RovHull.presets[EIGHT].effects[-1:], "external"), {**RovHull.presets[EIGHT].parameters, **thrusts})
    hull.initialize(0.0)
    return np.array([hull[f"external.{what}acceleration_{a}"] for what in ("", "angular_") for a in "xyz"])


@pytest.mark.known_answers(RovHull="further_thrusters")
@pytest.mark.parametrize("i", range(8))
def test_eight_thrusts_are_their_columns_of_the_matrix(i):
    hull = RovHull()
    rigid, _ = hull.masses()
    np.testing.assert_allclose(rigid @ accelerated(**{NAMES[i]: 3.0}), 3.0 * MATRIX[:, i], atol=1e-13)


def test_the_arrangement_is_regular_with_six_independent_axes():
    """Singular values of another program, to its digits."""
    values = np.linalg.svd(MATRIX, compute_uv=False)
    np.testing.assert_allclose(values, [2.0, 1.420, 1.419, 0.434, 0.378, 0.239], atol=5e-4)
    assert [np.linalg.matrix_rank(np.delete(MATRIX, i, axis=1)) for i in range(8)] == [6] * 8


def commanded(lost: int | None = None) -> np.ndarray:
    """Commands of the first sample for errors of position and attitude, (8,)."""
    controller = RovController(preset=EIGHT, parameters={"set_north": 0.3, "set_depth": -0.2, "set_yaw": 0.4, "set_roll": 0.1})
    if lost is not None:
        controller.set(AVAILABLE[lost], 0.0)
    controller.initialize(0.0)
    return np.array([controller[n] for n in COMMANDS])


def wanted() -> np.ndarray:
    """Wrench the gains ask for, from the controller's errors."""
    c = RovController(preset=EIGHT, parameters={"set_north": 0.3, "set_depth": -0.2, "set_yaw": 0.4, "set_roll": 0.1})
    c.initialize(0.0)
    gains = [24.0, 34.0, 37.0, 4.0, 4.0, 4.0]
    return np.array(gains) * [c[n] for n in ("error_north", "error_east", "error_down", "error_roll", "error_pitch", "error_yaw")]


@pytest.mark.known_answers(RovController="further_thrusters")
@pytest.mark.parametrize("lost", [None, *range(8)])
def test_the_commands_of_eight_thrusters_give_the_wanted_wrench(lost):
    """With all of them and without any one: eight have two to spare."""
    command = commanded(lost)
    thrust = np.where(command > 0.0, 51.44, 39.90) * command
    np.testing.assert_allclose(MATRIX @ thrust, wanted(), atol=1e-10)
    if lost is not None:
        assert command[lost] == 0.0


def test_a_hull_sees_the_water_at_its_further_thrusters():
    hull = RovHull(("current", "further_thrusters"), {"current.velocity_down": 0.5})
    hull.initialize(0.0)
    speeds = [hull[f"further_thrusters.axial_speed[{i}]"] for i in (1, 2)]
    np.testing.assert_allclose(speeds, [0.5, -0.5], atol=1e-15)  # one turns with the water, one against it


def test_a_controller_of_eight_uses_unequal_limits_to_the_full():
    """Far from its place it gives as much of the wrench as a linear programme allows, more than equal sharing does."""
    c = RovController(preset=EIGHT, parameters={"set_north": -3.0, "set_east": 2.5, "reach": 10.0})
    c.initialize(0.0)
    asked = np.array([24.0, 34.0]) * [c["error_north"], c["error_east"]]
    wrench = np.array([*asked, 0.0, 0.0, 0.0, 0.0])
    limits = [(-39.90, 51.44)] * 8 + [(0.0, 1.0)]
    best = linprog(np.r_[np.zeros(8), -1.0], A_eq=np.c_[MATRIX, -wrench], b_eq=np.zeros(6), bounds=limits).x[-1]
    thrust = np.linalg.pinv(MATRIX) @ wrench
    assert c["scale"] == pytest.approx(best, abs=1e-9)
    assert best > 1.03 * min(51.44 / thrust.max(), -39.90 / thrust.min())
