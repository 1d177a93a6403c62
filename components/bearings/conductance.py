"""Heat conductance of an angular contact ball bearing between its rings, under axial and radial load.

The conductance is the quantity, not the resistance: without load no ball touches, and it is 0 or that of the side paths.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import KernelComponent, Kernels, Refusal
from ..core.kernels import DONE, OUT_OF_RANGE, OWN, hold_inputs, kernel
from ..core.variables import PARTS, count, input_, integer, output, parameter
from .constriction import (
    bridged_resistance,
    conductances_in_series,
    finite_ring,
    note_contact,
    noted_contact,
    ring_part,
    thermal_contact,
    through_gap,
)
from .contacts import LARGEST_CONTACT, LOAD, BallContacts, groove_contacts, note_contacts, set_balls
from .geometry import INNER, OUTER, BallGeometry, diameter_share, grooved_contact, relative_radii
from .hertz import LARGEST_RATIO, effective_modulus, hertz_stiffness, two_in_series
from .loads import equilibrium
from .radiation import radiative_coefficient

LARGE_BALLS, LINE_CONTACT, THIN_WALLS, NARROW_RINGS, WIDE_MENISCUS, WIDE_GAP = range(OWN + 1, OWN + 7)  # status
AS_FAR_AS_THE_BALL = (
    "at most {refused.gap} m, where the gap beside the contact reaches as far out as the ball's radius of {refused.radius} m"
)


class BallBulk(Effect):
    """Conduction through the ball behind the constrictions: (ln(2 r / (a + b)) + 1/2) / (4 pi k r) at each contact."""


class RingWalls(Effect):
    """Rings of finite size: walls, ln(outside/inside) / (2 pi k width), and at each contact less constriction.

    Heat has spread as soon as it fills the ring's part of a ball: a circle of the same area, of radius b, takes 1.4098/(4 k b)
    off the constriction on a half space.
    """

    bore = parameter(40e-3, "m", "bore of the inner ring", low=1e-6)
    outside_diameter = parameter(68e-3, "m", "outside diameter of the outer ring", low=1e-6)


class Film(Effect):
    """Lubricant inside the contacts, in series with the constriction: thickness / (conductivity * area of the ellipse)."""

    conductivity = parameter(0.14, "W/m/K", "heat conductivity of the lubricant; mineral oil, from memory", low=1e-6)
    thickness = input_(5e-7, "m", "thickness of the film in each contact", nominal=1e-6)


class LubricantPath(Effect):
    """Lubricant that fills the gap beside each contact up to the height of its meniscus; see the ladder in `constriction`."""

    conductivity = parameter(0.14, "W/m/K", "heat conductivity of the lubricant; mineral oil, from memory", low=0.0)
    meniscus_height = parameter(1e-5, "m", "width of the gap that lubricant just fills; a choice of ours", low=0.0)


class GasPath(Effect):
    """Gas at rest: in the narrow gap beside each contact (beyond the meniscus, if there is one), and between the rings."""

    conductivity = parameter(0.026, "W/m/K", "heat conductivity of the gas; air at 300 K, from memory", low=0.0)
    widest_gap = parameter(5e-5, "m", "width up to which the gap beside a contact counts as narrow; a choice of ours", low=0.0)
    ring_gap = parameter(8e-3, "m", "distance of the rings beside the balls", low=1e-6)


class Convection(Effect):
    """Gas in motion: from one ring to the gas inside and on to the other ring, each over pi * pitch diameter * width."""

    coefficient = parameter(10.0, "W/m2/K", "heat transfer coefficient at both rings; a choice of ours", low=0.0)


class Radiation(Effect):
    """Radiation between the rings over pi * pitch diameter * width; exact in both temperatures, not linearised."""

    emissivity = parameter(
        0.2, "1", "exchange factor of both surfaces together; of two like planes 1/(2/emissivity - 1)", low=0.0, high=1.0
    )
    inner_temperature = input_(293.15, "K", "temperature of the inner ring", nominal=100.0)
    outer_temperature = input_(293.15, "K", "temperature of the outer ring", nominal=100.0)


DEPENDS = ("axial_force", "radial_force")
HEAT_DEPENDS = (*DEPENDS, "film.thickness")


class AngularContactConductance(KernelComponent):
    """Conductance from ring to ring: balls in parallel, two contacts in series in each.

        G = sum over balls 1 / (1/Gi + 1/Go) + side paths,      Gi = 4 agm(a, b) / (1/k_ball + 1/k_ring)

    a, b: semi-axes of the Hertzian ellipse, which grow with the cube root of the ball's load; agm: their
    arithmetic-geometric mean, 1/agm(a, b) = 2 K(1 - (b/a)²) / (pi a). So G grows with F_axial^(1/3) at a fixed contact
    angle, and at a given axial force a radial one lowers it: the cube root gains less on one side than it loses on the other.
    Ball loads: equilibrium of the inner ring without tilt, the first ball in the direction of the radial force. A single
    row carries axial force in one direction; a negative one counts as none.
    Source: the path of Spence & Kaminski (1996); constriction classical, see `constriction`. No rotation: heat that the
    balls carry with them and churned lubricant are not in it.
    """

    title = "Heat conductance of an angular contact ball bearing"
    system = "bearings"
    start_inputs = ()
    counters = ("steps", "equilibria")
    refusals = {
        LARGE_BALLS: Refusal(
            "balls of {ball_diameter} m on a pitch diameter of {pitch_diameter} m", "balls smaller than the pitch diameter"
        ),
        LINE_CONTACT: Refusal(
            "Ry/Rx = {refused.ratio} of a ball in its groove",
            f"a ratio in [1, {LARGEST_RATIO:g}]",
            "Correct the conformities or the diameters.",
        ),
        THIN_WALLS: Refusal(
            "rings from {ring_walls.bore} m to {ring_walls.outside_diameter} m",
            "walls around {refused.inside} m and {refused.outside} m, the diameters where the balls touch",
            "Correct bore and outside_diameter.",
        ),
        NARROW_RINGS: Refusal(
            "rings {width} m wide around {balls} balls of {ball_diameter} m",
            "a part of the ring for each ball that is no smaller than the ball",
            "Correct width or balls.",
        ),
        WIDE_MENISCUS: Refusal(
            "lubricant_path.meniscus_height = {lubricant_path.meniscus_height} m", AS_FAR_AS_THE_BALL, "Reduce meniscus_height."
        ),
        WIDE_GAP: Refusal("gas_path.widest_gap = {gas_path.widest_gap} m", AS_FAR_AS_THE_BALL, "Reduce widest_gap."),
    }

    ball_bulk = BallBulk
    ring_walls = RingWalls
    film = Film
    lubricant_path = LubricantPath
    gas_path = GasPath
    convection = Convection
    radiation = Radiation

    balls = integer(16, "number of balls", low=3, high=1000, structural=PARTS)
    ball_diameter = parameter(7.938e-3, "m", "diameter of the balls", low=1e-6)
    pitch_diameter = parameter(54e-3, "m", "pitch diameter of the balls", low=1e-6)
    inner_conformity = parameter(0.52, "1", "groove radius of the inner ring over ball diameter", low=0.5001, high=1.0)
    outer_conformity = parameter(0.53, "1", "groove radius of the outer ring over ball diameter", low=0.5001, high=1.0)
    contact_angle = parameter(math.radians(15.0), "rad", "contact angle without load", low=0.0, high=1.2)
    width = parameter(15e-3, "m", "width of the rings", low=1e-6)
    modulus = parameter(2.07e11, "Pa", "Young's modulus of balls and rings", low=1.0)
    poisson_ratio = parameter(0.3, "1", "Poisson's ratio of balls and rings", low=0.0, high=0.5)
    ball_conductivity = parameter(46.0, "W/m/K", "heat conductivity of the balls", low=1e-6)
    ring_conductivity = parameter(46.0, "W/m/K", "heat conductivity of the rings", low=1e-6)
    closest_gap = parameter(
        1e-6, "m", "least width of the gap beside a contact: roughness and, in gas, the temperature jump", low=1e-12
    )

    axial_force = input_(0.0, "N", "axial force on the inner ring, in the direction it can carry", nominal=1000.0)
    radial_force = input_(0.0, "N", "radial force on the inner ring", nominal=1000.0)

    conductance = output(
        "W/K",
        "heat flow from inner to outer ring over the difference of their temperatures",
        nominal=0.1,
        feedthrough=(*HEAT_DEPENDS, "radiation.inner_temperature", "radiation.outer_temperature"),
    )
    ball_conductance = output("W/K", "part of it that goes through the balls", nominal=0.1, feedthrough=HEAT_DEPENDS)
    loaded_balls = count("number of balls in contact", feedthrough=DEPENDS)
    max_ball_load = output("N", "largest load of a ball", nominal=100.0, feedthrough=DEPENDS)
    axial_displacement = output("m", "axial displacement of the inner ring", nominal=1e-5, feedthrough=DEPENDS)
    radial_displacement = output("m", "radial displacement of the inner ring", nominal=1e-5, feedthrough=DEPENDS)

    symbols = {  # as of `DeepGrooveBearing`
        "Z": "balls",
        "Dw": "ball_diameter",
        "Dpw": "pitch_diameter",
        "fi": "inner_conformity",
        "fe": "outer_conformity",
        "alpha": "contact_angle",
        "B": "width",
        "d": "ring_walls.bore",
        "D": "ring_walls.outside_diameter",
    }
    presets = {
        "7008C": Preset(
            {"balls": 16, "ball_diameter": 7.938e-3, "pitch_diameter": 54e-3, "inner_conformity": 0.52, "outer_conformity": 0.53,
             "contact_angle": math.radians(15.0), "width": 15e-3},
            "dimensions in use for this size; groove radii and number of balls assumed", "inferred"),
        "7210B": Preset(
            {"balls": 16, "ball_diameter": 12.7e-3, "pitch_diameter": 70e-3, "inner_conformity": 0.52, "outer_conformity": 0.52,
             "contact_angle": math.radians(40.0), "width": 20e-3},
            "dimensions in use for this size; groove radii and number of balls assumed", "inferred"),
    }  # fmt: skip

    def geometry(self) -> BallGeometry:
        """The bearing's geometry."""
        p: Any = self.parameters
        return BallGeometry(
            p["balls"], p["ball_diameter"], p["pitch_diameter"], p["inner_conformity"], p["outer_conformity"], p["contact_angle"]
        )

    def material(self) -> float:
        """E' of balls and rings, Pa."""
        p: Any = self.parameters
        return effective_modulus(p["modulus"], p["poisson_ratio"], p["modulus"], p["poisson_ratio"])

    @property
    def ball_loads(self) -> np.ndarray:
        """Loads of the balls when the outputs were last computed, (Z,) N."""
        return self.arguments[0].places[:, LOAD].copy()

    @property
    def raceways(self) -> tuple[float, float]:
        """Diameters where the balls touch the inner and the outer ring, m."""
        p: Any = self.parameters
        return raceway_diameters(p["ball_diameter"], p["pitch_diameter"], p["contact_angle"])

    def shapes(self) -> dict[str, Any]:
        """`places`: (Z, 4) of the balls, see `contacts`, with their loads.  `ring`: (3, 5) force on the inner ring, whether it is
        free to move, displacement.  `contacts`: `BallContacts`.  `races`: (2, 5) of `ThermalContact`.
        `rings`, `ball`, `refused`: see there.  `tangent`, `rows`: work of
        `loads.equilibrium`.
        """
        return {
            "places": (self.parameters["balls"], 4),
            "ring": (3, 5),
            "contacts": BallContacts,
            "races": (2, 5),
            "rings": Rings,
            "ball": Ball if "ball_bulk" in self.on else None,
            "tangent": (2, 5, 5),
            "rows": (5, 8),
            "refused": Refused,
        }

    def left_range(self) -> str:
        """The forces, and how large a contact may become."""
        given = ", ".join(f"{n} = {self.get(n):g} N" for n in ("axial_force", "radial_force"))
        return f"{given}, expected contacts within {LARGEST_CONTACT:g} radii of a ball, and rings inside each other"


