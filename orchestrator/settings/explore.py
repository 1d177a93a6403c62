"""Settings of a page that computes the scene: what can be changed in it.

[explore]
effects = ["catenary.dropper_slackening"]       # switches
algorithms = ["gauss-seidel", "jacobi"]

[explore.parameters]                            # with sliders
pantograph.speed = { from = "150 km/h", to = "330 km/h" }
pantograph.static_force = {}                    # from half its value to one and a half of it

[explore.presets]                               # buttons
"300 km/h" = { pantograph.speed = "300 km/h" }
"bars, large step" = { catenary.effects.dropper_slackening = false, master.step = 4e-3 }
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from ...components.core.errors import BadInput
from .algorithms import ALGORITHMS
from .model import RANGE, Model, Number, Parameters

ENDS = RANGE[:2]


def ends(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables as full names of parameters, each with the ends of its range: both, or none for the usual one."""
    for key, value in table.items():
        name = prefix + key
        if not isinstance(value, Mapping) or not value or value.keys() & set(ENDS):
            if not isinstance(value, Mapping) or (value and set(value) != set(ENDS)):
                shown = dict(value) if isinstance(value, Mapping) else value
                raise BadInput(name, repr(shown), "{ from = least value, to = largest value }, or {} for the usual range")
            yield name, value
        else:
            yield from ends(value, name + ".")


Ranges = Annotated[
    dict[str, dict[Literal["from", "to"], Number | str]],
    BeforeValidator(lambda table: dict(ends(table)) if isinstance(table, Mapping) else table),
    WithJsonSchema({"type": "object", "additionalProperties": {"type": "object"}}),
]


class ExploreSettings(Model):
    """Read by cosimo explore."""

    parameters: Ranges | None = Field(
        default=None,
        description=(
            "unit.parameter = { from, to } of its slider, numbers or texts with their unit, or {} for half to one and a half of "
            "its value; default: the eight that move the figures most"
        ),
    )
    effects: tuple[str, ...] | None = Field(
        default=None, description="unit.effect that can be switched; default: the first three without which the scene runs"
    )
    algorithms: tuple[Literal[tuple(ALGORITHMS)], ...] | None = Field(  # type: ignore[valid-type]
        default=None,
        description="master algorithms to choose from, beside the scene's; default: Jacobi and Gauss-Seidel for up to one effect",
    )
    presets: dict[str, Parameters] = Field(
        default={},
        description=(
            'name = { "unit.parameter" = value, "unit.effects.effect" = false, "master.step" = s, "master.algorithm" = name, '
            '"master.extrapolation" = degree }'
        ),
    )
