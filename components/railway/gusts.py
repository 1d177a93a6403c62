"""Gusts on the wires: a fluctuating wind across the line, with von Karman's spectra and a coherence that fades along the track.

Quasi-steady lift per length of a wire of diameter d in a wind U + u across it, w upwards, to the first order in u, w and z':

    f = rho d / 2 [C_L U² + 2 C_L U u + (C_L' + C_D) U (w - z')]

The first part belongs to the equilibrium at rest, the last one damps. The field is a sum of waves that travel along the track,

    u(x, t) = sum A_i cos(omega_i t + k_i x + phi_i),    A_i² / 2 = S(n_i) dn_i,

whose wave numbers k are random with Cauchy's distribution of the width a = C n / U: the spectrum of exp(-a |x|), Davenport's
coherence. What is shorter than a shortest wave is left out, of either field the share 1 - 2/pi atan(k_max / a): a wire averages
over it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import SEED, integer, output, parameter
from .gust_loads import DISTANCE, FIELDS, INTERVAL, Buffeting
from .line.plan import CLAMPED_TO, CONTACT, FROM, LANE, TO
from .mesh import Mesh, around
from .sines import TURN
from .statics import PRESENT, UNBALANCED, find_balance

PER_WAVE = 8.0  # samples in the shortest period, stations in the shortest wave
ACROSS = {"gusts.intensity", "gusts.length"}  # parameters of the wind across the line
SLACK_IN_WIND, NO_BAND = OWN + 9, OWN + 10  # statuses of `initialize`
REFUSALS = {
    SLACK_IN_WIND: Refusal(
        "gusts: a mean wind of {gusts.speed} m/s whose lift leaves {refused[0]} droppers slack at rest",
        "tension in every dropper",
        "Reduce speed, lift_coefficient or contact_wire_diameter.",
    ),
    NO_BAND: Refusal("gusts: frequencies from {gusts.lowest} to {gusts.highest} Hz", "a lowest one below the highest"),
}


class Gusts(Effect):
    """Wind across the line that fluctuates: its lift on the wires, and the damping by the air stream.

    Spectra after von Karman, coherence after Davenport, forms and the decay's size (8 to 16) from memory. Intensities and lengths
    are inferred: those of Davenport's and Panofsky's spectra 6 m above ground of 0.03 m roughness. Diameters from memory; round
    wires, C_L = C_L' = 0, are a choice: grooves and wear give a contact wire a lift. Messengers are round, stitch wires are
    left out. u and w are independent, and the same for all wires at a place. The wind's drag, which is lateral, is not modelled.
    """

    explicit_only = True

    speed = parameter(15.0, "m/s", "mean speed of the wind across the line", low=1e-3, high=100.0)
    density = parameter(1.225, "kg/m3", "density of the air", low=0.0)
    intensity = parameter(0.18, "1", "standard deviation across the line over the mean speed", low=0.0, high=1.0)
    vertical_intensity = parameter(0.09, "1", "standard deviation of the vertical speed over the mean speed", low=0.0, high=1.0)
    length = parameter(100.0, "m", "length scale of the gusts across the line", low=1e-3)
    vertical_length = parameter(2.5, "m", "length scale of the vertical gusts", low=1e-3)
    decay = parameter(10.0, "1", "decay C of the coherence along the line, exp(-C n distance / U)", low=1e-3)
    contact_wire_diameter = parameter(0.0145, "m", "diameter of a contact wire", low=0.0)
    messenger_diameter = parameter(0.014, "m", "diameter of a messenger", low=0.0)
    drag_coefficient = parameter(1.0, "1", "drag coefficient of the wires", low=0.0)
    lift_coefficient = parameter(0.0, "1", "lift coefficient of a contact wire in a level wind")
    lift_slope = parameter(0.0, "1/rad", "slope of that coefficient over the angle of the wind")
    lowest = parameter(0.02, "Hz", "lowest frequency", low=1e-4)
    highest = parameter(5.0, "Hz", "highest frequency", low=1e-3)
    shortest = parameter(12.0, "m", "shortest wave along the line", low=0.1)
    components = integer(200, "number of waves", low=1, high=2000, mesh="random")
    seed = integer(1, "of the random frequencies, wave numbers and phases", low=0, high=2**31 - 1, structural=SEED)

    load = output(
        "N/m",
        "lift per length of the gusts on the contact wire at the contact point, without its own motion's part",
        feedthrough=("contact_position",),
    )


def empty_buffeting(mesh: Mesh, components: int, seed: int) -> Buffeting:
    """Room for the waves on a mesh, with their random numbers."""
    n, random = components, np.random.default_rng(seed)
    place, share, turn = random.random(n), random.uniform(-1.0, 1.0, (2, n)), random.random((2, n))
    arrays: Any = (
        np.zeros(3),
        np.vstack((place, share, turn)),
        np.zeros(n),
        *np.zeros((3, 2, n)),
        *np.zeros((2, 2, 2, n)),
        np.zeros((2, mesh.mass.size)),
    )
    return Buffeting(*arrays)


@kernel
def von_karman(n, deviation, length, speed, lateral):
    """One-sided spectrum S of a wind's speed over the frequency n in Hz, m²/s; lateral: of a component across the wind.

    S = 4 s² L/U / (1 + 70.8 f²)^(5/6), or 4 s² L/U (1 + 755.2 f²) / (1 + 283.2 f²)^(11/6),  f = n L / U, L of that component.
    """
    f2 = (n * length / speed) ** 2
    shape = (1.0 + 755.2 * f2) / (1.0 + 283.2 * f2) ** (11.0 / 6.0) if lateral else (1.0 + 70.8 * f2) ** (-5.0 / 6.0)
    return 4.0 * deviation**2 * length / speed * shape


@kernel
def put_over_wires(contact_wire, messenger, mesh, plan, grid, out):
    """A value per length of contact wires and messengers times the length around each node, into out (N,); 0 at fixed ends."""
    W = mesh.bending_gradient.size
    out[:] = 0.0
    for k in range(plan.wires.shape[0]):
        if plan.wires[k, CLAMPED_TO] < 0:
            value = contact_wire if plan.wires[k, CONTACT] >= 0 else messenger
            for i in range(grid.node[plan.wires[k, FROM]] + 1, grid.node[plan.wires[k, TO]]):
                out[W * i + plan.wires[k, LANE]] = around(i, mesh.length) * value


@kernel
def blow(g, unilateral, mesh, plan, grid, balance, space, refused):
    """Put the equilibrium in the mean wind into the mesh, as the one that displacements count from; g: `Gusts`; a status.

    It is refused where a dropper would be slack there. Lift reduces the sag within an element by micrometres; this is neglected.
    """
    n, W = mesh.position.size, mesh.bending_gradient.size
    lift, q = space.nodal[0], space.nodal[1]
    put_over_wires(g.contact_wire_diameter * g.lift_coefficient, 0.0, mesh, plan, grid, lift)
    for j in range(lift.size):
        lift[j] = 0.5 * g.density * g.speed**2 * lift[j]
    if math.isnan(find_balance(lift, unilateral, q, mesh, balance)):
        return UNBALANCED
    slack = 0
    for k in range(mesh.preload.size):
        slack += 1 if balance.taut[PRESENT, k] == 0.0 else 0
    if slack > 0:
        refused[0] = slack
        return SLACK_IN_WIND
    for j in range(mesh.height.size):
        mesh.height[j] += q[W * (j % n) + 2 * (j // n)]
    for k in range(mesh.preload.size):
        mesh.preload[k] += mesh.dropper_stiffness[k] * (q[mesh.upper[k]] - q[mesh.lower[k]])
    return DONE


@kernel
def raise_wind(g, mesh, plan, grid, gusts):
    """Waves of the wind and their push on the mesh, into `gusts`; g: `Gusts`; a status."""
    if g.lowest >= g.highest:
        return NO_BAND
    U, n, across = g.speed, gusts.omega.size, g.lift_coefficient != 0.0
    put_over_wires(
        g.contact_wire_diameter * (g.lift_slope + g.drag_coefficient),
        g.messenger_diameter * g.drag_coefficient,
        mesh,
        plan,
        grid,
        gusts.push[0],
    )
    put_over_wires(g.contact_wire_diameter * g.lift_coefficient, 0.0, mesh, plan, grid, gusts.push[1])
    for j in range(gusts.push.shape[1]):
        gusts.push[0, j] *= 0.5 * g.density * U
        gusts.push[1, j] *= g.density * U
    interval, distance = 1.0 / (PER_WAVE * g.highest), g.shortest / PER_WAVE
    gusts.grid[INTERVAL], gusts.grid[DISTANCE], gusts.grid[FIELDS] = interval, distance, 2.0 if across else 1.0
    first, step = math.log10(g.lowest), (math.log10(g.highest) - math.log10(g.lowest)) / n
    edge = g.lowest
    for i in range(n):  # a random frequency in each of n bands of equal ratio
        end = 10.0 ** (step * (i + 1) + first) if i < n - 1 else g.highest
        number, middle = edge * (end / edge) ** gusts.random[0, i], math.sqrt(end * edge)
        gusts.omega[i] = TURN * number
        spread = g.decay * number / U
        angle = math.atan(TURN / g.shortest / spread)
        for r in range(2):
            if r == 0:
                spectrum = von_karman(middle, g.vertical_intensity * U, g.vertical_length, U, True)
            else:
                spectrum = von_karman(middle, g.intensity * U, g.length, U, False)
            wave = spread * math.tan(angle * gusts.random[1 + r, i])
            # straight lines between samples and stations carry the share sinc² of a sine, in time and along the line
            carried = sinc(number * interval) ** 2 * sinc(wave * distance / TURN) ** 2
            gusts.amplitude[r, i] = math.sqrt(2.0 * spectrum * (end - edge) * angle * 2.0 / math.pi) / carried
            gusts.wave[r, i], gusts.phase[r, i] = wave, TURN * gusts.random[3 + r, i]
            gusts.turn[r, 0, i], gusts.turn[r, 1, i] = math.cos(wave * distance), math.sin(wave * distance)
        edge = end
    return DONE


@kernel
def sinc(x):
    """sin(pi x) / (pi x)."""
    return math.sin(math.pi * x) / (math.pi * x) if x != 0.0 else 1.0
