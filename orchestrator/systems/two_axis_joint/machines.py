"""Drawings of joints with two axes, of links and of their drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...harness.machine import Machine, motor


def _gimbal() -> Machine:
    text = (
        "A frame turns about the vertical outer axis by alpha under the torque T outer. In it a body turns about the inner axis "
        "by beta under T inner; its centre of mass hangs the distance l below the crossing of the axes, with the weight m g."
    )
    m = Machine("Body on two crossed axes", text, 340, 270)
    m.ground((130, 22), (210, 22)).line((170, 22), (170, 48), width=4).line((80, 48), (260, 48), (260, 130)).line(
        (80, 130), (80, 48)
    )
    m.line((60, 120), (280, 120), width=1, dash="9 4 2 4").line((170, 8), (170, 250), width=1, dash="9 4 2 4").node(80, 120).node(
        260, 120
    )
    m.line((80, 120), (125, 120), width=4).line((215, 120), (260, 120), width=4).mass(170, 150, 90, 110)
    m.node(170, 180).arrow((170, 184), (170, 238), "m g", (192, 226)).measure((190, 120), (190, 180), "l", -1)
    m.turn(170, 36, 36, 190, 300, "α, T_{outer}", (255, 26), load=False).turn(285, 120, 26, -60, 60, "β", (326, 112), load=False)
    return m.label(300, 160, "T_{inner}").label(98, 70, "J_o").label(146, 150, "I")


def _gimbal_controller() -> Machine:
    return controller(
        "set", "e", "PID", "V", "gimbal", "angle, rate", "Sampled PID controller of two angles, with limited voltages."
    )


def controller(wish: str, error: str, law: str, output: str, plant: str, back: str, text: str) -> Machine:
    """A loop: comparison, law, limit, hold, plant."""
    m = Machine("Control loop", text, 350, 150)
    m.arrow((4, 60), (34, 60), load=False).label(16, 44, wish).ring(46, 60, 11).label(46, 60, "−").arrow(
        (58, 60), (84, 60), load=False
    )
    m.label(70, 44, error).block(116, 60, 62, 44, law, "").word(116, 70, "sampled")
    m.arrow((148, 60), (172, 60), load=False).block(192, 60, 38, 44).line((178, 74), (186, 74), (198, 46), (206, 46), width=2)
    m.arrow((212, 60), (252, 60), load=False).label(231, 44, output).block(296, 60, 84, 44, plant)
    m.line((338, 60), (346, 60), (346, 122), (46, 122)).arrow((46, 122), (46, 72), load=False).label(200, 110, back)
    return m.line((192, 82), (192, 98), (116, 98), width=1, dash="4 3").arrow((116, 98), (116, 83), load=False)


def _chain() -> Machine:
    text = (
        "Two rigid links in a vertical plane. The first hangs from a fixed joint at the angle th1 from the vertical, the second "
        "from its end at th2. Their lengths are l, their centres of mass the distances a1 and a2 from the joints; torques T1 "
        "and T2, damping d1 and d2."
    )
    m = Machine("Two-link chain", text, 340, 290)
    m.ground((90, 22), (170, 22)).beam((130, 26), (205, 126)).beam((205, 126), (165, 246)).node(130, 26).node(205, 126)
    m.line((130, 26), (130, 120), width=1, dash="4 3").line((205, 126), (205, 230), width=1, dash="4 3")
    m.turn(130, 26, 70, 270, 307, "θ_1", (152, 112)).turn(205, 126, 80, 270, 250, "θ_2", (190, 220))
    m.node(172, 82).label(92, 100, "m_1, I_1").line((118, 97), (168, 84), width=0.8).node(
        184, 190, "m_2, I_2", (-38, -6)
    ).measure((146, 14), (188, 70), "a_1", -1)
    m.measure((224, 134), (204, 194), "a_2", -1)
    m.turn(130, 26, 24, 330, 230, "T_1, d_1", (82, 48), load=True).turn(205, 126, 24, 170, 245, "T_2, d_2", (148, 146), load=True)
    return m.arrow((300, 210), (300, 256), "g", load=False).measure((164, 8), (238, 106), "l_1", -1)


def _link() -> Machine:
    text = (
        "A rigid link of length L in a plane at the angle th from the vertical; its centre of mass, with mass m and moment of "
        "inertia I, is the distance a from the base. Forces and torques act at base and tip, the weight m g at the centre of "
        "mass."
    )
    m = Machine("Planar link", text, 340, 260)
    m.beam((110, 50), (215, 200)).node(110, 50, "base", (-28, 14)).node(215, 200, "tip", (34, 12)).node(
        158, 119, "m, I", (34, -2)
    )
    m.line((110, 50), (110, 150), width=1, dash="4 3").turn(110, 50, 84, 270, 305, "θ", (131, 116)).measure(
        (136, 40), (182, 106), "a", -1
    )
    m.measure((153, 20), (258, 170), "L", -1).arrow((158, 123), (158, 168), "m g", (138, 162))
    m.arrow((110, 50), (60, 30), "F_{base}", (44, 16)).arrow((215, 200), (270, 184), "F_{tip}", (288, 176))
    m.turn(110, 50, 22, 160, 10, "T_{base}", (122, 14), load=True).turn(215, 200, 22, 190, 320, "T_{tip}", (206, 240), load=True)
    return m.arrow((290, 90), (325, 90), "x", (332, 78), load=False).arrow((290, 90), (290, 55), "y", (278, 52), load=False)


def _joint() -> Machine:
    text = (
        "A spring of stiffness k and a damper c side by side between a first and a second end, at the places r first and r "
        "second. The force F acts on the second end and with the other sign on the first."
    )
    m = Machine("Spring and damper between two ends", text, 340, 170)
    m.node(60, 80).node(280, 80).line((60, 80), (100, 80)).line((240, 80), (280, 80)).line((100, 50), (100, 110)).line(
        (240, 50), (240, 110)
    )
    m.spring((100, 50), (240, 50), "k", -1).damper((240, 110), (100, 110), "c", -1)
    m.arrow((280, 80), (324, 80), "F_{second}", (300, 62)).arrow((60, 80), (16, 80), "F_{first}", (36, 62))
    return m.label(60, 106, "r_{first}").label(280, 106, "r_{second}")


def _torque_motor() -> Machine:
    text = (
        "A DC motor: voltage V, resistance R, inductance L and current i; torque k i for the current; a gear of the ratio N "
        "drives the load's axis, which turns at w with the torque T."
    )
    m = motor(Machine("Torque motor", text, 350, 180), 235, 90)
    m.line((235, 90), (258, 90), width=4).block(274, 90, 30, 56, "N").line((290, 90), (318, 90), width=4).turn(
        310, 90, 20, -60, 60, "w", (338, 90)
    )
    return m.label(322, 58, "T")


def scene(units: Mapping[str, Mapping[str, Any]]) -> Machine:
    """The joint alone where a free link is only its mass; else the first component that a drawing is for."""
    used = [str(u.get("component")) for u in units.values()]
    if used == ["PlanarLink", "CompliantJoint"] and not any(u.get("effects") for u in units.values()):
        return _joint()
    return next(drawing for name, drawing in MACHINES.items() if name in used)()


MACHINES = {
    "GimbalBody": _gimbal,
    "TwoLinkChain": _chain,
    "PlanarLink": _link,
    "CompliantJoint": _joint,
    "GimbalController": _gimbal_controller,
    "TorqueMotor": _torque_motor,
}
