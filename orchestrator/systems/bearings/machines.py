"""Drawings of ball bearings and of the way of their heat."""

from __future__ import annotations

import math

from ...harness.machine import Machine


def _rings(m: Machine, x: float, y: float, inner: float, outer: float, balls: int = 8, shift: float = 0.0) -> Machine:
    """A ball bearing seen along its shaft; the inner ring is moved by `shift` downwards."""
    middle, ball = (inner + outer) / 2, (outer - inner) / 2 - 1
    m.ring(x, y, outer + 12, 2).ring(x, y, outer).ring(x, y + shift, inner).ring(x, y + shift, inner - 16, 2)
    for k in range(balls):
        angle = 2 * math.pi * (k + 0.5) / balls + math.pi / 2
        m.wheel(x + middle * math.cos(angle), y + shift / 2 + middle * math.sin(angle), ball, hub=False)
    return m


def _two_dof() -> Machine:
    text = (
        "A ball bearing seen along the shaft. The mass m in its middle moves by x along the load W and by y across it. Ball j "
        "stands at the angle theta_j and carries Q_j; the shaft turns at the speed w; the damper c joins shaft and housing."
    )
    m = Machine("Ball bearing with two degrees of freedom", text, 340, 270)
    _rings(m, 160, 125, 56, 92)
    m.wheel(160, 125, 26, hub=False).label(160, 113, "m").line((160, 125), (160, 199), width=1, dash="4 3").line(
        (160, 125), (132, 193), width=1, dash="4 3"
    )
    m.turn(160, 125, 110, 270, 249, "θ_j", (139, 250)).arrow((132, 193), (114, 238), "Q_j").arrow(
        (160, 148), (160, 252), "W", (178, 246)
    )
    m.arrow((284, 92), (284, 130), "x", (298, 122), load=False).arrow((284, 92), (322, 92), "y", (316, 78), load=False)
    m.turn(160, 125, 33, 150, 60, "w", (160, 77))
    m.ground((8, 160), (8, 90)).damper((8, 125), (56, 125), "c", -1).line((56, 125), (134, 125))
    return m


def _deep_groove() -> Machine:
    text = (
        "Section of a deep groove ball bearing. The outer ring is fixed, the inner ring follows the shaft along z, across it "
        "and in two tilts. The ball is pressed by delta with the force Q along a contact line at the angle phi; force F and "
        "moment M act on the shaft."
    )
    m = Machine("Deep groove ball bearing, section", text, 340, 262)
    m.ground((100, 24), (220, 24)).curve("M100 26V76H126A36 36 0 0 1 194 76H220V26", 2).wheel(160, 92, 34, hub=False)
    m.curve("M100 164V110H126A36 36 0 0 0 194 110H220V164Z", 2).line((60, 190), (290, 190), width=1, dash="9 4 2 4").label(
        304, 190, "z"
    )
    m.line((136, 118), (184, 66), width=1.4, dash="4 3").line((160, 58), (160, 126), width=1, dash="2 3").turn(
        160, 92, 26, 90, 48, "φ", (204, 50)
    )
    m.label(143, 80, "Q, δ").arrow((160, 150), (160, 222), "F", (176, 216)).turn(
        160, 190, 52, 200, 340, "M", (222, 218), load=True
    )
    return m.arrow((52, 92), (52, 60), "y", (52, 48), load=False).turn(250, 190, 22, -60, 60, "Ω", (286, 168))


def _conductance() -> Machine:
    text = (
        "Heat flows from ring to ring: in each ball two contacts in series, of the conductances Gi at the inner and Go at the "
        "outer ring; the balls, one beside the other, are in parallel, and a side path joins the rings directly. Axial force Fa "
        "and radial force Fr load the balls."
    )
    m = Machine("Heat through an angular contact ball bearing", text, 340, 230)
    m.block(170, 26, 300, 30, "outer ring").block(170, 204, 300, 30, "inner ring")
    for x in (70, 150, 230):
        m.wheel(x, 115, 26, hub=False).mass(x, 65, 12, 30).mass(x, 166, 12, 30)
        m.line((x, 41), (x, 50)).line((x, 80), (x, 89)).line((x, 141), (x, 151)).line((x, 181), (x, 189))
    m.label(92, 65, "G_o").label(92, 166, "G_i").label(190, 115, "…").line((300, 41), (300, 95)).mass(300, 115, 12, 40).line(
        (300, 135), (300, 189)
    )
    return m.word(292, 70, "side path", "end")


def _temperatures() -> Machine:
    text = (
        "Three heat capacities in a row: shaft with inner ring (Ci, Ti), balls (Cb, Tb), outer ring with housing (Co, To). "
        "Twice the conductance G lies on either side of the balls; Gs and Gh lead to the surroundings at Ta. The friction P "
        "heats all three."
    )
    m = Machine("Heat capacities of shaft, balls and housing", text, 350, 210)
    for x, name in ((60, "i"), (175, "b"), (290, "o")):
        m.block(x, 90, 70, 50, f"C_{name}", f"T_{name}").arrow((x, 28), (x, 62))
    m.label(60, 14, "s_i P").label(175, 14, "(1−s_i−s_o) P").label(290, 14, "s_o P")
    for x in (117, 232):
        m.line((x - 22, 90), (x - 14, 90)).mass(x, 90, 28, 12).line((x + 14, 90), (x + 23, 90)).label(x, 70, "2G")
    m.line((60, 115), (60, 128)).mass(60, 142, 12, 28).line((60, 156), (60, 180)).label(84, 142, "G_s")
    m.line((290, 115), (290, 128)).mass(290, 142, 12, 28).line((290, 156), (290, 180)).label(266, 142, "G_h")
    return m.line((30, 180), (320, 180), width=2.4).label(175, 194, "T_a")


MACHINES = {
    "BallBearing": _two_dof,
    "DimensionlessBallBearing": _two_dof,
    "DeepGrooveBearing": _deep_groove,
    "AngularContactConductance": _conductance,
    "BearingTemperatures": _temperatures,
}
