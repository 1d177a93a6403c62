"""Any FMI 2.0 co-simulation FMU as a unit.

FMPy reads, extracts and loads; the calls of every step go past it, straight to the library with buffers made once,
because FMPy builds new arrays in each call and then costs more than the FMU.

Inputs that change over a step are given in the best of three ways: by companion inputs "der(x)" and "der(x,2)" (our own
FMUs have them); by fmi2SetRealInputDerivatives where the FMU says canInterpolateInputs; else the mean of the polynomial
over the step is held: the unit then receives the right impulse, and the second order of the coupling survives.

Only Real inputs and outputs can be connected and recorded; parameters may be of any type.
"""

from __future__ import annotations

import ctypes
import shutil
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from fmpy import calloc, extract, free, read_model_description
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy
from fmpy.model_description import ModelDescription, ModelVariable

from components.core.errors import BadInput, StepFailed, nearest

from .interface import WIDE, Interface, Row, Signal

if TYPE_CHECKING:
    from components.core.component import Component

    from ..settings import UnitSettings

WARNING, FATAL = 1, 4
STATUS = {2: "discarded the call", 3: "reported an error", 4: "reported a fatal error"}
_LETTERS = {"Real": "d", "Integer": "i", "Enumeration": "i", "Boolean": "i"}


def _description(path: str, where: str) -> ModelDescription:
    if not Path(path).is_file():
        raise BadInput(where, repr(path), "an FMU file")
    return _read(path, Path(path).stat().st_mtime_ns, where)


@lru_cache(maxsize=64)
def _read(path: str, _changed: int, where: str) -> ModelDescription:
    try:
        found = read_model_description(path, validate=False)
    except Exception as error:  # FMPy raises bare exceptions and those of zipfile and lxml
        raise BadInput(where, repr(path), "an FMU", f"{error}.") from None
    if found.fmiVersion != "2.0" or found.coSimulation is None:
        raise BadInput(where, f"{path} (FMI {found.fmiVersion})", "an FMU for co-simulation, FMI 2.0")
    return found


def describe_fmu(name: str, settings: UnitSettings) -> Interface:
    """The interface an FMU's model description gives, with the scene's effects and parameters checked against it."""
    where = f"units.{name}"
    found = _description(settings.fmu, f"{where}.fmu")
    variables = {v.name: v for v in found.modelVariables}
    known = [v.removeprefix("effects.") for v in variables if v.startswith("effects.")]
    for effect in settings.effects:
        if effect not in known:
            raise BadInput(f"{where}.effects", repr(effect), "an effect of the FMU", nearest(effect, known))
    off = [e for e in known if e not in settings.effects and not _is_true(variables[f"effects.{e}"].start)]
    for parameter, value in settings.parameters.items():
        _check_value(where, parameter, value, variables, off)
    named = dict.fromkeys(settings.effects, "named in the scene")
    real = [v for v in variables.values() if v.type == "Real" and v.name.partition(".")[0] not in off]
    direct = {u.variable.name: u.dependencies for u in found.outputs}
    inputs = {v.name: _signal(v, ()) for v in real if v.causality == "input" and not v.name.startswith("der(")}
    return Interface(
        title=found.description or found.modelName,
        inputs=inputs,
        outputs={v.name: _signal(v, _depends(direct.get(v.name), inputs)) for v in real if v.causality == "output"},
        effects={e: "" if e in off else named.get(e, "on by the FMU's default") for e in known},
        set_inputs=frozenset(settings.parameters) & frozenset(inputs),
        input_degree=2 if found.coSimulation.canInterpolateInputs or _companions(variables, list(inputs)) else 0,
        variable_step=found.coSimulation.canHandleVariableCommunicationStepSize,
        saves_state=found.coSimulation.canGetAndSetFMUstate,
    )


def _is_true(text: Any) -> bool:
    return str(text).lower() in ("true", "1")


