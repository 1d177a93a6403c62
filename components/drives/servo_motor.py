"""A servo motor behind a gear, with the inertias that turn with it: it gives a motion and takes the load's torque."""

from __future__ import annotations

from typing import Any

from ..core.component import Effect, Preset
from ..core.events import EventComponent, event_kernels
from ..core.friction import stick_friction, stick_guard, stick_mode, stick_switch
from ..core.kernels import DONE, kernel
from ..core.variables import flag, input_, output, parameter
from . import torque_motor

ANGLE, RATE, CURRENT = 0, 1, 2  # of the state; with stick the mode is its last element


class Inductance(Effect):
    """The current follows with the time constant inductance / resistance; off, it is there at once."""

    inductance = parameter(0.238e-3, "H", "inductance of the winding", low=1e-9)
    start_current = parameter(0.0, "A", "current in the winding at the start")


class Saturation(torque_motor.Saturation):
    """The amplifier's limits: its voltage, and the current, above which it gives no more voltage than the current needs."""

    voltage = parameter(12.0, "V", "largest voltage of the amplifier", low=1e-9, nominal=10.0)
    current = parameter(4.0, "A", "largest current, held where the voltage allows it", low=1e-9)


class ShaftFriction(Effect):
    """Dry friction of bearings and gear with exact standstill, the start of motion and its end found as events.

    The kinetic level at the wheel is `level` and a share of the torque that the gear passes on, so that a gear of 80 % that
    drives has a `gear_loss` of 0.2; a load that drives the motor pays the same share, and nothing is ever gained.
    """

    level = parameter(0.01, "N.m", "kinetic friction at the wheel", low=0.0)
    static_ratio = parameter(1.5, "1", "static over kinetic friction, without the gear's share", low=1.0)
    gear_loss = parameter(0.2, "1", "share of the motor's torque that the gear's teeth lose", low=0.0, high=0.99)

    stuck = flag("1 while the shaft stands, 0 while it turns")


class Heating(Effect):
    """The winding's losses heat it, and it the housing: two heat capacities; copper's resistance grows with the temperature.

        C_w Tw' = R(Tw) i² - (Tw - Th) / R_wh,    C_h Th' = (Tw - Th) / R_wh - (Th - Ta) / R_ha,    R(T) = R (1 + a (T - 25 °C))

    `resistance` is that at 25 °C, as data sheets have it. Losses of iron, bearings and gear are left out, and so is what the heat
    takes from the magnets. Defaults: from memory, of the size of data sheets of motors of 22 mm; none of a particular motor.
    """

    coefficient = parameter(0.00393, "1/K", "growth of the resistance, a, copper's by default", low=0.0, nominal=0.004)
    winding_capacity = parameter(1.1, "J/K", "heat capacity of the winding, C_w", low=1e-9)
    housing_capacity = parameter(40.0, "J/K", "heat capacity of the housing, C_h", low=1e-9, nominal=10.0)
    winding_to_housing = parameter(5.0, "K/W", "thermal resistance from the winding to the housing, R_wh", low=1e-9)
    housing_to_ambient = parameter(
        14.0, "K/W", "thermal resistance from the housing to the ambient, R_ha", low=1e-9, nominal=10.0
    )
    ambient = parameter(298.15, "K", "temperature of the ambient, and of the motor at the start", low=0.0, nominal=300.0)

    winding_temperature = output("K", "temperature of the winding", nominal=300.0)
    housing_temperature = output("K", "temperature of the housing", nominal=300.0)


REFERENCE = 298.15  # K, at which data sheets give a resistance


class MotorParameters:
    """Winding, gear and inertias of a motor, for its own unit and for drives that contain such motors."""

    inductance = Inductance

    resistance = parameter(2.3, "Ohm", "resistance of the winding", low=1e-9)
    constant = parameter(
        23.4e-3, "N.m/A", "torque of the motor per current, the same number as voltage per rate", low=0.0, nominal=0.01
    )
    gear_ratio = parameter(19.0, "1", "turns of the motor per turn of the wheel; negative: against it", nominal=10.0)
    rotor_inertia = parameter(1e-6, "kg.m2", "moment of inertia of the rotor, at the motor's shaft", low=0.0, nominal=1e-6)
    wheel_inertia = parameter(1e-6, "kg.m2", "moment of inertia of the wheel and the gear's last shaft", low=1e-15, nominal=1e-6)
    damping = parameter(1e-7, "N.m.s/rad", "viscous damping at the motor's shaft", low=0.0, nominal=1e-6)


