"""Pipe robot on rings: the ring's stiffness, coasting, holding, power, a cone, an event-driven reference of other origin."""

import math

import numpy as np
import pytest
from cosimo.components.pipe_robot.rolling import RollingPipeRobot, ring_stiffness, rolling_derivatives
from cosimo.components.pipe_robot.route import PipeRoute
from cosimo.tests.support import initialized
from cosimo.tests.systems.pipe_robot.another_solver import reference
from scipy.integrate import quad

pytestmark = pytest.mark.full

G = 9.81
ON = ("harmonic_force", "tow", "route")
# an inner mass of a millionth, on a spring as weak: the body moves alone
ALONE = {"inner_mass": 1e-6, "stiffness": 2e-3, "damping": 5e-6, "harmonic_force.amplitude": 0.0}
PRESS = 4.0 * 6.7214 * 0.2 / 0.102**3 * 0.004  # N, of two rings on four rollers, with the stiffness of a handbook
MASS, ROLLING = 1.0, 1.0 + 4.0 * 2e-6 / 0.01**2


def started(**parameters) -> RollingPipeRobot:
    return initialized(RollingPipeRobot(ON, {k.replace("__", "."): v for k, v in parameters.items()}))


def test_a_ring_gives_way_as_energy_says():
    """Castigliano for a quarter of a ring: at its free side F / 2 and the moment F R (1/2 - 1/pi), by which it does not turn."""
    moment = 0.5 - 1.0 / math.pi  # over F R
    turn, _ = quad(lambda a: moment - 0.5 * (1.0 - math.cos(a)), 0.0, 0.5 * math.pi)
    assert turn == pytest.approx(0.0, abs=1e-15)
    energy, _ = quad(lambda a: (moment - 0.5 * (1.0 - math.cos(a))) ** 2, 0.0, 0.5 * math.pi)  # of F² R³ / 2 EI, one quarter
    radius, stiffness = 0.102, 0.2
    assert ring_stiffness(started().arguments[1]) == pytest.approx(stiffness / radius**3 / (4.0 * energy), rel=1e-13)


@pytest.mark.parametrize(("v0", "mass", "level"), [(0.5, ROLLING, 0.03 * PRESS), (-0.5, MASS, 0.4 * PRESS)])
def test_coasting_forwards_and_sliding_backwards(v0, mass, level):
    unit = started(start_velocity=v0, **ALONE)
    unit.step(0.0, 1.2 * mass * 0.5 / level)
    assert unit["mode"] == 0.0
    # the inner mass is a millionth of the body; 6.7214 has five digits
    assert unit["position"] == pytest.approx(math.copysign(0.5 * mass * v0 * v0 / level, v0), rel=2e-5)


@pytest.mark.known_answers(RollingPipeRobot="route")
def test_it_holds_on_a_slope_up_to_the_friction_and_rolls_down_forwards():
    limit = math.asin(0.4 * PRESS / G)
    up = started(route__slope=limit - 1e-4, **ALONE)
    up.step(0.0, 5.0)
    assert (up["position"], up["mode"]) == (0.0, 0.0)
    over = started(route__slope=limit + 1e-4, **ALONE)
    over.step(0.0, 0.5)
    assert over["mode"] == -1.0
    down = started(route__slope=-0.2, **ALONE)
    down.step(0.0, 0.5)
    acceleration = (G * math.sin(0.2) - 0.03 * PRESS) / ROLLING
    assert down["velocity"] == pytest.approx(0.5 * acceleration, rel=2e-5)
    assert down["grip"] == pytest.approx(acceleration * (ROLLING - MASS) / (0.4 * PRESS), rel=2e-5)


