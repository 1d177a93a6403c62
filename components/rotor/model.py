"""A shaft with disks and springs to the ground as banded matrices.

Four degrees of freedom a node, j = 4 node + (0: x, 1: y, 2: tilt_x, 3: tilt_y); tilt_x and tilt_y are the section's rotation
about x and y, tilt_y = dx/dz and tilt_x = -dy/dz without shear. Both planes of bending have the same matrices, so that
a rotation of the whole by 90 degrees, S: (x, y, tilt_x, tilt_y) -> (y, -x, tilt_y, -tilt_x), commutes with them.

    M q'' + (C + Omega G) q' + (K + Omega H) q = f,    G = 2 R S,    H = eta K_shaft S

with R the rotary inertia about a diameter (disks: I_p instead of 2 I_d) and eta the internal damping of the shaft, which is
viscous in the rotating frame: its force is -eta K_shaft (q' + Omega S q).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import kernel
from .elements import Section, element_mass, element_rotary_inertia, element_stiffness

DOFS = 4  # of a node
HALF = 2 * DOFS - 1  # half bandwidth: an element joins neighbouring nodes
WIDTH = 2 * HALF + 1
# degrees of freedom of an element's two nodes that bend in one plane, and their signs as tilt_x = -dy/dz has it
PLANES = ((0, 3, 4, 7), (1, 2, 5, 6))
SIGNS = ((1.0, 1.0, 1.0, 1.0), (1.0, -1.0, 1.0, -1.0))


class Matrices(NamedTuple):
    """The terms of the equation of motion, (N, N) each as dense matrices, (N, 15) each as bands."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    gyroscopic: np.ndarray  # G, times the speed in rad/s
    circulatory: np.ndarray  # H, times the speed in rad/s


def most_nodes(length: float, element: float, fixed: int) -> int:
    """Number of nodes that `place_nodes` never exceeds with so many fixed positions."""
    return int(length / element) + fixed + 3


@kernel
def place_nodes(length, places, element, nodes):
    """Nodes at both ends and every place, gaps between them cut into equal elements not longer than `element`; their number.

    Positions closer to one another than a millionth of the length share a node.  places: (k + 2,) m, in any order, of which the
    first two become the ends; it is lost.  nodes: (at least `most_nodes`,) m, written.
    """
    places[0], places[1] = 0.0, length
    for i in range(1, places.size):
        place, j = places[i], i - 1
        while j >= 0 and places[j] > place:
            places[j + 1] = places[j]
            j -= 1
        places[j + 1] = place
    kept, before = 1, places[0]
    for i in range(1, places.size):
        place = places[i]
        if place - before > 1e-6 * length:
            places[kept] = place
            kept += 1
        before = place
    places[kept - 1] = length
    count = 0
    for i in range(kept - 1):
        gap = places[i + 1] - places[i]
        parts = max(1, math.ceil(gap / element - 1e-6))
        for k in range(parts):
            nodes[count] = k * (gap / parts) + places[i]
            count += 1
    nodes[count] = length
    return count + 1


@kernel
def nearest_node(nodes, position):
    """Index of the node at a position."""
    nearest = 0
    for i in range(nodes.size):
        if abs(nodes[i] - position) < abs(nodes[nearest] - position):
            nearest = i
    return nearest


@kernel
def assemble_shaft(sections, nodes, deflection, rotary, stiffness, matrix):
    """Bands of a bare shaft with these nodes, m: deflection's and tilting's inertia, stiffness.

    sections: (n, 5) of each the end, m, at which there is a node, and the numbers of `Section`.  deflection, rotary, stiffness: (N, 15),
    written.  matrix: (4, 4), work.
    """
    deflection[:] = 0.0
    rotary[:] = 0.0
    stiffness[:] = 0.0
    k = 0
    for node in range(nodes.size - 1):
        L = nodes[node + 1] - nodes[node]
        while k < sections.shape[0] - 1 and 0.5 * (nodes[node] + nodes[node + 1]) > sections[k, 0]:
            k += 1
        section = Section(sections[k, 1], sections[k, 2], sections[k, 3], sections[k, 4])
        element_mass(section, L, matrix)
        add_element(deflection, node, matrix)
        element_rotary_inertia(section, L, matrix)
        add_element(rotary, node, matrix)
        element_stiffness(section, L, matrix)
        add_element(stiffness, node, matrix)


@kernel
def add_element(band, node, matrix):
    """Add the matrix of an element behind a node, (4, 4) of one plane, to the band of both planes."""
    for plane in range(2):
        for a in range(4):
            i = PLANES[plane][a]
            for b in range(4):
                band[DOFS * node + i, HALF + PLANES[plane][b] - i] += SIGNS[plane][a] * SIGNS[plane][b] * matrix[a, b]


@kernel
def turn(band, factor, result):
    """factor A S into (N, 15): the columns of x and y, and of tilt_x and tilt_y, change places.

    (A S q)_i = sum A_ij (S q)_j with S q = (y, -x, tilt_y, -tilt_x), so that column y gets A's column x, and x minus column y.
    """
    n = band.shape[0]
    result[:] = 0.0
    for i in range(n):
        for k in range(max(-HALF, -i), min(HALF, n - 1 - i) + 1):
            if (i + k) % 2 == 0:  # a column of x or tilt_x; it goes to the next one, one of y or tilt_y to the one before
                if k < HALF:
                    result[i, HALF + k + 1] += factor * band[i, HALF + k]
            elif k > -HALF:
                result[i, HALF + k - 1] -= factor * band[i, HALF + k]


@kernel
def add_disk(band, node, mass, diametral_inertia):
    """Add a disk's inertia to the band of the mass matrix."""
    j = DOFS * node
    band[j, HALF] += mass
    band[j + 1, HALF] += mass
    band[j + 2, HALF] += diametral_inertia
    band[j + 3, HALF] += diametral_inertia


@kernel
def add_disk_gyroscopic(band, node, polar_inertia):
    """Add a disk's I_p S to the band of the gyroscopic matrix."""
    j = DOFS * node + 2
    band[j, HALF + 1] += polar_inertia
    band[j + 1, HALF - 1] -= polar_inertia


@kernel
def add_band(factor, band, result):
    """result += factor * band."""
    for i in range(band.shape[0]):
        for k in range(band.shape[1]):
            result[i, k] += factor * band[i, k]


def dense(band: np.ndarray) -> np.ndarray:
    """The matrix of a band, (N, N)."""
    n = band.shape[0]
    matrix = np.zeros((n, n))
    for k in range(-HALF, HALF + 1):
        rows = np.arange(max(0, -k), n - max(0, k))
        matrix[rows, rows + k] = band[rows, HALF + k]
    return matrix
