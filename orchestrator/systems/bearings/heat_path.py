"""Reference for the lumped conductance: the path inner ring - ball - outer ring in finite volumes.

Used by the validation case thermal-scaling and by tests, by no component.

One ball and the part of each ring that belongs to it, about the common normal of both contacts. The ball is a sphere; a ring
is a disc of the sector's area (pitch of the balls times width of the ring) and the ring's thickness, insulated at its rim
(the neighbours are alike), at a given temperature at its back. Grids of ball and rings meet at the same radii, so that every
piece of the ball's surface faces one piece of a ring's. What lies between them:

    contact     inside the Hertzian ellipse (cells it cuts count by their share), no resistance of its own,
    gas         outside, as wide as the unloaded surfaces are apart less their distance at the contact's edge, plus `closest`,
    air         a node without heat capacity; all other surfaces exchange heat with it by convection,
    enclosure   a black node; all other surfaces radiate to it.

Both nodes float: what comes in through one ring leaves through the other. A quarter about the normal is enough.
The conduction is that of Spence & Kaminski (1996), whose own grid and numbers were not at hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....components.bearings.conductance import AngularContactConductance
from .finite_volumes import Bodies, Grid, cylindrical, graded, spherical

QUARTER = 0.5 * math.pi


@dataclass(frozen=True)
class RingPart:
    """The part of a ring that belongs to one ball; the contact's semi-axes in rolling direction and across, m."""

    along: float
    across: float
    radii: tuple[float, float]  # Rx, Ry of ball and race, m
    thickness: float  # from the race to the face that is held at a temperature, m
    area: float  # of ring per ball, m2
    conductivity: float


@dataclass(frozen=True)
class Surroundings:
    """What surfaces and gaps let through besides the contacts; 0: nothing."""

    gas_conductivity: float = 0.0  # W/(m.K)
    closest: float = 1e-6  # m, added to the gap's width: roughness and the gas's temperature jump
    widest: float = 1e-4  # m, the gap's width beyond which it counts as open
    convection: float = 0.0  # W/(m2.K)
    emissivity: float = 0.0


@dataclass(frozen=True)
class HeatPath:
    """Result of `solve_path`."""

    conductance: float  # W/K, of one ball with its parts of the rings
    imbalance: float  # heat in less heat out, over heat in
    ball: tuple[float, float, float]  # K: coldest, mean and hottest of the ball's surface cells


def solve_path(
    inner: RingPart,
    outer: RingPart,
    ball_radius: float,
    ball_conductivity: float,
    around: Surroundings | None = None,
    temperatures: tuple[float, float] = (303.15, 293.15),
    fineness: int = 4,
) -> HeatPath:
    """Heat from the inner to the outer ring by way of one ball; cells at the contact: the short semi-axis over `fineness`."""
    around = around or Surroundings()
    growth = 1.0 + 0.8 / fineness
    spots = [p.along if p.along > 0.0 else 0.02 * ball_radius for p in (inner, outer)]
    first = min(spots) / fineness**1.5
    phi = _angles(inner, outer, fineness)
    north, south = (np.arcsin(_radii(spot, fineness, growth, 0.95 * ball_radius) / ball_radius) for spot in spots)
    # near the equator the ball faces no race
    equator = np.linspace(north[-1], math.pi - south[-1], 7)[1:-1]
    theta = np.concatenate([north, equator, math.pi - south[::-1]])
    deep = ball_radius - graded(first, growth, ball_radius)[::-1]
    deep[0] = 0.0
    ball = spherical(deep, theta, phi, ball_conductivity)
    bodies = Bodies()
    index = bodies.add(ball)
    nodes = [bodies.node() if on > 0.0 else -1 for on in (around.convection, around.emissivity)]
    surface, bare = index[-1], np.ones(ball.shape[1:])
    facing = (slice(0, north.size - 1), slice(None, -south.size, -1))
    for part, rows, temperature in zip((inner, outer), facing, temperatures, strict=True):
        bare[rows] = _join_ring(bodies, part, ball, (surface[rows], rows), phi, first, growth, around, nodes, temperature)
    _expose(bodies, surface, ball.half[0][1][-1], bare * ball.area[0][-1], around, nodes)
    solution, heat = bodies.solve(0.5 * sum(temperatures))
    skin = solution[surface.ravel()]
    conductance = 4.0 * heat[0] / (temperatures[0] - temperatures[1])
    return HeatPath(
        conductance,
        (heat[0] + heat[1]) / heat[0],
        (float(skin.min()), float(np.average(skin, weights=ball.area[0][-1].ravel())), float(skin.max())),
    )


