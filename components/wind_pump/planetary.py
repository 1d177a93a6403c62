"""Planetary gear between turbine and pump whose third shaft a brake holds back: the second degree of freedom."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.component import Effect
from ..core.errors import BadInput
from ..core.events import rk4_events
from ..core.friction import stick_friction, stick_guard, stick_mode, stick_switch
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OUT_OF_RANGE, bind, kernel, kernel_tuple
from ..core.variables import choice, output, parameter
from .driven_shaft import (
    DISSIPATION_OUT,
    DRIVING_OUT,
    LOAD,
    RATIO_OUT,
    SPEED_OUT,
    TURBINE_OUT,
    TURBINE_SPEED,
    Transmission,
    mesh_loss,
    shaft_acceleration,
    shaft_guard,
    shaft_mode,
    speed_ratio,
    switched_shaft,
)

SHAFTS = ("sun", "ring", "carrier")


class DryBrake(Effect):
    """Brake of the third shaft that holds it exactly until it slips: a fixed ratio with protection against overload."""

    explicit_only = True

    kinetic = parameter(10.0, "N.m", "torque while it slips; a choice of ours", low=0.0)
    static = parameter(10.0, "N.m", "torque at which it begins to slip; no less than the kinetic one", low=1e-9)


class CentrifugalBrake(Effect):
    """Brake of the third shaft whose torque grows with the square of its speed."""

    explicit_only = True

    coefficient = parameter(0.5, "N.m.s2/rad2", "torque per speed squared; a choice of ours", low=0.0)
    largest_speed = parameter(50.0, "rad/s", "speed of the third shaft beyond which a run fails; sets the stable step", low=1e-3)


class PlanetaryTransmission(Transmission):
    """Gear set without inertia: on one shaft the turbine, through a compliant one, on another the pump, on the third a brake.

        Willis     w_s + k w_r = (1 + k) w_c,        T_s : T_r : T_c = 1 : k : -(1 + k),        k = teeth of ring / teeth of sun

    With coefficients a = 1, k, -(1 + k) of sun, ring and carrier, indices i, o, 3 for turbine, pump and third shaft:

        theta' = w_t - w_i,  w_i = -(a_o w + a_3 w_3) / a_i,    T = K theta + c theta'
        J w' = -a_o/a_i T - T_load - b w,    J3 w_3' = -a_3/a_i T - b3 w_3 - T_brake

    While the pump stands, the third shaft turns: the turbine starts against the brake's torque alone, and what the brake takes
    is lost. A brake that holds makes a fixed ratio. Sun and ring as turbine and pump turn against each other; the pump's speed
    is counted in its own direction then. The driven shaft stands and never turns back as in `driven_shaft`.
    Source: R. Willis's relations, textbook; the arrangement and all defaults are ours.
    """

    title = "Planetary transmission with a braked third shaft"
    start_inputs = ("turbine_speed", "load_torque")
    guards_count = 2

    dry_brake = DryBrake
    centrifugal_brake = CentrifugalBrake

    turbine_on = choice("ring", SHAFTS, "shaft of the gear set that the turbine turns")
    pump_on = choice("carrier", SHAFTS, "shaft that turns the pump")
    teeth_ratio = parameter(3.0, "1", "k, teeth of the ring over teeth of the sun", low=1.0 + 1e-9)
    stiffness = parameter(2000.0, "N.m/rad", "stiffness of the shaft between turbine and gear set", low=1e-3)
    shaft_damping = parameter(5.0, "N.m.s/rad", "damping of that shaft", low=0.0)
    driven_inertia = parameter(0.5, "kg.m2", "moment of inertia of the driven shaft and what turns on it", low=1e-9)
    driven_damping = parameter(0.0, "N.m.s/rad", "viscous friction of the driven shaft", low=0.0)
    third_inertia = parameter(0.05, "kg.m2", "moment of inertia of the third shaft", low=1e-9)
    third_damping = parameter(5.0, "N.m.s/rad", "viscous brake of the third shaft", low=0.0)
    substep = parameter(2e-3, "s", "longest internal step", low=1e-9, high=1.0)

    driving_torque = output("N.m", "torque of the gear on the driven shaft", nominal=10.0, feedthrough=("turbine_speed",))
    dissipation = output("W", "power lost in shafts, gear and brake", nominal=10.0, feedthrough=("turbine_speed",))
    third_speed = output("rad/s", "speed of the third shaft")
    third_torque = output("N.m", "torque of the brake against the third shaft", nominal=10.0, feedthrough=("turbine_speed",))

    def kernel_arguments(self) -> tuple[Any, ...]:
        """The parameters with the gear's coefficients in the place of its arrangement."""
        p, e = self._declared_arguments()
        coefficients = [1.0, p.teeth_ratio, -(1.0 + p.teeth_ratio)]
        into, out = coefficients[p.turbine_on], coefficients[p.pump_on]
        third = coefficients[3 - p.turbine_on - p.pump_on]
        values = {f: getattr(p, f) for f in Gear._fields if f in p._fields}
        return Gear(torque_ratio=abs(out / into), third_ratio=-third / into, **values), e

    def initial_state(self) -> np.ndarray:
        """Twist, speeds of driven and third shaft, mode of the driven one and, with `dry_brake`, direction of its slipping.

        The shaft is relaxed and turns with the turbine, from which the third shaft's speed follows.
        """
        p, e = self.arguments
        start = self.parameters["start_speed"]
        third = (self.u[0, TURBINE_SPEED] - p.torque_ratio * start) / p.third_ratio
        mode = shaft_mode(start, 0.0, self.u[0, LOAD])
        return np.array([0.0, start, third, mode] + ([] if e.dry_brake is None else [stick_mode(third, 0.0, e.dry_brake.static)]))

    def _initialize(self, t: float) -> int:
        values: Any = self.parameters
        if values["turbine_on"] == values["pump_on"]:
            raise BadInput(self.name, f"turbine and pump on the {values['pump_on']}", "two different shafts of the gear set",
                           "Change turbine_on or pump_on.")
        if "dry_brake" in self.on and values["dry_brake.static"] < values["dry_brake.kinetic"]:
            raise BadInput(self.name, f"dry_brake.static = {values['dry_brake.static']:g} N.m",
                           f"at least the kinetic torque, {values['dry_brake.kinetic']:g} N.m", "Raise it.")
        return super()._initialize(t)

    def energy(self) -> float:
        """Energy of both shafts' rotation and of the twist, J."""
        p, (twist, speed, third) = self.arguments[0], self.x[:3]
        return 0.5 * float(p.stiffness * twist**2 + p.driven_inertia * speed**2 + p.third_inertia * third**2)

    def left_range(self) -> str:
        """The third shaft's speed and its limit."""
        limit = self.get("centrifugal_brake.largest_speed")
        return (f"turbine_speed = {self.get('turbine_speed'):g} rad/s turns the third shaft at {self.x[THIRD]:g} rad/s, "
                f"expected within -{limit:g} and {limit:g} rad/s (centrifugal_brake.largest_speed)")

    def stable_step(self) -> float:
        """RK4's limit, radius / max |eigenvalue| with the turbine's speed given, s."""
        p, e = self.kernel_arguments()
        b3, brake = p.third_damping, e.centrifugal_brake
        b3 += 2.0 * brake.coefficient * brake.largest_speed if brake is not None else 0.0
        ratios = np.array([p.torque_ratio, p.third_ratio])
        inertias = np.array([p.driven_inertia, p.third_inertia])
        speeds = -(p.shaft_damping * np.outer(ratios, ratios) + np.diag([p.driven_damping, b3])) / inertias[:, None]
        A = np.block([[np.zeros((1, 1)), -ratios[None, :]], [(p.stiffness * ratios / inertias)[:, None], speeds]])
        return RK4_STABILITY_RADIUS / float(np.abs(np.linalg.eigvals(A)).max())


