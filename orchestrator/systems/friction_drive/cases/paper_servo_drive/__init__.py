"""The paper of Frączak (2013), claim by claim: a drive with friction wheels, its control, and what a surgeon asks of it."""

from __future__ import annotations

from .....harness.validation import Case
from . import accuracy, contact, control, path, power_loss

CASE = Case(
    "paper-servo-drive",
    "Servo drive with friction wheels (Frączak 2013)",
    "Steps and a path in both degrees of freedom under control, against the closed form of the design model and within the "
    "limits; then what matters at the patient: resolution, repeatability, force at the tip, slip, loss of power, and the "
    "friction of the trocar. Layouts and numbers are ours, of the size that such an instrument has; nothing measured is in "
    "it.",
    tuple(topic.QUESTION for topic in (control, path, accuracy, contact, power_loss)),
)
