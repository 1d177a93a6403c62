"""Thermal resistance of an angular contact bearing (Spence & Kaminski 1996), claim by claim."""

from __future__ import annotations

from .....harness.validation.papers import paper
from . import circumference, paths, plane

CASE = paper(
    "paper-thermal-resistance",
    "Thermal resistance of an angular contact bearing (Spence and Kaminski 1996)",
    "Asks what the abstract of Spence & Kaminski (1996) announces: contact areas around the circumference, conduction, "
    "convection and radiation from race to race, and the resistance over radial and axial load. Criteria are closed forms, an "
    "independent solver's table and finite volumes; that paper's bearing and curves were not at hand, and nothing rotates.",
    "bearings",
    (plane.study, paths.study, circumference.study),
)
