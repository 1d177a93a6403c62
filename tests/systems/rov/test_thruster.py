"""Thrust from a command: limits, published curves, lags against the matrix exponential, motor and propeller in closed form."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rov.thrust_curve import T200_COMMAND, T200_THRUST, curve_command, curve_thrust
from cosimo.components.rov.thruster import Thruster
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from scipy.linalg import expm

pytestmark = pytest.mark.interpreted

SHEET = {1100: -4.069, 1300: -1.438, 1456: -0.086, 1472: 0.0, 1500: 0.0, 1528: 0.0, 1532: 0.041, 1600: 0.603, 1900: 5.245}
POLYNOMIAL = {1.0: 30.4, 0.5: 16.594, -0.5: -16.594, 0.0: 0.0}  # N, von Benzon's curve evaluated by hand


def started(*effects, command=0.0, **parameters) -> Thruster:
    thruster = Thruster(effects, {k.replace("__", "."): v for k, v in parameters.items()})
    thruster["command"] = command
    return initialized(thruster)


@pytest.mark.parametrize(
    ("command", "thrust"), [(1.0, 51.44), (0.5, 25.72), (0.0, 0.0), (-0.5, -19.95), (-1.0, -39.9), (7.0, 51.44), (-7.0, -39.9)]
)
def test_an_ideal_thruster_gives_its_limits_in_proportion(command, thrust):
    assert started(command=command)["thrust"] == pytest.approx(thrust, rel=1e-14)


@pytest.mark.known_answers(Thruster="static_curve")
@pytest.mark.parametrize(("pulse", "force"), SHEET.items())
def test_the_static_curve_has_the_rows_of_the_sheet(pulse, force):
    assert started("static_curve", command=(pulse - 1500) / 400)["thrust"] == pytest.approx(9.80665 * force, rel=1e-12)


@pytest.mark.known_answers(RovController="inverse_curve")
def test_the_inverse_curve_gives_every_thrust_within_the_limits():
    commands, thrusts = np.array(T200_COMMAND), np.array(T200_THRUST)
    for thrust in np.linspace(-39.9, 51.43, 2001):
        command = curve_command(thrust, commands, thrusts)
        assert curve_thrust(command, commands, thrusts) == pytest.approx(thrust, abs=1e-12)
        assert command == 0.0 or abs(command) >= 28 / 400  # never inside the dead band
    assert curve_command(60.0, commands, thrusts) == 1.0
    assert curve_command(-60.0, commands, thrusts) == -1.0


@pytest.mark.known_answers(Thruster="polynomial_curve")
@pytest.mark.parametrize(("command", "thrust"), POLYNOMIAL.items())
def test_the_published_polynomial(command, thrust):
    assert started("polynomial_curve", command=command)["thrust"] == pytest.approx(thrust, abs=5e-4)


@pytest.mark.known_answers(Thruster="lag")
def test_a_first_order_lag_is_an_exponential():
    thruster = started("lag", lag__time_constant=0.2)
    thruster["command"] = 1.0
    thruster.step(0.0, 0.5)
    # a step of RK4 errs by (d / T)^5 / 120, 2.6e-14 with 1 ms, and there are 500 of them
    assert thruster["thrust"] == pytest.approx(51.44 * (1.0 - math.exp(-2.5)), rel=1e-11)


def third_order(t: float) -> float:
    """Unit step answer of (6136 s + 108700) / (s³ + 89 s² + 9258 s + 108700)."""
    A = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-108700.0, -9258.0, -89.0, 1.0], [0.0, 0.0, 0.0, 0.0]])
    z = expm(A * t) @ np.array([0.0, 0.0, 0.0, 1.0])
    return 108700.0 * z[0] + 6136.0 * z[1]


@pytest.mark.known_answers(Thruster="motor_lag")
def test_the_third_order_lag_is_the_published_transfer_function_to_fourth_order():
    errors = []
    for n in (1, 2):
        thruster = started("polynomial_curve", "motor_lag", substep=1e-3 / n)
        thruster["command"] = 0.5
        thruster.step(0.0, 0.04)
        errors.append(abs(thruster["thrust"] / 16.5939453125 - third_order(0.04)))
    assert errors[1] < 1e-6
    assert 3.8 < orders(errors)[0] < 4.4
    thruster.step(0.04, 3.0)
    assert thruster["thrust"] == pytest.approx(16.5939453125, rel=1e-12)  # the static gain is 1


@pytest.mark.known_answers(Thruster="propeller")
def test_full_voltage_is_the_full_row_of_the_sheet():
    """3533 rpm, 51.44 N, 23.83 A: what the numbers of motor and propeller were fitted to, three digits each."""
    thruster = started("propeller", command=1.0)
    assert thruster["propeller.speed"] == pytest.approx(3533.0 * 2.0 * math.pi / 60.0, rel=1e-3)
    assert thruster["thrust"] == pytest.approx(51.44, rel=1e-3)
    assert thruster["propeller.current"] == pytest.approx(23.83, rel=1e-3)
    assert thruster["propeller.electrical_power"] == pytest.approx(16.0 * 23.83, rel=1e-3)


@pytest.mark.parametrize("advance", [0.0, 1.5, -1.5])
def test_a_propeller_starts_as_riccatis_equation_has_it(advance):
    """J w' = a - b w - c w² from rest, in water that comes on at a constant speed."""
    thruster = Thruster(("propeller",))
    thruster["propeller.advance_speed"] = advance
    thruster.initialize(0.0)
    thruster["command"] = 0.8
    thruster.step(0.0, 0.012)
    k, r, density, d = 0.03165, 0.18, 1000.0, 0.0762
    a, c = 0.8 * 16.0 * k / r, density * d**5 * 0.0764 / (2.0 * math.pi) ** 2
    b = k * k / r + 2e-4 - 0.05 * density * d**4 * advance / (2.0 * math.pi)
    root = math.sqrt(b * b + 4.0 * a * c)
    low, high, rate = (root - b) / (2.0 * c), (root + b) / (2.0 * c), root / 1e-4
    decay = math.exp(-rate * 0.012)
    assert thruster["propeller.speed"] == pytest.approx(low * (1.0 - decay) / (1.0 + low / high * decay), rel=1e-5)
    thruster.step(0.012, 1.0)
    assert thruster["propeller.speed"] == pytest.approx(low, rel=1e-12)


