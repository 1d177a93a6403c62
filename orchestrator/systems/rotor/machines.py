"""Drawings of rotors."""

from __future__ import annotations

from ...harness.machine import Machine


def _jeffcott() -> Machine:
    text = (
        "A disk of mass m in the middle of a massless shaft of stiffness k between two rigid supports. On the right the disk "
        "along the axis: its middle is at (x, y), its centre of mass the distance e away, at the angle phi; damping c, force F."
    )
    m = Machine("Jeffcott rotor", text, 350, 235)
    m.curve("M20 120Q95 86 170 120", 3).mass(95, 103, 16, 90).label(95, 40, "m")
    for x in (20, 170):
        m.line((x - 10, 138), (x, 122), (x + 10, 138), closed=True).ground((x + 14, 138), (x - 14, 138))
    m.label(48, 88, "k").line((10, 120), (182, 120), width=1, dash="9 4 2 4")
    m.wheel(270, 100, 55, hub=False).node(270, 100).node(290, 80, "e", (-18, -2)).line((270, 100), (290, 80)).turn(
        270, 100, 24, 0, 45, "φ", (306, 90)
    ).line((270, 100), (316, 100), width=1, dash="3 3")
    m.arrow((183, 215), (216, 215), "x", load=False).arrow((183, 215), (183, 178), "y", load=False)
    return (
        m.arrow((290, 120), (322, 152), "F", (334, 160))
        .turn(270, 100, 66, 100, 150, "w")
        .damper((270, 210), (270, 155), "c")
        .ground((295, 210), (245, 210))
    )


def _beam() -> Machine:
    text = (
        "A shaft of Timoshenko beam elements along z with two disks, on two bearings of stiffness k and damping c. Each node "
        "moves across the shaft and tilts; the shaft turns at Omega, unbalance and bearing forces act on it."
    )
    m = Machine("Rotor of beam elements with disks on bearings", text, 350, 210)
    m.line((25, 83), (325, 83), width=2).line((25, 97), (325, 97), width=2).line((25, 83), (25, 97)).line((325, 83), (325, 97))
    for x in range(55, 325, 30):
        m.line((x, 83), (x, 97), width=1)
    m.mass(130, 90, 14, 100).mass(225, 90, 14, 76).label(130, 28, "M, G")
    for x, name in ((55, "a"), (295, "b")):
        m.spring((x - 12, 98), (x - 12, 160), f"k_{name}", width=6).damper((x + 12, 160), (x + 12, 98), f"c_{name}", width=6)
        m.ground((x + 26, 160), (x - 26, 160))
    m.line((10, 90), (340, 90), width=1, dash="9 4 2 4").turn(326, 90, 22, -50, 50, "Ω", (330, 56))
    m.arrow((180, 90), (180, 50), "y", (192, 52), load=False).turn(180, 90, 24, 250, 330)
    return m.arrow((145, 190), (195, 190), "z", load=False).arrow((225, 128), (225, 160), "f", (240, 152))


MACHINES = {"JeffcottRotor": _jeffcott, "BeamRotor": _beam}
