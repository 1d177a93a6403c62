"""Hard cases of the gimbal: gimbal lock, vanishing inertia, turning points under friction, stiff nutation, stops, long steps."""

import numpy as np
import pytest
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.tests.support import initialized

pytestmark = pytest.mark.full

GYRO = {
    "frame_inertia": 0.005,
    "cross_inertia": 0.015,
    "inner_inertia": 0.015,
    "axial_inertia": 0.015,
    "axis_orientation": "horizontal",
    "start_inner_angle": 0.0,
}


def gimbal(effects=(), inputs=None, **parameters) -> GimbalBody:
    return initialized(GimbalBody(effects, parameters), inputs)


# -- dry friction --------------------------------------------------------------------------------------------------------------
def shaken(body: GimbalBody, amplitudes, frequencies, duration: float, h: float) -> float:
    """Step under sinusoidal torques, each a parabola in a step; returns the work they did, by Simpson's rule."""
    work = 0.0
    for k in range(round(duration / h)):
        t = k * h
        a, b, c = (amplitudes * np.sin(frequencies * (t + share * h)) for share in (0.0, 0.5, 1.0))
        body.u[0], body.u[1], body.u[2] = a, (-3.0 * a + 4.0 * b - c) / h, 2.0 * (a - 2.0 * b + c) / h**2
        start = body.y[2:4].copy()
        body.step(t, h)
        work += 0.5 * h * (a @ start + c @ body.y[2:4])
    return work


@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_many_turning_points_under_friction(ratio):
    """Two axes shaken around the level of their friction: rests and slips without end, the same ones at coarse substeps."""
    counts, ends, balances = [], [], []
    for substep in (1e-2, 1e-3):
        body = gimbal(
            ("gravity", "stick_friction"), start_inner_angle=0.4, substep=substep, **{"stick_friction.static_ratio": ratio}
        )
        energy = body["mechanical_energy"]
        work = shaken(body, np.array([0.12, 0.1]), np.array([7.0, 17.0]), 20.0, 1e-2)
        counts.append(body.work["events"])
        ends.append(body.x.copy())
        balances.append(work - (body["mechanical_energy"] - energy))
    assert counts[0] == counts[1] > 60
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-5)
    assert min(balances) > 0.0  # friction only takes


def test_a_torque_that_reaches_the_static_level_exactly():
    """At the level it still holds; grown to it in a ramp that meets it at the end of a step, it lets go with the first excess."""
    numbers = {"stick_friction.inner_level": 0.5}  # binary fractions: the torque is the level to the last bit
    body = gimbal(("stick_friction",), {"inner_torque": 0.5}, **numbers)
    body.step(0.0, 10.0)
    assert body["inner_rate"] == 0.0
    assert body["inner_angle"] == 0.5
    body.set("inner_torque", 0.0)
    for k in range(12):
        body.u[1, 1] = 0.0625
        body.step(10.0 + k, 1.0)
        assert body["stick_friction.inner_stuck"] == (1.0 if k < 8 else 0.0)
    # T - T_f = 0.0625 t from the eighth second on: the angle is a cubic, which RK4 integrates exactly
    assert body["inner_angle"] == pytest.approx(0.5 + 0.0625 * 4.0**3 / (6.0 * 0.05), rel=1e-9)


@pytest.mark.parametrize("orientation", ["vertical", "horizontal"])
def test_an_axis_that_bears_just_its_level_does_not_disturb_the_other(orientation):
    """Outer torque of 0.1 N.m, the level to the last bit; the inner axis comes to rest after rate * I / level."""
    body = gimbal(
        ("stick_friction",),
        {"outer_torque": 0.1},
        axis_orientation=orientation,
        start_inner_rate=-0.5,
        **{"stick_friction.outer_level": 0.1, "stick_friction.inner_level": 0.05},
    )
    for k in range(8):
        body.step(0.125 * k, 0.125)
    assert body["outer_rate"] == body["inner_rate"] == body["outer_angle"] == 0.0
    assert body["inner_angle"] == pytest.approx(0.5 - 0.5**2 * 0.05 / (2.0 * 0.05), abs=1e-12)
    assert body.work["events"] == 1


