"""Ball bearing with two degrees of freedom in dimensionless form (Ambrozkiewicz et al. 2021), claim by claim."""

from __future__ import annotations

from .....harness.validation import Case
from . import conditioning, groups, other_sets, transition

CASE = Case(
    "paper-ball-bearing",
    "Dimensionless ball bearing with two degrees of freedom (Ambrozkiewicz et al. 2021)",
    "Asks what the abstract of Ambrozkiewicz et al. (2021) announces: a miscalculation that the dimensionless form cures, its "
    "groups, and a transition between periodic and chaotic motion that recurrence plots show. Criteria are closed forms and "
    "independent computations; that paper's own parameters and numbers were not at hand.",
    tuple(topic.QUESTION for topic in (conditioning, groups, transition, other_sets)),
)
