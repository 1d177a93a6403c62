"""What a scene's [analysis] may say. A key that nothing reads would have no effect, and is an error."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from components.core.errors import BadInput, nearest

EVERYWHERE = {
    "system": '"railway", "bearings" or "rotor": which figures the report has',
    "transient": "s from the start that are left out of spectra, orbits, measures and sections",
    "section": '{ signal = "unit.output", angle = "unit.output", turns = points a turn }: of a sweep, and in phase planes',
}
KEYS: dict[str, dict[str, str]] = {
    "railway": {
        "window": "[from, to] in m along the track, for the statistics",
        "span": "length of a span, m, for marks in the figures",
        "droppers": "positions of the droppers in a span, m",
    },
    "bearings": {
        "bearing": "the bearings to show, a name or a list; all of them without it",
        "marks": 'lines to mark in spectra: "outer", "inner", "ball", "cage", "shaft"',
        "highest_frequency": "end of the spectra's axes, Hz",
        "envelope_band": "[from, to] in Hz; the most impulsive band without it",
        "recurrence": "{ threshold = in standard deviations, theiler = samples, interval = s }",
    },
    "rotor": {
        "bearing": "the bearings to show, a name or a list; all of them without it",
        "orders": "multiples of the speed to follow",
        "orbit_windows": "[[from, to], ...] in s",
        "critical_speeds": "rad/s, to mark; without them from the rotor's matrices",
        "campbell_speed": "end of the Campbell diagram, rad/s",
    },
}


def check(analysis: Mapping[str, Any]) -> None:
    """Raise `BadInput` for a system or a key that is not known."""
    system = analysis.get("system", "")
    if system and system not in KEYS:
        raise BadInput("analysis.system", repr(system), "one of " + ", ".join(KEYS), nearest(str(system), KEYS))
    known = EVERYWHERE | KEYS.get(system, {})
    for key in analysis:
        if key in known:
            continue
        others = [s for s, keys in KEYS.items() if key in keys]
        remedy = f"It belongs to system = {' or '.join(map(repr, others))}." if others else nearest(key, known)
        raise BadInput("analysis", f"key {key!r}", "a key that is read" + (f" for {system}" if system else ""), remedy)
