"""Muscles and tendons of the forearm: activation in closed form, torque and power by moment arms, fibres, programme."""

import math

import numpy as np
import pytest
from cosimo.components.wrist.tendons import COUNT, MUSCLES, ForearmTendons
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

ALL = ("fibres", "force_velocity", "varying_arms")
FCR, FCU, ECRL, ECRB, ECU = range(COUNT)


def tendons(effects=(), excitation=None, parameters=None, **inputs) -> ForearmTendons:
    made = ForearmTendons(effects, parameters)
    for i, value in (excitation or {}).items():
        made.set(f"excitation[{i + 1}]", value)
    for name, value in inputs.items():
        made.set(name, value)
    return initialized(made)


def everything(name, made):
    return np.array([made[f"{name}[{i + 1}]"] for i in range(COUNT)])


def test_activation_rises_and_falls_exponentially():
    """First order, with one time constant up and another down; RK4 with 2 ms of 15 ms is right to (2 / 15)^5 / 120."""
    made = tendons()
    made.set("excitation[1]", 0.8)
    made.step(0.0, 0.03)
    assert made["activation[1]"] == pytest.approx(0.8 * -math.expm1(-0.03 / 0.015), rel=1e-5)
    reached = made["activation[1]"]
    made.set("excitation[1]", 0.0)
    made.step(0.03, 0.1)
    assert made["activation[1]"] == pytest.approx(reached * math.exp(-0.1 / 0.05), rel=1e-6)
    assert everything("activation", made)[1:].tolist() == [0.0] * 4


def test_activation_follows_a_ramp_behind_by_its_time_constant():
    made, h = tendons(), 0.02
    for k in range(20):
        made.u[1, 0] = 1.0
        made.step(k * h, h)
    t = 20 * h
    assert made["activation[1]"] == pytest.approx(t - 0.015 * -math.expm1(-t / 0.015), abs=1e-7)


def test_excitations_outside_0_and_1_count_as_the_ends():
    assert everything("activation", tendons(excitation={FCR: 3.0, ECU: -2.0})).tolist() == [1.0, 0.0, 0.0, 0.0, 0.0]


def test_torques_are_forces_times_moment_arms():
    made = tendons(excitation={FCR: 0.5, ECRL: 0.25, ECU: 1.0})
    forces = np.array([0.5 * 59.7, 0.0, 0.25 * 110.0, 0.0, 117.0])
    np.testing.assert_allclose(everything("force", made), forces, rtol=1e-14)
    flexion, radial = (np.array([made[f"{n}_arm[{i + 1}]"] for i in range(COUNT)]) for n in ("flexion", "radial"))
    assert made["flexion_torque"] == pytest.approx(forces @ flexion, rel=1e-13)
    assert made["deviation_torque"] == pytest.approx(forces @ radial, rel=1e-13)


WAYS = {FCR: (1, 1), FCU: (1, -1), ECRL: (-1, 1), ECRB: (-1, 1), ECU: (-1, -1)}


@pytest.mark.parametrize("muscle", WAYS)
def test_every_muscle_does_what_its_name_says(muscle):
    made = tendons(excitation={muscle: 1.0})
    assert tuple(np.sign([made["flexion_torque"], made["deviation_torque"]])) == WAYS[muscle]


@pytest.mark.parametrize("effects", [(), *((e,) for e in ALL), ALL])
def test_power_is_torque_times_rate_and_force_times_shortening(effects):
    rng = np.random.default_rng(5)
    for _ in range(20):
        values = dict(zip(("flexion", "deviation", "flexion_rate", "deviation_rate"), rng.uniform(-0.8, 0.8, 4), strict=True))
        made = tendons(effects, dict(enumerate(rng.uniform(0.0, 1.0, COUNT))), **values)
        at_the_hand = made["flexion_torque"] * values["flexion_rate"] + made["deviation_torque"] * values["deviation_rate"]
        assert made["power"] == pytest.approx(at_the_hand, rel=1e-12, abs=1e-14)


@pytest.mark.known_answers(ForearmTendons="fibres")
def test_passive_fibres_have_a_potential():
    """Without activation: torque is the negative slope of the energy, and curl-free, by central differences."""
    made, h = tendons(("fibres", "varying_arms"), flexion=0.7, deviation=-0.4), 1e-5
    for name, torque in (("flexion", "flexion_torque"), ("deviation", "deviation_torque")):
        here = made[name]
        ends = []
        for s in (-1.0, 1.0):
            made.set(name, here + s * h)
            ends.append(made.energy())
        made.set(name, here)
        made.refresh()
        assert made[torque] == pytest.approx(-(ends[1] - ends[0]) / (2.0 * h), rel=1e-7)
    assert tendons(("fibres",), flexion=0.5).energy() > 0.0
    assert tendons(("fibres",)).energy() == 0.0
    assert tendons(flexion=0.5).energy() == 0.0


