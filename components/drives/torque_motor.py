"""A DC motor as a source of torque, with a gear: the inertia it turns belongs to the load."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.contract import Kernels
from ..core.integrators import RK4_STABILITY_RADIUS, STABLE, SUBSTEP, SUBSTEP_TOO_LONG, OdeComponent, rk4
from ..core.kernels import DONE, bind, kernel
from ..core.variables import input_, output, parameter


class Inductance(Effect):
    """The current follows with the time constant inductance / resistance; off, it is there at once."""

    inductance = parameter(1e-3, "H", "inductance of the winding", low=1e-9)
    start_current = parameter(0.0, "A", "current in the winding at the start; 0 for a motor that is switched on there")
    substep = parameter(2e-4, "s", "longest internal step", low=1e-9, high=1.0)


class Saturation(Effect):
    """The amplifier's limits: its voltage, and the current, above which it gives no more voltage than the current needs."""

    voltage = parameter(24.0, "V", "largest voltage of the amplifier", low=1e-9, nominal=10.0)
    current = parameter(5.0, "A", "largest current, held where the voltage allows it", low=1e-9)


class TorqueMotor(OdeComponent):
    """A brushed DC motor with constant field, or a brushless one seen from its amplifier, and an ideal gear.

        L i' = V - R i - k N w,    T = N k i

    V: voltage, w: rate of the load's axis, N: gear ratio, k: torque per current, the same number as voltage per rate. Without
    `inductance` the current is (V - k N w) / R. The rotor's inertia, times N², belongs to the load. Numbers are a choice of ours,
    of the size of a direct drive for a small gimbal.
    """

    title = "Torque motor"
    system = "drives"
    start_inputs = ()

    inductance = Inductance
    saturation = Saturation

    resistance = parameter(2.0, "Ohm", "resistance of the winding", low=1e-9)
    constant = parameter(0.1, "N.m/A", "torque of the motor per current", low=0.0)
    gear_ratio = parameter(1.0, "1", "turns of the motor per turn of the load; negative: against it")

    voltage = input_(0.0, "V", "voltage asked of the amplifier", nominal=10.0)
    rate = input_(0.0, "rad/s", "rate of the load's axis")

    torque = output("N.m", "torque on the load", feedthrough=("voltage", "rate"))
    current = output("A", "current in the winding", feedthrough=("voltage", "rate"))
    electrical_power = output(
        "W", "power that the amplifier gives, negative where it gets some back", nominal=10.0, feedthrough=("voltage", "rate")
    )

    def states(self) -> int:
        """The current, with `inductance`; no state without."""
        return 1 if "inductance" in self.on else 0

    def energy(self) -> float:
        """Energy of the inductance, J; 0 without it."""
        inductance = self.arguments[2].inductance
        return 0.0 if inductance is None else float(0.5 * inductance.inductance * self.x[0] ** 2)


IN = TorqueMotor.input_places()
OUT = TorqueMotor.output_places()


@kernel
def back_emf(u, p):
    """Voltage that the turning induces in the winding, V."""
    return p.constant * p.gear_ratio * u[IN.rate]


@kernel
def limited_voltage(asked, induced, resistance, saturation):
    """Voltage that an amplifier with the limits of `Saturation` gives to a motor with the induced voltage, V."""
    drop = resistance * saturation.current
    wanted = min(max(asked, induced - drop), induced + drop)
    return min(max(wanted, -saturation.voltage), saturation.voltage)


@kernel
def amplifier_voltage(u, p, saturation):
    """Voltage at the winding: what is asked, or what the amplifier's limits leave of it."""
    if saturation is None:
        return u[IN.voltage]
    return limited_voltage(u[IN.voltage], back_emf(u, p), p.resistance, saturation)


@kernel
def motor_initialize(t, s, p, e):
    """The current at the start, which no voltage makes jump, and the internal step; without a winding nothing is integrated."""
    s.limits[SUBSTEP], s.limits[STABLE] = math.inf, math.inf
    if e.inductance is not None:
        s.x[0] = e.inductance.start_current
        s.limits[SUBSTEP] = e.inductance.substep
        s.limits[STABLE] = RK4_STABILITY_RADIUS * e.inductance.inductance / p.resistance
    if s.limits[SUBSTEP] > s.limits[STABLE]:
        return SUBSTEP_TOO_LONG
    return DONE


@kernel
def motor_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (current,), or nothing without inductance."""
    if e.inductance is not None:
        dx[0] = (amplifier_voltage(u, p, e.saturation) - p.resistance * x[0] - back_emf(u, p)) / e.inductance.inductance


@kernel
def motor_outputs(t, s, p, e):
    """Torque, current and electrical power."""
    u, y = s.u[0], s.y
    voltage = amplifier_voltage(u, p, e.saturation)
    if e.inductance is not None:
        current = s.x[0]
    else:
        current = (voltage - back_emf(u, p)) / p.resistance
    y[OUT.torque] = p.gear_ratio * p.constant * current
    y[OUT.current] = current
    y[OUT.electrical_power] = voltage * current
    return DONE


TorqueMotor.kernels = Kernels(
    motor_initialize, bind(rk4, __name__, derivatives=motor_derivatives, outputs=motor_outputs), motor_outputs, motor_derivatives
)
