"""Controller of the friction drive: its law sample by sample, decoupling, limits, counts, set points, exact closed loop."""

import math

import numpy as np
import pytest
from cosimo.components.drives.servo_motor import ServoMotor
from cosimo.components.friction_drive.controller import ServoController
from cosimo.tests.support import initialized
from cosimo.tests.systems.drives.closed_forms import wheel_constants
from scipy.linalg import expm

pytestmark = pytest.mark.interpreted

A, RADIUS, SLEEVE = math.pi / 6.0, 0.01, 0.005
LAYOUTS = ("skewed", "skewed_free_rollers", "orthogonal")


def controller(effects=(), inputs=None, **parameters) -> ServoController:
    return initialized(ServoController(effects, parameters), inputs)


def voltages(made) -> list[float]:
    return [made["first_voltage"], made["second_voltage"]]


# -- law ---------------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("layout", "first", "second"), [
    ("skewed", (1.0 / math.cos(A), 1.0 / math.sin(A)), (1.0 / math.cos(A), -1.0 / math.sin(A))),
    ("skewed_free_rollers", (math.cos(A), math.sin(A)), (math.cos(A), -math.sin(A))),
    ("orthogonal", (1.0, 0.0), (0.0, 1.0)),
])  # fmt: skip
def test_errors_become_wheel_rates_by_the_inverse_kinematics(layout, first, second):
    """20 1/s of 1 mm, 15 1/s of 0.1 rad, R = 10 mm; voltages of (0.4446 + 0.4) V.s/rad, less 0.4 for what turns already."""
    made = controller(
        (), {"first_rate": 0.3, "second_rate": -0.2}, layout=layout, set_feed=1e-3, set_rotation=0.1, rotation_gain=15.0
    )
    motion = np.array([20.0 * 1e-3, 15.0 * SLEEVE * 0.1]) / RADIUS
    wanted = np.array([first, second]) @ motion
    assert voltages(made) == pytest.approx(0.8446 * wanted - 0.4 * np.array([0.3, -0.2]), rel=1e-12)
    assert (made["feed_error"], made["rotation_error"]) == (1e-3, 0.1)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_way_of_the_wheels_is_that_of_the_sleeve_without_slip(layout):
    """Wheels turned as the inverse kinematics has it for 3 mm and -0.2 rad: no error is left."""
    ask = controller((), layout=layout, set_feed=3e-3, set_rotation=-0.2, rate_gain=0.0, rate_limit=1e3)
    turned = np.array(voltages(ask)) / (0.4446 * 20.0)
    made = controller(
        (),
        dict(zip(("first_angle", "second_angle"), turned, strict=True)),
        layout=layout,
        feedback="wheels",
        set_feed=3e-3,
        set_rotation=-0.2,
    )
    assert abs(made["feed_error"]) < 1e-17
    assert abs(made["rotation_error"]) < 1e-15
    blind = controller((), {"feed": 1.0, "rotation": 1.0}, layout=layout, feedback="wheels")
    assert voltages(blind) == [0.0, 0.0]


def test_a_limit_of_the_rates_keeps_the_direction_of_motion():
    near = np.array(voltages(controller((), set_feed=1e-3, set_rotation=0.3)))
    far = np.array(voltages(controller((), set_feed=1e-1, set_rotation=30.0, voltage_limit=100.0)))
    assert far / np.abs(far).max() == pytest.approx(near / np.abs(near).max(), rel=1e-12)
    assert np.abs(far).max() == pytest.approx(0.8446 * 20.0, rel=1e-12)


# -- samples -----------------------------------------------------------------------------------------------------------------
def test_voltages_are_held_between_samples_and_samples_see_their_instant():
    made = controller(layout="orthogonal", rate_integral_gain=0.0)
    made.u[:, 4] = 0.0, 1.0, 100.0  # feed = s + 100 s²
    made.step(0.0, 0.9e-3)
    assert voltages(made) == [0.0, 0.0]
    assert made.work["samples"] == 0
    made.u[:, 4] = made.u[0, 4], 1.0 + 200.0 * 0.9e-3, 100.0
    made.step(0.9e-3, 2.6e-3)  # up to 3.5 ms: the last sample is that of 3 ms
    feed = 3e-3 + 100.0 * 9e-6
    assert made.work["samples"] == 3
    assert made["feed_error"] == pytest.approx(-feed, rel=1e-12)
    assert made["first_voltage"] == pytest.approx(-0.8446 * 20.0 * feed / RADIUS, rel=1e-12)


