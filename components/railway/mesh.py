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

from ..core.banded import banded_product, factor_band, solve_band
from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from .contact import FASTEST, SPEEDS, WireOnMesh, compliance_table, node_compliance
from .line.layout import GRAVITY, Layout, Wire


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


def packed(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """All numbers and all indices of a mesh in one array each: handing 20 arrays to a kernel costs 3 us, two cost 0.3."""
    numbers = np.concatenate([np.atleast_1d(getattr(mesh, f)) for f in NUMBERS])
    sizes = [mesh.position.size, mesh.bending_gradient.size, mesh.dropper.size, mesh.support.size, mesh.node_of.size,
             mesh.height.size, mesh.fastest.size, mesh.jump.size, mesh.clamped.size]
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
    return Mesh(numbers[:n], numbers[n : 2 * n], inverse_length, cell, node_of, mass, inverse_mass, tension, curvature,
                bending_gradient, impedance, ground, ground_damping, dropper, lower, upper, dropper_stiffness, preload, support,
                height, bow, kind, compliance, fastest, sharpness, jump, jump_change, clamped, clamp)


def node_positions(fixed: np.ndarray, element: float) -> np.ndarray:
    """Nodes at all given places, (k,) m, increasing; gaps between them in equal elements no longer than `element`, (n,) m."""
    counts = [max(1, math.ceil(gap / element - 1e-9)) for gap in np.diff(fixed)]
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in zip(pairwise(fixed), counts, strict=True)]
    return np.concatenate((*parts, fixed[-1:]))


