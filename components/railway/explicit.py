"""Explicit integration of the wires: velocity Verlet with lumped masses."""

from __future__ import annotations

import math

from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, kernel
from .contact import add_contact, element_at, in_range
from .gust_loads import LOADS, add_air_damping, add_gusts, follow_gusts, gust_state
from .moving_window import move_window
from .wires import DENORMAL_GUARD, dropper_tension, first_at_or_after

PAD = 3  # nodes beyond either end: so far the stiffness of a wire reaches


@kernel
def fill_diagonals(band, W, diagonals):
    """Upper band (N, 3 W + 1) of all wires by diagonals, (3 or 4, N + PAD W): row k has K[j, j + k W] at j + PAD W; before, 0."""
    diagonals[:] = 0.0
    for k in range(diagonals.shape[0]):
        for j in range(band.shape[0]):
            diagonals[k, j + PAD * W] = band[j, k * W]


@kernel
def explicit_limit(omega2, damped, dashpots, inverse_mass):
    """Longest stable step, s: (omega h)² + 4 (beta omega_w² + c/m) h = 4 with the highest frequencies.

    omega2: omega², 1/s², of everything.  damped: beta omega_w², 1/s, of the wires alone.  dashpots: c (N,) N.s/m.
    """
    most = 0.0
    for j in range(dashpots.size):
        most = max(most, dashpots[j] * inverse_mass[j])
    b = 2.0 * most + 2.0 * damped
    return (math.sqrt(b * b + 4.0 * omega2) - b) / omega2


@kernel
def drift(d, q, v, a, z, force, beta):
    """Half a kick and the drift to the end of the step; z becomes q + beta (v + d/2 a), the force is cleared; all (n,)."""
    for j in range(q.size):
        v[j] += 0.5 * d * a[j]
        q[j] += d * v[j]
        z[j] = q[j] + beta * (v[j] + 0.5 * d * a[j])
        force[j] = DENORMAL_GUARD


@kernel
def kick(j, end, d, v, a, z, force, inverse_mass, stiffness, alpha, W, bending):
    """New acceleration from the wires' pull and the other forces, second half of the kick; degrees of freedom j to end - 1.

    z: (N + 2 PAD W,), stiffness: (3 or 4, N + PAD W), see `fill_diagonals`. One sum over five nodes, or seven of beams: with
    slopes and bending moments kept in between, the processor would load and store numbers for twice as long.
    """
    m, i = end - j, j + PAD * W
    point, over_mass, ac, vc = force[j:end], inverse_mass[j:end], a[j:end], v[j:end]
    # shifted views: plain indices, which LLVM can vectorize
    own, right, further_right = stiffness[0, i : i + m], stiffness[1, i : i + m], stiffness[2, i : i + m]
    left, further_left = stiffness[1, i - W : i - W + m], stiffness[2, i - 2 * W : i - 2 * W + m]
    here, z_left, z_right = z[i : i + m], z[i - W : i - W + m], z[i + W : i + W + m]
    z_further_left, z_further_right = z[i - 2 * W : i - 2 * W + m], z[i + 2 * W : i + 2 * W + m]
    if bending is not None:
        last_right, last_left = stiffness[3, i : i + m], stiffness[3, i - 3 * W : i - 3 * W + m]
        z_last_left, z_last_right = z[i - 3 * W : i - 3 * W + m], z[i + 3 * W : i + 3 * W + m]
    for k in range(m):
        pull = own[k] * here[k] + (left[k] * z_left[k] + right[k] * z_right[k])
        pull += further_left[k] * z_further_left[k] + further_right[k] * z_further_right[k]
        if bending is not None:
            pull += last_left[k] * z_last_left[k] + last_right[k] * z_last_right[k]
        ac[k] = (point[k] - pull) * over_mass[k] - alpha * (vc[k] + 0.5 * d * ac[k])
        vc[k] += 0.5 * d * ac[k]


@kernel
def add_clamped(z, force, first, end, stiffness, mesh):
    """The pull of a wire's end acts on the node to which it is clamped, N; z, stiffness: as of `kick`."""
    W = mesh.bending_gradient.size
    for k in range(first, end):
        j = mesh.clamped[k]
        i = j + PAD * W
        pull = stiffness[0, i] * z[i]
        for reach in range(1, stiffness.shape[0]):
            at = reach * W
            pull += stiffness[reach, i - at] * z[i - at] + stiffness[reach, i] * z[i + at]
        force[mesh.clamp[k]] += force[j] - pull


