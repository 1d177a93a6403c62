"""The paper of Kaniewski and Cichoński (2019), claim by claim: a lumped catenary through the table of EN 50318."""

from __future__ import annotations

from .....harness.validation import Case
from . import lumped, stiffness, table

CASE = Case(
    "paper-pantograph",
    "Pantograph and lumped catenary (Kaniewski, Cichoński 2019)",
    "Takes a mass on a spring that varies along the span, the class of model of the paper, row by row through the table of "
    "EN 50318:2002, with the stiffness that statics gives. Every row that it can hold and cannot hold was derived before, from "
    "a closed form. The paper's coefficients are not known to us: the verdict is on the class of model, not on the paper's "
    "numbers.",
    tuple(topic.QUESTION for topic in (stiffness, lumped, table)),
)
