"""Explicit integration of the wires: leapfrog with lumped masses, in one sweep along the rows of the state.

    w = w + (d_before + d) / 2 a,   q = q + d w,   v = w + d/2 a,   a = (forces of q + beta v) / m - damping of v

w is the velocity at the middle of a step, v that which the acceleration before the step predicts for its end: damping stays
explicit and of second order. It is velocity Verlet with half of the kicks put together; that needs a second pass over the rows.
What the sweep has read once stays in the processor's nearest cache until it is done with: displacements by block, `drift`, and
behind them the pull of the wires, `kick`. What acts at a few nodes comes afterwards, as acceleration. Source: Verlet, leapfrog form.
"""

from __future__ import annotations

import math

from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, kernel
from .contact import element_at, in_range, shape_weights
from .gust_loads import LOADS, accelerate_by_gusts, follow_gusts, gust_state
from .moving_window import FOUND, follow_speed, move_window
from .wires import DENORMAL_GUARD, dropper_tension, row_length, state_rows

PAD = 3  # nodes beyond either end: so far the stiffness of a wire reaches
BLOCK = 512  # degrees of freedom from drift to kick; half and twice as many cost the same


@kernel
def margin(W):
    """Numbers before a row that is read to the left, too: `PAD` nodes, in whole lines of the cache."""
    return row_length(PAD * W)


@kernel
def fill_wire_rows(band, mesh, rows):
    """Upper band (N, 3 W + 1) of all wires by diagonals, and what forces are multiplied with, into rows (5 or 6, N and margin).

    Row k has K[j, j + k W] at j + margin, 0 before. The last but one has 1/m; where a wire's end is clamped that of its clamp,
    which takes the acceleration over. The last one is that of `fill_damping`.
    """
    W, first = mesh.bending_gradient.size, margin(mesh.bending_gradient.size)
    rows[:] = 0.0
    for k in range(rows.shape[0] - 2):
        for j in range(band.shape[0]):
            rows[k, first + j] = band[j, k * W]
    over_mass = rows[rows.shape[0] - 2, first:]
    for j in range(mesh.mass.size):
        over_mass[j] = mesh.inverse_mass[j]
    for k in range(mesh.clamped.size):
        over_mass[mesh.clamped[k]] = mesh.inverse_mass[mesh.clamp[k]]


@kernel
def fill_damping(alpha, dashpots, mesh, rows):
    """Damping of masses and at nodes over the mass, 1/s, into the last of `rows`; dashpots: (N,) N.s/m."""
    first = margin(mesh.bending_gradient.size)
    over_mass, rate = rows[rows.shape[0] - 2, first:], rows[rows.shape[0] - 1, first:]
    for j in range(mesh.mass.size):
        rate[j] = (alpha if mesh.inverse_mass[j] > 0.0 else 0.0) + dashpots[j] * over_mass[j]


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
def drift(between, d, q, w, a, z, rate, beta):
    """Kick over the time `between` the middles of two steps, drift over d; z becomes q + beta v, a the damping; all (n,)."""
    for j in range(q.size):
        w[j] += between * a[j]
        q[j] += d * w[j]
        v = w[j] + 0.5 * d * a[j]
        z[j] = q[j] + beta * v
        a[j] = -rate[j] * v


@kernel
def kick(j, end, at, z, a, rows, W, bending):
    """Add the acceleration by the wires' pull; degrees of freedom j to end - 1, of which the first one is z[at]; rows: `fill_wire_rows`.

    One sum over five nodes, or seven of beams: with slopes and bending moments kept in between, the processor would load and
    store numbers for twice as long.
    """
    m, i = end - j, j + margin(W)
    over_mass, ac = rows[rows.shape[0] - 2, i : i + m], a[j:end]
    # shifted views: plain indices, which LLVM can vectorize
    own, right, further_right = rows[0, i : i + m], rows[1, i : i + m], rows[2, i : i + m]
    left, further_left = rows[1, i - W : i - W + m], rows[2, i - 2 * W : i - 2 * W + m]
    here, z_left, z_right = z[at : at + m], z[at - W : at - W + m], z[at + W : at + W + m]
    z_further_left, z_further_right = z[at - 2 * W : at - 2 * W + m], z[at + 2 * W : at + 2 * W + m]
    if bending is not None:
        last_right, last_left = rows[3, i : i + m], rows[3, i - 3 * W : i - 3 * W + m]
        z_last_left, z_last_right = z[at - 3 * W : at - 3 * W + m], z[at + 3 * W : at + 3 * W + m]
    for k in range(m):
        pull = own[k] * here[k] + (left[k] * z_left[k] + right[k] * z_right[k])
        pull += further_left[k] * z_further_left[k] + further_right[k] * z_further_right[k]
        if bending is not None:
            pull += last_left[k] * z_last_left[k] + last_right[k] * z_last_right[k]
        ac[k] += (DENORMAL_GUARD - pull) * over_mass[k]


