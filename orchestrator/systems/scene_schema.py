"""The JSON schema of scene files: it knows components with effects, presets and parameters, and the keys of each system."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

from ...components.catalogue import CATALOGUE, component_class
from ...components.core.component import Component
from ...components.core.variables import Causality, Kind, Variable
from ...fmus.versions import version
from ..scene.scene import Scene
from . import KNOWN_SYSTEMS

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """The schema as plain data, for editors and other programs.

    It refuses what can be seen in a file alone: unknown keys, components, effects, presets and parameters, numbers outside of
    their limits. Connections, units of measure and what needs a look into FMUs, the run checks.
    """
    schema = Scene.model_json_schema()
    definitions: dict[str, Any] = schema["$defs"]
    unit = definitions["UnitSettings"]
    unit["properties"]["component"] |= {"anyOf": [{"enum": list(CATALOGUE)}, {"pattern": "^[^:]+:[^:]+$"}]}
    unit["allOf"] = [_where("component", name, f"component.{name}") for name in CATALOGUE]
    definitions |= {f"component.{name}": _component(component_class(name)) for name in CATALOGUE}
    analysis = schema["properties"]["analysis"]
    analysis["properties"] = {"system": {"enum": ["", *KNOWN_SYSTEMS.models], "description": "whose figures the report has"}}
    analysis["allOf"] = [_where("system", name, f"analysis.{name}") for name in KNOWN_SYSTEMS.models]
    for name, model in KNOWN_SYSTEMS.models.items():
        keys = model.model_json_schema()
        definitions |= keys.pop("$defs", {})
        definitions[f"analysis.{name}"] = keys
    return {"$schema": DIALECT, "$comment": _writer(), **schema}


def is_stale(schema: Mapping[str, Any], components: Iterable[str]) -> bool:
    """Whether a schema that was written once is of another version, or of another list of components, or says something else of
    one of these components. Cheap: of all others nothing is imported, and nothing of the scene's own tables is generated."""
    definitions = schema.get("$defs", {})
    written = [name.removeprefix("component.") for name in definitions if name.startswith("component.")]
    return (
        schema.get("$comment") != _writer()
        or written != list(CATALOGUE)
        or any(
            definitions[f"component.{name}"] != json.loads(json.dumps(_component(component_class(name))))
            for name in set(components) & CATALOGUE.keys()
        )
    )


def _writer() -> str:
    return f"written by cosimo {version('cosimo')}"


def _where(key: str, value: str, definition: str) -> dict[str, Any]:
    """What holds of a table in which a key has a value."""
    return {"if": {"properties": {key: {"const": value}}, "required": [key]}, "then": {"$ref": f"#/$defs/{definition}"}}


def _component(cls: type[Component]) -> dict[str, Any]:
    """Of the table of a unit that is this component."""
    values = [v for v in cls.own_variables if v.causality is not Causality.OUTPUT]
    groups = {n: [v for v in e.variables if v.causality is not Causality.OUTPUT] for n, e in cls.effects.items()}
    tables = {n: {"type": "object", **_values(own)} for n, own in groups.items() if own}
    flat = _values(values, tables)
    for name, own in groups.items():  # "effect.variable" in quotation marks
        flat["patternProperties"] |= _elements(own, f"{name}.") | {f"^{name}[.]{v.name}$": _value(v) for v in own}
    return {
        "description": cls.title,
        "properties": {
            "effects": {"items": {"enum": list(cls.effects)}} if cls.effects else {"maxItems": 0},
            "preset": {"enum": ["", *cls.presets]},
            "parameters": flat,
        },
    }


def _values(variables: Iterable[Variable], tables: Mapping[str, Any] | None = None) -> dict[str, Any]:
    variables = list(variables)
    return {
        "properties": {**{v.name: _value(v) for v in variables}, **(tables or {})},
        "patternProperties": _elements(variables),
        "additionalProperties": False,
    }


def _elements(variables: Iterable[Variable], prefix: str = "") -> dict[str, Any]:
    """Elements of arrays by themselves, as "name[1]"."""
    start = prefix.replace(".", "[.]")
    return {f"^{start}{v.name}\\[[0-9]+\\]$": _scalar(v) for v in variables if v.size}


def _value(variable: Variable) -> dict[str, Any]:
    text = f"{variable.text}{f', {variable.unit}' if variable.unit != '1' else ''}"
    scalar = _scalar(variable)
    if variable.size:
        return {"description": text, "type": "array", "items": scalar, "maxItems": variable.size}
    return {"description": text, "default": variable.start, **scalar}


def _scalar(variable: Variable) -> dict[str, Any]:
    if variable.kind is Kind.CHOICE:
        return {"enum": list(variable.choices)}
    if variable.kind is Kind.TEXT:
        return {"type": "string"}
    limits = {"minimum": variable.low, "maximum": variable.high}
    written = {"type": ["number", "string"], "pattern": r"^\s*[+-]?[0-9.]"}  # "250 km/h"
    return {
        **(written if variable.kind is Kind.REAL else {"type": "integer"}),
        **{key: value for key, value in limits.items() if isfinite(value)},
    }
