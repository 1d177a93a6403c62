"""A thruster: thrust from a command, as an ideal force, from a static curve, with a lag, or from motor and propeller."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.spectrum import fastest_rate, spectral_radius, step_within
from ..core.variables import count, input_, output, parameter
from .thrust_curve import ROWS, T200_COMMAND, T200_THRUST, check_curve, curve_refusals, curve_thrust

TURN = 2.0 * math.pi
FASTEST_WATER = 5.0  # m/s, up to which the stable step of the propeller holds
SOURCE_OF_POWER = OWN + 4  # status

WITH_STATE = ("lag", "motor_lag", "propeller")  # effects that give a thruster a state
LIMITS = ("forward_limit", "reverse_limit")  # parameters of the thruster without a curve


class StaticCurve(Effect):
    """Measured thrust over command as a table: dead band, saturation, less thrust astern. Numbers: T200 at 16 V."""

    replaces = LIMITS

    command = parameter(T200_COMMAND, "1", "command of a row, not decreasing", size=ROWS, low=-1.0, high=1.0)
    thrust = parameter(T200_THRUST, "N", "thrust of a row, not decreasing", size=ROWS, nominal=10.0)


class PolynomialCurve(Effect):
    """Thrust as an odd polynomial of the command, c1 u + c3 u³ + c5 u⁵ + c7 u⁷ + c9 u⁹. Numbers: von Benzon et al. 2022."""

    explicit_only = True

    excludes = ("static_curve",)
    replaces = LIMITS

    coefficient = parameter((8.9, 176.0, -404.1, 389.9, -140.3), "N", "coefficients, of the power 1 first", size=5, nominal=100.0)


class Lag(Effect):
    """The thrust follows the static one as a first-order lag; 0.1 s is a choice of ours."""

    time_constant = parameter(0.1, "s", "time constant", low=1e-4)


class MotorLag(Effect):
    """The thrust follows the static one as a lag of third order, (b1 s + b0) / (s³ + a2 s² + a1 s + b0).

    Numbers: von Benzon et al. 2022, as read in the repository ViktorNfa/bluerov2_dynamics, whose matrices, rounded, have a
    static gain of 0.99985; here it is 1 whatever the numbers.
    """

    excludes = ("lag",)

    a2 = parameter(89.0, "1/s", "coefficient of s²", low=1e-6)
    a1 = parameter(9258.0, "1/s2", "coefficient of s", low=1e-6)
    b0 = parameter(108700.0, "1/s3", "coefficient of 1, above and below", low=1e-6)
    b1 = parameter(6136.0, "1/s2", "coefficient of s above")


class Propeller(Effect):
    """Motor and propeller in water that comes on at the advance speed; the command is the share of the supply's voltage.

    Speed and thrust at full voltage fit the T200 sheet at 16 V (3533 rpm, 51.4 N, 23.8 A). What the sheet does not tell is
    inferred: a resistance of 0.18 Ohm gives the back-EMF and from it the torque; how thrust and torque fall with the advance
    speed, the rotor's inertia and its friction are choices of ours.
    """

    explicit_only = True

    excludes = ("static_curve", "polynomial_curve", "lag", "motor_lag")
    replaces = LIMITS

    supply_voltage = parameter(16.0, "V", "voltage at full command", low=1e-3)
    resistance = parameter(0.18, "Ohm", "resistance of the motor", low=1e-6)
    motor_constant = parameter(0.03165, "N.m/A", "torque per current, and back-EMF per speed", low=1e-6)
    inertia = parameter(1e-4, "kg.m2", "inertia of rotor, propeller and the water that turns with it", low=1e-9)
    friction = parameter(2e-4, "N.m.s/rad", "friction of rotor and bearings per speed", low=0.0)
    diameter = parameter(0.0762, "m", "diameter of the propeller", low=1e-3)
    water_density = parameter(1000.0, "kg/m3", "density of the water", low=1e-3)
    thrust_bollard = parameter(0.44, "1", "thrust coefficient at rest, K_T0", low=0.0)
    thrust_advance = parameter(-0.5, "1", "change of the thrust coefficient with the advance ratio, K_TJ", high=0.0)
    torque_bollard = parameter(0.0764, "1", "torque coefficient at rest, K_Q0", low=0.0)
    torque_advance = parameter(-0.05, "1", "change of the torque coefficient with the advance ratio, K_QJ", high=0.0)

    advance_speed = input_(0.0, "m/s", "speed of the thruster through the water along its thrust")

    speed = output("rad/s", "speed of rotation", nominal=100.0)
    torque = output(
        "N.m", "torque of the water on the propeller, against its rotation", nominal=0.1, feedthrough=(".advance_speed",)
    )
    current = output("A", "current through the motor", nominal=10.0, feedthrough=("command",))
    electrical_power = output("W", "power taken from the supply", nominal=100.0, feedthrough=("command",))


class Inductance(Effect):
    """The motor's current does not jump. 0.08 mH is of the size of such motors, and a choice of ours."""

    requires = ("propeller",)

    inductance = parameter(8e-5, "H", "inductance of the motor", low=1e-9)


