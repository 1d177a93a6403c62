"""Drawings of the wrist: linkage, rows, ligaments and tendons."""

from __future__ import annotations

from ...harness.machine import Machine


def _four_bar() -> Machine:
    text = (
        "Four bars: the crank a turns at the angle phi from the ground d, the coupler b at theta, the rocker c at psi. The "
        "input torque acts on the crank, the load torque on the rocker."
    )
    m = Machine("Four-bar linkage", text, 340, 240)
    m.ground((120, 196), (60, 196)).ground((290, 196), (230, 196)).line((90, 190), (260, 190), width=1, dash="6 4")
    m.beam((90, 190), (120, 120)).beam((120, 120), (236, 62)).beam((236, 62), (260, 190))
    for x, y in ((90, 190), (120, 120), (236, 62), (260, 190)):
        m.node(x, y)
    m.label(88, 150, "a").label(172, 78, "b").label(266, 120, "c").label(175, 206, "d").turn(90, 190, 34, 0, 66, "φ", (134, 168))
    m.line((120, 120), (180, 120), width=1, dash="4 3").turn(120, 120, 42, 0, 27, "θ", (178, 108)).line(
        (260, 190), (320, 190), width=1, dash="4 3"
    )
    m.turn(260, 190, 26, 0, 100, "ψ", (298, 178)).turn(90, 190, 26, 200, 120, "T_{in}", (46, 172), load=True)
    return m.turn(260, 190, 44, 60, 20, "T_{load}", (320, 142), load=True)


def _rows(m: Machine) -> Machine:
    m.curve("M20 86H110M20 134H110").curve("M110 80Q122 110 110 140").word(52, 110, "forearm")
    m.curve("M120 76Q150 60 168 78Q176 110 168 142Q150 160 120 144Q132 110 120 76Z").curve(
        "M178 76Q206 62 222 82Q228 110 222 138Q206 158 178 144Q186 110 178 76Z"
    )
    m.node(128, 110).node(186, 110).mass(278, 110, 96, 66)
    return m.label(288, 110, "m, I")


def _wrist() -> Machine:
    text = (
        "Forearm, proximal row, distal row with the hand, from left to right. Each row turns on its own axis, by q1 and q2; the "
        "hand of mass m and inertia I follows. Passive stiffness K and damping D hold it; tendons and ligaments give torques."
    )
    m = _rows(Machine("Wrist of two rows", text, 350, 230))
    m.line((112, 30), (144, 190), width=1, dash="9 4 2 4").line((200, 30), (172, 190), width=1, dash="9 4 2 4")
    m.turn(128, 110, 60, 120, 60, "q_1", (98, 36), load=False).turn(186, 110, 60, 120, 60, "q_2", (222, 40), load=False)
    m.word(142, 206, "proximal", "end").word(172, 206, "distal", "start").arrow(
        (330, 180), (330, 120), "flexion", (310, 196), load=False
    )
    return m.label(150, 176, "K, D")


def _ligaments() -> Machine:
    text = (
        "Ligaments as springs that lead from the forearm over the rows to the hand; their tensions give torques on the angles "
        "q1 and q2 of the rows."
    )
    m = _rows(Machine("Ligaments of the wrist", text, 350, 220))
    m.spring((100, 82), (160, 72), "k", -1, width=5).spring((100, 138), (214, 142), "k", 1, width=5).spring(
        (158, 92), (236, 82), "", width=5
    )
    return m.turn(128, 110, 76, 110, 70, "q_1", (128, 20)).turn(186, 110, 76, 100, 60, "q_2", (222, 24))


def _tendons() -> Machine:
    text = (
        "Muscles in the forearm with the activation a pull at the hand with the force F by tendons that run over the wrist at "
        "moment arms for flexion and deviation."
    )
    m = _rows(Machine("Muscles and tendons over the wrist", text, 350, 230))
    for y, edge in ((52, 78), (168, 142)):
        m._add(f'<ellipse class="body" cx="62" cy="{y}" rx="40" ry="11" fill="currentColor" fill-opacity="0.12"/>')
        m.curve(f"M102 {y}L190 {y}L258 {edge}", 2.4).arrow((236, y + (edge - y) * 0.68), (206, y + (edge - y) * 0.24), "")
    m.label(62, 52, "e, a").label(212, 36, "F").measure((186, 108), (186, 54), "arm", -1)
    return m.turn(186, 110, 100, 10, 40, "torque", (308, 36), load=True)


MACHINES = {"LigamentBundle": _ligaments, "ForearmTendons": _tendons, "Wrist": _wrist, "FourBar": _four_bar}
