"""Inertial converter: a crank shakes a floating lever, whose inertia pushes a driven shaft on through two one-way clutches.

The faster the crank and the slower the driven shaft, the more torque; the ratio adjusts itself to the load. A wind turbine
starts against no load, and no start wind has to overcome the peak of a piston pump.

The clutches engage at equal speeds, without impact, and let go as their force vanishes: up to four such instants a revolution of
the crank. The driven shaft stands exactly where the lever cannot overcome the load, and never turns back. These are events
(`core/events.py`), and with them the clutches are rigid. With `compliant_clutches` they slip in proportion to their torque
instead, which real ones do, and which costs: with the default coefficient a substep of 25 us instead of 2 ms.

The macro step is bounded by the input shaft. Measured with the defaults behind a turbine of 15 kg m², inputs extrapolated
linearly: the largest torque on the turbine is right to 3 % up to 8 ms, and 19 % too large with 9 ms.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Effect
from ..core.events import event_kernels
from ..core.integrators import RK4_STABILITY_RADIUS, SUBSTEP
from ..core.kernels import DONE, OUT_OF_RANGE, kernel
from ..core.spectrum import fastest_rate
from ..core.variables import count, input_, output, parameter
from .driven_shaft import (
    IN,
    STANDING,
    TURNING,
    Transmission,
    mesh_loss,
    shaft_acceleration,
    shaft_guard,
    speed_ratio,
    switched_shaft,
)
from .lever import engaged_lever, free_lever, joint_forces, locked_lever

TWIST, ANGLE, RATE, SLIDER, VELOCITY, SPEED, MODE = range(7)  # of the state
FREE = 2.0  # a mode besides STANDING; 1 and -1: engaged, driven by a slider that moves up or down
SEPARATED = 1.0 - 1e-12  # speed of a slider that has just let go, over that at which it would engage: beyond rounding
STARTED = 1e-12  # rad/s of a shaft that has just begun to turn
MOST_TURN = 0.3  # rad of the crank in a substep; 21 substeps a revolution


class CompliantClutches(Effect):
    """Clutches that slip while they drive: torque = damping * (speed of the slider at the arm - speed of the shaft).

    They let go late by the angle w1 tau of the crank, tau = rho² (m b² + m_y) / damping. The mean torque falls by no more than
    k1 w1² (w1 tau)² / 2: less than 1e-4 of the stall torque with the defaults, up to a crank of 500 rad/s.
    """

    damping = parameter(2e3, "N.m.s/rad", "torque per slip of a clutch that drives", low=1.0)
    substep = parameter(2.5e-5, "s", "longest internal step while the clutches slip", low=1e-9, high=1.0)


class Stresses(Effect):
    """Joint forces, and the nominal stresses of both shafts, the lever and its pins; signed, so that their ranges show."""

    explicit_only = True

    shaft_diameter = parameter(0.03, "m", "diameter of the input shaft", low=1e-6)
    driven_shaft_diameter = parameter(0.03, "m", "diameter of the driven shaft", low=1e-6)
    lever_arm = parameter(0.4, "m", "distance from the slider to the crank pin along the lever", low=1e-6)
    lever_width = parameter(0.02, "m", "width of the lever's rectangular section at the crank pin", low=1e-6)
    lever_height = parameter(0.05, "m", "height of that section, in the plane of motion", low=1e-6)
    pin_diameter = parameter(0.02, "m", "diameter of the pins, in single shear", low=1e-6)

    crank_pin_force = output(
        "N", "force of the crank pin across the lever", nominal=100.0, feedthrough=("turbine_speed", "load_torque")
    )
    mass_pin_force = output("N", "force of the lever on the mass", nominal=100.0, feedthrough=("turbine_speed", "load_torque"))
    slider_pin_force = output(
        "N", "force of the lever on the slider", nominal=100.0, feedthrough=("turbine_speed", "load_torque")
    )
    shaft_stress = output("Pa", "shear stress of the input shaft's torsion", nominal=1e6, feedthrough=("turbine_speed",))
    driven_shaft_stress = output(
        "Pa",
        "shear stress of the driven shaft's torsion by the clutches",
        nominal=1e6,
        feedthrough=("turbine_speed", "load_torque"),
    )
    lever_stress = output(
        "Pa", "bending stress of the lever at the crank pin", nominal=1e6, feedthrough=("turbine_speed", "load_torque")
    )
    pin_stress = output("Pa", "mean shear stress of the crank pin", nominal=1e6, feedthrough=("turbine_speed", "load_torque"))
    lever_angle = output("rad", "angle of the lever, which the equations take as small", nominal=0.1)


class InertialConverter(Transmission):
    """Transmission with an oscillating lever and two opposed one-way clutches, in full.

    The turbine's speed w_t turns the crank through a gear of ratio n and a compliant shaft, T = k theta + c theta',
    theta' = n w_t - phi'. The equations of crank and lever are those of `lever.py`; the driven shaft has

        J2 w' = rho |F| - T_load,    w >= |y'| / rho,    F y' >= 0,    w >= 0.

    Each of the modes has equations of its own: lever free (F = 0), engaged (y' = ± rho w), standing (w = y' = 0).
    In the mean over a revolution, at constant speeds w1 = n w_t and w:

        rho |F| = k1 w1² - k2 w1 w,  k1 = 2/pi rho m a b r,  k2 = 2/pi rho² (m b² + m_y)

    Source: after Scutaru and Mitrica, Mathematical Problems in Engineering 2016, 3821083, a wind pump with a transmission of
    two degrees of freedom whose ratio adjusts itself; its drawing and its numbers are not in what we could read. That it is of
    G. Constantinesco's inertial kind, the equations and all defaults are ours.
    """

    title = "Inertial converter with a floating lever and one-way clutches"
    start_inputs = ("turbine_speed",)
    default_stop = 10.0
    guards_count = 2

    compliant_clutches = CompliantClutches
    stresses = Stresses

    gear_ratio = parameter(6.0, "1", "speed of the crank over that of the turbine", low=1e-3)
    shaft_stiffness = parameter(1e4, "N.m/rad", "stiffness of the shaft between gear and crank", low=1e-3)
    shaft_damping = parameter(30.0, "N.m.s/rad", "damping of that shaft", low=0.0)
    crank_inertia = parameter(1.0, "kg.m2", "moment of inertia of the crank", low=1e-9)
    crank_radius = parameter(0.05, "m", "radius of the crank", low=1e-6)
    lever_ratio = parameter(1.0, "1", "b, arm from crank pin to mass over arm from slider to crank pin", low=1e-3)
    lever_mass = parameter(20.0, "kg", "mass at the free end of the lever", low=1e-9)
    slider_mass = parameter(0.25, "kg", "mass of the guided end of the lever", low=0.0)
    clutch_arm = parameter(0.05, "m", "arm at which the slider turns the clutches", low=1e-6)
    driven_inertia = parameter(1.0, "kg.m2", "moment of inertia of the driven shaft and what it turns", low=1e-9)
    start_angle = parameter(0.0, "rad", "angle of the crank at the start")
    substep = parameter(2e-3, "s", "longest internal step; the crank may turn 0.3 rad in it", low=1e-9, high=1.0)

    turbine_speed = input_(0.0, "rad/s", "speed of the turbine", nominal=3.0)

    turbine_torque = output("N.m", "torque that brakes the turbine", nominal=100.0, feedthrough=("turbine_speed",))
    speed = output("rad/s", "speed of the driven shaft", nominal=3.0)
    driving_torque = output(
        "N.m", "torque of the clutches on the driven shaft", nominal=10.0, feedthrough=("turbine_speed", "load_torque")
    )
    dissipation = output(
        "W",
        "power lost in the gear, in the input shaft's damping and in slipping clutches",
        nominal=10.0,
        feedthrough=("turbine_speed",),
    )
    crank_speed = output("rad/s", "speed of the crank", nominal=20.0)
    crank_angle = output("rad", "angle of the crank since time 0", nominal=10.0)
    slider_velocity = output("m/s", "velocity of the lever's guided end", nominal=0.1)
    engaged = count(
        "the clutch that drives or, on a standing shaft, pushes: 1, -1, or 0 for none",
        feedthrough=("turbine_speed", "load_torque"),
    )

    def states(self) -> int:
        """Twist, angle and speed of the crank, place and velocity of the slider, speed of the driven shaft, mode."""
        return 7

    def energy(self) -> float:
        """Energy of motion and of the input shaft's twist, J."""
        p = self.arguments[1]
        twist, angle, rate, _, velocity, speed, _ = self.x
        mass_velocity = (1.0 + p.lever_ratio) * p.crank_radius * math.cos(angle) * rate - p.lever_ratio * velocity
        return 0.5 * float(
            p.shaft_stiffness * twist**2
            + p.crank_inertia * rate**2
            + p.lever_mass * mass_velocity**2
            + p.slider_mass * velocity**2
            + p.driven_inertia * speed**2
        )

    def left_range(self) -> str:
        """The crank's speed and how fast it may turn for the internal step."""
        substep = self.arguments[0].limits[SUBSTEP]
        limit = MOST_TURN / substep
        return (
            f"turbine_speed = {self.get('turbine_speed'):g} rad/s turns the crank at {self.x[RATE]:.4g} rad/s, expected "
            f"within -{limit:.4g} and {limit:.4g} rad/s for internal steps of {substep:g} s"
        )


