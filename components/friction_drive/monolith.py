"""The whole friction-wheel drive but for its controller: two servo motors, wheels and sleeve in one unit."""

from __future__ import annotations

from typing import Any

from ..core.events import EventComponent, event_kernels
from ..core.friction import stick_friction, stick_guard, stick_mode, stick_switch
from ..core.kernels import DONE, kernel
from ..core.variables import flag, input_, output
from ..drives import servo_motor
from ..drives.servo_motor import MotorParameters, shaft_inertia
from .sleeve import (
    FEED,
    FEED_RATE,
    GUARDS,
    ROTATION,
    ROTATION_RATE,
    contact_outputs,
    contacts,
    seal_place,
    sleeve_derivatives,
    sleeve_energy,
    sleeve_guards,
    sleeve_start,
    sleeve_states,
    sleeve_switch,
    stuck_outputs,
    wheel_loads,
)
from .wheels import FrictionWheels, SleeveDeclarations, declared_status

RATES, CURRENTS = 2, 4  # behind the motors' place in the state: two angles, two rates, two currents; at last two modes


class ShaftFriction(servo_motor.ShaftFriction):
    """Dry friction of both motors' bearings and gears with exact standstill, as in the motor's unit."""

    stuck = None  # type: ignore[assignment]  # there are two
    first_stuck = flag("1 while the first shaft stands, 0 while it turns")
    second_stuck = flag("1 while the second shaft stands, 0 while it turns")


class MotorDeclarations(MotorParameters):
    """Effects and parameters of both motors."""

    shaft_friction = ShaftFriction


class FrictionDrive(SleeveDeclarations, MotorDeclarations, EventComponent):
    """Two equal servo motors whose wheels move a sleeve by friction: what `ServoMotor`, twice, and `FrictionWheels` couple to.

    Equations and numbers are theirs, solved as one: the reference for the split. Slip is between states here, so that the
    contacts' part in the loads needs no step between. Two contacts that stick while friction holds the shafts, too, leave their
    tractions open if all is rigid; with `exact_slip` contacts are elastic, and the deflections say how the load is shared.
    Of Frączak (2013), known to us by its abstract, is that friction wheels move a sleeve in two degrees of freedom.
    """

    title = "Friction-wheel drive, whole"
    system = "friction_drive"
    start_inputs = ("first_voltage", "second_voltage")  # they decide whether a shaft sticks

    first_voltage = input_(0.0, "V", "voltage of the first motor", nominal=10.0)
    second_voltage = input_(0.0, "V", "voltage of the second motor", nominal=10.0)
    external_force = FrictionWheels.external_force
    external_torque = FrictionWheels.external_torque

    first_angle = output("rad", "angle of the first wheel")
    second_angle = output("rad", "angle of the second wheel")
    first_rate = output("rad/s", "rate of the first wheel", nominal=10.0)
    second_rate = output("rad/s", "rate of the second wheel", nominal=10.0)
    first_current = output("A", "current of the first motor", feedthrough=("first_voltage",))
    second_current = output("A", "current of the second motor", feedthrough=("second_voltage",))
    electrical_power = output("W", "power that both motors get", nominal=10.0, feedthrough=("first_voltage", "second_voltage"))
    feed = FrictionWheels.feed
    feed_rate = FrictionWheels.feed_rate
    rotation = FrictionWheels.rotation
    rotation_rate = FrictionWheels.rotation_rate
    first_torque = output("N.m", "load of the first wheel, against a positive rate", nominal=0.05)
    second_torque = output("N.m", "load of the second wheel, against a positive rate", nominal=0.05)
    first_slip_axial = output("m/s", "slip of the sleeve on the first wheel, along the axis", nominal=0.1)
    first_slip_around = output("m/s", "slip of the sleeve on the first wheel, around it", nominal=0.1)
    second_slip_axial = output("m/s", "slip of the sleeve on the second wheel, along the axis", nominal=0.1)
    second_slip_around = output("m/s", "slip of the sleeve on the second wheel, around it", nominal=0.1)
    first_traction_axial = output("N", "force of the first wheel on the sleeve, along the axis")
    first_traction_around = output("N", "force of the first wheel on the sleeve, around it")
    second_traction_axial = output("N", "force of the second wheel on the sleeve, along the axis")
    second_traction_around = output("N", "force of the second wheel on the sleeve, around it")
    margin = output("1", "share of the kinetic friction still free, of the wheel that has less; 0 without preload")
    contact_power = output("W", "power that the contacts take up: lost, but for what deflections store")
    mechanical_energy = output("J", "kinetic energy, height above feed zero, deflection of contacts and seal")

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """Those of both contacts, the seal and both shafts, where any of them can hold."""
        return GUARDS + 2 if {"shaft_friction", "exact_slip", "trocar_friction"} & {*self.on} else 0

    def states(self) -> int:
        """Those of the sleeve, angles, rates[, currents][, modes of the shafts]."""
        return sleeve_states(self.on) + 4 + 2 * ("inductance" in self.on) + 2 * ("shaft_friction" in self.on)

    def shapes(self) -> dict[str, Any]:
        """`slopes`: of the derivatives over the state, and workspace."""
        return super().shapes() | {"slopes": (2, self.states(), self.states())}

    def energy(self) -> float:
        """Energy of sleeve, contacts, seal, rotors and wheels, and of the windings, J."""
        _, p, e = self.arguments
        at = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
        twice = shaft_inertia(p) * (self.x[at + RATES : at + RATES + 2] ** 2).sum()
        if e.inductance is not None:
            twice += e.inductance.inductance * (self.x[at + CURRENTS : at + CURRENTS + 2] ** 2).sum()
        return float(sleeve_energy(self.t, self.x, p, e) + 0.5 * twice)


