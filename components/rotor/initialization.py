"""Constants that a beam rotor's parameters determine, and its state at the start."""

from __future__ import annotations

import math

from ..core.kernels import DONE, OWN, kernel
from ..core.linear import add_product, factor_general, solve_general
from .elements import circular_section
from .frame import add_frame_load, turn_frame
from .integration import NODES, SPEED, STEP, WATCHED, add_imbalance
from .model import DOFS, add_band, add_disk, add_disk_gyroscopic, assemble_shaft, nearest_node, place_nodes, turn
from .spin import TURN, acceleration_at, speed_at
from .statics import equilibrium
from .supports import NODE, add_supports, beyond_rows, follow_speed, hold_shaft

# status
(
    HOLLOW,
    NO_MATERIAL,
    UNBALANCE_LOST,
    WATCHED_BEYOND,
    DISK_BEYOND,
    SUPPORT_BEYOND,
    BEARING_BEYOND,
    SPEED_BEYOND,
    NO_METAL,
    NO_BODY,
) = range(OWN + 1, OWN + 11)
RIGID = -0.99  # Poisson's ratio below which a shear modulus is one of those who want no shear
THIN = 2.1  # polar over diametral inertia: 2 of a thin disk, the most that a body has, and the rounding of tables
LEAST = 0.15  # Poisson's ratio of metals: 0.2 of cast iron to 0.45 (handbooks), less the rounding of moduli


@kernel
def rotor_initialize(t, s, p, e):
    """Matrices, loads and places of the parameters; equilibrium at the start, but for the unbalance."""
    status = set_sections(s, p, e)
    if status == DONE:
        status = mesh_status(s, p, e)
    if status != DONE:
        return status
    set_matrices(s, p, e)
    set_loads(s, e)
    N, x = DOFS * s.mesh[NODES], s.x
    q, v, force, band, factors = x[:N], x[N : 2 * N], x[2 * N : 3 * N], s.now[0, :N], s.now[1, :N]
    angle, speed = p.start_angle % TURN, speed_at(t, p.start_speed, e.run_up)
    for j in range(N):
        force[j] = s.load[j]
    force[s.mesh[WATCHED]] += s.u[0, 0]
    force[s.mesh[WATCHED] + 1] += s.u[0, 1]
    if e.frame_rotation is not None:
        add_frame_load(0.0, speed, s, e.frame_rotation, force)
    if s.spans is not None:
        if beyond_rows(speed, s) or (e.run_up is not None and beyond_rows(e.run_up.end_speed, s)):
            return SPEED_BEYOND
        follow_speed(speed, s)
    copy_band(s.stiffness, band)
    add_supports(s.supports, 1.0, 0.0, band)
    if s.circulatory is not None:
        add_band(speed, s.circulatory[:N], band)
    equilibrium(band, factors, s, q, force, p.start_fall)
    if s.imbalance is not None:
        add_imbalance(angle, speed, acceleration_at(t, p.start_speed, e.run_up), s.imbalance, force)
    copy_band(s.mass, factors)
    factor_general(factors)
    solve_general(factors, force)  # the acceleration: a method with a spectral radius below 1 begins with it
    v[:] = 0.0
    x[3 * N] = angle
    s.room[:] = 0.0
    s.prepared[STEP] = s.prepared[SPEED] = math.nan
    return DONE


@kernel
def set_sections(s, p, e):
    """The sections of the shaft; whether each has a wall, of an isotropic material. A table's numbers that are none are the parameters'."""
    end = 0.0
    for k in range(s.sections.shape[0]):
        outer, inner, length = p.outer_diameter, p.inner_diameter, p.length
        youngs_modulus, shear_modulus, density = p.youngs_modulus, p.shear_modulus, p.density
        if e.shaft_table is not None:
            row = s.shaft[k]
            length, outer, inner = row[0], row[1], row[2]
            youngs_modulus = given(row[3], youngs_modulus)
            shear_modulus, density = given(row[4], shear_modulus), given(row[5], density)
        if inner >= outer:
            return HOLLOW
        poisson = 0.5 * youngs_modulus / shear_modulus - 1.0
        if not -1.0 < poisson <= 0.5 + 1e-9:  # 0.5 itself comes with its rounding
            s.refused[0] = poisson
            return NO_MATERIAL
        half = e.shaft_table is not None and math.isnan(s.shaft[k, 3]) != math.isnan(s.shaft[k, 4])
        if RIGID < poisson < (LEAST if half else 0.0):
            s.refused[0] = poisson
            return NO_METAL
        section = circular_section(outer, inner, youngs_modulus, shear_modulus, density)
        end += length
        s.sections[k, 0], s.sections[k, 1], s.sections[k, 2] = end, section.bending, section.shear
        s.sections[k, 3], s.sections[k, 4] = section.mass, section.inertia
    s.extent[0] = end
    return DONE


@kernel
def given(number, otherwise):
    """The number of a table, or another where the table has none."""
    return otherwise if math.isnan(number) else number


@kernel
def is_disk(row):
    """Whether a row of the disks, (4,), is one."""
    return row[1] + row[2] + row[3] != 0.0


