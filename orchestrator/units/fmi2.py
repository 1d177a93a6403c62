"""Units made of FMUs of FMI 2.0."""

from __future__ import annotations

import ctypes
from math import nan
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

from .call_table import Callback, CallTable, Held, call_table
from .fmu_simulator import FmuSimulator
from .inputs import WARNING
from .interface import SimulationEnded

DISCARD, PENDING = 2, 5
STEP_STATUS, LAST_TIME, TERMINATED = 0, 2, 3  # of fmi2GetStatus and its kin
POLL = 1e-4  # s between two looks at a step that another thread of the FMU takes


_running: WeakValueDictionary[int, FmuSimulator] = WeakValueDictionary()


@fmi2CallbackLoggerTYPE
def _LOGGER(environment, _name, status, _category, text):
    """One for all units, which it tells apart by their environment: FMPy's proxy hands everything to the last logger it got."""
    if (unit := _running.get(environment or 0)) is not None:
        unit.noted(text, status)


class Fmi2Simulator(FmuSimulator):
    """What model exchange and co-simulation share. `fmpy_class` is FMPy's class of the interface."""

    prefix = "fmi2"
    fmpy_class: Any = FMU2Slave

    def _instantiate(self) -> Any:
        fmu = self.fmpy_class(
            instanceName=self.name,
            guid=self.description.model.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self._interface().modelIdentifier,
        )
        fmu.instantiate(callbacks=self._callbacks(), loggingOn=True)
        return fmu

    def _callbacks(self) -> fmi2CallbackFunctions:
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        _running[id(self)] = self
        callbacks.componentEnvironment = id(self)
        addLoggerProxy(ctypes.byref(callbacks))
        return callbacks

    def _set_up(self) -> None:
        tolerance, (start, stop) = self._tolerance or 0.0, self._span
        self._call(
            "SetupExperiment",
            ctypes.c_int(tolerance > 0.0),
            ctypes.c_double(tolerance),
            ctypes.c_double(start),
            ctypes.c_int(stop is not None),
            ctypes.c_double(stop or 0.0),
        )

    def _enter_initialization(self) -> None:
        self._call("EnterInitializationMode")

    def start(self) -> None:
        self._call("ExitInitializationMode")
        self._started = True


class Fmi2CoSimulation(Fmi2Simulator):
    """An FMU of FMI 2.0 for co-simulation."""

    def wire(self, inputs: Any, outputs: Any) -> None:
        super().wire(inputs, outputs)
        self._do_step = self._function("DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self._instance = self._fmu.component
        self._held_values = np.zeros(len(self._rows[2]))

    def call_table(self) -> CallTable | None:
        """For compiled steps; None where they need Python."""
        interface = self._interface()
        if interface.canRunAsynchronuously:
            return None
        self.hold_anew()
        self._hand_over_held = Callback(self._hand_over_values)
        held = Held(self._rows[2], self._held_values, self._hand_over_held)
        return call_table(
            self._fmu.dll,
            self._fmu.component,
            self._input_names,
            self._output_names,
            interface.canInterpolateInputs,
            self._scalars,
            held,
        )

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
        """Compiled steps begin: whether none will be taken back; raises `SimulationEnded` where the FMU has ended it."""
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        return self._states.none

    def stepped(self, steps: int, t: float) -> None:
        """Compiled code has taken steps of this unit, the last one from t."""
        self._steps += steps
        self._time = t

    def stopped(self, status: int, t: float, h: float) -> None:
        """A call from compiled code had this status in the step from t to t + h; raises `StepFailed` unless it is done."""
        self._hand_over_held.raise_error()
        self._not_done(status, t, t + h)

    def step(self, t: float, h: float) -> None:
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        self._time = t
        status = self._do_step(self._instance, t, h, self._forget)
        self._steps += 1
        if status > WARNING:
            self._not_done(status, t, t + h)
        elif status == WARNING:
            self.messages.warned()

    def _not_done(self, status: int, t: float, end: float) -> None:
        """Wait for a step that goes on in the FMU's own thread; tell why one was not completed."""
        kind, place = ctypes.c_int, ctypes.c_void_p
        while status == PENDING:
            sleep(POLL)
            answer = ctypes.c_int(PENDING)
            self._check(self._function("GetStatus", kind, place)(self._instance, STEP_STATUS, ctypes.addressof(answer)))
            status = answer.value
        if status == DISCARD:
            ended, last = ctypes.c_int(), ctypes.c_double(t)
            if self._function("GetBooleanStatus", kind, place)(self._instance, TERMINATED, ctypes.addressof(ended)) > WARNING:
                ended.value = 0
            known = self._function("GetRealStatus", kind, place)(self._instance, LAST_TIME, ctypes.addressof(last)) <= WARNING
            # pythonfmu says of every step that was discarded that the simulation is to end
            if ended.value and not self.description.holds_component:
                self._step_start, self._step_end = t, end
                self._end_at(min(max(last.value, t), end) if known else t)
                return
            if known and last.value > t:
                self._failed(
                    status, f" and got to {last.value:.9g} s", f"A macro step of at most {last.value - t:.3g} s may help"
                )
        self._check(status)