@kernel_tuple
class Gear(NamedTuple):
    """Parameters for the kernels; w_turbine = torque_ratio * w + third_ratio * w_3, torques accordingly."""

    torque_ratio: float
    third_ratio: float
    stiffness: float
    shaft_damping: float
    driven_inertia: float
    driven_damping: float
    third_inertia: float
    third_damping: float


THIRD_OUT, BRAKE_OUT = PlanetaryTransmission.output_indices("third_speed", "third_torque")
TWIST, SPEED, THIRD, MODE, SLIP = 0, 1, 2, 3, 4


@kernel
def twist_rate(x, u, p):
    """Speed of the turbine over that of its shaft of the gear set, rad/s."""
    return u[TURBINE_SPEED] - p.torque_ratio * x[SPEED] - p.third_ratio * x[THIRD]


@kernel
def shaft_torque(x, u, p):
    """Torque of the compliant shaft on the gear set, N.m."""
    return p.stiffness * x[TWIST] + p.shaft_damping * twist_rate(x, u, p)


@kernel
def third_drive(x, u, p, centrifugal):
    """Torque on the third shaft, a dry brake apart, N.m."""
    torque = p.third_ratio * shaft_torque(x, u, p) - p.third_damping * x[THIRD]
    if centrifugal is not None:
        torque -= centrifugal.coefficient * x[THIRD] * abs(x[THIRD])
    return torque


