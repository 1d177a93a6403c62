"""What a dotted name means in a scene: the one place that knows.

    "pantograph.static_force"            a variable of a unit: parameter, input or output
    "pantograph.effects.contact_loss"    an effect of a component, on or off
    "master.step", "units.road.every"    any setting, by its place in the scene's file; "units.road" is a whole unit

Names of units may hold dots, and those of variables do; see `settings.names`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple, TypeVar

from ...components.core.errors import BadInput, nearest
from ...components.core.variables import Variable
from ..settings import SceneSettings, UnitSettings
from ..settings.names import names_in, split_name
from ..units.kinds import KEYS, OF_A_KIND, UnitKind, kind_of

AnyScene = TypeVar("AnyScene", bound=SceneSettings)
TIMES = ("start_time", "stop_time", "master.step", "record.interval")  # settings that are times, s
TABLES = ("iteration.", "control.")  # of [master], with settings of their own
# of units, what a whole one does not take over from the one before
OF_ONE = {*OF_A_KIND, "preset", "effects", "parameters", "tolerances"}


class Place(NamedTuple):
    """keys: down to the setting.  unit: of one in [units].  parameter, effect: of the unit, where it is one."""

    keys: tuple[str, ...]
    unit: str = ""
    parameter: str = ""
    effect: str = ""


def is_setting(name: str) -> bool:
    """Whether it is the name of a setting outside of [units], which stands there whatever units a scene has."""
    return name.partition(".")[0] in SceneSettings.model_fields.keys() - {"units"}


def place_of(scene: SceneSettings, name: str) -> Place:
    """Where a name stands in the settings of a scene; raises `BadInput` for one that cannot be there, with the near names."""
    where = f"{scene.name}: change"
    head, _, rest = name.partition(".")
    if is_setting(name):
        return Place(tuple(name.split(".", 2 if rest.startswith(TABLES) else 1)))
    path = rest if head == "units" else name
    unit = path if head == "units" and path in scene.units else _unit_of(scene, path, scene.units, where)
    if unit not in scene.units:
        known = [f"{u}.{name}" for u in scene.units if name in declared(scene, u)]  # of a parameter without its unit
        known = known or [*scene.units, *(() if head == "units" else SceneSettings.model_fields)]
        raise BadInput(where, f"unit {unit!r}", "a unit of the scene", nearest(unit, known))
    within = path[len(unit) + 1 :]
    if head == "units":
        key, _, within = within.partition(".")
        if key and (key not in UnitSettings.model_fields or (within and key not in ("parameters", "tolerances"))):
            raise BadInput(where, repr(name), "a setting of the unit", nearest(key, UnitSettings.model_fields))
        if not within:
            return Place(("units", unit, key) if key else ("units", unit), unit)
        if key == "tolerances":
            return Place(("units", unit, key, within), unit)
    elif not within:
        raise BadInput(where, repr(name), '"unit.parameter"', f"As {f'units.{name}'!r} it is the whole unit.")
    elif within.startswith("effects.") and (cls := _kind(scene, unit).component_class) is not None:
        if (effect := within.removeprefix("effects.")) not in cls.effects:
            raise BadInput(where, repr(name), f"an effect of {unit}", nearest(effect, cls.effects))
        return Place(("units", unit, "effects"), unit, effect=effect)
    return Place(("units", unit, "parameters", within), unit, within)


def _unit_of(scene: SceneSettings, name: str, units: Collection[str], where: str) -> str:
    """The unit that a name begins with; raises `BadInput` where two have the variable, as "a" of "b.c" and "a.b" of "c"."""
    both = [u for u in units if name.startswith(f"{u}.") and name[len(u) + 1 :] in declared(scene, u)] if _nested(units) else []
    if len(both) > 1:
        ways = " or ".join(f"'units.{u}.parameters.{name[len(u) + 1 :]}'" for u in both)
        raise BadInput(where, f"{name!r}, which {' and '.join(both)} have", ways)
    return split_name(name, units)[0]


def _nested(units: Collection[str]) -> bool:
    return any(".".join(parts[:k]) in units for parts in (u.split(".") for u in units) for k in range(1, len(parts)))


def displaced(scene: AnyScene, numbers: Mapping[str, float]) -> AnyScene:
    """The scene with other numbers of parameters and inputs, which are not checked: some lie a little beyond a limit."""
    units = dict(scene.units)
    for name, value in numbers.items():
        place = place_of(scene, name)
        parameters = {**units[place.unit].parameters, place.parameter: value}
        units[place.unit] = units[place.unit].model_copy(update={"parameters": parameters})
    return scene.model_copy(update={"units": units})


def changed_settings(scene: SceneSettings, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a scene as plain data, some of them replaced by their names.

    Single effects come behind all others. One that is switched off takes its parameters with it, one that is switched on those of
    the scene that it replaces; their tolerances go, too.
    """
    data, effects = scene.settings(), []
    for name, value in changes.items():
        place = place_of(scene, name)
        if place.effect:
            effects.append((place, name, value))
        elif len(place.keys) == 2 and place.unit:
            if not isinstance(value, Mapping):
                raise BadInput(f"{scene.name}: {name}", repr(value), "a table of a unit, such as { component = ... }")
            kept = {key: v for key, v in data["units"][place.unit].items() if key not in OF_ONE}
            data["units"][place.unit] = {**kept, **value}
        else:
            _set(data, place.keys, list(value) if isinstance(value, tuple) else value, f"{scene.name}: change of {name}")
    for place, name, on in effects:
        if not isinstance(on, bool):
            raise BadInput(f"{scene.name}: {name}", repr(on), "true or false")
        table = data["units"][place.unit]
        others = [e for e in table.get("effects", ()) if e != place.effect]
        table["effects"] = [*others, place.effect] if on else others
        _drop(data, place.unit, _replaced(scene, place, changes) if on else _of_effect(place.effect))
    return data


