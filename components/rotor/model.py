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
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..core.errors import BadInput
from .elements import Disk, Section, element_mass, element_rotary_inertia, element_stiffness

DOFS = 4  # of a node
HALF = 2 * DOFS - 1  # half bandwidth: an element joins neighbouring nodes
WIDTH = 2 * HALF + 1


class Matrices(NamedTuple):
    """The terms of the equation of motion, (N, N) each as dense matrices, (N, 15) each as bands."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    gyroscopic: np.ndarray  # G, times the speed in rad/s
    circulatory: np.ndarray  # H, times the speed in rad/s


class Shaft(NamedTuple):
    """Bands of a bare shaft: deflection's and tilting's inertia, stiffness, (N, 15) each."""

    position: np.ndarray  # (n,) m, nodes
    deflection: np.ndarray
    rotary: np.ndarray
    stiffness: np.ndarray


def node_positions(length: float, fixed: list[float], element: float) -> np.ndarray:
    """Nodes at both ends and every fixed position, gaps between them cut into equal elements not longer than `element`, (n,) m.

    Positions closer to one another than a millionth of the length share a node.
    """
    places = np.unique([0.0, *fixed, length])
    places = places[np.append(True, np.diff(places) > 1e-6 * length)]
    places[-1] = length
    counts = [max(1, math.ceil(gap / element - 1e-6)) for gap in np.diff(places)]
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in zip(pairwise(places), counts, strict=True)]
    return np.concatenate((*parts, places[-1:]))


def nearest_node(nodes: np.ndarray, position: float) -> int:
    """Index of the node at a position."""
    return int(np.abs(nodes - position).argmin())


def checked_positions(positions, length: float, where: str, what: str) -> list[float]:
    """The positions as a list, or `BadInput` if one of them is beyond the shaft."""
    for value in positions:
        if not 0.0 <= value <= length * (1.0 + 1e-12):
            raise BadInput(where, f"{what} at {value:g} m", f"a place on the shaft, 0 to {length:g} m")
    return [float(value) for value in positions]


def assemble_shaft(section: Section, nodes: np.ndarray) -> Shaft:
    """Bands of a uniform shaft with these nodes, m."""
    L = np.diff(nodes)
    blocks = (element_mass(section, L), element_rotary_inertia(section, L), element_stiffness(section, L))
    return Shaft(nodes, *(_banded(block, nodes.size) for block in blocks))


def _banded(plane: np.ndarray, nodes: int) -> np.ndarray:
    """Band of both planes from the element matrices of one, (n - 1, 4, 4); signs as tilt_x = -dy/dz has it."""
    band = np.zeros((DOFS * nodes, WIDTH))
    first = DOFS * np.arange(nodes - 1)
    for places, signs in (((0, 3, 4, 7), (1.0, 1.0, 1.0, 1.0)), ((1, 2, 5, 6), (1.0, -1.0, 1.0, -1.0))):
        for a, i in enumerate(places):
            for b, j in enumerate(places):
                band[first + i, HALF + j - i] += signs[a] * signs[b] * plane[:, a, b]
    return band


def turned(band: np.ndarray) -> np.ndarray:
    """A S: the columns of x and y, and of tilt_x and tilt_y, change places; (N, 15).

    (A S q)_i = sum A_ij (S q)_j with S q = (y, -x, tilt_y, -tilt_x), so that column y gets A's column x, and x minus column y.
    """
    result = np.zeros_like(band)
    for k in range(-HALF, HALF + 1):
        rows = np.arange(max(0, -k), band.shape[0] - max(0, k))
        even = (rows + k) % 2 == 0  # a column of x or tilt_x; it goes to the next one, one of y or tilt_y to the one before
        to, back = rows[even], rows[~even]
        if k < HALF:
            result[to, HALF + k + 1] += band[to, HALF + k]
        if k > -HALF:
            result[back, HALF + k - 1] -= band[back, HALF + k]
    return result


def add_disk(band: np.ndarray, node: int, disk: Disk) -> None:
    """Add a disk's inertia to the band of the mass matrix."""
    rows = DOFS * node + np.arange(DOFS)
    band[rows, HALF] += (disk.mass, disk.mass, disk.diametral_inertia, disk.diametral_inertia)


def add_disk_gyroscopic(band: np.ndarray, node: int, polar_inertia: float) -> None:
    """Add a disk's I_p S to the band of the gyroscopic matrix."""
    j = DOFS * node + 2
    band[j, HALF + 1] += polar_inertia
    band[j + 1, HALF - 1] -= polar_inertia


def dense(band: np.ndarray) -> np.ndarray:
    """The matrix of a band, (N, N)."""
    n = band.shape[0]
    matrix = np.zeros((n, n))
    for k in range(-HALF, HALF + 1):
        rows = np.arange(max(0, -k), n - max(0, k))
        matrix[rows, rows + k] = band[rows, HALF + k]
    return matrix
