"""Speeds and displacements of the rotors of a run, forces and ball loads of their bearings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, SummaryRow
from ...run.key_results import after_transient
from .records import RotorRecord, rotors

if TYPE_CHECKING:
    from ...run.results import Result

HOUR = 3600.0  # s
HEADLINE = ("displacement_max", "speed_at_max", "force_max", "ball_load_max", "rating_life")  # what a run is judged by
INPUTS = ("start_speed", "run_up.*", "length", "outer_diameter", "unbalance.*", "disks.mass*", "*clearance", "*.position*")


def summary(result: Result) -> Summary:
    """Of every rotor whose speed was recorded, after the transient."""
    kept = after_transient(result)
    return tuple(row for r in rotors(result) for row in _rows(r, kept))


def _rows(rotor: RotorRecord, kept: slice) -> list[SummaryRow]:
    speed = rotor.signals["speed"][kept]
    numbers = [SummaryRow(f"{rotor.unit}.speed_end", float(speed[-1]), "rad/s", "speed at the end")]
    if {"x", "y"} <= rotor.signals.keys():
        radius = np.hypot(rotor.signals["x"], rotor.signals["y"])[kept]
        largest = int(np.argmax(radius))
        numbers += [
            SummaryRow(f"{rotor.unit}.displacement_max", float(radius[largest]), "m", "largest displacement where it is watched"),
            SummaryRow(f"{rotor.unit}.speed_at_max", float(speed[largest]), "rad/s", "speed at the largest displacement"),
        ]
    for port, signals in rotor.ports.items():
        if {"force_x", "force_y"} <= signals.keys():
            force = np.hypot(signals["force_x"], signals["force_y"])[kept]
            numbers.append(
                SummaryRow(f"{rotor.unit}.{port}.force_max", float(force.max()), "N", f"largest radial force at {port}")
            )
        if "max_ball_load" in signals:
            numbers.append(
                SummaryRow(
                    f"{rotor.unit}.{port}.ball_load_max",
                    float(signals["max_ball_load"][kept].max()),
                    "N",
                    f"largest load of a ball at {port}",
                )
            )
        if "rating_life.rate" in signals and (rate := float(signals["rating_life.rate"][kept].mean())) > 0.0:
            life = SummaryRow(
                f"{rotor.unit}.{port}.rating_life", 1.0 / (HOUR * rate), "h", f"rating life at {port}, by the run's loads"
            )
            numbers.append(life)
    return numbers
