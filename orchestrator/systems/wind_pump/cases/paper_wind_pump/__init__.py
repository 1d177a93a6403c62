"""What the paper of the wind pump announces, claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import sizes, stability, stresses, water

CASE = Case(
    "paper-wind-pump",
    "Wind pump with a transmission that adapts its ratio (Scutaru and Mitrica 2016)",
    "Stability of turbine and converter over wind and load, by eigenvalues and by pushes; torsion, cycles and damage behind a "
    "fixed ratio and behind the clutches; water of a year by a wind distribution, against the fixed ratio best for the site. "
    "The abstract is what is known of the paper: mechanism, sizes and thresholds are of this project.",
    tuple(topic.QUESTION for topic in (stability, stresses, water, sizes)),
)
