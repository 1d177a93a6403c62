"""Drawings of the friction-wheel drive."""

from __future__ import annotations

from ...harness.machine import Machine, motor
from ..two_axis_joint.machines import controller


def _servo_controller() -> Machine:
    return controller(
        "set",
        "e",
        "K_p, K_v",
        "V",
        "drive",
        "way, rates",
        "Cascade of feed and rotation over the rates of both wheels, sampled, with limits.",
    )


def _servo_motor() -> Machine:
    text = (
        "A DC motor with voltage V, resistance R, inductance L and current i; its rotor of inertia J_r drives a wheel of "
        "inertia J_w through a gear of the ratio N. The wheel turns at w against friction and the load."
    )
    m = motor(Machine("Servo motor with gear and wheel", text, 350, 180), 228, 90)
    m.label(236, 122, "J_r").line((228, 90), (244, 90), width=4).block(258, 90, 28, 56, "N").line((272, 90), (296, 90), width=4)
    return m.mass(304, 90, 16, 100).label(304, 26, "J_w").turn(318, 90, 24, -55, 55, "w", (338, 62)).label(332, 140, "load")


def _wheels() -> Machine:
    text = (
        "A sleeve of mass m and radius r slides along its axis by z and turns by phi. Two wheels of radius R, pressed on it "
        "with the normal force, stand at the angles a1 and a2 to the axis, turn at w1 and w2 and pull with the forces Q1 and "
        "Q2."
    )
    m = Machine("Sleeve between two friction wheels", text, 350, 240)
    m.mass(165, 120, 270, 56).line((20, 120), (330, 120), width=1, dash="9 4 2 4").label(54, 106, "m, J")
    for x, name, lean in ((125, "1", 1), (215, "2", -1)):
        m.curve(f"M{x - 32} {120 + lean * 18}L{x + 32} {120 - lean * 18}", 12)
        m.arrow((x, 120), (x + 52, 120 - lean * 30), f"Q_{name}", (x + 62, 120 - lean * 44))
        m.label(x - 34 * lean, 120 - 42 * lean, f"w_{name}")
    m.arrow((300, 70), (340, 70), "z", (318, 56), load=False)
    m.arrow((165, 40), (165, 88), "normal force", (165, 26)).arrow((165, 204), (165, 152))
    return m.curve("M22 100A12 32 0 0 0 22 140", 1.4).label(10, 166, "φ").measure((314, 148), (314, 120), "r")


MACHINES = {"FrictionWheels": _wheels, "FrictionDrive": _wheels, "ServoController": _servo_controller, "ServoMotor": _servo_motor}
