"""The paper of Kabanov, Kramar and Ermakov (2021), claim by claim: six thrusters for six degrees of freedom, and the sea."""

from __future__ import annotations

from .....harness.validation import Case
from . import losses, power, sea, tasks, wrench_sets

CASE = Case(
    "paper-underwater-vehicle",
    "Underwater vehicle with six thrusters (Kabanov, Kramar, Ermakov 2021)",
    "Compares the six thrusters of the paper with a usual layout of eight on the same hull: forces and moments that each can "
    "give, power and error in the same tasks in current and waves, and what is left when a thruster is lost. Checks the waves "
    "that the tasks near the coast need. The paper's arrangement was read; masses and drag are those of another vehicle.",
    tuple(topic.QUESTION for topic in (wrench_sets, power, tasks, losses, sea)),
)