@kernel
def follow_clamped(values, first, end, mesh):
    """The end of a wire that is clamped to another one moves with it; first, end: of the clamps that take part."""
    for k in range(first, end):
        values[mesh.clamped[k]] = values[mesh.clamp[k]]


@kernel
def explicit_steps(t, h, n, motion, mesh, stiffness, laws):
    """n equal velocity-Verlet steps over h from the time t; motion, laws: see `wires`.

    motion.x: displacement, velocity, acceleration, (N,) each, contacts[, gusts][, window (2,)].  motion.work: (2, N + 2 PAD W).
    stiffness: as of `fill_diagonals`.

    The damping force uses the predicted velocity v + d/2 a: the step stays explicit and of second order.
    Source: Verlet in kick-drift-kick form.
    """
    N, nodes, W = mesh.mass.size, mesh.position.size, mesh.bending_gradient.size
    x, u, points = motion.x, motion.u, motion.points
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    padded, force = motion.work[0], motion.work[1, :N]
    z = padded[PAD * W : PAD * W + N]
    alpha, beta = 0.0, 0.0
    if laws.damping is not None:
        alpha, beta = laws.damping.alpha, laws.damping.beta
    lo, hi = 1, nodes - 2
    first_dropper, end_dropper, first_support, end_support = 0, mesh.dropper.size, 1, mesh.support.size - 1
    first_clamp, end_clamp = 0, mesh.clamped.size
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
        if motion.window is not None:
            lo, hi = move_window(front, rear, x, mesh, motion.window)
            if rear < mesh.position[lo]:  # the wire there was left behind and does not move any more
                return OUT_OF_RANGE
            first_dropper, end_dropper = first_at_or_after(mesh.dropper, lo), first_at_or_after(mesh.dropper, hi + 1)
            first_support = max(first_at_or_after(mesh.support, lo), 1)
            end_support = min(first_at_or_after(mesh.support, hi + 1), mesh.support.size - 1)
            first_clamp, end_clamp = first_at_or_after(mesh.clamped, W * lo), first_at_or_after(mesh.clamped, W * hi + W)
        here = slice(W * lo - W, W * hi + 2 * W)  # the moving nodes and one neighbour on either side

        drift(d, q[here], v[here], a[here], z[here], force[here], beta)
        follow_clamped(q, first_clamp, end_clamp, mesh)
        follow_clamped(v, first_clamp, end_clamp, mesh)
        follow_clamped(z, first_clamp, end_clamp, mesh)
        if motion.window is not None:  # an edge inside the wire: level beyond it, a dashpot that lets waves out
            for j in range(W):
                if lo > 1:
                    for i in range(1, PAD + 1):
                        padded[W * (PAD + lo - i) + j] = z[W * lo + j]
                    force[W * lo + j] -= mesh.impedance[W * lo + j] * v[W * lo + j]
                if hi < nodes - 2:
                    for i in range(1, PAD + 1):
                        padded[W * (PAD + hi + i) + j] = z[W * hi + j]
                    force[W * hi + j] -= mesh.impedance[W * hi + j] * v[W * hi + j]
        for k in range(first_dropper, end_dropper):
            change = dropper_tension(k, q, mesh, laws.slack) - mesh.preload[k]
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
        if motion.gusts is not None:
            moving, loads = slice(W * lo, W * hi + W), x[gust_state(points, mesh) :]
            share = follow_gusts(t + s, lo, hi, loads, mesh, motion.gusts)
            add_gusts(share, loads[LOADS : LOADS + N][moving], loads[LOADS + N : LOADS + 2 * N][moving], force[moving])
            add_air_damping(d, v[moving], a[moving], motion.gusts.push[0][moving], force[moving])
        add_clamped(padded, force, first_clamp, end_clamp, stiffness, mesh)
        kick(W * lo, W * hi + W, d, v, a, padded, force, mesh.inverse_mass, stiffness, alpha, W, laws.bending)
    motion.counts[0] += n
    motion.counts[1] += n
    if not math.isfinite(q[W * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
