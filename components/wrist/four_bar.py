"""A planar four-bar linkage between two shafts: no mass, motion one way, torque the other."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.kernels import DONE, OUT_OF_RANGE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import choice, input_, output, parameter
from .linkage import Linkage, change_points, longest_link, position, turns_freely

LINKS = ("crank", "coupler", "rocker", "ground")
OPEN, REFUSE, THROUGH = 0, 0, 1  # of the choices
FREE_PAIR, AT_0, AT_180, AT_BOTH, NO_CHANGE_POINT, TOO_LONG = range(OWN + 1, OWN + 7)  # statuses; the last one and three more
UNRESOLVED = ("word of how it goes on there", "Set change_point to through or fold, or change a length.")
NEAR, FAR, REST = range(3)  # of the array `linkage`
ANGLE, MOTION, LOADED = ("input_angle",), ("input_angle", "input_rate"), ("input_angle", "load_torque")


class PinDamping(Effect):
    """Viscous friction of all four pins, each in proportion to the rate of its two links against each other."""

    coefficient = parameter(1e-3, "N.m.s/rad", "damping of a pin", low=0.0)
    dissipation = output("W", "power lost in the pins", nominal=1e-3, feedthrough=MOTION)


class RockerSpring(Effect):
    """A torsion spring from the ground to the rocker, as ligaments between two bones are one."""

    explicit_only = True

    stiffness = parameter(1.0, "N.m/rad", "stiffness of the spring", low=0.0)
    rest_angle = parameter(1.9, "rad", "rocker angle at which it has no torque")


class CouplerPoint(Effect):
    """A point that the coupler carries: its path is the coupler curve."""

    explicit_only = True

    along = parameter(0.025, "m", "distance from the crank's tip along the coupler")
    across = parameter(0.02, "m", "distance from the coupler's line, to its left")
    x = output("m", "place along the ground from the crank's pin", nominal=0.1, feedthrough=ANGLE)
    y = output("m", "place across the ground", nominal=0.1, feedthrough=ANGLE)
    velocity_x = output("m/s", "velocity along the ground", nominal=0.1, feedthrough=MOTION)
    velocity_y = output("m/s", "velocity across the ground", nominal=0.1, feedthrough=MOTION)


class FourBar(StatelessComponent):
    """Crank, coupler and rocker on a ground, K1 cos psi - K2 cos phi + K3 = cos(phi - psi) (Freudenstein).

        K1 = d/a, K2 = d/c, K3 = (a² - b² + c² + d²) / (2 a c);    ratio = psi'/phi' = a sin(theta - phi) / (c sin(theta - psi))
        input_torque = ratio load_torque + what springs and pins add: the linkage itself takes no power

    phi, psi, theta: angles of crank, rocker and coupler; a, b, c, d: `crank`, `coupler`, `rocker`, `ground`. Where coupler and
    rocker are in one line (toggle), the ratio is infinite: a run fails as soon as the transmission angle is closer to that than
    `least_transmission_angle`. A linkage in which all links can lie in one line has change points, where two assemblies meet:
    `change_point` says how it goes on, "through" without a kink, as bodies with inertia do, or "fold" within its assembly.
    The exact root is used there, so that position, ratio and torque have no gap.
    Sandow (2020), of which the abstract was at hand, calls the wrist a linkage of two gears and four bars. The two rows of `Wrist`
    are four-bars of long arcs on a sphere (case `paper-wrist`), of which this planar one is the limit of short arcs: its
    lengths are not those of a wrist, the defaults are a textbook crank-rocker of the size of a carpus.
    """

    title = "Planar four-bar linkage"
    system = "wrist"

    pin_damping = PinDamping
    rocker_spring = RockerSpring
    coupler_point = CouplerPoint

    crank = parameter(0.020, "m", "length a of the crank, which the input turns", low=1e-6)
    coupler = parameter(0.050, "m", "length b of the coupler", low=1e-6)
    rocker = parameter(0.040, "m", "length c of the rocker, the output", low=1e-6)
    ground = parameter(0.055, "m", "distance d of the pins in the ground", low=1e-6)
    assembly = choice("open", ("open", "crossed"), "side of the crank's diagonal on which coupler and rocker meet")
    change_point = choice("refuse", ("refuse", "through", "fold"), "what a linkage does where all its links lie in one line")
    least_transmission_angle = parameter(1e-3, "rad", "nearest approach to the toggle", low=1e-6, high=1.0)

    input_angle = input_(0.5 * math.pi, "rad", "crank angle from the ground's direction")
    input_rate = input_(0.0, "rad/s", "rate of the crank")
    load_torque = input_(0.0, "N.m", "torque that brakes the rocker")

    output_angle = output("rad", "rocker angle from the ground's direction", feedthrough=ANGLE)
    output_rate = output("rad/s", "rate of the rocker", feedthrough=MOTION)
    input_torque = output("N.m", "torque that brakes the crank", feedthrough=(*MOTION, "load_torque"))
    ratio = output("1", "rate of the rocker over that of the crank", feedthrough=ANGLE)
    transmission_angle = output("rad", "angle between coupler and rocker, 0 and pi in the toggle", feedthrough=ANGLE)
    coupler_angle = output("rad", "angle of the coupler from the ground's direction, within -pi and pi", feedthrough=ANGLE)

    refusals = {
        FREE_PAIR: Refusal(
            "crank = ground and coupler = rocker",
            "another linkage",
            "With the crank along the ground, coupler and rocker would turn about one pin, whatever the crank does.",
        ),
        AT_0: Refusal("a linkage with a change point at the crank angle 0", *UNRESOLVED),
        AT_180: Refusal("a linkage with a change point at the crank angle 180 degrees", *UNRESOLVED),
        AT_BOTH: Refusal("a linkage with a change point at the crank angle 0 and 180 degrees", *UNRESOLVED),
        NO_CHANGE_POINT: Refusal(
            "change_point = '{change_point}'",
            "a linkage with a change point",
            "It would have no effect: two pairs of links are not equally long together.",
        ),
        **{
            TOO_LONG + k: Refusal(
                f"{link} = {{{link}}} m, the others together {{linkage[{REST}]}} m",
                "a longest link shorter than the others together",
                "Nothing moves otherwise.",
            )
            for k, link in enumerate(LINKS)
        },
    }

    def shapes(self) -> dict[str, Any]:
        """`linkage`: how it goes on with the crank at 0 and at pi, see `Linkage`; length of all links but the longest, m."""
        return {"linkage": 3}

    def energy(self) -> float:
        """Energy of the rocker's spring, J; 0 without one."""
        spring = self.arguments[2].rocker_spring
        if spring is None:
            return 0.0
        return float(0.5 * spring.stiffness * (self.get("output_angle") - spring.rest_angle) ** 2)

    def left_range(self) -> str:
        """Where the crank is."""
        s, p, _ = self.arguments
        reached = "beyond" if abs(cosine_of_transmission(s.u[0, IN.input_angle], p)) > 1.0 else "at"
        return f"crank angle {s.u[0, IN.input_angle]:.6g} rad is {reached}"

    def _check(self, status: int) -> None:
        if status == OUT_OF_RANGE:
            where = self.left_range() or "the crank angle is at or beyond"
            raise StepFailed(
                self.name,
                self.t,
                f"{where} the toggle, where coupler and rocker are in one line",
                "Keep the crank within its range, or change the lengths",
            )
        super()._check(status)


