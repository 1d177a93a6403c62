"""Rotors.

The port for a bearing takes the linearised bearing: F = force - stiffness q - damping q', with `force` its force at zero
displacement and velocity. So the rotor need not remember where a force was computed, and initial sweeps are Newton's method.
"""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {}