class ServoMotor(MotorParameters, EventComponent):
    """A DC motor with constant field, a gear, and a wheel on the gear's shaft; w is the rate of the wheel, N the gear ratio.

        L i' = V - R i - k N w
        (N² J_r + J_w) w' = N k i - N² b w - friction - load

    Without `inductance` the current is (V - k N w) / R. `load_torque` brakes a positive rate. The poles of rate and current are
    the roots of s² + (R/L + B/J) s + (k² N² + R B) / (L J), with J and B at the wheel. Servo motors that move the sleeve of a
    laparoscope by friction wheels are the subject of Frączak (2013), known to us by its abstract; the equations are the usual
    ones of a DC motor. Defaults: numbers from memory for a motor of 12 V with a gear of 19:1, none published with that drive.
    """

    title = "Servo motor with gear and wheel"
    system = "drives"
    default_stop = 0.5
    start_inputs = ("voltage", "load_torque")  # they decide whether the shaft sticks

    saturation = Saturation
    shaft_friction = ShaftFriction
    heating = Heating

    start_angle = parameter(0.0, "rad", "angle of the wheel at the start")
    start_rate = parameter(0.0, "rad/s", "rate of the wheel at the start")
    substep = parameter(1e-4, "s", "longest internal step", low=1e-9, high=1.0)

    voltage = input_(0.0, "V", "voltage asked of the amplifier", nominal=10.0)
    load_torque = input_(0.0, "N.m", "torque of the load at the wheel, against a positive rate", nominal=0.1)

    angle = output("rad", "angle of the wheel")
    rate = output("rad/s", "rate of the wheel", nominal=10.0)
    current = output("A", "current in the winding", feedthrough=("voltage",))
    electrical_power = output(
        "W", "power that the amplifier gives, negative where it gets some back", nominal=10.0, feedthrough=("voltage",)
    )

    presets = {
        "motor alone": Preset(
            {"gear_ratio": 1.0, "wheel_inertia": 1e-15, "inductance.inductance": 0.238e-3},
            "the default motor without gear and wheel: poles at -244.3 and -9419.6 1/s",
            "unconfirmed",
            ("inductance",),
        )
    }

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """One where the shaft can stick."""
        return 1 if "shaft_friction" in self.on else 0

    def states(self) -> int:
        """Angle, rate, the current where it is a state, both temperatures above the ambient's, and the mode of the shaft."""
        return 2 + ("inductance" in self.on) + 2 * ("heating" in self.on) + ("shaft_friction" in self.on)

    def shapes(self) -> dict[str, Any]:
        """`slopes`: of the derivatives over the state, and workspace."""
        return super().shapes() | {"slopes": (2, self.states(), self.states())}

    def energy(self) -> float:
        """Kinetic energy of rotor and wheel and the energy of the inductance, J."""
        _, p, e = self.arguments
        kinetic = 0.5 * shaft_inertia(p) * self.x[RATE] ** 2
        return float(kinetic if e.inductance is None else kinetic + 0.5 * e.inductance.inductance * self.x[CURRENT] ** 2)


IN = ServoMotor.input_places()
OUT = ServoMotor.output_places()


@kernel
def shaft_inertia(p):
    """Moment of inertia of rotor and wheel at the wheel, kg.m²."""
    return p.gear_ratio * p.gear_ratio * p.rotor_inertia + p.wheel_inertia


@kernel
def heat_place(inductance):
    """Place of the temperatures in the state."""
    return CURRENT + 1 if inductance is not None else CURRENT


@kernel
def winding_resistance(x, p, e):
    """Resistance of the winding, Ohm: at its temperature where it heats."""
    if e.heating is not None:
        temperature = e.heating.ambient + x[heat_place(e.inductance)]
        return p.resistance * (1.0 + e.heating.coefficient * (temperature - REFERENCE))
    return p.resistance


@kernel
def winding_voltage(rate, u, resistance, p, saturation):
    """Voltage at the winding: what is asked, or what the amplifier's limits leave of it, V."""
    if saturation is None:
        return u[IN.voltage]
    return torque_motor.limited_voltage(u[IN.voltage], p.constant * p.gear_ratio * rate, resistance, saturation)


@kernel
def steady_current(rate, u, resistance, p, saturation):
    """Current in the steady state at a rate of the wheel, A."""
    return (winding_voltage(rate, u, resistance, p, saturation) - p.constant * p.gear_ratio * rate) / resistance


