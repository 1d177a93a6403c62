"""Heat conductance of an angular contact ball bearing between its rings, under axial and radial load.

The conductance is the quantity, not the resistance: without load no ball touches, and it is 0 or that of the side paths.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..core.component import Component, Effect, Preset
from ..core.errors import BadInput
from ..core.kernels import DONE, OUT_OF_RANGE, hold_inputs, kernel, kernel_tuple
from ..core.variables import input_, integer, output, parameter
from .constriction import (
    Ball,
    ThermalContact,
    bridged_resistance,
    conductances_in_series,
    finite_ring,
    thermal_contact,
    through_gap,
)
from .contacts import LARGEST_CONTACT, LOAD, BallContacts, ball_contacts, place_balls
from .geometry import BallGeometry
from .hertz import effective_modulus
from .loads import equilibrium, workspace
from .radiation import radiative_coefficient

FREE = (1.0, 0.0, 1.0, 0.0, 0.0)  # the inner ring moves along the radial load and along the shaft, and does not tilt


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

    conductivity = parameter(0.14, "W/m/K", "heat conductivity of the lubricant; mineral oil, recalled", low=1e-6)
    thickness = input_(5e-7, "m", "thickness of the film in each contact", nominal=1e-6)


class LubricantPath(Effect):
    """Lubricant that fills the gap beside each contact up to the height of its meniscus; see the ladder in `constriction`."""

    conductivity = parameter(0.14, "W/m/K", "heat conductivity of the lubricant; mineral oil, recalled", low=0.0)
    meniscus_height = parameter(1e-5, "m", "width of the gap that lubricant just fills; a choice of ours", low=0.0)


class GasPath(Effect):
    """Gas at rest: in the narrow gap beside each contact (beyond the meniscus, if there is one), and between the rings."""

    conductivity = parameter(0.026, "W/m/K", "heat conductivity of the gas; air at 300 K, recalled", low=0.0)
    widest_gap = parameter(5e-5, "m", "width up to which the gap beside a contact counts as narrow; a choice of ours", low=0.0)
    ring_gap = parameter(8e-3, "m", "distance of the rings beside the balls", low=1e-6)


class Convection(Effect):
    """Gas in motion: from one ring to the gas inside and on to the other ring, each over pi * pitch diameter * width."""

    coefficient = parameter(10.0, "W/m2/K", "heat transfer coefficient at both rings; a choice of ours", low=0.0)


class Radiation(Effect):
    """Radiation between the rings over pi * pitch diameter * width; exact in both temperatures, not linearised."""

    emissivity = parameter(0.2, "1", "exchange factor of both surfaces together; of two like planes 1/(2/emissivity - 1)",
                           low=0.0, high=1.0)
    inner_temperature = input_(293.15, "K", "temperature of the inner ring", nominal=100.0)
    outer_temperature = input_(293.15, "K", "temperature of the outer ring", nominal=100.0)


DEPENDS = ("axial_force", "radial_force")
HEAT_DEPENDS = (*DEPENDS, "film.thickness")


class AngularContactConductance(Component):
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
    needs_scipy = True
    counters = ("steps", "equilibria")

    ball_bulk = BallBulk
    ring_walls = RingWalls
    film = Film
    lubricant_path = LubricantPath
    gas_path = GasPath
    convection = Convection
    radiation = Radiation

    balls = integer(16, "number of balls", low=3, high=1000)
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
    closest_gap = parameter(1e-6, "m", "least width of the gap beside a contact: roughness and, in gas, the temperature jump",
                            low=1e-12)

    axial_force = input_(0.0, "N", "axial force on the inner ring, in the direction it can carry", nominal=1000.0)
    radial_force = input_(0.0, "N", "radial force on the inner ring", nominal=1000.0)

    conductance = output("W/K", "heat flow from inner to outer ring over the difference of their temperatures", nominal=0.1,
                         feedthrough=(*HEAT_DEPENDS, "radiation.inner_temperature", "radiation.outer_temperature"))
    ball_conductance = output("W/K", "part of it that goes through the balls", nominal=0.1, feedthrough=HEAT_DEPENDS)
    loaded_balls = output("1", "number of balls in contact", feedthrough=DEPENDS)
    max_ball_load = output("N", "largest load of a ball", nominal=100.0, feedthrough=DEPENDS)
    axial_displacement = output("m", "axial displacement of the inner ring", nominal=1e-5, feedthrough=DEPENDS)
    radial_displacement = output("m", "radial displacement of the inner ring", nominal=1e-5, feedthrough=DEPENDS)

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
        return BallGeometry(p["balls"], p["ball_diameter"], p["pitch_diameter"], p["inner_conformity"], p["outer_conformity"],
                            p["contact_angle"])

    def material(self) -> float:
        """E' of balls and rings, Pa."""
        p: Any = self.parameters
        return effective_modulus(p["modulus"], p["poisson_ratio"], p["modulus"], p["poisson_ratio"])

    @property
    def ball_loads(self) -> np.ndarray:
        """Loads of the balls when the outputs were last computed, (Z,) N."""
        return self._balls[:, LOAD].copy()

    @property
    def raceways(self) -> tuple[float, float]:
        """Diameters where the balls touch the inner and the outer ring, m."""
        p: Any = self.parameters
        across = p["ball_diameter"] * math.cos(p["contact_angle"])
        return p["pitch_diameter"] - across, p["pitch_diameter"] + across

    def _initialize(self, t: float) -> int:
        _, e = self._declared_arguments()
        p: Any = self.parameters
        geometry = self.geometry()
        modulus, raceways = self.material(), self.raceways
        inner, outer = (
            thermal_contact(geometry.contact(race, modulus), geometry.radii(race), p["ball_conductivity"], p["ring_conductivity"])
            for race in ("inner", "outer")
        )
        if "ring_walls" in self.on:
            self._check_walls(raceways)
        self._check_gaps(max(inner.radius_across, outer.radius_across))
        constants = Constants(
            ball_contacts(geometry, geometry.stiffness(modulus)),
            inner,
            outer,
            0.5 * p["ball_diameter"],
            1.0 / (2.0 * math.pi * p["ring_conductivity"] * p["width"]),
            finite_ring(ring_part(raceways[0], p["width"], p["balls"]), p["ring_conductivity"]),
            finite_ring(ring_part(raceways[1], p["width"], p["balls"]), p["ring_conductivity"]),
            raceways[1] / raceways[0],
            math.pi * p["pitch_diameter"] * p["width"],
            p["closest_gap"],
        )
        if e.ball_bulk is not None:
            e = e._replace(ball_bulk=Ball(0.5 * p["ball_diameter"], p["ball_conductivity"]))
        self.arguments = (constants, e)
        self._balls, self._work = place_balls(p["balls"]), workspace()
        self._ring = np.array([(0.0,) * 5, FREE, (0.0,) * 5])
        return DONE

    def _check_walls(self, raceways: tuple[float, float]) -> None:
        p: Any = self.parameters
        bore, outside = p["ring_walls.bore"], p["ring_walls.outside_diameter"]
        if not (bore < raceways[0] and raceways[1] < outside):
            raise BadInput(self.name, f"rings from {bore:g} m to {outside:g} m", f"walls around {raceways[0]:.4g} m and "
                           f"{raceways[1]:.4g} m, the diameters where the balls touch", "Correct bore and outside_diameter.")
        if ring_part(raceways[0], p["width"], p["balls"]) < 0.5 * p["ball_diameter"]:
            raise BadInput(self.name, f"rings {p['width']:g} m wide around {p['balls']} balls of {p['ball_diameter']:g} m",
                           "a part of the ring for each ball that is no smaller than the ball", "Correct width or balls.")

    def _check_gaps(self, across: float) -> None:
        """Refuses a gap that is bridged as far out as the ball's equator; across: the larger relative radius Ry, m."""
        p: Any = self.parameters
        radius = 0.5 * p["ball_diameter"]
        widest = 0.5 * radius**2 / across
        for effect, name in (("lubricant_path", "meniscus_height"), ("gas_path", "widest_gap")):
            if effect in self.on and (width := p[f"{effect}.{name}"]) > widest:
                raise BadInput(self.name, f"{effect}.{name} = {width:g} m", f"at most {widest:.3g} m, where the gap beside the "
                               f"contact reaches as far out as the ball's radius of {radius:g} m", f"Reduce {name}.")

    def left_range(self) -> str:
        """The forces, and how large a contact may become."""
        given = ", ".join(f"{n} = {self.get(n):g} N" for n in ("axial_force", "radial_force"))
        return f"{given}; expected contacts within {LARGEST_CONTACT:g} radii of a ball, and rings inside each other"

    def _step(self, t: float, h: float) -> int:
        hold_inputs(self.u, h)
        self.counts += 1
        return self._solve()

    def _outputs(self, t: float) -> None:
        self._check(self._solve())

    def _solve(self) -> int:
        return bearing_conductance(self.u[0], self.y, self._ring, self._balls, self._work, *self.arguments)