def solve_bearing(
    bearing: AngularContactConductance, bore: float, outside: float, around: Surroundings | None = None, fineness: int = 3
) -> float:
    """Conductance in W/K from the bore to the outside (diameters in m, each at one temperature) under the present loads.

    Every ball's path is solved with the ellipses of its own load; a part of a ring is as thick as the ring under the raceway,
    and as large as its wall conducts. Then both rings are solved in radius and angle, with the balls between them, so that
    heat goes round to where the load is. Balls that carry the same to six digits are reckoned once; one that touches
    nothing, with nothing around it, not at all.
    """
    p: Any = bearing.parameters
    loads, ball = np.unique([float(f"{load:.6g}") for load in bearing.ball_loads], return_inverse=True)
    balls = np.zeros(loads.size)
    for i, load in enumerate(loads):
        if load == 0.0 and around is None:
            continue
        path = ball_path(bearing, load, bore, outside, around, fineness)
        parts = _ring_parts(bearing, load, bore, outside)
        walls = sum(part.thickness / (part.conductivity * part.area) for part in parts)
        balls[i] = path.conductance / (1.0 - path.conductance * walls)  # without the walls, which the rings add again
    return solve_rings(balls[ball], (bore, *bearing.raceways, outside), p["width"], p["ring_conductivity"])


def ball_path(
    bearing: AngularContactConductance,
    load: float,
    bore: float,
    outside: float,
    around: Surroundings | None = None,
    fineness: int = 3,
) -> HeatPath:
    """The path through one ball under a load in N with its parts of the rings; diameters in m as for `solve_bearing`."""
    p: Any = bearing.parameters
    inner, outer = _ring_parts(bearing, load, bore, outside)
    return solve_path(inner, outer, 0.5 * p["ball_diameter"], p["ball_conductivity"], around, fineness=fineness)


def _ring_parts(bearing: AngularContactConductance, load: float, bore: float, outside: float) -> tuple[RingPart, RingPart]:
    return _ring_part(bearing, "inner", load, bore), _ring_part(bearing, "outer", load, outside)


def solve_rings(balls: np.ndarray, diameters: tuple[float, float, float, float], width: float, conductivity: float) -> float:
    """Conductance in W/K of two rings, inner and outer diameter each in m, with balls (Z,) in W/K evenly spaced between them.

    Each ball's heat is spread over its pitch, because its own constriction is in its conductance.
    """
    per_ball = 6
    phi = np.linspace(0.0, 2.0 * math.pi, per_ball * balls.size + 1)
    bodies, faces = Bodies(), []
    for first, last, outer in ((*diameters[:2], False), (*diameters[2:], True)):
        ring = cylindrical(0.5 * np.linspace(first, last, 9), phi, [0.0, width], conductivity)
        index = bodies.add(ring, closed=1)
        raceway, far = (0, -1) if outer else (-1, 0)
        bodies.hold(index[far], 1.0 / ring.half[0][outer][far], 0.0 if outer else 1.0)
        faces.append((index[raceway], ring.half[0][not outer][raceway]))
    (inner, under), (outside, above) = faces
    through = np.repeat(balls, per_ball).reshape(inner.shape) / per_ball
    bodies.link(inner, outside, through / (1.0 + through * (under + above)))
    return float(bodies.solve(0.5)[1][0])


def _ring_part(bearing: AngularContactConductance, race: str, load: float, edge: float) -> RingPart:
    p: Any = bearing.parameters
    geometry = bearing.geometry()
    raceway = bearing.raceways[race == "outer"]
    along, across = (0.5 * axis for axis in geometry.contact(race, bearing.material()).axes(load))
    thickness = 0.5 * abs(raceway - edge)
    area = 2.0 * math.pi * p["width"] * thickness / abs(math.log(edge / raceway)) / p["balls"]
    return RingPart(along, across, geometry.radii(race), thickness, area, p["ring_conductivity"])


def _radii(spot: float, fineness: int, growth: float, end: float) -> np.ndarray:
    """Edges from the normal to `end`, m, finest around one at `spot`, where the contact ends along its short axis."""
    first = spot / fineness**1.5
    inside = spot - graded(first, growth, spot)[::-1]
    inside[0] = 0.0
    return np.concatenate([inside, spot + graded(first, growth, end - spot)[1:]])


