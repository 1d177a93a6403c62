"""The tether against the catenary, a chain's frequencies, drag across its length, and as derivative identities of its energy."""

import math

import numpy as np
import pytest
from cosimo.components.rov.tether import Tether
from cosimo.tests.support import initialized
from scipy.optimize import brentq

WAYS = ("north", "east", "down")
HEAVY = {"mass_per_length": 0.143, "youngs_modulus": 6.437e9}  # sinks, and hardly stretches
AREA = 0.25 * math.pi * 7.5e-3**2


def started(*effects, end=(0.0, 0.0, 0.0), **parameters) -> Tether:
    tether = Tether(effects, {k.replace("__", "."): v for k, v in parameters.items()})
    put(tether, end)
    return initialized(tether)


def put(tether: Tether, end, velocity=(0.0, 0.0, 0.0)) -> None:
    for way, place, speed in zip(WAYS, end, velocity, strict=True):
        tether[f"position_{way}"], tether[f"velocity_{way}"] = place, speed


def force(tether: Tether) -> np.ndarray:
    """Force on the vehicle, N, (3,)."""
    return np.array([tether[f"force_{way}"] for way in WAYS])


def test_a_hanging_tether_tends_to_the_catenary_with_the_square_of_the_segments():
    """Between two ends at one height: H = w a with L = 2 a sinh(D / 2a), and sag a (cosh(D / 2a) - 1)."""
    D, L, w = 20.0, 35.0, (0.143 - 1000.0 * AREA) * 9.81
    a = brentq(lambda a: 2.0 * a * math.sinh(0.5 * D / a) - L, 1.0, 1e3, xtol=1e-14)
    sag = a * (math.cosh(0.5 * D / a) - 1.0)
    errors = []
    for n in (20, 40, 80):
        tether = started(segments=n, substep=1e-6, **HEAVY | {"youngs_modulus": 1e12})
        # half the weight; 1e-13 of 35 m, as near as the shape is found, is 1e-4 N of a cable as stiff as this
        assert force(tether)[2] == pytest.approx(0.5 * w * L, rel=1e-5)
        errors.append((abs(force(tether)[0] / (-w * a) - 1.0), abs(tether["lowest"] / sag - 1.0)))
    for e in np.array(errors).T:
        assert e[2] < 1e-3
        assert 1.9 < math.log2(e[1] / e[2]) < 2.1


@pytest.mark.parametrize(
    "end",
    [
        (0.0, 0.0, 0.0),
        (-5.0, 12.0, 20.0),
        (13.0, 8.0, -3.0),
        (14.999, 0.0, 0.0),
        (-20.0, 0.0, 10.0),
        (-20.0, 1e-3, -13.0),
        (-20.0, 0.0, 0.0),
        (-20.0, 0.0, 14.0),
        (-19.0, 0.5, 34.0),
        (20.0, 3.0, 5.0),
        (-20.0, 0.0, 40.0),
        (-20.0, 0.0, -40.0),
    ],
)
@pytest.mark.parametrize("mass", [0.043, 0.143])
def test_a_tether_starts_at_rest(end, mass):
    """Slack, nearly straight, stretched, one end above the other or at the same place; lighter and heavier than water."""
    tether = started("internal_damping", end=end, mass_per_length=mass)
    nodes = np.vstack(([-20.0, 0.0, 0.0], tether.x.reshape(2, -1, 3)[0], end))
    stretch = np.linalg.norm(np.diff(nodes, axis=0), axis=1) / 3.5
    assert stretch.max() == pytest.approx(max(1.0, math.dist(end, (-20.0, 0.0, 0.0)) / 35.0), abs=0.05)
    before = tether.x.copy()
    tether.step(0.0, 1.0)
    np.testing.assert_allclose(tether.x, before, atol=1e-8)
    # both ends together carry the weight in water: force on the vehicle, and pull at the fixed end with its half segment
    first = (nodes[1] - nodes[0]) / np.linalg.norm(nodes[1] - nodes[0])
    weight = (mass - 1000.0 * AREA) * 9.81 * 35.0
    pull = force(tether) - tether["anchor_tension"] * -first + (0.0, 0.0, weight / 20.0)
    np.testing.assert_allclose(pull, [0.0, 0.0, weight], atol=1e-6)


def test_a_stretched_tether_pulls_with_its_stiffness():
    tether = started(end=(16.0, 0.0, 0.0), mass_per_length=1000.0 * AREA)
    pull = 6.437e7 * AREA / 35.0 * 1.0
    np.testing.assert_allclose(force(tether), [-pull, 0.0, 0.0], rtol=1e-9, atol=1e-9)
    assert tether["anchor_tension"] == pytest.approx(pull, rel=1e-9)


