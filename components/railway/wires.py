"""Forces of the two wires, their droppers and supports, and the geometry of the moving contact: kernels."""

from __future__ import annotations

from ..core.kernels import kernel

# N; every nodal force starts from this instead of 0. Ahead of the wave front displacements would otherwise shrink into
# the subnormal numbers, where each operation takes a hundred times as long. It lifts the wires by less than 1e-25 m.
WHISPER = 1e-27


@kernel
def add_wire_force(z, force, moment, tension, curvature, inverse_length, bending):
    """Add the restoring force of tension and bending for displacements z, all (2 k,) for k successive nodes.

    string: T (z[i+1] - z[i]) / L - T (z[i] - z[i-1]) / l.  beam: the moment EI z'' at the nodes, its second difference.
    The first and the last node are neighbours that act on the others and get no force; there is no moment in them.
    """
    left, here, right = z[:-4], z[2:-2], z[4:]  # shifted views: plain indices, which LLVM can turn into vector code
    tension_left, tension_right, into = tension[:-4], tension[2:-2], force[2:-2]
    for j in range(here.size):
        into[j] += tension_right[j] * (right[j] - here[j]) - tension_left[j] * (here[j] - left[j])
    if bending is not None:
        moment[:2] = 0.0
        moment[-2:] = 0.0
        over_left, over_right, stiffness = inverse_length[:-4], inverse_length[2:-2], curvature[2:-2]
        moment_left, moment_here, moment_right = moment[:-4], moment[2:-2], moment[4:]
        for j in range(here.size):
            moment_here[j] = stiffness[j] * (over_right[j] * (right[j] - here[j]) - over_left[j] * (here[j] - left[j]))
        for j in range(here.size):
            into[j] += over_right[j] * (moment_here[j] - moment_right[j]) - over_left[j] * (moment_left[j] - moment_here[j])


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


@kernel
def element_at(position, mesh):
    """Number of the element that holds a position on the wire, its ends included."""
    cell = min(max(int(position / mesh.cell), 0), mesh.node_of.size - 1)
    i = mesh.node_of[cell]
    while i < mesh.position.size - 2 and mesh.position[i + 1] <= position:
        i += 1
    return min(i, mesh.position.size - 2)  # the last node starts no element


@kernel
def wire_height(position, q, mesh):
    """Height of the contact wire at a position, m: static shape plus displacement, linear between the nodes.

    The kink that the string has under the contact force, inside an element, is not part of it: `local_compliance`.
    """
    i = element_at(position, mesh)
    s = (position - mesh.position[i]) / mesh.length[i]
    shape = (1.0 - s) * mesh.height[i] + s * mesh.height[i + 1] - s * (1.0 - s) * mesh.bow[i]
    return shape + (1.0 - s) * q[2 * i] + s * q[2 * i + 2]


@kernel
def wire_velocity(position, v, mesh):
    """Vertical velocity of the contact wire's material at a position, m/s."""
    i = element_at(position, mesh)
    s = (position - mesh.position[i]) / mesh.length[i]
    return (1.0 - s) * v[2 * i] + s * v[2 * i + 2]


@kernel
def local_compliance(position, mesh):
    """Deflection per force of the string under a point load, relative to the chord of its element, m/N.

    s (1 - s) L / T at s of an element: what linear elements leave out. It has no inertia, so it acts in series with the
    contact spring, and the partner that owns that spring puts it there.
    """
    i = element_at(position, mesh)
    s = (position - mesh.position[i]) / mesh.length[i]
    return s * (1.0 - s) / mesh.tension[2 * i]


@kernel
def add_contact(position, load, force, mesh):
    """Add a point load to the nodes beside it, N."""
    i = element_at(position, mesh)
    s = (position - mesh.position[i]) / mesh.length[i]
    force[2 * i] += (1.0 - s) * load
    force[2 * i + 2] += s * load


@kernel
def in_range(position, mesh):
    """Whether a contact point is on the wire, at least one element away from its ends."""
    return mesh.position[1] <= position < mesh.position[mesh.position.size - 2]