IN = FourBar.input_places()
OUT = FourBar.output_places()


@kernel
def cosine_of_transmission(angle, p):
    """Cosine of the transmission angle at a crank angle; beyond -1 or 1 where the linkage does not close."""
    square = p.crank**2 + p.ground**2 - 2.0 * p.crank * p.ground * math.cos(angle)
    return (p.coupler**2 + p.rocker**2 - square) / (2.0 * p.coupler * p.rocker)


@kernel
def linkage_start(t, s, p, e):
    """How it goes on where all links lie in one line; refused for lengths that do not close, or leave a link free to turn."""
    longest = longest_link(p.crank, p.coupler, p.rocker, p.ground)
    length = max(p.crank, p.coupler, p.rocker, p.ground)
    total = p.crank + p.coupler + p.rocker + p.ground
    s.linkage[REST] = total - length
    if length >= 0.5 * total:
        return TOO_LONG + longest
    if turns_freely(p.crank, p.coupler, p.rocker, p.ground):
        return FREE_PAIR
    near, far = change_points(p.crank, p.coupler, p.rocker, p.ground)
    if p.change_point == REFUSE and (near or far):
        if near and far:
            return AT_BOTH
        return AT_0 if near else AT_180
    if p.change_point != REFUSE and not (near or far):
        return NO_CHANGE_POINT
    way = 1.0 if p.change_point == THROUGH else -1.0
    s.linkage[NEAR], s.linkage[FAR] = way if near else 0.0, way if far else 0.0
    return DONE


