"""What the paper of the pipe robots announces, claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import design, thresholds

CASE = Case(
    design.NAME,
    "Pipe robots with elastic elements and a vibration exciter (Matuliauskas and Spruogis 2002)",
    "A design chart: mean speed over friction ratio, frequency, slope and stiffness, with the thresholds at which a robot breaks "
    "loose, turns back or slides. A closed form by balance of the first harmonic beside runs that stick and slip exactly. The "
    "abstract is what is known of the paper: equations, sizes and chart are of this project.",
    tuple(topic.QUESTION for topic in (design, thresholds)),
)