@kernel
def gear_derivatives(t, x, u, dx, p, e):
    """dx/dt of x = (twist, speed of driven and of third shaft, mode[, direction of slipping])."""
    third = third_drive(x, u, p, e.centrifugal_brake)
    if e.dry_brake is not None:
        third -= stick_friction(x[SLIP], third, e.dry_brake.kinetic)
        dx[SLIP] = 0.0
    driving = p.torque_ratio * shaft_torque(x, u, p)
    dx[TWIST] = twist_rate(x, u, p)
    dx[SPEED] = shaft_acceleration(x[MODE], x[SPEED], driving, u[LOAD], p.driven_inertia, p.driven_damping)
    dx[THIRD] = third / p.third_inertia
    dx[MODE] = 0.0


@kernel
def gear_guards(t, x, u, g, p, e):
    """Those of the driven shaft and of the dry brake."""
    g[0] = shaft_guard(x[MODE], x[SPEED], p.torque_ratio * shaft_torque(x, u, p), u[LOAD])
    g[1] = 1.0
    if e.dry_brake is not None:
        g[1] = stick_guard(x[SLIP], x[THIRD], third_drive(x, u, p, e.centrifugal_brake), e.dry_brake.static)


@kernel
def gear_switch(which, t, x, u, p, e):
    """The driven shaft stops or starts, or the third one does."""
    if which == 0:
        x[SPEED] = 0.0
        x[MODE] = switched_shaft(x[MODE], p.torque_ratio * shaft_torque(x, u, p), u[LOAD])
    elif e.dry_brake is not None:
        x[THIRD] = 0.0
        x[SLIP] = stick_switch(x[SLIP], third_drive(x, u, p, e.centrifugal_brake), e.dry_brake.static)


@kernel
def gear_outputs(t, x, u, y, p, e):
    """Torques, speeds, ratio, power lost."""
    torque, rate = shaft_torque(x, u, p), twist_rate(x, u, p)
    loss = mesh_loss(torque, u[TURBINE_SPEED], e.mesh_friction)
    drive = third_drive(x, u, p, e.centrifugal_brake)
    brake = p.third_ratio * torque - drive
    if e.dry_brake is not None:
        brake += stick_friction(x[SLIP], drive, e.dry_brake.kinetic)
    y[TURBINE_OUT], y[SPEED_OUT], y[DRIVING_OUT] = torque + loss, x[SPEED], p.torque_ratio * torque
    y[RATIO_OUT] = speed_ratio(x[SPEED], u[TURBINE_SPEED])
    y[DISSIPATION_OUT] = (p.shaft_damping * rate * rate + p.driven_damping * x[SPEED] ** 2 + brake * x[THIRD]
                          + loss * u[TURBINE_SPEED])
    y[THIRD_OUT], y[BRAKE_OUT] = x[THIRD], brake


_advance = bind(rk4_events, __name__, derivatives=gear_derivatives, guards=gear_guards, switch=gear_switch, outputs=gear_outputs)


@kernel
def gear_advance(t, h, n, k, x, u, y, work, counts, p, e):
    """`rk4_events`, refused for a third shaft that is faster than the stable step allows for."""
    status = _advance(t, h, n, k, x, u, y, work, counts, p, e)
    if e.centrifugal_brake is not None and status == DONE and abs(x[THIRD]) > e.centrifugal_brake.largest_speed:
        return OUT_OF_RANGE
    return status


PlanetaryTransmission.advance = gear_advance
PlanetaryTransmission.output_kernel = gear_outputs