def test_fibres_pull_by_their_length():
    """Active: exp(-strain² / 0.45), either way. Passive: the largest force at 60 %, at 30 % (e² - 1) / (e⁴ - 1) of it."""

    def force(strain, excitation):
        return tendons(("fibres",), {FCR: excitation}, flexion=-strain * 0.0628 / 0.0177)["force[1]"] / 59.7

    half = math.expm1(2.0) / math.expm1(4.0)
    assert force(-0.3, 1.0) == pytest.approx(math.exp(-0.2), rel=1e-12)
    assert force(-0.3, 0.0) == 0.0
    assert force(0.6, 0.0) == pytest.approx(1.0, rel=1e-12)
    assert force(0.3, 0.0) == pytest.approx(half, rel=1e-12)
    assert force(0.3, 0.5) == pytest.approx(0.5 * math.exp(-0.2) + half, rel=1e-12)


def test_stretched_muscles_pull_back():
    flexed = tendons(("fibres",), flexion=1.2)
    assert flexed["flexion_torque"] < 0.0
    assert (everything("force", flexed)[:2] == 0.0).all()  # the flexors are slack
    assert tendons(("fibres",), flexion=-1.2)["flexion_torque"] > 0.0


@pytest.mark.known_answers(ForearmTendons="force_velocity")
def test_hills_hyperbola():
    """(1 - v) / (1 + 4 v), none at the greatest rate; more than isometric when lengthened, up to 1.4."""

    def force(rate):
        return tendons(("force_velocity",), {FCR: 1.0}, flexion_rate=rate / 0.0177)["force[1]"] / 59.7

    fastest = 0.628
    assert force(0.0) == 1.0
    assert force(0.25 * fastest) == pytest.approx(0.75 / 2.0, rel=1e-12)
    assert force(fastest) == pytest.approx(0.0, abs=1e-12)
    assert force(2.0 * fastest) == 0.0
    assert 1.0 < force(-0.1 * fastest) < force(-fastest) < 1.4
    assert force(-1e6) == pytest.approx(1.4, rel=1e-3)
    slope = [(force(s * 1e-7) - 1.0) / (s * 1e-7) for s in (1.0, -1.0)]
    assert slope[0] == pytest.approx(slope[1], rel=1e-4)  # no kink at standstill


@pytest.mark.known_answers(ForearmTendons="varying_arms")
def test_moment_arms_that_vary_are_the_slope_of_the_shortening():
    made = tendons(("varying_arms",), {ECRL: 1.0}, flexion=0.5)
    assert made["flexion_torque"] == pytest.approx(110.0 * (-0.0102 + 0.5 * 3.1e-3), rel=1e-12)


@pytest.mark.known_answers(ForearmTendons="programme")
def test_the_programme_goes_in_straight_lines():
    """Three rows: before, on, between and behind them; the rest of the arrays stays 0."""
    table = {"programme.time[1]": 0.1, "programme.time[2]": 0.2, "programme.time[3]": 0.3,
             "programme.ecu[1]": 0.1, "programme.ecu[2]": 0.5, "programme.ecu[3]": 0.2}  # fmt: skip
    quick = {"rise_time": 1e-3, "fall_time": 1e-3, "substep": 2e-4}
    made = tendons(("programme",), parameters=table | quick)
    assert made["activation[5]"] == 0.1
    for end, value in ((0.09, 0.1), (0.15, 0.3), (0.2, 0.5), (0.25, 0.35), (0.35, 0.2), (1.0, 0.2)):
        made.step(made.t, end - made.t)
        assert made["activation[5]"] == pytest.approx(value, abs=5e-3)  # behind by 1 ms times 4 per s
    assert everything("activation", made)[:4].tolist() == [0.0] * 4
    added = tendons(("programme",), {ECU: 0.3}, table)
    for t, value in ((0.0, 0.1), (0.15, 0.3), (0.5, 0.2)):
        added.initialize(t)
        assert added["activation[5]"] == pytest.approx(0.3 + value)


def test_a_jump_in_the_programme_holds_from_its_time_on():
    table = {"programme.time[2]": 0.1, "programme.time[3]": 0.1, "programme.time[4]": 0.5,
             "programme.fcr[3]": 1.0, "programme.fcr[4]": 1.0}  # fmt: skip
    made = tendons(("programme",), parameters=table)
    made.step(0.0, 0.098)
    assert made["activation[1]"] == 0.0
    made.step(0.098, 0.102)
    assert made["activation[1]"] > 0.99


def test_names_of_the_muscles_are_those_of_the_programme():
    assert [n for n in ForearmTendons.variables if n.startswith("programme.") and n.endswith("[1]")] == [
        f"programme.{n}[1]" for n in ("time", *MUSCLES)
    ]
