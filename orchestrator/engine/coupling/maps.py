"""Maps of values that a connection carries: truth values, whole numbers and members of enumerations, entry by entry."""

from __future__ import annotations

from typing import Any

from ....components.core.errors import BadInput, nearest
from ...settings import ConnectionSettings
from ...units.interface import Signal

MAPPED = ("boolean", "integer", "enumeration")
TRUTHS = {"true": 1, "false": 0}


def mapped(connection: str | ConnectionSettings, source: Signal, target: Signal, where: str) -> tuple[tuple[float, float], ...]:
    """(number of the output, number of the input) of each entry of a connection's map; none where it has no map.

    Raises `BadInput` for entries that fit no value, and where a value that the output may have is missing: all truth values and all
    members of an enumeration. Of whole numbers nobody knows which will come; one without an entry ends the run.
    """
    table = connection.map if isinstance(connection, ConnectionSettings) else None
    if table is None:
        return ()
    if source.kind != target.kind or source.kind not in MAPPED:
        raise BadInput(
            where,
            f"a map from a {source.kind} output to a {target.kind} input",
            "truth values, whole numbers or members of an enumeration at both ends",
        )
    pairs = {_number(source, key, where): _number(target, value, where) for key, value in table.items()}
    known = TRUTHS if source.kind == "boolean" else source.members
    if missing := [name for name, value in known.items() if value not in pairs]:
        raise BadInput(f"{where}: map", f"no entry for {', '.join(missing)}", "one for each value of the output")
    return tuple((float(a), float(b)) for a, b in pairs.items())


def _number(signal: Signal, value: Any, where: str) -> int:
    """Of a value as a map has it: keys are texts always."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    if signal.kind == "boolean":
        known = TRUTHS
    elif text.removeprefix("-").isdigit() and not isinstance(value, bool):
        return int(text)
    else:
        known = dict(signal.members)
    if text not in known:
        kind = {"boolean": "true or false", "integer": "a whole number"}.get(signal.kind, "a member of the enumeration")
        raise BadInput(f"{where}: map", repr(value), f"{kind}, for {signal.name}", nearest(text, known) if known else "")
    return known[text]
