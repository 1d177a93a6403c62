"""Elastic stops with hysteresis, for any angle or distance that has a range.

Source of the law: Hunt and Crossley, ASME Journal of Applied Mechanics 42 (1975) 440-445.
"""

from __future__ import annotations

from .kernels import kernel


@kernel
def stop_torque(angle, rate, lower, upper, stiffness, dissipation):
    """Torque of the stops on an axis: stiffness * depth * (1 + dissipation * rate into the stop), never pulling."""
    depth, into = angle - upper, rate
    if angle < lower:
        depth, into = lower - angle, -rate
    if depth <= 0.0:
        return 0.0
    torque = max(stiffness * depth * (1.0 + dissipation * into), 0.0)
    return torque if angle < lower else -torque


@kernel
def stop_depth(angle, lower, upper):
    """How far an angle is beyond its stops, rad."""
    return max(angle - upper, lower - angle, 0.0)
