"""Four-bar linkage: extremes, loop closure, ratio by two formulas and by differences, virtual work, effects."""

import math

import numpy as np
import pytest
from cosimo.components.wrist import linkage
from cosimo.components.wrist.four_bar import FourBar
from cosimo.tests.support import initialized
from cosimo.tests.systems.wrist.linkage_limits import crank_limits, rocker_extremes, transmission_extremes

pytestmark = pytest.mark.interpreted

CRANK_ROCKER = (0.020, 0.050, 0.040, 0.055)
NAMES = ("crank", "coupler", "rocker", "ground")
LINKAGES = {
    "crank-rocker": CRANK_ROCKER,
    "double crank": (0.050, 0.045, 0.040, 0.020),
    "rocker-crank": (0.040, 0.050, 0.020, 0.055),
    "double rocker": (0.050, 0.020, 0.045, 0.055),
    "triple rocker": (0.050, 0.030, 0.045, 0.030),
}


def four_bar(angle=0.5 * math.pi, rate=0.0, load=0.0, lengths=CRANK_ROCKER, effects=(), **parameters) -> FourBar:
    return initialized(
        FourBar(effects, dict(zip(NAMES, lengths, strict=True)) | parameters),
        {"input_angle": angle, "input_rate": rate, "load_torque": load},
    )


def angles(lengths, count=60):
    """Crank angles that the linkage reaches, away from its toggles."""
    limits = crank_limits(*lengths)
    low, high = (0.0, 2.0 * math.pi) if limits is None else limits
    return low + (high - low) * (np.arange(count) + 0.5) / count


def all_of(lengths, name, **parameters):
    return np.array([four_bar(a, lengths=lengths, **parameters)[name] for a in angles(lengths)])


def test_rocker_turns_back_where_crank_and_coupler_are_in_line():
    """Law of cosines: 32.1572 and 93.5833 degrees between rocker and ground; the unit counts from the ground's direction."""
    closed = np.degrees(rocker_extremes(*CRANK_ROCKER))
    np.testing.assert_allclose(closed, [32.1572, 93.5833], atol=5e-5)

    def reached(angles):
        return 180.0 - np.degrees([four_bar(a)["output_angle"] for a in angles])

    turn = np.linspace(0.0, 2.0 * math.pi, 401)
    for extreme, expected in ((np.argmin, closed[0]), (np.argmax, closed[1])):
        near = turn[extreme(reached(turn))]
        found = reached(np.linspace(near - turn[1], near + turn[1], 101))  # parabola, (2 pi / 20000)² / 8
        assert found[extreme(found)] == pytest.approx(expected, abs=2e-6)
    crank = math.acos((0.070**2 + 0.055**2 - 0.040**2) / (2.0 * 0.070 * 0.055))  # stretched
    assert abs(four_bar(crank)["ratio"]) < 1e-14


def test_transmission_angle_is_extreme_with_the_crank_along_the_ground():
    closed = np.degrees(transmission_extremes(*CRANK_ROCKER))
    np.testing.assert_allclose(closed, [44.0486, 112.4111], atol=5e-5)
    for angle, expected in zip((0.0, math.pi), closed, strict=True):
        assert math.degrees(four_bar(angle)["transmission_angle"]) == pytest.approx(expected, abs=1e-10)
    assert all(closed[0] <= np.degrees(v) <= closed[1] for v in all_of(CRANK_ROCKER, "transmission_angle"))


@pytest.mark.parametrize("assembly", ["open", "crossed"])
@pytest.mark.parametrize("name", LINKAGES)
def test_the_loop_closes(name, assembly):
    """Freudenstein's equation and the coupler's length, in both assemblies, to rounding."""
    a, b, c, d = lengths = LINKAGES[name]
    assert linkage.kind(*lengths) == name
    for angle in angles(lengths):
        made = four_bar(angle, lengths=lengths, assembly=assembly)
        out = made["output_angle"]
        k3 = (a * a - b * b + c * c + d * d) / (2.0 * a * c)
        assert d / a * math.cos(out) - d / c * math.cos(angle) + k3 == pytest.approx(math.cos(angle - out), abs=1e-13)
        coupler = d + c * np.exp(1j * out) - a * np.exp(1j * angle)
        assert abs(coupler) == pytest.approx(b, rel=1e-13)
        assert np.exp(1j * made["coupler_angle"]) == pytest.approx(coupler / b, abs=1e-12)
        side = (coupler * np.conj(a * np.exp(1j * angle) - d)).imag  # the coupler's tip against the diagonal
        assert np.sign(side) == (-1.0 if assembly == "open" else 1.0)


@pytest.mark.parametrize("name", LINKAGES)
def test_ratio_by_the_sines_and_by_differences(name):
    a, _, c, _ = lengths = LINKAGES[name]
    h = 1e-6
    for angle in angles(lengths):
        made = four_bar(angle, lengths=lengths)
        sines = a * math.sin(made["coupler_angle"] - angle) / (c * math.sin(made["coupler_angle"] - made["output_angle"]))
        assert made["ratio"] == pytest.approx(sines, rel=1e-9, abs=1e-12)
        ends = [four_bar(angle + s * h, lengths=lengths)["output_angle"] for s in (-1.0, 1.0)]
        assert made["ratio"] == pytest.approx((ends[1] - ends[0]) / (2.0 * h), rel=1e-6, abs=1e-8)


