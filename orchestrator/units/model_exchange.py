"""An FMU for model exchange as a unit: it gives equations and events, the integrator is ours.

Inputs follow their polynomials wherever the integrator looks. A multistep integrator goes on across macro steps, and begins
anew behind an event, where an input jumps by more than the tolerance, behind `restore`, and behind `pack`, so that a run that
is resumed from a file takes the steps of the one that wrote it. Its past is no part of a state: a step that is repeated
is bit-identical each time, and what the first try gave within the tolerance. An event is one of time, announced by the
FMU, one of state, where an event indicator changes between positive and not positive, or one of a completed step; all of
them are dealt with inside the macro step.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from math import inf, isfinite, ulp
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Model, fmi2EventInfo
from fmpy.fmi3 import FMU3Model

from ...components.core.errors import StepFailed
from .description import Description
from .fmi2 import Fmi2Simulator
from .fmi3 import Fmi3Simulator
from .fmu_simulator import DiscreteStates, FmuSimulator
from .inputs import WARNING
from .interface import PortValues, SimulationEnded, Span
from .solvers import AGAIN, DONE, FAILED, Solver, SolverFailed, make_solver
from .states import FmuState
from .values import signature

DISCARD = 2
TOLERANCE = 1e-8  # relative, where neither scene nor FMU gives one; Van der Pol's oscillator over 20 s is then within 3e-6
EVENTS = 10_000  # in one step
EVENT_ULPS = (
    32.0  # units in the last place: an event of time is within a step where a sum of its period is that far behind its end
)
REAL, POINTER, SIZE = ctypes.c_double, ctypes.c_void_p, ctypes.c_size_t


class ModelExchange(FmuSimulator):
    """What FMUs for model exchange share, whatever their version, with an integrator.

    A version gives `_sizes` and `_update_states`, and the name of a function.
    """

    derivatives_function = "GetDerivatives"

    def __init__(
        self, name: str, description: Description, values: Mapping[str, Any], tolerance: float | None, method: str, span: Span
    ):
        self.kind = f"FMU for model exchange with {method}"
        self._method, self._relative = method, tolerance or TOLERANCE
        self._n = self._nz = 0  # states and event indicators, known when the sizes of arrays are
        self._solver: Solver | None = None
        self._goes_on_at: float | None = None  # s, where a multistep integrator stands; None: it has to begin anew
        self._left_inputs = np.zeros(0)  # what the moving inputs were when it got there
        self._worst = DONE  # worst status of an equation since the last look
        self._counts = dict.fromkeys(("solver_steps", "derivative_calls", "events"), 0)
        super().__init__(name, description, values, self._relative, None, span)

    # Calls of the library

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        super().wire(inputs, outputs)
        self._polynomial: tuple[np.ndarray, ...] | None = None  # values, slopes, quadratic of the moving inputs over this step
        self._origin = 0.0  # and when they begin
        self._last_held: list[Any] | None = None
        if self._reals is not None:
            block, moving = self._reals.block, len(self._rows[0])
            self._target = np.ctypeslib.as_array(block.buffer)
            self._moving_at = np.array(block.at[:moving])
            self._nominals = np.array([self._scalars[inputs[k]].nominal for k in self._rows[0]])
            self._set_moving = self._function("Set" + block.type.suffix, *signature(self._fmi3))
            companions = len(block.at) > moving  # "der(x)" behind them, which an integrator that asks for inputs does not need
            self._moving_arguments = (self._instance, *(block.first(moving) if companions else block.arguments))
        self._singles: tuple[np.ndarray, ...] | None = None  # the same of inputs of single precision
        if inputs:
            self.drive = self._drive
        self._set_time = self._function("SetTime", REAL)
        self._set_states = self._function("SetContinuousStates", POINTER, SIZE)
        self._get_states = self._function("GetContinuousStates", POINTER, SIZE)
        self._get_derivatives = self._function(self.derivatives_function, POINTER, SIZE)
        self._get_indicators = self._function("GetEventIndicators", POINTER, SIZE)
        self._tell_completed = self._function("CompletedIntegratorStep", self.truth_value, POINTER, POINTER)
        self._needs_completed = self._interface().needsCompletedIntegratorStep
        self._flags = (self.truth_value * 2)()  # event mode wanted, end of the simulation wanted
        flags = ctypes.addressof(self._flags)
        self._flag_places = (flags, flags + ctypes.sizeof(self.truth_value))

    def _move_inputs(self, t: float) -> int:
        """The continuous inputs where their polynomials are at t."""
        if self._singles is not None:
            self._levels.write(_at(self._singles, t - self._origin).tolist(), t)
        if self._polynomial is None:
            return DONE
        self._target[self._moving_at] = _at(self._polynomial, t - self._origin)
        return self._set_moving(*self._moving_arguments)

    def _at(self, t: float, x: int) -> int:
        """The FMU stands at t with the states at an address; the worst status of the calls."""
        status = self._set_time(self._instance, t)
        if self._n:
            status = max(status, self._set_states(self._instance, x, self._n))
        return max(status, self._move_inputs(t))

    def _answer(self, status: int) -> int:
        """A status of FMI as the integrator wants it; one that is bad is kept for the message."""
        if status <= WARNING:
            return DONE
        self._worst = max(self._worst, status)
        return AGAIN if status == DISCARD else FAILED

    def _f(self, t: float, x: int, dx: int) -> int:
        self._counts["derivative_calls"] += 1
        status = max(self._at(t, x), self._get_derivatives(self._instance, dx, self._n))
        if status > WARNING:
            return self._answer(status)
        return DONE if isfinite(sum((REAL * self._n).from_address(dx))) else AGAIN

    def _g(self, t: float, x: int, z: int) -> int:
        return self._answer(max(self._at(t, x), self._get_indicators(self._instance, z, self._nz)))

    # Events

    def start(self) -> None:
        super().start()
        self._n, self._nz = self._sizes()
        self._x, self._z, self._signs = np.zeros(self._n), np.zeros(self._nz), np.zeros(self._nz, dtype=bool)
        self._solver = make_solver(self._method, self._n, self._nz, self._f, self._g, self._relative)
        self._find_discrete_states(nominals=True)

    def _event(self, t: float) -> None:
        """In event mode: find the discrete states, and go on in continuous time."""
        self._time = t
        self._counts["events"] += 1
        self._call("EnterEventMode")
        self._find_discrete_states()

    def _find_discrete_states(self, nominals: bool = False) -> None:
        self._goes_on_at = None
        states = self._iterate_discrete_states()
        if states.ends:
            return
        self._call("EnterContinuousTimeMode")
        assert self._solver is not None
        if (nominals or states.nominals) and self._n:
            sizes = np.zeros(self._n)
            self._call("GetNominalsOfContinuousStates", POINTER(sizes.ctypes.data), SIZE(self._n))
            self._solver.tolerate(self._relative * np.abs(sizes))
        self._signs = self._present_signs()

    def _present_signs(self) -> np.ndarray:
        if self._nz:
            self._check(self._get_indicators(self._instance, self._z.ctypes.data, self._nz))
        return self._z > 0.0

    def _restart(self, t: float) -> None:
        """The integrator begins anew with the FMU's states, unless it stands there."""
        assert self._solver is not None
        if self._goes_on_at is not None and abs(self._goes_on_at - t) <= 4.0 * ulp(t) and not self._inputs_jump():
            return
        self._goes_on_at = None
        if self._n:
            self._check(self._get_states(self._instance, self._x.ctypes.data, self._n))
        self._solver.restart(t, self._x)

    def _inputs_jump(self) -> bool:
        """Whether the polynomials begin elsewhere than the last ones ended, by more than the tolerance."""
        if self._polynomial is None:
            return False
        values, left = self._polynomial[0], self._left_inputs
        allowed = self._relative * (self._nominals + np.abs(values))
        return values.size != left.size or bool((np.abs(values - left) > allowed).any())

    # Inputs

    def _drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        moving, singles, held = self._rows
        if held:
            self._hold([values[k] for k in held])
        rows = [np.zeros(len(values)) if row is None else np.asarray(row, dtype=float) for row in (values, slopes, quadratic)]
        if moving:
            self._polynomial = tuple(row[moving] for row in rows)
        if singles:
            self._singles = tuple(row[singles] for row in rows)

    def _hold(self, values: list[Any]) -> None:
        """Inputs that change at instants only; after the initialization they do it in event mode, and only where they change."""
        if not self._started:
            super()._hold(values)
        elif values != self._last_held and self._ended is None:
            self._call("EnterEventMode")
            super()._hold(values)
            self._find_discrete_states()
        self._last_held = values

    def set_texts(self, values: Sequence[str]) -> None:
        in_step = self._started and self._ended is None
        if in_step:
            self._call("EnterEventMode")
        super().set_texts(values)
        if in_step:
            self._find_discrete_states()

    # The step

    def step(self, t: float, h: float) -> None:
        if self._ended is not None:
            raise SimulationEnded(self.name, self._ended)
        self._time, self.event, self._origin = t, None, t
        self._steps += 1
        self._step_start, self._step_end = t, t + h
        try:
            self._integrate(t, t + h)
        except SolverFailed as error:
            if self._worst > DISCARD:
                self._failed(self._worst)
            self._healthy = False
            raise StepFailed(
                self.name,
                self._time,
                f"{self._method} cannot go on: {error}{self._log_lines()}",
                "A smaller macro step or another solver may help",
            ) from None
        finally:
            self._singles = None
            if self._polynomial is not None:  # the FMU keeps the inputs of the end
                self._left_inputs, self._polynomial = self._target[self._moving_at], None

    def _integrate(self, t: float, end: float) -> None:
        near, now = EVENT_ULPS * ulp(end), t
        self._check(max(self._set_time(self._instance, t), self._move_inputs(t)))
        if (self._present_signs() != self._signs).any():  # the inputs have jumped over a threshold
            self._event(t)
        self._restart(t)
        for _ in range(EVENTS):
            goal = self.next_event if self.next_event <= end + near else end
            now, event = self._until_event(now, goal)
            if event:
                if self.event is None and now - t > near:
                    self.event = now
                self._event(now)
            if self._ended is not None or (end - now <= near and self.next_event > now):
                return
            self._restart(now)
        raise StepFailed(self.name, now, f"more than {EVENTS} events in one step{self._log_lines()}")

    def _until_event(self, now: float, goal: float) -> tuple[float, bool]:
        """Integrate to the goal or to an event before it: (time reached, whether there is an event)."""
        solver = self._solver
        assert solver is not None
        while True:
            crossed = False
            if goal - now > 4.0 * ulp(goal):
                self._goes_on_at = None
                now, crossed = solver.advance(goal)
                self._goes_on_at = now if solver.multistep else None
                self._counts["solver_steps"] += 1
            else:
                now = max(goal, now)
            self._time = now
            self._check(self._at(now, solver.address))
            wanted, signs = self._completed(now), self._present_signs()
            if self._ended is not None:
                return now, False
            if wanted or crossed or now >= self.next_event or (signs != self._signs).any():
                return now, True
            if now >= goal:
                return now, False

    def _completed(self, now: float) -> bool:
        """Tell the FMU of a completed step; whether it wants event mode."""
        if not self._needs_completed:
            return False
        self._check(self._tell_completed(self._instance, self._states.none, *self._flag_places))
        wanted, ends = self._flags
        if ends:
            self._end_at(now)
        return bool(wanted) and not ends

    # The rest

    def restore(self, state: FmuState) -> None:
        super().restore(state)
        self._goes_on_at = None
        self._polynomial, self._singles, self._signs = None, None, self._present_signs()
        self._last_held = [None] * len(self._rows[2])
        for block in self._held.blocks:
            for row, value in zip(block.rows, self._read(block), strict=True):
                self._last_held[row] = value

    def pack(self, state: FmuState) -> bytes:
        self._goes_on_at = None
        return super().pack(state)

    def _beside(self) -> Any:
        return [super()._beside(), self._solver.step_size if self._solver is not None else None]

    def _take(self, beside: Any) -> None:
        others, size = beside
        super()._take(others)
        if self._solver is not None:
            self._solver.step_size = size

    def work(self) -> dict[str, int]:
        return {"steps": self._steps, **self._counts}

    def close(self) -> None:
        super().close()
        if self._solver is not None:
            self._solver.close()