def build_mesh(layout: Layout, element: float, slack, gravity_sag, damping, time_error: float, reading_error: float) -> Mesh:
    """Mesh and static equilibrium of a layout; effects of `Catenary` are NamedTuples or None.

    element: m, the longest.  time_error: s², the share that the time integration adds to the squared frequency omega² of a wave,
    over omega²/12.  reading_error: s², what it adds to the contact's sharpness, over c²/h²; taken back there.
    """
    x = node_positions(layout.places, element)
    n, W = x.size, layout.lanes
    L = np.append(np.diff(x), 0.0)
    at_support, at_dropper = node_at(x, layout.supports), node_at(x, layout.droppers.position)
    lower, upper = layout.droppers.lower, layout.droppers.upper
    around = 0.5 * (L + np.roll(L, 1))
    mean_element = float(L @ L / L.sum())
    wires = [wire_on_mesh(w, damping, mean_element, time_error, reading_error) for w in layout.wires]

    mass, tension, curvature, fourth_order, impedance, ground, ground_damping, lift = (np.zeros((n, W)) for _ in range(8))
    exists = np.zeros((n, W), dtype=bool)
    over_right = np.zeros((n, W))  # N, tension of the element to the right
    gradient = np.full(W, np.inf)
    jumps, clamps = [], []
    for wire, on_mesh in zip(layout.wires, wires, strict=True):
        j, (a, b) = wire.lane, node_at(x, np.array([wire.start, wire.end]))
        exists[a + 1 : b, j] = True
        part = slice(a, b + 1)
        mass[part, j] += own_mass(wire, x[part], L[part], around[part] if (a, b) == (0, n - 1) else None)
        T = np.full(b - a, wire.tension)
        for change in wire.tension_changes:
            T[slice(*(node_at(x, np.array([change.start, change.end])) - a))] += change.value
        if np.any(T <= 0.0):
            raise BadInput("Catenary", f"a tension of {T.min():g} N in a wire from {wire.start:g} to {wire.end:g} m",
                           "a positive one", "Reduce what the stitch wires take off the messenger.")
        tension[a + 1 : b + 1, j] = T
        over_right[a:b, j] = T
        if a == 0:
            tension[0, j] = T[0]
        least = np.minimum(T[:-1], T[1:])
        impedance[a + 1 : b, j] = np.sqrt(least * wire.mass)
        inside = around[a + 1 : b]
        curvature[a + 1 : b, j] = wire.bending / inside
        fourth_order[a + 1 : b, j] = fourth_order_term(least, wire.mass, inside, time_error) / inside
        gradient[j] = min(gradient[j], on_mesh.gradient / on_mesh.element**3)
        if wire.clamped_to is not None:
            mass[[a, b], wire.clamped_to] += mass[[a, b], j]
            mass[[a, b], j] = 0.0
            clamps += [(W * i + j, W * i + wire.clamped_to) for i in (a, b)]
        jumps += [(W * i + j, T[i - a - 1] - T[i - a]) for i in range(a + 1, b) if T[i - a - 1] != T[i - a]]
        if wire.clamped_to is not None:
            jumps += [(W * a + j, -T[0]), (W * b + j, T[-1])]
    weight = GRAVITY * mass
    np.add.at(mass, (at_dropper, lower), layout.droppers.mass_below)
    np.add.at(mass, (at_dropper, upper), layout.droppers.mass_above)
    np.add.at(weight, (at_dropper, lower), GRAVITY * layout.droppers.mass_below)
    np.add.at(weight, (at_dropper, upper), GRAVITY * layout.droppers.mass_above)

    unresolved = np.zeros((n, W))
    for wire, on_mesh in zip(layout.wires, wires, strict=True):
        a, b = node_at(x, np.array([wire.start, wire.end]))
        unresolved[a : b + 1, wire.lane] = node_compliance(on_mesh)
    holds = layout.holds
    at_hold = node_at(x, holds.position), holds.lane
    share = np.where(np.isin(holds.lane, layout.contact_lanes), 1.0, 1.0 / (1.0 + unresolved[at_hold] * holds.stiffness))
    np.add.at(ground, at_hold, share * holds.stiffness)
    np.add.at(ground_damping, at_hold, share**2 * holds.damping)
    np.add.at(mass, at_hold, holds.mass)
    np.add.at(lift, at_hold, holds.lift)

    tied = np.zeros((n, W), dtype=bool)
    tied.ravel()[[c for c, _ in clamps]] = True
    absent = ~exists & ~tied
    absent[[0, -1]] = False
    mass[~exists] = 0.0
    ground[absent] = RIGID
    inverse_mass = np.divide(1.0, mass, out=np.zeros((n, W)), where=mass > 0.0)
    mass[[0, -1]], inverse_mass[[0, -1]] = np.inf, 0.0

    contacts = len(layout.contact_lanes)
    height, bow, kind = np.full((contacts, n), NO_WIRE), np.zeros((contacts, n)), np.zeros((contacts, n), dtype=np.int64)
    preload = np.zeros(at_dropper.size)
    kinds: list[WireOnMesh] = []
    for wire, on_mesh in zip(layout.wires, wires, strict=True):
        if wire.lane not in layout.contact_lanes:
            continue
        a, b = node_at(x, np.array([wire.start, wire.end]))
        part, lane, c = slice(a, b + 1), wire.lane, wire.lane // 2
        mine = (lower == lane) & (at_dropper >= a) & (at_dropper <= b)
        on, clamp_height = at_dropper[mine], layout.droppers.height[mine]
        own = np.append(L[a:b], 0.0)
        band = stiffness_band(over_right[part, lane], curvature[part, lane], 0.0, own)  # exact at the nodes of a string
        hold = (holds.lane == lane) & (at_hold[0] > a) & (at_hold[0] < b) & ~np.isnan(holds.height)
        held = np.concatenate(([a, b], at_hold[0][hold], on)) - a
        values = np.concatenate((wire.heights, holds.height[hold], clamp_height))
        down = weight[part, lane] - lift[part, lane]
        y = contact_wire_shape(band, down, held, values)
        preload[mine] = (down + banded_product(band, y))[on - a]
        height[c, part] = y
        bow[c, a:b] = 4.0 * wire.mass * GRAVITY * L[a:b] ** 2 / (8.0 * over_right[a:b, lane])
        if gravity_sag is None:  # straight lines between the clamps
            height[c, part] = np.interp(x[part], x[np.concatenate(([a], on, [b]))],
                                        np.concatenate((wire.heights[:1], clamp_height, wire.heights[1:])))
            bow[c] = 0.0
        if on_mesh not in kinds:
            kinds.append(on_mesh)
        kind[c, part] = kinds.index(on_mesh)
    if slack is not None and np.any(preload <= 0.0):
        k = int(np.argmin(preload))
        actual = f"dropper at {layout.droppers.position[k]:g} m would carry {preload[k]:.3g} N at rest"
        raise BadInput("Catenary", actual, "tension in every dropper", "Reduce the pre-sag or move the droppers.")

    cell = float(L[:-1].min())
    node_of = np.searchsorted(x, cell * np.arange(math.ceil(x[-1] / cell) + 1), side="right") - 1
    stiffness = 1.0 / (1.0 / layout.droppers.stiffness + (unresolved[at_dropper, lower] + unresolved[at_dropper, upper]))
    inverse_length = np.repeat(np.append(1.0 / L[:-1], 0.0), W)
    tables = np.zeros((len(kinds), SPEEDS))
    for row, one in zip(tables, kinds, strict=True):
        compliance_table(one, row)
    fastest = np.array([FASTEST * math.sqrt(w.tension / w.mass) for w in kinds])
    jumps.sort()
    clamps.sort()
    return Mesh(x, L, inverse_length, cell, node_of, mass.ravel(), inverse_mass.ravel(), tension.ravel(),
                (curvature + fourth_order).ravel(), np.where(np.isinf(gradient), 0.0, gradient), impedance.ravel(),
                ground.ravel(), ground_damping.ravel(), at_dropper, W * at_dropper + lower, W * at_dropper + upper, stiffness,
                preload, at_support, height.ravel(), bow.ravel(), kind.ravel(), tables.ravel(), fastest,
                np.array([w.sharpness for w in kinds]),
                np.array([j for j, _ in jumps], dtype=np.int64), np.array([c for _, c in jumps], dtype=float),
                np.array([a for a, _ in clamps], dtype=np.int64), np.array([b for _, b in clamps], dtype=np.int64))


