"""Geometry of a catenary section as arrays: nodes, masses, stiffnesses, droppers, supports, static shape.

All wires share the node positions. Degrees of freedom are interleaved, j = W i + lane at node i, lane 0 the contact wire,
1 the messenger, so that one loop serves all and the system matrix has a small bandwidth. The first and the last node are
fixed. Displacements are deviations from the static equilibrium, positive upwards.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel, kernel_tuple
from ..core.linear import factor_band, solve_band
from .contact import FASTEST, SPEEDS, WireOnMesh, compliance_table, node_compliance
from .line.layout import GRAVITY, Layout
from .line.plan import (
    ADDED,
    CLAMPED_TO,
    CONTACT,
    DAMPING,
    FACTOR,
    FIRST,
    FROM,
    HEIGHT,
    HEIGHT_FROM,
    HEIGHT_TO,
    HOLD_HEIGHT,
    HOLD_MASS,
    LANE,
    LAST,
    LIFT,
    LOWER,
    MASS_ABOVE,
    MASS_BELOW,
    NO_TENSION,
    PLACE,
    SPRING_LANE,
    SPRING_PLACE,
    STIFFNESS,
    TO,
    WIRE,
    WORN,
    Plan,
)
from .stiffness import add_wire, product_at


@kernel_tuple
class Mesh(NamedTuple):
    """Arrays for the kernels; n nodes, W lanes, N = W n degrees of freedom, d droppers, s supports, k kinds of contact wire.

    Where a lane has no wire, nothing moves: mass and inverse mass are 0, the spring to the ground is rigid.
    """

    position: np.ndarray  # (n,) m
    length: np.ndarray  # (n,) m, element to the right of the node (last one 0)
    inverse_length: np.ndarray  # (N,) 1/m, of the element to the right of the node (0 at the last one)
    cell: float  # m, width of a cell of `node_of`
    node_of: np.ndarray  # int, last node at or left of the start of a cell
    mass: np.ndarray  # (N,) kg, lumped; infinite at the fixed ends
    inverse_mass: np.ndarray  # (N,) 1/kg
    tension: np.ndarray  # (N,) N, of the element to the left of the node
    curvature: np.ndarray  # (N,) N m, EI + T h²/12 over the mean length around the node
    bending_gradient: np.ndarray  # (W,) N m, h²/6 EI / h³ of each lane
    impedance: np.ndarray  # (N,) N.s/m, sqrt(T m) of the wire
    ground: np.ndarray  # (N,) N/m, springs to the ground: messenger supports, steady arms
    ground_damping: np.ndarray  # (N,) N.s/m
    dropper: np.ndarray  # (d,) int, node of the dropper
    lower: np.ndarray  # (d,) int, degree of freedom of its lower end
    upper: np.ndarray  # (d,) int, degree of freedom of its upper end
    dropper_stiffness: np.ndarray  # (d,) N/m
    preload: np.ndarray  # (d,) N, dropper tension in the static equilibrium
    support: np.ndarray  # (s,) int, node of the support
    height: np.ndarray  # (n,) or (2 n,) m, contact wires in the static equilibrium; 0 is the level of a clamp without pre-sag
    bow: np.ndarray  # as height, m, sag of the element to the right of the node below its chord, times 4
    kind: np.ndarray  # as height, int, which of the different contact wires
    compliance: np.ndarray  # (k SPEEDS,) m/N, what the mesh leaves out under a force that moves at 0 to `fastest`
    fastest: np.ndarray  # (k,) m/s
    sharpness: np.ndarray  # (k,) of the contact's shape function: 0 linear between two nodes, 1 a cubic through four
    jump: np.ndarray  # (j,) int, degrees of freedom at which the tension changes
    jump_change: np.ndarray  # (j,) N, tension to the left less that to the right
    clamped: np.ndarray  # (c,) int, ends of wires that are clamped to another wire
    clamp: np.ndarray  # (c,) int, degree of freedom of that wire


INTEGERS = ("node_of", "dropper", "lower", "upper", "support", "kind", "jump", "clamped", "clamp")
NUMBERS = tuple(f for f in Mesh._fields if f not in INTEGERS)
RIGID = 1e18  # N/m
NO_WIRE = 10.0  # m, height of a contact wire where there is none: out of reach
PUSHED = OWN + 8  # status of `initialize`
REFUSALS = {
    PUSHED: Refusal(
        "dropper at {refused[0]} m would carry {refused[1]} N at rest",
        "tension in every dropper",
        "Reduce the pre-sag or move the droppers.",
    )
}


@kernel_tuple
class Grid(NamedTuple):
    """Further structure of a mesh, to fill it with numbers; f places, k kinds of contact wire, j jumps."""

    node: np.ndarray  # (f,) int, of the places of a plan
    kind_of: np.ndarray  # (w,) int, kind of each wire, -1 of those that are no contact wires
    jump_side: np.ndarray  # (j,) int, -1 where a clamped wire begins, 1 where it ends, 0 within a wire
    element: np.ndarray  # (2,) m, m³, mean element


@kernel_tuple
class Discretisation(NamedTuple):
    """Numbers that decide how waves run along the mesh.

    time_error: s², the share that the time integration adds to the squared frequency omega² of a wave, over omega²/12.
    reading_error: s², what it adds to the contact's sharpness, over c²/h²; taken back there.
    """

    time_error: float
    reading_error: float
    alpha: float  # 1/s, damping
    beta: float  # s


@kernel
def discretisation(alpha, beta, implicit, filled, p):
    """How waves run along the mesh with the time integration.

    Verlet makes waves too fast by (omega h)²/24, the midpoint rule too slow by twice that; what each does to a force that moves
    at v and to the height read there goes with v²/c², taken at 1/2. Beyond 0.7 the series says nothing.
    """
    element_time = p.element * math.sqrt(filled.mass[0] / filled.tension[0])
    h2 = min(p.substep**2, 0.7 * element_time**2)
    if implicit:
        return Discretisation(2.0 * h2, 1.125 * h2, alpha, beta)
    return Discretisation(-h2, -0.75 * h2, alpha, beta)


@kernel_tuple
class Space(NamedTuple):
    """Workspace to fill a mesh of n nodes and N degrees of freedom."""

    nodal: np.ndarray  # (8, N)
    bands: np.ndarray  # (2, n, 4) of one wire


# rows of `nodal`: of the element to the right of the node its tension, N, and its mass, kg; weight on the node, N; lift of arms,
# N; compliance that the mesh leaves out, m/N; and of the nodes of one wire curvature, N m, height, m, and whether it is held
OVER_RIGHT, ELEMENT_MASS, WEIGHT, LIFTED, UNRESOLVED, CURVATURE, SHAPE, HELD = range(8)
CLAMPED = 2.0  # in `HELD`, at the ends of the wire and at droppers


def packed(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """All numbers and all indices of a mesh in one array each: handing 20 arrays to a kernel costs 3 us, two cost 0.3."""
    numbers = np.concatenate([np.atleast_1d(getattr(mesh, f)) for f in NUMBERS])
    sizes = [
        mesh.position.size,
        mesh.bending_gradient.size,
        mesh.dropper.size,
        mesh.support.size,
        mesh.node_of.size,
        mesh.height.size,
        mesh.fastest.size,
        mesh.jump.size,
        mesh.clamped.size,
    ]
    return numbers, np.concatenate((sizes, *(getattr(mesh, f) for f in INTEGERS)))


@kernel
def unpacked(numbers, indices):
    """The mesh that `packed` put away, as views."""
    n, W, d, s, c = indices[0], indices[1], indices[2], indices[3], indices[4]
    m, k, jumps, clamps = indices[5], indices[6], indices[7], indices[8]
    N = W * n
    i = numbers[2 * n :]  # behind position and length, in the order of the fields
    j = indices[9:]
    node_of, dropper, lower, upper, j = j[:c], j[c : c + d], j[c + d : c + 2 * d], j[c + 2 * d : c + 3 * d], j[c + 3 * d :]
    support, kind, j = j[:s], j[s : s + m], j[s + m :]
    jump, clamped, clamp = j[:jumps], j[jumps : jumps + clamps], j[jumps + clamps : jumps + 2 * clamps]
    inverse_length, cell, i = i[:N], i[N], i[N + 1 :]
    mass, inverse_mass, tension, curvature = i[:N], i[N : 2 * N], i[2 * N : 3 * N], i[3 * N : 4 * N]
    bending_gradient, impedance, i = i[4 * N : 4 * N + W], i[4 * N + W : 5 * N + W], i[5 * N + W :]
    ground, ground_damping, i = i[:N], i[N : 2 * N], i[2 * N :]
    dropper_stiffness, preload, i = i[:d], i[d : 2 * d], i[2 * d :]
    height, bow, i = i[:m], i[m : 2 * m], i[2 * m :]
    compliance, fastest, sharpness = i[: k * SPEEDS], i[k * SPEEDS : k * SPEEDS + k], i[k * SPEEDS + k : k * SPEEDS + 2 * k]
    jump_change = i[k * SPEEDS + 2 * k : k * SPEEDS + 2 * k + jumps]
    return Mesh(
        numbers[:n],
        numbers[n : 2 * n],
        inverse_length,
        cell,
        node_of,
        mass,
        inverse_mass,
        tension,
        curvature,
        bending_gradient,
        impedance,
        ground,
        ground_damping,
        dropper,
        lower,
        upper,
        dropper_stiffness,
        preload,
        support,
        height,
        bow,
        kind,
        compliance,
        fastest,
        sharpness,
        jump,
        jump_change,
        clamped,
        clamp,
    )


def node_positions(fixed: np.ndarray, element: float) -> np.ndarray:
    """Nodes at all given places, (k,) m, increasing; gaps between them in equal elements no longer than `element`, (n,) m."""
    counts = [max(1, math.ceil(gap / element - 1e-9)) for gap in np.diff(fixed)]
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in zip(pairwise(fixed), counts, strict=True)]
    return np.concatenate((*parts, fixed[-1:]))


def empty_mesh(layout: Layout, plan: Plan, element: float) -> tuple[Mesh, Grid]:
    """What of a mesh follows from structure; its numbers are 0. element: m, the longest."""
    x = node_positions(layout.places, element)
    n, W, wires = x.size, layout.lanes, layout.wires
    L = np.append(np.diff(x), 0.0)
    node = np.searchsorted(x, plan.place - 1e-6)
    at_dropper, (_, lower, upper) = node[plan.droppers[:, PLACE]], plan.droppers.T
    cell = float(L[:-1].min())
    node_of = np.searchsorted(x, cell * np.arange(math.ceil(x[-1] / cell) + 1), side="right") - 1
    contacts = len(layout.contact_lanes)
    kinds: list[tuple[float, ...]] = []
    kind, kind_of, jumps, clamps = np.zeros((contacts, n), dtype=np.int64), np.full(len(wires), -1), set(), []
    for row, (wire, (lane, a, b, clamped_to, contact, _)) in enumerate(zip(wires, plan.wires, strict=True)):
        a, b = node[a], node[b]
        if contact >= 0:
            own = (wire.tension, wire.mass, wire.bending, row if row in plan.fixed else -1)
            same = next((k for k, other in enumerate(kinds) if np.array_equal(own, other, equal_nan=True)), len(kinds))
            kinds += [own] if same == len(kinds) else []
            kind_of[row] = kind[contact, a : b + 1] = same
        mine = plan.stretches[:, WIRE] == row
        added = np.zeros(b - a)
        for (_, first, last), (change, _) in zip(plan.stretches[mine], plan.stretch_numbers[mine], strict=True):
            added[node[first] - a : node[last] - a] += change
        jumps |= {(W * (a + i + 1) + lane, 0) for i in np.flatnonzero(np.diff(added))}
        if clamped_to >= 0:
            clamps += [(W * i + lane, W * i + clamped_to) for i in (a, b)]
            jumps |= {(W * a + lane, -1), (W * b + lane, 1)}
    jump, clamp = (np.array(sorted(rows), dtype=np.int64).reshape(-1, 2) for rows in (jumps, clamps))
    N, d, numbers = W * n, at_dropper.size, np.zeros
    mean = float(L @ L / L.sum())
    mesh = Mesh(
        x,
        L,
        np.repeat(np.append(1.0 / L[:-1], 0.0), W),
        cell,
        node_of,
        numbers(N),
        numbers(N),
        numbers(N),
        numbers(N),
        numbers(W),
        numbers(N),
        numbers(N),
        numbers(N),
        at_dropper,
        W * at_dropper + lower,
        W * at_dropper + upper,
        numbers(d),
        numbers(d),
        np.searchsorted(x, layout.supports - 1e-6),
        numbers(kind.size),
        numbers(kind.size),
        kind.ravel(),
        numbers(SPEEDS * len(kinds)),
        numbers(len(kinds)),
        numbers(len(kinds)),
        jump[:, 0],
        numbers(len(jump)),
        clamp[:, 0],
        clamp[:, 1],
    )
    return mesh, Grid(node, kind_of, jump[:, 1].copy(), np.array([mean, mean**3]))


# -- kernels -----------------------------------------------------------------------------------------------------------
@kernel
def around(i, length):
    """Mean length of the elements about node i, m."""
    return 0.5 * (length[i] + length[i - 1]) if i > 0 else 0.5 * length[i]


@kernel
def fourth_order_term(tension, mass, element, time_error):
    """E4 = T h²/12, N m²: u_xx from five nodes is (1 - h² d²/12) d² u, d² the second difference.

    Less the part that the time step adds.
    """
    return max(tension * element**2 + time_error * tension**2 / mass, 0.0) / 12.0


@kernel
def wire_on_mesh(k, filled, element, way):
    """Wire k on elements of one length, m; way: `Discretisation`."""
    T, m, B = filled.tension[k], filled.mass[k], filled.bending[k]
    return WireOnMesh(
        T,
        m,
        B,
        element,
        fourth_order_term(T, m, element, way.time_error),
        B * element**2 / 6.0,
        way.time_error,
        1.0 + way.reading_error * T / m / element**2,
        way.alpha,
        way.beta,
    )


@kernel
def spread_wires(mesh, plan, filled, grid, way, space):
    """Tensions, masses and stiffnesses of the wires along the mesh; a status."""
    n, W, L = mesh.position.size, mesh.bending_gradient.size, mesh.length
    over_right, element_mass, unresolved = space.nodal[OVER_RIGHT], space.nodal[ELEMENT_MASS], space.nodal[UNRESOLVED]
    over_right[:], element_mass[:], unresolved[:] = 0.0, 0.0, 0.0
    for values in (mesh.mass, mesh.inverse_mass, mesh.tension, mesh.curvature, mesh.impedance, mesh.ground, mesh.ground_damping):
        values[:] = 0.0
    mesh.bending_gradient[:] = math.inf
    for k in range(plan.wires.shape[0]):
        lane, a, b = plan.wires[k, LANE], grid.node[plan.wires[k, FROM]], grid.node[plan.wires[k, TO]]
        for i in range(a, b):
            over_right[W * i + lane], element_mass[W * i + lane] = filled.tension[k], filled.mass[k] * L[i]
    for k in range(plan.stretches.shape[0]):
        lane = plan.wires[plan.stretches[k, WIRE], LANE]
        for i in range(grid.node[plan.stretches[k, FIRST]], grid.node[plan.stretches[k, LAST]]):
            over_right[W * i + lane] += plan.stretch_numbers[k, ADDED]
            element_mass[W * i + lane] *= plan.stretch_numbers[k, FACTOR]
    for k in range(plan.wires.shape[0]):
        lane, a, b = plan.wires[k, LANE], grid.node[plan.wires[k, FROM]], grid.node[plan.wires[k, TO]]
        wire = wire_on_mesh(k, filled, grid.element[0], way)
        left_out = node_compliance(wire)
        mesh.bending_gradient[lane] = min(mesh.bending_gradient[lane], wire.gradient / grid.element[1])
        least = math.inf
        for i in range(a, b + 1):
            j, here = W * i + lane, around(i, L)
            unresolved[j] = left_out
            if a == 0 and b == n - 1 and plan.wires[k, WORN] == 0:
                mesh.mass[j] += wire.mass * here
            else:
                mesh.mass[j] += 0.5 * ((element_mass[j] if i < b else 0.0) + (element_mass[j - W] if i > a else 0.0))
            if i > a:
                mesh.tension[j] = over_right[j - W]
                least = min(least, over_right[j - W])
            if a < i < b:
                smaller = min(over_right[j - W], over_right[j])
                mesh.inverse_mass[j] = 1.0  # there is a wire
                mesh.impedance[j] = math.sqrt(smaller * wire.mass)
                mesh.curvature[j] = wire.bending / here + fourth_order_term(smaller, wire.mass, here, way.time_error) / here
        if least <= 0.0:
            filled.refused[0] = least
            filled.refused[1], filled.refused[2] = mesh.position[a], mesh.position[b]
            return NO_TENSION
        if a == 0:
            mesh.tension[lane] = over_right[lane]
        if plan.wires[k, CLAMPED_TO] >= 0:
            for i in (W * a, W * b):
                mesh.mass[i + plan.wires[k, CLAMPED_TO]] += mesh.mass[i + lane]
                mesh.mass[i + lane] = 0.0
        if grid.kind_of[k] >= 0:
            kind = grid.kind_of[k]
            mesh.fastest[kind], mesh.sharpness[kind] = FASTEST * math.sqrt(wire.tension / wire.mass), wire.sharpness
            if mesh.compliance[SPEEDS * kind] == 0.0:
                compliance_table(wire, mesh.compliance[SPEEDS * kind : SPEEDS * kind + SPEEDS])
    for lane in range(W):
        if math.isinf(mesh.bending_gradient[lane]):
            mesh.bending_gradient[lane] = 0.0
    for k in range(mesh.jump.size):
        j = mesh.jump[k]
        before = over_right[j - W] if grid.jump_side[k] >= 0 else 0.0
        mesh.jump_change[k] = before - (over_right[j] if grid.jump_side[k] <= 0 else 0.0)
    return DONE


@kernel
def add_fittings(mesh, plan, filled, grid, space):
    """Droppers, supports and arms on the wires."""
    N, W = mesh.mass.size, mesh.bending_gradient.size
    weight, lifted, unresolved = space.nodal[WEIGHT], space.nodal[LIFTED], space.nodal[UNRESOLVED]
    for j in range(N):
        weight[j], lifted[j] = GRAVITY * mesh.mass[j], 0.0
    for ends, row in ((mesh.lower, MASS_BELOW), (mesh.upper, MASS_ABOVE)):
        for k in range(ends.size):
            mesh.mass[ends[k]] += filled.dropper[row, k]
            weight[ends[k]] += GRAVITY * filled.dropper[row, k]
    for k in range(mesh.dropper.size):
        left_out = unresolved[mesh.lower[k]] + unresolved[mesh.upper[k]]
        mesh.dropper_stiffness[k] = 1.0 / (1.0 / filled.dropper[STIFFNESS, k] + left_out)
    for k in range(plan.holds.shape[0]):
        own, lane = filled.hold[:, k], plan.holds[k, SPRING_LANE]
        j = W * grid.node[plan.holds[k, SPRING_PLACE]] + lane
        share = 1.0 if plan.lanes[lane] > 0 else 1.0 / (1.0 + unresolved[j] * own[STIFFNESS])
        mesh.ground[j] += share * own[STIFFNESS]
        mesh.ground_damping[j] += share**2 * own[DAMPING]
        mesh.mass[j] += own[HOLD_MASS]
        lifted[j] += own[LIFT]
    for k in range(mesh.clamped.size):
        mesh.inverse_mass[mesh.clamped[k]] = -1.0  # it moves with the wire that it is clamped to
    for j in range(N):
        exists, at_end = mesh.inverse_mass[j] > 0.0, j < W or j >= N - W
        if not exists:
            mesh.mass[j] = 0.0
            if mesh.inverse_mass[j] == 0.0 and not at_end:
                mesh.ground[j] = RIGID
        mesh.inverse_mass[j] = 1.0 / mesh.mass[j] if mesh.mass[j] > 0.0 else 0.0
        if at_end:
            mesh.mass[j], mesh.inverse_mass[j] = math.inf, 0.0


@kernel
def hang_wires_on_droppers(mesh, plan, filled, grid, space, sag):
    """Heights of the contact wires under their own weight, held by droppers and arms, and the tensions of the droppers.

    So does an auxiliary wire, behind those that it carries.  sag: whether heights keep it; else they are straight between clamps.
    """
    n, W, L, held, y = mesh.position.size, mesh.bending_gradient.size, mesh.length, space.nodal[HELD], space.nodal[SHAPE]
    mesh.height[:] = NO_WIRE
    mesh.bow[:] = 0.0
    for k in range(plan.wires.shape[0]):
        lane, contact = plan.wires[k, LANE], plan.wires[k, CONTACT]
        a, size = grid.node[plan.wires[k, FROM]], grid.node[plan.wires[k, TO]] - grid.node[plan.wires[k, FROM]] + 1
        if plan.lanes[lane] == 0:
            continue
        y[:size], held[:size] = 0.0, 0.0
        y[0], y[size - 1] = plan.wire_numbers[k, HEIGHT_FROM], plan.wire_numbers[k, HEIGHT_TO]
        held[0], held[size - 1] = CLAMPED, CLAMPED
        for m in range(plan.holds.shape[0]):
            i, height = grid.node[plan.holds[m, SPRING_PLACE]] - a, filled.hold[HOLD_HEIGHT, m]
            if plan.holds[m, SPRING_LANE] == lane and 0 < i < size - 1 and not math.isnan(height):
                y[i], held[i] = height, 1.0
        for m in range(mesh.dropper.size):
            i = mesh.dropper[m] - a
            if plan.droppers[m, LOWER] == lane and 0 <= i < size:
                y[i], held[i] = filled.dropper[HEIGHT, m], CLAMPED
        weight, lifted = space.nodal[WEIGHT, W * a + lane :: W], space.nodal[LIFTED, W * a + lane :: W]
        over_right, curvature = space.nodal[OVER_RIGHT, W * a + lane :: W], space.nodal[CURVATURE]
        for i in range(size):
            curvature[i] = filled.bending[k] / around(a + i, L) if 0 < i < size - 1 else 0.0
        band = space.bands[0, :size:1, ::1]
        band[:] = 0.0
        add_wire(over_right, curvature[::1], 0.0, L[a::1], band)  # exact at the nodes of a string
        work, load = space.bands[1], held[size : 2 * size]  # behind the nodes of the wire
        for i in range(size):
            load[i] = 0.0 if held[i] > 0.0 else -product_at(i, band, y[:size]) - (weight[i] - lifted[i])
            for m in range(4):  # rows and columns of held nodes become those of the identity
                bound = held[i] > 0.0 or (m > 0 and i + m < size and held[i + m] > 0.0)
                work[i, m] = (1.0 if m == 0 else 0.0) if bound else band[i, m]
        factor_band(work, 0, 0, size)
        solve_band(work, load, 0, size)
        for i in range(size):
            y[i] += load[i]
        for m in range(mesh.dropper.size):
            i = mesh.dropper[m] - a
            if plan.droppers[m, LOWER] == lane and 0 <= i < size:
                mesh.preload[m] = (weight[i] - lifted[i]) + product_at(i, band, y[:size])
                space.nodal[WEIGHT, mesh.upper[m]] += mesh.preload[m]
        at, before = contact * n + a, 0
        for i in range(size if contact >= 0 else 0):
            mesh.height[at + i] = y[i]
            if sag and i < size - 1:
                mesh.bow[at + i] = 4.0 * filled.mass[k] * GRAVITY * L[a + i] ** 2 / (8.0 * over_right[i])
            if not sag and held[i] == CLAMPED:
                left = mesh.position[a + before]
                for m in range(before + 1, i):
                    slope = (y[i] - y[before]) / (mesh.position[a + i] - left)
                    mesh.height[at + m] = slope * (mesh.position[a + m] - left) + y[before]
                before = i


@kernel
def find_pushed(mesh, refused):
    """Whether a dropper would push at rest: a status."""
    worst = 0
    for k in range(mesh.preload.size):
        if mesh.preload[k] < mesh.preload[worst]:
            worst = k
    if mesh.preload[worst] > 0.0:
        return DONE
    refused[0], refused[1] = mesh.position[mesh.dropper[worst]], mesh.preload[worst]
    return PUSHED
