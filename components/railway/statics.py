"""Static equilibrium of the catenary: under a contact force, along the span, and at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..core.banded import factor_band, solve_band
from ..core.errors import StepFailed
from ..core.kernels import kernel, kernel_tuple
from .contact import add_contact, contact_compliance, wire_height
from .implicit import RIGID_CLAMP
from .line.layout import GRAVITY
from .mesh import Mesh, add_springs, stiffness_band, stiffness_of_wires

MAX_SETS = 100  # of taut droppers that are tried
NO_REST, CHECK_FORCE = "the slack droppers of the static equilibrium do not converge", "Check the contact force"


@kernel_tuple
class Rest(NamedTuple):
    """Stiffness of a mesh of N degrees of freedom and d droppers, and the factors of two sets of taut droppers."""

    stiffness: np.ndarray  # (N, 3 W + 1) N/m, of all but droppers
    factors: np.ndarray  # (2, N, 3 W + 1): all taut, with which every search begins, and the last other set
    factored: np.ndarray  # (2, d) 1 where a dropper is taut in these sets, -1 before there are factors
    taut: np.ndarray  # (d,) of the equilibrium


def rest_of(mesh: Mesh) -> Rest:
    """Stiffness of a mesh; nothing is factored."""
    stiffness = stiffness_of_wires(mesh, 3)
    stiffness[:, 0] += mesh.ground
    add_springs(stiffness, mesh.clamped, mesh.clamp, RIGID_CLAMP)
    return Rest(stiffness, np.zeros((2, *stiffness.shape)), np.full((2, mesh.dropper.size), -1.0), np.ones(mesh.dropper.size))


@kernel
def factor_rest(which, mesh, rest):
    """Factors number `which` with the stiffness of the present taut droppers, unless they are there."""
    band, factored, N, W = rest.factors[which], rest.factored[which], mesh.mass.size, mesh.bending_gradient.size
    same = True
    for k in range(factored.size):
        same = same and factored[k] == rest.taut[k]
    if same:
        return
    for j in range(N):
        for i in range(band.shape[1]):
            band[j, i] = rest.stiffness[j, i]
    for k in range(factored.size):
        factored[k] = rest.taut[k]
        one, other, stiffness = mesh.lower[k], mesh.upper[k], mesh.dropper_stiffness[k] * factored[k]
        band[one, 0] += stiffness
        band[other, 0] += stiffness
        band[min(one, other), abs(one - other)] -= stiffness
    factor_band(band, W, W, N - W)


@kernel
def product_at(i, band, x):
    """Element i of the product of a symmetric matrix, as its upper band, with x."""
    value = band[i, 0] * x[i]
    for k in range(1, band.shape[1]):
        if i + k < x.size:
            value += band[i, k] * x[i + k]
        if i >= k:
            value += band[i - k, k] * x[i - k]
    return value


@kernel
def find_rest(force, unilateral, q, mesh, rest):
    """Displacements q (N,) m under forces on the nodes (N,) N; with `unilateral` droppers do not push.

    Returns the largest unbalanced nodal force over the largest dropper preload, or NaN where the set of taut droppers does not
    converge. The forces become the unbalanced ones.
    """
    N, W, taut = mesh.mass.size, mesh.bending_gradient.size, rest.taut
    for k in range(taut.size):
        taut[k] = 1.0
    for _ in range(MAX_SETS):
        for j in range(N):
            q[j] = force[j]
        slack = 0
        for k in range(taut.size):
            q[mesh.lower[k]] -= mesh.preload[k] * (1.0 - taut[k])
            q[mesh.upper[k]] += mesh.preload[k] * (1.0 - taut[k])
            if taut[k] == 0.0:
                slack += 1
        for j in range(W):
            q[j], q[N - 1 - j] = 0.0, 0.0
        which = 0 if slack == 0 else 1
        factor_rest(which, mesh, rest)
        solve_band(rest.factors[which], q, W, N - W)
        changed = 0
        for k in range(taut.size):
            tension = mesh.preload[k] + mesh.dropper_stiffness[k] * (q[mesh.upper[k]] - q[mesh.lower[k]])
            now = 1.0 if tension > 0.0 or not unilateral else 0.0
            if now != taut[k]:
                taut[k] = now
                changed += 1
        if changed > 0:
            continue
        for j in range(N):
            force[j] -= product_at(j, rest.stiffness, q)
        largest, most = 0.0, 0.0
        for k in range(taut.size):
            tension = mesh.preload[k] + mesh.dropper_stiffness[k] * (q[mesh.upper[k]] - q[mesh.lower[k]])
            change = (tension if taut[k] > 0.0 else 0.0) - mesh.preload[k]
            force[mesh.lower[k]] += change
            force[mesh.upper[k]] -= change
            most = max(most, abs(mesh.preload[k]))
        for j in range(W, N - W):
            largest = max(largest, abs(force[j]))
        return largest / most
    return math.nan


class Statics:
    """Static equilibrium of a mesh under point loads."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.rest = mesh, rest_of(mesh)

    def under(self, loads: Sequence[tuple], unilateral: bool,
              nodal: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray, float]:
        """Displacements under point loads (position in m, force in N, contact wire: 0 if left out) and forces on nodes (N,), N.

        Returns q (N,) m, taut (d,) 1 for every dropper under tension, and the largest unbalanced nodal force over the
        largest dropper preload. Raises `StepFailed` if the set of taut droppers does not converge.
        """
        force, q = np.zeros(self.mesh.mass.size) + nodal, np.zeros(self.mesh.mass.size)
        for position, load, *wire in loads:
            add_contact(float(position), float(load), force, wire[0] if wire else 0, self.mesh)
        residual = find_rest(force, unilateral, q, self.mesh, self.rest)
        if math.isnan(residual):
            raise StepFailed("Catenary", 0.0, NO_REST, CHECK_FORCE)
        return q, self.rest.taut.copy(), residual


