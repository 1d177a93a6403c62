"""Drawings of the underwater vehicle and of what acts on it."""

from __future__ import annotations

from ...harness.machine import Machine
from ..two_axis_joint.machines import controller


def _vehicle(m: Machine, x: float, y: float) -> Machine:
    m.mass(x, y - 26, 130, 24).mass(x, y + 20, 130, 34).line((x - 55, y - 14), (x - 55, y + 3)).line(
        (x + 55, y - 14), (x + 55, y + 3)
    )
    for side in (-1, 1):
        m.mass(x + side * 30, y - 5, 12, 16).line((x + side * 30 - 14, y - 5), (x + side * 30 + 14, y - 5), width=2.4)
    return m


def _hull() -> Machine:
    text = (
        "The vehicle from the side, with thrusters. Body axes: x ahead, y to starboard, z down; velocities v and w. Weight W "
        "acts in the centre of mass, buoyancy B above it, thrusts F along the thrusters, drag D against the motion through the "
        "water, which moves at v_c."
    )
    m = _vehicle(Machine("Hull of an underwater vehicle", text, 350, 250), 165, 120)
    m.node(165, 104, "B", (18, -44)).arrow((165, 104), (165, 48)).node(165, 140, "W", (18, 60)).arrow((165, 140), (165, 212))
    m.arrow((195, 115), (195, 66), "F", (210, 64)).arrow((100, 140), (44, 140), "D", (44, 122))
    m.arrow((240, 128), (290, 128), "x, v", (308, 128), load=False).arrow((240, 128), (240, 178), "z", (240, 192), load=False)
    m.turn(240, 128, 34, 335, 285, "w", (282, 164))
    for y in (40, 56, 72):
        m.arrow((330, y), (285, y), load=False)
    m.label(340, 24, "v_c", "end")
    return m.label(66, 222, "M_{RB} + M_A")


def _added_mass() -> Machine:
    text = "The hull accelerates by a = nu'; water of the mass M_A moves with it and answers with the force f = -M_A nu'."
    m = Machine("Added mass as a force", text, 340, 200)
    m._add('<ellipse cx="170" cy="105" rx="125" ry="72" stroke-dasharray="5 4"/>')
    return (
        _vehicle(m, 170, 105)
        .label(170, 50, "M_A")
        .arrow((240, 105), (310, 105), "ν′", (318, 90), load=False)
        .arrow((104, 105), (40, 105), "f", (32, 90))
    )


def _thruster() -> Machine:
    text = (
        "A motor with the voltage V u, resistance R and inductance L turns a propeller of diameter D at w against the water's "
        "torque Q. The thrust acts along its axis; water comes in at u_a."
    )
    m = Machine("Thruster", text, 340, 190)
    m.mass(130, 95, 100, 44, "R, L, k, J").line((180, 95), (222, 95), width=4).arrow(
        (20, 95), (78, 95), "V u", (46, 78), load=False
    )
    m.curve("M222 95C212 60 232 40 222 32C206 44 210 76 222 95C232 130 212 150 222 158C238 146 234 114 222 95", 1.6)
    m.measure((252, 32), (252, 158), "D", -1).turn(192, 95, 18, -60, 60, "w, Q", (196, 62))
    m.arrow((130, 150), (60, 150), "thrust", (92, 168))
    for y in (65, 125):
        m.arrow((335, y), (285, y), load=False)
    return m.label(310, 48, "u_a")


def _current() -> Machine:
    text = (
        "A uniform current of the speed v_c under the surface; waves of the length lambda turn the water in circles that shrink "
        "with the depth z."
    )
    m = Machine("Current and waves", text, 340, 200)
    m.curve("M10 50C35 25 60 25 85 50S135 75 160 50S210 25 235 50S285 75 330 50", 2).measure((47, 22), (197, 22), "λ", -1)
    for k, radius in enumerate((18, 13, 9)):
        m.turn(250, 88 + 40 * k, radius, 200, 440)
        m.arrow((30, 88 + 40 * k), (120, 88 + 40 * k), load=False)
    return m.label(142, 88, "v_c").arrow((310, 70), (310, 180), "z", (322, 176), load=False)


def _rov_controller() -> Machine:
    return controller(
        "p",
        "e",
        "PID",
        "u",
        "thrusters",
        "p, q, v, w",
        "Sampled PID controller of position and attitude; the wrench is shared among the thrusters.",
    )


def _tether() -> Machine:
    text = (
        "A cable of equal segments of length l between a fixed upper end and the vehicle. Masses m at the nodes; tension T "
        "along each segment, drag D of the water across it, weight in water w l at each node."
    )
    m = Machine("Tether of lumped masses", text, 340, 240)
    points = ((50, 30), (78, 88), (120, 138), (176, 176), (250, 196))
    m.ground((20, 22), (100, 22)).line(*points, width=2)
    for x, y in points[1:-1]:
        m.wheel(x, y, 7, hub=False)
    m.mass(288, 196, 70, 36, "hull").label(100, 82, "m").arrow((120, 146), (120, 196), "w l", (120, 210))
    m.arrow((120, 138), (96, 109), "T_i", (124, 112)).arrow((120, 138), (156, 163), "T_{i+1}", (184, 148))
    for y in (60, 80):
        m.arrow((300, y), (240, y), load=False)
    return m.label(270, 44, "v_c").arrow((82, 170), (52, 182), "D", (40, 190)).measure((36, 40), (62, 94), "l", 1)


MACHINES = {
    "AddedMassForce": _added_mass,
    "Tether": _tether,
    "RovHull": _hull,
    "Thruster": _thruster,
    "WaterCurrent": _current,
    "RovController": _rov_controller,
}
