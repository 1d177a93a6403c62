"""What an FMU says in its log while it runs: counted by level, and the first messages of each level kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...components.core.errors import BadInput, nearest, visible

LEVELS = ("info", "warning", "discard", "error", "fatal")  # by the statuses of FMI, from 0 on
MOST_MESSAGES = 100  # messages of each level of a unit
LONGEST = 1000  # characters of a message
STATUS = "returned a warning"  # calls that ended with this status; a message may have come with them
DEFAULT = "warning"


@dataclass(frozen=True)
class FmuLog:
    """Messages of an FMU as run.json has them: counts by level, and the first ones as (s, level, text)."""

    counts: Mapping[str, int]
    messages: tuple[tuple[float, str, str], ...]


class Messages:
    """Of one FMU. However many there are, memory is bounded; what is counted only costs no text."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = {}
        self.kept: list[tuple[float, str, str]] = []  # s, level, text

    def add(self, t: float, status: int, text: str) -> None:
        """A message at t, s, with a status of FMI."""
        level = LEVELS[status] if 0 <= status < len(LEVELS) else LEVELS[0]
        self.counts[level] = count = self.counts.get(level, 0) + 1
        if count <= MOST_MESSAGES:
            self.kept.append((t, level, visible(text[:LONGEST])))

    def warned(self, calls: int = 1) -> None:
        """So many calls have returned the status of a warning."""
        self.counts[STATUS] = self.counts.get(STATUS, 0) + calls


def level_of(name: str) -> str:
    """A level by its name, or "none"; `BadInput` for another one."""
    if name not in (*LEVELS, "none"):
        raise BadInput("fmu_log", repr(name), "one of none, " + ", ".join(LEVELS), nearest(name, LEVELS))
    return name


def described(messages: Mapping[str, Messages], level: str) -> dict[str, FmuLog]:
    """By unit: counts, and the messages of a level and above; nothing of units that are silent."""
    shown = LEVELS[LEVELS.index(level) :] if level in LEVELS else ()
    return {
        unit: FmuLog(of_unit.counts, tuple(one for one in of_unit.kept if one[1] in shown))
        for unit, of_unit in messages.items()
        if of_unit.counts
    }


def warnings_of(messages: Mapping[str, Messages]) -> list[str]:
    """One warning for each unit and level above that of information, with its first message."""
    texts = []
    for unit, of_unit in messages.items():
        for level in LEVELS[1:]:
            if count := of_unit.counts.get(level, 0):
                t, _, text = next(one for one in of_unit.kept if one[1] == level)
                many = f"{count} messages of level {level}, the first" if count > 1 else f"a message of level {level}"
                texts.append(f"{unit}: {many} at t = {t:.9g} s: {text}")
        if (calls := of_unit.counts.get(STATUS, 0)) and not of_unit.counts.get("warning"):
            texts.append(f"{unit}: {calls} call{'s' * (calls > 1)} {STATUS}, without a message")
    return texts


def log_lines(fmu_log: Mapping[str, FmuLog]) -> Sequence[str]:
    """The lines of fmu.log of a run, in the order of time."""
    lines = sorted(
        (t, f"t = {t:.9g} s  {unit}  {level}: {text}") for unit, of_unit in fmu_log.items() for t, level, text in of_unit.messages
    )
    more = [
        f"{unit}  {level}: {count - MOST_MESSAGES} more messages, which were counted only"
        for unit, of_unit in fmu_log.items()
        for level, count in of_unit.counts.items()
        if level != STATUS and count > MOST_MESSAGES and any(one[1] == level for one in of_unit.messages)
    ]
    return [*(line for _, line in lines), *more]
