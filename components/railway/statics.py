"""Static equilibrium of the catenary: under a contact force, along the span, and at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.kernels import OWN, kernel, kernel_tuple
from ..core.linear import factor_band, solve_band
from .contact import add_contact, contact_compliance, wire_height
from .implicit import RIGID_CLAMP
from .line.layout import GRAVITY
from .mesh import Mesh
from .stiffness import add_spring, add_wire, fill_stiffness, product_at

MAX_SETS = 100  # of taut droppers that are tried
UNBALANCED = OWN + 11  # status of `initialize`
REFUSALS = {
    UNBALANCED: Refusal(
        "slack droppers of the static equilibrium that do not converge", "a set of them that does", "Check the contact force."
    )
}


@kernel_tuple
class Balance(NamedTuple):
    """Stiffness of a mesh of N degrees of freedom and d droppers, and the factors of two sets of taut droppers."""

    stiffness: np.ndarray  # (N, 3 W + 1) N/m, of all but droppers
    factors: np.ndarray  # (2, N, 3 W + 1): all taut, with which every search begins, and the last other set
    taut: np.ndarray  # (3, d) 1 where a dropper is taut in these sets, -1 before there are factors; and in the last equilibrium


PRESENT = 2  # row of `Balance.taut`


def empty_balance(mesh: Mesh) -> Balance:
    """Room for `balance` on a mesh."""
    N, width = mesh.mass.size, 3 * mesh.bending_gradient.size + 1
    return Balance(np.zeros((N, width)), np.zeros((2, N, width)), np.zeros((3, mesh.dropper.size)))


@kernel
def add_ground(mesh, balance):
    """Springs to the ground and clamps, to the stiffness of the wires; nothing is factored."""
    for j in range(mesh.mass.size):
        balance.stiffness[j, 0] += mesh.ground[j]
    for k in range(mesh.clamped.size):
        add_spring(mesh.clamped[k], mesh.clamp[k], RIGID_CLAMP, balance.stiffness)
    balance.taut[:] = -1.0


@kernel
def put_droppers(taut, lower, upper, dropper_stiffness, stiffness, band):
    """A band of stiffness and of the droppers that are taut, 0 or 1 (d,), into band."""
    for j in range(band.shape[0]):
        for k in range(band.shape[1]):
            band[j, k] = stiffness[j, k]
    for k in range(taut.size):
        add_spring(lower[k], upper[k], dropper_stiffness[k] * taut[k], band)


@kernel
def find_balance(force, unilateral, q, mesh, balance):
    """Displacements q (N,) m under forces on the nodes (N,) N; with `unilateral` droppers do not push.

    Returns the largest unbalanced nodal force over the largest dropper preload, or NaN where the set of taut droppers does not
    converge. `force` becomes what is unbalanced.
    """
    N, W, lower, upper = mesh.mass.size, mesh.bending_gradient.size, mesh.lower, mesh.upper
    preload, stiffness, taut, changed = mesh.preload, mesh.dropper_stiffness, balance.taut[PRESENT], 1
    taut[:] = 1.0
    for _ in range(MAX_SETS):
        which, same = 0, True
        for k in range(taut.size):
            if taut[k] == 0.0:
                which = 1
        for k in range(taut.size):
            same = same and balance.taut[which, k] == taut[k]
            balance.taut[which, k] = taut[k]
        if not same:
            put_droppers(taut, lower, upper, stiffness, balance.stiffness, balance.factors[which])
            factor_band(balance.factors[which], W, W, N - W)
        for j in range(N):
            q[j] = force[j]
        for k in range(taut.size):
            q[lower[k]] -= preload[k] * (1.0 - taut[k])
            q[upper[k]] += preload[k] * (1.0 - taut[k])
        q[:W], q[N - W :] = 0.0, 0.0
        solve_band(balance.factors[which], q, W, N - W)
        changed = 0
        for k in range(taut.size):
            now = 1.0 if not unilateral or preload[k] + stiffness[k] * (q[upper[k]] - q[lower[k]]) > 0.0 else 0.0
            changed += 1 if now != taut[k] else 0
            taut[k] = now
        if changed == 0:
            break
    if changed > 0:
        return math.nan
    for j in range(N):
        force[j] -= product_at(j, balance.stiffness, q)
    unbalanced, whole = 0.0, 0.0  # root mean squares, which have derivatives where several are largest
    for k in range(taut.size):
        change = (preload[k] + stiffness[k] * (q[upper[k]] - q[lower[k]])) * taut[k] - preload[k]
        force[lower[k]] += change
        force[upper[k]] -= change
        whole += preload[k] ** 2
    for j in range(W, N - W):
        unbalanced += force[j] ** 2
    return math.sqrt(unbalanced / whole)


# -- for Python --------------------------------------------------------------------------------------------------------
class Statics:
    """Static equilibrium of a mesh under point loads."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.balance = mesh, empty_balance(mesh)
        fill_stiffness(mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.length, self.balance.stiffness)
        add_ground(mesh, self.balance)

    def under(self, loads: Sequence[tuple], unilateral: bool) -> tuple[np.ndarray, np.ndarray, float]:
        """Displacements under point loads (position in m, force in N, contact wire: 0 if left out).

        Returns q (N,) m, taut (d,) 1 for every dropper under tension, and the unbalanced nodal forces over the
        dropper preloads (root sums of squares). Raises `StepFailed` if the set of taut droppers does not converge.
        """
        force, q = np.zeros((2, self.mesh.mass.size))
        for position, load, *wire in loads:
            add_contact(float(position), float(load), force, wire[0] if wire else 0, self.mesh)
        residual = find_balance(force, unilateral, q, self.mesh, self.balance)
        if math.isnan(residual):
            raise StepFailed(
                "Catenary", 0.0, "the slack droppers of the static equilibrium do not converge", "Check the contact force"
            )
        return q, self.balance.taut[PRESENT].copy(), residual


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
    band = np.zeros((L.size, 4))
    add_wire(np.full(L.size, p.messenger_tension), EI / around, 0.0, L, band)
    band[mesh.support[1:-1], 0] += p.support_stiffness
    y = -weight
    y[[0, -1]] = 0.0
    factor_band(band, 1, 1, y.size - 1)
    solve_band(band, y, 1, y.size - 1)
    return y
