"""The inertial converter: cycle averages, engagement angles, energy, order, modes."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.wind_pump.converter import FREE, MODE, RATE, SPEED, VELOCITY, InertialConverter, converter_derivatives
from cosimo.components.wind_pump.driven_shaft import STANDING, TURNING
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate

pytestmark = pytest.mark.interpreted
# the example of the cycle averages: m = 4 kg, m_y = 0.05 kg, a = 2, b = 1, r = 30 mm, rho = 50 mm
EXAMPLE = {
    "gear_ratio": 1.0,
    "lever_mass": 4.0,
    "slider_mass": 0.05,
    "crank_radius": 0.03,
    "lever_ratio": 1.0,
    "clutch_arm": 0.05,
}
SHAKE = 4.0 * 2.0 * 0.03  # m a b r
K1 = 2.0 / math.pi * 0.05 * SHAKE
K2 = 2.0 / math.pi * 0.05**2 * 4.05
FASTEST = SHAKE / (4.05 * 0.05)  # w2 / w1 at which the clutches no longer engage
HEAVY = {"crank_inertia": 1e6, "driven_inertia": 1e6, "shaft_stiffness": 1e-3, "shaft_damping": 0.0, "substep": 1e-3}


def started(effects=(), turbine=20.0, load=0.0, **parameters) -> InertialConverter:
    return initialized(InertialConverter(effects, {**EXAMPLE, **parameters}), {"turbine_speed": turbine, "load_torque": load})


def mean_torques(crank: float, speed: float, revolutions: int = 10, effects=(), **parameters) -> tuple[float, float, int]:
    """Mean torque on the driven shaft and on the crank, at speeds that flywheels hold, and the events a revolution."""
    converter = started(effects, crank, start_speed=speed, **{**HEAVY, **parameters})
    period = 2.0 * math.pi / crank
    converter.step(0.0, 2.0 * period)  # the start: the lever begins at rest
    speeds, events = converter.x[[RATE, SPEED]], converter.work["events"]
    converter.step(2.0 * period, revolutions * period)
    changes = (converter.x[[RATE, SPEED]] - speeds) / (revolutions * period) * converter["crank_inertia"]
    return float(changes[1]), -float(changes[0]), (converter.work["events"] - events) // revolutions


@pytest.mark.full
@pytest.mark.parametrize("crank", [5.0, 20.0])
@pytest.mark.parametrize("share", [0.01, 0.2, 0.5, 0.8, 0.97])
def test_the_cycle_average_is_the_closed_form(crank, share):
    """T2 = k1 w1² - k2 w1 w2 from near stall to near the largest speed, and T1 w1 = T2 w2: nothing is lost.

    The flywheels of 1e6 kg m² hold the speeds to 1e-6; the rest of the tolerance is what a share of the stall torque makes of it.
    """
    speed = share * FASTEST * crank
    driving, braking, events = mean_torques(crank, speed)
    expected = K1 * crank**2 - K2 * crank * speed
    assert driving == pytest.approx(expected, abs=2e-6 * K1 * crank**2)
    assert braking * crank == pytest.approx(driving * speed, abs=2e-6 * K1 * crank**3)
    assert events == 4  # each clutch engages and lets go


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_lever_flies_free_up_to_the_angle_of_the_closed_form(side):
    """Each clutch lets go where the crank's angle is 0 or pi, and the other engages at cos phi = ± (1 - 2 w2 / w2max)."""
    crank, share = 20.0, 0.6
    converter = started((), crank, start_speed=share * FASTEST * crank, **HEAVY)
    engages = math.acos(1.0 - 2.0 * share) + (0.0 if side > 0.0 else math.pi)
    lets_go = math.pi if side > 0.0 else 2.0 * math.pi
    for angle, before, after in ((engages, 0.0, -side), (lets_go, -side, 0.0)):
        for offset, engaged in ((-1e-5, before), (1e-5, after)):
            at = (4.0 * math.pi + angle + offset) / crank
            converter.step(converter.t, at - converter.t)
            assert converter["engaged"] == engaged


def test_above_the_largest_speed_the_lever_flies_for_ever():
    driving, braking, events = mean_torques(20.0, 1.001 * FASTEST * 20.0)
    assert (driving, events) == (0.0, 0)
    assert abs(braking) < 1e-3  # a lever that is carried to and fro takes no power in the mean


@pytest.mark.full
def test_without_load_the_shaft_approaches_the_largest_speed():
    converter = started(driven_inertia=0.02, crank_inertia=1e3)
    converter.step(0.0, 60.0)
    assert converter["speed"] == pytest.approx(20.0 * FASTEST, rel=2e-3)
    assert round(20.0 * FASTEST, 4) == 23.7037  # the printed number


def test_the_standing_shaft_gets_the_stall_torque():
    """rho |F| = rho m a b r w1² |sin phi|, whose mean over a revolution is k1 w1²; nothing moves but the crank."""
    converter = started(load=10.0, **HEAVY)
    torques = []
    for k in range(400):
        converter.step(k * math.pi / 4000.0, math.pi / 4000.0)
        torques.append(converter["driving_torque"])
        expected = 0.05 * SHAKE * 400.0 * abs(math.sin(converter["crank_angle"]))
        assert torques[-1] == pytest.approx(expected, abs=1e-5)
    assert np.mean(torques) == pytest.approx(K1 * 400.0, rel=1e-4)  # sum for an integral of |sin|, 400 points
    assert converter["speed"] == converter["slider_velocity"] == 0.0
    assert converter.work["events"] == 0