OUT = InertialConverter.output_places()


@kernel
def shaft_torque(x, u, p):
    """Torque of the input shaft on the crank, N.m."""
    return p.shaft_stiffness * x[TWIST] + p.shaft_damping * (p.gear_ratio * u[IN.turbine_speed] - x[RATE])


@kernel
def clutch_force(velocity, speed, p, clutches):
    """Force of clutches that slip, against the slider, N."""
    slip = abs(velocity) / p.clutch_arm - speed
    if slip <= 0.0:
        return 0.0
    return math.copysign(clutches.damping * slip / p.clutch_arm, velocity)


@kernel
def accelerations(x, u, p, clutches):
    """(phi'', y'', w', F) in the present mode."""
    torque, load = shaft_torque(x, u, p), u[IN.load_torque]
    if clutches is not None:
        force = clutch_force(x[VELOCITY], x[SPEED], p, clutches)
        crank, slider = free_lever(x[ANGLE], x[RATE], torque, force, p)
        driving = p.clutch_arm * abs(force)
        return crank, slider, shaft_acceleration(x[MODE], x[SPEED], driving, load, p.driven_inertia, 0.0), force
    if x[MODE] == FREE:
        crank, slider = free_lever(x[ANGLE], x[RATE], torque, 0.0, p)
        return crank, slider, -load / p.driven_inertia, 0.0
    if x[MODE] == STANDING:
        crank, force = locked_lever(x[ANGLE], x[RATE], torque, p)
        return crank, 0.0, 0.0, force
    crank, slider, force = engaged_lever(x[ANGLE], x[RATE], torque, x[MODE], load, p)
    return crank, slider, x[MODE] * slider / p.clutch_arm, force


