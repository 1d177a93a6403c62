"""Static equilibrium of a beam rotor, also of one that nothing but its bearings holds.

A bearing with clearance has no stiffness until the shaft has found its balls. A shaft that nothing holds is moved a given
way along the sum of its constant loads, weight and input force, into the balls; from there the master's sweeps are Newton's
method, and approach the equilibrium of Hertzian contacts from the side of the larger load, where it converges.
"""

from __future__ import annotations

import math

from ..core.kernels import kernel
from ..core.linear import add_product, factor_general, solve_general
from .model import DOFS, HALF
from .ports import add_loads, add_tangents, follow_tangents

SOFT = 1e-14  # springs beside the stiffness, as a share of its diagonal: some 50 roundings, so that a free rotor can be solved
HELD = 1e-6  # of the load: what soft springs may carry of it in an equilibrium
REFINEMENTS = 10


@kernel
def largest(vector):
    """The largest magnitude of a vector's elements; NaN where one of them is."""
    size = 0.0
    for j in range(vector.size):
        if abs(vector[j]) > size or math.isnan(vector[j]):
            size = abs(vector[j])
    return size


@kernel
def find_residual(stiffness, q, load, residual):
    """residual = K q - load."""
    for j in range(q.size):
        residual[j] = -load[j]
    add_product(stiffness, q, residual)


@kernel
def solve_static(stiffness, load, q, factors, first, residual):
    """Displacements under a load into q, (N,), and whether the stiffness, an (N, 15) band, holds the structure against it.

    No load at all is the limit of a small one: there a load of ones on every degree of freedom tells.
    factors: (N, 15), first, residual: (N,), work.
    """
    for i in range(stiffness.shape[0]):
        for k in range(stiffness.shape[1]):
            factors[i, k] = stiffness[i, k]
        factors[i, HALF] *= 1.0 + SOFT
    factor_general(factors)
    limit, held = largest(load), True
    if limit == 0.0:
        for j in range(q.size):
            q[j], residual[j] = 1.0, -1.0
        solve_general(factors, q)
        add_product(stiffness, q, residual)
        held = largest(residual) <= HELD
    for j in range(q.size):
        first[j] = load[j]
    solve_general(factors, first)
    for j in range(q.size):
        q[j] = first[j]
    for _ in range(REFINEMENTS):
        find_residual(stiffness, q, load, residual)
        if not largest(residual) > 1e-13 * limit:
            break
        solve_general(factors, residual)
        for j in range(q.size):
            q[j] -= residual[j]
    find_residual(stiffness, q, load, residual)
    return held and largest(residual) <= HELD * limit


@kernel
def equilibrium(band, factors, s, q, force, fall):
    """Displacements q under a constant load and the ports' loads, and the forces that are left there, (N,) each.

    A shaft that nothing holds is straight; where it has ports it is moved by `fall`, m, along the sum of the constant load.
    band: (N, 15) stiffness, to which those of the ports are added.  factors: (N, 15), work.  force: the constant load at first.
    """
    N = q.size
    fx, fy = 0.0, 0.0
    for j in range(0, N, DOFS):
        fx += force[j]
        fy += force[j + 1]
    follow_tangents(0.0, s.ports, s.u, s.tangents)
    add_tangents(s.ports, s.tangents, 1.0, 0.0, band)
    add_loads(0.0, s.ports, s.u, force)
    if not solve_static(band, force, q, factors, s.room[0, :N], s.room[1, :N]):
        falls = s.ports.shape[0] > 0 and (fx != 0.0 or fy != 0.0)
        share = fall / math.hypot(fx, fy) if falls else 0.0
        for j in range(0, N, DOFS):
            q[j], q[j + 1], q[j + 2], q[j + 3] = share * fx, share * fy, 0.0, 0.0
    for j in range(N):
        s.room[0, j] = -q[j]
    add_product(band, s.room[0, :N], force)
