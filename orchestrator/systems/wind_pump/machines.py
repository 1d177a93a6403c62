"""Drawings of the wind pump: rotor, transmissions, pumps and pipe."""

from __future__ import annotations

import math

from ...harness.machine import Machine


def _rotor(m: Machine, x: float, y: float, radius: float, blades: int = 3) -> Machine:
    for k in range(blades):
        angle = 2 * math.pi * k / blades + math.pi / 2
        ahead, across = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))
        root, belly, tip = 0.08 * radius, 0.35 * radius, radius
        m.curve(
            f"M{x + root * ahead[0]:.1f} {y + root * ahead[1]:.1f}L{x + belly * ahead[0] + 0.14 * radius * across[0]:.1f} "
            f"{y + belly * ahead[1] + 0.14 * radius * across[1]:.1f}L{x + tip * ahead[0]:.1f} {y + tip * ahead[1]:.1f}Z"
        )
    return m.node(x, y)


def _turbine() -> Machine:
    text = (
        "A rotor of radius R and inertia J in a wind v turns at w. The wind drives it with the torque T, the transmission "
        "brakes it with T1."
    )
    m = Machine("Wind turbine", text, 340, 250)
    _rotor(m, 200, 95, 82).line((196, 100), (190, 235)).line((204, 100), (210, 235)).ground((250, 236), (150, 236))
    for y in (60, 95, 130):
        m.arrow((20, y), (80, y), load=False)
    m.label(50, 42, "v").measure((214, 92), (214, 14), "R", 1).turn(200, 95, 62, 60, 10, "w, T", (282, 66), load=True)
    return m.turn(200, 95, 52, 255, 300, "T_1", (232, 154), load=True).label(180, 74, "J")


def _wind() -> Machine:
    text = "Wind speed v over the time t: a mean that rises in a ramp, turbulence on it, and a gust."
    m = Machine("Wind over time", text, 340, 180)
    m.line((40, 150), (325, 150), width=1).line((40, 150), (40, 20), width=1).label(22, 26, "v").label(330, 164, "t")
    m.line((40, 120), (90, 120), (140, 85), (320, 85), width=1, dash="5 4")
    m.curve(
        "M40 121L50 117L60 124L72 118L84 122L96 112L108 110L118 99L130 95L142 84L154 88L166 80L178 90"
        "L190 84C205 84 208 34 225 34S245 86 260 86L272 80L284 91L296 83L308 88L320 84",
        2,
    )
    return m.word(110, 140, "ramp").word(225, 20, "gust").word(284, 108, "turbulence")


def _fixed() -> Machine:
    text = (
        "A gear of the ratio i between the turbine, which turns at w_t with the torque T1, and a shaft of stiffness k and "
        "damping c that is twisted by theta; behind it the driven shaft of inertia J at w against T load."
    )
    m = Machine("Gear of fixed ratio with a compliant shaft", text, 350, 190)
    m.line((8, 75), (60, 75), width=4).mass(68, 75, 14, 100).mass(68, 152, 14, 50).label(68, 14, "i").line(
        (75, 152), (110, 152), width=4
    )
    m.line((110, 130), (110, 174)).spring((110, 138), (200, 138), "k, θ", -1, width=6).damper(
        (200, 166), (110, 166), "c", -1, width=6
    )
    m.line((200, 130), (200, 174)).line((200, 152), (232, 152), width=4).mass(252, 152, 40, 62, "J").line(
        (272, 152), (312, 152), width=4
    )
    m.turn(26, 75, 22, -60, 60, "w_t, T_1", (32, 38)).turn(292, 152, 22, -60, 60, "w", (326, 132))
    return m.label(326, 176, "T_{load}").line((272, 120), (272, 120.5))


def _planetary() -> Machine:
    text = (
        "A planetary gear seen along its axis: sun in the middle, planets on a carrier, ring outside, with the speeds w_s, w_c "
        "and w_r. Turbine and pump sit on two of these shafts, a brake with the torque T brake on the third."
    )
    m = Machine("Planetary gear with a braked third shaft", text, 350, 240)
    m.ring(130, 120, 104, 2).ring(130, 120, 92, 1.2, "4 3").wheel(130, 120, 34, hub=False)
    ends = []
    for k in range(3):
        angle = 2 * math.pi * k / 3 + math.pi / 2
        x, y = 130 + 63 * math.cos(angle), 120 - 63 * math.sin(angle)
        ends.append((x, y))
        m.wheel(x, y, 28)
    m.line(*ends, width=1.2, dash="7 3", closed=True).label(130, 122, "w_s").label(200, 106, "w_c").label(228, 36, "w_r")
    m.turn(130, 120, 112, 30, 55).block(300, 96, 80, 28, "turbine").block(300, 136, 80, 28, "pump").block(
        300, 196, 80, 44, "brake", "T_{brake}, J_3"
    )
    return m.word(300, 66, "on its shafts")


