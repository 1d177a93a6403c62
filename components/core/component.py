"""The contract every component keeps.

A component declares its variables and effects on the class. An instance is made with the effects that are on, then
`initialize(t)`, then any number of `step(t, h)`; `refresh()` recomputes the outputs after an input was set between steps;
`save()` and `restore()` may surround a repeated step. After `StepFailed` only `restore` is allowed.

Components of the catalogue are kernels, see `contract`. One in plain Python gives three methods, `_initialize`, `_step` and
`_outputs`, besides its declarations. Everything that a step changes belongs to the array `x`: `save` keeps time, inputs, outputs and
`x` only. Iterations, events, step control and resumed runs repeat steps from there.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any, ClassVar

import numpy as np

from .errors import BadInput, StepFailed, nearest, pick
from .kernels import DONE, OUT_OF_RANGE, REASONS, kernel_tuple
from .variables import Causality, Declared, Kind, Variable

TABLES = "Signals_"  # what the names of classes begin with that are made of a table, see `signals`
INITIALIZATION = ("initialize", "_initialize", "kernels")  # they decide on the initial state


def _inherited(cls: type, kind: type) -> dict[str, Any]:
    """Attributes that are instances of `kind`, or subclasses of it, by name: those of base classes and mix-ins first.

    A name that is declared again keeps its place; one that is set to something else, such as None, is gone.
    """
    merged: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        for name, value in vars(base).items():
            if isinstance(value, kind) or (isinstance(value, type) and issubclass(value, kind)):
                merged[name] = value
            else:
                merged.pop(name, None)
    return merged


def _declared(cls: type) -> tuple[Variable, ...]:
    return tuple(_inherited(cls, Variable).values())


def _tuple_type(owner: type, name: str, fields: Iterable[str]) -> type:
    """A NamedTuple for kernels, reachable as `owner.name`, because Numba's disk cache refers to it by module and name."""
    values = namedtuple(name, tuple(fields))  # type: ignore[misc]
    values.__module__, values.__qualname__ = owner.__module__, f"{owner.__qualname__}.{name}"
    return kernel_tuple(values)


def _form(variable: Variable, value: Callable[[Variable], Any]) -> Any:
    """How kernels get a parameter; value: that of a scalar."""
    if variable.size:
        return np.array([value(scalar) for scalar in variable.scalars])
    if variable.kind is Kind.TEXT:
        return 0
    return variable.choices.index(value(variable)) if variable.choices else value(variable)


def _start(scalar: Variable) -> Any:
    assert not isinstance(scalar.start, tuple)
    return float(scalar.start) if scalar.kind is Kind.REAL else scalar.start


class Effect:
    """An optional part of a component's physics. Off means absent: no state, no variable, no call.

    A subclass declares its own variables. Kernels get `Values` or None: the parameters, `u` and `y`, the positions of
    the effect's first input and first output where it has such, and `on` where there is nothing else to hold.

    `restores`: of what effects that it requires replace, the parameters that it reads after all.

    `explicit_only`: only a scene switches the effect on; a study of effects never adds it. So are parts, defects, loads, programmes
    and other forms of the model, which do not refine what a scene already has.

    `replaces`: parameters of the component, or of effects that it requires, that the effect makes ineffective; arrays without an index.

    `read_by`: the kernels that read its values. The others get None, so that they are compiled once for all sets of such effects.

    `either_in`: of these the kernels that find out when they run whether it is on: `initialize` where it takes long to compile. They have
    the effect's branches in the machine code of a process, compiled once with and without it; in a native FMU nothing is left of them.
    Such an effect gives `s` no array that is None where it is off, and is None where an effect that it requires is off.
    """

    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[tuple[str, ...]] = ()
    replaces: ClassVar[tuple[str, ...]] = ()
    restores: ClassVar[tuple[str, ...]] = ()
    explicit_only: ClassVar[bool] = False
    read_by: ClassVar[tuple[str, ...]] = ("initialize", "step", "outputs")
    either_in: ClassVar[tuple[str, ...]] = ()
    variables: ClassVar[tuple[Variable, ...]] = ()
    Values: ClassVar[Any]

    def __init_subclass__(cls) -> None:
        cls.variables = _declared(cls)
        fields = [
            name
            for name, kind in (("u", Causality.INPUT), ("y", Causality.OUTPUT))
            if any(v.causality is kind for v in cls.variables)
        ]
        fields += [v.name for v in cls.variables if v.causality is Causality.PARAMETER]
        cls.Values = _tuple_type(cls, "Values", fields or ["on"])

    @classmethod
    def form(cls) -> Any:
        """Some `Values`, of the types that they have in every component."""
        parameters = {v.name: v for v in cls.variables if v.causality is Causality.PARAMETER}
        fields = cls.Values._fields
        return cls.Values(*(_form(parameters[n], _start) if n in parameters else fields == ("on",) or 0 for n in fields))