@kernel
def converter_start(t, s, p, e):
    """The crank turns with the turbine, the lever's guided end is at rest, the shaft between them is relaxed."""
    x = s.x
    x[ANGLE], x[RATE], x[SPEED] = p.start_angle, p.gear_ratio * s.u[0, IN.turbine_speed], p.start_speed
    x[MODE] = STANDING if p.start_speed == 0.0 else FREE  # what does not last is left at the begin of the first substep
    if e.compliant_clutches is not None:
        if p.start_speed > 0.0:
            x[MODE] = TURNING
        s.limits[SUBSTEP] = min(p.substep, e.compliant_clutches.substep)
    return DONE


@kernel
def converter_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| of the shaft on the crank alone and, where they slip, of the clutches, s."""
    fastest = fastest_rate(p.crank_inertia, p.shaft_damping, p.shaft_stiffness)
    if e.compliant_clutches is not None:
        slider = p.lever_mass * p.lever_ratio**2 + p.slider_mass
        carried = p.lever_mass * (1.0 + p.lever_ratio) * p.crank_radius
        lightest = slider - (p.lever_ratio * carried) ** 2 / (p.crank_inertia + carried * (1.0 + p.lever_ratio) * p.crank_radius)
        slip = e.compliant_clutches.damping * (1.0 / (p.clutch_arm**2 * lightest) + 1.0 / p.driven_inertia)
        fastest += slip  # no less than the largest eigenvalue of both together
    return RK4_STABILITY_RADIUS / fastest


@kernel
def converter_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (theta, phi, phi', y, y', w, mode)."""
    dx[TWIST] = p.gear_ratio * u[IN.turbine_speed] - x[RATE]
    dx[ANGLE], dx[SLIDER], dx[MODE] = x[RATE], x[VELOCITY], 0.0
    dx[RATE], dx[VELOCITY], dx[SPEED], _ = accelerations(x, u, p, e.compliant_clutches)


@kernel
def converter_guards(t, x, u, g, s, p, e):
    """Free: distance from either clutch. Engaged: force and speed. Standing: the rest of the load."""
    _, _, _, force = accelerations(x, u, p, e.compliant_clutches)
    if e.compliant_clutches is not None or x[MODE] == STANDING:
        g[0] = g[1] = shaft_guard(x[MODE], x[SPEED], p.clutch_arm * abs(force), u[IN.load_torque])
    elif x[MODE] == FREE:
        g[0], g[1] = p.clutch_arm * x[SPEED] - x[VELOCITY], p.clutch_arm * x[SPEED] + x[VELOCITY]
    else:
        g[0], g[1] = x[MODE] * force, x[SPEED]