class Status(Effect):
    """A line that tells a controller that the thruster is there; a fault of a scene may override it, as the failure report."""

    explicit_only = True

    available = count("1 while the thruster is there")  # whole: no true or false can be led to a real input


class Thruster(OdeComponent):
    """A thruster, massless towards the hull: its thrust along its own axis, from a command in [-1, 1], beyond which it saturates.

    Without effects the thrust is the command times the limit of its direction. With `propeller`, n turns a second:

        J w' = k i - b w - Q,    V u = R i + k w  (+ L i'),    w = 2 pi n
        thrust = rho D⁴ (K_T0 |n| n + K_TJ |n| u_a / D),    Q = rho D⁵ (K_Q0 |n| n + K_QJ |n| u_a / D)

    The form of thrust and torque is that of Fossen's Marine Systems Simulator, used here in both directions of rotation, where
    that drops u_a astern: a thruster that brakes against its motion through the water then gives more. Where the numbers would
    have the propeller give more power than it takes, they are refused. It has no dead band; `static_curve` has.
    """

    title = "Thruster"
    system = "rov"
    default_step = 0.02
    default_stop = 2.0
    start_inputs = ("command", "propeller.advance_speed")

    static_curve = StaticCurve
    polynomial_curve = PolynomialCurve
    lag = Lag
    motor_lag = MotorLag
    propeller = Propeller
    inductance = Inductance
    status = Status

    forward_limit = parameter(51.44, "N", "thrust at command 1, without a curve; T200 at 16 V", low=1e-6, nominal=10.0)
    reverse_limit = parameter(39.90, "N", "thrust at command -1, without a curve", low=1e-6, nominal=10.0)
    substep = parameter(1e-3, "s", "longest internal step; without `inductance` 10 ms are stable, too", low=1e-9, high=1.0)

    command = input_(0.0, "1", "command, -1 to 1")

    thrust = output("N", "thrust along the axis", nominal=10.0, feedthrough=("command", "propeller.advance_speed"))

    presets = {
        "T200": Preset(
            {},
            "maker's public sheet of September 2019 at 16 V, read in CentraleNantesROV/bluerov2",
            "verbatim",
            ("static_curve",),
        ),
        "von Benzon 2022": Preset(
            {
                "polynomial_curve.coefficient[1]": 8.9,
                "polynomial_curve.coefficient[2]": 176.0,
                "polynomial_curve.coefficient[3]": -404.1,
                "polynomial_curve.coefficient[4]": 389.9,
                "polynomial_curve.coefficient[5]": -140.3,
                "motor_lag.a2": 89.0,
                "motor_lag.a1": 9258.0,
                "motor_lag.b0": 108700.0,
                "motor_lag.b1": 6136.0,
            },
            "von Benzon et al., J. Mar. Sci. Eng. 10 (2022) 1898, as quoted in ViktorNfa/bluerov2_dynamics",
            "verbatim",
            ("polynomial_curve", "motor_lag"),
        ),
    }

    refusals = curve_refusals("static_curve") | {
        SOURCE_OF_POWER: Refusal(
            "propeller: more thrust power than shaft power near the advance ratio {refused[0]}",
            "(2 pi K_QJ - K_T0)² at most 8 pi K_Q0 |K_TJ|",
            "Raise torque_bollard, or lower thrust_bollard.",
        )
    }

    def states(self) -> int:
        """Thrust; the three states of the lag; speed (and current); nothing without such an effect."""
        if "motor_lag" in self.on:
            return 3
        return sum(effect in self.on for effect in ("lag", "propeller", "inductance"))

    def shapes(self) -> dict[str, Any]:
        """`refused`: (4,) numbers of a refusal.  `matrix`: of the lag of third order, and workspace."""
        return super().shapes() | {"refused": 4, "matrix": (2, 3, 3) if "motor_lag" in self.on else None}

    def unused(self, names: Iterable[str]) -> dict[str, str]:
        """See `Component.unused`; also the internal step of a thruster that integrates nothing."""
        names = tuple(names)
        reasons = super().unused(names)
        if "substep" in names and not any(effect in self.on for effect in WITH_STATE):
            reasons["substep"] = f"nothing is integrated without {', '.join(WITH_STATE[:-1])} or {WITH_STATE[-1]}"
        return reasons

    def energy(self) -> float:
        """Energy of the turning propeller and of the inductance, J; 0 where a thruster has neither."""
        _, _, e = self.arguments
        if e.propeller is None:
            return 0.0
        energy = 0.5 * e.propeller.inertia * self.x[0] ** 2
        return energy if e.inductance is None else energy + 0.5 * e.inductance.inductance * self.x[1] ** 2


