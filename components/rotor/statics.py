"""Static equilibrium of a beam rotor, also of one that nothing but its bearings holds.

A bearing with clearance has no stiffness until the shaft has found its balls. A shaft that nothing holds is moved a given
way along the sum of its constant loads, weight and input force, into the balls; from there the master's sweeps are Newton's
method, and approach the equilibrium of Hertzian contacts from the side of the larger load, where it converges.
"""

from __future__ import annotations

import numpy as np

from ..core.banded import add_product, factor_general, solve_general
from .model import DOFS, HALF
from .ports import add_loads, add_tangents, follow_tangents

SOFT = 1e-14  # springs beside the stiffness, as a share of its diagonal: some 50 roundings, so that a free rotor can be solved
HELD = 1e-6  # of the load: what soft springs may carry of it in an equilibrium
REFINEMENTS = 10


def solve_static(stiffness: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, bool]:
    """Displacements under a load, (N,), and whether the stiffness, an (N, 15) band, holds the structure against it."""
    factors = stiffness.copy()
    factors[:, HALF] *= 1.0 + SOFT
    factor_general(factors)
    first = load.copy()
    solve_general(factors, first)
    q, limit = first.copy(), np.abs(load).max()
    for _ in range(REFINEMENTS):
        residual = -load
        add_product(stiffness, q, residual)
        if not np.abs(residual).max() > 1e-13 * limit:
            break
        solve_general(factors, residual)
        q -= residual
    residual = -load
    add_product(stiffness, q, residual)
    held = bool(np.abs(residual).max() <= HELD * limit)
    return (q if held else first), held


def equilibrium(
    stiffness: np.ndarray, load: np.ndarray, ports: np.ndarray, u: np.ndarray, fall: float
) -> tuple[np.ndarray, np.ndarray]:
    """Displacements under a constant load and the ports' loads, and the forces that are left there, (N,) each.

    A shaft that nothing holds is straight; where it has ports it is moved by `fall`, m, along the sum of `load`.
    stiffness: (N, 15).  load: (N,).  ports: (k, 3) node, first input, first output.  u: (3, m) inputs.
    """
    tangents = np.zeros((len(ports), 2, DOFS, DOFS))
    follow_tangents(0.0, ports, u, tangents)
    band, total = stiffness.copy(), load.copy()
    add_tangents(ports, tangents, 1.0, 0.0, band)
    add_loads(0.0, ports, u, total)
    q, held = solve_static(band, total)
    if not held:
        q[:] = 0.0
        weight = load.reshape(-1, DOFS)[:, :2].sum(axis=0)
        if len(ports) and weight.any():
            q.reshape(-1, DOFS)[:, :2] = fall / np.hypot(*weight) * weight
    add_product(band, -q, total)
    return q, total
