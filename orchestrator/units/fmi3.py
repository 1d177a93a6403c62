"""Units made of FMUs of FMI 3.0; those for co-simulation with early return and event mode where the FMU has them.

An FMU with event mode handles its events inside `step`: it returns at the event, its discrete states are iterated, and
it goes on to the end of the step. Where it announces the time of its next event, it is stepped exactly to it. Inputs that
change at instants only are handed over in event mode, and only when they have changed.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from math import inf, ulp
from typing import Any, cast

import numpy as np
from fmpy.fmi3 import FMU3Slave

from ...components.core.errors import StepFailed
from .discarded import ShorterSteps
from .fmu_simulator import DISCARD, DiscreteStates, FmuSimulator
from .inputs import Others, Reals, Requested
from .interface import SimulationEnded

EVENTS = 10_000  # in one step
BOOLEAN, DOUBLE, POINTER = ctypes.c_bool, ctypes.c_double, ctypes.c_void_p


class Fmi3Simulator(FmuSimulator):
    """What model exchange and co-simulation share."""

    prefix = "fmi3"
    truth_value = BOOLEAN

    def _callbacks(self) -> dict[str, Any]:
        return {"logMessage": self._logged}

    def _logged(self, _environment: Any, status: int, _category: bytes, text: bytes) -> None:
        self.noted(text, status)

    def _set_values(self, values: Any) -> None:
        """Structural parameters first, in a mode of their own: they fix the sizes of arrays."""
        sizes = {n: v for n, v in values.items() if self._scalars[n].variable.causality == "structuralParameter"}
        if sizes:
            self._call("EnterConfigurationMode")
            super()._set_values(sizes)
            self._call("ExitConfigurationMode")
        super()._set_values({n: v for n, v in values.items() if n not in sizes})

    def _enter_initialization(self) -> None:
        self._tell_span("EnterInitializationMode")

    def _update_states(self) -> DiscreteStates:
        """In event mode: one iteration of the discrete states."""
        flags, when = np.zeros(5, dtype=np.uint8), DOUBLE()
        places = [POINTER(flags.ctypes.data + k) for k in range(5)]
        self._call("UpdateDiscreteStates", *places, ctypes.pointer(when))
        again, ends, nominals, _, defined = flags.tolist()
        return DiscreteStates(bool(again), bool(ends), bool(nominals), when.value if defined else inf)


class Fmi3CoSimulation(Fmi3Simulator):
    """An FMU of FMI 3.0 for co-simulation."""

    fmpy_class = FMU3Slave

    def _callbacks(self) -> dict[str, Any]:
        interface = self._interface()
        self._events = interface.hasEventMode
        self._stops = self._events and interface.canHandleVariableCommunicationStepSize  # can be stepped to an event
        asked = {self._scalars[n].variable.valueReference for n in self.description.requested}
        return super()._callbacks() | {
            "eventModeUsed": self._events,
            "earlyReturnAllowed": True,
            "requiredIntermediateVariables": sorted(asked),
            "intermediateUpdate": self._requested if asked else None,
        }

    def _requested(
        self,
        _environment: Any,
        t: float,
        wants_inputs: bool,
        _gives: bool,
        _finished: bool,
        _may_return: bool,
        early: Any,
        _when: Any,
    ) -> None:
        """The FMU asks for its inputs inside a step."""
        early[0] = False
        if wants_inputs and isinstance(self._reals, Requested):
            self._reals.move(t - self._origin)

    def _make_reals(self, names: Sequence[str]) -> Reals:
        return (
            Requested(names, *self._common(self._function))
            if set(names) <= self.description.requested
            else super()._make_reals(names)
        )

    def start(self) -> None:
        super().start()
        if self._events:
            self._handle_events()

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        super().wire(inputs, outputs)
        self._do_step = self._function("DoStep", DOUBLE, DOUBLE, BOOLEAN, POINTER, POINTER, POINTER, POINTER)
        self._enter_event_mode, self._enter_step_mode = (self._guarded(n) for n in ("EnterEventMode", "EnterStepMode"))
        self._parts = ShorterSteps(self._interface(), self._span.parts and not self.description.holds_component)
        # event, termination, early return: three bytes that are looked at as one word
        self._origin = 0.0  # s, the beginning of the step
        if isinstance(self._reals, Requested):
            self.step = self._step_with_requests  # type: ignore[method-assign]
        self._word, self._reached = ctypes.c_uint32(), DOUBLE()
        flags = ctypes.addressof(self._word)
        self._answers = (flags, flags + 1, flags + 2, ctypes.addressof(self._reached))

    def _hand_over(self, inputs: Others, values: Sequence[Any]) -> None:
        """In event mode, if the FMU has it and runs."""
        event = self._events and self._started
        if event:
            self._check(self._enter_event_mode(self._instance))
        super()._hand_over(inputs, values)
        if event:
            self._handle_events()

    def _take(self, beside: Any) -> None:
        super()._take(beside)
        self._reached.value = -inf  # an older time is not that of a discarded step

    def _handle_events(self) -> None:
        """In event mode: find the discrete states, and go on to step mode."""
        if not self._iterate_discrete_states().ends:
            self._check(self._enter_step_mode(self._fmu.component))

    def step(self, t: float, h: float) -> None:
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        self._time, self.event, self._step_start, self._step_end = t, None, t, t + h
        self._steps += 1
        if self.next_event <= t + h:
            self._parts.begin(h)
            self._step_by_events(t, h, self._advance(t, self._stride(t, h)))
        else:
            status = self._do_step(self._instance, t, h, self._forget, *self._answers)
            if status or self._word.value:
                self._parts.begin(h)
                self._step_by_events(t, h, self._answered(status, t, t + h))

    def _step_with_requests(self, t: float, h: float) -> None:
        self._origin = t
        Fmi3CoSimulation.step(self, t, h)
        cast(Requested, self._reals).stepped()

    def _stride(self, t: float, h: float) -> float:
        """The part of h up to the next event, if the FMU can be stepped to it; short enough after a discarded step."""
        h = self._parts.next(h)
        return min(h, max(self.next_event - t, 0.0)) if self._stops else h

    def _advance(self, t: float, h: float) -> tuple[float, bool]:
        """One call of the FMU: (time reached, whether there is an event)."""
        if h <= 0.0:
            return t, True
        return self._answered(self._do_step(self._instance, t, h, self._forget, *self._answers), t, t + h)

    def _answered(self, status: int, t: float, end: float) -> tuple[float, bool]:
        event, ends, early, _ = self._word.value.to_bytes(4, "little")
        reached = self._reached.value if early else end
        if ends:
            reached = min(max(t, self._reached.value), end)
            self._end_at(reached)
            return reached, False
        if status == DISCARD:  # the FMU is where it was, or at a time that it tells
            progress = self._reached.value - t if t < self._reached.value < end else 0.0
            self._shorten(t, end - t, progress, back=False)
            self._word.value = 0
            return t + progress, False
        self._check(status, self._parts.after)
        return reached, bool(event)

    def _step_by_events(self, t: float, h: float, first: tuple[float, bool]) -> None:
        """The rest of a step behind its first part, with all events up to its end."""
        reached, event = first
        end = t + h
        for _ in range(EVENTS):
            if self._ended is not None:
                return
            due = self._events and (event or self.next_event <= reached)
            if self.event is None and (due or (reached < end and self._word.value)):
                self.event = reached
            self._time = reached
            if due:
                self._check(self._enter_event_mode(self._instance))
                self._handle_events()
            left = end - reached
            if left <= 2.0 * ulp(end):
                return
            reached, event = self._advance(reached, self._stride(reached, left))
        raise StepFailed(self.name, self._time, f"more than {EVENTS} events in one step{self._log_lines()}")
