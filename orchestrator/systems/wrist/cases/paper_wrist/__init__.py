"""What the paper on the rules of the wrist announces, claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import constraints, load, postures

CASE = Case(
    postures.NAME,
    "Rules of the wrist (Sandow 2020)",
    "Roll, arcs of the rows and their signs over all postures, stability under a load along the forearm, lengths of the "
    "ligaments, and a person's wrist with two interventions. The abstract is what is known of the paper: axes, attachments and "
    "numbers are of this project or read in other studies. No number of a living wrist follows from it.",
    tuple(topic.QUESTION for topic in (postures, load, constraints)),
)