def test_torques_at_the_very_levels_at_random():
    """Steps, ramps and parabolas between the levels of both axes, from rest and from motion: no modes that chase each other."""
    rng = np.random.default_rng(5)
    torques = [0.0, 0.05, -0.05, 0.1, -0.1, 0.2, -0.2]
    for _ in range(20):
        body = gimbal(
            ("stick_friction",),
            axis_orientation=rng.choice(["vertical", "horizontal"]),
            start_outer_rate=rng.choice([0.0, 2.0]),
            start_inner_rate=rng.choice([0.0, -1.0]),
            **{f"stick_friction.{axis}_level": rng.choice([0.05, 0.1]) for axis in ("outer", "inner")},
            **{"stick_friction.static_ratio": rng.choice([1.0, 2.0])},
        )
        for k in range(60):
            begin, end = rng.choice(torques, (2, 2))
            body.u[0], body.u[1] = begin, rng.choice([0.0, 1.0]) * (end - begin) / 0.05
            body.u[2] = rng.choice([0.0, 0.0, 1.0, -1.0], 2)
            body.step(0.05 * k, 0.05)


def test_friction_of_one_axis_alone_leaves_the_other_free():
    body = gimbal(("gravity", "stick_friction"), **{"stick_friction.inner_level": 0.0, "stick_friction.outer_level": 0.3})
    energy = body["mechanical_energy"]
    body.step(0.0, 20.0)
    assert body["outer_angle"] == 0.0
    assert body["mechanical_energy"] == pytest.approx(energy, rel=1e-9)


def test_friction_holds_an_axis_against_the_gyroscopic_torque_of_the_other_up_to_its_level():
    """A turning inner axis and a rotor: h beta' cos beta on the outer axis, 0.1 N.m at the start, below 0.2 and above 0.05."""
    for level, holds in ((0.2, True), (0.05, False)):
        body = gimbal(
            ("rotor", "stick_friction"),
            **GYRO,
            start_inner_rate=0.2,
            **{"stick_friction.outer_level": level, "stick_friction.inner_level": 0.0},
        )
        body.step(0.0, 1.0)
        assert (body["outer_angle"] == 0.0) is holds
        if holds:
            assert body["inner_angle"] == pytest.approx(0.2, rel=1e-12)


# -- stops and steps -------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("h", [1e-3, 0.5])
def test_a_torque_into_a_stop_comes_to_rest_on_it(h):
    body = gimbal(("stops",), {"outer_torque": 0.5, "inner_torque": -0.8}, **{"stops.dissipation": 2.0})
    for k in range(round(40.0 / h)):
        body.step(k * h, h)
    # the stop's law damps in proportion to the depth: an oscillation about T / k dies like 1 / (1 + ...)
    assert body["outer_angle"] == pytest.approx(2.9 + 0.5 / 1000.0, abs=2e-6)
    assert body["inner_angle"] == pytest.approx(-1.3 - 0.8 / 1000.0, abs=2e-6)


def test_a_start_beyond_a_stop_is_pushed_back_and_not_faster_than_its_energy():
    body = gimbal(("stops",), start_inner_angle=1.35)
    energy = body["mechanical_energy"]
    assert energy == pytest.approx(0.5 * 1000.0 * 0.05**2, rel=1e-12)
    body.step(0.0, 0.05)
    assert body["inner_angle"] < 1.3
    assert 0.0 < body["mechanical_energy"] < energy


@pytest.mark.parametrize("effects", [("gravity", "rotor"), ("gravity", "stick_friction"), ("gravity", "lugre_friction")])
def test_the_macro_step_does_not_show(effects):
    """One step of 4 s, or 4000 of a millisecond: the same substeps, so the same motion but for rounding of the time."""
    whole, parts = (gimbal(effects, start_outer_rate=2.0, substep=1e-3) for _ in range(2))
    whole.step(0.0, 4.0)
    for k in range(4000):
        parts.step(k * 1e-3, 1e-3)
    np.testing.assert_allclose(whole.y, parts.y, atol=1e-9)
    assert whole.work["steps"] == parts.work["steps"]


@pytest.mark.parametrize("effect", ["lugre_friction", "stick_friction", "smoothed_friction"])
def test_three_kinds_of_friction_agree_while_sliding(effect):
    """Well above the Stribeck rate and the width: the kinetic level, whatever the law, 0.05 N.m on 0.05 kg.m².

    Bristles that start relaxed take more at first: their dashpot c z, z = level / k, less what the spring lacks until they are
    bent, level / r. Their relaxation r is held to one per substep, 1000 1/s, where it would be 4000.
    """
    parameters = {f"{effect}.static_ratio": 1.0} if effect != "smoothed_friction" else {}
    body = gimbal((effect,), start_inner_rate=1.0, **parameters)
    body.step(0.0, 0.5)
    first = 2.0 * 0.05 / 200.0 - 0.05 / 1000.0 if effect == "lugre_friction" else 0.0
    assert body["inner_rate"] == pytest.approx(1.0 - (0.05 * 0.5 + first) / 0.05, abs=1e-4)
