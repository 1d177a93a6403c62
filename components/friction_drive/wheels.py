"""Two friction wheels and the sleeve they move: from the wheels' rates to their loads and the sleeve's motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from ..core.contract import Refusal
from ..core.events import EventComponent, event_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import input_, output, parameter
from .kinematics import ANGLE, IDLE, idle_angle, layout_choice
from .sleeve import (
    FEED,
    FEED_RATE,
    GUARDS,
    ROTATION,
    ROTATION_RATE,
    ExactSlip,
    Gravity,
    LuGreSlip,
    PreloadLoss,
    RollingSlip,
    SmoothedSlip,
    TrocarFriction,
    contact_outputs,
    sleeve_derivatives,
    sleeve_energy,
    sleeve_guards,
    sleeve_start,
    sleeve_states,
    sleeve_switch,
    stuck_outputs,
)

CREEP = 600.0  # N.s/m, by default
CREEP_WITH_LUGRE, CREEP_WITH_EXACT, CREEP_WITH_ROLLING = OWN + 4, OWN + 5, OWN + 6  # statuses, behind those of kinematics.py
FIRST, SECOND, BOTH = ("first_rate",), ("second_rate",), ("first_rate", "second_rate")


class SleeveDeclarations:
    """Effects and parameters of wheels and sleeve, for the wheels' unit and for the whole drive."""

    smoothed_slip = SmoothedSlip
    lugre_slip = LuGreSlip
    exact_slip = ExactSlip
    rolling_slip = RollingSlip
    trocar_friction = TrocarFriction
    gravity = Gravity
    preload_loss = PreloadLoss

    layout = layout_choice()
    angle = parameter(ANGLE, "rad", "angle of the skewed wheels to the axis of the sleeve", low=0.0, high=0.5 * math.pi)
    wheel_radius = parameter(0.01, "m", "radius of the wheels", low=1e-6, nominal=0.01)
    sleeve_radius = parameter(0.005, "m", "radius of the sleeve", low=1e-6, nominal=0.01)
    mass = parameter(0.15, "kg", "mass of the sleeve with its instrument", low=1e-9)
    inertia = parameter(1.875e-6, "kg.m2", "moment of inertia about the sleeve's axis", low=1e-15, nominal=1e-6)
    normal_force = parameter(15.0, "N", "normal force of each wheel, its preload", low=1e-9, nominal=10.0, tunable=True)
    friction = parameter(0.4, "1", "coefficient of kinetic friction of wheel and sleeve", low=1e-9, tunable=True)
    creep = parameter(CREEP, "N.s/m", "traction per slip of a contact that creeps, at full preload", low=0.0, nominal=100.0)
    start_feed = parameter(0.0, "m", "feed at the start")
    start_rotation = parameter(0.0, "rad", "rotation at the start")
    start_feed_rate = parameter(0.0, "m/s", "rate of feed at the start")
    start_rotation_rate = parameter(0.0, "rad/s", "rate of rotation at the start")
    substep = parameter(1e-4, "s", "longest internal step", low=1e-9, high=1.0)

    refusals: ClassVar[Mapping[int, Refusal]] = IDLE | {
        status: Refusal(
            f"creep = {{creep}} N.s/m with {effect!r}",
            "contacts that creep: 'smoothed_slip' or none of the effects of slip",
            f"The stiffness of contacts with {effect!r} follows from parameters of that effect.",
        )
        for status, effect in (
            (CREEP_WITH_LUGRE, "lugre_slip"),
            (CREEP_WITH_EXACT, "exact_slip"),
            (CREEP_WITH_ROLLING, "rolling_slip"),
        )
    }


