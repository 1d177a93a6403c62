"""A component that runs in this process: the fastest kind of unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from components.catalogue import component_class
from components.core.component import Component
from components.core.errors import BadInput, nearest

from ..settings import UnitSettings
from .interface import Interface, Signal


def find(component: str, where: str) -> type[Component]:
    """The class of a catalogue name or of "module:Class"."""
    if ":" not in component:
        return component_class(component, where)
    module, _, name = component.partition(":")
    try:
        found = getattr(import_module(module), name, None)
    except ImportError as error:
        raise BadInput(where, f"component {component!r}", "module:Class that can be imported", f"{error}.") from None
    if not (isinstance(found, type) and issubclass(found, Component)):
        classes = [n for n, c in vars(import_module(module)).items() if isinstance(c, type) and issubclass(c, Component)]
        raise BadInput(where, f"component {component!r}", f"a component of {module}", nearest(name, classes))
    return found


def make(name: str, settings: UnitSettings) -> Component:
    """The component of a scene's entry, with its parameters checked."""
    cls = find(settings.component, f"units.{name}")
    return cls(settings.effects, settings.parameters, preset=settings.preset, name=name)


def describe_component(name: str, settings: UnitSettings) -> Interface:
    """The interface of a component with the scene's effects."""
    component = make(name, settings)
    cls, variables = type(component), type(component).variables
    preset = cls.presets[settings.preset].effects if settings.preset else ()
    named, by_preset = dict.fromkeys(settings.effects, "named in the scene"), dict.fromkeys(preset, f"preset {settings.preset!r}")
    return Interface(
        title=cls.title,
        inputs={n: Signal(n, v.unit, component[n], v.nominal) for n in component.inputs for v in [variables[n]]},
        outputs={
            n: Signal(n, v.unit, 0.0, v.nominal, tuple(i for i in component.inputs if _feeds(i, v.feedthrough)))
            for n in component.outputs for v in [variables[n]]
        },
        effects={e: named.get(e) or by_preset.get(e, "") for e in cls.effects},
        set_inputs=frozenset(settings.parameters) & frozenset(component.inputs),
    )


def _feeds(name: str, declared: tuple[str, ...]) -> bool:
    """Whether an input is among declared names, as itself or as an element of a declared array."""
    return name in declared or name.partition("[")[0] in declared


class ComponentUnit:
    """A component as a unit; inputs and outputs are views of the component's own arrays."""

    kind = "in process"

    def __init__(self, name: str, component: Component):
        self.name, self.component = name, component

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self._columns = self.component.input_positions(inputs).tolist()
        rows: list[Any] = [memoryview(row) for row in self.component.u]  # type: ignore[arg-type]
        self._value, self._slope, self._half = rows  # writing an item of a view is twice as fast as of an array
        self.get = self.reader(outputs)
        self.step = self.component.step

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        y, positions = self.component.y, self.component.output_positions(names)
        first = int(positions[0]) if len(names) else 0
        if positions.tolist() == list(range(first, first + len(names))):
            view: Any = memoryview(y[first : first + len(names)])  # type: ignore[arg-type]
            return view.tolist  # a quarter of the time of picking elements
        return lambda: y[positions].tolist()

    def _set(self, values: list[float]) -> None:
        row = self._value
        for i, value in zip(self._columns, values):  # noqa: B905 - strict would take more time than the loop
            row[i] = value

    def initialize(self, t: float, values: list[float]) -> None:
        self._set(values)
        self.component.initialize(t)

    def start(self) -> None:
        """Nothing to do: the component stands at its initial state."""

    def drive(self, values: list[float], slopes: list[float] | None, halves: list[float] | None, h: float) -> None:
        self._set(values)
        if slopes is not None:
            row = self._slope
            for i, slope in zip(self._columns, slopes):  # noqa: B905
                row[i] = slope
        if halves is not None:
            row = self._half
            for i, half in zip(self._columns, halves):  # noqa: B905
                row[i] = half

    def update(self, values: list[float]) -> None:
        self._set(values)
        self.component.refresh()

    def save(self, reuse: bytes | None = None) -> bytes:
        return self.component.save()

    def restore(self, state: bytes) -> None:
        self.component.restore(state)

    def parameters(self) -> dict[str, Any]:
        return dict(self.component.parameters)

    def work(self) -> dict[str, int]:
        return self.component.work

    def close(self) -> None:
        """Nothing is held outside the component."""
