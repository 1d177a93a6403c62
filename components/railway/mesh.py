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
    spread: np.ndarray  # (N,) kg, off-diagonal share of the element's mass to the right of the node
    tension: np.ndarray  # (N,) N/m, T / length of the element to the right
    curvature: np.ndarray  # (N,) N/m * m, EI / mean length around the node; 0 without bending stiffness
    impedance: np.ndarray  # (2,) N.s/m, sqrt(T m) of the contact and the messenger wire
    ground: np.ndarray  # (N,) N/m, springs to the ground: messenger supports, steady arms
    ground_damping: np.ndarray  # (N,) N.s/m
    dropper: np.ndarray  # (d,) int, node of the dropper
    dropper_stiffness: np.ndarray  # (d,) N/m
    preload: np.ndarray  # (d,) N, dropper tension in the static equilibrium
    support: np.ndarray  # (s,) int, node of the support
    height: np.ndarray  # (n,) m, contact wire in the static equilibrium; 0 is the level of a dropper clamp without pre-sag
    bow: np.ndarray  # (n,) m, sag of the element to the right of the node below its chord, times 4


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
    mass, inverse_mass, spread, tension, curvature = i[:N], i[N : 2 * N], i[2 * N : 3 * N], i[3 * N : 4 * N], i[4 * N : 5 * N]
    impedance, i = i[5 * N : 5 * N + 2], i[5 * N + 2 :]
    ground, ground_damping, i = i[:N], i[N : 2 * N], i[2 * N :]
    dropper_stiffness, preload, height, bow = i[:d], i[d : 2 * d], i[2 * d : 2 * d + n], i[2 * d + n : 2 * d + N]
    return Mesh(numbers[:n], numbers[n:N], inverse_length, cell, node_of, mass, inverse_mass, spread, tension, curvature,
                impedance, ground, ground_damping, dropper, dropper_stiffness, preload, support, height, bow)


def node_positions(supports: np.ndarray, droppers: np.ndarray, element: float) -> np.ndarray:
    """Nodes at every support and dropper, gaps between them cut into equal elements no longer than `element`, (n,) m."""
    fixed = np.unique(np.concatenate((supports, droppers)))
    counts = [max(1, math.ceil(gap / element - 1e-9)) for gap in np.diff(fixed)]
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in zip(pairwise(fixed), counts, strict=True)]
    return np.concatenate((*parts, fixed[-1:]))


