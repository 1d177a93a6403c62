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

from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.errors import BadInput
from ..core.variables import integer, output, parameter
from .gust_loads import Buffeting
from .line.layout import Layout
from .mesh import Mesh, node_at
from .sines import TURN, random_bands
from .statics import Statics

PER_WAVE = 8.0  # samples in the shortest period, stations in the shortest wave
ACROSS = {"gusts.intensity", "gusts.length"}  # parameters of the wind across the line


class Gusts(Effect):
    """Wind across the line that fluctuates: its lift on the wires, and the damping by the air stream.

    Spectra after von Karman, coherence after Davenport, forms and the decay's size (8 to 16) recalled. Intensities and lengths
    are inferred: those of Davenport's and Panofsky's spectra 6 m above ground of 0.03 m roughness. Diameters recalled; round
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
    components = integer(200, "number of waves", low=1, high=2000)
    seed = integer(1, "of the random frequencies, wave numbers and phases", low=0, high=2**31 - 1)

    load = output("N/m", "lift per length of the gusts on the contact wire at the contact point, without its own motion's part",
                  feedthrough=("contact_position",))


def von_karman(n, deviation: float, length: float, speed: float, lateral: bool):
    """One-sided spectrum S of a wind's speed over the frequency n (k,) in Hz, m²/s; lateral: of a component across the wind.

    S = 4 s² L/U / (1 + 70.8 f²)^(5/6), or 4 s² L/U (1 + 755.2 f²) / (1 + 283.2 f²)^(11/6),  f = n L / U, L of that component.
    """
    f2 = (n * length / speed) ** 2
    shape = (1.0 + 755.2 * f2) / (1.0 + 283.2 * f2) ** (11 / 6) if lateral else (1.0 + 70.8 * f2) ** (-5 / 6)
    return 4.0 * deviation**2 * length / speed * shape


def mean_lift(values: Any, mesh: Mesh, layout: Layout) -> np.ndarray:
    """Lift of the mean wind on the nodes, (N,) N; values: of `Gusts`."""
    lift = _over_wires(mesh, layout, values.contact_wire_diameter * values.lift_coefficient, 0.0)
    return 0.5 * values.density * values.speed**2 * lift


def in_mean_wind(values: Any, mesh: Mesh, layout: Layout, unilateral: bool) -> Mesh:
    """The mesh with the equilibrium in the mean wind as the one that displacements count from.

    `BadInput` where a dropper would be slack there. What lift takes off the sag within an element, micrometres, is neglected.
    """
    lift = mean_lift(values, mesh, layout)
    if not lift.any():
        return mesh
    q, taut, _ = Statics(mesh).under((), unilateral, lift)
    if not taut.all():
        raise BadInput("Catenary", f"gusts: a mean wind of {values.speed:g} m/s whose lift leaves "
                       f"{int(taut.size - taut.sum())} droppers slack at rest", "tension in every dropper",
                       "Reduce speed, lift_coefficient or contact_wire_diameter.")
    shape = q.reshape(mesh.position.size, -1)[:, list(layout.contact_lanes)].T.ravel()
    preload = mesh.preload + mesh.dropper_stiffness * (q[mesh.upper] - q[mesh.lower])
    return mesh._replace(height=mesh.height + shape, preload=preload)


def buffeting(values: Any, mesh: Mesh, layout: Layout, where: str) -> Buffeting:
    """Waves and their push on the mesh; values: of `Gusts`."""
    if values.lowest >= values.highest:
        raise BadInput(f"{where}: gusts", f"frequencies from {values.lowest:g} to {values.highest:g} Hz",
                       "a lowest one below the highest")
    g, U, n = values, values.speed, int(values.components)
    per_angle = g.lift_slope + g.drag_coefficient
    push = [0.5 * g.density * U * _over_wires(mesh, layout, g.contact_wire_diameter * per_angle,
                                              g.messenger_diameter * g.drag_coefficient)]
    if g.lift_coefficient != 0.0:
        push.append(g.density * U * _over_wires(mesh, layout, g.contact_wire_diameter * g.lift_coefficient, 0.0))
    random = np.random.default_rng(int(g.seed))
    number, middle, width = random_bands(g.lowest, g.highest, n, random)
    spectra = (von_karman(middle, g.vertical_intensity * U, g.vertical_length, U, True),
               von_karman(middle, g.intensity * U, g.length, U, False))
    spread, k_max = g.decay * number / U, TURN / g.shortest
    angle = np.arctan(k_max / spread)
    wave = spread * np.tan(angle * random.uniform(-1.0, 1.0, (2, n)))
    phase = TURN * random.random((2, n))
    interval, distance = 1.0 / (PER_WAVE * g.highest), g.shortest / PER_WAVE
    # straight lines between samples and stations carry the share sinc² of a sine, in time and along the line
    carried = np.sinc(number * interval) ** 2 * np.sinc(wave * distance / TURN) ** 2
    amplitude = np.sqrt(2.0 * np.array(spectra) * width * angle * 2.0 / np.pi) / carried
    r = len(push)
    turn = np.stack((np.cos(wave[:r] * distance), np.sin(wave[:r] * distance)), axis=1)
    return Buffeting(g.y, interval, distance, TURN * number, amplitude[:r].copy(), wave[:r].copy(), phase[:r].copy(), turn,
                     np.zeros((r, 2, n)), np.array(push))


def _over_wires(mesh: Mesh, layout: Layout, contact_wire: float, messenger: float) -> np.ndarray:
    """A value per length of contact wires and messengers times the length around each node, (N,); 0 at fixed ends."""
    W = mesh.bending_gradient.size
    around = 0.5 * (mesh.length + np.roll(mesh.length, 1))
    total = np.zeros((around.size, W))
    for wire in layout.wires:
        if wire.clamped_to is None:
            a, b = node_at(mesh.position, np.array([wire.start, wire.end]))
            total[a + 1 : b, wire.lane] = contact_wire if wire.lane in layout.contact_lanes else messenger
    return (around[:, None] * total).ravel()
