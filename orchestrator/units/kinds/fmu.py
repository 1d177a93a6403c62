"""An FMU of FMI 2.0 or 3.0, for co-simulation or model exchange, by its model description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....components.core.errors import BadInput, nearest
from ....components.core.measure import BASES, number_in, parse
from ....components.core.measure import Unit as Measure
from ....components.core.store import digest_of
from ....fmus.description import MOVING
from ..description import NEITHER, Description, Scalar, has_companions, is_companion, read
from ..interface import Interface, Signal, Simulator, Span
from ..values import checked_values, members
from .kind import UnitKind

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

    from ..fmu_simulator import FmuSimulator

RECORDABLE = ("local", "calculatedParameter")  # causalities of variables that are computed and are no outputs


class FmuKind(UnitKind):
    """An FMU that a scene names by its path."""

    key = "fmu"
    is_file = True
    suffixes = (".fmu",)
    foreign = True
    outside = "an FMU"

    def _chosen(self) -> Description:
        """The description by the interface and the sizes of arrays that the scene asks for."""
        settings = self.settings
        return read(self.value, f"{self.where}.fmu").chosen(settings, self.where).sized(settings.parameters, self.where)

    def describe(self, name: str) -> Interface:
        settings, where, description = self.settings, self.where, self._chosen()
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

    def made_ready(self) -> FmuKind:
        from ..fmu_sources import with_library

        path = with_library(self._chosen(), f"{self.where}.fmu")
        return self if path == self.value else FmuKind(self.settings.model_copy(update={"fmu": path}), self.where)

    def open(self, name: str, in_process: bool, span: Span) -> Simulator:
        description, settings = self._chosen(), self.settings
        given: dict[str, Any] = {f"effects.{e}": True for e in settings.effects}
        given |= checked_values(description, settings, self.where)
        tolerance = settings.tolerance or description.tolerance
        if description.exchange:
            from ..model_exchange import Fmi2ModelExchange, Fmi3ModelExchange

            exchange = Fmi3ModelExchange if description.fmi3 else Fmi2ModelExchange
            return exchange(name, description, given, tolerance, settings.solver or "CVode", span)
        return simulator_class(description)(name, description, given, tolerance, None, span)

    @property
    def variables(self) -> Mapping[str, Signal]:
        """With units of measure, elements of arrays by their own names."""
        description = read(self.value, f"{self.where}.fmu")
        measures = _measures(description.model)
        return {name: _signal(scalar, (), measures) for name, scalar in description.scalars.items()}

    @property
    def parameters(self) -> Mapping[str, Signal]:
        """But those that only sizes of arrays follow from."""
        scalars = read(self.value, self.where).scalars
        return {name: v for name, v in self.variables.items() if scalars[name].variable.causality == "parameter"}

    def parameter_names(self) -> set[str]:
        return {v.name for v in read(self.value, "fmu").model.modelVariables}

    def number_of(self, parameter: str, text: str) -> Any:
        declared, where = self.variables, f"{self.where}.parameters.{parameter}"
        signal = declared.get(parameter) or declared.get(f"{parameter}[1]")
        if signal is None or signal.kind != "real":
            return text
        if not signal.unit:
            raise BadInput(where, repr(text), "a number alone, as the FMU does not say in which unit it is")
        return number_in(text, signal.unit, where, signal.measure, signal.relative)

    def contents(self, entry: dict[str, Any]) -> dict[str, Any]:
        return {**super().contents(entry), "fmu": digest_of(self.fmu_file().read_bytes())}

    def fmu_file(self) -> Path:
        return Path(self.value)

    def fmu_values(self, name: str) -> dict[str, Any]:
        return {**{f"effects.{e}": True for e in self.settings.effects}, **self.settings.parameters}


def simulator_class(description: Description) -> type[FmuSimulator]:
    """The simulator of an FMU for co-simulation."""
    if description.fmi3:
        from ..fmi3 import Fmi3CoSimulation

        return Fmi3CoSimulation
    from ..fmi2 import Fmi2CoSimulation

    return Fmi2CoSimulation


def _clock_remarks(model: ModelDescription) -> tuple[str, ...]:
    """That the clocks which an importer has to trigger are not triggered; none where there are none."""
    clocks = [v.name for v in model.modelVariables if v.type == "Clock" and v.causality == "input"]
    if not clocks:
        return ()
    return (
        f"clock{'s' * (len(clocks) > 1)} {', '.join(clocks)} of the FMU: nothing triggers, so that what they drive stands still",
    )


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