@pytest.mark.known_answers(RollingPipeRobot="tow")
@pytest.mark.parametrize("mode", [1.0, -1.0, 0.0])
def test_energy_of_a_rolling_robot_grows_by_what_comes_in_less_what_is_lost(mode):
    """As of `PipeRobot`; where the pipe narrows, the rings take up what the body loses."""
    random, d = np.random.default_rng(4), 1e-6
    for _ in range(5):
        unit = started(route__slope=0.2, tow__force=1.5, diameter=0.199, taper=-0.02)
        unit.x[:4] = random.uniform(-1.0, 1.0, 4) * [0.02, 0.5, 0.02, 0.5]
        unit.x[1] = mode * abs(unit.x[1])
        unit.x[4:] = mode, random.uniform(0.0, 6.0)
        unit.refresh()
        dx = np.zeros_like(unit.x)
        rolling_derivatives(0.0, unit.x, unit.u[0], dx, *unit.arguments)
        power = unit["exciter_power"] + unit["tow.force"] * unit["velocity"] + unit["route.weight_power"] - unit["dissipation"]
        x, narrowing, energies = unit.x.copy(), -0.02 * unit["velocity"], []
        for sign in (1.0, -1.0):
            unit.x[:] = x + sign * d * dx
            unit.set("diameter", 0.199 + sign * d * narrowing)
            energies.append(unit.energy())
        assert (energies[0] - energies[1]) / (2.0 * d) == pytest.approx(power, abs=1e-7)


def test_through_a_cone_by_energy():
    """Coasting from one diameter into a smaller one: kinetic energy goes into the rings and into rolling resistance."""
    table = {f"diameter_table[{i + 1}]": d for i, d in enumerate((0.2,) * 3 + (0.199,) * 5)}
    way = PipeRoute(parameters=table | {f"place[{i + 1}]": 0.1 * i for i in range(8)})
    way.initialize(0.0)
    robot = started(start_velocity=0.8, **ALONE)
    h, stiffness, work = 1e-3, 6.7214 * 0.2 / 0.102**3, 0.0
    for k in range(500):
        place = robot["position"]
        way.set("position", place + 0.5 * h * robot["velocity"])
        way.refresh()
        robot.set("diameter", way["diameter"])
        robot.set("taper", way["taper"])
        robot.step(k * h, h)
        work += 0.03 * 4.0 * robot["pressing_force"] * (robot["position"] - place)
    assert robot["position"] > 0.3
    assert robot["mode"] == 1.0
    stored = 0.5 * 2 * stiffness * (0.005**2 - 0.004**2)
    kinetic = 0.5 * ROLLING * (0.8**2 - robot["velocity"] ** 2)
    # inputs are held over a step at its middle: second order, (h v / 0.1 m)² = 2.5e-5
    assert kinetic == pytest.approx(stored + work, rel=1e-4)


@pytest.mark.known_answers(RollingPipeRobot="harmonic_force")
def test_rolling_and_sliding_are_those_of_another_solver():
    wanted, modes = reference(2.0, 20.0, (0.03 * PRESS, 0.4 * PRESS), (ROLLING, MASS))
    unit = started(harmonic_force__amplitude=20.0)
    unit.step(0.0, 2.0)
    assert unit.work["events"] == len(modes) - 1
    np.testing.assert_allclose(unit.y[:4], wanted, atol=1e-5 * 0.9)  # five digits of the handbook's 6.7214, 0.9 m of way


def test_it_starts_on_a_slope_with_its_mass_hanging_still():
    unit = started(route__slope=0.1, harmonic_force__amplitude=0.0)
    stretch = unit["inner_position"]
    assert stretch == pytest.approx(-0.5 * G * math.sin(0.1) / 2000.0, rel=1e-14)
    unit.step(0.0, 0.5)
    assert unit["inner_position"] == pytest.approx(stretch, abs=1e-15)
    assert unit["position"] == 0.0


def test_the_stable_step_is_that_of_both_masses_on_the_spring():
    """Roots of (k + c s) (1 / m1 + 1 / m2) + s², with the body as light as it slides."""
    largest = np.abs(np.roots([1.0, 5.0 * (1.0 + 2.0), 2000.0 * (1.0 + 2.0)])).max()
    assert started().stable_step() == pytest.approx(2.61 / largest, rel=1e-12)
