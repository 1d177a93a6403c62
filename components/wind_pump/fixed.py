"""Gear of fixed ratio with a compliant shaft, between turbine and pump."""

from __future__ import annotations

from ..core.events import event_kernels
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, kernel
from ..core.spectrum import fastest_rate
from ..core.variables import parameter
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


class FixedTransmission(Transmission):
    """Gear of ratio i = pump speed / turbine speed, a compliant shaft behind it, and the driven shaft with what turns on it.

        theta' = i w_t - w,    T = k theta + c theta',    T1 = i T,    J w' = T - T_load - b w

    The driven shaft stands exactly while T is below T_load, and never turns back; see `driven_shaft`. The gear itself has no
    inertia: add it to the turbine's, i² times what sits behind it. Defaults are choices of ours.
    """

    title = "Transmission of fixed ratio with a compliant shaft"
    start_inputs = ("turbine_speed", "load_torque")

    gear_ratio = parameter(1.0, "1", "speed of the pump over that of the turbine", low=1e-3)
    stiffness = parameter(2000.0, "N.m/rad", "stiffness of the shaft", low=1e-3)
    shaft_damping = parameter(5.0, "N.m.s/rad", "damping of the shaft", low=0.0)
    driven_inertia = parameter(0.5, "kg.m2", "moment of inertia of the driven shaft and what turns on it", low=1e-9)
    driven_damping = parameter(0.0, "N.m.s/rad", "viscous friction of the driven shaft", low=0.0)
    substep = parameter(2e-3, "s", "longest internal step", low=1e-9, high=1.0)

    def states(self) -> int:
        """Twist, speed, mode."""
        return 3

    def energy(self) -> float:
        """Energy of the driven shaft's rotation and of the twist, J."""
        p = self.arguments[1]
        return 0.5 * float(p.driven_inertia * self.x[SPEED] ** 2 + p.stiffness * self.x[TWIST] ** 2)


TWIST, SPEED, MODE = 0, 1, 2


@kernel
def shaft_torque(twist, speed, u, p):
    """Torque of the compliant shaft, N.m."""
    return p.stiffness * twist + p.shaft_damping * (p.gear_ratio * u[IN.turbine_speed] - speed)


@kernel
def fixed_start(t, s, p, e):
    """The shaft relaxed, its speed as given."""
    driving = shaft_torque(0.0, p.start_speed, s.u[0], p)
    s.x[SPEED], s.x[MODE] = p.start_speed, shaft_mode(p.start_speed, driving, s.u[0, IN.load_torque])
    return DONE


@kernel
def fixed_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| with the turbine's speed given, s."""
    return RK4_STABILITY_RADIUS / fastest_rate(p.driven_inertia, p.shaft_damping + p.driven_damping, p.stiffness)


@kernel
def fixed_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (twist, speed of the driven shaft, mode)."""
    driving = shaft_torque(x[TWIST], x[SPEED], u, p)
    dx[TWIST] = p.gear_ratio * u[IN.turbine_speed] - x[SPEED]
    dx[SPEED] = shaft_acceleration(x[MODE], x[SPEED], driving, u[IN.load_torque], p.driven_inertia, p.driven_damping)
    dx[MODE] = 0.0


@kernel
def fixed_guards(t, x, u, g, s, p, e):
    """That of the driven shaft."""
    g[0] = shaft_guard(x[MODE], x[SPEED], shaft_torque(x[TWIST], x[SPEED], u, p), u[IN.load_torque])


@kernel
def fixed_switch(which, t, x, u, s, p, e):
    """The driven shaft stops or starts."""
    x[SPEED] = 0.0
    x[MODE] = switched_shaft(x[MODE], shaft_torque(x[TWIST], 0.0, u, p), u[IN.load_torque])


@kernel
def fixed_outputs(t, s, p, e):
    """Torques, speed, ratio, power lost."""
    x, u, y = s.x, s.u[0], s.y
    driving, rate = shaft_torque(x[TWIST], x[SPEED], u, p), p.gear_ratio * u[IN.turbine_speed] - x[SPEED]
    on_turbine = p.gear_ratio * driving
    loss = mesh_loss(on_turbine, u[IN.turbine_speed], e.mesh_friction)
    y[OUT.turbine_torque], y[OUT.speed], y[OUT.driving_torque] = on_turbine + loss, x[SPEED], driving
    y[OUT.ratio] = speed_ratio(x[SPEED], u[IN.turbine_speed])
    y[OUT.dissipation] = p.shaft_damping * rate**2 + p.driven_damping * x[SPEED] ** 2 + loss * u[IN.turbine_speed]
    return DONE


FixedTransmission.kernels = event_kernels(
    __name__,
    start=fixed_start,
    stable=fixed_stable,
    derivatives=fixed_derivatives,
    guards=fixed_guards,
    switch=fixed_switch,
    outputs=fixed_outputs,
)