@kernel
def winding_current(x, u, p, e):
    """Current in the winding, A: of the state, or the steady one."""
    if e.inductance is not None:
        return x[CURRENT]
    return steady_current(x[RATE], u, winding_resistance(x, p, e), p, e.saturation)


@kernel
def shaft_drive(x, u, p, e):
    """Torque that accelerates the wheel, dry friction apart, N.m."""
    torque = p.gear_ratio * p.constant * winding_current(x, u, p, e)
    return torque - p.gear_ratio * p.gear_ratio * p.damping * x[RATE] - u[IN.load_torque]


@kernel
def gear_friction(x, u, p, e):
    """Share of the motor's torque that the gear loses, N.m at the wheel."""
    return e.shaft_friction.gear_loss * abs(p.gear_ratio * p.constant * winding_current(x, u, p, e))


@kernel
def static_level(x, u, p, e):
    """Largest friction of a shaft that stands, N.m."""
    return e.shaft_friction.static_ratio * e.shaft_friction.level + gear_friction(x, u, p, e)


@kernel
def servo_start(t, s, p, e):
    """Angle and rate of the parameters, the current where it is a state, the mode of the shaft; as warm as the ambient."""
    x = s.x
    x[ANGLE], x[RATE] = p.start_angle, p.start_rate
    if e.inductance is not None:
        x[CURRENT] = e.inductance.start_current
    if e.shaft_friction is not None:
        drive = shaft_drive(x, s.u[0], p, e)
        x[-1] = stick_mode(p.start_rate, drive, static_level(x, s.u[0], p, e))
    return DONE


@kernel
def servo_resting(x, p, e):
    """The shaft slides: while it stands, the motor would not move."""
    if e.shaft_friction is not None:
        x[-1] = 1.0


@kernel
def servo_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (angle, rate[, current][, temperatures][, mode])."""
    torque = shaft_drive(x, u, p, e)
    if e.shaft_friction is not None:
        kinetic = e.shaft_friction.level + gear_friction(x, u, p, e)
        torque -= stick_friction(x[-1], torque, kinetic)
        dx[-1] = 0.0
    dx[ANGLE] = x[RATE]
    dx[RATE] = torque / shaft_inertia(p)
    if e.inductance is not None:
        induced = p.constant * p.gear_ratio * x[RATE]
        resistance = winding_resistance(x, p, e)
        given = winding_voltage(x[RATE], u, resistance, p, e.saturation)
        dx[CURRENT] = (given - resistance * x[CURRENT] - induced) / e.inductance.inductance
    if e.heating is not None:
        heat, at, current = e.heating, heat_place(e.inductance), winding_current(x, u, p, e)
        passed = (x[at] - x[at + 1]) / heat.winding_to_housing
        dx[at] = (winding_resistance(x, p, e) * current * current - passed) / heat.winding_capacity
        dx[at + 1] = (passed - x[at + 1] / heat.housing_to_ambient) / heat.housing_capacity


@kernel
def servo_guards(t, x, u, g, s, p, e):
    """Guards: positive while the shaft's mode lasts."""
    level = static_level(x, u, p, e)
    g[0] = stick_guard(x[-1], x[RATE], shaft_drive(x, u, p, e), level)


@kernel
def servo_switch(which, t, x, u, s, p, e):
    """The shaft has come to rest or breaks loose: its rate is zero, and its drive decides what follows."""
    x[RATE] = 0.0
    level = static_level(x, u, p, e)
    x[-1] = stick_switch(x[-1], shaft_drive(x, u, p, e), level)


@kernel
def servo_outputs(t, s, p, e):
    """Angle, rate, current, electrical power, and whether the shaft stands."""
    x, u, y = s.x, s.u[0], s.y
    y[OUT.angle], y[OUT.rate] = x[ANGLE], x[RATE]
    y[OUT.current] = winding_current(x, u, p, e)
    y[OUT.electrical_power] = winding_voltage(x[RATE], u, winding_resistance(x, p, e), p, e.saturation) * y[OUT.current]
    if e.heating is not None:
        at = heat_place(e.inductance)
        y[e.heating.y], y[e.heating.y + 1] = e.heating.ambient + x[at], e.heating.ambient + x[at + 1]
    if e.shaft_friction is not None:
        y[e.shaft_friction.y] = 1.0 if x[-1] == 0.0 else 0.0
    return DONE


ServoMotor.kernels = event_kernels(
    __name__,
    start=servo_start,
    derivatives=servo_derivatives,
    outputs=servo_outputs,
    resting=servo_resting,
    guards=servo_guards,
    switch=servo_switch,
)