def _at(polynomial: tuple[np.ndarray, ...], s: float) -> np.ndarray:
    """Values + slopes s + quadratic s²."""
    values, slopes, quadratic = polynomial
    return values + s * (slopes + s * quadratic)


class Fmi2ModelExchange(ModelExchange, Fmi2Simulator):
    """Of FMI 2.0."""

    fmpy_class = FMU2Model

    def _sizes(self) -> tuple[int, int]:
        model = self.description.model
        return len(model.derivatives), int(model.numberOfEventIndicators or 0)

    def _update_states(self) -> DiscreteStates:
        info = fmi2EventInfo()
        self._call("NewDiscreteStates", ctypes.pointer(info))
        return DiscreteStates(
            bool(info.newDiscreteStatesNeeded),
            bool(info.terminateSimulation),
            bool(info.nominalsOfContinuousStatesChanged),
            info.nextEventTime if info.nextEventTimeDefined else inf,
        )


class Fmi3ModelExchange(ModelExchange, Fmi3Simulator):
    """Of FMI 3.0: the numbers of states and indicators may follow from structural parameters."""

    fmpy_class = FMU3Model
    derivatives_function = "GetContinuousStateDerivatives"

    def _sizes(self) -> tuple[int, int]:
        sizes = (ctypes.c_size_t(), ctypes.c_size_t())
        for name, size in zip(("ContinuousStates", "EventIndicators"), sizes, strict=True):
            self._call(f"GetNumberOf{name}", ctypes.pointer(size))
        return sizes[0].value, sizes[1].value