def _of_effect(effect: str) -> Callable[[str], bool]:
    """Whether a variable is of an effect, by its name."""
    return lambda name: name.startswith(f"{effect}.")


def _replaced(scene: SceneSettings, place: Place, changes: Mapping[str, Any]) -> Callable[[str], bool]:
    """Whether effects that are switched on take the place of a parameter, which the changes do not give themselves."""
    cls = _kind(scene, place.unit).component_class
    others = {n: other for n in changes if (other := place_of(scene, n)).unit == place.unit}
    on = [other.effect for n, other in others.items() if cls and other.effect in cls.effects and changes[n] is True]
    gone = set(cls.replaced(on) if cls else ()) - {other.parameter.partition("[")[0] for other in others.values()}
    return lambda name: name.partition("[")[0] in gone


def _drop(data: dict[str, Any], unit: str, gone: Callable[[str], bool]) -> None:
    """Take away the parameters of a unit that have no part any more, with their tolerances and correlations."""
    table = data["units"][unit]
    for key in ("parameters", "tolerances"):
        if key in table:
            table[key] = {n: v for n, v in table[key].items() if not gone(n)}
    if pairs := data.get("correlations"):
        own = f"{unit}."
        data["correlations"] = {
            pair: r
            for pair, r in pairs.items()
            if not any(n.startswith(own) and gone(n.removeprefix(own)) for n in names_in(pair))
        }


def _set(data: dict[str, Any], keys: tuple[str, ...], value: Any, where: str) -> None:
    *path, last = keys
    table = data
    for key in path:
        table = table.setdefault(key, {})
        if not isinstance(table, dict):
            raise BadInput(where, repr(".".join(keys)), "the place of a setting", 'Such as "master.step".')
    if isinstance(value, list):  # an array takes the place of all its elements
        for element in [key for key in table if key.startswith(f"{last}[")]:
            del table[element]
    if last in KEYS and len(keys) == 3 and value:  # a unit of another kind takes the place of this one
        for other in OF_A_KIND:
            table.pop(other, None)
    table[last] = value


def check_effects(scene: Any, changes: Iterable[str], before: SceneSettings) -> None:
    """Refuse an effect that was switched off and that a preset has; scene: `Scene` with the changes."""
    for place, name in ((place_of(before, name), name) for name in changes):
        on = scene.coupling.interfaces[place.unit].effects[place.effect] if place.effect else ""
        if on and place.effect not in scene.units[place.unit].effects:
            raise BadInput(f"{scene.name}: {name}", "false", f"true: it is part of {on}")


def declared(scene: SceneSettings, unit: str) -> Mapping[str, Any]:
    """All variables that a unit declares, by name: `Variable` of a component, `Signal` of an FMU; none of a contact."""
    return _kind(scene, unit).variables if unit in scene.units else {}


def _kind(scene: SceneSettings, unit: str) -> UnitKind:
    return kind_of(scene.units[unit], f"units.{unit}")


def parameter_of(scene: SceneSettings, name: str) -> Variable | None:
    """The parameter of a component that a name stands for, or the array that it is an element of; None for all else."""
    place = place_of(scene, name)
    if not place.parameter or (cls := _kind(scene, place.unit).component_class) is None:
        return None
    return cls.variables.get(place.parameter) or cls.variables.get(place.parameter.partition("[")[0])


def measure_of(scene: SceneSettings, name: str) -> str:
    """Unit of measure of a setting; "" for texts, truth values and parameters of an FMU."""
    if name in TIMES:
        return "s"
    return known.unit if (known := parameter_of(scene, name)) is not None else ""


def numerical_of(scene: SceneSettings, names: Iterable[str]) -> dict[str, str]:
    """Those of some names of a scene that set the numerics, with the reason; raises `BadInput` as `place_of`."""
    places = ((n, place_of(scene, n)) for n in names)
    reasons = ((n, _kind(scene, p.unit).numerical(p.parameter)) for n, p in places if p.parameter)
    return {n: reason for n, reason in reasons if reason}


def elements(names: Iterable[str], array: str) -> list[str]:
    """The elements among some names, "array[...]", of an array."""
    return [name for name in names if name.startswith(f"{array}[")]


def variable_of(scene: Any, name: str, where: str) -> tuple[str, str]:
    """("unit", "variable") of a parameter, an input or an output of a `Scene`, or of an array of them.

    Raises `BadInput` with the near names for one that the scene does not have.
    """
    interfaces = scene.coupling.interfaces
    unit = _unit_of(scene, name, interfaces, where)
    variable = name[len(unit) + 1 :]
    if unit not in interfaces:
        raise BadInput(f"{where}: {name}", f"unit {unit!r}", "a unit of the scene", nearest(unit, interfaces))
    known = {**interfaces[unit].inputs, **interfaces[unit].outputs}
    if variable in known or variable in (known := {**known, **declared(scene, unit)}) or elements(known, variable):
        return unit, variable
    raise BadInput(where, repr(name), f"a parameter, an input or an output of {unit}", nearest(variable, known))