IN = FrictionDrive.input_places()
OUT = FrictionDrive.output_places()


@kernel
def motor_place(lugre, exact, rolling, trocar):
    """Place of the motors in the state."""
    return seal_place(lugre, exact, rolling) + (3 if trocar is not None else 0)


@kernel
def shaft_modes(inductance):
    """Place of the shafts' modes behind that of the motors."""
    return CURRENTS + 2 if inductance is not None else CURRENTS


@kernel
def current(k, at, x, voltage, p, inductance):
    """Current of motor k, A: of the state, or the steady one."""
    if inductance is not None:
        return x[at + CURRENTS + k]
    return (voltage - p.constant * p.gear_ratio * x[at + RATES + k]) / p.resistance


@kernel
def shaft_drive(k, at, x, voltage, load, p, inductance):
    """Torque that accelerates wheel k, dry friction apart, N.m."""
    torque = p.gear_ratio * p.constant * current(k, at, x, voltage, p, inductance)
    return torque - p.gear_ratio * p.gear_ratio * p.damping * x[at + RATES + k] - load


@kernel
def shaft_levels(k, at, x, voltage, p, inductance, shaft):
    """(kinetic, static) friction of shaft k, N.m at the wheel, with the share of the motor's torque that its gear loses."""
    lost = shaft.gear_loss * abs(p.gear_ratio * p.constant * current(k, at, x, voltage, p, inductance))
    return shaft.level + lost, shaft.static_ratio * shaft.level + lost


@kernel
def shafts(t, x, u, p, e):
    """(drive, drive, static, static): torques that both shafts bear while they stand, and their limits, N.m."""
    at = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    _, _, _, _, qx, qy, rx, ry = contacts(t, x, x[at + RATES], x[at + RATES + 1], p, e)
    load_1, load_2 = wheel_loads(qx, qy, rx, ry, p)
    return (
        shaft_drive(0, at, x, u[IN.first_voltage], load_1, p, e.inductance),
        shaft_drive(1, at, x, u[IN.second_voltage], load_2, p, e.inductance),
        shaft_levels(0, at, x, u[IN.first_voltage], p, e.inductance, e.shaft_friction)[1],
        shaft_levels(1, at, x, u[IN.second_voltage], p, e.inductance, e.shaft_friction)[1],
    )


@kernel
def drive_start(t, s, p, e):
    """Sleeve as in `FrictionWheels`, wheels at rest at angle zero, currents as given, shafts that stand where they can."""
    x, at = s.x, motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    sleeve_start(x, p)
    if e.inductance is not None:
        x[at + CURRENTS] = x[at + CURRENTS + 1] = e.inductance.start_current
    if e.shaft_friction is not None:
        drive_1, drive_2, static_1, static_2 = shafts(t, x, s.u[0], p, e)
        mode = at + shaft_modes(e.inductance)
        x[mode], x[mode + 1] = stick_mode(0.0, drive_1, static_1), stick_mode(0.0, drive_2, static_2)
    return declared_status(p, e)


