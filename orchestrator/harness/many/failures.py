"""Failed points of a sweep in groups: how many failed alike, why, and what they have in common."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
NO_FAILURE = ("done", "not run")


def failure_groups(outcomes: Sequence[str], varied: Mapping[str, np.ndarray]) -> list[str]:
    """A sentence for each kind of failure, the most frequent first.

    outcomes: (n,), "done", "not run" or the reason. Reasons that differ by their numbers only are of one kind.  varied: name ->
    values, (n,) each.
    """
    failed = {k: outcome for k, outcome in enumerate(outcomes) if outcome not in NO_FAILURE}
    done = [k for k, outcome in enumerate(outcomes) if outcome == "done"]
    return _groups(failed, done, varied, len(outcomes), "failed")


def doubt_groups(
    kinds: Sequence[str] | np.ndarray, reasons: Sequence[str] | np.ndarray, varied: Mapping[str, np.ndarray]
) -> list[str]:
    """The same for points that are done and may be unstable. kinds, reasons: (n,), of a `Sweep`."""
    doubtful = {k: reason for k, reason in enumerate(reasons) if reason and kinds[k] == "done"}
    done = [k for k, kind in enumerate(kinds) if kind == "done" and k not in doubtful]
    return _groups(doubtful, done, varied, len(kinds), "are doubtful")


def _groups(texts: Mapping[int, str], done: Sequence[int], varied: Mapping[str, np.ndarray], count: int, what: str) -> list[str]:
    groups: dict[str, list[int]] = {}
    for k, text in texts.items():
        groups.setdefault(NUMBER.sub("#", text), []).append(k)
    sentences = []
    for members in sorted(groups.values(), key=len, reverse=True):
        common = _common(members, done, varied)
        alike = "" if len({texts[k] for k in members}) == 1 else "such as: "
        sentences.append(
            f"{len(members)} of {count} points {what}{f', all with {common}' if common else ''}: {alike}{texts[members[0]]}"
        )
    return sentences


def _common(members: Sequence[int], done: Sequence[int], varied: Mapping[str, np.ndarray]) -> str:
    """What of the varied values distinguishes the failed points from those that are done; "" where nothing does."""
    parts = []
    for name, values in varied.items() if done else ():
        failed, fine = values[list(members)], values[list(done)]
        if values.dtype.kind in "iuf":
            if failed.min() > fine.max():
                parts.append(f"{name} of at least {failed.min():.6g}")
            elif failed.max() < fine.min():
                parts.append(f"{name} of at most {failed.max():.6g}")
        elif not set(map(str, failed)) & set(map(str, fine)):
            parts.append(f"{name} = {' or '.join(dict.fromkeys(map(str, failed)))}")
    return " and ".join(parts)
