"""Drawings of robots that vibrate through pipes."""

from __future__ import annotations

from ...harness.machine import Machine


def _pipe(m: Machine, top: float = 40, bottom: float = 180) -> Machine:
    return m.ground((10, top), (340, top)).ground((340, bottom), (10, bottom))


def _robot() -> Machine:
    text = (
        "A body of mass m1 stands in the pipe on inclined elastic elements, which rub with R, weakly forwards and strongly "
        "backwards. In it an inner mass m2 on a spring k and a damper c is shaken by the force f; the ways along the pipe are "
        "x1 and x2."
    )
    m = _pipe(Machine("Pipe robot on inclined elastic elements", text, 350, 230))
    m.mass(170, 110, 200, 84).label(98, 142, "m_1").mass(212, 110, 56, 40, "m_2")
    m.spring((84, 98), (184, 98), "k", -1).damper((184, 122), (84, 122), "", width=6).label(134, 144, "c")
    for x in (100, 140, 200, 240):
        m.line((x, 68), (x - 24, 42), width=2.4).line((x, 152), (x - 24, 178), width=2.4)
    m.arrow((240, 110), (262, 110), load=True).label(256, 128, "f").arrow((60, 168), (24, 168), "R", (40, 152))
    m.arrow((280, 150), (325, 150), "x_1", (306, 164), load=False).arrow((212, 84), (250, 84), "x_2", load=False)
    return m.label(150, 212, "slope").arrow((190, 212), (250, 212), load=False)


def _rolling() -> Machine:
    text = (
        "A body of mass m1 with an inner mass m2 on a spring; two elastic rings of radius R are pressed by the pipe of diameter "
        "D with the force N on rollers of radius rho, which turn one way only."
    )
    m = _pipe(Machine("Pipe robot on elastic rings with one-way rollers", text, 350, 230), 30, 190)
    m.line((90, 110), (108, 110), width=4).line((130, 132), (130, 142), (250, 142), (250, 110), width=3)
    for x in (90, 250):
        m._add(f'<ellipse cx="{x}" cy="110" rx="26" ry="66"/>')
        m.wheel(x, 37, 7, hub=False).wheel(x, 183, 7, hub=False)
    m.mass(130, 110, 44, 44, "m_1").mass(212, 110, 32, 34, "m_2").spring((152, 110), (196, 110), "k", -1, turns=3)
    m.arrow((90, 44), (90, 78), "N", (106, 66)).label(60, 132, "R").label(270, 44, "ρ").measure((322, 188), (322, 32), "D", 1)
    return m.arrow((150, 158), (200, 158), "x_1", load=False)


def _route() -> Machine:
    text = (
        "A pipe whose slope and diameter D change along the position x, from a table of places between which a smooth curve is "
        "laid."
    )
    m = Machine("Pipe along its way", text, 340, 190)
    m.curve("M15 130C100 130 110 110 160 80S240 40 325 40", 2).curve("M15 158C110 158 130 138 180 104S250 66 325 66", 2)
    for x, y in ((40, 144), (110, 130), (168, 92), (240, 60), (310, 53)):
        m.node(x, y)
    m.line((110, 130), (190, 130), width=1, dash="4 3").turn(110, 130, 62, 0, 28, "slope", (204, 118)).measure(
        (290, 66), (290, 41), "D", 1
    )
    return m.arrow((20, 180), (90, 180), "x", load=False)


def _tow() -> Machine:
    text = (
        "A spring k and a damper c in parallel between a robot in front at x front and one behind at x rear, which they keep a "
        "length apart."
    )
    m = Machine("Coupling between two robots", text, 350, 190)
    m.mass(45, 90, 74, 56, "rear").mass(305, 90, 74, 56, "front").line((82, 90), (105, 90)).line((245, 90), (268, 90))
    m.line((105, 66), (105, 114)).line((245, 66), (245, 114)).spring((105, 70), (245, 70), "k", -1).damper(
        (245, 110), (105, 110), "c", -1
    )
    m.measure((82, 152), (268, 152), "length + e")
    return m.arrow((82, 44), (128, 44), "F_{rear}", (104, 28)).arrow((268, 44), (222, 44), "F_{front}", (246, 28))


def _program() -> Machine:
    text = (
        "Frequency, amplitude and voltage over the time t: a straight line from start to end, and where wanted back the same way."
    )
    m = Machine("Program of the exciter", text, 340, 170)
    m.line((40, 140), (325, 140), width=1).line((40, 140), (40, 20), width=1).label(332, 154, "t").line(
        (40, 120), (80, 120), (180, 40), (220, 40), width=2.4
    )
    m.line((220, 40), (320, 120), width=1.4, dash="6 4").word(60, 106, "start").word(200, 26, "end").word(290, 66, "and back")
    return m.word(46, 14, "frequency, amplitude, voltage", "start")


MACHINES = {
    "RollingPipeRobot": _rolling,
    "TowCoupling": _tow,
    "PipeRoute": _route,
    "PipeRobot": _robot,
    "ExciterProgram": _program,
}
