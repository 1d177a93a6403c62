"""Piston pump on a crank: torque and flow at the present angle."""

from __future__ import annotations

import math

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.integrators import OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import choice, input_, output, parameter

ACTIONS = ("single", "double")
DOUBLE = 1
TURN = 2.0 * math.pi
ROD_WITHOUT_USE, ROD_TOO_THICK = OWN + 1, OWN + 2


class Leakage(Effect):
    """Water that slips past valves and seals: a share of the flow, for which the piston works all the same."""

    share = parameter(0.05, "1", "lost share of the flow; a choice of ours", low=0.0, high=1.0)


class SealFriction(Effect):
    """Dry friction of the piston's seals: a force against the piston, whichever way it goes."""

    force = parameter(100.0, "N", "friction force at the piston; a choice of ours", low=0.0)


class Averaged(Effect):
    """Torque and flow in the mean over a turn: for long runs and flywheels that do not feel the strokes."""

    explicit_only = True


class PistonPump(OdeComponent):
    """Pump with a piston of area A on a crank of radius r = stroke / 2 and a long rod; phi is the crank's angle.

        single    T = rho g H A r max(sin phi, 0)        q = A r max(sin phi, 0) phi'
        double    T = rho g H A r |sin phi|              q = A r |sin phi| phi'

    With the rod of a double-acting pump on one side, that side has the rod's area less. So T phi' = rho g H q at every instant;
    the single-acting pump's largest torque is pi times its mean, rho g H V / (2 pi), V = A stroke.
    The pump has no inertia. Its torque is the one that turns it forwards from the present angle, also at standstill; the
    driven shaft of a transmission stands below it. It does not turn backwards: a negative speed counts as standstill.
    """

    title = "Piston pump"
    system = "wind_pump"
    start_inputs = ()
    default_step = 1e-2
    default_stop = 20.0

    leakage = Leakage
    seal_friction = SealFriction
    averaged = Averaged

    action = choice("single", ACTIONS, "strokes that deliver: one of two, or both")
    diameter = parameter(0.06, "m", "diameter of the piston", low=1e-4)
    stroke = parameter(0.15, "m", "stroke of the piston", low=1e-4)
    rod_diameter = parameter(0.0, "m", "diameter of the rod, in the return stroke of a double-acting pump", low=0.0)
    density = parameter(1000.0, "kg/m3", "density of the water", low=1e-6)
    gravity = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0)
    start_angle = parameter(0.0, "rad", "angle of the crank at the start; delivery begins at 0")
    substep = parameter(5e-3, "s", "longest internal step", low=1e-9, high=10.0)

    speed = input_(0.0, "rad/s", "speed of the crank")
    head = input_(20.0, "m", "head against which it delivers", nominal=10.0)

    torque = output("N.m", "torque that it takes to turn it forwards", nominal=10.0, feedthrough=("head",))
    flow = output("m3/s", "flow delivered", nominal=1e-3, feedthrough=("speed",))
    angle = output("rad", "angle of the crank, in [0, 2 pi)")
    hydraulic_power = output("W", "power given to the water that is delivered", nominal=10.0, feedthrough=("speed", "head"))

    presets = {
        "60 x 150 mm": Preset(
            {"diameter": 0.06, "stroke": 0.15},
            "size chosen for an example: 0.424 l per stroke, 13.2 N m in the mean at 20 m",
            "computed",
        )
    }

    refusals = {
        ROD_WITHOUT_USE: Refusal(
            "rod_diameter = {rod_diameter} m with action 'single'",
            "a double-acting pump",
            "In a single-acting one the rod changes nothing.",
        ),
        ROD_TOO_THICK: Refusal("rod_diameter = {rod_diameter} m", "less than the piston's {diameter} m"),
    }

    def states(self) -> int:
        """The crank's angle."""
        return 1


IN = PistonPump.input_places()
OUT = PistonPump.output_places()


@kernel
def volume_rate(angle, p, averaged):
    """Water moved per angle of the crank, m³/rad."""
    forth = 0.25 * math.pi * p.diameter**2
    back = forth - 0.25 * math.pi * p.rod_diameter**2 if p.action == DOUBLE else 0.0
    if averaged is not None:
        return (forth + back) * 0.5 * p.stroke / math.pi
    lift = math.sin(angle)
    return (forth if lift >= 0.0 else back) * 0.5 * p.stroke * abs(lift)


@kernel
def piston_rate(angle, averaged):
    """Speed of the piston over that of the crank pin."""
    if averaged is not None:
        return 2.0 / math.pi
    return abs(math.sin(angle))


@kernel
def pump_start(t, s, p, e):
    """The crank's angle."""
    if p.rod_diameter > 0.0 and p.action != DOUBLE:
        return ROD_WITHOUT_USE
    if p.rod_diameter >= p.diameter:
        return ROD_TOO_THICK
    s.x[0] = p.start_angle
    return DONE


@kernel
def pump_stable(t, s, p, e):
    """Any step: the speed is given."""
    return math.inf


@kernel
def pump_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (angle)."""
    dx[0] = max(u[IN.speed], 0.0)


@kernel
def pump_outputs(t, s, p, e):
    """Torque, flow, angle and power."""
    x, u, y = s.x, s.u[0], s.y
    moved, weight = volume_rate(x[0], p, e.averaged), p.density * p.gravity
    torque = weight * u[IN.head] * moved
    if e.seal_friction is not None:
        torque += e.seal_friction.force * 0.5 * p.stroke * piston_rate(x[0], e.averaged)
    flow = moved * max(u[IN.speed], 0.0)
    if e.leakage is not None:
        flow *= 1.0 - e.leakage.share
    y[OUT.torque], y[OUT.flow], y[OUT.hydraulic_power] = torque, flow, weight * u[IN.head] * flow
    wrapped = x[0] % TURN
    y[OUT.angle] = wrapped if wrapped < TURN else 0.0  # rounding of a small negative angle
    return DONE


PistonPump.kernels = ode_kernels(
    __name__, start=pump_start, stable=pump_stable, derivatives=pump_derivatives, outputs=pump_outputs
)