IN = AngularContactConductance.input_places()
OUT = AngularContactConductance.output_places()


class Rings:
    """The record `s.rings`: what the parameters determine of the rings."""

    wall: float  # 1 / (2 pi k width) of a ring, K/W
    inner_relief: float  # reduction of the constriction by a ring's finite size, K/W
    outer_relief: float
    raceways: float  # ratio of the diameters where the balls touch the outer and the inner ring
    area: float  # of each ring towards the other, m2


class Ball:
    """The record `s.ball`, for the spreading of heat in a ball."""

    radius: float  # m
    conductivity: float  # W/(m.K)


class Refused:
    """The record `s.refused`: numbers of messages."""

    ratio: float  # Ry/Rx
    inside: float  # m, diameters where the balls touch
    outside: float
    gap: float  # m, of which the contact is still a small spot
    radius: float  # m, of a ball


@kernel
def raceway_diameters(ball_diameter, pitch_diameter, contact_angle):
    """Diameters where the balls touch the inner and the outer ring, m."""
    across = ball_diameter * math.cos(contact_angle)
    return pitch_diameter - across, pitch_diameter + across


@kernel
def conductance_start(t, s, p, e):
    """Constants from the parameters: contacts, rings, places of the balls."""
    d = p.ball_diameter
    if not d < p.pitch_diameter:
        return LARGE_BALLS
    gamma = diameter_share(d, p.pitch_diameter, p.contact_angle)
    modulus = effective_modulus(p.modulus, p.poisson_ratio, p.modulus, p.poisson_ratio)
    inner_along, inner_across = relative_radii(INNER, p.inner_conformity, d, gamma)
    outer_along, outer_across = relative_radii(OUTER, p.outer_conformity, d, gamma)
    s.refused.ratio = max(inner_across / inner_along, outer_across / outer_along)
    if s.refused.ratio > LARGEST_RATIO:
        return LINE_CONTACT
    inner = grooved_contact(inner_along, inner_across, modulus, False)
    outer = grooved_contact(outer_along, outer_across, modulus, False)
    note_contact(thermal_contact(inner, inner_along, inner_across, p.ball_conductivity, p.ring_conductivity), s.races[0])
    note_contact(thermal_contact(outer, outer_along, outer_across, p.ball_conductivity, p.ring_conductivity), s.races[1])
    status = rings_status(s, p, e)
    if status == DONE:
        status = gaps_status(max(inner_across, outer_across), s, p, e)
    if status != DONE:
        return status
    stiffness = two_in_series(
        hertz_stiffness(inner.radius, modulus, inner.ellipse), hertz_stiffness(outer.radius, modulus, outer.ellipse)
    )
    contacts = groove_contacts(
        p.balls, stiffness, p.inner_conformity, p.outer_conformity, d, p.pitch_diameter, p.contact_angle, 0.0
    )
    note_contacts(contacts, s.contacts)
    if e.ball_bulk is not None:
        s.ball.radius, s.ball.conductivity = 0.5 * d, p.ball_conductivity
    set_balls(s.places, 0.0)
    s.ring[1, 0] = s.ring[1, 2] = 1.0  # it moves along the radial load and along the shaft, and does not tilt
    return DONE


