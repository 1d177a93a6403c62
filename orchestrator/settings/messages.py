"""Pydantic's findings in the form of all other messages: the place, the actual value, the expected one."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from ...components.core.errors import BadInput, nearest

M = TypeVar("M", bound=BaseModel)
EXPECTED = {
    "float_type": "a number",
    "string_type": "a text",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "int_type": "a whole number",
    "tuple_type": "a list",
    "too_short": "at least one",
    "string_pattern_mismatch": "a name of letters, digits and _ that starts with one of A to Z",
    "connection": '"unit.output -> unit.input" or a table',
}
BOUNDS = {"greater_than": "greater than", "greater_than_equal": "of at least", "less_than_equal": "of at most"}
LITERAL = re.compile("'(.*?)'")
MOST_KEYS = 8  # of a table that a message names
LONGEST = 200  # characters of a value that are shown


def validated(model: type[M], data: M | Mapping[str, Any], name: str) -> M:
    """Plain data as settings of a model; raises `BadInput`, in which the data are called `name`."""
    if isinstance(data, model):
        return data
    try:
        return model.model_validate(dict(data))  # type: ignore[arg-type]
    except ValidationError as error:
        raise one_message(error, model, name) from None


def one_message(error: ValidationError, model: type[BaseModel], name: str, *table: str) -> BadInput:
    """The first finding in the data of `model`, which stands in a table of the scene `name`."""
    finding = _first(error)
    kind, actual, context = finding["type"], shown(finding["input"]), finding.get("ctx", {})
    path = [key for k, key in enumerate(finding["loc"]) if key != "[key]" and not _is_mark(finding["loc"], k)]
    places = [*table, *path]
    cause = context.get("error")
    if isinstance(cause, BadInput):
        return BadInput(_where(name, *places, cause.where), cause.actual, cause.expected, cause.remedy)
    where = _where(name, *places)
    if kind == "extra_forbidden":
        last = str(path[-1])
        return BadInput(
            _where(name, *places[:-1]),
            f"unknown key {shown(last)}",
            "a known key",
            nearest(last, _model_at(model, path[:-1]).model_fields),
        )
    if kind == "literal_error":
        remedy = nearest(finding["input"], LITERAL.findall(context["expected"])) if isinstance(finding["input"], str) else ""
        return BadInput(where, actual, context["expected"], remedy)
    if kind == "missing":
        return BadInput(where, "nothing", "a value", f"Add {path[-1]} = ...")
    if kind in BOUNDS:
        (limit,) = context.values()
        return BadInput(where, actual, f"a number {BOUNDS[kind]} {limit:g}")
    if kind.endswith("_type") and "parameters" in path:
        return BadInput(_where(name, *places[: places.index("parameters") + 1]), actual, "a number, a text or a truth value")
    keys = list(_model_at(model, path).model_fields) if kind.startswith("model_") else []
    remedy = f"Its keys are {', '.join(keys[:MOST_KEYS])}{', ...' if len(keys) > MOST_KEYS else ''}." if keys else ""
    return BadInput(where, actual, EXPECTED.get(kind, finding["msg"]), remedy)


def _first(error: ValidationError) -> Any:
    """The first finding; of a connection, which is a text or a table, the one about the form it was given in."""
    findings = error.errors()
    finding = findings[0]
    loc = finding["loc"]
    if not _is_mark(loc, 2):
        return _misspelt(findings) or finding
    if not isinstance(finding["input"], dict):
        return {**finding, "type": "connection"}
    return next(f for f in findings if f["loc"][:2] == loc[:2] and f["loc"][2] != loc[2])


def _misspelt(findings: list[Any]) -> Any:
    """An unknown key that is nearly one that is missing in the same table: what was meant is clear."""
    missing = {(f["loc"][:-1], str(f["loc"][-1])) for f in findings if f["type"] == "missing"}
    for finding in (f for f in findings if f["type"] == "extra_forbidden"):
        *table, key = finding["loc"]
        if get_close_matches(str(key), [name for place, name in missing if place == tuple(table)], cutoff=0.5):
            return finding
    return None


def _is_mark(loc: tuple[str | int, ...], k: int) -> bool:
    """Whether an element of a finding's place is Pydantic's name of a form of a connection."""
    return loc[:1] == ("connections",) and k == 2 < len(loc)


def shown(value: Any) -> str:
    """A value as a message gives it: what would fill the screen is cut."""
    text = f"a whole number of {value.bit_length()} bits" if isinstance(value, int) and abs(value) > 10**30 else repr(value)
    return text if len(text) <= LONGEST else text[:LONGEST] + " ..."


def _model_at(model: type[BaseModel], path: Iterable[str | int]) -> type[BaseModel]:
    """The model of the table at a place in the data of another."""
    for key in path:
        field = model.model_fields.get(str(key))
        model = next(_models(field.annotation), model) if field is not None else model
    return model


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """Models among the types that an annotation is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models(argument)


def _where(name: str, *keys: str | int) -> str:
    """The scene and the dotted place in it; elements of lists are counted from 1."""
    place = "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys if key != "")
    return f"{name}: {place.removeprefix('.')}" if place else name
