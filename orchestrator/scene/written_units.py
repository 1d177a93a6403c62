"""Numbers with their units in a scene, "250 km/h", as the numbers that units of the scene take: SI, or the unit of an FMU."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

import numpy as np

from ...components.core.columns import name_and_unit
from ...components.core.errors import BadInput, nearest
from ...components.core.measure import conversion_of, is_quantity, number_in, plain, refuse_mixed
from ...components.core.variables import Causality, Kind
from ..settings.model import flattened
from ..settings.names import split_name
from ..units.kinds import UnitKind, kind_of_entry
from .names import TIMES, declared, place_of


def with_numbers(data: Mapping[str, Any], scene: str) -> Mapping[str, Any]:
    """The data of a scene with numbers in the place of texts such as "250 km/h" among the parameters of its units.

    Raises `BadInput` for a unit of another dimension. What is no such text stays as it is, and is checked with the scene.
    """
    if not isinstance(units := data.get("units"), Mapping):
        return data
    changed = {"units": {name: _unit(unit, f"{scene}: units.{name}") for name, unit in units.items()}}
    if isinstance(axes := data.get("sweep"), Mapping):
        changed["sweep"] = axes_with_numbers(axes, units, f"{scene}: sweep")
    if isinstance(study := data.get("study"), Mapping) and isinstance(axes := study.get("stability"), Mapping):
        changed["study"] = {**study, "stability": axes_with_numbers(axes, units, f"{scene}: study.stability")}
    changed["units"] = {name: _with_tolerances(unit, f"{scene}: units.{name}") for name, unit in changed["units"].items()}
    return {**data, **changed}


def _with_tolerances(unit: Any, where: str) -> Any:
    """A unit with its tolerances as numbers in the units of the parameters; a share stays a text, "3 %"."""
    given = unit.get("tolerances") if isinstance(unit, Mapping) else None
    if not isinstance(given, Mapping) or not given:
        return unit
    if (kind := kind_of_entry(unit, where)) is None:
        return unit
    return {**unit, "tolerances": {n: tolerance_of(kind, n, t, f"{where}.tolerances.{n}") for n, t in flattened(given)}}


def tolerance_of(kind: UnitKind, name: str, tolerance: Any, where: str) -> float | str:
    """That of a parameter of a unit: a number in its unit, or a share as it is written. Raises `BadInput`."""
    variable = (known := kind.parameters).get(name)
    if variable is None:
        raise BadInput(where, repr(name), "a parameter", nearest(name, known))
    real = variable.kind in (Kind.REAL, Kind.REAL.value)
    parameter = getattr(variable, "causality", Causality.PARAMETER) is Causality.PARAMETER
    structural, numbers = getattr(variable, "structural", ""), kind.numerical(name)  # why
    if not real or not parameter or structural or numbers:
        reason = numbers or structural or "nothing has a derivative by it"
        raise BadInput(where, f"{name}: {reason}", "a real parameter that is not structural", "Remove it.")
    number = tolerance
    if is_quantity(tolerance):
        share = tolerance.strip().endswith("%")
        measure = getattr(variable, "measure", None)
        number = number_in(tolerance, "1", where) if share else number_in(tolerance, variable.unit or "1", where, measure, True)
    if isinstance(number, bool) or not isinstance(number, int | float) or not 0.0 <= number < inf:
        raise BadInput(
            where, repr(tolerance), f'a standard deviation of at least 0, in {variable.unit or "its unit"} or as "3 %"'
        )
    return tolerance if isinstance(tolerance, str) and tolerance.strip().endswith("%") else float(number)


def axes_with_numbers(axes: Mapping[str, Any], units: Mapping[str, Any], where: str, prefix: str = "") -> dict[str, Any]:
    """What varies, by "unit.parameter" or in nested tables, with numbers in the place of texts such as "250 km/h": in lists, in
    ranges and in distributions. units: the table [units] of the scene. Raises `BadInput` for a unit of another dimension."""
    changed: dict[str, Any] = {}
    for key, value in axes.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping) and all(isinstance(v, Mapping | list | tuple) for v in value.values()):
            changed[key] = axes_with_numbers(value, units, where, f"{name}.")
        elif isinstance(value, Mapping) and _has_quantity(value):
            changed[key] = {k: _in_axis(name, v, units, where) for k, v in value.items()}
            own = [k for k in value if k != "points"]
            refuse_mixed([value[k] for k in own], [changed[key][k] for k in own], f"{where}: {name}")
        elif isinstance(value, list | tuple) and any(map(is_quantity, value)):
            changed[key] = [_in_axis(name, v, units, where) for v in value]
            refuse_mixed(value, changed[key], f"{where}: {name}")
        else:
            changed[key] = value
    return changed


def _in_axis(name: str, value: Any, units: Mapping[str, Any], where: str) -> Any:
    """A value that varies, as a number where it is a text with its unit."""
    if not is_quantity(value):
        return value
    plain = name.removeprefix("units.")
    unit, rest = split_name(plain, units)
    if unit not in units or not rest:
        return number_in(value, "s", f"{where}: {name}") if name in TIMES else value
    kind = kind_of_entry(units[unit], f"{where}: {unit}")
    return value if kind is None else kind.number_of(rest.removeprefix("parameters."), value)


def _unit(unit: Any, where: str) -> Any:
    parameters = unit.get("parameters") if isinstance(unit, Mapping) else None
    if not isinstance(parameters, Mapping) or not _has_quantity(parameters):
        return unit
    kind = kind_of_entry(unit, where)
    return unit if kind is None else {**unit, "parameters": _converted(parameters, "", kind)}


def _has_quantity(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_quantity, value.values()))
    return any(map(_has_quantity, value)) if isinstance(value, list | tuple) else is_quantity(value)


def _converted(value: Any, name: str, kind: UnitKind) -> Any:
    """A parameter, or a table or list of them, with numbers in the place of texts."""
    if isinstance(value, Mapping):
        return {key: _converted(inner, f"{name}.{key}" if name else str(key), kind) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        numbers = [_converted(inner, name, kind) for inner in value]
        refuse_mixed(value, numbers, name)
        return numbers
    return kind.number_of(name, value) if is_quantity(value) else value


def scaled_names(scene: Any, texts: Iterable[str], where: str) -> tuple[tuple[str, ...], np.ndarray]:
    """(names as a `Scene` has them, (2, n) factors and offsets to its units from those behind the names, "unit.variable [km/h]").

    Raises `BadInput` for a unit of another dimension, and for a name that comes twice.
    """
    names, scales = [], []
    for text in texts:
        name, unit = name_and_unit(text)
        place = place_of(scene, name)
        variable = declared(scene, place.unit).get(place.parameter.partition("[")[0]) if place.parameter else None
        own = "s" if name in TIMES else getattr(variable, "unit", "")
        if unit and not own:
            raise BadInput(f"{where}: {text}", f"unit {unit!r}", f"a name alone, as the unit of {name} is not known")
        names.append(name)
        scales.append(conversion_of(plain(unit), own, f"{where}: {text}", repr(unit)) if unit else (1.0, 0.0))
    if len(set(names)) < len(names):
        raise BadInput(where, ", ".join(names), "each name once")
    return tuple(names), np.array(scales).reshape(-1, 2).T
