"""Planetary gear between turbine and pump whose third shaft a brake holds back: the second degree of freedom."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.errors import BadInput
from ..core.events import event_kernels
from ..core.friction import stick_friction, stick_guard, stick_mode, stick_switch
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OUT_OF_RANGE, OWN, kernel, kernel_tuple
from ..core.spectrum import spectral_radius
from ..core.variables import choice, output, parameter
from .driven_shaft import IN, Transmission, mesh_loss, shaft_acceleration, shaft_guard, shaft_mode, speed_ratio, switched_shaft

SHAFTS = ("sun", "ring", "carrier")
STATIC_BELOW_KINETIC = OWN + 1


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

        Willis     w_s + k w_r = (1 + k) w_c,        T_s : T_r : T_c = 1 : k : -(1 + k),        k = (teeth of ring) / (teeth of sun)

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

    refusals = {
        STATIC_BELOW_KINETIC: Refusal(
            "dry_brake.static = {dry_brake.static} N.m", "at least the kinetic torque, {dry_brake.kinetic} N.m", "Raise it."
        )
    }

    def states(self) -> int:
        """Twist, speeds of driven and third shaft, mode of the driven one and, with `dry_brake`, direction of its slipping."""
        return 5 if "dry_brake" in self.on else 4

    def shapes(self) -> dict[str, Any]:
        """`ratios`: see `Ratios`.  `matrix`: of the linear equations, and workspace."""
        if self.parameters["turbine_on"] == self.parameters["pump_on"]:
            raise BadInput(
                self.name,
                f"turbine and pump on the {self.parameters['turbine_on']}",
                "two different shafts of the gear set",
                "Change turbine_on or pump_on.",
            )
        return super().shapes() | {"ratios": Ratios, "matrix": (2, 3, 3)}

    def energy(self) -> float:
        """Energy of both shafts' rotation and of the twist, J."""
        p, (twist, speed, third) = self.arguments[1], self.x[:3]
        return 0.5 * float(p.stiffness * twist**2 + p.driven_inertia * speed**2 + p.third_inertia * third**2)

    def left_range(self) -> str:
        """The third shaft's speed and its limit."""
        limit = self.get("centrifugal_brake.largest_speed")
        return (
            f"turbine_speed = {self.get('turbine_speed'):g} rad/s turns the third shaft at {self.x[THIRD]:g} rad/s, "
            f"expected within -{limit:g} and {limit:g} rad/s (centrifugal_brake.largest_speed)"
        )


class Ratios:
    """The record `s.ratios`: w_turbine = driven * w + third * w_3."""

    driven: float
    third: float


@kernel_tuple
class Gear(NamedTuple):
    """w_turbine = torque_ratio * w + third_ratio * w_3, torques accordingly; and the shaft between turbine and gear set."""

    torque_ratio: float
    third_ratio: float
    stiffness: float
    shaft_damping: float


OUT = PlanetaryTransmission.output_places()
TWIST, SPEED, THIRD, MODE, SLIP = 0, 1, 2, 3, 4


@kernel
def coefficient(shaft, k):
    """Of a shaft of the gear set, sun, ring or carrier, in Willis's relation."""
    return 1.0 if shaft == 0 else k if shaft == 1 else -(1.0 + k)


@kernel
def gear_of(s, p):
    """The gear set in its arrangement."""
    return Gear(s.ratios.driven, s.ratios.third, p.stiffness, p.shaft_damping)


@kernel
def twist_rate(x, u, gear):
    """Speed of the turbine over that of its shaft of the gear set, rad/s."""
    return u[IN.turbine_speed] - gear.torque_ratio * x[SPEED] - gear.third_ratio * x[THIRD]


@kernel
def shaft_torque(x, u, gear):
    """Torque of the compliant shaft on the gear set, N.m."""
    return gear.stiffness * x[TWIST] + gear.shaft_damping * twist_rate(x, u, gear)


@kernel
def third_drive(x, u, gear, damping, centrifugal):
    """Torque on the third shaft, a dry brake apart, N.m."""
    torque = gear.third_ratio * shaft_torque(x, u, gear) - damping * x[THIRD]
    if centrifugal is not None:
        torque -= centrifugal.coefficient * x[THIRD] * abs(x[THIRD])
    return torque


@kernel
def gear_start(t, s, p, e):
    """The shaft is relaxed and turns with the turbine, from which the third shaft's speed follows."""
    if e.dry_brake is not None and e.dry_brake.static < e.dry_brake.kinetic:
        return STATIC_BELOW_KINETIC
    into, out = coefficient(p.turbine_on, p.teeth_ratio), coefficient(p.pump_on, p.teeth_ratio)
    s.ratios.driven, s.ratios.third = abs(out / into), -coefficient(3 - p.turbine_on - p.pump_on, p.teeth_ratio) / into
    third = (s.u[0, IN.turbine_speed] - s.ratios.driven * p.start_speed) / s.ratios.third
    s.x[SPEED], s.x[THIRD], s.x[MODE] = p.start_speed, third, shaft_mode(p.start_speed, 0.0, s.u[0, IN.load_torque])
    if e.dry_brake is not None:
        s.x[SLIP] = stick_mode(third, 0.0, e.dry_brake.static)
    return DONE