@kernel
def rings_status(s, p, e):
    """The numbers of `Rings`, and whether there is a wall around the balls and room for their heat in it."""
    inside, outside = raceway_diameters(p.ball_diameter, p.pitch_diameter, p.contact_angle)
    if e.ring_walls is not None:
        s.refused.inside, s.refused.outside = inside, outside
        if not (e.ring_walls.bore < inside and outside < e.ring_walls.outside_diameter):
            return THIN_WALLS
        if ring_part(inside, p.width, p.balls) < 0.5 * p.ball_diameter:
            return NARROW_RINGS
    r = s.rings
    r.wall = 1.0 / (2.0 * math.pi * p.ring_conductivity * p.width)
    r.inner_relief = finite_ring(ring_part(inside, p.width, p.balls), p.ring_conductivity)
    r.outer_relief = finite_ring(ring_part(outside, p.width, p.balls), p.ring_conductivity)
    r.raceways, r.area = outside / inside, math.pi * p.pitch_diameter * p.width
    return DONE


@kernel
def gaps_status(across, s, p, e):
    """Whether no gap is bridged as far out as the ball's equator; across: the larger relative radius Ry, m."""
    radius = 0.5 * p.ball_diameter
    s.refused.gap, s.refused.radius = 0.5 * radius**2 / across, radius
    if e.lubricant_path is not None and e.lubricant_path.meniscus_height > s.refused.gap:
        return WIDE_MENISCUS
    if e.gas_path is not None and e.gas_path.widest_gap > s.refused.gap:
        return WIDE_GAP
    return DONE


