"""Forces of the two wires and their droppers: kernels."""

from __future__ import annotations

from ..core.kernels import kernel

# N; every nodal force starts from this instead of 0. Ahead of the wave front displacements would otherwise shrink into
# the subnormal numbers, where each operation takes a hundred times as long. It lifts the wires by less than 1e-25 m.
WHISPER = 1e-27


@kernel
def tension_and_bending(z, w, kink, tension, curvature, bending_gradient, inverse_length, bending):
    """w = T z - C z_xx for displacements z of successive nodes, all (2 k,), whose second difference is the restoring force.

    C = EI + T h²/12 (`curvature`, over the mean length): T z_xx from five nodes, to the fourth order in h. Bending takes
    h²/6 EI z_xxxx more (`bending_gradient`, (2,)), for the same order. The first and the last node bear no moment.
    """
    left, here, right = z[:-4], z[2:-2], z[4:]  # shifted views: plain indices, which LLVM can turn into vector code
    over_left, over_right = inverse_length[:-4], inverse_length[2:-2]
    inner, pull, stiffness = w[2:-2], tension[2:-2], curvature[2:-2]
    for j in range(2):
        w[j] = tension[j] * z[j]
        w[w.size - 2 + j] = tension[j] * z[z.size - 2 + j]
    if bending is None:
        for j in range(here.size):
            slope = over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
            inner[j] = pull[j] * here[j] - stiffness[j] * slope
    else:
        kink_left, kink_here, kink_right = kink[:-4], kink[2:-2], kink[4:]
        kink[:2] = 0.0
        kink[-2:] = 0.0
        for j in range(here.size):
            kink_here[j] = over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j])
            inner[j] = pull[j] * here[j] - stiffness[j] * kink_here[j]
        for j in range(0, here.size, 2):
            inner[j] += bending_gradient[0] * (kink_left[j] - 2.0 * kink_here[j] + kink_right[j])
            inner[j + 1] += bending_gradient[1] * (kink_left[j + 1] - 2.0 * kink_here[j + 1] + kink_right[j + 1])


@kernel
def dropper_tension(k, u, mesh, slack):
    """Tension of dropper k for displacements u, N; with `slack` (an effect or None) never below 0."""
    j = 2 * mesh.dropper[k]
    tension = mesh.preload[k] + mesh.dropper_stiffness[k] * (u[j + 1] - u[j])
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
