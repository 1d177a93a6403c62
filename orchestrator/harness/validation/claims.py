"""What a paper announces, claim by claim, as data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ....components.core.errors import BadInput, pick

CONSTRUCTION = "by construction"  # a row that no run can fail, and the verdict of a finding without others
VERDICTS = ("shown", "partly", "not shown", "contradicted", CONSTRUCTION)
MEANINGS = {
    "shown": "every criterion is met",
    "partly": "some are, or a control shows where the claim ends",
    "not shown": "none is",
    "contradicted": "a measured row says the opposite",
    CONSTRUCTION: "what is announced is an assumption of the model, so that no row of it could fail; it is not counted as shown",
}
CLAIM_KINDS = ("model", "finding")
ROLES = ("supports", "limits", "contradicts", CONSTRUCTION)
_TEXTS = ("number", "kind", "announced", "verdict")
_OPTIONAL = ("criterion", "discussion", "shown_by", "missing")


@dataclass(frozen=True)
class Claim:
    """One statement of a paper's abstract, in words of this project.

    kind: "model", held by equations, effects and tests, or "finding", held by measured rows.
    criterion: what a run has to give, derived before it.  shown_by: components, effects as Component.effect, files.
    missing: a part that is announced and not modelled here; such a claim is "partly" shown at most.
    verdict: what the rows gave when they were last reviewed; a run that gives another one fails.
    """

    number: str
    kind: str
    announced: str
    verdict: str
    criterion: str = ""
    discussion: str = ""
    shown_by: tuple[str, ...] = ()
    missing: str = ""


def read_claims(table: str, entries: Iterable[Mapping[str, Any]]) -> tuple[Claim, ...]:
    """Claims of a table's text; what is missing or unknown is one `BadInput`."""
    claims = tuple(_claim(f"table {table}, claim {i}", entry) for i, entry in enumerate(entries, 1))
    if len({c.number for c in claims}) < len(claims):
        raise BadInput(f"table {table}", "a claim's number twice", "each number once")
    return claims


def _claim(where: str, entry: Mapping[str, Any]) -> Claim:
    for key in entry:
        pick(key, _TEXTS + _OPTIONAL, where, "a field of a claim", "field")
    for key in _TEXTS:
        if not isinstance(entry.get(key), str):
            raise BadInput(where, f"{key} = {entry.get(key)!r}", "a text")
    claim = Claim(**{**entry, "shown_by": tuple(entry.get("shown_by", ()))})
    for key, value, known in (("verdict", claim.verdict, VERDICTS), ("kind", claim.kind, CLAIM_KINDS)):
        if value not in known:
            raise BadInput(where, f"{key} = {value!r}", "one of " + ", ".join(known))
    if claim.kind == "finding" and not claim.criterion:
        raise BadInput(where, "a finding without a criterion", "what a run has to give, derived before it")
    if claim.kind == "model" and not claim.shown_by:
        raise BadInput(where, "a model without what shows it", "shown_by: components, effects, files")
    if claim.verdict != "shown" and not claim.discussion:
        raise BadInput(where, f"verdict {claim.verdict!r} without a discussion", "what holds, what does not, and why")
    return claim
