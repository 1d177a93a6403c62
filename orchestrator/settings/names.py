"""Names in texts: the one place where "unit.variable" and "unit.output -> unit.input" are taken apart.

Names of units are identifiers with dots between subsystems. The name of a variable is any string: it may hold dots, blanks, brackets,
quotation marks and arrows. A text is therefore read by the names of the units that there are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

JOINED, ARROW = "<->", "->"
TABLE_FORM = 'Write it as a table: { source = "unit.output", target = "unit.input" }.'


class Reading(NamedTuple):
    """One way to read a connection: its arrow, and both ends as they are written."""

    arrow: str
    source: str
    target: str


def split_name(text: str, units: Collection[str]) -> tuple[str, str]:
    """("unit", "rest") of "unit.rest": the longest name of a unit, which may hold dots, or else what the first dot ends."""
    unit = max((u for u in units if text.startswith(f"{u}.")), key=len, default=text.partition(".")[0])
    return unit, text[len(unit) + 1 :]


def names_in(pair: str) -> tuple[str, ...]:
    """The names of "unit.parameter, unit.parameter", a key of [correlations]."""
    return tuple(name.strip() for name in pair.split(","))


def readings(text: str, units: Collection[str]) -> list[Reading]:
    """All ways to read the text of a connection in which both ends begin with a unit.

    Blanks beside the arrow belong to no name, or all but one of them do.
    """
    texts: dict[Reading, None] = {}
    for arrow, left, right in _parted(text):
        for source, target in ((left.strip(), right.strip()), (left.removesuffix(" "), right.removeprefix(" "))):
            if all(split_name(end, units)[1] and split_name(end, units)[0] in units for end in (source, target)):
                texts[Reading(arrow, source, target)] = None
    return list(texts)


def connection(source: str, target: str, units: Collection[str]) -> str | dict[str, Any]:
    """A connection as a scene has it: a text, or a table where a text could be read in another way."""
    text = f"{source} {ARROW} {target}"
    plain = "*" not in text and readings(text, units) == [Reading(ARROW, source, target)]
    return text if plain else {"source": source, "target": target}


def prefixed(text: str, entry: str, units: Collection[str]) -> list[str]:
    """The text of a connection between `units` as a scene around them, which calls them "entry.unit", would write it: one text for
    each arrow by which it can be read."""
    texts: dict[str, None] = {}
    for arrow, left, right in _parted(text):
        ends = [end.lstrip() for end in (left, right)]
        if all(split_name(end, units)[0] in units for end in ends):
            texts[f"{entry}.{ends[0]}{arrow}{' ' * (len(right) - len(ends[1]))}{entry}.{ends[1]}"] = None
    return list(texts)


def _parted(text: str) -> Iterator[tuple[str, str, str]]:
    """(arrow, left, right) at each arrow of a text."""
    for arrow in (JOINED, ARROW):
        at = text.find(arrow)
        while at >= 0:
            yield arrow, text[:at], text[at + len(arrow) :]
            at = text.find(arrow, at + 1)