def elasticity(mesh: Mesh, positions, force: float, unilateral: bool = True, wire: int = 0) -> np.ndarray:
    """Static uplift per force at the given positions of a contact wire, 0 or 1, (len(positions),) m/N."""
    result, statics = [], Statics(mesh)
    for position in positions:
        q, _, _ = statics.under([(position, force, wire)], unilateral)
        uplift = wire_height(position, q, wire, mesh) - wire_height(position, 0.0 * q, wire, mesh)
        result.append(uplift / force + contact_compliance(0.0, position, wire, mesh))
    return np.array(result)


def stiffness_series(positions, stiffness, span: float, harmonics: int) -> tuple[float, np.ndarray]:
    """(k0, a) of k(x) = k0 (1 + sum a[n-1] cos(2 pi n x / span)), least squares; k0 in N/m, a: (harmonics,).

    x = 0 is a support. The span is symmetric, so that no sines appear.
    """
    angle = 2.0 * np.pi * np.asarray(positions)[:, None] / span
    coefficients = np.linalg.lstsq(np.cos(angle * np.arange(harmonics + 1)), np.asarray(stiffness), rcond=None)[0]
    return float(coefficients[0]), coefficients[1:] / coefficients[0]


def messenger_shape(p, bending, mesh: Mesh) -> np.ndarray:
    """Height of the messenger wire at rest above its supports' unloaded height, (n,) m, from weights and dropper tensions.

    p and bending: parameters of `Catenary` and of its `bending_stiffness`, or None. Linear elements, as at the contact wire.
    """
    L = mesh.length
    around = 0.5 * (L + np.roll(L, 1))
    weight = GRAVITY * p.messenger_mass * around
    weight[mesh.dropper] += GRAVITY * (p.messenger_clamp_mass + 0.5 * p.dropper_mass) + mesh.preload
    EI = bending.messenger if bending is not None else 0.0
    band = stiffness_band(np.full(L.size, p.messenger_tension), EI / around, 0.0, L)
    band[mesh.support[1:-1], 0] += p.support_stiffness
    y = -weight
    y[[0, -1]] = 0.0
    factor_band(band, 1, 1, y.size - 1)
    solve_band(band, y, 1, y.size - 1)
    return y
