"""Forces of the wires, their droppers, clamps and changes of tension: kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.kernels import kernel, kernel_tuple

# N; every nodal force starts from this instead of 0. Ahead of the wave front displacements would otherwise shrink into
# the subnormal numbers, where each operation takes a hundred times as long. It lifts the wires by less than 1e-25 m.
DENORMAL_GUARD = 1e-27


LINE = 8  # numbers of a line of the cache, with which each row of the state begins


@kernel
def row_length(N):
    """Numbers of a row of the state for N degrees of freedom, in whole lines of the cache."""
    return N + (-N) % LINE


@kernel
def state_rows(x, N):
    """Displacement q, m, velocity w, m/s, and acceleration a, m/s², (N,) each, of the state.

    The explicit method has w at the middle of its last step d: the velocity is w + d/2 a. The implicit one has the velocity, d = 0.
    """
    S = row_length(N)
    return x[:N], x[S : S + N], x[2 * S : 2 * S + N]


@kernel
def last_step(x, N):
    """The step d of `state_rows`, s."""
    return x[3 * row_length(N)]


@kernel
def contacts_at(N):
    """Where place and speed of the contact points begin in the state, behind rows and last step."""
    return 3 * row_length(N) + 1


@kernel_tuple
class Motion(NamedTuple):
    """The wires' state, which a step changes, and the m inputs that move them."""

    x: np.ndarray  # state: see `state_rows`, `last_step`, `contacts_at`, `gust_loads.gust_state`; then window (2,), or taut (d,)
    u: np.ndarray  # (3, m)
    points: np.ndarray  # (p, 5) int, as of `contact.contact_points`
    work: np.ndarray
    counts: np.ndarray
    window: Any  # lengths of the moving window, or None
    gusts: Any  # `Buffeting` or None


@kernel_tuple
class Laws(NamedTuple):
    """Effects of `Catenary` that decide how wires and droppers move, or None."""

    slack: Any
    bending: Any
    damping: Any


@kernel_tuple
class Shown(NamedTuple):
    """Effects of which outputs tell, or None; others do not have `put_outputs` compiled anew."""

    gusts: Any
    moving_window: Any
    stagger: Any
    blow_off: Any
    wire_profile: Any
    line_profile: Any


@kernel
def shown(e):
    """What outputs get of all effects."""
    return Shown(e.gusts, e.moving_window, e.stagger, e.blow_off, e.wire_profile, e.line_profile)


@kernel
def tension_and_bending(z, w, kink, tension, curvature, bending_gradient, inverse_length, bending):
    """w = T z - C z_xx for displacements z of successive nodes, all (W k,), whose second difference is the restoring force.

    C = EI + T h²/12 (`curvature`, over the mean length): T z_xx from five nodes, to the fourth order in h. Bending takes
    h²/6 EI z_xxxx more (`bending_gradient`, (W,)), for the same order. The first and the last node bear no moment.
    """
    W, n = bending_gradient.size, z.size
    left, here, right = z[: n - 2 * W], z[W : n - W], z[2 * W :]  # shifted views: plain indices, which LLVM can vectorize
    over_left, over_right = inverse_length[: n - 2 * W], inverse_length[W : n - W]
    inner, pull, stiffness = w[W : n - W], tension[W : n - W], curvature[W : n - W]
    for j in range(W):
        w[j] = tension[j] * z[j]
        w[n - W + j] = tension[n - W + j] * z[n - W + j]
    if bending is None:
        for j in range(here.size):
            slope = over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
            inner[j] = pull[j] * here[j] - stiffness[j] * slope
    else:
        kink_left, kink_here, kink_right = kink[: n - 2 * W], kink[W : n - W], kink[2 * W :]
        kink[:W] = 0.0
        kink[n - W :] = 0.0
        for j in range(here.size):
            kink_here[j] = over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
            inner[j] = pull[j] * here[j] - stiffness[j] * kink_here[j]
        for wire in range(W):
            for j in range(wire, here.size, W):
                inner[j] += bending_gradient[wire] * (kink_left[j] - 2.0 * kink_here[j] + kink_right[j])


@kernel
def dropper_tension(k, u, mesh, slack):
    """Tension of dropper k for displacements u, N; with `slack` (an effect or None) never below 0."""
    tension = mesh.preload[k] + mesh.dropper_stiffness[k] * (u[mesh.upper[k]] - u[mesh.lower[k]])
    if slack is not None:
        tension = max(tension, 0.0)
    return tension


@kernel
def first_at_or_after(nodes, node):
    """Index of the first element of the sorted `nodes` that is not below `node`."""
    low, high = 0, nodes.size
    while low < high:
        middle = (low + high) // 2
        if nodes[middle] < node:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def add_jumps(z, force, first, end, mesh):
    """Where the tension of a wire changes at a node: `tension_and_bending` has there that of the left element, for both.

    first, end: of the changes that take part.
    """
    W = mesh.bending_gradient.size
    for k in range(first, end):
        j = mesh.jump[k]
        change = mesh.jump_change[k] * z[j] * mesh.inverse_length[j]
        force[j] += change
        force[j + W] -= change