def _check_value(where: str, name: str, value: Any, variables: Mapping[str, ModelVariable], off: Sequence[str]) -> None:
    variable, where = variables.get(name), f"{where}.parameters"
    settable = [n for n, v in variables.items()
                if v.causality in ("parameter", "input") and not n.startswith(("effects.", "der("))]
    if name not in settable or variable is None:
        remedy = "List effects under effects = [...]." if name.startswith("effects.") else nearest(name, settable)
        raise BadInput(where, repr(name), "a parameter or an input of the FMU", remedy)
    if name.partition(".")[0] in off:
        effect = name.partition(".")[0]
        raise BadInput(where, repr(name), "a parameter of an effect that is on", f"Switch on the effect {effect!r}.")
    wanted = {"Real": (int, float), "Boolean": (bool,), "String": (str,)}.get(variable.type, (int,))
    if not isinstance(value, wanted) or (isinstance(value, bool) and bool not in wanted):
        raise BadInput(where, f"{name} = {value!r}", f"a value of type {variable.type}")
    if isinstance(value, float) and not isfinite(value):
        raise BadInput(where, f"{name} = {value!r}", "a finite number")
    for bound, beyond in ((variable.min, float.__lt__), (variable.max, float.__gt__)):
        if bound is not None and beyond(float(value), float(bound)):
            raise BadInput(where, f"{name} = {value!r}", f"a value in [{variable.min}, {variable.max}]")


def _signal(v: ModelVariable, feedthrough: tuple[str, ...] | None) -> Signal:
    unit = v.unit or (v.declaredType.unit if v.declaredType else None) or ""
    return Signal(v.name, unit, float(v.start or 0.0), abs(float(v.nominal or 1.0)) or 1.0, feedthrough)


def _depends(declared: Sequence[ModelVariable] | None, inputs: Mapping[str, Signal]) -> tuple[str, ...] | None:
    return None if declared is None else tuple(v.name for v in declared if v.name in inputs)


def _companions(variables: Mapping[str, ModelVariable], inputs: Sequence[str]) -> bool:
    return bool(inputs) and all(f"der({n})" in variables and f"der({n},2)" in variables for n in inputs)


def open_fmu(name: str, settings: UnitSettings) -> FmuUnit:
    """The running FMU of a scene's entry; a component of the catalogue is built first if the cache has no FMU of it."""
    if settings.fmu:
        given: dict[str, Any] = {f"effects.{e}": True for e in settings.effects} | settings.parameters
        return FmuUnit(name, settings.fmu, given)
    from fmus.build import built

    from .component import make

    component = make(name, settings)
    starts = dict(zip(component.inputs, component.u[0].tolist(), strict=True))
    given = {f"effects.{e}": e in component.on for e in component.effects} | component.parameters | starts
    return FmuUnit(name, str(built(settings.component)), given, component)