def _converter() -> Machine:
    text = (
        "A crank of radius r and inertia J1, driven through a compliant shaft (k, c, twist theta), moves the pin of a lever "
        "with the arms l2 and b l2. At the upper end of the lever is the mass m, at the lower one the slider m_y with the way "
        "y, whose force F turns the driven shaft J2 through two opposed one-way clutches of radius rho, against T load."
    )
    m = Machine("Inertial converter: crank, lever, one-way clutches", text, 350, 270)
    m.beam((150, 58), (150, 208)).wheel(150, 40, 17, "", hub=False).label(150, 40, "m").node(150, 130).mass(
        150, 220, 30, 22
    ).label(118, 222, "m_y")
    m.wheel(75, 130, 36, hub=False).node(75, 130).line((75, 130), (104, 110), width=3).node(104, 110).line(
        (104, 110), (150, 130), width=3
    )
    m.label(86, 112, "r").label(60, 148, "J_1").turn(75, 130, 46, 150, 90, "φ", (42, 84)).measure(
        (178, 130), (178, 44), "b l_2"
    ).measure((178, 216), (178, 134), "l_2")
    m.line((165, 220), (232, 220), width=2).wheel(262, 196, 24, hub=True).wheel(262, 244, 24, hub=True).arrow(
        (180, 240), (216, 240), "F, y", (196, 256)
    )
    m.label(262, 160, "ρ").mass(318, 220, 26, 80, "J_2").line((286, 196), (305, 196)).line((286, 244), (305, 244)).label(
        318, 166, "T_{load}"
    )
    m.spring((6, 130), (39, 130), "", turns=3, width=5)
    return m.label(18, 112, "k, c")


def _piston_pump() -> Machine:
    text = (
        "A crank of the radius r at the angle phi moves a piston of the area A up and down; the torque T turns it. Water flows "
        "with q through the valves and is lifted by the head H."
    )
    m = Machine("Piston pump", text, 340, 280)
    m.wheel(120, 55, 40, hub=False).node(120, 55).line((120, 55), (150, 32), width=3).node(150, 32, "r", (-34, -2)).line(
        (150, 32), (120, 152), width=2.6
    )
    m.turn(120, 55, 50, 60, 10, "φ, T", (192, 34), load=True).line((85, 120), (85, 240)).line((155, 120), (155, 178)).line(
        (155, 202), (155, 240)
    )
    m.mass(120, 158, 68, 14, "").label(62, 158, "A").line((85, 240), (108, 240)).line((132, 240), (155, 240)).line(
        (106, 236), (134, 228), width=2.4
    )
    m.line((155, 178), (240, 178), (240, 40)).line((155, 202), (264, 202), (264, 40)).line((168, 200), (176, 180), width=2.4)
    m.arrow((120, 272), (120, 246), "q", (138, 250)).arrow((252, 130), (252, 90), load=False).measure(
        (296, 240), (296, 40), "H", 1
    )
    return m.line((80, 262), (330, 262), width=1, dash="6 4")


def _centrifugal_pump() -> Machine:
    text = (
        "An impeller in a spiral casing turns at w with the torque T. Water comes in at its middle and leaves with the flow Q "
        "and the head H through a check valve."
    )
    m = Machine("Centrifugal pump", text, 340, 220)
    m.curve("M120 28A78 78 0 1 0 214 120V28H180V70A70 70 0 0 0 120 28", 2)
    for k in range(6):
        angle = 2 * math.pi * k / 6
        blade = ((15, angle), (38, angle), (48, angle + 0.6))
        a, b, c = (f"{130 + r * math.cos(v):.1f} {112 + r * math.sin(v):.1f}" for r, v in blade)
        m.curve(f"M{a}Q{b} {c}")
    m.ring(130, 112, 14).turn(130, 112, 58, 200, 260, "w, T", (74, 196)).line((182, 52), (206, 40), width=2.4)
    return m.arrow((197, 26), (197, 4), "Q, H", (232, 16)).word(236, 46, "check valve", "start")


def _pipe() -> Machine:
    text = (
        "A pipe rises by the static head from the pump to a tank of a given area; the flow q goes up and loses head by friction "
        "K, outflow leaves the tank."
    )
    m = Machine("Delivery pipe and tank", text, 340, 240)
    m.line((40, 205), (120, 205), (120, 84), (170, 84)).line((40, 222), (137, 222), (137, 101), (170, 101)).line(
        (190, 60), (190, 150), (310, 150), (310, 60)
    )
    m.line((190, 100), (310, 100), width=1, dash="6 4").arrow((60, 213), (104, 213), load=False).label(80, 192, "q, H")
    m.measure((98, 190), (98, 93), "H_{static}", -1).line((170, 92), (190, 92)).arrow((310, 140), (334, 140), load=False)
    return m.measure((250, 148), (250, 102), "level", -1)


MACHINES = {
    "InertialConverter": _converter,
    "FixedTransmission": _fixed,
    "PlanetaryTransmission": _planetary,
    "WindTurbine": _turbine,
    "AveragedConverter": _converter,
    "Wind": _wind,
    "PistonPump": _piston_pump,
    "CentrifugalPump": _centrifugal_pump,
    "WaterPipe": _pipe,
}
