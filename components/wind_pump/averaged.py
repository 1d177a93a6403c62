"""Inertial converter in the mean over a revolution of its crank: the torque it passes on, without crank, lever and clutches."""

from __future__ import annotations

import math

from ..core.events import event_kernels
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OUT_OF_RANGE, kernel
from ..core.variables import output, parameter
from .driven_shaft import (
    IN,
    OUT,
    Transmission,
    mesh_loss,
    shaft_acceleration,
    shaft_guard,
    shaft_mode,
    speed_ratio,
    switched_shaft,
)


class AveragedConverter(Transmission):
    """The mean torque of `InertialConverter` with rigid clutches, at the crank's speed w1 = n w_t and the driven shaft's w:

        T2 = k1 w1² - k2 w1 w,  T1 = n T2 w / w1 = n (k1 w1 - k2 w) w,  k1 = 2/pi rho m a b r,  k2 = 2/pi rho² (m b² + m_y)

    up to w = w1 k1 / k2, where the clutches no longer engage. a = 1 + b; the other letters as there. At stall it gives k1 w1²
    and takes nothing: a turbine starts against no load. Nothing is divided by a speed, so standstill of either side is an
    ordinary state; the driven shaft stands exactly while T2 is below the load, and never turns back (`driven_shaft`).
    It holds where the speeds change little within half a revolution of the crank. The mean inertia that crank and lever put on
    the turbine, n² (J1 + m a² r² / 2), belongs to the turbine's.
    Source: the mean is an own derivation, see `InertialConverter`, whose defaults these are.
    """

    title = "Inertial converter in the mean over a revolution"
    default_step = 5e-2
    start_inputs = ("turbine_speed", "load_torque")

    gear_ratio = parameter(6.0, "1", "speed of the crank over that of the turbine", low=1e-3)
    crank_radius = parameter(0.05, "m", "radius of the crank", low=1e-6)
    lever_ratio = parameter(1.0, "1", "b, arm from crank pin to mass over arm from slider to crank pin", low=1e-3)
    lever_mass = parameter(20.0, "kg", "mass at the free end of the lever", low=1e-9)
    slider_mass = parameter(0.25, "kg", "mass of the guided end of the lever", low=0.0)
    clutch_arm = parameter(0.05, "m", "arm at which the slider turns the clutches", low=1e-6)
    driven_inertia = parameter(1.0, "kg.m2", "moment of inertia of the driven shaft and what it turns", low=1e-9)
    driven_damping = parameter(0.0, "N.m.s/rad", "viscous friction of the driven shaft", low=0.0)
    largest_turbine_speed = parameter(50.0, "rad/s", "turbine speed beyond which a run fails; it sets the stable step", low=1e-3)
    substep = parameter(2e-2, "s", "longest internal step", low=1e-9, high=10.0)

    driving_torque = output(
        "N.m", "mean torque of the clutches on the driven shaft", nominal=10.0, feedthrough=("turbine_speed",)
    )
    dissipation = output("W", "power lost in bearings and gear", nominal=10.0, feedthrough=("turbine_speed",))

    def coefficients(self) -> tuple[float, float]:
        """(k1, k2) in kg m² of the mean torque k1 w1² - k2 w1 w."""
        return mean_coefficients(self._parameters()[0])

    def states(self) -> int:
        """Speed of the driven shaft, mode."""
        return 2

    def energy(self) -> float:
        """Energy of the driven shaft's rotation, J."""
        return 0.5 * self.arguments[1].driven_inertia * float(self.x[0]) ** 2

    def left_range(self) -> str:
        """The turbine's speed and its limit."""
        limit = self.get("largest_turbine_speed")
        return f"turbine_speed = {self.get('turbine_speed'):g} rad/s, expected within -{limit:g} and {limit:g} rad/s"


SPEED, MODE = 0, 1


@kernel
def mean_coefficients(p):
    """(k1, k2), kg m²."""
    share = 2.0 / math.pi * p.clutch_arm
    k1 = share * p.lever_mass * (1.0 + p.lever_ratio) * p.lever_ratio * p.crank_radius
    return k1, share * p.clutch_arm * (p.lever_mass * p.lever_ratio**2 + p.slider_mass)


@kernel
def mean_torques(speed, u, p):
    """(torque on the driven shaft, torque that brakes the turbine by it), N.m; turned backwards, a crank shakes as well."""
    k1, k2 = mean_coefficients(p)
    crank = p.gear_ratio * u[IN.turbine_speed]
    per_speed = max(k1 * abs(crank) - k2 * speed, 0.0)
    return per_speed * abs(crank), math.copysign(p.gear_ratio * per_speed * speed, crank)


@kernel
def averaged_start(t, s, p, e):
    """Speed of the driven shaft as given, and its mode."""
    driving, _ = mean_torques(p.start_speed, s.u[0], p)
    s.x[SPEED], s.x[MODE] = p.start_speed, shaft_mode(p.start_speed, driving, s.u[0, IN.load_torque])
    return DONE


@kernel
def averaged_stable(t, s, p, e):
    """RK4's limit, radius / |eigenvalue| at the largest turbine speed, s."""
    _, k2 = mean_coefficients(p)
    return RK4_STABILITY_RADIUS * p.driven_inertia / (k2 * p.gear_ratio * p.largest_turbine_speed + p.driven_damping)


@kernel
def averaged_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (speed of the driven shaft, mode)."""
    driving, _ = mean_torques(x[SPEED], u, p)
    dx[SPEED] = shaft_acceleration(x[MODE], x[SPEED], driving, u[IN.load_torque], p.driven_inertia, p.driven_damping)
    dx[MODE] = 0.0


@kernel
def averaged_guards(t, x, u, g, s, p, e):
    """That of the driven shaft."""
    driving, _ = mean_torques(x[SPEED], u, p)
    g[0] = shaft_guard(x[MODE], x[SPEED], driving, u[IN.load_torque])


@kernel
def averaged_switch(which, t, x, u, s, p, e):
    """The driven shaft stops or starts."""
    x[SPEED] = 0.0
    driving, _ = mean_torques(0.0, u, p)
    x[MODE] = switched_shaft(x[MODE], driving, u[IN.load_torque])


@kernel
def averaged_outputs(t, s, p, e):
    """Torques, speed, ratio, power lost."""
    x, u, y = s.x, s.u[0], s.y
    driving, on_turbine = mean_torques(x[SPEED], u, p)
    loss = mesh_loss(on_turbine, u[IN.turbine_speed], e.mesh_friction)
    y[OUT.turbine_torque], y[OUT.speed], y[OUT.driving_torque] = on_turbine + loss, x[SPEED], driving
    y[OUT.ratio] = speed_ratio(x[SPEED], u[IN.turbine_speed])
    y[OUT.dissipation] = p.driven_damping * x[SPEED] ** 2 + loss * u[IN.turbine_speed]
    return DONE


_events = event_kernels(
    __name__,
    start=averaged_start,
    stable=averaged_stable,
    derivatives=averaged_derivatives,
    guards=averaged_guards,
    switch=averaged_switch,
    outputs=averaged_outputs,
)
_step = _events.step


@kernel
def averaged_step(t, h, s, p, e):
    """A step with events, refused for a turbine that is faster than the stable step allows for."""
    status = _step(t, h, s, p, e)
    if status == DONE and not abs(s.u[0, IN.turbine_speed]) <= p.largest_turbine_speed:  # also where it is no number
        return OUT_OF_RANGE
    return status


AveragedConverter.kernels = _events._replace(step=averaged_step)
