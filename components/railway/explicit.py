"""Explicit integration of the wires: velocity Verlet with lumped masses."""

from __future__ import annotations

import math

from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, kernel
from .contact import add_contact, element_at, in_range
from .wires import (
    WHISPER,
    add_clamped,
    add_jumps,
    dropper_tension,
    first_at_or_after,
    follow_clamped,
    tension_and_bending,
)


@kernel
def move_window(front, rear, x, mesh, window):
    """First and last moving node for the contact points at `front` and `rear`; nodes left behind go to equilibrium.

    x: its last two elements hold the window of the step before.
    """
    n, N, W = mesh.position.size, mesh.mass.size, mesh.bending_gradient.size
    before = int(x[x.size - 2])
    lo = max(element_at(max(rear - window.behind, 0.0), mesh), max(before, 1))
    hi = min(element_at(min(front + window.ahead, mesh.position[n - 1]), mesh) + 1, n - 2)
    for part in range(3):
        for j in range(W * max(before, 1), W * lo):
            x[part * N + j] = 0.0
    x[x.size - 2], x[x.size - 1] = lo, hi
    return lo, hi


@kernel
def drift(d, q, v, a, z, force, beta):
    """Half a kick and the drift to the end of the step; z becomes q + beta (v + d/2 a), the force is cleared; all (n,)."""
    for j in range(q.size):
        v[j] += 0.5 * d * a[j]
        q[j] += d * v[j]
        z[j] = q[j] + beta * (v[j] + 0.5 * d * a[j])
        force[j] = WHISPER


@kernel
def kick(d, v, a, w, force, inverse_length, inverse_mass, alpha, W):
    """New acceleration from the wire's force and the others, and the second half of the kick; all (n,), ends fixed."""
    n = w.size
    left, here, right = w[: n - 2 * W], w[W : n - W], w[2 * W :]
    over_left, over_right, over_mass = inverse_length[: n - 2 * W], inverse_length[W : n - W], inverse_mass[W : n - W]
    point, ac, vc = force[W : n - W], a[W : n - W], v[W : n - W]
    for j in range(here.size):
        total = point[j] + over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
        ac[j] = total * over_mass[j] - alpha * (vc[j] + 0.5 * d * ac[j])
        vc[j] += 0.5 * d * ac[j]


@kernel
def explicit_steps(h, n, x, u, points, mesh, work, counts, slack, bending, damping, window):
    """n equal velocity-Verlet steps over h.

    x: displacement, velocity, acceleration, (N,) each, contacts[, window (2,)].  work: (4, N).
    points: (p, 5), as of `contact_points`.

    The damping force uses the predicted velocity v + d/2 a: the step stays explicit and of second order.
    Source: Verlet in kick-drift-kick form.
    """
    N, nodes, W = mesh.mass.size, mesh.position.size, mesh.bending_gradient.size
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    z, force, w, kink = work[0], work[1], work[2], work[3]
    alpha, beta = 0.0, 0.0
    if damping is not None:
        alpha, beta = damping.alpha, damping.beta
    lo, hi = 1, nodes - 2
    first_dropper, end_dropper, first_support, end_support = 0, mesh.dropper.size, 1, mesh.support.size - 1
    first_jump, end_jump, first_clamp, end_clamp = 0, mesh.jump.size, 0, mesh.clamped.size
    d = h / n
    for step in range(n):
        s = (step + 1) * d
        front, rear = -math.inf, math.inf
        for k in range(points.shape[0]):
            i = points[k, 0]
            position = u[0, i] + s * (u[1, i] + s * u[2, i])
            if not in_range(position, mesh):
                return OUT_OF_RANGE
            front, rear = max(front, position), min(rear, position)
        if window is not None:
            lo, hi = move_window(front, rear, x, mesh, window)
            first_dropper, end_dropper = first_at_or_after(mesh.dropper, lo), first_at_or_after(mesh.dropper, hi + 1)
            first_support = max(first_at_or_after(mesh.support, lo), 1)
            end_support = min(first_at_or_after(mesh.support, hi + 1), mesh.support.size - 1)
            first_jump, end_jump = first_at_or_after(mesh.jump, W * lo), first_at_or_after(mesh.jump, W * hi + W)
            first_clamp, end_clamp = first_at_or_after(mesh.clamped, W * lo), first_at_or_after(mesh.clamped, W * hi + W)
        here = slice(W * lo - W, W * hi + 2 * W)  # the moving nodes and one neighbour on either side

        drift(d, q[here], v[here], a[here], z[here], force[here], beta)
        follow_clamped(q, first_clamp, end_clamp, mesh)
        follow_clamped(v, first_clamp, end_clamp, mesh)
        follow_clamped(z, first_clamp, end_clamp, mesh)
        if window is not None:  # an edge inside the wire: no tension from outside, a dashpot that lets waves out
            for j in range(W):
                if lo > 1:
                    z[W * lo - W + j] = z[W * lo + j]
                    force[W * lo + j] -= mesh.impedance[W * lo + j] * v[W * lo + j]
                if hi < nodes - 2:
                    z[W * hi + W + j] = z[W * hi + j]
                    force[W * hi + j] -= mesh.impedance[W * hi + j] * v[W * hi + j]
        tension_and_bending(z[here], w[here], kink[here], mesh.tension[here], mesh.curvature[here], mesh.bending_gradient,
                            mesh.inverse_length[here], bending)
        add_jumps(z, force, first_jump, end_jump, mesh)
        for k in range(first_dropper, end_dropper):
            change = dropper_tension(k, q, mesh, slack) - mesh.preload[k]
            force[mesh.lower[k]] += change
            force[mesh.upper[k]] -= change
        for k in range(first_support, end_support):
            for j in range(W * mesh.support[k], W * mesh.support[k] + W):
                force[j] -= mesh.ground[j] * q[j] + mesh.ground_damping[j] * (v[j] + 0.5 * d * a[j])
        for k in range(points.shape[0]):
            i, f = points[k, 0], points[k, 1]
            position = u[0, i] + s * (u[1, i] + s * u[2, i])
            load = u[0, f] + s * (u[1, f] + s * u[2, f])
            add_contact(position, load, force, points[k, 4], mesh)
        add_clamped(w, force, first_clamp, end_clamp, mesh)
        kick(d, v[here], a[here], w[here], force[here], mesh.inverse_length[here], mesh.inverse_mass[here], alpha, W)
    counts[0] += n
    counts[1] += n
    if not math.isfinite(q[W * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