@kernel
def side_of_ball(load, thickness, contact, relief, s, p, e):
    """Conductance between a ball and one race, W/K: the contact, the gap beside it, and the resistances in series with both.

    load: N.  thickness: of the film, m.  relief: what the ring's finite part takes off the constriction, K/W.
    """
    root = load ** (1.0 / 3.0)
    inside, width = math.inf, 0.0  # resistance within the gap `width`, and the constriction from there on
    if load > 0.0:
        inside = 0.0
        if e.film is not None:
            inside = thickness / (e.film.conductivity * math.pi * contact.along * contact.across * root * root)
    spread = bridged_resistance(0.0, root, contact, s.ball)
    reach = 0.0
    if e.gas_path is not None and e.gas_path.conductivity > 0.0:
        reach = e.gas_path.widest_gap
    if e.lubricant_path is not None:
        width = e.lubricant_path.meniscus_height
        # lubricant that conducts nothing: only the gas that begins beyond it needs to know how far it goes
        if width > 0.0 and (e.lubricant_path.conductivity > 0.0 or reach > width):
            inside, spread = through_gap(inside, 0.0, width, p.closest_gap, e.lubricant_path.conductivity, root, contact, s.ball)
    if e.gas_path is not None and reach > width:
        inside, spread = through_gap(inside, width, reach, p.closest_gap, e.gas_path.conductivity, root, contact, s.ball)
    if inside == math.inf:
        return 0.0
    resistance = inside + spread
    if e.ring_walls is not None:
        resistance -= relief
    return 1.0 / resistance


