"""A component: in this process, or as the FMU that pythonfmu makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from ....components.catalogue import component_class
from ....components.core.component import Component
from ....components.core.variables import Kind as VariableKind
from ....components.core.variables import Variable
from ..interface import Interface, Kind, Signal, Simulator, Span
from .kind import UnitKind

SIGNAL_KINDS: dict[VariableKind, Kind] = {
    VariableKind.REAL: "real",
    VariableKind.INTEGER: "integer",
    VariableKind.BOOLEAN: "boolean",
}  # of outputs


class ComponentKind(UnitKind):
    """A component of the catalogue, or a "module:Class", which always runs in process."""

    key = "component"
    suffixes: ClassVar[tuple[str, ...] | None] = None
    has_native_form = True

    @property
    def label(self) -> str:
        return self.value.rpartition(":")[2]

    @cached_property
    def component_class(self) -> type[Component]:  # type: ignore[override]
        return component_class(self.settings.component, self.where)

    @property
    def of_catalogue(self) -> bool:  # type: ignore[override]
        return ":" not in self.settings.component

    @property
    def code(self) -> tuple[str, ...]:  # type: ignore[override]
        return (self.settings.component,)

    def opened_as(self, in_process: bool) -> str:
        return "component" if in_process or not self.of_catalogue else "FMU"

    def describe(self, name: str) -> Interface:
        from ..component import make

        component = make(name, self.settings)
        settings, cls, variables = self.settings, type(component), type(component).variables
        preset = cls.presets[settings.preset].effects if settings.preset else ()
        named = dict.fromkeys(settings.effects, "named in the scene")
        by_preset = dict.fromkeys(preset, f"preset {settings.preset!r}")
        return Interface(
            title=cls.title,
            inputs={
                n: Signal(n, v.unit, component[n], v.nominal, moving=v.moving) for n in component.inputs for v in [variables[n]]
            },
            outputs={
                n: Signal(
                    n,
                    v.unit,
                    0.0,
                    v.nominal,
                    tuple(i for i in component.inputs if _feeds(i, v.feedthrough)),
                    SIGNAL_KINDS[v.kind],
                    component.is_discrete(n),
                )
                for n in component.outputs
                for v in [variables[n]]
            },
            effects={e: named.get(e) or by_preset.get(e, "") for e in cls.effects},
            set_inputs=frozenset(settings.parameters) & frozenset(component.inputs),
            ports=cls.ports,
            port_members=cls.port_members,
            sums={n: parts for n, parts in cls.output_sums.items() if n in component.outputs},
            is_discontinuous=getattr(component, "is_discontinuous", False),
            remarks=tuple(component.doubts(settings.parameters)),
        )

    def open(self, name: str, in_process: bool, span: Span) -> Simulator:
        from ..component import ComponentSimulator, make

        component = make(name, self.settings)
        if self.opened_as(in_process) == "component":
            return ComponentSimulator(name, component)
        from .fmu import read, simulator_class

        given = {f"effects.{e}": e in component.on for e in component.effects} | component.parameters | _starts(component)
        description = read(str(self.fmu_file()), self.where)
        return simulator_class(description)(name, description, given, None, component, span)

    @property
    def variables(self) -> Mapping[str, Variable]:
        return self.component_class.variables

    def parameter_names(self) -> set[str] | None:
        return None if self.of_catalogue else set(self.variables)

    def number_of(self, parameter: str, text: str) -> Any:
        declared, array = self.variables, parameter.partition("[")[0]
        variable = declared.get(parameter) or declared.get(array) or declared.get(f"{array}[1]")
        return text if variable is None else variable.number_of(text, f"{self.where}.parameters.{parameter}")

    def numerical(self, parameter: str) -> str:
        if parameter == "period" and self.component_class.holds_outputs:  # waves and tides have periods, too
            return "the instants of samples move, and with them the steps that they fall into"
        return super().numerical(parameter)

    def fmu_file(self) -> Path:
        from ....fmus.build import built

        return built(self.settings.component)

    def fmu_values(self, name: str) -> dict[str, Any]:
        from ..component import make

        component = make(name, self.settings)
        variables, given = type(component).variables, self.settings.parameters
        starts = {**component.parameters, **_starts(component)}
        changed = {n: v for n, v in starts.items() if n in given or v != variables[n].start}
        return {**{f"effects.{e}": True for e in component.on}, **changed}


def _starts(component: Component) -> dict[str, float]:
    """Values of the inputs before the first step."""
    return dict(zip(component.inputs, component.u[0].tolist(), strict=True))


def _feeds(name: str, declared: tuple[str, ...]) -> bool:
    """Whether an input is among declared names, as itself or as an element of a declared array."""
    return name in declared or name.partition("[")[0] in declared