@pytest.mark.parametrize("effects", [(), ("mesh_friction",), ("compliant_clutches",)])
def test_energy_changes_by_the_power_at_the_ports_and_the_losses(effects):
    """d(energy)/dt = T_t w_t - T_load w - dissipation at random states in every mode."""
    rng = np.random.default_rng(5)
    converter = InertialConverter(effects)
    modes = (STANDING, TURNING) if "compliant_clutches" in effects else (STANDING, 1.0, -1.0, FREE)
    for k in range(60):
        converter.set("turbine_speed", rng.normal(3.0, 3.0))
        converter.set("load_torque", rng.normal(10.0, 5.0))
        converter.initialize(0.0)
        mode = modes[k % len(modes)]
        speed = 0.0 if mode == STANDING else rng.uniform(0.1, 5.0)
        velocity = 0.05 * speed * (mode if mode in (1.0, -1.0) else rng.uniform(-1.0, 1.0))
        if "compliant_clutches" in effects:
            velocity = 0.05 * (speed + 0.02) * rng.normal()
        angle = rng.uniform(0.0, 7.0)
        converter.x[:] = [0.01 * rng.normal(), angle, 20.0 * rng.normal(), 0.01 * rng.normal(), velocity, speed, mode]
        converter.refresh()
        step = 1e-6 / max(1.0, np.abs(energy_rate(converter, converter_derivatives)[1]).max())
        rate, _ = energy_rate(converter, converter_derivatives, step)
        y = converter
        power = y["turbine_torque"] * y["turbine_speed"] - y["load_torque"] * y["speed"] - y["dissipation"]
        scale = abs(y["turbine_torque"] * y["turbine_speed"]) + y["dissipation"] + 1.0
        # cancellation: 1e-16 of the energy over the step
        assert rate == pytest.approx(power, abs=1e-7 * scale + 1e-15 * converter.energy() / step)


@pytest.mark.full
@pytest.mark.parametrize(("effects", "substep"), [((), 1e-3), (("compliant_clutches",), 1e-5)])
def test_energy_over_whole_periods(effects, substep):
    """What goes in at the turbine comes out at the load, as motion or as loss; powers by trapezoids at 1/1000 of a period."""
    converter = started(effects, load=1.0, **({"compliant_clutches.substep": substep} if effects else {"substep": substep}))
    period, samples, revolutions = 2.0 * math.pi / 20.0, 1000, 10
    h = period / samples
    before, powers = converter.energy(), []
    for k in range(revolutions * samples + 1):
        powers.append((converter["turbine_torque"] * 20.0, converter["speed"] * 1.0, converter["dissipation"]))
        if k < revolutions * samples:
            converter.step(k * h, h)
    given, taken, lost = (float(np.trapezoid(p, dx=h)) for p in zip(*powers, strict=True))
    assert given - taken - lost == pytest.approx(converter.energy() - before, abs=2e-4 * given)
    assert lost > 0.0


def test_order_four_through_events():
    """Speeds after four revolutions with 15 events, against a substep of a sixth of the shortest (1/1296 of its error)."""
    end = 8.0 * math.pi / 20.0

    def speed(n: int) -> np.ndarray:
        converter = started(load=0.5, substep=end / n, crank_inertia=1.0, shaft_stiffness=2e3)
        converter.step(0.0, end)
        assert converter.work["events"] > 10
        return converter.x[[RATE, SPEED, VELOCITY]]

    exact, steps = speed(16000), np.unique(np.geomspace(960, 2715, 8).astype(int))
    errors = [np.abs(speed(n) - exact).max() for n in steps]
    assert slope(1.0 / steps, errors) == pytest.approx(4.0, abs=0.25)


def test_engaged_parts_move_as_one():
    """|y'| = rho w while a clutch drives, |y'| < rho w while none does, to the last digits; both occur."""
    converter = started(load=1.0)
    driving = 0
    for k in range(2000):
        converter.step(k * 2e-3, 2e-3)
        distance = 0.05 * converter["speed"] - abs(converter["slider_velocity"])
        if converter.x[MODE] == FREE:
            assert distance > 0.0
        else:
            assert abs(distance) < 1e-15
            assert converter["driving_torque"] >= 0.0
            driving += 1
    assert 200 < driving < 1800


