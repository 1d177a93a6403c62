"""Failed points of a sweep in groups: how many failed alike, and why."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def failure_groups(outcomes: Sequence[str]) -> list[str]:
    """A sentence for each kind of failure, the most frequent first. Reasons that differ by their numbers only are of one kind.

    outcomes: (n,), "done", "not run" or the reason.
    """
    return _groups([outcome for outcome in outcomes if outcome not in ("done", "not run")], len(outcomes), "failed")


def doubt_groups(kinds: Sequence[str] | np.ndarray, reasons: Sequence[str] | np.ndarray) -> list[str]:
    """The same for points that are done and may be unstable. kinds, reasons: (n,), of a `Sweep`."""
    doubtful = [reason for kind, reason in zip(kinds, reasons, strict=True) if reason and kind == "done"]
    return _groups(doubtful, len(kinds), "are doubtful")


def _groups(texts: Sequence[str], count: int, what: str) -> list[str]:
    groups: dict[str, list[str]] = {}
    for text in texts:
        groups.setdefault(NUMBER.sub("#", text), []).append(text)
    return [
        f"{len(members)} of {count} points {what}: {'' if len(set(members)) == 1 else 'such as: '}{members[0]}"
        for members in sorted(groups.values(), key=len, reverse=True)
    ]
