"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import closed_forms, hunting, paper_servo_drive, servo_motor

CASES = tuple(module.CASE for module in (closed_forms, servo_motor, hunting, paper_servo_drive))
