"""Figures of a living wrist's bones, beside thresholds that were written down before the poses were read, and the model's axes.

`poses-66582.csv` is what `python -m cosimo.orchestrator.systems.wrist.measured_axes 66582` prints of that person's public poses; the
poses are not here. What is judged is the wrist, by figures that no model made, and by the model with axes of other postures.
"""

from __future__ import annotations

import math
from pathlib import Path

from ......components.core.columns import read_table
from ......components.wrist.kinematics import DISTAL_TILT, PROXIMAL_TILT
from .....harness.validation import Evidence, Runs
from ...row_rules import DIRECTIONS

FILE = Path(__file__).with_name("poses-66582.csv")
AXES = ("proximal", "distal")


def measure(runs: Runs) -> Evidence:
    """The person's figures, and some of them in units of their errors."""
    table = read_table(FILE)
    of = dict(zip(table.texts("figure"), table.numbers("value").tolist(), strict=True))
    measured = {f"poses.{name}": value for name, value in of.items()}
    measured |= {f"poses.{name}.errors": of[name] / of[f"{name}.error"] for name in ("share", "per.deviation", "apart")}
    measured |= {f"poses.{way}.errors": of[f"toward.{way}"] / of["error"] for way in DIRECTIONS}
    measured["poses.distal.share.errors"] = (1.0 - of["share"]) / of["share.error"]
    measured["poses.arcs.errors"] = (of["arc.flexion"] - of["arc.deviation"]) / of["error"]
    measured["poses.halves"] = of["halves.error"] / of["halves.control"]
    for axis, tilt in zip(AXES, (PROXIMAL_TILT, DISTAL_TILT), strict=True):
        measured[f"tilt.{axis}.errors"] = abs(math.degrees(tilt) - of[f"tilt.{axis}"]) / of[f"tilt.{axis}.error"]
    return Evidence(measured)
