"""Units made of FMUs of FMI 2.0."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isnan, nan, ulp
from time import sleep
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from fmpy import calloc, free
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

from . import environment
from .call_names import OF_STEP
from .call_table import Callback, Held, fmu_table
from .discarded import ShorterSteps
from .fmu_simulator import DISCARD, NEAR, FmuSimulator
from .inputs import WARNING
from .interface import CallTable, PortValues, SimulationEnded
from .states import FmuState

PENDING = 5
STEP_STATUS, LAST_TIME, TERMINATED = 0, 2, 3  # of fmi2GetStatus and its kin
POLL = 1e-4  # s between two looks at a step that another thread of the FMU takes


_running: WeakValueDictionary[int, FmuSimulator] = WeakValueDictionary()


@fmi2CallbackLoggerTYPE
def _LOGGER(environment, _name, status, _category, text):
    """One for all units, which it tells apart by their environment: FMPy's proxy hands everything to the last logger it got."""
    if (unit := _running.get(environment or 0)) is not None:
        unit.noted(text, status)


class Fmi2Simulator(FmuSimulator):
    """What model exchange and co-simulation share."""

    prefix = "fmi2"

    def _callbacks(self) -> dict[str, Any]:
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        _running[id(self)] = self
        callbacks.componentEnvironment = id(self)
        addLoggerProxy(ctypes.byref(callbacks))
        return {"callbacks": callbacks}

    def _set_up(self) -> None:
        self._tell_span("SetupExperiment")

    def _enter_initialization(self) -> None:
        self._call("EnterInitializationMode")


class Fmi2CoSimulation(Fmi2Simulator):
    """An FMU of FMI 2.0 for co-simulation, which compiled code steps: a `SteppedFmu`."""

    fmpy_class = FMU2Slave
    driven: Callable[[], Sequence[PortValues | None]]
    _before: FmuState | None = None  # where the present step began, if the FMU can go back there

    def wire(self, inputs: Any, outputs: Any) -> None:
        super().wire(inputs, outputs)
        self._do_step = self._function("DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self._held_values = np.zeros(len(self._rows[2]))
        self._parts = ShorterSteps(self._interface(), self._span.parts and not self.description.holds_component)

    def start(self) -> None:
        super().start()
        if self._parts.may_go_back and self._interface().canGetAndSetFMUstate:
            self._before = self._states.of_steps()
            self._forget = int(self._states.none)

    def call_table(self) -> CallTable | None:
        interface = self._interface()
        if interface.canRunAsynchronuously:
            return None
        self.hold_anew()
        self._hand_over_held = Callback(self._hand_over_values)
        held = Held(self._rows[2], self._held_values, self._hand_over_held)
        table = fmu_table(
            self._stopped,
            self._fmu.dll,
            self._fmu.component,
            self._input_names,
            self._output_names,
            interface.canInterpolateInputs,
            self._scalars,
            held,
            0 if self._before is None else self._before.place,
            not self.description.holds_component,
        )
        return table and replace(table, stepped=self._stepped, fmu=self)

    def _hand_over_values(self, t: float, _: float) -> None:
        """Compiled code has changed `_held_values`; the last step was from t."""
        self._time = t
        self._hold(self._held_values.tolist())

    def _take(self, beside: Any) -> None:
        super()._take(beside)
        self.hold_anew()

    def hold_anew(self) -> None:
        """The inputs that compiled code finds in the FMU are those that it has."""
        self._held_values[:] = nan if self._last_held is None else self._last_held

    def begin_steps(self) -> bool:
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        return self._states.none

    def _stepped(self, t: float) -> None:
        self._time = t

    def count(self, steps: int, warnings: int) -> None:
        self._steps += steps
        if warnings:
            self.messages.warned(warnings)

    def _stopped(self, status: int, t: float, h: float) -> None:
        self._hand_over_held.raise_error()
        if status < OF_STEP:
            self._check(status)
        if self._reals is not None:
            self._reals.given = [row if row is None else [row[k] for k in self._rows[0]] for row in self.driven()]
        self._not_done(status - OF_STEP, t, t + h)

    def step(self, t: float, h: float) -> None:
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        self._time = t
        self._steps += 1
        if self._before is not None:
            self._states.note(self._before)
        status = self._do_step(self._instance, t, h, self._forget)
        if status > WARNING:
            self._not_done(status, t, t + h)
        elif status == WARNING:
            self.messages.warned()

    def _not_done(self, status: int, t: float, end: float) -> None:
        """A step was not made at once: wait for one that goes on in the FMU's own thread, make a discarded one in shorter ones."""
        self._step_start, self._step_end, at, h = t, end, t, end - t
        self._parts.begin(h)
        while True:
            if (status := self._waited_for(status)) == DISCARD:
                progress = self._progress(at, h)
                if self._ended is not None:
                    return
                self._shorten(at, h, progress, back=self._before is not None)
                if self._before is not None:
                    self._states.restore(self._before)
                else:
                    at += progress or 0.0
            else:
                self._check(status, self._parts.after)
                at += h
            h = self._parts.next(end - at)
            if h <= 2.0 * ulp(end):
                return
            if self._reals is not None:
                self._reals.drive_part(at - t, h)
            if self._before is not None:
                self._states.note(self._before)
            status = self._do_step(self._instance, at, h, self._forget)
            environment.restore()

    def _waited_for(self, status: int) -> int:
        """The status of a step that is over."""
        while status == PENDING:
            sleep(POLL)
            answer = ctypes.c_int(PENDING)
            self._check(self._asked("Status", STEP_STATUS, answer))
            status = answer.value
        return status

    def _progress(self, t: float, h: float) -> float | None:
        """So far the FMU got in a discarded step, s; None: not told. Where it ends the simulation, that is dealt with."""
        ended, last = ctypes.c_int(), ctypes.c_double(nan)
        if self._asked("BooleanStatus", TERMINATED, ended) > WARNING:
            ended.value = 0
        known = self._asked("RealStatus", LAST_TIME, last) <= WARNING and not isnan(last.value)
        # pythonfmu says of every step that was discarded that the simulation is to end
        if ended.value and not self.description.holds_component:
            self._end_at(min(max(last.value, t), t + h) if known else t)
        return max(last.value - t, 0.0) if known and t - NEAR * h <= last.value < t + h else None

    def _asked(self, name: str, kind: int, answer: Any) -> int:
        """The status of fmi2Get..., which gives an answer about the last step."""
        return self._guarded("Get" + name, ctypes.c_int, ctypes.c_void_p)(self._instance, kind, ctypes.addressof(answer))