def test_a_run_that_begins_between_two_samples_takes_the_next_one():
    made = controller(layout="orthogonal")
    made.initialize(0.4e-3)
    made.set("feed", 1e-3)
    made.step(0.4e-3, 0.5e-3)
    assert (made["feed_error"], made.work["samples"]) == (0.0, 0)
    made.step(0.9e-3, 0.2e-3)
    assert (made["feed_error"], made.work["samples"]) == (-1e-3, 1)


@pytest.mark.parametrize("rounded", [-1.0, 1.0])
def test_a_run_that_begins_at_a_sample_after_a_day_takes_it_once(rounded):
    """The start is that instant but for the rounding of a time of 1e5 s, more than a millionth of a period."""
    start = 1e5 + rounded * np.spacing(1e5)
    made = controller(layout="orthogonal")
    made.initialize(start)
    made.step(start, 0.5e-3)
    assert made.work["samples"] == 0
    made.step(start + 0.5e-3, 1e-3)
    assert made.work["samples"] == 1


@pytest.mark.known_answers(ServoController="reference")
def test_the_set_point_follows_its_table():
    table = {"reference.time": (1.0, 1.0, 2.0), "reference.feed": (0.0, 0.01, 0.03), "reference.rotation": (0.5, 0.5, -0.5)}
    given = {f"{n}[{k + 1}]": v for n, values in table.items() for k, v in enumerate((*values, 0.0))}
    made = controller(("reference",), set_feed=0.1, **given)
    for time, feed, rotation in ((0.5, 0.1, 0.5), (0.999, 0.1, 0.5), (1.0, 0.11, 0.5), (1.75, 0.125, -0.25), (2.5, 0.13, -0.5)):
        made.initialize(time)
        assert (made["wanted_feed"], made["wanted_rotation"]) == pytest.approx((feed, rotation), rel=1e-12)
    made.set("feed", 0.12)
    made.set("rotation", 0.0)
    made.initialize(1.5)  # no error: what is asked is the slope of the table alone, 0.02 m/s and -1 rad/s, by skewed wheels
    expected = [0.02 / math.cos(A) / RADIUS + k * SLEEVE * -1.0 / math.sin(A) / RADIUS for k in (1.0, -1.0)]
    assert voltages(made) == pytest.approx(0.8446 * np.array(expected), rel=1e-9)


# -- counts ------------------------------------------------------------------------------------------------------------------
def test_counted_rates_sum_up_to_the_counted_angle():
    """A wheel at 0.5 rad/s passes 3.03 counts a sample: rates of 3 and 4 counts, whose mean is the rate, and no drift."""
    made = controller(
        ("quantisation",),
        {"first_rate": 0.5},
        layout="orthogonal",
        feedback="wheels",
        feed_gain=0.0,
        feed_forward=0.0,
        rate_gain=1.0,
        rate_integral_gain=0.0,
    )
    rates = []
    for k in range(1000):
        made.u[:, 0] = 0.5e-3 * k, 0.5, 0.0
        made.step(1e-3 * k, 1e-3)
        rates.append(-made["first_voltage"])
    counts = np.array(rates) * 1e-3 / 1.65e-4
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert set(np.round(counts)) == {3.0, 4.0}
    assert np.sum(counts) == pytest.approx(0.5 / 1.65e-4, abs=1.0)


def test_each_wheel_is_counted_from_the_start_as_if_it_had_turned_before():
    """4 and -6 counts a sample; then the angles jump by 5 and -1 counts within one."""
    count, alone = 1.65e-4, {"layout": "orthogonal", "feed_gain": 0.0, "rotation_gain": 0.0, "feed_forward": 0.0,
                             "rate_gain": 1.0, "rate_integral_gain": 0.0}  # fmt: skip
    made = controller(("quantisation",), {"first_angle": 10.5 * count, "second_angle": -7.5 * count,
                                          "first_rate": 4e3 * count, "second_rate": -6e3 * count}, **alone)  # fmt: skip
    assert voltages(made) == pytest.approx([-4e3 * count, 6e3 * count], rel=1e-12)
    made.set("first_angle", 15.5 * count)
    made.set("second_angle", -8.5 * count)
    made.step(0.0, 1e-3)
    assert voltages(made) == pytest.approx([-5e3 * count, 1e3 * count], rel=1e-12)


