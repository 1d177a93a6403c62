"""What all tables of a scene share: frozen, closed models, the types of their numbers, and nested tables as full names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from sys import float_info
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from ...components.core.errors import BadInput
from ...components.core.measure import is_quantity, number_in

Seconds = Annotated[
    float,
    Field(strict=True, gt=0.0, allow_inf_nan=False),
    BeforeValidator(lambda value: number_in(value, "s", "") if is_quantity(value) else value),
]
Time = Annotated[
    float,
    Field(strict=True, allow_inf_nan=False),
    BeforeValidator(lambda value: number_in(value, "s", "") if is_quantity(value) else value),
]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
Truth = Annotated[bool, Field(strict=True)]
Whole = Annotated[int, Field(gt=-(2**64), lt=2**64)]  # what the widest types of an FMU hold
UNIT_NAME = r"^[A-Za-z]\w*(\.[A-Za-z]\w*)*$"  # "subsystem.unit" for the units of an included scene
Value = bool | Whole | float | str
RANGE = ("from", "to", "points")
MOST_POINTS = 1_000_000  # of one range; each is a run
# by full names; a file may also have them in nested tables and lists, which become full names before they are checked
Parameters = Annotated[
    dict[str, Value],
    BeforeValidator(lambda table: dict(flattened(table)) if isinstance(table, Mapping) else table),
    WithJsonSchema({"type": "object", "additionalProperties": {"type": ["boolean", "number", "string", "array", "object"]}}),
]
Tolerances = Annotated[
    dict[str, float | str],
    BeforeValidator(lambda table: dict(flattened(table)) if isinstance(table, Mapping) else table),
    WithJsonSchema({"type": "object", "additionalProperties": {"type": ["number", "string", "array", "object"]}}),
]
Sweep = Annotated[
    dict[str, Annotated[tuple[Number, ...], Field(min_length=1)]],
    BeforeValidator(lambda table: dict(ranged(table)) if isinstance(table, Mapping) else table),
    WithJsonSchema(
        {
            "type": "object",
            "additionalProperties": {
                "anyOf": [{"type": "array", "items": {"type": "number"}, "minItems": 1}, {"type": "object"}]
            },
        }
    ),
]


class Model(BaseModel):
    """Frozen, and closed to keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


def flattened(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables and lists as the full names of variables: "effect.name", "name[1]", "name[1,2]"."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flattened(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            if not value:
                raise BadInput(prefix + key, "an empty list", "values", "Remove it.")
            yield from ((f"{prefix}{key}[{','.join(place)}]", v) for place, v in _elements(value))
        else:
            yield prefix + key, value


def _elements(values: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Elements of nested lists, each with its indices from 1."""
    for i, value in enumerate(values, 1):
        if isinstance(value, list | tuple):
            yield from _elements(value, (*place, str(i)))
        else:
            yield (*place, str(i)), value


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= float_info.max


def ranged(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables as full names of parameters, each with its values; ranges as evenly spaced ones."""
    for key, value in table.items():
        name = prefix + key
        if not isinstance(value, Mapping):
            yield name, value
        elif not value.keys() & set(RANGE):
            yield from ranged(value, name + ".")
        else:
            first, last, points = (value.get(k) for k in RANGE)
            countable = isinstance(points, int) and 2 <= points <= MOST_POINTS
            if len(value) != 3 or not (_finite(first) and _finite(last) and first != last and countable):
                raise BadInput(name, repr(dict(value)), f"{{ from = first value, to = last value, points = 2 to {MOST_POINTS} }}")
            yield name, np.linspace(float(first), float(last), points).tolist()  # type: ignore[arg-type]