@kernel
def sweep(first, end, level, between, d, motion, mesh, rows, beta, bending):
    """Drift and kick of the degrees of freedom first to end - 1, block by block.

    level: whether the wires beyond the first one are level; else they are fixed at 0. Those beyond the last one are fixed where they are.
    motion.work: (BLOCK and 5 margins,), displacements of a block and of what the kick behind it reads.
    """
    N, W = mesh.mass.size, mesh.bending_gradient.size
    q, w, a = state_rows(motion.x, N)
    z, H, rate = motion.work, margin(W), rows[rows.shape[0] - 1, margin(W) :]
    for i in range(2 * H):
        z[i] = 0.0
    done, j = first, first
    while j < end:
        e = min(j + BLOCK, end)
        if end - e < 2 * H:
            e = end
        m = e - j
        drift(between, d, q[j:e], w[j:e], a[j:e], z[2 * H : 2 * H + m], rate[j:e], beta)
        if level and j == first:
            for i in range(PAD * W):
                z[2 * H - 1 - i] = z[2 * H + W - 1 - i % W]
        to = e - H
        if e == end:
            for i in range(PAD * W):
                z[2 * H + m + i] = q[e + i] if e + i < N else 0.0
            to = end
        kick(done, to, 2 * H + done - j, z, a, rows, W, bending)
        for i in range(2 * H):  # not by slices: they may overlap, and Numba would copy
            z[i] = z[m + i]
        done, j = to, e


@kernel
def explicit_steps(t, h, n, motion, mesh, rows, laws):
    """n equal steps over h from the time t; motion, laws: see `wires`; rows: see `fill_wire_rows`; motion.work: see `sweep`."""
    N, W = mesh.mass.size, mesh.bending_gradient.size
    x, u, points = motion.x, motion.u, motion.points
    q, w, a = state_rows(x, N)
    over_mass = rows[rows.shape[0] - 2, margin(W) :]
    alpha, beta = 0.0, 0.0
    if laws.damping is not None:
        alpha, beta = laws.damping.alpha, laws.damping.beta
    follow_speed(x, points, mesh, motion.window, alpha, beta)
    moving = motion.window[FOUND:]
    d, before = h / n, 3 * row_length(N)
    for values in (q, w, a):
        for k in range(mesh.clamped.size):  # as the wire that it is clamped to; from here on they move alike
            values[mesh.clamped[k]] = values[mesh.clamp[k]]
    for step in range(n):
        s = (step + 1) * d
        front, rear = -math.inf, math.inf
        for k in range(points.shape[0]):
            i = points[k, 0]
            position = u[0, i] + s * (u[1, i] + s * u[2, i])
            if not in_range(position, mesh):
                return OUT_OF_RANGE
            front, rear = max(front, position), min(rear, position)
        lo, hi = move_window(front, rear, x, mesh, motion.window)
        if rear < mesh.position[lo]:  # the wire there was left behind and does not move any more
            return OUT_OF_RANGE
        first, end = W * lo if lo > 1 else 0, W * hi + W

        sweep(first, end, lo > 1, 0.5 * (x[before] + d), d, motion, mesh, rows, beta, laws.bending)
        x[before] = d
        if motion.gusts is not None:
            loads = x[gust_state(points, mesh) :]
            share = follow_gusts(t + s, lo, hi, loads, mesh, motion.gusts)
            one, other = loads[LOADS + first : LOADS + end], loads[LOADS + N + first : LOADS + N + end]
            accelerate_by_gusts(share, one, other, over_mass[first:end], a[first:end])
        for k in range(int(moving[0]), int(moving[1])):
            change = dropper_tension(k, q, mesh, laws.slack) - mesh.preload[k]
            a[mesh.lower[k]] += change * over_mass[mesh.lower[k]]
            a[mesh.upper[k]] -= change * over_mass[mesh.upper[k]]
        for k in range(int(moving[2]), int(moving[3])):
            for j in range(W * mesh.support[k], W * mesh.support[k] + W):
                a[j] -= over_mass[j] * mesh.ground[j] * q[j]
        for k in range(points.shape[0]):
            i, f = points[k, 0], points[k, 1]
            position = u[0, i] + s * (u[1, i] + s * u[2, i])
            load = u[0, f] + s * (u[1, f] + s * u[2, f])
            e, at_left, here, there, at_right = shape_weights(position, points[k, 4], mesh)
            j = W * e + 2 * points[k, 4]
            a[j - W] += at_left * load * over_mass[j - W]
            a[j] += here * load * over_mass[j]
            a[j + W] += there * load * over_mass[j + W]
            a[j + 2 * W] += at_right * load * over_mass[j + 2 * W]
        if lo > 1:  # an edge inside the wire: a dashpot that lets waves out
            for j in range(first, first + W):
                a[j] -= over_mass[j] * mesh.impedance[j] * w[j]
        for k in range(int(moving[4]), int(moving[5])):
            a[mesh.clamp[k]] += a[mesh.clamped[k]]
        for k in range(int(moving[4]), int(moving[5])):
            a[mesh.clamped[k]] = a[mesh.clamp[k]]
    motion.counts[0] += n
    motion.counts[1] += n
    if not math.isfinite(q[W * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
