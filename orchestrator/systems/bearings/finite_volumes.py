"""Steady heat conduction on orthogonal grids: finite volumes in cylindrical or spherical coordinates.

Each cell has half resistances from its centre to its six faces, exact for heat that flows along one coordinate alone (so a
cylinder's wall and a spherical shell come out exactly, a general field with second order). Bodies are joined by links
between cells, and to the outside through boundary temperatures. Sparse matrices, SciPy only. No component uses it: it is the
reference that the validation case thermal-scaling and the tests hold the lumped conductance against, by way of `heat_path`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix, diags_array
from scipy.sparse.csgraph import dijkstra
from scipy.sparse.linalg import spsolve

from ....components.bearings.radiation import STEFAN_BOLTZMANN
from ....components.core.errors import BadInput

DIRECT = 20000  # unknowns up to which a sparse factorisation is quicker than conjugate gradients
RESIDUAL = 1e-11  # relative, of the conjugate gradients
MOST_ITERATIONS = 20000
MOST_ROUNDS = 50  # of the radiative coefficients
SETTLED = 1e-9  # change of the temperatures in a round, relative


@dataclass(frozen=True)
class Grid:
    """Cells of a body; half[axis][side]: resistance from a cell's centre to its lower (0) or upper (1) face, K/W, `shape`.

    area[axis]: (n + 1 along that axis) of the faces, m2.  At an axis of rotation or a pole the face has no area and an
    infinite resistance.
    """

    shape: tuple[int, int, int]
    half: tuple[tuple[np.ndarray, np.ndarray], ...]
    area: tuple[np.ndarray, ...]

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def index(self) -> np.ndarray:
        """Numbers of the cells, `shape`."""
        return np.arange(self.size).reshape(self.shape)


def _grid(shape, half, area) -> Grid:
    full = tuple((np.broadcast_to(low, shape), np.broadcast_to(high, shape)) for low, high in half)
    faces = tuple(np.broadcast_to(a, tuple(n + (i == axis) for i, n in enumerate(shape))) for axis, a in enumerate(area))
    return Grid(shape, full, faces)


def _cells(edges) -> tuple[np.ndarray, ...]:
    """Lower and upper edges along three axes, shaped to broadcast against each other."""
    cells = []
    for axis, e in enumerate(edges):
        e = np.asarray(e, dtype=float)
        if e.size < 2 or not (np.diff(e) > 0.0).all():
            raise BadInput("finite volumes", f"edges of axis {axis}: {e}", "at least two growing numbers")
        shape = [1, 1, 1]
        shape[axis] = -1
        cells += [e[:-1].reshape(shape), e[1:].reshape(shape)]
    return tuple(cells)


def _faces(edges, axis: int) -> np.ndarray:
    shape = [1, 1, 1]
    shape[axis] = -1
    return np.asarray(edges, dtype=float).reshape(shape)


def cylindrical(rho, phi, z, conductivity: float) -> Grid:
    """Part of a cylinder, edges of radius in m, angle in rad, height in m; the first radius may be 0."""
    r1, r2, p1, p2, z1, z2 = _cells((rho, phi, z))
    middle, dphi, dz, k = 0.5 * (r1 + r2), p2 - p1, z2 - z1, conductivity
    with np.errstate(divide="ignore"):
        low, high = np.log(middle / r1) / (k * dphi * dz), np.log(r2 / middle) / (k * dphi * dz)
        turn = 0.5 * dphi / (k * dz * np.where(r1 > 0.0, np.log(r2 / r1), (r2 - r1) / middle))
    up = 0.5 * dz / (k * 0.5 * (r2**2 - r1**2) * dphi)
    area = (_faces(rho, 0) * dphi * dz, (r2 - r1) * dz, 0.5 * (r2**2 - r1**2) * dphi)
    return _grid((middle.size, dphi.size, dz.size), ((low, high), (turn, turn), (up, up)), area)


def spherical(r, theta, phi, conductivity: float) -> Grid:
    """Part of a ball, edges of radius in m, angle from the pole and angle about the axis in rad."""
    r1, r2, t1, t2, p1, p2 = _cells((r, theta, phi))
    rm, tm, dr, dphi, k = 0.5 * (r1 + r2), 0.5 * (t1 + t2), r2 - r1, p2 - p1, conductivity
    solid = (np.cos(t1) - np.cos(t2)) * dphi
    pole = (t1 < 1e-12) | (t2 > math.pi - 1e-12)
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (1.0 / r1 - 1.0 / rm) / (k * solid), (1.0 / rm - 1.0 / r2) / (k * solid)
        log1, logm, log2 = (np.log(np.tan(0.5 * t)) for t in (t1, tm, t2))
        north = np.where(t1 < 1e-12, np.inf, (logm - log1) / (k * dr * dphi))
        south = np.where(t2 > math.pi - 1e-12, np.inf, (log2 - logm) / (k * dr * dphi))
        turn = 0.5 * dphi / (k * dr * np.where(pole, (t2 - t1) / np.sin(tm), log2 - log1))
    across = 0.5 * (r2**2 - r1**2)
    area = (_faces(r, 0) ** 2 * solid, across * np.abs(np.sin(_faces(theta, 1))) * dphi, across * (t2 - t1))
    return _grid((rm.size, tm.size, dphi.size), ((low, high), (north, south), (turn, turn)), area)


@dataclass
class Bodies:
    """Bodies and single nodes, the links between them, and what holds them at temperatures."""

    size: int = 0
    links: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)  # cells, cells, W/K
    held: list[tuple[np.ndarray, np.ndarray, float]] = field(default_factory=list)  # cells, W/K, K
    radiating: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)  # cells, cells, m2

    def add(self, grid: Grid, closed: int | None = None) -> np.ndarray:
        """Cell numbers of a new body, `grid.shape`; `closed`: the axis along which its last cells meet its first ones."""
        index = grid.index + self.size
        self.size += grid.size
        for axis in range(3):
            here, there = _along(axis, slice(None, -1)), _along(axis, slice(1, None))
            resistance = grid.half[axis][1][here] + grid.half[axis][0][there]
            self.link(index[here], index[there], 1.0 / resistance)
            if axis == closed:
                last, first = _along(axis, slice(-1, None)), _along(axis, slice(None, 1))
                self.link(index[last], index[first], 1.0 / (grid.half[axis][1][last] + grid.half[axis][0][first]))
        return index

    def node(self) -> int:
        """Number of a new node without extent, such as the air inside."""
        self.size += 1
        return self.size - 1

    def link(self, here, there, conductance) -> None:
        """Heat conductance (W/K) between cells; arrays of one shape, or a single node."""
        here, there, g = np.broadcast_arrays(here, there, conductance)
        self.links.append((here.ravel(), there.ravel(), np.asarray(g, dtype=float).ravel()))

    def hold(self, cells, conductance, temperature: float) -> None:
        """Tie cells to a temperature in K through conductances in W/K."""
        cells, g = np.broadcast_arrays(cells, conductance)
        self.held.append((cells.ravel(), np.asarray(g, dtype=float).ravel(), float(temperature)))

    def radiate(self, here, there, area) -> None:
        """Exchange sigma * area * (T_here⁴ - T_there⁴) between cells, area in m2 times the emissivity."""
        here, there, c = np.broadcast_arrays(here, there, area)
        self.radiating.append((here.ravel(), there.ravel(), np.asarray(c, dtype=float).ravel()))

    def solve(self, guess: float = 293.15) -> tuple[np.ndarray, np.ndarray]:
        """Temperatures, (size,) K, and the heat from each `hold` into the bodies, (number of holds,) W."""
        temperature = np.full(self.size, guess)
        for _ in range(MOST_ROUNDS):
            links = self.links + [(a, b, c * _coefficient(temperature[a], temperature[b])) for a, b, c in self.radiating]
            before, temperature = temperature, self._linear(links, temperature)
            if not self.radiating or np.abs(temperature - before).max() <= SETTLED * np.abs(temperature).max():
                break
        else:
            raise RuntimeError(f"radiation: temperatures still changed by more than {SETTLED:g} after {MOST_ROUNDS} rounds")
        heat = [float(np.sum(g * (t - temperature[cells]))) for cells, g, t in self.held]
        return temperature, np.array(heat)

    def _linear(self, links, guess: np.ndarray) -> np.ndarray:
        i, j, g = (np.concatenate(parts) for parts in zip(*links, strict=True))
        diagonal = np.bincount(i, g, self.size) + np.bincount(j, g, self.size)
        right = np.zeros(self.size)
        for cells, conductance, t in self.held:
            diagonal += np.bincount(cells, conductance, self.size)
            right += np.bincount(cells, conductance * t, self.size)
        every = np.arange(self.size)
        matrix = coo_matrix(
            (np.concatenate([diagonal, -g, -g]), (np.concatenate([every, i, j]), np.concatenate([every, j, i])))
        ).tocsr()
        if self.size <= DIRECT:
            return spsolve(matrix.tocsc(), right)
        return _conjugate_gradients(matrix, right, diagonal, guess)


def _conjugate_gradients(matrix, right: np.ndarray, diagonal: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """Solve a symmetric system: every second cell eliminated, the others by conjugate gradients, scaled with their diagonal.

    Half of the iterations with half of the unknowns: cells of one colour of a chessboard have no links among themselves. Their own
    equations hold exactly, so what is left in the others is the residual of the whole system.
    SciPy's own takes its scalar products from BLAS, whose threads made it ten times slower on two busy cores.
    """
    out, kept = (np.flatnonzero(of) for of in _chessboard(matrix))
    rows = matrix[kept]
    ahead, back = matrix[out][:, kept], (rows[:, out] @ diags_array(1.0 / diagonal[out])).tocsr()
    own = rows[:, kept]
    scale = diagonal[kept] - np.asarray(back.multiply(rows[:, out]).sum(axis=1)).ravel()
    x = guess[kept]
    left = right[kept] - back @ right[out] - (own @ x - back @ (ahead @ x))
    enough = RESIDUAL**2 * np.sum(right * right)
    direction, before = np.zeros_like(x), 1.0
    for _ in range(MOST_ITERATIONS):
        scaled = left / scale
        now = np.sum(left * scaled)
        direction = scaled + (now / before) * direction
        change = own @ direction - back @ (ahead @ direction)
        share = now / np.sum(direction * change)
        x += share * direction
        left -= share * change
        before = now
        if np.sum(left * left) <= enough:
            whole = np.empty_like(guess)
            whole[kept], whole[out] = x, (right[out] - ahead @ x) / diagonal[out]
            return whole
    raise RuntimeError(f"conjugate gradients left a residual above {RESIDUAL:g} after {MOST_ITERATIONS} iterations")


def _chessboard(matrix) -> tuple[np.ndarray, np.ndarray]:
    """Masks of cells without links among themselves, (size,), and of all others.

    Cells at an odd number of steps from the first one. A node of air joins cells at like distances: these stay.
    """
    steps = dijkstra(abs(matrix), indices=0, unweighted=True)
    odd = np.where(np.isfinite(steps), steps, 0.0) % 2.0 == 1.0
    out = odd & (abs(matrix) @ odd == abs(matrix.diagonal()) * odd)
    return out, ~out


def _along(axis: int, part: slice) -> tuple[slice, ...]:
    return tuple(part if i == axis else slice(None) for i in range(3))


def _coefficient(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """sigma (a⁴ - b⁴) / (a - b), W/(m2.K)."""
    return STEFAN_BOLTZMANN * (a * a + b * b) * (a + b)


def graded(first: float, growth: float, length: float) -> np.ndarray:
    """Edges from 0 to `length` whose cells grow by a factor near `growth` from a first one near `first`, (n + 1,)."""
    n = max(1, math.ceil(math.log1p((growth - 1.0) * length / first) / math.log(growth)))
    edges = np.expm1(math.log(growth) * np.arange(n + 1))
    return edges * (length / edges[-1])