def ring_part(diameter: float, width: float, balls: int) -> float:
    """Radius of a circle as large as the part of a ring that belongs to one ball, m."""
    return math.sqrt(diameter * width / balls)


AXIAL_FORCE, RADIAL_FORCE = AngularContactConductance.input_indices("axial_force", "radial_force")
CONDUCTANCE, BALL_CONDUCTANCE, LOADED, MAX_LOAD, AXIAL, RADIAL = AngularContactConductance.output_indices(
    "conductance", "ball_conductance", "loaded_balls", "max_ball_load", "axial_displacement", "radial_displacement"
)


@kernel_tuple
class Constants(NamedTuple):
    """What follows from the parameters."""

    contacts: BallContacts
    inner: ThermalContact
    outer: ThermalContact
    ball_radius: float  # m
    wall: float  # 1 / (2 pi k width) of a ring, K/W
    inner_relief: float  # what a ring's finite part takes off the constriction, K/W
    outer_relief: float
    raceways: float  # ratio of the diameters where the balls touch the outer and the inner ring
    area: float  # of each ring towards the other, m2
    closest_gap: float  # m


@kernel
def side_of_ball(load, contact, relief, p, e, thickness):
    """Conductance between a ball and one race, W/K: the contact, the gap beside it, and what is in series with both."""
    root = load ** (1.0 / 3.0)
    inside, width = math.inf, 0.0  # resistance within the gap `width`, and the constriction from there on
    if load > 0.0:
        inside = 0.0
        if e.film is not None:
            inside = thickness / (e.film.conductivity * math.pi * contact.along * contact.across * root * root)
    spread = bridged_resistance(0.0, root, contact, e.ball_bulk)
    reach = 0.0
    if e.gas_path is not None and e.gas_path.conductivity > 0.0:
        reach = e.gas_path.widest_gap
    if e.lubricant_path is not None:
        width = e.lubricant_path.meniscus_height
        # lubricant that conducts nothing: only the gas that begins beyond it needs to know how far it goes
        if width > 0.0 and (e.lubricant_path.conductivity > 0.0 or reach > width):
            inside, spread = through_gap(inside, 0.0, width, p.closest_gap, e.lubricant_path.conductivity, root, contact,
                                         e.ball_bulk)
    if e.gas_path is not None and reach > width:
        inside, spread = through_gap(inside, width, reach, p.closest_gap, e.gas_path.conductivity, root, contact, e.ball_bulk)
    if inside == math.inf:
        return 0.0
    resistance = inside + spread
    if e.ring_walls is not None:
        resistance -= relief
    return 1.0 / resistance


