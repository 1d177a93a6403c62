"""Deep groove bearing with six degrees of freedom (Sopanen & Mikkola 2003), claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import clearance, defects, masters, waviness

CASE = Case(
    "paper-deep-groove",
    "Deep groove ball bearing with six degrees of freedom (Sopanen and Mikkola 2003)",
    "Asks of a rigid shaft in the bearing what the abstract of Sopanen & Mikkola (2003) announces: natural frequencies and "
    "vibration over the clearance, waves of the rings, pits, and use as an element of other codes. Criteria are closed forms and "
    "independent solutions in the bearing's own scales; that paper's bearing and numbers were not at hand.",
    tuple(topic.QUESTION for topic in (clearance, waviness, defects, masters)),
)