class FmuUnit:
    """An FMU that is extracted, instantiated and has its parameters; see `Unit` for the order of calls."""

    kind = "FMU"
    event: float | None = None

    def __init__(self, name: str, path: str, values: Mapping[str, Any], twin: Component | None = None):
        """`twin`: the component that is in the FMU, to ask why it cannot start; FMI hands over a status, no reasons."""
        self.name, self._values, self._twin = name, dict(values), twin
        self._time, self._steps, self._initializing = 0.0, 0, False
        self._usable = self._healthy = False  # whether the instance may be touched, and whether all its calls went well
        description = _description(path, f"units.{name}")
        self._variables = {v.name: v for v in description.modelVariables}
        self._interpolates = description.coSimulation.canInterpolateInputs
        self._states: list[ctypes.c_void_p] = []  # the FMU's own memory, freed on close
        self._log: deque[str] = deque(maxlen=3)
        self._folder = extract(path)
        try:
            self._fmu = FMU2Slave(instanceName=name, guid=description.guid, unzipDirectory=self._folder,
                                  modelIdentifier=description.coSimulation.modelIdentifier)
            self._fmu.instantiate(callbacks=self._callbacks(), loggingOn=True)
            self._usable = self._healthy = True
        except Exception as error:  # FMPy raises bare exceptions
            self.close()
            raise BadInput(f"units.{name}", f"{path} cannot be started: {error}{self._said()}",
                           "an FMU with a library for this platform") from None
        try:
            self._set_values(values)
            self._call("fmi2SetupExperiment", ctypes.c_int(0), ctypes.c_double(0.0), ctypes.c_double(0.0), ctypes.c_int(0),
                       ctypes.c_double(0.0))
        except StepFailed as error:
            self.close()
            raise BadInput(f"units.{name}", error.reason, "parameter values the FMU accepts") from None

    def _callbacks(self) -> fmi2CallbackFunctions:
        def log(_environment, _instance, _status, _category, message):
            self._log.append(message.decode(errors="replace").strip())

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(log)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(ctypes.byref(callbacks))
        return callbacks

    def _function(self, name: str, *types: Any) -> Callable[..., int]:
        """A C function under this unit's own argument types: indexing the library gives a new object each time."""
        function = self._fmu.dll[name]
        function.argtypes, function.restype = (ctypes.c_void_p, *types), ctypes.c_int
        return function

    def _call(self, name: str, *arguments: Any) -> None:
        status = self._function(name, *(type(a) for a in arguments))(self._fmu.component, *arguments)
        if status > WARNING:
            self._failed(status)

    def _said(self) -> str:
        return "".join(f"\n  log: {line}" for line in self._log)

    def _failed(self, status: int) -> None:
        self._usable, self._healthy = status != FATAL, False
        raise StepFailed(self.name, self._time, f"the FMU {STATUS.get(status, f'returned status {status}')}{self._said()}")

    def _references(self, names: Sequence[str]) -> Any:
        return (ctypes.c_uint32 * len(names))(*(self._variables[n].valueReference for n in names))

    def _set_values(self, values: Mapping[str, Any]) -> None:
        """Values of any type, one call each: this happens once."""
        for name, value in values.items():
            type_ = self._variables[name].type
            array = (ctypes.c_char_p * 1)(value.encode()) if type_ == "String" else (ctypes.c_int * 1)(int(value)) \
                if type_ != "Real" else (ctypes.c_double * 1)(value)
            call = "fmi2SetInteger" if type_ == "Enumeration" else f"fmi2Set{type_}"
            self._call(call, self._references([name]), ctypes.c_size_t(1), array)

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        n, pointer, self._input_names = len(inputs), ctypes.c_void_p, tuple(inputs)
        companions = _companions(self._variables, inputs)
        self._n, self._companions = n, companions
        self._inputs: Any = (ctypes.c_double * (3 * n))()
        self._array = np.ctypeslib.as_array(self._inputs) if n > WIDE else None
        names = [*inputs, *(f"der({i})" for i in inputs), *(f"der({i},2)" for i in inputs)] if companions else inputs
        self._input_references, self._orders = self._references(names), [(ctypes.c_int * n)(*[k] * n) for k in (1, 2)]
        self._set_real = self._function("fmi2SetReal", pointer, ctypes.c_size_t, pointer)
        self._set_derivatives = self._function("fmi2SetRealInputDerivatives", pointer, ctypes.c_size_t, pointer, pointer)
        self._do_step = self._function("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self._instance = self._fmu.component
        self.get = self.reader(outputs, len(outputs) > WIDE)

    def wire_texts(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        raise NotImplementedError

    def set_texts(self, values: Sequence[str]) -> None:
        raise NotImplementedError

    def get_texts(self) -> list[str]:
        raise NotImplementedError

    def reader(self, names: Sequence[str], arrays: bool = False) -> Callable[[], Row]:
        get_real = self._function("fmi2GetReal", ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
        n = len(names)
        if n == 0:
            return list
        instance, references, buffer = self._fmu.component, self._references(names), (ctypes.c_double * n)()
        values = np.ctypeslib.as_array(buffer) if arrays else None

        def read() -> Row:
            status = get_real(instance, references, n, buffer)
            if status > WARNING:
                self._failed(status)
            return buffer[:] if values is None else values

        return read

    def initialize(self, t: float, values: Row) -> None:
        if not self._initializing:
            self._initializing = True
            self._call("fmi2EnterInitializationMode")
        try:
            self.update(values)
            if not isfinite(sum(self.get())):
                raise StepFailed(self.name, t, f"the FMU gives no finite initial values{self._said()}")
        except StepFailed:
            if self._twin is not None:
                for name, value in zip(self._input_names, values, strict=True):
                    self._twin.set(name, value)
                self._twin.initialize(t)  # raises with the component's own words, which may be `BadInput`
            raise

    def start(self) -> None:
        self._call("fmi2ExitInitializationMode")

    def drive(self, values: Row, slopes: Row | None, halves: Row | None, h: float) -> None:
        n, count, inputs = self._n, self._n, self._inputs if self._array is None else self._array
        if slopes is None:
            inputs[:n] = values
        elif self._companions:
            inputs[:n], inputs[n : 2 * n], count = values, slopes, 2 * n
            if halves is not None:
                inputs[2 * n :], count = [2.0 * c for c in halves], 3 * n
        elif self._interpolates:
            inputs[:n] = values
            self._check(self._set_real(self._instance, self._input_references, n, self._inputs))
            for order, derivatives in zip(self._orders, (slopes, None if halves is None else [2.0 * c for c in halves]),
                                          strict=True):
                if derivatives is not None:
                    inputs[:n] = derivatives
                    self._check(self._set_derivatives(self._instance, self._input_references, n, order, self._inputs))
            return
        else:
            terms = zip(values, slopes, [0.0] * n if halves is None else halves, strict=True)
            inputs[:n] = [v + h * (s / 2.0 + h * c / 3.0) for v, s, c in terms]
        self._check(self._set_real(self._instance, self._input_references, count, self._inputs))

    def _check(self, status: int) -> None:
        if status > WARNING:
            self._failed(status)

    def step(self, t: float, h: float) -> None:
        self._time = t
        status = self._do_step(self._instance, t, h, 1)
        self._steps += 1
        if status > WARNING:
            self._failed(status)

    def update(self, values: Row) -> None:
        if self._n:
            (self._inputs if self._array is None else self._array)[: self._n] = values
            self._check(self._set_real(self._instance, self._input_references, self._n, self._inputs))

    def save(self, reuse: ctypes.c_void_p | None = None) -> ctypes.c_void_p:
        state = reuse or ctypes.c_void_p()
        self._call("fmi2GetFMUstate", ctypes.pointer(state))
        if reuse is None:
            self._states.append(state)
        return state

    def restore(self, state: ctypes.c_void_p) -> None:
        self._call("fmi2SetFMUstate", state)

    def release(self, state: ctypes.c_void_p) -> None:
        raise NotImplementedError

    def pack(self, state: ctypes.c_void_p) -> bytes:
        raise NotImplementedError

    def unpack(self, packed: bytes) -> ctypes.c_void_p:
        raise NotImplementedError

    def jacobian(self) -> np.ndarray:
        raise NotImplementedError

    def parameters(self) -> dict[str, Any]:
        return self._values

    def work(self) -> dict[str, int]:
        return {"steps": self._steps}

    def close(self) -> None:
        if self._usable:  # after a fatal error the instance must not be touched
            if self._healthy:  # after an error only the last of these calls is allowed
                for state in self._states:
                    self._function("fmi2FreeFMUstate", ctypes.c_void_p)(self._fmu.component, ctypes.byref(state))
                self._function("fmi2Terminate")(self._fmu.component)
            self._fmu.freeInstance()
            self._usable = False
        shutil.rmtree(self._folder, ignore_errors=True)
        sys.path[:] = [p for p in sys.path if not p.startswith(str(self._folder))]  # pythonfmu leaves an entry at each start
