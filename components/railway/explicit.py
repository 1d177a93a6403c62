"""Explicit integration of the wires: velocity Verlet with lumped masses."""

from __future__ import annotations

import math

from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, kernel
from .contact import add_contacts, contact_columns, contact_count, element_at, in_range
from .wires import WHISPER, dropper_tension, first_at_or_after, tension_and_bending


@kernel
def move_window(front, rear, x, mesh, window):
    """First and last moving node for the contact points at `front` and `rear`; nodes left behind go to equilibrium.

    x: its last two elements hold the window of the step before.
    """
    n, N = mesh.position.size, mesh.mass.size
    before = int(x[x.size - 2])
    lo = max(element_at(max(rear - window.behind, 0.0), mesh), max(before, 1))
    hi = min(element_at(min(front + window.ahead, mesh.position[n - 1]), mesh) + 1, n - 2)
    for part in range(3):
        for j in range(2 * max(before, 1), 2 * lo):
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
def kick(d, v, a, w, force, inverse_length, inverse_mass, alpha):
    """New acceleration from the wire's force and the others, and the second half of the kick; all (n,), ends fixed."""
    left, here, right = w[:-4], w[2:-2], w[4:]
    over_left, over_right, over_mass = inverse_length[:-4], inverse_length[2:-2], inverse_mass[2:-2]
    point, ac, vc = force[2:-2], a[2:-2], v[2:-2]
    for j in range(here.size):
        total = point[j] + over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
        ac[j] = total * over_mass[j] - alpha * (vc[j] + 0.5 * d * ac[j])
        vc[j] += 0.5 * d * ac[j]


@kernel
def explicit_steps(h, n, x, u, mesh, work, counts, slack, bending, damping, second, further, window):
    """n equal velocity-Verlet steps over h.

    x: displacement, velocity, acceleration, (N,) each, contacts[, window (2,)].  work: (4, N).

    The damping force uses the predicted velocity v + d/2 a: the step stays explicit and of second order.
    Source: Verlet in kick-drift-kick form.
    """
    N, nodes = mesh.mass.size, mesh.position.size
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    z, force, w, kink = work[0], work[1], work[2], work[3]
    alpha, beta = 0.0, 0.0
    if damping is not None:
        alpha, beta = damping.alpha, damping.beta
    lo, hi = 1, nodes - 2
    first_dropper, end_dropper, first_support, end_support = 0, mesh.dropper.size, 1, mesh.support.size - 1
    d = h / n
    for step in range(n):
        s = (step + 1) * d
        position = u[0, 0] + s * (u[1, 0] + s * u[2, 0])
        front, rear = position, position
        for k in range(contact_count(second, further)):
            at, _ = contact_columns(k, second, further)
            place = u[0, at] + s * (u[1, at] + s * u[2, at])
            if not in_range(place, mesh):
                return OUT_OF_RANGE
            front, rear = max(front, place), min(rear, place)
        if window is not None:
            lo, hi = move_window(front, rear, x, mesh, window)
            first_dropper, end_dropper = first_at_or_after(mesh.dropper, lo), first_at_or_after(mesh.dropper, hi + 1)
            first_support = max(first_at_or_after(mesh.support, lo), 1)
            end_support = min(first_at_or_after(mesh.support, hi + 1), mesh.support.size - 1)
        here = slice(2 * lo - 2, 2 * hi + 4)  # the moving nodes and one neighbour on either side

        drift(d, q[here], v[here], a[here], z[here], force[here], beta)
        if window is not None:  # an edge inside the wire: no tension from outside, a dashpot that lets waves out
            for j in range(2):
                if lo > 1:
                    z[2 * lo - 2 + j] = z[2 * lo + j]
                    force[2 * lo + j] -= mesh.impedance[j] * v[2 * lo + j]
                if hi < nodes - 2:
                    z[2 * hi + 2 + j] = z[2 * hi + j]
                    force[2 * hi + j] -= mesh.impedance[j] * v[2 * hi + j]
        tension_and_bending(z[here], w[here], kink[here], mesh.tension[here], mesh.curvature[here], mesh.bending_gradient,
                            mesh.inverse_length[here], bending)
        for k in range(first_dropper, end_dropper):
            j = 2 * mesh.dropper[k]
            change = dropper_tension(k, q, mesh, slack) - mesh.preload[k]
            force[j] += change
            force[j + 1] -= change
        for k in range(first_support, end_support):
            for j in range(2 * mesh.support[k], 2 * mesh.support[k] + 2):
                force[j] -= mesh.ground[j] * q[j] + mesh.ground_damping[j] * (v[j] + 0.5 * d * a[j])
        add_contacts(s, u, force, mesh, second, further)
        kick(d, v[here], a[here], w[here], force[here], mesh.inverse_length[here], mesh.inverse_mass[here], alpha)
    counts[0] += n
    counts[1] += n
    if not math.isfinite(q[2 * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