class FrictionWheels(SleeveDeclarations, EventComponent):
    """A sleeve with two degrees of freedom, feed z and rotation phi, and two wheels that are pressed on it.

        s_k = (z', r phi') - R w_k t_k,    t_k = (cos a_k, sin a_k)
        m z'' = sum of Q_k along + F,    J phi'' = r sum of Q_k around + M,    load of wheel k = R Q_k . t_k

    s_k: slip, Q_k: force of wheel k on the sleeve, against the slip. With plain wheels it has both components, with free rollers
    (see kinematics.py) the one along t_k only. Without an effect of friction the contacts creep: Q = -creep s, without a limit;
    one of `smoothed_slip`, `lugre_slip`, `exact_slip` and `rolling_slip` gives them one, friction * normal_force, whatever the direction.

    Frączak (2013), known to us by its abstract, has friction wheels that move a laparoscope's sleeve in two degrees of freedom;
    equations, layouts and numbers are ours, of the size that instrument has. The wheels' inertia belongs to their motors.
    """

    title = "Friction wheels and sleeve"
    system = "friction_drive"
    start_inputs = ()

    first_rate = input_(0.0, "rad/s", "rate of the first wheel", nominal=10.0)
    second_rate = input_(0.0, "rad/s", "rate of the second wheel", nominal=10.0)
    external_force = input_(0.0, "N", "force on the sleeve along its axis, in the direction of feed")
    external_torque = input_(0.0, "N.m", "torque on the sleeve about its axis", nominal=0.005)

    first_torque = output("N.m", "load of the first wheel, against a positive rate", nominal=0.05, feedthrough=FIRST)
    second_torque = output("N.m", "load of the second wheel, against a positive rate", nominal=0.05, feedthrough=SECOND)
    feed = output("m", "position of the sleeve along its axis", nominal=0.1)
    feed_rate = output("m/s", "rate of feed", nominal=0.1)
    rotation = output("rad", "angle of the sleeve about its axis")
    rotation_rate = output("rad/s", "rate of rotation", nominal=10.0)
    first_slip_axial = output("m/s", "slip of the sleeve on the first wheel, along the axis", nominal=0.1, feedthrough=FIRST)
    first_slip_around = output("m/s", "slip of the sleeve on the first wheel, around it", nominal=0.1, feedthrough=FIRST)
    second_slip_axial = output("m/s", "slip of the sleeve on the second wheel, along the axis", nominal=0.1, feedthrough=SECOND)
    second_slip_around = output("m/s", "slip of the sleeve on the second wheel, around it", nominal=0.1, feedthrough=SECOND)
    first_traction_axial = output("N", "force of the first wheel on the sleeve, along the axis", feedthrough=FIRST)
    first_traction_around = output("N", "force of the first wheel on the sleeve, around it", feedthrough=FIRST)
    second_traction_axial = output("N", "force of the second wheel on the sleeve, along the axis", feedthrough=SECOND)
    second_traction_around = output("N", "force of the second wheel on the sleeve, around it", feedthrough=SECOND)
    margin = output(
        "1", "share of the kinetic friction still free, of the wheel that has less; 0 without preload", feedthrough=BOTH
    )
    contact_power = output("W", "power that the contacts take up: lost, but for what deflections store", feedthrough=BOTH)
    mechanical_energy = output("J", "kinetic energy, height above feed zero, deflection of contacts and seal")

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """Those of both contacts and the seal, where any of them can hold."""
        return GUARDS if {"exact_slip", "trocar_friction"} & {*self.on} else 0

    def states(self) -> int:
        """Those of the sleeve."""
        return sleeve_states(self.on)

    def shapes(self) -> dict[str, Any]:
        """`slopes`: of the derivatives over the state, and workspace."""
        return super().shapes() | {"slopes": (2, self.states(), self.states())}

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        _, p, e = self.arguments
        return float(sleeve_energy(self.t, self.x, p, e))


IN = FrictionWheels.input_places()
OUT = FrictionWheels.output_places()


@kernel
def declared_status(p, e):
    """The status of parameters that have no part: an angle of wheels without, and `creep` with a friction that has none."""
    if e.lugre_slip is not None and p.creep != CREEP:
        return CREEP_WITH_LUGRE
    if e.exact_slip is not None and p.creep != CREEP:
        return CREEP_WITH_EXACT
    if e.rolling_slip is not None and p.creep != CREEP:
        return CREEP_WITH_ROLLING
    return idle_angle(p.layout, p.angle)


@kernel
def wheels_start(t, s, p, e):
    """Motion of the parameters, contacts relaxed."""
    sleeve_start(s.x, p)
    return declared_status(p, e)


@kernel
def wheels_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of the sleeve, see sleeve.py."""
    sleeve_derivatives(t, x, u[IN.first_rate], u[IN.second_rate], (u[IN.external_force], u[IN.external_torque]), dx, p, e)


@kernel
def wheels_guards(t, x, u, g, s, p, e):
    """Guards: positive while the modes of both contacts and the seal last."""
    sleeve_guards(x, u[IN.first_rate], u[IN.second_rate], g, p, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)


@kernel
def wheels_switch(which, t, x, u, s, p, e):
    """A contact or the seal breaks loose, or comes to rest."""
    sleeve_switch(which, x, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)


@kernel
def wheels_outputs(t, s, p, e):
    """Loads of the wheels, motion of the sleeve, contacts, energy."""
    x, u, y = s.x, s.u[0], s.y
    y[OUT.first_torque], y[OUT.second_torque] = contact_outputs(
        t, x, u[IN.first_rate], u[IN.second_rate], y, OUT.first_slip_axial, p, e
    )
    y[OUT.feed], y[OUT.feed_rate], y[OUT.rotation], y[OUT.rotation_rate] = x[FEED], x[FEED_RATE], x[ROTATION], x[ROTATION_RATE]
    y[OUT.mechanical_energy] = sleeve_energy(t, x, p, e)
    stuck_outputs(x, y, e.lugre_slip, e.exact_slip, e.rolling_slip, e.trocar_friction)
    return DONE


FrictionWheels.kernels = event_kernels(
    __name__,
    start=wheels_start,
    derivatives=wheels_derivatives,
    outputs=wheels_outputs,
    guards=wheels_guards,
    switch=wheels_switch,
)
