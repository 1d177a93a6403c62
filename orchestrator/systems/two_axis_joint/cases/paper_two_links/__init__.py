"""What the paper of the body on a two-axis joint and of two links announces, claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import applications, special_case

CASE = Case(
    special_case.NAME,
    "Body on a two-axis joint and two links (Akulenko, Bolotnik, Leshchenko and Palii 2020)",
    "The special case in which the linear model with viscous joints has an exact solution, for any two links, and what happens "
    "beside it; then three applications: a satellite's panel unfolds, an arm follows its set points, a jaw crusher turns. The "
    "abstract is what is known of the paper: which case it means is not.",
    tuple(topic.QUESTION for topic in (special_case, applications)),
)
