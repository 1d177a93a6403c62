"""Static equilibrium of the catenary: under a contact force, along the span, and at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.banded import banded_product, factor_band, solve_band
from ..core.errors import StepFailed
from .contact import add_contact, contact_compliance, wire_height
from .implicit import RIGID_CLAMP
from .line.layout import GRAVITY
from .mesh import Mesh, add_droppers, add_springs, stiffness_band, stiffness_of_wires


class Statics:
    """Static equilibrium of a mesh under point loads. Keeps the stiffness, and the factors of two sets of taut droppers."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.stiffness = stiffness_of_wires(mesh, 3)
        self.stiffness[:, 0] += mesh.ground
        add_springs(self.stiffness, mesh.clamped, mesh.clamp, RIGID_CLAMP)
        self._by_column = np.asfortranarray(self.stiffness)  # of which `banded_product` takes column by column
        self._factors: dict[bytes, np.ndarray] = {}

    def under(self, loads: Sequence[tuple], unilateral: bool,
              nodal: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray, float]:
        """Displacements under point loads (position in m, force in N, contact wire: 0 if left out) and forces on nodes (N,), N.

        Returns q (N,) m, taut (d,) 1 for every dropper under tension, and the largest unbalanced nodal force over the
        largest dropper preload. Raises `StepFailed` if the set of taut droppers does not converge.
        """
        mesh = self.mesh
        N, W = mesh.mass.size, mesh.bending_gradient.size
        force = np.zeros(N) + nodal
        for position, load, *wire in loads:
            add_contact(position, load, force, wire[0] if wire else 0, mesh)
        low, up, k = mesh.lower, mesh.upper, mesh.dropper_stiffness
        taut = np.ones(low.size)
        for _ in range(100):
            q = force.copy()
            np.subtract.at(q, low, mesh.preload * (1.0 - taut))
            np.add.at(q, up, mesh.preload * (1.0 - taut))
            q[:W], q[-W:] = 0.0, 0.0
            solve_band(self._factors_with(taut), q, W, N - W)
            tension = mesh.preload + k * (q[up] - q[low])
            now = (tension > 0.0).astype(float) if unilateral else taut
            if np.array_equal(now, taut):
                change = np.where(taut > 0.0, tension, 0.0) - mesh.preload
                unbalanced = force - banded_product(self._by_column, q)
                np.add.at(unbalanced, low, change)
                np.subtract.at(unbalanced, up, change)
                return q, taut, float(np.abs(unbalanced[W:-W]).max() / np.abs(mesh.preload).max())
            taut = now
        raise StepFailed("Catenary", 0.0, "the slack droppers of the static equilibrium do not converge",
                         "Check the contact force")

    def _factors_with(self, taut: np.ndarray) -> np.ndarray:
        """Factors with the taut droppers' stiffness. Kept: all taut, with which every search begins, and the last other set."""
        key = taut.tobytes()
        if key not in self._factors:
            band = self.stiffness.copy()
            add_droppers(band, self.mesh, taut)
            N, W = self.mesh.mass.size, self.mesh.bending_gradient.size
            factor_band(band, W, W, N - W)
            if len(self._factors) > 1:
                self._factors.popitem()
            self._factors[key] = band
        return self._factors[key]


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