@pytest.mark.known_answers(ServoController="quantisation")
def test_a_sleeve_between_two_counts_is_seen_at_the_lower_one():
    made = controller(("quantisation",), {"feed": 2.7e-5, "rotation": -1.2e-3})
    assert (made["feed_error"], made["rotation_error"]) == pytest.approx((-2e-5, 2e-3), rel=1e-12)


# -- integrals ---------------------------------------------------------------------------------------------------------------
def test_integrals_do_not_wind_up_at_the_limits():
    """A wheel that is held fast: the voltage stays at its limit, and what is asked exceeds it by K_i e T, no more."""
    made = controller(layout="orthogonal", set_feed=1.0, feed_integral_gain=50.0)
    made.step(0.0, 2.0)
    assert made["first_voltage"] == 12.0
    excess = 10.0 * 20.0 * 0.02  # K_i times the rate that is limited to 20 rad/s, times T
    assert made.x[3] == pytest.approx(12.0 + excess - 0.8446 * 20.0, rel=1e-6)
    # the motion is limited to R 20 rad/s = 0.2 m/s, and the wanted one exceeds it by K_m e T
    assert made.x[9] == pytest.approx(0.2 + 50.0 * 1.0 * 0.02 - 20.0 * 1.0, rel=1e-6)


def test_each_way_has_its_own_integral():
    """Errors that stay, at 101 samples: K_m e per time each. At the common limit of the rates each gives up in proportion.

    There v (1 - share) = K_m e T for both, with share = 0.2 m/s / v of the feed, whose wheel is at the limit.
    """
    gains = {"layout": "orthogonal", "feed_integral_gain": 50.0, "rotation_integral_gain": 70.0}
    free = controller(set_feed=1e-3, set_rotation=0.1, **gains)
    free.step(0.0, 0.1)
    assert free.x[9:11] == pytest.approx([0.101 * 50.0 * 1e-3, 0.101 * 70.0 * 0.1], rel=1e-12)
    limited = controller(set_feed=1.0, set_rotation=0.1, **gains)
    limited.step(0.0, 2.0)
    feed_rate = 0.2 + 50.0 * 1.0 * 0.02
    turn_rate = 70.0 * 0.1 * 0.02 / (1.0 - 0.2 / feed_rate)
    assert limited.x[9:11] == pytest.approx([feed_rate - 20.0 * 1.0, turn_rate - 20.0 * 0.1], rel=1e-9)


def test_without_gains_there_are_no_integrals():
    made = controller(layout="orthogonal", set_feed=1.0, rate_integral_gain=0.0)
    made.step(0.0, 1.0)
    assert not made.x[3:5].any()
    assert not made.x[9:11].any()


def test_closed_loop_with_a_motor_is_the_exact_sampled_one():
    """Motor without friction and winding: between samples its matrix exponential, at samples the law, in eight numbers."""
    motor = ServoMotor()
    motor.initialize(0.0)
    made = controller(layout="orthogonal", feedback="wheels", set_feed=2e-3, feed_integral_gain=30.0)
    J, B, K = wheel_constants(motor)
    system = np.array([[0.0, 1.0, 0.0], [0.0, -(B + K**2 / 2.3) / J, K / 2.3 / J], [0.0, 0.0, 0.0]])
    over = expm(system * 1e-3)
    angle, rate, inner, outer = 0.0, 0.0, 0.0, 0.0
    for k in range(150):
        error = 2e-3 - RADIUS * angle
        wanted = (20.0 * error + outer) / RADIUS
        voltage = 0.4446 * wanted + 0.4 * (wanted - rate) + inner
        outer, inner = outer + 30e-3 * error, inner + 10e-3 * (wanted - rate)
        assert made["first_voltage"] == pytest.approx(voltage, abs=1e-7)
        motor.set("voltage", made["first_voltage"])
        motor.step(k * 1e-3, 1e-3)
        angle, rate, _ = over @ [angle, rate, voltage]
        assert motor["angle"] == pytest.approx(angle, abs=1e-9)  # RK4 with 0.024 of the time constant
        made.set("first_angle", motor["angle"])
        made.set("first_rate", motor["rate"])
        made.step(k * 1e-3, 1e-3)
    assert abs(angle - 0.2) < 0.02