@kernel
def linkage_outputs(t, s, p, e):
    """Position, rates and torques; none at the toggle, nor where the angle is no number."""
    y, angle, rate = s.y, s.u[0, IN.input_angle], s.u[0, IN.input_rate]
    sign = 1.0 if p.assembly == OPEN else -1.0
    linkage = Linkage(p.crank, p.coupler, p.rocker, p.ground, sign, s.linkage[NEAR], s.linkage[FAR])
    transmission, limit = cosine_of_transmission(angle, p), math.cos(p.least_transmission_angle)
    if not ((linkage.near != 0.0 or transmission < limit) and (linkage.far != 0.0 or transmission > -limit)):
        return OUT_OF_RANGE
    rocker, ratio, sine, cosine = position(angle, linkage)
    x, z = p.crank * math.cos(angle), p.crank * math.sin(angle)  # the crank's tip
    along, across = p.ground + p.rocker * math.cos(rocker) - x, p.rocker * math.sin(rocker) - z  # from there to the rocker's
    # per rate of the crank: the rates of those two components, and of the coupler
    along_slope, across_slope = z - p.rocker * math.sin(rocker) * ratio, p.rocker * math.cos(rocker) * ratio - x
    coupler_ratio = (along * across_slope - across * along_slope) / p.coupler**2
    load = s.u[0, IN.load_torque]
    if e.rocker_spring is not None:
        load += e.rocker_spring.stiffness * (rocker - e.rocker_spring.rest_angle)
    y[OUT.output_angle], y[OUT.output_rate], y[OUT.ratio] = rocker, ratio * rate, ratio
    y[OUT.input_torque] = ratio * load
    y[OUT.transmission_angle], y[OUT.coupler_angle] = math.atan2(abs(sine), cosine), math.atan2(across, along)
    if e.pin_damping is not None:
        share = 1.0 + (coupler_ratio - 1.0) ** 2 + (ratio - coupler_ratio) ** 2 + ratio * ratio
        y[OUT.input_torque] += e.pin_damping.coefficient * share * rate
        y[e.pin_damping.y] = e.pin_damping.coefficient * share * rate * rate
    if e.coupler_point is not None:
        one, two, point = along / p.coupler, across / p.coupler, e.coupler_point
        right, up = one * point.along - two * point.across, two * point.along + one * point.across
        y[point.y], y[point.y + 1] = x + right, z + up
        y[point.y + 2], y[point.y + 3] = (-z - coupler_ratio * up) * rate, (x + coupler_ratio * right) * rate
    return DONE


FourBar.kernels = stateless_kernels(__name__, linkage_outputs, linkage_start)
