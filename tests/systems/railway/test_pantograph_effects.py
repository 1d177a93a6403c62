"""Strips, lift, unevenness, acceleration and actuator of the pantograph, each against its closed form."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.pantograph import Pantograph
from cosimo.components.railway.pantograph_effects import speed_at
from cosimo.components.railway.sines import AMPLITUDE, NUMBER, PHASE, sum_of_sines

pytestmark = pytest.mark.interpreted

ROUNDING = 1e-9  # relative: some thousand operations on numbers of one size


def stepped(pantograph: Pantograph, seconds: float, inputs=lambda t: {}) -> list[dict[str, float]]:
    """Outputs after each ms; inputs(t): values at the start of a step, held."""
    rows = []
    for i in range(round(seconds / 1e-3)):
        for name, value in inputs(i * 1e-3).items():
            pantograph.set(name, value)
        pantograph.step(i * 1e-3, 1e-3)
        rows.append({name: pantograph[name] for name in pantograph.outputs})
    return rows


@pytest.mark.parametrize(
    "more", [(), ("bump_stops",), ("lower_frame", "aerodynamic_uplift", "strip_lift", "actuator", "base_excitation")]
)
def test_start_on_two_strips_is_an_equilibrium(more):
    """Wires of two heights and compliances, friction that loads the front strip: nothing moves."""
    pantograph = Pantograph(["two_strips", "contact_loss", *more], {"two_strips.friction": 0.3})
    given = {"wire_height": 0.03, "wire_compliance": 4e-6, "two_strips.wire_height": 0.031, "two_strips.wire_compliance": 2e-6}
    for name, value in given.items():
        pantograph.set(name, value)
    if "actuator" in more:
        pantograph.set("actuator.command", 30.0)
        pantograph.set("base_excitation.height", -0.1)
    pantograph.initialize(0.0)
    before = pantograph.x.copy()
    stepped(pantograph, 0.05)
    assert np.abs(pantograph.x - before).max() < ROUNDING * np.abs(before).max()


def test_friction_loads_the_front_strip():
    """Moments about the head's pivot: (F1 - F2) d/2 = mu (F1 + F2) e; the sum is what the frame gives."""
    for friction in (0.0, 0.2):
        parameters = {"two_strips.friction": friction, "two_strips.pitch_stiffness": 0.0, "frame_stiffness": 0.0}
        pantograph = Pantograph(["two_strips"], parameters)
        pantograph.initialize(0.0)
        front, rear = pantograph["contact_force"], pantograph["two_strips.contact_force"]
        assert front + rear == pytest.approx(120.0, rel=ROUNDING)
        assert (front - rear) * 0.29 == pytest.approx(friction * 120.0 * 0.05, rel=1e-7, abs=1e-9)


@pytest.mark.known_answers(Pantograph="two_strips")
def test_two_strips_average_the_wire_over_their_distance():
    """A rigid wire's wave meets the strips with a phase w d / v between them: their sum gets the cosine of half of it.

    Exact at every instant, as the head's heave and pitch are separate motions.
    """
    omega, phase = 2.0 * np.pi * 5.0, 1.3

    def total(shift):
        pantograph = Pantograph(["two_strips"])
        pantograph.initialize(0.0)
        rest = pantograph["contact_force"] + pantograph["two_strips.contact_force"]
        rows = stepped(
            pantograph,
            0.2,
            lambda t: {
                "wire_height": 1e-3 * np.sin(omega * t + 0.5 * shift),
                "two_strips.wire_height": 1e-3 * np.sin(omega * t - 0.5 * shift),
            },
        )
        return np.array([r["contact_force"] + r["two_strips.contact_force"] - rest for r in rows])

    together, apart = total(0.0), total(phase)
    assert np.abs(together).max() > 5.0
    assert np.abs(apart - np.cos(0.5 * phase) * together).max() < 1e-7 * np.abs(together).max()


def test_a_strip_that_has_left_the_wire_hangs_on_the_head():
    """A wire out of the rear strip's reach: it carries nothing, the front one all; nothing pulls."""
    pantograph = Pantograph(["two_strips", "contact_loss"], {"two_strips.pitch_stiffness": 3000.0})
    pantograph.initialize(0.0)
    rows = stepped(pantograph, 1.0, lambda t: {"two_strips.wire_height": 0.5})
    assert all(r["two_strips.contact_force"] == 0.0 for r in rows[50:])
    assert min(r["contact_force"] for r in rows) >= 0.0
    assert rows[-1]["two_strips.rear_height"] > rows[-1]["two_strips.front_height"]