@pytest.mark.known_answers(FourBar="pin_damping")
@pytest.mark.parametrize("name", LINKAGES)
def test_virtual_work(name):
    """Lossless: torque in times rate in is torque out times rate out; with pins the difference is what they lose."""
    rng = np.random.default_rng(3)
    lengths = LINKAGES[name]
    for angle in angles(lengths, 20):
        rate, load = rng.normal(size=2)
        plain = four_bar(angle, rate, load, lengths)
        assert plain["input_torque"] * rate == pytest.approx(load * plain["output_rate"], rel=1e-13)
        lossy = four_bar(angle, rate, load, lengths, ("pin_damping",))
        lost = lossy["pin_damping.dissipation"]
        assert lost > 0.0
        assert lossy["input_torque"] * rate == pytest.approx(load * lossy["output_rate"] + lost, rel=1e-12)


def test_pins_lose_by_the_rates_of_their_links_against_each_other():
    """Rates of coupler and rocker by differences of their angles; four pins, two of them in the ground."""
    h, rate = 1e-6, 3.0
    for angle in (0.4, 1.3, 2.6, 4.4):
        ends = [four_bar(angle + s * h) for s in (-1.0, 1.0)]
        coupler, rocker = (rate * (ends[1][n] - ends[0][n]) / (2.0 * h) for n in ("coupler_angle", "output_angle"))
        lost = 1e-3 * (rate**2 + (coupler - rate) ** 2 + (rocker - coupler) ** 2 + rocker**2)
        assert four_bar(angle, rate, effects=("pin_damping",))["pin_damping.dissipation"] == pytest.approx(lost, rel=1e-7)


@pytest.mark.known_answers(FourBar="rocker_spring")
def test_the_spring_stores_what_goes_into_it():
    """Work of the input over a quarter of a turn, by Gauss's rule, is the spring's energy."""
    ends = [four_bar(a, effects=("rocker_spring",)).energy() for a in (0.4, 2.0)]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    torque = [four_bar(1.2 + 0.8 * s, effects=("rocker_spring",))["input_torque"] for s in nodes]
    assert 0.8 * weights @ torque == pytest.approx(ends[1] - ends[0], rel=1e-12)
    assert four_bar().energy() == 0.0


@pytest.mark.known_answers(FourBar="coupler_point")
def test_the_point_of_the_coupler_moves_as_its_velocity_says():
    on = ("coupler_point",)
    made, h = four_bar(1.0, 2.0, effects=on), 1e-6
    ahead, behind = (four_bar(1.0 + 2.0 * s * h, 2.0, effects=on) for s in (1.0, -1.0))
    for axis in "xy":
        slope = (ahead[f"coupler_point.{axis}"] - behind[f"coupler_point.{axis}"]) / (2.0 * h)
        assert made[f"coupler_point.velocity_{axis}"] == pytest.approx(slope, rel=1e-6)
    tip = 0.020 * np.exp(1j)
    place = complex(made["coupler_point.x"], made["coupler_point.y"])
    assert abs(place - tip) == pytest.approx(math.hypot(0.025, 0.02), rel=1e-14)
    ends = {"coupler_point.along": 0.05, "coupler_point.across": 0.0}
    tip = four_bar(1.0, effects=on, **ends)
    assert tip["coupler_point.y"] == pytest.approx(0.040 * math.sin(tip["output_angle"]), rel=1e-13)


def test_two_in_series_multiply_their_ratios():
    """The two gears of the wrist: the rocker of the first is the crank of the second; loads go the way back."""
    first = four_bar(1.1, 0.7)
    second = four_bar(first["output_angle"], first["output_rate"], 2.0)
    first.set("load_torque", second["input_torque"])
    first.refresh()
    assert second["output_rate"] == pytest.approx(first["ratio"] * second["ratio"] * 0.7, rel=1e-14)
    assert first["input_torque"] * 0.7 == pytest.approx(2.0 * second["output_rate"], rel=1e-13)


def test_a_crank_that_turns_on_has_a_rocker_angle_that_goes_on():
    """A double crank: the output goes round with the input, without a jump; a crank-rocker comes back."""
    turns = 3.0 * 2.0 * math.pi
    lengths = LINKAGES["double crank"]
    one, later = four_bar(0.3, lengths=lengths)["output_angle"], four_bar(0.3 + turns, lengths=lengths)["output_angle"]
    assert later - one == pytest.approx(turns, abs=1e-12)
    assert four_bar(0.3 + turns)["output_angle"] == pytest.approx(four_bar(0.3)["output_angle"], abs=1e-13)


def test_a_rocker_that_drives_has_the_inverse_ratio():
    forward = four_bar(0.8)
    mirrored = (CRANK_ROCKER[2], CRANK_ROCKER[1], CRANK_ROCKER[0], CRANK_ROCKER[3])
    back = four_bar(math.pi - forward["output_angle"], lengths=mirrored, assembly="crossed")
    if abs(math.pi - back["output_angle"] - 0.8) > 1e-9:
        back = four_bar(math.pi - forward["output_angle"], lengths=mirrored)
    assert math.pi - back["output_angle"] == pytest.approx(0.8, abs=1e-12)
    assert back["ratio"] * forward["ratio"] == pytest.approx(1.0, rel=1e-11)