@kernel
def bearing_conductance(u, y, ring, balls, work, p, e):
    """Ball loads for the inputs u, and all outputs.

    ring: (3, 5) force, freedom to move (`FREE`) and displacement of the inner ring; balls: (Z, 4); work: of `workspace`.
    """
    forces, free, q = ring[0], ring[1], ring[2]
    forces[0], forces[2] = u[RADIAL_FORCE], max(u[AXIAL_FORCE], 0.0)
    q[:] = 0.0  # always the same way to the equilibrium: a repeated step gives the same bits
    status = equilibrium(forces, free, p.contacts, balls, q, work)
    if status != DONE:
        return status
    thickness = 0.0
    if e.film is not None:
        thickness = max(u[e.film.u], 0.0)
    total, largest, loaded = 0.0, 0.0, 0
    for j in range(balls.shape[0]):
        load = balls[j, LOAD]
        loaded += load > 0.0
        largest = max(largest, load)
        inner = side_of_ball(load, p.inner, p.inner_relief, p, e, thickness)
        outer = side_of_ball(load, p.outer, p.outer_relief, p, e, thickness)
        total += conductances_in_series(inner, outer)
    if largest ** (1.0 / 3.0) * max(p.inner.across, p.outer.across) > LARGEST_CONTACT * p.ball_radius:
        return OUT_OF_RANGE
    y[BALL_CONDUCTANCE] = total
    if e.gas_path is not None:
        total += e.gas_path.conductivity * p.area / e.gas_path.ring_gap
    if e.convection is not None:
        total += 0.5 * e.convection.coefficient * p.area
    if e.radiation is not None:
        inner, outer = u[e.radiation.u], u[e.radiation.u + 1]
        total += e.radiation.emissivity * p.area * radiative_coefficient(inner, outer)
    if e.ring_walls is not None:
        total /= 1.0 + total * p.wall * math.log(e.ring_walls.outside_diameter / e.ring_walls.bore / p.raceways)
    y[CONDUCTANCE], y[LOADED], y[MAX_LOAD], y[AXIAL], y[RADIAL] = total, loaded, largest, q[2], q[0]
    return DONE