@kernel
def conductance_outputs(t, s, p, e):
    """Ball loads for the inputs, and all outputs."""
    u, y, places = s.u[0], s.y, s.places
    forces, free, q = s.ring[0], s.ring[1], s.ring[2]
    forces[0], forces[2] = u[IN.radial_force], max(u[IN.axial_force], 0.0)
    q[:] = 0.0  # always the same way to the equilibrium: a repeated step is bit-identical
    status = equilibrium(forces, free, s.contacts, places, q, (s.tangent[0], s.tangent[1], s.rows), None)
    if status != DONE:
        return status
    inner, outer, rings = noted_contact(s.races[0]), noted_contact(s.races[1]), s.rings
    thickness = 0.0
    if e.film is not None:
        thickness = max(u[e.film.u], 0.0)
    total, largest, loaded = 0.0, 0.0, 0
    for j in range(places.shape[0]):
        load = places[j, LOAD]
        loaded += load > 0.0
        largest = max(largest, load)
        total += conductances_in_series(
            side_of_ball(load, thickness, inner, rings.inner_relief, s, p, e),
            side_of_ball(load, thickness, outer, rings.outer_relief, s, p, e),
        )
    if largest ** (1.0 / 3.0) * max(inner.across, outer.across) > LARGEST_CONTACT * 0.5 * p.ball_diameter:
        return OUT_OF_RANGE
    y[OUT.ball_conductance] = total
    if e.gas_path is not None:
        total += e.gas_path.conductivity * rings.area / e.gas_path.ring_gap
    if e.convection is not None:
        total += 0.5 * e.convection.coefficient * rings.area
    if e.radiation is not None:
        total += e.radiation.emissivity * rings.area * radiative_coefficient(u[e.radiation.u], u[e.radiation.u + 1])
    if e.ring_walls is not None:
        total /= 1.0 + total * rings.wall * math.log(e.ring_walls.outside_diameter / e.ring_walls.bore / rings.raceways)
    y[OUT.conductance], y[OUT.loaded_balls], y[OUT.max_ball_load], y[OUT.axial_displacement], y[OUT.radial_displacement] = (
        total,
        loaded,
        largest,
        q[2],
        q[0],
    )
    return DONE


@kernel
def conductance_step(t, h, s, p, e):
    """The outputs at the end of a step."""
    hold_inputs(s.u, h)
    s.counts[0] += 1
    s.counts[1] += 1
    return conductance_outputs(t + h, s, p, e)


AngularContactConductance.kernels = Kernels(conductance_start, conductance_step, conductance_outputs)
