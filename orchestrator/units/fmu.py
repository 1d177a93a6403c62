"""An FMU of FMI 2.0 or 3.0 as a unit: its `Interface` and its simulator, from model description and scene's entry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...components.core.errors import BadInput, nearest
from ...components.core.measure import BASES, parse
from ...components.core.measure import Unit as Measure
from ...fmus.description import MOVING
from .description import NEITHER, Description, Scalar, has_companions, is_companion, read
from .interface import Interface, Signal, Span
from .values import checked_values, members

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

    from ..settings import UnitSettings
    from .fmu_simulator import FmuSimulator

RECORDABLE = ("local", "calculatedParameter")  # causalities of variables that are computed and are no outputs


def describe_fmu(name: str, settings: UnitSettings) -> Interface:
    """The interface an FMU's model description gives, with the scene's effects and parameters checked against it."""
    where = f"units.{name}"
    description = read(settings.fmu, f"{where}.fmu").chosen(settings, where).sized(settings.parameters, where)
    known = [n.removeprefix("effects.") for n in description.scalars if n.startswith("effects.")]
    for effect in settings.effects:
        if effect not in known:
            raise BadInput(f"{where}.effects", repr(effect), "an effect of the FMU", nearest(effect, known))
    off = [e for e in known if e not in settings.effects and not description.scalars[f"effects.{e}"].start]
    checked_values(description, settings, where, off)
    named = dict.fromkeys(settings.effects, "named in the scene")
    there = {n: s for n, s in description.scalars.items() if n.partition(".")[0] not in off}
    direct = {u.variable.name: u.dependencies for u in description.model.outputs}
    measures = _measures(description.model)
    inputs = {
        n: _signal(s, (), measures)
        for n, s in there.items()
        if s.variable.causality == "input" and not is_companion(n, description.scalars)
    }
    real = [n for n, s in inputs.items() if s.kind == "real"]
    return Interface(
        title=description.model.description or description.model.modelName,
        inputs=inputs,
        outputs={
            n: _signal(s, _depends(direct.get((s.variable.alias or s.variable).name), inputs, there), measures)
            for n, s in there.items()
            if s.variable.causality == "output"
        },
        effects={e: "" if e in off else named.get(e, "on by the FMU's default") for e in known},
        set_inputs=frozenset(settings.parameters) & frozenset(inputs),
        recordable={n: _signal(s, (), measures) for n, s in there.items() if s.variable.causality in RECORDABLE},
        arrays=_arrays(there),
        terminals=description.terminals,
        remarks=_clock_remarks(description.model),
        foreign=not description.holds_component,
        refused={v.name: v.type for v in description.model.modelVariables if v.type in NEITHER},
        **_capabilities(description, real),
    )


def _clock_remarks(model: ModelDescription) -> tuple[str, ...]:
    """That the clocks which an importer has to trigger are not triggered; none where there are none."""
    clocks = [v.name for v in model.modelVariables if v.type == "Clock" and v.causality == "input"]
    if not clocks:
        return ()
    return (
        f"clock{'s' * (len(clocks) > 1)} {', '.join(clocks)} of the FMU: nothing triggers, so that what they drive stands still",
    )


def declared_signals(path: str, where: str) -> dict[str, Signal]:
    """All variables of an FMU with their units of measure, elements of arrays by their own names."""
    description = read(path, where)
    measures = _measures(description.model)
    return {name: _signal(scalar, (), measures) for name, scalar in description.scalars.items()}


def declared_parameters(path: str, where: str) -> dict[str, Signal]:
    """Those of the variables of an FMU that are parameters, and none that only sizes of arrays follow from."""
    scalars, signals = read(path, where).scalars, declared_signals(path, where)
    return {name: signal for name, signal in signals.items() if scalars[name].variable.causality == "parameter"}


def _arrays(scalars: Mapping[str, Scalar]) -> dict[str, tuple[str, ...]]:
    """Elements of each array that is an output or may be recorded."""
    arrays: dict[str, tuple[str, ...]] = {}
    for name, scalar in scalars.items():
        if scalar.variable.causality in ("output", *RECORDABLE) and scalar.variable.dimensions:
            arrays[scalar.variable.name] = (*arrays.get(scalar.variable.name, ()), name)
    return arrays


def _capabilities(description: Description, inputs: Sequence[str]) -> dict[str, Any]:
    """What the FMU can beyond a step, as fields of `Interface`; `inputs`: the real ones."""
    interface: Any = description.interface
    saves = interface.canGetAndSetFMUstate
    shared = {
        "saves_state": saves,
        "packs_state": saves and interface.canSerializeFMUstate,
        "gives_jacobian": description.directional,
    }
    if description.exchange:  # inputs are evaluated wherever the solver looks, and every event is seen
        return shared | {"may_return_early": True}
    follow = bool(inputs) and set(inputs) <= description.requested
    return shared | {
        "input_degree": 2 if description.interpolates or has_companions(description.scalars, inputs) or follow else 0,
        "variable_step": interface.canHandleVariableCommunicationStepSize,
        "fixed_step": float(interface.fixedInternalStepSize or 0.0),
        "may_return_early": interface.hasEventMode or interface.mightReturnEarlyFromDoStep,
    }


def _measures(model: ModelDescription) -> dict[str, Measure]:
    """Units of measure that the FMU defines because nobody else does."""
    measures = {}
    for unit in model.unitDefinitions:
        if unit.name is None:
            continue
        try:
            parse(unit.name)
        except (BadInput, ArithmeticError, ValueError):  # a power beyond the range of numbers
            if (base := unit.baseUnit) is not None:
                measures[unit.name] = Measure(base.factor, base.offset, tuple(getattr(base, name) for name in BASES))
    return measures


def _signal(s: Scalar, feedthrough: tuple[str, ...] | None, measures: Mapping[str, Measure]) -> Signal:
    declared, kind, unit = s.variable.declaredType, s.kind, s.unit
    start = (s.start or "") if kind in ("string", "binary") else float(s.start or 0)
    moving = declared is not None and declared.name == MOVING
    return Signal(
        s.name, unit, start, s.nominal, feedthrough, kind, s.discrete, moving, s.relative, members(s), measures.get(unit)
    )


def _depends(
    declared: Sequence[ModelVariable] | None, inputs: Mapping[str, Signal], scalars: Mapping[str, Scalar]
) -> tuple[str, ...] | None:
    """Names of inputs that are, or are elements of, declared variables."""
    if declared is None:
        return None
    references = {(v.type, v.valueReference) for v in declared}
    return tuple(n for n in inputs for v in [scalars[n].variable] if (v.type, v.valueReference) in references)


def open_fmu(name: str, settings: UnitSettings, span: Span) -> FmuSimulator:
    """The running FMU of a scene's entry; a component of the catalogue is built first if the cache has no FMU of it."""
    where = f"units.{name}"
    if settings.fmu:
        description = read(settings.fmu, f"{where}.fmu").chosen(settings, where).sized(settings.parameters, where)
        given: dict[str, Any] = {f"effects.{e}": True for e in settings.effects}
        given |= checked_values(description, settings, where)
        tolerance = settings.tolerance or description.tolerance
        if description.exchange:
            from .model_exchange import Fmi2ModelExchange, Fmi3ModelExchange

            exchange = Fmi3ModelExchange if description.fmi3 else Fmi2ModelExchange
            return exchange(name, description, given, tolerance, settings.solver or "CVode", span)
        return _class(description)(name, description, given, tolerance, None, span)
    from ...fmus.build import built
    from .component import make

    component = make(name, settings)
    starts = dict(zip(component.inputs, component.u[0].tolist(), strict=True))
    given = {f"effects.{e}": e in component.on for e in component.effects} | component.parameters | starts
    description = read(str(built(settings.component)), where)
    return _class(description)(name, description, given, None, component, span)


def _class(description: Any) -> type[FmuSimulator]:
    if description.fmi3:
        from .fmi3 import Fmi3CoSimulation

        return Fmi3CoSimulation
    from .fmi2 import Fmi2CoSimulation

    return Fmi2CoSimulation


__all__ = ["describe_fmu", "open_fmu"]
