"""The moving contact on the mesh of a wire: its shape function, and the compliance of the waves that the mesh cannot hold.

Inside the mesh a wave of wave number k meets the stiffness and the mass of the wire to the fourth order in k h. A contact that
moves reads and loads the wire through a shape function over four nodes, whose own error is of the same order; with hat functions
over two nodes it would be (k h)²/6 of the contact's compliance. The shape function is the same for force and height, so that
both do the same work.

The waves beyond the mesh, k > pi / h, follow the force without delay: a compliance in series with the contact spring,
`contact_compliance`, and in series with droppers and supports, `node_compliance`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import hold_inputs, kernel, kernel_tuple
from .catenary_effects import FURTHER
from .wires import contacts_at, dropper_tension, first_at_or_after, last_step, state_rows

SPEEDS = 33  # points of the table of the compliance
FASTEST = 0.98  # of the wave speed: end of the table


def contact_points(own: tuple[int, ...], e, wires: int) -> np.ndarray:
    """Of each contact point its position and force in u, its first output in y and how far the next ones are, its contact wire.

    (p, 5) int; own: those of the component's own point; e: effects; wires: number of contact wires. Points of
    `further_pantographs` beyond their number do not take part.
    """
    points = [own]
    if e.second_pantograph is not None:
        second = e.second_pantograph
        points.append((second.u, second.u + 1, second.y, 1, 0))
    if e.further_pantographs is not None:
        more = e.further_pantographs
        points += [(more.u + i, more.u + FURTHER + i, more.y + i, FURTHER, 0) for i in range(int(more.count))]
    if e.second_wire is not None and wires > 1:
        wide = 2 + FURTHER
        points += [(points[k][0], e.second_wire.u + k, e.second_wire.y + k, wide, 1) for k in range(len(points))]
    return np.array(points, dtype=np.int64)


@kernel
def element_at(position, mesh):
    """Number of the element that holds a position on the wire, its ends included."""
    cell = min(max(int(position / mesh.cell), 0), mesh.node_of.size - 1)
    i = mesh.node_of[cell]
    while i < mesh.position.size - 2 and mesh.position[i + 1] <= position:
        i += 1
    return min(i, mesh.position.size - 2)  # the last node starts no element


@kernel
def in_range(position, mesh):
    """Whether a contact point is on the wire, at least one element away from its ends."""
    return mesh.position[1] <= position < mesh.position[mesh.position.size - 2]


@kernel
def wire_kind(i, wire, mesh):
    """Which of the different contact wires element i of contact wire 0 or 1 belongs to."""
    return mesh.kind[wire * mesh.position.size + i]


@kernel
def shape_weights(position, wire, mesh):
    """Element i of a position and the weights of the nodes i - 1 to i + 2 of a contact wire, 0 or 1.

    Linear between the nodes i and i + 1, less sharpness s (1 - s) L² u''/2, u'' the mean of the second differences at both
    nodes: 0 takes two nodes, 1 makes a cubic through four. A little less than 1 takes back what the step in time adds.
    """
    i = element_at(position, mesh)
    here = mesh.length[i]
    s = (position - mesh.position[i]) / here
    if i < 1 or i > mesh.position.size - 3:
        return i, 0.0, 1.0 - s, s, 0.0
    left, right = here / mesh.length[i - 1], here / mesh.length[i + 1]
    bubble = 0.25 * mesh.sharpness[wire_kind(i, wire, mesh)] * s * (1.0 - s)
    at_left, at_right = 2.0 * bubble / (1.0 + 1.0 / left), 2.0 * bubble / (1.0 + 1.0 / right)
    outer_left, outer_right = at_left * left, at_right * right
    return (i, -outer_left, 1.0 - s + at_left + outer_left - at_right, s + at_right + outer_right - at_left, -outer_right)


@kernel
def over_nodes(weights, u, wire, mesh):
    """Displacement or velocity of a contact wire, u (N,), with the `shape_weights` of a position."""
    i, a, b, c, d = weights
    W = mesh.bending_gradient.size
    j = W * i + 2 * wire
    value = b * u[j] + c * u[j + W]
    if 1 <= i <= mesh.position.size - 3:
        value += a * u[j - W] + d * u[j + 2 * W]
    return value


@kernel
def add_contact(position, load, force, wire, mesh):
    """Add a point load on a contact wire to the nodes around it, N; the position is in range."""
    i, a, b, c, d = shape_weights(position, wire, mesh)
    W = mesh.bending_gradient.size
    j = W * i + 2 * wire
    force[j - W] += a * load
    force[j] += b * load
    force[j + W] += c * load
    force[j + 2 * W] += d * load


@kernel
def wire_height(position, q, wire, mesh):
    """Height of a contact wire at a position, m: static shape plus displacement."""
    weights = shape_weights(position, wire, mesh)
    return rest_height(position, weights[0], wire, mesh) + over_nodes(weights, q, wire, mesh)


@kernel
def rest_height(position, i, wire, mesh):
    """Static shape of a contact wire at a position in element i, m."""
    s = (position - mesh.position[i]) / mesh.length[i]
    j = wire * mesh.position.size + i
    return (1.0 - s) * mesh.height[j] + s * mesh.height[j + 1] - s * (1.0 - s) * mesh.bow[j]


@kernel
def wire_motion(position, x, wire, mesh):
    """Height of a contact wire at a position, m, and its vertical velocity, m/s, of the state x."""
    N, weights = mesh.mass.size, shape_weights(position, wire, mesh)
    q, w, a = state_rows(x, N)
    height = rest_height(position, weights[0], wire, mesh) + over_nodes(weights, q, wire, mesh)
    return height, over_nodes(weights, w, wire, mesh) + 0.5 * last_step(x, N) * over_nodes(weights, a, wire, mesh)


@kernel
def lateral_position(position, wire, lateral):
    """Lateral position of a contact wire, m, straight between the rows (wire, position, stagger, number) of `lateral`, else 0."""
    for k in range(lateral.shape[0] - 1):
        a, b = lateral[k, 1], lateral[k + 1, 1]
        if lateral[k, 0] == wire and lateral[k + 1, 0] == wire and a <= position <= b and b > a:
            s = (position - a) / (b - a)
            return (1.0 - s) * lateral[k, 2] + s * lateral[k + 1, 2]
    return 0.0


@kernel
def blown_off(position, wire, lateral, tension, wind):
    """Displacement to the side by a wind (`BlowOff`), m: p x (L - x) / 2 T between supports, 0 beyond them.

    lateral: as of `lateral_position`, the number that of the wire in `tension`, N.
    """
    load = 0.5 * wind.density * wind.drag_coefficient * wind.diameter * wind.speed * abs(wind.speed)
    for k in range(lateral.shape[0] - 1):
        a, b = lateral[k, 1], lateral[k + 1, 1]
        if lateral[k, 0] == wire and lateral[k + 1, 0] == wire and a <= position <= b and b > a:
            return load * (position - a) * (b - position) / (2.0 * tension[int(lateral[k, 3])])
    return 0.0


@kernel
def follow_contacts(h, x, u, points, mesh):
    """End of a step of length h: the inputs are held, and place (m) and speed (m/s) of the contact points are remembered.

    The speed from two places, not from an input's slope, which partners that hand over bare values do not give. A jump faster
    than the wire's waves is no motion.
    """
    hold_inputs(u, h)
    fastest = 0.0
    for k in range(mesh.fastest.size):
        fastest = max(fastest, mesh.fastest[k])
    for k in range(points.shape[0]):
        i, position = contacts_at(mesh.mass.size) + 2 * k, u[0, points[k, 0]]
        speed = (position - x[i]) / h
        x[i] = position
        if abs(speed) <= fastest:
            x[i + 1] = speed


@kernel
def heights_around(position, q, mesh, heights):
    """Heights of the first contact wire at points 1 m apart, `position` in the middle, its ends' beyond them, m; heights (n,).

    As `wire_height`, for many points at once: nodes are passed in order, and few numbers are divided by others.
    """
    n, W = mesh.position.size, mesh.bending_gradient.size
    first = position - heights.size // 2
    i = element_at(min(max(first, 0.0), mesh.position[n - 1]), mesh)
    for k in range(heights.size):
        x = min(max(first + k, 0.0), mesh.position[n - 1])
        while i < n - 2 and mesh.position[i + 1] <= x:
            i += 1
        j = W * i
        s = (x - mesh.position[i]) * mesh.inverse_length[j]
        here, there = q[j], q[j + W]
        value = (1.0 - s) * (mesh.height[i] + here) + s * (mesh.height[i + 1] + there) - s * (1.0 - s) * mesh.bow[i]
        if 0 < i < n - 2:
            left, right = mesh.length[i] * mesh.inverse_length[j - W], mesh.length[i] * mesh.inverse_length[j + W]
            bend_left = left / (1.0 + left) * (there - here - left * (here - q[j - W]))
            bend_right = right / (1.0 + right) * (right * (q[j + 2 * W] - there) - there + here)
            value -= 0.5 * mesh.sharpness[mesh.kind[i]] * s * (1.0 - s) * (bend_left + bend_right)
        heights[k] = value


@kernel
def hung_around(position, q, mesh, lanes, hung):
    """At points 1 m apart, `position` in the middle: what the contact wire hangs from, as `LineProfile` tells it.

    lanes: of a plan; hung: (3n,), displacement of the second lane, m, least tension of droppers near, N, 0 where one is slack and -1
    where there is none, and displacement of the first auxiliary wire, m, 0 without one.
    """
    n, W, points = mesh.position.size, mesh.bending_gradient.size, hung.size // 3
    messenger, tension, auxiliary = hung[:points], hung[points : 2 * points], hung[2 * points :]
    lane = 0
    while lane < W and lanes[lane] >= 0:
        lane += 1
    first = position - points // 2
    i = element_at(min(max(first, 0.0), mesh.position[n - 1]), mesh)
    d = first_at_or_after(mesh.dropper, i)
    for k in range(points):
        x = min(max(first + k, 0.0), mesh.position[n - 1])
        while i < n - 2 and mesh.position[i + 1] <= x:
            i += 1
        s = (x - mesh.position[i]) * mesh.inverse_length[W * i]
        messenger[k] = (1.0 - s) * q[W * i + 1] + s * q[W * i + W + 1]
        auxiliary[k] = (1.0 - s) * q[W * i + lane] + s * q[W * i + W + lane] if lane < W else 0.0
        tension[k] = -1.0
    while d < mesh.dropper.size:
        k = int(mesh.position[mesh.dropper[d]] - first + 0.5)
        if k >= points:
            break
        if k >= 0:
            pull = max(dropper_tension(d, q, mesh, None), 0.0)
            tension[k] = pull if tension[k] < 0.0 else min(tension[k], pull)
        d += 1


@kernel_tuple
class WireOnMesh(NamedTuple):
    """Numbers that decide how waves travel along one wire, and along its mesh."""

    tension: float  # N
    mass: float  # kg/m
    bending: float  # N m², EI
    element: float  # m, h
    curvature: float  # N m², E4: what the mesh adds to EI for the fourth order in space, less what the step in time adds
    gradient: float  # N m⁴, E6 = EI h²/6
    time_error: float  # s², share that the step in time adds to a squared frequency, over its omega²/12
    sharpness: float  # of the contact's shape function
    alpha: float  # 1/s
    beta: float  # s


@kernel
def compliance_table(wire, table):
    """Mean compliance that a mesh leaves out under a force that moves, m/N, for SPEEDS speeds from 0 to FASTEST c; table (n,).

    In the frame of a force that moves at v, averaged over its place within an element,

        c = 1/pi ∫ Re [1 / D(k) - W(k)² / D_h(k)] dk,   k > 0,   z = k h / 2
        D = (T k² + EI k⁴) (1 - i beta v k) - m v² k² - i alpha m v k
        D_h = (T q² + (EI + E4) q⁴ + E6 q⁶) (1 - i beta v k) - m v² k² (1 + tau v² k²/12) - i alpha m v k,   q = 2 sin(z) / h
        W = (sin z / z)² (1 + sharpness cos z (sin z / z - cos z))
    """
    T, m, EI, h = wire.tension, wire.mass, wire.bending, wire.element
    c = math.sqrt(T / m)
    n, end = 1200, 4.0 * math.pi  # midpoints up to z = 4 pi; W⁴ leaves less than 1e-4 of the integral beyond
    for j in range(table.size):
        v = FASTEST * c * j / (table.size - 1)
        # A trace of damping: undamped, the mesh's slow waves make a pole, whose principal value is meant.
        lag = max(wire.beta * v, 0.02 * h * v / c)
        total = 0.0
        for i in range(n):
            z = end * (i + 0.5) / n
            k, q = 2.0 * z / h, 2.0 * math.sin(z) / h
            sinc = math.sin(z) / z
            W = sinc * sinc * (1.0 + wire.sharpness * math.cos(z) * (sinc - math.cos(z)))
            stiffness = T * k**2 + EI * k**4
            on_mesh = T * q**2 + (EI + wire.curvature) * q**4 + wire.gradient * q**6
            inertia, drag = m * (v * k) ** 2, wire.alpha * m * v * k
            re, im = stiffness - inertia, stiffness * lag * k + drag
            re_h, im_h = on_mesh - inertia * (1.0 + wire.time_error * (v * k) ** 2 / 12.0), on_mesh * lag * k + drag
            total += re / (re**2 + im**2) - W * W * re_h / (re_h**2 + im_h**2)
        total *= end / n * 2.0 / h
        last = 2.0 * end / h  # beyond it the wire alone, k = last / s
        for i in range(200):
            s = (i + 0.5) / 200
            k = last / s
            stiffness = T * k**2 + EI * k**4
            re, im = stiffness - m * (v * k) ** 2, stiffness * lag * k
            total += re / (re**2 + im**2) * last / s**2 / 200
        table[j] = total / math.pi


@kernel
def node_compliance(wire):
    """Compliance that a mesh leaves out at a node under a force at rest, m/N.

    For strings linear elements are exact at their nodes: 1/(T q²) over the mesh's waves is 1/(T k²) over all of them. Bending
    takes sqrt(EI / T) / (2 T) off the wire.
    """
    T, EI, on_mesh, n = wire.tension, wire.bending, 0.0, 1000
    for i in range(n):
        q = 2.0 * math.sin(0.5 * math.pi * (i + 0.5) / n) / wire.element
        on_mesh += 1.0 / (T * q**2) - 1.0 / (T * q**2 + (EI + wire.curvature) * q**4 + wire.gradient * q**6)
    return on_mesh / n / wire.element - 0.5 * math.sqrt(EI / T) / T


@kernel
def contact_compliance(speed, position, wire, mesh):
    """Compliance for a contact point that moves at a speed, m/N: linear in the wire's table, its last value beyond."""
    kind = wire_kind(element_at(position, mesh), wire, mesh)
    table = mesh.compliance[kind * SPEEDS : (kind + 1) * SPEEDS]
    place = min(abs(speed) / mesh.fastest[kind], 1.0) * (table.size - 1)
    j = min(int(place), table.size - 2)
    return table[j] + (place - j) * (table[j + 1] - table[j])