def node_at(x: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Nodes at positions that the mesh has, (k,) int."""
    return np.searchsorted(x, positions - 1e-6)


def own_mass(wire: Wire, x: np.ndarray, L: np.ndarray, around: np.ndarray | None) -> np.ndarray:
    """Mass of a wire at its nodes x (k,) m, kg: half of the elements to either side. around: that length, of a whole line."""
    if around is not None and not wire.masses:
        return wire.mass * around
    element = wire.mass * L[:-1]
    middle = 0.5 * (x[:-1] + x[1:])
    for part in wire.masses:
        element = np.where((middle > part.start) & (middle < part.end), part.value * element, element)
    return 0.5 * (np.append(element, 0.0) + np.append(0.0, element))


def fourth_order_term(tension, mass, element, time_error):
    """E4 = T h²/12, N m²: u_xx from five nodes is (1 - h² d²/12) d² u, d² the second difference. Less what the time step adds."""
    return np.maximum(tension * element**2 + time_error * tension**2 / mass, 0.0) / 12.0


def wire_on_mesh(wire: Wire, damping, element: float, time_error: float, reading_error: float) -> WireOnMesh:
    """A wire on elements of one length, m."""
    alpha, beta = (damping.alpha, damping.beta) if damping is not None else (0.0, 0.0)
    T, m, B = wire.tension, wire.mass, wire.bending
    return WireOnMesh(T, m, B, element, float(fourth_order_term(T, m, element, time_error)), B * element**2 / 6.0, time_error,
                      1.0 + reading_error * T / m / element**2, alpha, beta)


def contact_wire_shape(stiffness, weight, held_at, heights) -> np.ndarray:
    """Height of a contact wire under its own weight, held at some nodes at given heights, (n,) m; stiffness: its band, (n, 4)."""
    n = weight.size
    held = np.zeros(n, dtype=bool)
    y = np.zeros(n)
    held[held_at] = True
    y[held_at] = heights
    load = np.where(held, 0.0, -banded_product(stiffness, y) - weight)
    band = stiffness.copy()
    band[held, 0] = 1.0  # rows and columns of held nodes become those of the identity
    for offset in (1, 2, 3):
        band[held, offset] = 0.0
        band[:-offset, offset][held[offset:]] = 0.0
    factor_band(band, 0, 0, n)
    solve_band(band, load, 0, n)
    return y + load


def stiffness_band(tension: np.ndarray, curvature: np.ndarray, gradient: float, L: np.ndarray) -> np.ndarray:
    """Upper band of one wire's stiffness matrix, band[i, k] = K[i, i + k], (n, 4) N/m.

    tension: (n,) N, curvature: (n,) N m, L: (n,) m; tension and length of the element to the right of the node.

    K = T times that of linear elements + the sum of c[i] kink[i]² + gradient (kink[i + 1] - kink[i])² over the inner nodes, where
    kink[i] = u[i-1]/l - u[i] (1/l + 1/r) + u[i+1]/r; the end nodes have none.
    """
    n, over = L.size, 1.0 / L[:-1]
    band = np.zeros((n, 4))
    band[:-1, 0] += tension[:-1] * over
    band[1:, 0] += tension[:-1] * over
    band[:-1, 1] -= tension[:-1] * over
    kink = np.stack((over[:-1], -over[:-1] - over[1:], over[1:]))  # (3, n - 2), of the nodes to the left, here, to the right
    c = curvature[1:-1] + 2.0 * gradient
    for i in range(3):
        for j in range(3):
            if j >= i:
                band[i : n - 2 + i, j - i] += c * kink[i] * kink[j]
            shift = j + 1 - i  # with the kink of the next node
            first = min(i, j + 1)
            count = 2.0 if shift == 0 else 1.0
            band[first : n - 3 + first, abs(shift)] -= count * gradient * kink[i, :-1] * kink[j, 1:]
    return band


def stiffness_of_wires(mesh: Mesh, reach: int) -> np.ndarray:
    """Upper band of the stiffness of all wires, interleaved, without droppers, clamps, supports and arms, (N, reach W + 1) N/m.

    reach: 2, or 3 nodes with bending stiffness.
    """
    W = mesh.bending_gradient.size
    stiffness = np.zeros((mesh.mass.size, reach * W + 1))
    for wire in range(W):
        tension = np.append(mesh.tension[wire::W][1:], 0.0)
        band = stiffness_band(tension, mesh.curvature[wire::W], mesh.bending_gradient[wire], mesh.length)
        stiffness[wire::W, ::W] = band[:, : reach + 1]
    return stiffness


def diagonals_of_wires(mesh: Mesh, reach: int, pad: int) -> np.ndarray:
    """The same matrix by diagonals: row k has K[j, j + k W] at j + pad W, behind zeros, (reach + 1, N + pad W) N/m."""
    W, N = mesh.bending_gradient.size, mesh.mass.size
    diagonals = np.zeros((reach + 1, N + pad * W))
    diagonals[:, pad * W :] = stiffness_of_wires(mesh, reach)[:, ::W].T
    return diagonals


def add_droppers(band: np.ndarray, mesh: Mesh, taut) -> None:
    """Add the droppers' stiffness to a band of all wires; taut: 1 or (d,), 0 where a dropper is slack."""
    add_springs(band, mesh.lower, mesh.upper, mesh.dropper_stiffness * taut)


def add_springs(band: np.ndarray, one: np.ndarray, other: np.ndarray, stiffness) -> None:
    """Add springs between degrees of freedom, (k,) each, to an upper band; stiffness: (k,) or one, N/m."""
    np.add.at(band[:, 0], one, stiffness)
    np.add.at(band[:, 0], other, stiffness)
    np.subtract.at(band, (np.minimum(one, other), np.abs(one - other)), stiffness)