@pytest.mark.known_answers(InertialConverter="compliant_clutches")
@pytest.mark.parametrize("damping", [10.0, 20.0, 40.0])
def test_slipping_clutches_lose_torque_in_the_second_order_of_their_delay(damping):
    """T2 falls by k1 w1² (w1 tau)² / 2 with tau = rho² (m b² + m_y) / c: a clutch lets go late by the angle w1 tau.

    The next order of w1 tau is 2e-2 at most; the rest is rounding of the flywheels' increments.
    """
    inertia = {"crank_inertia": 1e5, "driven_inertia": 1e5}
    slipping = inertia | {"compliant_clutches.damping": damping, "compliant_clutches.substep": 1e-2 / damping}
    miss = mean_torques(20.0, 10.0, 4, **inertia)[0] - mean_torques(20.0, 10.0, 4, ("compliant_clutches",), **slipping)[0]
    delay = 0.05**2 * 4.05 / damping
    assert miss == pytest.approx(0.5 * K1 * 400.0 * (20.0 * delay) ** 2, rel=0.02)


@pytest.mark.known_answers(InertialConverter="mesh_friction")
@pytest.mark.full
def test_gear_friction_takes_its_share_of_the_torque():
    """3 % of the torque that is passed on, and nothing else changes."""
    ideal, lossy = started(load=1.0), started(("mesh_friction",), load=1.0)
    for converter in (ideal, lossy):
        converter.step(0.0, 1.234)
    assert lossy["speed"] == ideal["speed"] > 0.0
    assert lossy["turbine_torque"] - ideal["turbine_torque"] == pytest.approx(0.03 * abs(ideal["turbine_torque"]), rel=1e-12)
    assert lossy["dissipation"] - ideal["dissipation"] == pytest.approx(0.6 * abs(ideal["turbine_torque"]), rel=1e-12)


def turning(effects=(), turbine=3.0, load=0.0, **parameters) -> InertialConverter:
    return initialized(InertialConverter(effects, parameters), {"turbine_speed": turbine, "load_torque": load})


def per_work(converter: InertialConverter, duration: float) -> int:
    """Derivative calls a second of simulated time."""
    converter.step(0.0, duration)
    return round(converter.work["derivative_calls"] / duration)


@pytest.mark.full
def test_what_stiff_clutches_cost():
    """Slipping clutches ask for substeps as short as their relaxation: 80 times as many as rigid ones, for the same speed."""
    rigid, slipping = turning(load=5.0), turning(["compliant_clutches"], load=5.0)
    assert per_work(slipping, 20.0) > 50 * per_work(rigid, 20.0)
    # the mean torque differs in the second order of the delay, 25 us at 18 rad/s; phases within a revolution shift a little
    assert slipping["speed"] == pytest.approx(rigid["speed"], rel=1e-3)
    stiffer = turning(["compliant_clutches"], **{"compliant_clutches.damping": 1e3})
    assert stiffer.stable_step() < 2e-4
    with pytest.raises(BadInput, match="limit of RK4"):
        turning(["compliant_clutches"], **{"compliant_clutches.damping": 1e5})


@pytest.mark.full
@pytest.mark.parametrize("effects", [(), ("compliant_clutches",)])
def test_below_the_peak_a_load_is_moved_twice_a_revolution(effects):
    """The peak is rho m a b r w1² = 32 N.m; below it, the shaft turns for a while twice a revolution, and stands in between."""
    peak = 0.05 * 20.0 * 2.0 * 0.05 * 18.0**2
    weaker = turning(effects, load=0.9 * peak)
    speeds = []
    for k in range(200):
        weaker.step(0.01 * k, 0.01)
        speeds.append(weaker["speed"])
    assert min(speeds) == 0.0 < max(speeds)
    assert 0.1 < np.mean(np.array(speeds) == 0.0) < 0.9


@pytest.mark.full
def test_a_gust_and_a_load_that_jumps():
    """Turbine from 2 to 8 rad/s in 0.1 s, loads that come and go at every macro step: finite, never backwards, parts engaged."""
    rng = np.random.default_rng(11)
    converter = turning(turbine=2.0, load=10.0)
    for k in range(400):
        if k == 100:
            converter.u[1, 0] = 60.0
        converter.step(0.1 * k, 0.1)
        converter.set("load_torque", rng.choice([0.0, 1e-6, 10.0, 100.0]))
        assert converter["speed"] >= 0.0
        assert abs(converter["slider_velocity"]) <= 0.05 * converter["speed"] + 1e-14
    assert converter["turbine_speed"] == pytest.approx(8.0)


@pytest.mark.full
def test_random_converters_under_random_jumps():
    """Masses, arms and inertias over decades: no state that is not finite, no modes that chase each other."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        ranges = {
            "lever_mass": (-3, 2),
            "crank_radius": (-2, -1),
            "lever_ratio": (-0.7, 0.7),
            "clutch_arm": (-2, -0.5),
            "driven_inertia": (-2, 1),
            "crank_inertia": (-0.5, 1),
        }
        parameters = {n: 10.0 ** rng.uniform(*r) for n, r in ranges.items()}
        converter = turning(turbine=rng.uniform(-5.0, 5.0), slider_mass=rng.choice([0.0, 0.1]),
                            start_speed=rng.choice([0.0, 4.0]), **parameters)  # fmt: skip
        for k in range(50):
            converter.set("load_torque", rng.choice([0.0, -0.1, 10.0 ** rng.uniform(-3.0, 2.0)]))
            converter.u[1] = rng.normal(size=2)
            converter.step(0.05 * k, 0.05)
            assert converter["speed"] >= 0.0