def build_mesh(p, slack, bending, gravity_sag, pre_sag, arm, level, spread_factor: float) -> Mesh:
    """Mesh and static equilibrium for parameters and effects of `Catenary` (NamedTuples or None).

    spread_factor: 0 lumped mass, 1 consistent mass of linear elements; in between for less dispersion.
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

    mass, spread, tension, curvature = (np.zeros((n, 2)) for _ in range(4))
    ground, ground_damping = np.zeros((n, 2)), np.zeros((n, 2))
    around = 0.5 * (L + np.roll(L, 1))
    for wire, (T, m) in enumerate(((p.contact_wire_tension, p.contact_wire_mass), (p.messenger_tension, p.messenger_mass))):
        mass[:, wire] = m * around
        spread[:, wire] = spread_factor * m * L / 6.0
        tension[:-1, wire] = T / L[:-1]
        if bending is not None:
            curvature[1:-1, wire] = (bending.contact_wire, bending.messenger)[wire] / around[1:-1]
    weight = GRAVITY * mass
    half_dropper = 0.5 * p.dropper_mass
    clamps = np.array([p.contact_clamp_mass + half_dropper, p.messenger_clamp_mass + half_dropper])
    mass[at_dropper] += clamps
    weight[at_dropper] += GRAVITY * clamps
    inner = at_support[1:-1]
    ground[inner, 1] = p.support_stiffness
    ground_damping[inner, 1] = p.support_damping
    if arm is not None:
        ground[inner, 0] = arm.stiffness
        mass[inner, 0] += arm.mass
    mass[[0, -1]] = np.inf

    clamp_height = np.zeros(droppers.size)
    if pre_sag is not None:  # parabola through the first and the last dropper of a span
        a, b = within[0], within[-1]
        clamp_height = np.tile(-4.0 * pre_sag.depth * (within - a) * (b - within) / (b - a) ** 2, p.spans)
    contact_wire = stiffness_band(tension[:, 0], curvature[:, 0], L)
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
    stiffness = np.full(droppers.size, p.dropper_stiffness)
    impedance = np.sqrt([p.contact_wire_tension * p.contact_wire_mass, p.messenger_tension * p.messenger_mass])
    inverse_length = np.repeat(np.append(1.0 / L[:-1], 0.0), 2)
    return Mesh(x, L, inverse_length, cell, node_of, mass.ravel(), 1.0 / mass.ravel(), spread.ravel(), tension.ravel(),
                curvature.ravel(), impedance, ground.ravel(), ground_damping.ravel(), at_dropper, stiffness, preload, at_support,
                height, bow)


def _contact_wire_shape(stiffness, weight, at_dropper, clamp_height, inner, level) -> np.ndarray:
    """Height of the contact wire hanging from its clamps under its own weight, (n,) m; stiffness: its band, (n, 3).

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
    for offset in (1, 2):
        band[held, offset] = 0.0
        band[:-offset, offset][held[offset:]] = 0.0
    factor_band(band, 0, 0, n)
    solve_band(band, load, 0, n)
    return y + load


def stiffness_band(tension: np.ndarray, curvature: np.ndarray, L: np.ndarray) -> np.ndarray:
    """Upper band of one wire's stiffness matrix, band[i, k] = K[i, i + k], (n, 3) N/m."""
    n = tension.size
    band = np.zeros((n, 3))
    band[:-1, 0] += tension[:-1]
    band[1:, 0] += tension[:-1]
    band[:-1, 1] -= tension[:-1]
    inner = np.arange(1, n - 1)  # the moment at node i is curvature * (u[i-1] / l - u[i] (1/l + 1/r) + u[i+1] / r)
    left, right, c = 1.0 / L[inner - 1], 1.0 / L[inner], curvature[inner]
    band[inner - 1, 0] += c * left**2
    band[inner, 0] += c * (left + right) ** 2
    band[inner + 1, 0] += c * right**2
    band[inner - 1, 1] -= c * left * (left + right)
    band[inner, 1] -= c * right * (left + right)
    band[inner - 1, 2] += c * left * right
    return band


def system_bands(mesh: Mesh, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Upper bands of mass and stiffness of both wires, interleaved, without droppers, supports and arms, (N, width).

    width: 3 for strings, 5 with bending stiffness. The rows of the fixed end nodes are not meant to be used.
    """
    N = mesh.mass.size
    mass, stiffness = np.zeros((N, width)), np.zeros((N, width))
    mass[:, 0] = np.where(np.isinf(mesh.mass), 1.0, mesh.mass) - mesh.spread - np.roll(mesh.spread, 2)
    mass[:, 2] = mesh.spread
    for wire in (0, 1):
        band = stiffness_band(mesh.tension[wire::2], mesh.curvature[wire::2], mesh.length)
        stiffness[wire::2, ::2] = band[:, : (width + 1) // 2]
    return mass, stiffness


def add_droppers(band: np.ndarray, mesh: Mesh, taut) -> None:
    """Add the droppers' stiffness to a band of both wires; taut: 1 or (d,), 0 where a dropper is slack."""
    at, stiffness = 2 * mesh.dropper, mesh.dropper_stiffness * taut
    np.add.at(band[:, 0], at, stiffness)
    np.add.at(band[:, 0], at + 1, stiffness)
    np.subtract.at(band[:, 1], at, stiffness)