@kernel
def drive_resting(x, p, e):
    """The shafts slide: while they stand, motors and wheels would not move."""
    if e.shaft_friction is not None:
        mode = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction) + shaft_modes(e.inductance)
        x[mode], x[mode + 1] = 1.0, 1.0


@kernel
def drive_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (sleeve, angles, rates[, currents][, modes])."""
    at = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    load_1, load_2 = sleeve_derivatives(
        t, x, x[at + RATES], x[at + RATES + 1], (u[IN.external_force], u[IN.external_torque]), dx, p, e
    )
    for k in range(2):
        voltage, rate = u[IN.first_voltage + k], x[at + RATES + k]
        torque = shaft_drive(k, at, x, voltage, load_1 if k == 0 else load_2, p, e.inductance)
        if e.shaft_friction is not None:
            mode = at + shaft_modes(e.inductance) + k
            torque -= stick_friction(x[mode], torque, shaft_levels(k, at, x, voltage, p, e.inductance, e.shaft_friction)[0])
            dx[mode] = 0.0
        dx[at + k], dx[at + RATES + k] = rate, torque / shaft_inertia(p)
        if e.inductance is not None:
            drop = p.resistance * x[at + CURRENTS + k] + p.constant * p.gear_ratio * rate
            dx[at + CURRENTS + k] = (voltage - drop) / e.inductance.inductance


@kernel
def drive_guards(t, x, u, g, s, p, e):
    """Guards: positive while the modes of both contacts, the seal and both shafts last."""
    at = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    sleeve_guards(x, x[at + RATES], x[at + RATES + 1], g, p, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    g[3] = g[4] = 1.0
    if e.shaft_friction is not None:
        drive_1, drive_2, static_1, static_2 = shafts(t, x, u, p, e)
        mode = at + shaft_modes(e.inductance)
        g[3] = stick_guard(x[mode], x[at + RATES], drive_1, static_1)
        g[4] = stick_guard(x[mode + 1], x[at + RATES + 1], drive_2, static_2)


@kernel
def drive_switch(which, t, x, u, s, p, e):
    """A contact, the seal or a shaft breaks loose, or comes to rest."""
    if which < 3:
        sleeve_switch(which, x, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    elif e.shaft_friction is not None:
        k, at = which - 3, motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
        x[at + RATES + k] = 0.0
        drive_1, drive_2, static_1, static_2 = shafts(t, x, u, p, e)
        mode = at + shaft_modes(e.inductance) + k
        x[mode] = stick_switch(x[mode], drive_1 if k == 0 else drive_2, static_1 if k == 0 else static_2)


@kernel
def drive_outputs(t, s, p, e):
    """Motors, sleeve, contacts, energy, and which parts stand."""
    x, u, y = s.x, s.u[0], s.y
    at = motor_place(e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    y[OUT.first_angle], y[OUT.second_angle], y[OUT.first_rate], y[OUT.second_rate] = (
        x[at],
        x[at + 1],
        x[at + RATES],
        x[at + RATES + 1],
    )
    y[OUT.first_current], y[OUT.second_current] = (
        current(0, at, x, u[IN.first_voltage], p, e.inductance),
        current(1, at, x, u[IN.second_voltage], p, e.inductance),
    )
    y[OUT.electrical_power] = u[IN.first_voltage] * y[OUT.first_current] + u[IN.second_voltage] * y[OUT.second_current]
    y[OUT.feed], y[OUT.feed_rate], y[OUT.rotation], y[OUT.rotation_rate] = x[FEED], x[FEED_RATE], x[ROTATION], x[ROTATION_RATE]
    y[OUT.first_torque], y[OUT.second_torque] = contact_outputs(
        t, x, y[OUT.first_rate], y[OUT.second_rate], y, OUT.first_slip_axial, p, e
    )
    y[OUT.mechanical_energy] = sleeve_energy(t, x, p, e)
    stuck_outputs(x, y, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    if e.shaft_friction is not None:
        mode = at + shaft_modes(e.inductance)
        y[e.shaft_friction.y], y[e.shaft_friction.y + 1] = 1.0 if x[mode] == 0.0 else 0.0, 1.0 if x[mode + 1] == 0.0 else 0.0
    return DONE


FrictionDrive.kernels = event_kernels(
    __name__,
    start=drive_start,
    derivatives=drive_derivatives,
    outputs=drive_outputs,
    resting=drive_resting,
    guards=drive_guards,
    switch=drive_switch,
)
