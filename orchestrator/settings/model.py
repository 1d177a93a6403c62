"""What all tables of a scene share: frozen, closed models and the types of their numbers."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema

Seconds = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
Truth = Annotated[bool, Field(strict=True)]
Whole = Annotated[int, Field(gt=-(2**64), lt=2**64)]  # what the widest types of an FMU hold
UNIT_NAME = r"^[A-Za-z]\w*(\.[A-Za-z]\w*)*$"  # "subsystem.unit" for the units of an included scene
Value = bool | Whole | float | str
# by full names; a file may also have them in nested tables and lists, which become full names before they are checked
Parameters = Annotated[
    dict[str, Value],
    WithJsonSchema({"type": "object", "additionalProperties": {"type": ["boolean", "number", "string", "array", "object"]}}),
]
Sweep = Annotated[
    dict[str, Annotated[tuple[Number, ...], Field(min_length=1)]],
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
