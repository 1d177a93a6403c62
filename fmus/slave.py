"""The one pythonfmu slave: FMI calls on one side, a component on the other.

Part of every FMU's bundle; the component class is handed in by the generated script.

What pythonfmu 0.7 makes of a slave's answers decides the form of this file: an exception becomes fmi2Fatal and
releases objects pythonfmu does not own (the next call may crash), False from `do_step` becomes fmi2Discard with the
status Terminated, and no other call can report a failure. So nothing raises: what goes wrong is logged and remembered,
and the next step is discarded.
"""

from __future__ import annotations

import json
import logging
from functools import cache
from math import inf, isfinite, nan
from struct import Struct
from typing import Any, ClassVar

import numpy as np
from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from .interface import Scalar, interface

LOG = logging.getLogger("cosimo")
MISSING = {"Real": nan, "Integer": 0, "Boolean": False, "String": ""}
WIDE = 24  # values: a call with more of them is an array operation
KEPT = 16  # wide calls whose places are remembered; a master has one or two to a port
HEAD = Struct("<2Q")  # a saved state starts with the lengths of its two JSON parts: configuration, status


class ComponentSlave(Fmi2Slave):
    """FMI co-simulation slave of `component_class`."""

    component_class: ClassVar[Any]

    def __init__(self, **kwargs: Any):
        super().__init__(**kwargs)
        self.component: Any = None  # made when the initial values are needed, remade when a parameter changes before the run
        self.running = False  # initialisation mode was left
        self.start_time = 0.0
        self._scalars, self._references = _tables(self.component_class)
        self._values = [s.start for s in self._scalars]  # of all that is not in the component's arrays
        self._dirty = True  # the outputs do not belong to the present inputs
        self._failure = ""
        self._refused: dict[str, str] = {}  # parameter -> why its value was refused
        self._config = b""
        self._bind()

    # -- where a value lives: value reference -> (container, index) ----------------------------------------------------
    def _bind(self) -> None:
        """Point the value references at the component's arrays, and the rest at `_values`."""
        self._reads: dict[str, dict[int, tuple[Any, int]]] = {t: {} for t in MISSING}
        self._writes: dict[int, tuple[Any, int]] = {}
        for reference, scalar in enumerate(self._scalars):
            self._reads[scalar.type][reference] = (self._values, reference)
            if scalar.causality == "input":
                self._writes[reference] = (self._values, reference)
        if self.component is not None:
            reads, writes = self._reads["Real"], self._writes
            self._u, self._y = self.component.u.reshape(-1), self.component.y
            # v . zeros is not 0 if a number in v is not finite: the quickest test of them all
            self._u_zeros, self._y_zeros = np.zeros(self._u.size), np.zeros(self._y.size)
            u, y = memoryview(self._u), memoryview(self._y)  # a read from a memoryview is a float, and three times faster
            containers = (u, u, _Halved(u))
            for reference, order, position in self._active_inputs():
                reads[reference] = writes[reference] = (containers[order], position)
            for k, name in enumerate(self.component.outputs):
                reference = self._references[name]
                self._reads[self._scalars[reference].type][reference] = (y, k)
        self._real_reads = self._reads["Real"]
        self._read_ports, self._written_ports = _Ports(), _Ports()  # of the last wide calls

    def _active_inputs(self) -> list[tuple[int, int, int]]:
        """(value reference, order of the derivative, position in the component's flat `u`) of the inputs that are on."""
        names, n = self.component.inputs, len(self.component.inputs)
        forms = ("{}", "der({})", "der({},2)")
        return [(self._references[f.format(name)], k, k * n + i) for k, f in enumerate(forms) for i, name in enumerate(names)]

    def _make(self) -> None:
        values = {s.name: v for s, v in zip(self._scalars, self._values, strict=True)}
        on = [n for n in self.component_class.effects if values[f"effects.{n}"]]
        given = [s.name for s in self._scalars if s.causality == "parameter" and s.type != "Boolean"]
        parameters = {n: values[n] for n in given if "." not in n or n.partition(".")[0] in on}
        self._set_outputs(0.0)
        self.component = self.component_class(on, parameters, name=self.instance_name)
        self._bind()
        for reference, _, _ in self._active_inputs():
            container, position = self._writes[reference]
            container[position] = self._values[reference]
        self._config = json.dumps(self._values).encode()

    def _release(self) -> None:
        """Drop the component, keep the inputs it had."""
        if self.component is not None:
            for reference, _, _ in self._active_inputs():
                container, position = self._real_reads[reference]
                self._values[reference] = container[position]
            self.component = None
            self._bind()

    # -- values --------------------------------------------------------------------------------------------------------
    def get_real(self, vrs: list[int]) -> list[float]:
        if self._dirty:
            self._freshen()
        reads = self._real_reads
        if len(vrs) > WIDE and self.component is not None and self._read_ports.hold(vrs, reads, self._y):
            return self._y[self._read_ports.places].tolist()
        try:
            return [container[i] for container, i in [reads[v] for v in vrs]]
        except KeyError:
            return self._get("Real", vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        writes = self._writes
        self._dirty = True
        if len(vrs) > WIDE and self.component is not None and self._written_ports.hold(vrs, writes, self._u):
            ports = self._written_ports
            self._u[ports.places] = values if ports.scales is None else ports.scales * values
            return
        try:
            for v, value in zip(vrs, values):  # noqa: B905 - pythonfmu gives lists of one length, and strict costs time
                container, i = writes[v]
                container[i] = value
        except KeyError:
            self._set("Real", vrs, values)

    def _get(self, type_: str, vrs: list[int]) -> list[Any]:
        reads = self._reads[type_]
        for v in vrs:
            if v not in reads:
                self._say(f"value reference {v} is no {type_} variable", Fmi2Status.error)
        return [container[i] for container, i in [reads.get(v, ((MISSING[type_],), 0)) for v in vrs]]

    def _set(self, type_: str, vrs: list[int], values: list[Any]) -> None:
        for v, value in zip(vrs, values, strict=True):
            known = v in self._reads[type_]
            if known and self._scalars[v].causality == "parameter":
                self._set_parameter(v, value)
            elif known and v in self._writes:
                container, i = self._writes[v]
                container[i] = value
            else:
                self._say(f"value reference {v} is no {type_} variable that can be set", Fmi2Status.error)

    def get_integer(self, vrs: list[int]) -> list[int]:
        return [round(v) for v in self._discrete("Integer", vrs)]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return [bool(v) for v in self._discrete("Boolean", vrs)]

    def _discrete(self, type_: str, vrs: list[int]) -> list[Any]:
        """Counts and flags lie among the outputs, which are real numbers; those that there are not are 0."""
        if self._dirty and any(v < len(self._scalars) and self._scalars[v].causality == "output" for v in vrs):
            self._freshen()
        return [0 if v != v else v for v in self._get(type_, vrs)]

    def get_string(self, vrs: list[int]) -> list[str]:
        return self._get("String", vrs)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set("Integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self._set("Boolean", vrs, values)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        self._set("String", vrs, values)

    def _set_parameter(self, reference: int, value: Any) -> None:
        """Take a parameter or an effect before the run; a value that cannot be used is refused and stops the run."""
        name = self._scalars[reference].name
        if self.running and not self._scalars[reference].tunable:
            self._say(f"{name} = {value!r} refused: this parameter is fixed after initialisation", Fmi2Status.warning)
            return
        try:
            variable = self.component_class.variables.get(name)
            checked = bool(value) if variable is None else variable.checked(value, self.instance_name)
        except Exception as error:
            self._refused[name] = str(error)
            self._say(str(error), Fmi2Status.error)
            return
        self._refused.pop(name, None)
        if checked != self._values[reference]:
            if self.running and self.component is not None:
                self._values[reference] = checked
                self._tune(name, checked)
            else:
                self._release()
                self._values[reference] = checked
        self._dirty = True

    def _tune(self, name: str, value: float) -> None:
        """Of a parameter that may change during the run: it acts from the next step on, and is part of a state."""
        if name in self.component.parameters:  # not of an effect that is off
            self.component.set(name, value)
        self._config = json.dumps(self._values).encode()

    # -- the run -------------------------------------------------------------------------------------------------------
    def setup_experiment(self, start_time: float, stop_time: float | None = None, tolerance: float | None = None) -> None:
        self.start_time = start_time
        self._dirty = True

    def exit_initialization_mode(self) -> None:
        if self._dirty:
            self._freshen()
        self.running = True

    def do_step(self, current_time: float, step_size: float) -> bool:
        try:
            if not self.running:
                self.exit_initialization_mode()
            if self._failure or self._refused or not 0.0 < step_size < inf or self._u.dot(self._u_zeros) != 0.0:
                return self._discard(current_time, self._obstacle(step_size))
            self.component.step(current_time, step_size)
            if self._y.dot(self._y_zeros) != 0.0:
                self._fail("output " + self._bad(self._y, self.component.outputs))
                return self._discard(current_time, self._failure)
            self._dirty = False
            return True
        except BaseException as error:
            self._fail(str(error) or type(error).__name__)
        return self._discard(current_time, self._failure)

    def _freshen(self) -> None:
        """Outputs that belong to the present inputs; before the run also the initial state."""
        self._dirty = False
        if self.running and self._failure:
            return
        try:
            if self.running:
                self.component.refresh()
            else:
                self._failure = ""
                self._initialize()
            if self._y.dot(self._y_zeros) != 0.0:
                bad = self._bad(self._u, self.component.inputs) or self._bad(self._y, self.component.outputs)
                if not self.running:
                    self._fail(bad)
                else:
                    self._say(f"t = {self.component.t:.9g}: {bad}", Fmi2Status.warning)
        except BaseException as error:
            self._fail(str(error) or type(error).__name__)

    def _initialize(self) -> None:
        if self.component is None:
            self._make()
        derivatives = self.component.u[1:].copy()  # set for the first step, perhaps
        self.component.initialize(self.start_time)
        self.component.u[1:] = derivatives

    # -- what goes wrong -----------------------------------------------------------------------------------------------
    def _say(self, message: str, status: Fmi2Status) -> None:
        """To the FMI logger; what stops a run also to Python's, because pythonfmu logs nothing unless loggingOn is set."""
        self.log(message.replace("%", "%%"), status)  # FMI loggers take a format
        if status >= Fmi2Status.discard:
            LOG.error(message if message.startswith(self.instance_name) else f"{self.instance_name}: {message}")

    def _fail(self, message: str) -> None:
        self._failure = message
        self._say(message, Fmi2Status.error)
        if self.component is None or not self.running:
            self._set_outputs(nan)  # there is no earlier result that could be read

    def _set_outputs(self, value: float) -> None:
        if self.component is not None:
            self._y[:] = value
        for reference, scalar in enumerate(self._scalars):
            if scalar.causality == "output":
                self._values[reference] = value

    @staticmethod
    def _bad(values: Any, names: tuple[str, ...]) -> str:
        """The first number that is not finite, with its name."""
        labels = [*names, *(f"der({n})" for n in names), *(f"der({n},2)" for n in names)]
        return next((f"{n} = {v}" for n, v in zip(labels, values.tolist(), strict=False) if not isfinite(v)), "")

    def _obstacle(self, step_size: float) -> str:
        """Why the next step cannot be made."""
        if not 0.0 < step_size < inf:
            return f"step size {step_size}, expected more than 0"
        if self._failure:
            return f"no step after a failure ({self._failure}); restore a state, or reset"
        if self._refused:
            return "; ".join(self._refused.values())
        return "input " + self._bad(self._u, self.component.inputs)

    def _discard(self, time: float, reason: str) -> bool:
        self._say(f"step from t = {time:.9g} s discarded: {reason}", Fmi2Status.discard)
        return False

    # -- state ---------------------------------------------------------------------------------------------------------
    def _get_fmu_state(self) -> bytes:
        try:
            if self.component is None:
                self._config = json.dumps(self._values).encode()
            status = json.dumps([self._failure, self._refused, self.running, self.start_time, self._dirty]).encode()
            data = b"" if self.component is None else self.component.save()
            return b"".join((HEAD.pack(len(self._config), len(status)), self._config, status, data))
        except Exception as error:
            self._fail(f"state cannot be saved: {error}")
            return b""

    def _set_fmu_state(self, state: bytes) -> None:
        try:
            n, m = HEAD.unpack_from(state)
            ends = HEAD.size + n, HEAD.size + n + m
            config, status, data = state[HEAD.size : ends[0]], json.loads(state[slice(*ends)]), state[ends[1] :]
            if config != self._config or (self.component is None) != (not data):
                self.component = None
                self._values[:] = json.loads(config)
                self._bind()
                if data:
                    self._make()
                    self.component.initialize(status[3])
            if data:
                self.component.restore(data)
            self._failure, self._refused, self.running, self.start_time, self._dirty = status
        except Exception as error:
            self._fail(f"state cannot be restored: {error}")

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return state

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> bytes:
        return state


class _Ports:
    """Where the values of the last wide calls live, kept for the next ones: one array operation instead of a loop over them."""

    def __init__(self) -> None:
        self._kept: dict[tuple[int, ...], tuple[list[int], bool, Any, Any]] = {}
        self._references: list[int] | None = None  # of the last call: a list is compared more quickly than looked up
        self._all = False
        self.places = np.zeros(0, dtype=np.intp)
        self.scales: Any = None  # factors of values that are second derivatives

    def hold(self, references: list[int], known: dict[int, tuple[Any, int]], array: Any) -> bool:
        """Whether all these references are elements of `array`, which `places` then tells."""
        if references != self._references:
            key = tuple(references)
            if key not in self._kept:
                if len(self._kept) == KEPT:
                    self._kept.clear()
                self._kept[key] = self._located(references, known, array)
            self._references, self._all, self.places, self.scales = self._kept[key]
        return self._all

    @staticmethod
    def _located(references: list[int], known: dict[int, tuple[Any, int]], array: Any) -> tuple[list[int], bool, Any, Any]:
        bound = [known.get(v, (None, 0)) for v in references]
        scales = [0.5 if isinstance(container, _Halved) else 1.0 for container, _ in bound]
        inside = [c.u if isinstance(c, _Halved) else c for c, _ in bound]
        all_ = all(isinstance(c, memoryview) and c.obj is array for c in inside)
        places = np.array([place for _, place in bound], dtype=np.intp)
        return list(references), all_, places, np.array(scales) if 0.5 in scales else None


class _Halved:
    """Second derivatives of the inputs; the component's `u` holds half of them."""

    def __init__(self, u: Any):
        self.u = u

    def __getitem__(self, position: int) -> float:
        return 2.0 * self.u[position]

    def __setitem__(self, position: int, value: float) -> None:
        self.u[position] = 0.5 * value


@cache
def _tables(component: Any) -> tuple[tuple[Scalar, ...], dict[str, int]]:
    scalars = interface(component)
    return scalars, {s.name: i for i, s in enumerate(scalars)}
