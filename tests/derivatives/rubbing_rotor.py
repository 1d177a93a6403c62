"""A Jeffcott rotor within a ring that it touches: whirls in contact are circles, so that they and their folds are known in closed form."""

import math

from cosimo.components.core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.variables import output, parameter


class RubbingRotor(OdeComponent):
    """m z'' + c z' + k z + K (1 - clearance / |z|) z = m e w² exp(i w t) for z = x + i y; K where |z| is above the clearance."""

    title = "Jeffcott rotor in a ring"
    system = "rotor"

    mass = parameter(10.0, "kg", "mass of the disk", low=1e-9)
    stiffness = parameter(1e5, "N/m", "stiffness of the shaft")
    damping = parameter(150.0, "N.s/m", "external damping")
    eccentricity = parameter(1e-4, "m", "distance of the centre of mass")
    ring = parameter(1e5, "N/m", "stiffness of the ring")
    clearance = parameter(3e-4, "m", "radial clearance")
    speed = parameter(90.0, "rad/s", "speed of rotation")
    substep = parameter(2e-4, "s", "longest internal step", low=1e-9)

    displacement_x = output("m", "displacement along x")
    displacement_y = output("m", "displacement along y")
    angle = output("rad", "angle of the rotor")

    def states(self) -> int:
        """x, y, x', y', angle."""
        return 5


@kernel
def start(t, s, p, e):
    """At rest in the middle."""
    s.x[:] = 0.0
    return DONE


@kernel
def stable(t, s, p, e):
    """Limit of the internal step for an undamped mass on both springs."""
    return RK4_STABILITY_RADIUS / math.sqrt((p.stiffness + p.ring) / p.mass)


@kernel
def derivatives(t, x, u, dx, s, p, e):
    """dx/dt."""
    r = math.hypot(x[0], x[1])
    stiffness = p.stiffness
    if r > p.clearance:
        stiffness += p.ring * (1.0 - p.clearance / r)
    moment = p.mass * p.eccentricity * p.speed**2
    dx[0], dx[1] = x[2], x[3]
    dx[2] = (moment * math.cos(x[4]) - stiffness * x[0] - p.damping * x[2]) / p.mass
    dx[3] = (moment * math.sin(x[4]) - stiffness * x[1] - p.damping * x[3]) / p.mass
    dx[4] = p.speed


@kernel
def outputs(t, s, p, e):
    """Place and angle."""
    s.y[0], s.y[1], s.y[2] = s.x[0], s.x[1], s.x[4]
    return DONE


RubbingRotor.kernels = ode_kernels(__name__, start=start, derivatives=derivatives, outputs=outputs, stable=stable)
