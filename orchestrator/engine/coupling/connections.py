"""From the connections of a scene to its links: which variables they mean, and what becomes of a value on its way."""

from __future__ import annotations

from collections.abc import Mapping

from ....components.core.errors import BadInput, nearest
from ....components.core.measure import conversion
from ...settings import ConnectionSettings, SceneSettings
from ...settings.names import ARROW, JOINED, TABLE_FORM, Reading, readings, split_name
from ...units import Interface
from ...units.interface import Signal
from .arrays import elements, shape_of
from .contacts import connections
from .graph import Endpoint, Link
from .maps import mapped
from .ports import port_pairs

SHOWN_CHARACTERS = 100  # of a unit of measure
FORMS = '"unit.output -> unit.input", "unit.port <-> unit.port", or "unit.* -> unit.*" for all of the same name'
FACTOR = "Or give the factor, and an offset, yourself: { source = ..., target = ..., factor = ... }."


def endpoint(text: str, where: str, interfaces: Mapping[str, Interface]) -> Endpoint:
    """Unit and variable of "unit.variable", see `settings.names`."""
    unit, variable = split_name(text, interfaces)
    if not variable:
        raise BadInput(where, repr(text), '"unit.variable"')
    if unit not in interfaces:
        raise BadInput(where, f"unit {unit!r}", "a unit of the scene", nearest(unit, interfaces))
    return unit, variable