@dataclass(frozen=True)
class Preset:
    """A published set of parameters: where it was read, and the provenance of its numbers."""

    parameters: Mapping[str, float]
    source: str
    provenance: str  # "verbatim", "unconfirmed", "inferred" or "computed"
    effects: tuple[str, ...] = ()


class Component:
    """Base of all components; see the module's docstring for the order of calls.

    Variables, effects and presets are inherited from base classes and mix-ins, by the method resolution order.
    """

    title: ClassVar[str] = ""
    system: ClassVar[str] = ""
    needs_scipy: ClassVar[bool] = False
    presets: ClassVar[Mapping[str, Preset]] = {}
    symbols: ClassVar[Mapping[str, str]] = {}  # of tables of the trade -> name of the parameter
    counters: ClassVar[tuple[str, ...]] = ("steps", "derivative_calls")
    default_step: ClassVar[float] = 1e-3  # s, macro step of the FMU's default experiment
    default_stop: ClassVar[float] = 1.0  # s
    # inputs, of effects too, from which what initialization leaves behind follows, whatever is on; None where it is not declared
    start_inputs: ClassVar[tuple[str, ...] | None] = None

    holds_outputs: ClassVar[bool] = False  # they keep their values between samples: no master may interpolate or extrapolate them
    by_midpoint_rule: bool = False  # it integrates so, with a parameter `substep`: modes take back what the rule does to them
    ports: ClassVar[Declared] = {}  # signals that go to one partner together
    port_members: ClassVar[Mapping[str, str]] = {}  # names of signals that are others within a port
    output_sums: ClassVar[
        Mapping[str, tuple[str, ...]]
    ] = {}  # an output -> the outputs that are its parts, each an incomplete answer
    former: ClassVar[Mapping[str, str]] = {}  # names that earlier versions had, and what to do
    own_variables: ClassVar[tuple[Variable, ...]] = ()
    effects: ClassVar[Mapping[str, type[Effect]]] = {}
    variables: ClassVar[Mapping[str, Variable]] = {}  # every scalar, of effects too, by full name
    Values: ClassVar[Any]  # NamedTuple of the own parameters, for kernels
    Present: ClassVar[Any]  # NamedTuple of the effects, for kernels: the effect's `Values`, or None where it is off

    def __init_subclass__(cls) -> None:
        if "start_inputs" not in vars(cls) and any(method in vars(cls) for method in INITIALIZATION):
            cls.start_inputs = None  # that of the base class is about the method which is overridden
        cls.own_variables = _declared(cls)
        cls.effects = _inherited(cls, Effect)
        cls.presets = {n: p for base in reversed(cls.__mro__) for n, p in vars(base).get("presets", {}).items()}
        cls.variables = {s.name: s for v in cls.own_variables for s in v.scalars}
        for name, effect in cls.effects.items():
            cls.variables |= {s.name: s for v in effect.variables for s in _prefixed(v, name).scalars}
        if cls.holds_outputs:
            cls.variables = {n: replace(v, held=v.causality is Causality.OUTPUT) for n, v in cls.variables.items()}
        cls.Values = _tuple_type(cls, "Values", [v.name for v in cls.own_variables if v.causality is Causality.PARAMETER])
        cls.Present = _tuple_type(cls, "Present", cls.effects)

    @classmethod
    def input_places(cls) -> Any:
        """Positions of own inputs in the kernels' `u`, of an array that of its first element: a NamedTuple of their names."""
        return cls._places("InputPlaces", Causality.INPUT)

    @classmethod
    def output_places(cls) -> Any:
        """Positions of own outputs in the kernels' `y`, as `input_places`."""
        return cls._places("OutputPlaces", Causality.OUTPUT)

    @classmethod
    def _places(cls, name: str, causality: Causality) -> Any:
        variables = [v for v in cls.own_variables if v.causality is causality]
        ends = accumulate(len(v.scalars) for v in variables)
        setattr(cls, name, _tuple_type(cls, name, [v.name for v in variables]))
        return getattr(cls, name)(*(end - len(v.scalars) for end, v in zip(ends, variables, strict=True)))

    def __init__(
        self, effects: Iterable[str] = (), parameters: Mapping[str, Any] | None = None, *, preset: str = "", name: str = ""
    ) -> None:
        cls = type(self)
        self.name = name or cls.__name__
        preset_values: dict[str, Any] = {}
        if preset:
            pick(preset, cls.presets, self.name, "a preset of " + cls.__name__, "preset")
            preset_values |= cls.presets[preset].parameters
            effects = (*cls.presets[preset].effects, *effects)
        self.on = self._checked_effects(tuple(effects))
        active = {n: v for n, v in cls.variables.items() if self.is_active(n)}
        self.parameters = {n: v.start for n, v in active.items() if v.causality is Causality.PARAMETER}
        self._defaults = self.parameters | {n: v for n, v in preset_values.items() if n in self.parameters}
        self.inputs = tuple(n for n, v in active.items() if v.causality is Causality.INPUT)
        self.outputs = tuple(n for n, v in active.items() if v.causality is Causality.OUTPUT)
        self._input_index = {n: i for i, n in enumerate(self.inputs)}
        self._output_index = {n: i for i, n in enumerate(self.outputs)}
        # by effect, the position of its first input and of its first output
        self._first_of_effect = [
            {n.partition(".")[0]: i for i, n in reversed([*enumerate(names)]) if "." in n}
            for names in (self.inputs, self.outputs)
        ]
        self.u = np.zeros((3, len(self.inputs)))  # value now, slope, half of the second derivative over the coming step
        self.u[0] = [active[n].start for n in self.inputs]
        self.y = np.zeros(len(self.outputs))
        self.x = np.zeros(0)
        self.t = 0.0
        self.counts = np.zeros(len(self.counters), dtype=np.int64)
        self._used: tuple[Any, ...] = ()  # parameters of which each is known to have a part
        for key, value in {**preset_values, **(parameters or {})}.items():
            self.set(key, active[key].checked(value, self.name) if key in self._input_index else value)

    def _checked_effects(self, effects: tuple[str, ...]) -> tuple[str, ...]:
        known = type(self).effects
        for effect in effects:
            pick(effect, known, self.name, f"an effect of {type(self).__name__}", "effect")
        for effect in effects:
            for other in known[effect].requires:
                if other not in effects:
                    raise BadInput(self.name, f"the effect {effect!r} needs {other!r}", "", f"Switch on {other!r}, too.")
            for other in known[effect].excludes:
                if other in effects:
                    raise BadInput(self.name, f"the effects {effect!r} and {other!r} exclude each other", "", "Remove one.")
        return tuple(n for n in known if n in effects)

    def is_active(self, variable: str) -> bool:
        """Whether the variable exists in this instance, that is, belongs to no effect that is off."""
        effect, dot, _ = variable.partition(".")
        return not dot or effect in self.on

    def is_discrete(self, output: str) -> bool:
        """Whether an output changes at instants only."""
        return type(self).variables[output].discrete

    # -- values ------------------------------------------------------------------------------------------------------
    def _unknown(self, name: str) -> BadInput:
        effect = name.partition(".")[0]
        if name in type(self).variables and effect in type(self).effects and effect not in self.on:
            return BadInput(self.name, f"variable {name!r}", "a variable of what is on", f"It needs the effect {effect!r}.")
        if name in self._output_index:
            return BadInput(self.name, f"a value of {name!r}", "a parameter or an input; this is an output")
        arrays = {n.partition("[")[0] for n in (*self.parameters, *self.inputs) if "[" in n}
        if name in arrays:
            return BadInput(self.name, f"one value of {name!r}", "an array", f"Give a list, or set {name}[1] and so on.")
        names = [*self.parameters, *self.inputs, *self.outputs]
        remedy = type(self).former.get(name) or nearest(name, names)
        return BadInput(self.name, f"variable {name!r}", f"a variable of {type(self).__name__}", remedy)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter (before `initialize`, unless it is tunable) or the present value of an input."""
        if name in self._input_index:
            self.u[:, self._input_index[name]] = (float(value), 0.0, 0.0)
        elif name in self.parameters:
            self.parameters[name] = type(self).variables[name].checked(value, self.name)
        else:
            raise self._unknown(name)

    def get(self, name: str) -> Any:
        """The value of a parameter, an input or an output."""
        if name in self._output_index:
            return float(self.y[self._output_index[name]])
        if name in self._input_index:
            return float(self.u[0, self._input_index[name]])
        if name in self.parameters:
            return self.parameters[name]
        raise self._unknown(name)

    __getitem__, __setitem__ = get, set

    @classmethod
    def replaced(cls, on: Iterable[str]) -> dict[str, str]:
        """The parameters that are ineffective with these effects, each with the effect that takes its place; arrays without an index."""
        some = [(name, cls.effects[name]) for name in on]
        restored = {n for _, effect in some for n in effect.restores}
        return {n: name for name, effect in some for n in effect.replaces if n not in restored}

    def unused(self, names: Iterable[str]) -> dict[str, str]:
        """Of some parameters those that have no part in what is computed, each with the reason; a subclass may know more."""
        reasons = {n: f"the effect {effect!r} takes its place" for n, effect in type(self).replaced(self.on).items()}
        return {n: reasons[own] for n in names if (own := n.partition("[")[0]) in reasons}

    def doubts(self, names: Iterable[str]) -> list[str]:
        """Of some parameters those whose values are probably in another unit, each with the question."""
        variables = type(self).variables
        values = {n: self.parameters[n] for n in names if n in self.parameters}
        return [f"{n} = {v:g}: {question}" for n, v in values.items() if (question := variables[n].doubt(v))]

    def refuse_unused(self, names: Iterable[str]) -> None:
        """`BadInput` where parameters that were given have no part: their values would be ignored."""
        if unused := self.unused(n for n in names if n in self.parameters):
            values = ", ".join(f"{n} = {self.parameters[n]!r}" for n in unused)
            why = "; ".join(dict.fromkeys(unused.values()))
            raise BadInput(self.name, f"{values} has no effect here: {why}", "", "Remove it.")

    def input_positions(self, names: Iterable[str]) -> np.ndarray:
        """Columns of `u` for input names, (n,)."""
        return np.array([self._input_index[n] for n in names], dtype=np.intp)

    def output_positions(self, names: Iterable[str]) -> np.ndarray:
        """Elements of `y` for output names, (n,)."""
        return np.array([self._output_index[n] for n in names], dtype=np.intp)

    def _declared_arguments(self) -> tuple[Any, ...]:
        """(p, e) for the kernels: the parameters, and of a component with effects all of them, None for one that is off."""
        cls = type(self)
        p = cls.Values(*(self._value(v) for v in cls.own_variables if v.causality is Causality.PARAMETER))
        return (p, cls.Present(*map(self._effect_values, cls.effects))) if cls.effects else (p,)

    def _effect_values(self, name: str) -> Any:
        """The form of an effect in kernels: its `Values`, or None where it is off."""
        if name not in self.on:
            return None
        effect = type(self).effects[name]
        fields = [index[name] for index in self._first_of_effect if name in index]
        fields += [self._value(v, name + ".") for v in effect.variables if v.causality is Causality.PARAMETER]
        return effect.Values(*(fields or [True]))

    def _value(self, variable: Variable, owner: str = "") -> Any:
        """The value of a declared parameter; owner: of an effect, its name and a dot."""
        return _form(variable, lambda scalar: self.parameters[owner + scalar.name])

    # -- the run -----------------------------------------------------------------------------------------------------
    def initialize(self, t: float) -> None:
        """Take over the parameters, compute the initial state for the present inputs and the outputs. May be repeated.

        `BadInput` for parameters that do not go together, also where they overflow or make a singular matrix.
        """
        self.t = float(t)
        self.u[1:] = 0.0
        self.counts[:] = 0
        if self._used != (values := tuple(self.parameters.values())):  # initialization is repeated
            self.refuse_unused(n for n, value in self.parameters.items() if value != self._defaults[n])
            self._used = values
        try:
            status = self._initialize(self.t)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            raise BadInput(
                self.name,
                "the initial state overflows or is singular",
                "parameters and inputs of a usual size",
                f"Check the largest and the smallest of them ({type(error).__name__}: {error}).",
            ) from error
        self._check(status)
        self.refresh()

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h; inputs follow u[0] + u[1] s + u[2] s², and keep their end value afterwards."""
        self._check(self._step(float(t), float(h)))
        self.stepped(t + h)

    def stepped(self, t: float) -> None:
        """One step or many have reached the time t, s; a component may warn here of what its kernels noted in them."""
        self.t = t

    def refresh(self) -> None:
        """Outputs from the present state and inputs."""
        self._outputs(self.t)

    def _check(self, status: int) -> None:
        if status != DONE:
            reason, remedy = REASONS[status]
            if status == OUT_OF_RANGE and (left := self.left_range()):
                reason = f"{reason}: {left}"
            raise StepFailed(self.name, self.t, reason, remedy)

    def left_range(self) -> str:
        """The variable that is out of the model's range, with its value and the range; of components that have one."""
        return ""

    def save(self) -> bytes:
        """Everything a repeated step depends on; `restore` gives back every bit."""
        return np.concatenate(([self.t], self.u.ravel(), self.y, self.x)).tobytes()

    def restore(self, state: bytes) -> None:
        """Take back a state of `save`, of this instance or of one with the same effects and parameters."""
        values = np.frombuffer(state)
        size = 1 + self.u.size + self.y.size + self.x.size
        if values.size != size:
            raise BadInput(self.name, f"a state of {values.size} numbers", f"{size} numbers")
        self.t = float(values[0])
        ends = np.cumsum([1, self.u.size, self.y.size])
        self.u[:] = values[ends[0] : ends[1]].reshape(self.u.shape)
        self.y[:] = values[ends[1] : ends[2]]
        self.x[:] = values[ends[2] :]

    @property
    def work(self) -> dict[str, int]:
        """The counters by name, since `initialize`."""
        return dict(zip(self.counters, self.counts.tolist(), strict=True))

    # -- what a component gives --------------------------------------------------------------------------------------
    def _initialize(self, t: float) -> int:
        raise NotImplementedError

    def _step(self, t: float, h: float) -> int:
        """Advance the state; leave the outputs of the end of the step in `y`, and the inputs held (`hold_inputs`)."""
        raise NotImplementedError

    def _outputs(self, t: float) -> None:
        raise NotImplementedError

    def energy(self) -> float:
        """Mechanical energy of the present state, J; of components that hold some."""
        raise NotImplementedError

    def stable_step(self) -> float:
        """Largest internal step that is stable without the interface, s; infinite where nothing is integrated explicitly."""
        return math.inf


def _prefixed(variable: Variable, effect: str) -> Variable:
    feedthrough = tuple(f"{effect}.{n[1:]}" if n.startswith(".") else n for n in variable.feedthrough)
    return replace(variable, name=f"{effect}.{variable.name}", feedthrough=feedthrough)