def gained(thruster: Thruster) -> float:
    """Power that stays: from the supply, less ohmic loss, friction and the work on the water, W."""
    w, i = thruster.x
    return thruster["propeller.electrical_power"] - 0.18 * i**2 - 2e-4 * w**2 - thruster["propeller.torque"] * w


def test_energy_is_what_goes_in_less_what_goes_out():
    """d/dt of the rotor's energy at random states: electrical power less ohmic loss, friction and the work on the water."""
    rng, h = np.random.default_rng(3), 1e-7
    thruster = started("propeller", "inductance")
    for _ in range(50):
        thruster.x[:] = rng.normal(size=2) * (300.0, 20.0)
        thruster["command"], thruster["propeller.advance_speed"] = rng.uniform(-1.0, 1.0), rng.normal()
        thruster.refresh()
        state, before, rise = thruster.save(), thruster.energy(), 0.5 * gained(thruster)
        thruster.step(0.0, h)
        rise += 0.5 * gained(thruster)
        # over 0.1 us the trapezoidal mean errs by (2 h R / L)² / 12 of up to some kW, 1e-8 of it
        assert (thruster.energy() - before) / h == pytest.approx(rise, abs=1e-4)
        thruster.restore(state)


def test_a_propeller_takes_more_power_than_it_gives():
    """In all four quadrants of speed of rotation and advance speed, and so far that it would drive itself."""
    thruster = started("propeller")
    for speed in np.linspace(-500.0, 500.0, 41):
        for advance in np.linspace(-6.0, 6.0, 41):
            thruster.x[0], thruster["propeller.advance_speed"] = speed, advance
            thruster.refresh()
            assert thruster["propeller.torque"] * speed - thruster["thrust"] * advance >= 0.0


@pytest.mark.known_answers(Thruster="inductance")
def test_a_small_inductance_changes_little():
    """A hundredth of the rotor's time constant in the current shows by about that much in the run-up."""
    runs = []
    for effects, more in ((("propeller",), {}), (("propeller", "inductance"), {"inductance__inductance": 2e-6, "substep": 2e-5})):
        thruster = started(*effects, **more)
        thruster["command"] = 0.8
        thruster.step(0.0, 0.01)
        runs.append(thruster["thrust"])
    assert runs[1] == pytest.approx(runs[0], rel=0.01)


def test_an_internal_step_of_what_integrates_nothing_is_refused():
    with pytest.raises(BadInput, match=r"substep = 0.002.*nothing is integrated without lag, motor_lag or propeller"):
        started("static_curve", substep=2e-3)
    assert started("static_curve", "lag", substep=2e-3).get("substep") == 2e-3