@kernel
def add_place(position, count, s):
    """Note a place of the shaft at which there is to be a node; False: it is beyond the shaft."""
    s.refused[0] = position
    s.places[count] = position
    return 0.0 <= position <= s.extent[0] * (1.0 + 1e-12)


@kernel
def mesh_status(s, p, e):
    """Nodes, and which of them disks, supports, ports and the watched place have; whether all these are on the shaft."""
    if e.disks is not None and e.disk_table is None:
        for k in range(e.disks.mass.size):
            row = s.disk_rows[k]
            row[0], row[1] = e.disks.position[k], e.disks.mass[k]
            row[2], row[3] = e.disks.polar_inertia[k], e.disks.diametral_inertia[k]
    if e.unbalance is not None:
        for k in range(e.unbalance.moment.size):
            if e.unbalance.moment[k] != 0.0 and not (k < s.disk_rows.shape[0] and is_disk(s.disk_rows[k])):
                s.refused[0] = k + 1.0
                return UNBALANCE_LOST
    count = 2  # behind the ends
    for k in range(s.sections.shape[0] - 1):
        s.places[count] = s.sections[k, 0]
        count += 1
    if not add_place(p.watched_position, count, s):
        return WATCHED_BEYOND
    count += 1
    for k in range(s.disk_rows.shape[0]):
        if is_disk(s.disk_rows[k]):
            if not add_place(s.disk_rows[k, 0], count, s):
                return DISK_BEYOND
            if s.disk_rows[k, 2] > THIN * s.disk_rows[k, 3]:
                return NO_BODY
            count += 1
    for k in range(s.supports.shape[0]):
        if not add_place(support_place(k, s, e), count, s):
            return SUPPORT_BEYOND
        count += 1
    if e.bearing_a is not None:
        if not add_place(e.bearing_a.position, count, s):
            return BEARING_BEYOND
        count += 1
    if e.bearing_b is not None:
        if not add_place(e.bearing_b.position, count, s):
            return BEARING_BEYOND
        count += 1
    s.mesh[NODES] = place_nodes(s.extent[0], s.places[:count], p.element, s.nodes)
    s.mesh[WATCHED] = DOFS * nearest_node(s.nodes[: s.mesh[NODES]], p.watched_position)
    return DONE


@kernel
def support_place(k, s, e):
    """Where a support stands, m."""
    if e.linear_supports is not None:
        return e.linear_supports.position[k]
    if s.spans is not None:
        return s.spans[k, 0]
    return 0.0


@kernel
def set_matrices(s, p, e):
    """Bands of shaft and disks, and the places where the shaft is held."""
    nodes = s.nodes[: s.mesh[NODES]]
    N = DOFS * nodes.size
    mass, damping, stiffness, rotary = s.mass[:N], s.damping[:N], s.stiffness[:N], s.now[0, :N]
    assemble_shaft(s.sections, nodes, mass, rotary, stiffness, s.matrix)
    add_band(1.0, rotary, mass)
    if s.gyroscopic is not None:
        turn(rotary, 2.0, s.gyroscopic[:N])
    damping[:] = 0.0
    if e.internal_damping is not None:
        add_band(e.internal_damping.time_constant, stiffness, damping)
        turn(stiffness, e.internal_damping.time_constant, s.circulatory[:N])
    for k in range(s.disk_rows.shape[0]):
        disk = s.disk_rows[k]
        if is_disk(disk):
            node = nearest_node(nodes, disk[0])
            add_disk(mass, node, disk[1], disk[3])
            if s.gyroscopic is not None:
                add_disk_gyroscopic(s.gyroscopic, node, disk[2])
            if e.unbalance is not None and k < e.unbalance.moment.size:
                s.imbalance[k, 0], s.imbalance[k, 1] = DOFS * node, e.unbalance.moment[k]
                s.imbalance[k, 2] = e.unbalance.phase[k]
    for k in range(s.supports.shape[0]):
        s.supports[k, NODE] = DOFS * nearest_node(nodes, support_place(k, s, e))
    if e.linear_supports is not None:
        hold_shaft(e.linear_supports, s)
    port = 0
    if e.bearing_a is not None:
        s.ports[port, 0], s.ports[port, 1], s.ports[port, 2] = (
            nearest_node(nodes, e.bearing_a.position),
            e.bearing_a.u,
            e.bearing_a.y,
        )
        port += 1
    if e.bearing_b is not None:
        s.ports[port, 0], s.ports[port, 1], s.ports[port, 2] = (
            nearest_node(nodes, e.bearing_b.position),
            e.bearing_b.u,
            e.bearing_b.y,
        )


@kernel
def set_loads(s, e):
    """Weight, and the loads of a turning frame on the rotor per speed and rate."""
    nodes = s.nodes[: s.mesh[NODES]]
    N = DOFS * nodes.size
    if e.gravity is not None:
        falling = s.room[0, :N]
        for j in range(N):
            falling[j] = -e.gravity.acceleration if j % DOFS == 1 else 0.0
        add_product(s.mass[:N], falling, s.load[:N])
    if e.frame_rotation is not None:
        turn_frame(nodes, s.gyroscopic[:N], s, e.frame_rotation)


@kernel
def copy_band(band, result):
    """The rows of `result` from a band that may have more rows."""
    for i in range(result.shape[0]):
        for k in range(result.shape[1]):
            result[i, k] = band[i, k]