def _angles(inner: RingPart, outer: RingPart, fineness: int) -> np.ndarray:
    """Edges of the angle about the normal from the long axis of the contact; finer towards the tip of a slender one."""
    slender = min((p.along / p.across for p in (inner, outer) if p.along > 0.0), default=1.0)
    return graded(0.5 * QUARTER * slender / fineness, 1.0 + 0.5 / fineness, QUARTER)


def _join_ring(bodies, part, ball, facing, phi, first, growth, around, nodes, temperature) -> np.ndarray:
    """Adds a ring, links it with the ball's cells that face it, and returns the share of those that stays bare."""
    surface, rows = facing
    n = surface.shape[0]
    radius = np.sqrt(part.area / math.pi)
    meeting = np.sqrt(2.0 * np.cumsum(np.r_[0.0, _cap_areas(ball, rows)]))
    beyond = meeting[-1] + graded(meeting[-1] - meeting[-2], growth, radius - meeting[-1])[1:]
    ring = cylindrical(np.r_[meeting, beyond], phi, graded(first, growth, part.thickness), part.conductivity)
    index = bodies.add(ring)
    bodies.hold(index[:, :, -1], 1.0 / ring.half[2][1][:, :, -1], temperature)
    here, area, inside = index[:, :, 0], ring.area[2][:, :, 0], ring.half[2][0][:, :, 0]
    share = _inside_ellipse(part, meeting, phi)
    outside = ball.half[0][1][-1][rows]
    with np.errstate(divide="ignore"):
        touching = share / (outside + inside[:n])
    bodies.link(surface, here[:n], touching)
    bare = np.ones(ring.shape[:2])
    bare[:n] -= share
    covered = np.zeros(ring.shape[:2])
    if around.gas_conductivity > 0.0:
        width = _gap(part, meeting, phi)
        covered[:n] = np.where(width < around.widest, bare[:n], 0.0)
        free = covered[:n] > 0.0
        gas = (width + around.closest) / (around.gas_conductivity * area[:n])
        bodies.link(surface[free], here[:n][free], (covered[:n] / (outside + inside[:n] + gas))[free])
    bare -= covered
    _expose(bodies, here, inside, bare * area, around, nodes)
    return bare[:n]


def _cap_areas(ball: Grid, rows: slice) -> np.ndarray:
    """Area over 2 pi of the ball's rings of cells about the contact, (n,) m2; the ring's cells get the same areas."""
    return ball.area[0][-1][rows].sum(1) / QUARTER


def _inside_ellipse(part: RingPart, rho: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Share of each cell of a plane inside the contact, (radii, angles)."""
    if part.along <= 0.0:
        return np.zeros((rho.size - 1, phi.size - 1))
    # in the middle of five equal parts of every cell's angle; along the radius the share is exact
    angle = phi[:-1, None] + np.diff(phi)[:, None] * (np.arange(5) + 0.5) / 5.0
    edge = 1.0 / ((np.cos(angle) / part.across) ** 2 + (np.sin(angle) / part.along) ** 2)
    low, high = rho[:-1, None, None] ** 2, rho[1:, None, None] ** 2
    return np.clip((edge - low) / (high - low), 0.0, 1.0).mean(2)


def _gap(part: RingPart, rho: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Width of the gap in the middle of each cell, (radii, angles) m: it opens at the edge of the contact."""
    square = 0.5 * (rho[:-1] ** 2 + rho[1:] ** 2)[:, None]
    angle = 0.5 * (phi[:-1] + phi[1:])
    edge = 0.0
    if part.along > 0.0:
        edge = 1.0 / ((np.cos(angle) / part.across) ** 2 + (np.sin(angle) / part.along) ** 2)
    return 0.5 * np.maximum(square - edge, 0.0) * (np.sin(angle) ** 2 / part.radii[0] + np.cos(angle) ** 2 / part.radii[1])


def _expose(bodies, cells, inside, area, around, nodes) -> None:
    """Surfaces to the air and to the enclosure; radiation leaves from the cell's centre, half a cell below the surface."""
    air, enclosure = nodes
    open_ = area > 0.0
    if around.convection > 0.0:
        bodies.link(cells[open_], air, 1.0 / (inside[open_] + 1.0 / (around.convection * area[open_])))
    if around.emissivity > 0.0:
        bodies.radiate(cells[open_], enclosure, around.emissivity * area[open_])
