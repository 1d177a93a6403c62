"""Drawings of pantograph and overhead line."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from ...harness.machine import Machine


def _pantograph() -> Machine:
    text = (
        "Head of mass m1 and frame of mass m2, one above the other. The contact spring kc leads from the head to the wire at "
        "height w; spring k1 and damper c1 join head and frame; spring k2 and damper c2 join frame and base. The static force "
        "F0 lifts the frame, the contact force F presses on the head."
    )
    m = Machine("Pantograph of two masses under the wire", text, 340, 300)
    m.line((30, 24), (310, 24), width=3).label(300, 40, "w").spring((170, 26), (170, 82), "k_c", -1)
    m.mass(170, 98, 120, 30, "m_1").arrow((205, 36), (205, 80), "F", (221, 56))
    m.spring((140, 113), (140, 167), "k_1").damper((200, 167), (200, 113), "c_1")
    m.mass(170, 183, 120, 30, "m_2").spring((140, 198), (140, 256), "k_2").damper((200, 256), (200, 198), "c_2")
    m.ground((250, 256), (90, 256)).arrow((95, 236), (95, 196), "F_0", (78, 222))
    m.arrow((262, 98), (262, 72), "z_1", (280, 84), load=False).line((232, 98), (266, 98), width=1)
    return m.arrow((262, 183), (262, 157), "z_2", (280, 169), load=False).line((232, 183), (266, 183), width=1)


def _catenary() -> Machine:
    text = (
        "Messenger wire above, hung at the supports, and contact wire below, joined by droppers of stiffness k. Both are under "
        "the tension T and carry the mass m for each metre; their deflection is u(x, t). The contact force F presses the "
        "contact wire upwards."
    )
    m = Machine("Two tensioned wires joined by droppers", text, 350, 210)
    m.ground((28, 150), (28, 34)).ground((322, 34), (322, 150))
    return (
        _span(m, 28, 322, "u")
        .arrow((205, 192), (205, 150), "F", (222, 178))
        .label(60, 92, "k")
        .label(175, 52, "m, EI")
        .arrow((322, 142), (347, 142), "T", (338, 126))
    )


def _span(
    m: Machine, left: float, right: float, u: str = "", drop: float = 60, low: float = 142, stitch: bool = False
) -> Machine:
    """A span of wires between two supports. drop: px by which the messenger wire hangs through."""
    width, middle = right - left, (left + right) / 2
    m.curve(f"M{left} {low - 98}Q{middle} {low - 98 + drop} {right} {low - 98}", 2).line((left, low), (right, low), width=3)
    for share in (0.14, 0.32, 0.5, 0.68, 0.86):
        m.line((left + share * width, low - 98 + 2 * drop * share * (1 - share)), (left + share * width, low), width=1.2)
    if stitch:
        for x, sign in ((left, 1), (right, -1)):
            m.line((x, low - 74), (x + sign * 0.2 * width, low - 98 + 0.32 * drop), width=2)
    return m.arrow((middle - 25, 128), (middle - 25, 106), u, (middle - 39, 118), load=False) if u else m


def _lumped() -> Machine:
    text = (
        "A mass m hangs by a spring whose stiffness k(x) varies along the span and a damper c. The contact force F lifts it by "
        "w. Below, k over the position x: large at the supports, small in the middle of the span of length L."
    )
    m = Machine("One mass on a spring that varies along the span", text, 340, 250)
    m.ground((70, 24), (190, 24)).spring((105, 24), (105, 92), "k(x)").damper((155, 92), (155, 24), "c").mass(
        130, 108, 100, 30, "m"
    )
    m.arrow((130, 168), (130, 126), "F", (146, 152)).arrow((200, 108), (200, 82), "w", (215, 94), load=False)
    m.line((40, 230), (320, 230), width=1).line((40, 230), (40, 178), width=1).label(22, 186, "k").label(328, 230, "x")
    m.curve("M40 184C90 184 90 218 165 218S240 184 290 184", 2).measure((40, 240), (290, 240), "")
    return m.label(165, 205, "L")


def scene(units: Mapping[str, Mapping[str, Any]]) -> Machine:
    """What tells one line from another: overlap, stitch wires, unequal spans, wires, pantographs, strips, speed."""
    line = next(u for u in units.values() if u["component"] != "Pantograph")
    if line["component"] == "LumpedCatenary":
        return _lumped()
    pantographs = [u for u in units.values() if u["component"] == "Pantograph"]
    effects = {e for u in (line, *pantographs) for e in u.get("effects", ())}
    table = line.get("parameters", {}).get("line_table", {}).get("table", "")
    overlap, unequal, stitch = ("overlap" in table, "unequal" in table, "stitched" in table)
    features = [text for text, there in (("overlap", overlap), ("unequal spans", unequal), ("stitch wires", stitch)) if there]
    features += [] if overlap or "second_wire" not in effects else ["two contact wires"]
    features += [f"{len(pantographs)} pantographs" if len(pantographs) > 1 else "pantograph"]
    features += ["two strips"] if "two_strips" in effects else []
    speed = 3.6 * pantographs[0].get("parameters", {}).get("speed", 0.0)
    features += [f"{speed:.0f} km/h"] if speed else []
    text = ", ".join(features)
    m = Machine(text, f"Overhead line from the side: {text}.", 340, 190)
    ends = (12, 92, 222, 328) if unequal else (12, 170, 328)
    for left, right in pairwise(ends):
        _span(m, left, right, drop=60 * min(1.0, (right - left) / 150), low=128, stitch=stitch)
    for x in ends:
        m.line((x, 16), (x, 170), width=2.6)
    if overlap:
        m.line((90, 128), (250, 60), width=3).line((90, 60), (250, 128), width=3)
    elif "second_wire" in effects:
        m.line((12, 133), (328, 133), width=3)
    middle = 130.0 if len(pantographs) == 1 else 170.0  # between two masts
    for k in range(len(pantographs)):
        at = middle + (k - (len(pantographs) - 1) / 2) * 76
        if "two_strips" in effects:
            m.line((at - 13, 138), (at - 3, 138), width=3.4).line((at + 3, 138), (at + 13, 138), width=3.4)
            m.line((at - 8, 140), (at + 8, 140))
        else:
            m.line((at - 13, 138), (at + 13, 138), width=3.4)
        m.line((at, 139), (at + 17, 153), (at, 169), width=2).line((at - 20, 170), (at + 20, 170), width=2)
    return m.arrow((276, 180), (332, 180), load=False).word(270, 180, text, "end")


MACHINES = {"Pantograph": _pantograph, "Catenary": _catenary, "LumpedCatenary": _lumped}