@pytest.mark.parametrize("mode", [1, 4])
def test_a_taut_tether_swings_along_itself_as_a_chain_does(mode):
    """Frequencies 2 sqrt(k / m) sin(pi j / 2n) of n - 1 masses between n springs and fixed ends."""
    n = 10
    tether = started(end=(20.0, 0.0, 0.0), mass_per_length=1000.0 * AREA, segments=n)
    rest = tether.x.reshape(2, n - 1, 3).copy()
    shape = 1e-3 * np.sin(math.pi * mode * np.arange(1, n) / n)
    tether.x.reshape(2, n - 1, 3)[0, :, 0] += shape
    k, m = 6.437e7 * AREA / 3.5, 1000.0 * AREA * 3.5
    t = 0.7
    tether.step(0.0, t)
    moved = tether.x.reshape(2, n - 1, 3)[0, :, 0] - rest[0, :, 0]
    frequency = 2.0 * math.sqrt(k / m) * math.sin(0.5 * math.pi * mode / n)
    np.testing.assert_allclose(moved, shape * math.cos(frequency * t), atol=1e-7 * shape.max() * 10.0)


@pytest.mark.known_answers(Tether=("drag", "current"))
@pytest.mark.full
def test_a_taut_tether_in_a_cross_flow_carries_its_drag():
    """rho d C L U² / 2 over its length, half at either end, and a bow of q L² / 8 H for a small sag."""
    U = 0.5
    tether = started(
        "internal_damping", "drag", "current", end=(20.0, 0.0, 0.0), mass_per_length=1000.0 * AREA, segments=20, substep=2.5e-4
    )
    tether["current.velocity_east"] = U
    tether.step(0.0, 20.0)
    drag = 0.5 * 1000.0 * 7.5e-3 * 1.2 * U**2  # N/m
    length = 40.0
    stretched = np.linalg.norm(
        np.diff(np.vstack(([-20.0, 0.0, 0.0], tether.x.reshape(2, -1, 3)[0], [20.0, 0.0, 0.0])), axis=0), axis=1
    ).sum()
    # drag is reckoned on the length without tension, 35 m, and falls with the cosine squared of the small angle to the flow
    assert force(tether)[1] == pytest.approx(0.5 * drag * 35.0, rel=2e-3)
    bow = np.abs(tether.x.reshape(2, -1, 3)[0, :, 1]).max()
    q = drag * 35.0 / length
    assert bow == pytest.approx(q * length**2 / (8.0 * -force(tether)[0]), rel=3e-3)
    assert stretched == pytest.approx(length + 8.0 * bow**2 / (3.0 * length), rel=1e-5)


def test_a_tether_towed_straight_has_the_tangential_drag():
    """Sinking along itself at a steady speed: what the vehicle carries is w L less the drag along the cable."""
    v = (0.0, 0.0, 1.0)
    tether = started("drag", end=(-20.0, 0.0, 35.5), mass_per_length=1000.0 * AREA)
    nodes = tether.x.reshape(2, -1, 3)
    nodes[1] = v
    put(tether, (-20.0, 0.0, 35.5), v)
    tether.refresh()
    half = 0.5 * 0.5 * 1000.0 * 7.5e-3 * 0.01 * 3.5
    assert force(tether)[2] == pytest.approx(-tether["tension"] - half, rel=1e-12)


@pytest.mark.parametrize("slack", [True, False])
def test_energy_changes_by_the_work_of_the_vehicle_and_by_nothing_else(slack):
    """At random states: d(energy)/dt is minus the power of the force on the vehicle, where nothing dissipates."""
    rng = np.random.default_rng(5)
    h = 1e-6
    for _ in range(20):
        end, velocity = rng.normal(size=3) * 3.0 + ((-5.0, 0.0, 0.0) if slack else (18.0, 0.0, 0.0)), rng.normal(size=3)
        tether = started(end=end, mass_per_length=0.143)
        tether.x += rng.normal(size=tether.x.size) * 0.01
        energies = []
        power = 0.0
        for shift in (-h, h):  # backwards and forwards in time, for a central difference
            tether_state = tether.save()
            put(tether, end, velocity)
            tether.refresh()
            power = -float(force(tether) @ velocity)
            for way, speed in zip(WAYS, velocity, strict=True):
                tether.u[1, tether.inputs.index(f"position_{way}")] = speed
            tether.step(0.0, shift)
            energies.append(tether.energy())
            tether.restore(tether_state)
        assert (energies[1] - energies[0]) / (2.0 * h) == pytest.approx(power, rel=1e-5, abs=1e-4)


@pytest.mark.known_answers(Tether="internal_damping")
@pytest.mark.full
def test_drag_and_damping_only_take_energy():
    rng = np.random.default_rng(6)
    for _ in range(10):
        tether = started("internal_damping", "drag", end=(14.5, 0.0, 1.0), mass_per_length=0.143)
        tether.x += rng.normal(size=tether.x.size) * 0.02
        last = tether.energy()
        for k in range(20):
            tether.step(0.01 * k, 0.01)
            assert tether.energy() <= last + 1e-9 * abs(last)
            last = tether.energy()


def test_without_dissipation_energy_is_kept():
    tether = started(end=(14.0, 0.0, 0.0), mass_per_length=0.143)
    tether.x.reshape(2, -1, 3)[1, 4] = (0.0, 0.5, -0.5)
    before = tether.energy()
    tether.step(0.0, 10.0)
    # segments go slack and taut again, a kink of the force at which a step errs by its square; the kick brought 0.19 J
    assert tether.energy() == pytest.approx(before, abs=2e-4)