def links_of(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> tuple[Link, ...]:
    """The links of all connections and contacts; raises `BadInput` for names, kinds and units of measure that do not fit."""
    links: dict[Endpoint, Link] = {}
    named = [(f"connection {c if isinstance(c, str) else c.text!r}", c) for c in scene.connections]
    named += [item for contact in scene.contacts for item in connections(contact).items()]
    for where, connection in named:
        for source, target in _pairs(connection, where, interfaces):
            outputs, inputs = interfaces[source[0]].outputs, interfaces[target[0]].inputs
            if source[1] not in outputs:
                raise no_variable(where, source, "output", interfaces)
            if target[1] not in inputs:
                raise no_variable(where, target, "input", interfaces)
            if target in links:
                raise BadInput(
                    where,
                    f"input {'.'.join(target)} driven a second time",
                    f"one source; {'.'.join(links[target].source)} drives it already",
                )
            if target[1] in interfaces[target[0]].set_inputs:
                raise BadInput(
                    f"units.{target[0]}.parameters",
                    f"the value of input {target[1]!r} has no effect, as a connection drives it",
                    "",
                    "Remove one of them.",
                )
            ends = outputs[source[1]], inputs[target[1]]
            pairs = mapped(connection, *ends, where)
            links[target] = Link(source, target, *((0.0, 0.0) if pairs else _transformation(connection, *ends, where)), pairs)
    return tuple(links.values())


def _transformation(connection: str | ConnectionSettings, source: Signal, target: Signal, where: str) -> tuple[float, float]:
    """(factor, offset) from the output's number to the input's; raises `BadInput` for kinds or units that do not fit."""
    own = connection if isinstance(connection, ConnectionSettings) else None
    if source.kind != target.kind and (source.kind, target.kind) not in WIDENING:
        raise BadInput(
            where,
            f"a {source.kind} output for {_article(target.kind)} input",
            "the same kind at both ends",
            "Only whole numbers become real ones by themselves.",
        )
    if own is not None and (own.factor, own.offset) != (1.0, 0.0) and target.kind not in ("real", "integer"):
        raise BadInput(where, f"factor and offset have no effect on {_article(target.kind)} input", "", "Remove them.")
    factor, offset = 1.0, 0.0
    if source.unit and target.unit and (own is None or own.convert_units):
        try:
            factor, offset = _conversion(source, target, own is not None and own.scales, where)
        except (ArithmeticError, ValueError) as error:  # a power beyond the range of numbers
            if isinstance(error, BadInput):
                raise
            raise BadInput(
                where,
                f"units {source.unit[:SHOWN_CHARACTERS]!r} and {target.unit[:SHOWN_CHARACTERS]!r} ({type(error).__name__})",
                "units of measure whose factors are numbers",
            ) from None
    if target.kind != "real" and (factor, offset) != (1.0, 0.0):
        raise BadInput(where, f"{source.unit!r} for {target.unit!r} in whole numbers", "the same unit at both ends")
    return (factor, offset) if own is None else (own.factor * factor, own.factor * offset + own.offset)


def _conversion(source: Signal, target: Signal, scaled: bool, where: str) -> tuple[float, float]:
    """(factor, offset) between units of measure. `scaled`: the user gives factor and offset, which settle what is not defined."""
    try:
        factor, offset = conversion(
            source.unit, target.unit, where, (source.measure, target.measure), source.relative and target.relative
        )
    except BadInput as error:
        if scaled:
            return 1.0, 0.0
        raise BadInput(where, error.actual, error.expected, f"{error.remedy} {FACTOR}".strip()) from None
    if offset and source.relative != target.relative:
        if not scaled:
            kinds = [f"a {'difference' if s.relative else 'value'} in {s.unit!r}" for s in (source, target)]
            raise BadInput(where, " for ".join(kinds), "two differences, or none: only these have a common zero", FACTOR)
        return factor, 0.0
    return factor, offset


WIDENING = {("integer", "real"), ("boolean", "integer"), ("enumeration", "integer"), ("integer", "enumeration")}


def _article(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def expanded_connection(text: str, interfaces: Mapping[str, Interface]) -> list[tuple[Endpoint, Endpoint]]:
    """(source, target) of all that one connection of a scene stands for."""
    return _pairs(text, f"connection {text!r}", interfaces)


def _pairs(
    connection: str | ConnectionSettings, where: str, interfaces: Mapping[str, Interface]
) -> list[tuple[Endpoint, Endpoint]]:
    """(source, target) of one connection, of joined ports, of arrays element by element, or with * at both ends of all that agree
    in what stands for it. A text is read in the one way in which there are such variables."""
    if not isinstance(connection, str):
        reading = Reading(ARROW, connection.source, connection.target)
        exact = _meant(reading, where, interfaces, False) or _meant(reading, where, interfaces, True)
        return exact or _pairs_or_why_not(reading, where, interfaces)
    meanings: dict[tuple[tuple[Endpoint, Endpoint], ...], None] = {}
    for reading in readings(connection, interfaces):
        for starred in (False, True):
            if pairs := _meant(reading, where, interfaces, starred):
                meanings[tuple(pairs)] = None
    if len(meanings) > 1:
        ways = " or ".join(", ".join(f"{'.'.join(s)!r} to {'.'.join(t)!r}" for s, t in pairs[:2]) for pairs in meanings)
        raise BadInput(where, f"a text that means {ways}", "one meaning", TABLE_FORM)
    if meanings:
        return list(next(iter(meanings)))
    arrow = JOINED if JOINED in connection else ARROW
    ends = [end.strip() for end in connection.split(arrow)]
    stars = [end.endswith("*") for end in ends]
    if len(ends) != 2 or not all("." in end for end in ends) or stars[0] != stars[1] or (arrow == JOINED and any(stars)):
        raise BadInput("connections", repr(connection), FORMS, TABLE_FORM if len(ends) > 2 else "")
    return _pairs_or_why_not(Reading(arrow, *ends), where, interfaces)


def _meant(reading: Reading, where: str, interfaces: Mapping[str, Interface], starred: bool) -> list[tuple[Endpoint, Endpoint]]:
    """What one reading of a connection stands for; nothing where there are no such variables. `starred`: by * at both ends."""
    source, target = (split_name(end, interfaces) for end in reading[1:])
    if source[0] == target[0] or not {source[0], target[0]} <= interfaces.keys():
        return []
    outputs, inputs = interfaces[source[0]].outputs, interfaces[target[0]].inputs
    if reading.arrow == JOINED:
        try:
            return [] if starred else port_pairs((source, target), where, interfaces)
        except BadInput:  # told by `_pairs_or_why_not` where nothing else is meant
            return []
    if not starred:
        if source[1] in outputs and target[1] in inputs:
            return [(source, target)]
        of_source, of_target = elements(source[1], outputs), elements(target[1], inputs)
        same = of_source.keys() == of_target.keys()
        return [((source[0], n), (target[0], of_target[at])) for at, n in of_source.items()] if same else []
    if not (source[1].endswith("*") and target[1].endswith("*")):
        return []
    before, after = source[1][:-1], target[1][:-1]
    rests = [n.removeprefix(before) for n in outputs if n.startswith(before)]
    return [((source[0], before + r), (target[0], after + r)) for r in rests if after + r in inputs]


def _pairs_or_why_not(reading: Reading, where: str, interfaces: Mapping[str, Interface]) -> list[tuple[Endpoint, Endpoint]]:
    """Of a connection in which nothing is meant that there is: raises `BadInput` with the reason."""
    source, target = (endpoint(end, where, interfaces) for end in reading[1:])
    if source[0] == target[0]:
        raise BadInput(where, f"unit {source[0]!r} twice", "two units", "Close such a loop inside the unit.")
    if reading.arrow == JOINED:
        return port_pairs((source, target), where, interfaces)
    outputs, inputs = interfaces[source[0]].outputs, interfaces[target[0]].inputs
    if source[1].endswith("*") and target[1].endswith("*"):
        before, after = source[1][:-1], target[1][:-1]
        gives = [n.removeprefix(before) for n in outputs if n.startswith(before)]
        takes = [n for n in inputs if n.startswith(after)]
        raise BadInput(
            where,
            f"outputs {', '.join(gives) or 'of no name'} and inputs {', '.join(takes) or 'of no name'}",
            "at least one name on both sides",
            "Switch on the effect that has them, or name the variables.",
        )
    shapes = [shape_of(name, of) for (_, name), of in ((source, outputs), (target, inputs))]
    if all(shapes) and shapes != ["()", "()"]:
        raise BadInput(
            where,
            f"{'.'.join(source)} of shape {shapes[0]} for {'.'.join(target)} of shape {shapes[1]}",
            "arrays of the same shape",
            "Or connect single elements, by their names.",
        )
    return [(source, target)]


def no_variable(where: str, end: Endpoint, wished: str, interfaces: Mapping[str, Interface]) -> BadInput:
    """The message for a variable that a unit does not have. wished: "input" or "output"."""
    unit, name = end
    interface = interfaces[unit]
    here, there = (interface.outputs, interface.inputs) if wished == "output" else (interface.inputs, interface.outputs)
    effect = name.partition(".")[0]
    if name in interface.refused:
        return BadInput(where, f"{'.'.join(end)}, {_article(interface.refused[name])}", "a number, a truth value or a text")
    if name in there:
        remedy = "A connection goes from an output to an input."
    elif effect in interface.effects and not interface.effects[effect]:
        remedy = f"Switch on the effect {effect!r} if it belongs to it."
    else:
        remedy = nearest(name, here)
    return BadInput(where, f"{'.'.join(end)}", f"an {wished} of {unit}", remedy)