@kernel
def converter_switch(which, t, x, u, s, p, e):
    """The next mode; speeds that are equal in it are made so."""
    if e.compliant_clutches is not None:
        driving = p.clutch_arm * abs(clutch_force(x[VELOCITY], 0.0, p, e.compliant_clutches))
        x[SPEED] = 0.0
        x[MODE] = switched_shaft(x[MODE], driving, u[IN.load_torque])
    elif x[MODE] == STANDING:
        torque = shaft_torque(x, u, p)
        _, slider = free_lever(x[ANGLE], x[RATE], torque, 0.0, p)
        x[SPEED] = STARTED
        if p.clutch_arm * -u[IN.load_torque] / p.driven_inertia > abs(
            slider
        ):  # driven from outside faster than the lever follows
            x[MODE] = FREE
        else:
            x[MODE] = math.copysign(1.0, slider)
            x[VELOCITY] = x[MODE] * p.clutch_arm * STARTED
    elif x[MODE] == FREE:
        x[MODE] = 1.0 if which == 0 else -1.0
        x[VELOCITY] = x[MODE] * p.clutch_arm * x[SPEED]
    elif which == 0:
        x[VELOCITY] = SEPARATED * x[MODE] * p.clutch_arm * x[SPEED]
        x[MODE] = FREE
    else:
        x[SPEED] = x[VELOCITY] = 0.0
        x[MODE] = STANDING


@kernel
def converter_outputs(t, s, p, e):
    """Torques, speeds and losses; joint forces and stresses where they are on."""
    x, u, y = s.x, s.u[0], s.y
    torque = shaft_torque(x, u, p)
    crank, slider, _, force = accelerations(x, u, p, e.compliant_clutches)
    driving = p.clutch_arm * abs(force)
    loss = mesh_loss(p.gear_ratio * torque, u[IN.turbine_speed], e.mesh_friction)
    y[OUT.turbine_torque], y[OUT.speed], y[OUT.driving_torque] = p.gear_ratio * torque + loss, x[SPEED], driving
    y[OUT.ratio] = speed_ratio(x[SPEED], u[IN.turbine_speed])
    slip = p.gear_ratio * u[IN.turbine_speed] - x[RATE]
    y[OUT.dissipation] = p.shaft_damping * slip * slip + loss * u[IN.turbine_speed]
    if e.compliant_clutches is not None:
        y[OUT.dissipation] += driving * (abs(x[VELOCITY]) / p.clutch_arm - x[SPEED])
    y[OUT.crank_speed], y[OUT.crank_angle], y[OUT.slider_velocity], y[OUT.engaged] = (
        x[RATE],
        x[ANGLE],
        x[VELOCITY],
        float(np.sign(force)),
    )
    if e.stresses is not None:
        k = e.stresses.y
        on_lever, on_mass, on_slider = joint_forces(x[ANGLE], x[RATE], crank, slider, p)
        y[k], y[k + 1], y[k + 2] = on_lever, on_mass, on_slider
        y[k + 3] = 16.0 * torque / (math.pi * e.stresses.shaft_diameter**3)
        y[k + 4] = 16.0 * driving / (math.pi * e.stresses.driven_shaft_diameter**3)
        bending = on_mass * p.lever_ratio * e.stresses.lever_arm
        y[k + 5] = 6.0 * bending / (e.stresses.lever_width * e.stresses.lever_height**2)
        y[k + 6] = 4.0 * on_lever / (math.pi * e.stresses.pin_diameter**2)
        y[k + 7] = (p.crank_radius * math.sin(x[ANGLE]) - x[SLIDER]) / e.stresses.lever_arm
    return DONE


_events = event_kernels(
    __name__,
    start=converter_start,
    stable=converter_stable,
    derivatives=converter_derivatives,
    guards=converter_guards,
    switch=converter_switch,
    outputs=converter_outputs,
)
_step = _events.step


@kernel
def converter_step(t, h, s, p, e):
    """A step with events, refused where its substeps do not resolve the crank's revolution."""
    status = _step(t, h, s, p, e)
    if status == DONE and abs(s.x[RATE]) * h > MOST_TURN * max(1, math.ceil(h / s.limits[SUBSTEP] * (1.0 - 1e-9))):
        return OUT_OF_RANGE
    return status


InertialConverter.kernels = _events._replace(step=converter_step)
