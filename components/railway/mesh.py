"""Geometry of a catenary section as arrays: nodes, masses, stiffnesses, droppers, supports, static shape.

Both wires share the node positions. Degrees of freedom are interleaved, j = 2 i for the contact wire and 2 i + 1 for
the messenger wire at node i, so that one loop with stride 2 serves both and the system matrix has a small bandwidth.
The first and the last node are fixed. Displacements are deviations from the static equilibrium, positive upwards.
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

GRAVITY = 9.81  # m/s²


@kernel_tuple
class Mesh(NamedTuple):
    """Arrays for the kernels; n nodes, N = 2 n degrees of freedom, d droppers, s supports."""

    position: np.ndarray  # (n,) m
    length: np.ndarray  # (n,) m, element to the right of the node (last one 0)
    inverse_length: np.ndarray  # (N,) 1/m, of the element to the right of the node (0 at the last one)
    cell: float  # m, width of a cell of `node_of`
    node_of: np.ndarray  # int, last node at or left of the start of a cell
    mass: np.ndarray  # (N,) kg, lumped; infinite at the fixed ends
    inverse_mass: np.ndarray  # (N,) 1/kg
    tension: np.ndarray  # (N,) N
    curvature: np.ndarray  # (N,) N m, EI + T h²/12 over the mean length around the node
    bending_gradient: np.ndarray  # (2,) N m, h²/6 EI / h³ of the contact and the messenger wire
    impedance: np.ndarray  # (2,) N.s/m, sqrt(T m) of the contact and the messenger wire
    ground: np.ndarray  # (N,) N/m, springs to the ground: messenger supports, steady arms
    ground_damping: np.ndarray  # (N,) N.s/m
    dropper: np.ndarray  # (d,) int, node of the dropper
    dropper_stiffness: np.ndarray  # (d,) N/m
    preload: np.ndarray  # (d,) N, dropper tension in the static equilibrium
    support: np.ndarray  # (s,) int, node of the support
    height: np.ndarray  # (n,) m, contact wire in the static equilibrium; 0 is the level of a dropper clamp without pre-sag
    bow: np.ndarray  # (n,) m, sag of the element to the right of the node below its chord, times 4
    compliance: np.ndarray  # (SPEEDS,) m/N, what the mesh leaves out under a force that moves at 0 to `fastest`
    fastest: float  # m/s
    sharpness: float  # of the contact's shape function: 0 linear between two nodes, 1 a cubic through four


NUMBERS = tuple(f for f in Mesh._fields if f not in ("node_of", "dropper", "support"))


def packed(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """All numbers and all indices of a mesh in one array each: handing 20 arrays to a kernel costs 3 us, two cost 0.3."""
    numbers = np.concatenate([np.atleast_1d(getattr(mesh, f)) for f in NUMBERS])
    sizes = [mesh.position.size, mesh.dropper.size, mesh.support.size, mesh.node_of.size]
    return numbers, np.concatenate((sizes, mesh.node_of, mesh.dropper, mesh.support))


@kernel
def unpacked(numbers, indices):
    """The mesh that `packed` put away, as views."""
    n, d, s, c = indices[0], indices[1], indices[2], indices[3]
    N = 2 * n
    i = numbers[2 * n :]  # behind position and length, in the order of the fields
    node_of, dropper, support = indices[4 : 4 + c], indices[4 + c : 4 + c + d], indices[4 + c + d : 4 + c + d + s]
    inverse_length, cell, i = i[:N], i[N], i[N + 1 :]
    mass, inverse_mass, tension, curvature = i[:N], i[N : 2 * N], i[2 * N : 3 * N], i[3 * N : 4 * N]
    bending_gradient, impedance, i = i[4 * N : 4 * N + 2], i[4 * N + 2 : 4 * N + 4], i[4 * N + 4 :]
    ground, ground_damping, i = i[:N], i[N : 2 * N], i[2 * N :]
    dropper_stiffness, preload, i = i[:d], i[d : 2 * d], i[2 * d :]
    height, bow, i = i[:n], i[n:N], i[N:]
    return Mesh(numbers[:n], numbers[n:N], inverse_length, cell, node_of, mass, inverse_mass, tension, curvature,
                bending_gradient, impedance, ground, ground_damping, dropper, dropper_stiffness, preload, support, height, bow,
                i[:SPEEDS], i[SPEEDS], i[SPEEDS + 1])


def node_positions(supports: np.ndarray, droppers: np.ndarray, element: float) -> np.ndarray:
    """Nodes at every support and dropper, gaps between them cut into equal elements no longer than `element`, (n,) m."""
    fixed = np.unique(np.concatenate((supports, droppers)))
    counts = [max(1, math.ceil(gap / element - 1e-9)) for gap in np.diff(fixed)]
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in zip(pairwise(fixed), counts, strict=True)]
    return np.concatenate((*parts, fixed[-1:]))


def build_mesh(p, slack, bending, gravity_sag, pre_sag, damping, arm, level, time_error: float,
               reading_error: float) -> Mesh:
    """Mesh and static equilibrium for parameters and effects of `Catenary` (NamedTuples or None).

    time_error: s², the share that the time integration adds to the squared frequency omega² of a wave, over omega²/12.
    reading_error: s², what it adds to the contact's sharpness, over c²/h²; taken back there.
    """
    count = int(p.droppers)
    within = p.dropper_position[:count]
    if not (np.all(np.diff(within) > 0.0) and within[0] > 0.0 and within[-1] < p.span_length):
        expected = f"increasing values inside the span of {p.span_length:g} m"
        raise BadInput("Catenary", f"dropper positions {within.tolist()}", expected)
    supports = p.span_length * np.arange(p.spans + 1)
    droppers = (p.span_length * np.arange(p.spans)[:, None] + within).ravel()
    x = node_positions(supports, droppers, p.element)
    n = x.size
    L = np.append(np.diff(x), 0.0)
    at_support = np.searchsorted(x, supports - 1e-6)
    at_dropper = np.searchsorted(x, droppers - 1e-6)

    mass, tension, curvature = (np.zeros((n, 2)) for _ in range(3))
    ground, ground_damping, fourth_order = (np.zeros((n, 2)) for _ in range(3))
    around = 0.5 * (L + np.roll(L, 1))
    wires = wires_on_mesh(p, bending, damping, float(L @ L / L.sum()), time_error, reading_error)
    for j, wire in enumerate(wires):
        mass[:, j] = wire.mass * around
        tension[:, j] = wire.tension
        curvature[1:-1, j] = wire.bending / around[1:-1]
        fourth_order[1:-1, j] = fourth_order_term(wire.tension, wire.mass, around[1:-1], time_error) / around[1:-1]
    weight = GRAVITY * mass
    half_dropper = 0.5 * p.dropper_mass
    clamps = np.array([p.contact_clamp_mass + half_dropper, p.messenger_clamp_mass + half_dropper])
    mass[at_dropper] += clamps
    weight[at_dropper] += GRAVITY * clamps
    inner = at_support[1:-1]
    unresolved = [node_compliance(wire) for wire in wires]
    share = 1.0 / (1.0 + unresolved[1] * p.support_stiffness)
    ground[inner, 1] = share * p.support_stiffness
    ground_damping[inner, 1] = share**2 * p.support_damping
    if arm is not None:
        ground[inner, 0] = arm.stiffness
        mass[inner, 0] += arm.mass
    mass[[0, -1]] = np.inf

    clamp_height = np.zeros(droppers.size)
    if pre_sag is not None and count < 2:
        raise BadInput("Catenary", "pre_sag with one dropper in a span", "at least two: it is 0 at the first and at the last",
                       "Set droppers to 2 or more, or leave pre_sag off.")
    if pre_sag is not None:  # parabola through the first and the last dropper of a span
        a, b = within[0], within[-1]
        clamp_height = np.tile(-4.0 * pre_sag.depth * (within - a) * (b - within) / (b - a) ** 2, p.spans)
    contact_wire = stiffness_band(p.contact_wire_tension, curvature[:, 0], 0.0, L)  # exact at the nodes of a string
    height = _contact_wire_shape(contact_wire, weight[:, 0], at_dropper, clamp_height, inner, level)
    preload = (weight[:, 0] + banded_product(contact_wire, height))[at_dropper]
    if slack is not None and np.any(preload <= 0.0):
        k = int(np.argmin(preload))
        actual = f"dropper at {droppers[k]:g} m would carry {preload[k]:.3g} N at rest"
        raise BadInput("Catenary", actual, "tension in every dropper", "Reduce the pre-sag or move the droppers.")
    bow = 4.0 * p.contact_wire_mass * GRAVITY * L**2 / (8.0 * p.contact_wire_tension)
    if gravity_sag is None:  # straight lines between the clamps, level at the ends of the wire
        height = np.interp(x, np.concatenate((x[:1], droppers, x[-1:])), np.concatenate(([0.0], clamp_height, [0.0])))
        bow = np.zeros(n)

    cell = float(L[:-1].min())
    node_of = np.searchsorted(x, cell * np.arange(math.ceil(x[-1] / cell) + 1), side="right") - 1
    stiffness = np.full(droppers.size, 1.0 / (1.0 / p.dropper_stiffness + sum(unresolved)))
    impedance = np.sqrt([p.contact_wire_tension * p.contact_wire_mass, p.messenger_tension * p.messenger_mass])
    inverse_length = np.repeat(np.append(1.0 / L[:-1], 0.0), 2)
    gradient = np.array([wire.gradient / wire.element**3 for wire in wires])
    table = np.zeros(SPEEDS)
    compliance_table(wires[0], table)
    fastest = FASTEST * math.sqrt(p.contact_wire_tension / p.contact_wire_mass)
    return Mesh(x, L, inverse_length, cell, node_of, mass.ravel(), 1.0 / mass.ravel(), tension.ravel(),
                (curvature + fourth_order).ravel(), gradient, impedance, ground.ravel(), ground_damping.ravel(), at_dropper,
                stiffness, preload, at_support, height, bow, table, fastest, wires[0].sharpness)


def fourth_order_term(tension, mass, element, time_error):
    """E4 = T h²/12, N m²: u_xx from five nodes is (1 - h² d²/12) d² u, d² the second difference. Less what the time step adds."""
    return np.maximum(tension * element**2 + time_error * tension**2 / mass, 0.0) / 12.0


def wires_on_mesh(p, bending, damping, element: float, time_error: float, reading_error: float) -> list[WireOnMesh]:
    """Contact wire and messenger on elements of one length, m."""
    alpha, beta = (damping.alpha, damping.beta) if damping is not None else (0.0, 0.0)
    EI = (bending.contact_wire, bending.messenger) if bending is not None else (0.0, 0.0)
    wires = ((p.contact_wire_tension, p.contact_wire_mass, EI[0]), (p.messenger_tension, p.messenger_mass, EI[1]))
    return [WireOnMesh(T, m, B, element, float(fourth_order_term(T, m, element, time_error)), B * element**2 / 6.0, time_error,
                       1.0 + reading_error * T / m / element**2, alpha, beta) for T, m, B in wires]


def _contact_wire_shape(stiffness, weight, at_dropper, clamp_height, inner, level) -> np.ndarray:
    """Height of the contact wire hanging from its clamps under its own weight, (n,) m; stiffness: its band, (n, 4).

    `level` (an effect or None) holds the wire at height 0 at the supports; without it the wire hangs free there.
    """
    n = weight.size
    held = np.zeros(n, dtype=bool)
    y = np.zeros(n)
    held[[0, -1]] = True
    held[at_dropper] = True
    y[at_dropper] = clamp_height
    if level is not None:
        held[inner] = True
    load = np.where(held, 0.0, -banded_product(stiffness, y) - weight)
    band = stiffness.copy()
    band[held, 0] = 1.0  # rows and columns of held nodes become those of the identity
    for offset in (1, 2, 3):
        band[held, offset] = 0.0
        band[:-offset, offset][held[offset:]] = 0.0
    factor_band(band, 0, 0, n)
    solve_band(band, load, 0, n)
    return y + load


def stiffness_band(tension: float, curvature: np.ndarray, gradient: float, L: np.ndarray) -> np.ndarray:
    """Upper band of one wire's stiffness matrix, band[i, k] = K[i, i + k], (n, 4) N/m; curvature: (n,) N m, L: (n,) m.

    K = T times that of linear elements + the sum of c[i] kink[i]² + gradient (kink[i + 1] - kink[i])² over the inner nodes, where
    kink[i] = u[i-1]/l - u[i] (1/l + 1/r) + u[i+1]/r; the end nodes have none.
    """
    n, over = L.size, 1.0 / L[:-1]
    band = np.zeros((n, 4))
    band[:-1, 0] += tension * over
    band[1:, 0] += tension * over
    band[:-1, 1] -= tension * over
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


def stiffness_of_wires(mesh: Mesh, width: int) -> np.ndarray:
    """Upper band of the stiffness of both wires, interleaved, without droppers, supports and arms, (N, width) N/m.

    width: 5, or 7 with bending stiffness.
    """
    stiffness = np.zeros((mesh.mass.size, width))
    for wire in (0, 1):
        band = stiffness_band(mesh.tension[wire], mesh.curvature[wire::2], mesh.bending_gradient[wire], mesh.length)
        stiffness[wire::2, ::2] = band[:, : (width + 1) // 2]
    return stiffness


def add_droppers(band: np.ndarray, mesh: Mesh, taut) -> None:
    """Add the droppers' stiffness to a band of both wires; taut: 1 or (d,), 0 where a dropper is slack."""
    at, stiffness = 2 * mesh.dropper, mesh.dropper_stiffness * taut
    np.add.at(band[:, 0], at, stiffness)
    np.add.at(band[:, 0], at + 1, stiffness)
    np.subtract.at(band[:, 1], at, stiffness)
