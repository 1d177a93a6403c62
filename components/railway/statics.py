"""Static equilibrium of the catenary: under a contact force, along the span, and at rest."""

from __future__ import annotations

import numpy as np

from ..core.banded import banded_product, factor_band, solve_band
from ..core.errors import StepFailed
from .contact import add_contact, contact_compliance, wire_height
from .mesh import GRAVITY, Mesh, add_droppers, stiffness_band, stiffness_of_wires


def loaded_equilibrium(mesh: Mesh, loads: list[tuple[float, float]], unilateral: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """Displacements under point loads (position in m, force in N) on the contact wire.

    Returns q (N,) m, taut (d,) 1 for every dropper under tension, and the largest unbalanced nodal force over the
    largest dropper preload. Raises `StepFailed` if the set of taut droppers does not converge.
    """
    N = mesh.mass.size
    stiffness = stiffness_of_wires(mesh, 7)
    stiffness[:, 0] += mesh.ground
    force = np.zeros(N)
    for position, load in loads:
        add_contact(position, load, force, mesh)
    at, k = 2 * mesh.dropper, mesh.dropper_stiffness
    taut = np.ones(at.size)
    for _ in range(100):
        band, q = stiffness.copy(), force.copy()
        add_droppers(band, mesh, taut)
        np.subtract.at(q, at, mesh.preload * (1.0 - taut))
        np.add.at(q, at + 1, mesh.preload * (1.0 - taut))
        q[:2], q[-2:] = 0.0, 0.0
        factor_band(band, 2, 2, N - 2)
        solve_band(band, q, 2, N - 2)
        tension = mesh.preload + k * (q[at + 1] - q[at])
        now = (tension > 0.0).astype(float) if unilateral else taut
        if np.array_equal(now, taut):
            change = np.where(taut > 0.0, tension, 0.0) - mesh.preload
            unbalanced = force - banded_product(stiffness, q)
            np.add.at(unbalanced, at, change)
            np.subtract.at(unbalanced, at + 1, change)
            return q, taut, float(np.abs(unbalanced[2:-2]).max() / np.abs(mesh.preload).max())
        taut = now
    raise StepFailed("Catenary", 0.0, "the slack droppers of the static equilibrium do not converge", "Check the contact force")


def elasticity(mesh: Mesh, positions, force: float, unilateral: bool = True) -> np.ndarray:
    """Static uplift per force at the given positions of the contact wire, (len(positions),) m/N."""
    result = []
    for position in positions:
        q, _, _ = loaded_equilibrium(mesh, [(position, force)], unilateral)
        uplift = wire_height(position, q, mesh) - wire_height(position, 0.0 * q, mesh)
        result.append(uplift / force + contact_compliance(0.0, mesh))
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
    band = stiffness_band(p.messenger_tension, (bending.messenger if bending is not None else 0.0) / around, 0.0, L)
    band[mesh.support[1:-1], 0] += p.support_stiffness
    y = -weight
    y[[0, -1]] = 0.0
    factor_band(band, 1, 1, y.size - 1)
    solve_band(band, y, 1, y.size - 1)
    return y