IN = Thruster.input_places()
OUT = Thruster.output_places()


@kernel
def limited(command):
    """A command within [-1, 1]."""
    return min(max(command, -1.0), 1.0)


@kernel
def static_thrust(command, p, curve, polynomial):
    """Thrust that a constant command ends at, N."""
    u = limited(command)
    if curve is not None:
        return curve_thrust(u, curve.command, curve.thrust)
    if polynomial is not None:
        c, s = polynomial.coefficient, u * u
        return u * (c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * c[4]))))
    return u * (p.forward_limit if u >= 0.0 else p.reverse_limit)


@kernel
def torque_constants(propeller):
    """The water's torque is square * |w| w + cross * |w| u_a, in N.m, for a speed w in rad/s."""
    scale = propeller.water_density * propeller.diameter**4 / TURN
    return scale * propeller.diameter * propeller.torque_bollard / TURN, scale * propeller.torque_advance


@kernel
def propeller_torque(speed, advance, propeller):
    """Torque of the water against the rotation, N.m."""
    square, cross = torque_constants(propeller)
    return abs(speed) * (square * speed + cross * advance)


@kernel
def propeller_thrust(speed, advance, propeller):
    """Thrust of the propeller, N."""
    n, d = speed / TURN, propeller.diameter
    return propeller.water_density * d**4 * abs(n) * (propeller.thrust_bollard * n + propeller.thrust_advance * advance / d)


@kernel
def steady_speed(command, advance, propeller):
    """Speed at which motor and water balance, rad/s, turning the way the voltage drives; 0 without voltage."""
    square, cross = torque_constants(propeller)
    k, r = propeller.motor_constant, propeller.resistance
    drive = k * abs(command) * propeller.supply_voltage / r
    if drive == 0.0:
        return 0.0
    linear = propeller.friction + k * k / r + math.copysign(1.0, command) * cross * advance
    # the positive root of square w² + linear w = drive, in a form that loses no digits
    root = math.sqrt(linear * linear + 4.0 * square * drive)
    speed = 2.0 * drive / (linear + root) if linear >= 0.0 else (root - linear) / (2.0 * square)
    return math.copysign(speed, command)


@kernel
def motor_current(x, u, propeller, inductance):
    """Current of the motor, A."""
    if inductance is not None:
        return x[1]
    return (limited(u[IN.command]) * propeller.supply_voltage - propeller.motor_constant * x[0]) / propeller.resistance


@kernel
def gives_power(propeller, refused):
    """Whether there is an advance ratio, then in `refused`, at which the thrust has more power than the shaft.

    Power of the shaft less that of the thrust, over rho D⁵ |n|³, is a + b J + c J² in the advance ratio J.
    """
    a = TURN * propeller.torque_bollard
    b = TURN * propeller.torque_advance - propeller.thrust_bollard
    c = -propeller.thrust_advance
    if b * b > 4.0 * a * c:
        refused[0] = 0.5 * abs(b) / c if c > 0.0 else math.inf
        return True
    return False