@pytest.mark.known_answers(Pantograph="strip_lift")
def test_lift_of_the_strips_adds_to_the_force():
    effects = ["two_strips", "strip_lift"]
    numbers = {"frame_stiffness": 0.0, "speed": 50.0, "two_strips.pitch_stiffness": 0.0}
    pantograph = Pantograph(effects, numbers | {"strip_lift.front": 0.004, "strip_lift.rear": 0.002})
    pantograph.initialize(0.0)
    front, rear = pantograph["contact_force"], pantograph["two_strips.contact_force"]
    assert front + rear == pytest.approx(120.0 + 0.006 * 50.0**2, rel=ROUNDING)
    assert front - rear == pytest.approx(0.002 * 50.0**2, rel=1e-7)  # the head does not pitch: either strip keeps its own lift


@pytest.mark.known_answers(Pantograph="lift_fluctuation")
def test_lift_fluctuates_with_its_standard_deviation():
    """Its energy is exact, its mean 0, and either lift has another history; the same seed gives the same one."""
    pantograph = Pantograph(["aerodynamic_uplift", "lift_fluctuation"], {"lift_fluctuation.intensity": 0.08})
    pantograph.initialize(0.0)
    sines = pantograph.arguments[0].fluctuation
    amplitude, number = sines[AMPLITUDE], sines[NUMBER]
    assert np.sqrt(0.5 * np.sum(amplitude**2)) == pytest.approx(0.08, rel=ROUNDING)
    t = np.arange(0.0, 400.0, 0.02)
    histories = np.array([[np.sum(amplitude * np.cos(number * s + phase)) for s in t] for phase in sines[PHASE:]])
    assert histories.std(axis=1) == pytest.approx(np.full(3, 0.08), rel=0.05)
    # of 40 sines with random phases: a standard deviation of 1 / sqrt(2 * 40)
    assert np.abs(np.corrcoef(histories) - np.eye(3)).max() < 3.0 / np.sqrt(80.0)
    assert sum_of_sines(t[7], 1, sines) == pytest.approx(histories[1, 7], abs=1e-12)
    assert 0.2 <= number.min() / (2.0 * np.pi) < number.max() / (2.0 * np.pi) <= 20.0


@pytest.mark.known_answers(Pantograph="wire_unevenness")
def test_unevenness_is_a_height_of_the_wire():
    """The same heights as an input give the same force, at rest at any place; its energy is exact and lies within the band."""
    for place in (3.0, 47.3):
        parameters = {"start_position": place, "speed": 0.0, "wire_unevenness.deviation": 2e-3}
        uneven = Pantograph(["wire_unevenness", "two_strips"], parameters)
        uneven.initialize(0.0)
        amplitude, number, _, phase = uneven.arguments[0].unevenness
        even = Pantograph(["two_strips"], {"start_position": place, "speed": 0.0})
        for name, x in (("wire_height", place), ("two_strips.wire_height", place - 0.58)):
            even.set(name, float(np.sum(amplitude * np.cos(number * x + phase))))
        even.initialize(0.0)
        for name in ("contact_force", "two_strips.contact_force"):
            assert uneven[name] == pytest.approx(even[name], rel=1e-7)
    assert np.sqrt(0.5 * np.sum(amplitude**2)) == pytest.approx(2e-3, rel=ROUNDING)
    length = 2.0 * np.pi / number
    assert 0.4 <= length.min() < length.max() <= 60.0
    energy = amplitude**2 / np.diff(np.geomspace(1.0 / 60.0, 1.0 / 0.4, 61))
    assert energy[-1] / energy[0] == pytest.approx(2.0 / (1.0 + 150.0**2), rel=0.2)  # (1 + (n L)²) at both ends, bands 8 % wide