@kernel
def gear_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| with the turbine's speed given, s."""
    b3 = p.third_damping
    if e.centrifugal_brake is not None:
        b3 += 2.0 * e.centrifugal_brake.coefficient * e.centrifugal_brake.largest_speed
    A, ratios = s.matrix[0], (s.ratios.driven, s.ratios.third)
    A[0, 0] = 0.0
    for i in range(2):
        inertia, damping = (p.driven_inertia, p.driven_damping) if i == 0 else (p.third_inertia, b3)
        A[0, i + 1] = -ratios[i]
        A[i + 1, 0] = p.stiffness * ratios[i] / inertia
        for j in range(2):
            A[i + 1, j + 1] = -(p.shaft_damping * ratios[i] * ratios[j] + (damping if i == j else 0.0)) / inertia
    return RK4_STABILITY_RADIUS / spectral_radius(A, s.matrix[1])


@kernel
def gear_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (twist, speed of driven and of third shaft, mode[, direction of slipping])."""
    gear = gear_of(s, p)
    third = third_drive(x, u, gear, p.third_damping, e.centrifugal_brake)
    if e.dry_brake is not None:
        third -= stick_friction(x[SLIP], third, e.dry_brake.kinetic)
        dx[SLIP] = 0.0
    driving = gear.torque_ratio * shaft_torque(x, u, gear)
    dx[TWIST] = twist_rate(x, u, gear)
    dx[SPEED] = shaft_acceleration(x[MODE], x[SPEED], driving, u[IN.load_torque], p.driven_inertia, p.driven_damping)
    dx[THIRD] = third / p.third_inertia
    dx[MODE] = 0.0


@kernel
def gear_guards(t, x, u, g, s, p, e):
    """Those of the driven shaft and of the dry brake."""
    gear = gear_of(s, p)
    g[0] = shaft_guard(x[MODE], x[SPEED], gear.torque_ratio * shaft_torque(x, u, gear), u[IN.load_torque])
    g[1] = 1.0
    if e.dry_brake is not None:
        g[1] = stick_guard(x[SLIP], x[THIRD], third_drive(x, u, gear, p.third_damping, e.centrifugal_brake), e.dry_brake.static)


@kernel
def gear_switch(which, t, x, u, s, p, e):
    """The driven shaft stops or starts, or the third one does."""
    gear = gear_of(s, p)
    if which == 0:
        x[SPEED] = 0.0
        x[MODE] = switched_shaft(x[MODE], gear.torque_ratio * shaft_torque(x, u, gear), u[IN.load_torque])
    elif e.dry_brake is not None:
        x[THIRD] = 0.0
        x[SLIP] = stick_switch(x[SLIP], third_drive(x, u, gear, p.third_damping, e.centrifugal_brake), e.dry_brake.static)


@kernel
def gear_outputs(t, s, p, e):
    """Torques, speeds, ratio, power lost."""
    x, u, y, gear = s.x, s.u[0], s.y, gear_of(s, p)
    torque, rate = shaft_torque(x, u, gear), twist_rate(x, u, gear)
    loss = mesh_loss(torque, u[IN.turbine_speed], e.mesh_friction)
    drive = third_drive(x, u, gear, p.third_damping, e.centrifugal_brake)
    brake = gear.third_ratio * torque - drive
    if e.dry_brake is not None:
        brake += stick_friction(x[SLIP], drive, e.dry_brake.kinetic)
    y[OUT.turbine_torque], y[OUT.speed], y[OUT.driving_torque] = torque + loss, x[SPEED], gear.torque_ratio * torque
    y[OUT.ratio] = speed_ratio(x[SPEED], u[IN.turbine_speed])
    y[OUT.dissipation] = (
        p.shaft_damping * rate * rate + p.driven_damping * x[SPEED] ** 2 + brake * x[THIRD] + loss * u[IN.turbine_speed]
    )
    y[OUT.third_speed], y[OUT.third_torque] = x[THIRD], brake
    return DONE


_events = event_kernels(
    __name__,
    start=gear_start,
    stable=gear_stable,
    derivatives=gear_derivatives,
    guards=gear_guards,
    switch=gear_switch,
    outputs=gear_outputs,
)
_step = _events.step


@kernel
def gear_step(t, h, s, p, e):
    """A step with events, refused for a third shaft that is faster than the stable step allows for."""
    status = _step(t, h, s, p, e)
    if e.centrifugal_brake is not None and status == DONE and abs(s.x[THIRD]) > e.centrifugal_brake.largest_speed:
        return OUT_OF_RANGE
    return status


PlanetaryTransmission.kernels = _events._replace(step=gear_step)
