"""Mistakes in the declarations of a class, with file and line: what would else show as a traceback, late, or not at all."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

from .component import Component, Effect
from .errors import BadInput, nearest
from .variables import MESHES, Causality, Kind, Variable


def check_declaration(cls: type[Component]) -> None:
    """Raises `BadInput` with file and line for the first declaration of a class that cannot be meant."""
    for name, expected, actual, remedy in _mistakes(cls):
        raise BadInput(place_of(cls, name), actual, expected, remedy)


def _mistakes(cls: type[Component]) -> Iterator[tuple[str, str, str, str]]:
    """(declared name, what was expected, what is there, what to do)."""
    inputs = {n for n, v in cls.variables.items() if v.causality is Causality.INPUT}
    declared = [(v, v.name, "") for v in cls.own_variables]
    declared += [(v, f"{e}.{v.name}", e) for e, effect in cls.effects.items() for v in effect.variables]
    for variable, name, effect in declared:
        yield from _of_variable(variable, name)
        known = {*inputs, *(n.partition("[")[0] for n in inputs), *(n.removeprefix(effect) for n in inputs if effect)}
        for fed in variable.feedthrough:
            if fed not in known:
                yield name, "an input of the class", f"feedthrough of {fed!r}", nearest(fed, sorted(known))
        if not effect and callable(getattr(Component, variable.name, None)):
            yield name, "a name that no method of Component has", f"variable {name!r}", "Give it another name."
    for name, effect_class in cls.effects.items():
        for other in (*effect_class.requires, *effect_class.excludes):
            if other not in cls.effects or other == name:
                yield name, "another effect of the class", f"effect {name!r} with {other!r}", nearest(other, cls.effects)
        own = [v.name for v in cls.own_variables if v.causality is Causality.PARAMETER]
        required = [f"{other}.{v.name}" for other in effect_class.requires for v in cls.effects[other].variables]
        gone = [n for other in effect_class.requires for n in cls.effects[other].replaces]
        for other in effect_class.restores:
            if other not in gone:
                yield (
                    name,
                    "a parameter that a required effect replaces",
                    f"effect {name!r} restores {other!r}",
                    nearest(other, gone),
                )
        for other in effect_class.replaces:
            if other not in (*own, *required):
                yield name, "a parameter of the class", f"effect {name!r} in the place of {other!r}", nearest(other, own)
    for name, preset in cls.presets.items():
        for effect in preset.effects:
            if effect not in cls.effects:
                yield "presets", "an effect of the class", f"preset {name!r} with effect {effect!r}", nearest(effect, cls.effects)
        for variable_name, value in preset.parameters.items():
            if variable_name not in cls.variables:
                yield (
                    "presets",
                    "a parameter of the class",
                    f"preset {name!r} with {variable_name!r}",
                    nearest(variable_name, cls.variables),
                )
                continue
            try:
                cls.variables[variable_name].checked(value, "")
            except BadInput as error:
                yield "presets", error.expected, f"preset {name!r} with {error.actual}", error.remedy


def _of_variable(variable: Variable, name: str) -> Iterator[tuple[str, str, str, str]]:
    if variable.mesh and (
        variable.mesh not in MESHES
        or variable.causality is not Causality.PARAMETER
        or variable.size
        or variable.kind.value == "text"
    ):
        yield (
            name,
            f"mesh = one of {', '.join(MESHES)}, of a number that is a parameter",
            f"{name} with mesh={variable.mesh!r}",
            "",
        )
        return
    if isinstance(variable.start, tuple) and len(variable.start) != variable.size:
        yield name, f"size={len(variable.start)}", f"{name} with {len(variable.start)} start values and size={variable.size}", ""
        return
    if not variable.low <= variable.high:
        yield name, "low at or below high", f"{name} with low={variable.low:g}, high={variable.high:g}", ""
        return
    for scalar in variable.scalars:
        try:
            if variable.causality is not Causality.OUTPUT or variable.kind is not Kind.REAL:
                scalar.checked(scalar.start, "")
        except BadInput as error:
            yield name, error.expected, f"{name} that starts at {scalar.start!r}", "A start value lies within its own limits."
            return


def place_of(cls: type, name: str = "") -> str:
    """ "file:line: Class.name" of a declaration, of an effect's variable as "effect.name"; without a line of what has no file."""
    owner, attribute = cls, name.partition("[")[0]
    effect, dot, variable = attribute.partition(".")
    if dot and isinstance(inner := getattr(cls, effect, None), type) and issubclass(inner, Effect):
        owner, attribute = inner, variable
    for base in owner.__mro__:
        if not attribute or attribute in vars(base):
            owner = base
            break
    label = f"{owner.__name__}.{attribute}" if attribute else owner.__name__
    try:
        file = inspect.getfile(owner)
    except (TypeError, OSError):
        return label
    return f"{file}:{line_of(Path(file), owner.__name__, attribute)}: {label}"


def line_of(file: Path, owner: str, attribute: str) -> int:
    """The line where an attribute of a class is assigned; of the class where that is not seen, or 1."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return 1
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name == owner:
            for statement in node.body:
                targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
                if any(isinstance(t, ast.Name) and t.id == attribute for t in targets):
                    return statement.lineno
            return node.lineno
    return 1
