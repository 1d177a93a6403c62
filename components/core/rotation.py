"""Attitude by a quaternion (w, x, y, z) that turns body axes into world axes.

The kernels divide by the quaternion's norm, so it need not be 1: q' = q (0, omega) / 2 is linear in q, and a norm that
drifts in an integration alters no rotation. It is enough to set it back to 1 now and then, and no term has to hold it there.

Angles are roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll), with z downwards in marine use.
"""

from __future__ import annotations

import math

from .kernels import kernel

VERTICAL = math.cos(math.radians(89.9))  # cosine of the pitch above which roll and yaw are determinate


@kernel
def quaternion_of_angles(roll, pitch, yaw):
    """Quaternion (w, x, y, z) of roll, pitch and yaw in rad."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy)


@kernel
def quaternion_rate(w, x, y, z, p, q, r):
    """Time derivative of the quaternion for the angular velocity (p, q, r) about the body's axes, rad/s."""
    return (
        -0.5 * (x * p + y * q + z * r),
        0.5 * (w * p + y * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - y * p),
    )


@kernel
def to_world(w, x, y, z, a, b, c):
    """World components of the vector that has the body components (a, b, c)."""
    s = 2.0 / (w * w + x * x + y * y + z * z)
    i, j, k = y * c - z * b, z * a - x * c, x * b - y * a
    return (a + s * (w * i + y * k - z * j), b + s * (w * j + z * i - x * k), c + s * (w * k + x * j - y * i))


@kernel
def to_body(w, x, y, z, a, b, c):
    """Body components of the vector that has the world components (a, b, c)."""
    return to_world(-w, x, y, z, a, b, c)


@kernel
def angles(w, x, y, z, held_roll):
    """(roll, pitch, yaw, validity) of a quaternion, rad; the last is 1.0 where roll and yaw are determinate, else 0.0.

    Within 0.1 degrees of the vertical they turn about the same axis, and only their sum or difference is a fact: there
    roll is `held_roll`, such as the last determinate one, and yaw takes the rest, so that neither jumps.
    """
    s = 1.0 / (w * w + x * x + y * y + z * z)
    side, down = 2.0 * s * (y * z + w * x), 1.0 - 2.0 * s * (x * x + y * y)
    level = math.hypot(side, down)  # cosine of the pitch
    pitch = math.atan2(2.0 * s * (w * y - x * z), level)
    if level >= VERTICAL:
        yaw = math.atan2(2.0 * s * (x * y + w * z), 1.0 - 2.0 * s * (y * y + z * z))
        return math.atan2(side, down), pitch, yaw, 1.0
    turn = math.atan2(2.0 * s * (x * y - w * z), 1.0 - 2.0 * s * (x * x + z * z))  # roll - yaw upwards, -(roll + yaw) down
    yaw = held_roll - turn if pitch > 0.0 else -held_roll - turn
    return held_roll, pitch, math.atan2(math.sin(yaw), math.cos(yaw)), 0.0