@pytest.mark.known_answers(Pantograph="measured_unevenness")
def test_measured_unevenness_is_a_height_of_the_wire():
    """Straight between the rows, level beyond them, at either strip's own place: as the same heights as inputs."""
    table = "position [m],height [m]\n10,0.001\n10.5,0.003\n\n12,-0.002\n"
    x, z = np.array([10.0, 10.5, 12.0]), np.array([1e-3, 3e-3, -2e-3])
    for place in (9.0, 10.0, 10.2, 10.5, 11.3, 12.0, 40.0):
        given = {"start_position": place, "speed": 0.0}
        uneven = Pantograph(["measured_unevenness", "two_strips"], given | {"measured_unevenness.table": table})
        uneven.initialize(0.0)
        even = Pantograph(["two_strips"], given)
        even.set("wire_height", float(np.interp(place, x, z)))
        even.set("two_strips.wire_height", float(np.interp(place - 0.58, x, z)))
        even.initialize(0.0)
        for name in ("contact_force", "two_strips.contact_force"):
            assert uneven[name] == pytest.approx(even[name], rel=1e-9)
    moving = Pantograph(["measured_unevenness"], {"start_position": 9.9, "speed": 50.0, "measured_unevenness.table": table})
    moving.initialize(0.0)
    assert np.ptp([row["contact_force"] for row in stepped(moving, 0.03)]) > 1.0


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("", "a header and rows"),
        ("position [m],height [m]\n0,0\n", "at least two rows"),
        ("position [m],z\n0,0\n", "column 'z'"),
        ("position [m],height [mm]\n0,0\n1,a\n", "'a', expected a number"),
        ("position [m],height [m]\n0,0\n2,0\n1,0\n", "position 1 behind 2"),
        ("position [m],height [m]\n0,0,0\n1,0,0\n", "3 cells"),
        ("position [m],height [m]\n0,0\n1,nan\n", "rows"),
    ],
)
def test_a_table_of_heights_that_cannot_be_used_is_one_message(table, expected):
    with pytest.raises(BadInput, match=expected):
        Pantograph(["measured_unevenness"], {"measured_unevenness.table": table}).initialize(0.0)


@pytest.mark.known_answers(Pantograph="acceleration")
def test_train_accelerates_and_then_keeps_its_speed():
    """x = v0 t + a t²/2 up to the final speed, then straight on; braking to a stop likewise, and it stays there."""
    for speed, rate, final in ((20.0, 4.0, 21.0), (20.0, -10.0, 19.0), (1.0, -5.0, 0.0), (20.0, 0.0, 50.0)):
        parameters = {"speed": speed, "acceleration.rate": rate, "acceleration.final_speed": final, "start_position": 5.0}
        pantograph = Pantograph(["acceleration"], parameters)
        pantograph.initialize(0.0)
        end = (final - speed) / rate if rate else np.inf
        for i, row in enumerate(stepped(pantograph, 0.4)):
            t = (i + 1) * 1e-3
            exact = 5.0 + speed * t + 0.5 * rate * t**2
            if t > end:
                exact = 5.0 + 0.5 * (speed + final) * end + final * (t - end)
            assert row["contact_position"] == pytest.approx(exact, rel=1e-12)
            reached = speed + rate * min(t, end) if rate else speed
            assert speed_at(t, *pantograph.arguments[1:]) == pytest.approx(reached, rel=1e-12)


@pytest.mark.known_answers(Pantograph="actuator")
def test_actuator_follows_its_command_with_a_lag():
    """f = F (1 - exp(-t / tau)), and a command beyond the limit gives the limit."""
    pantograph = Pantograph(["actuator"], {"actuator.limit": 25.0, "frame_stiffness": 0.0, "frame_damping": 500.0})
    pantograph.initialize(0.0)
    assert pantograph["contact_force"] == pytest.approx(120.0)
    rows = stepped(pantograph, 0.1, lambda t: {"actuator.command": 80.0})
    exact = 25.0 * (1.0 - np.exp(-0.1 / 0.05))
    assert rows[-1]["actuator.force"] == pytest.approx(exact, rel=1e-7)
    for name, value in (("actuator.command", -80.0),):
        pantograph.set(name, value)
    pantograph.initialize(0.0)  # starts where the command has been for long
    assert pantograph["actuator.force"] == -25.0
    assert pantograph["contact_force"] == pytest.approx(95.0, rel=ROUNDING)