@kernel
def thruster_start(t, s, p, e):
    """Steady state at the present command; a curve that falls and a propeller that is a source of power are refused."""
    x, u = s.x, s.u[0]
    if e.static_curve is not None:
        status = check_curve(e.static_curve.command, e.static_curve.thrust, s.refused)
        if status != DONE:
            return status
    if e.lag is not None:
        x[0] = static_thrust(u[IN.command], p, e.static_curve, e.polynomial_curve)
    if e.motor_lag is not None:
        x[0] = static_thrust(u[IN.command], p, e.static_curve, e.polynomial_curve) / e.motor_lag.b0
    if e.propeller is not None:
        if gives_power(e.propeller, s.refused):
            return SOURCE_OF_POWER
        command = limited(u[IN.command])
        x[0] = steady_speed(command, u[e.propeller.u], e.propeller)
        if e.inductance is not None:
            voltage = command * e.propeller.supply_voltage
            x[1] = (voltage - e.propeller.motor_constant * x[0]) / e.propeller.resistance
    return DONE


@kernel
def thruster_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue|, s; of the propeller at full speed in water that moves at up to 5 m/s."""
    if e.lag is not None:
        return RK4_STABILITY_RADIUS * e.lag.time_constant
    if e.motor_lag is not None:
        A = s.matrix[0]
        A[:] = 0.0
        A[0, 1], A[1, 2] = 1.0, 1.0
        A[2, 0], A[2, 1], A[2, 2] = -e.motor_lag.b0, -e.motor_lag.a1, -e.motor_lag.a2
        return step_within(RK4_STABILITY_RADIUS, spectral_radius(A, s.matrix[1]))
    if e.propeller is not None:
        fastest = e.propeller.supply_voltage / e.propeller.motor_constant
        square, cross = torque_constants(e.propeller)
        water = e.propeller.friction + 2.0 * square * fastest + abs(cross) * FASTEST_WATER
        k, r, inertia = e.propeller.motor_constant, e.propeller.resistance, e.propeller.inertia
        if e.inductance is not None:
            inductance = e.inductance.inductance
            rate = fastest_rate(inertia * inductance, water * inductance + r * inertia, water * r + k * k)
            return step_within(RK4_STABILITY_RADIUS, rate)
        return RK4_STABILITY_RADIUS * inertia / (water + k * k / r)
    return math.inf


@kernel
def thruster_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (), (thrust), the states of the third-order lag in controllable form, or (speed[, current])."""
    if e.lag is not None:
        dx[0] = (static_thrust(u[IN.command], p, e.static_curve, e.polynomial_curve) - x[0]) / e.lag.time_constant
    if e.motor_lag is not None:
        dx[0], dx[1] = x[1], x[2]
        dx[2] = (
            static_thrust(u[IN.command], p, e.static_curve, e.polynomial_curve)
            - e.motor_lag.b0 * x[0]
            - e.motor_lag.a1 * x[1]
            - e.motor_lag.a2 * x[2]
        )
    if e.propeller is not None:
        current = motor_current(x, u, e.propeller, e.inductance)
        torque = propeller_torque(x[0], u[e.propeller.u], e.propeller)
        dx[0] = (e.propeller.motor_constant * current - e.propeller.friction * x[0] - torque) / e.propeller.inertia
        if e.inductance is not None:
            voltage = limited(u[IN.command]) * e.propeller.supply_voltage
            dx[1] = (voltage - e.propeller.resistance * x[1] - e.propeller.motor_constant * x[0]) / e.inductance.inductance


@kernel
def thruster_outputs(t, s, p, e):
    """Thrust, and the states of motor and propeller."""
    x, u, y = s.x, s.u[0], s.y
    if e.lag is not None:
        y[OUT.thrust] = x[0]
    elif e.motor_lag is not None:
        y[OUT.thrust] = e.motor_lag.b0 * x[0] + e.motor_lag.b1 * x[1]
    elif e.propeller is not None:
        current = motor_current(x, u, e.propeller, e.inductance)
        y[OUT.thrust] = propeller_thrust(x[0], u[e.propeller.u], e.propeller)
        y[e.propeller.y] = x[0]
        y[e.propeller.y + 1] = propeller_torque(x[0], u[e.propeller.u], e.propeller)
        y[e.propeller.y + 2] = current
        y[e.propeller.y + 3] = current * limited(u[IN.command]) * e.propeller.supply_voltage
    else:
        y[OUT.thrust] = static_thrust(u[IN.command], p, e.static_curve, e.polynomial_curve)
    if e.status is not None:
        y[e.status.y] = 1.0
    return DONE


Thruster.kernels = ode_kernels(
    __name__, start=thruster_start, derivatives=thruster_derivatives, outputs=thruster_outputs, stable=thruster_stable
)
