"""What units made of an FMU share, whatever its version: its lifetime, its values, its states, its log.

FMPy extracts and loads; the calls of every step go past it, straight to the library with buffers made once,
because FMPy builds new arrays in each call and then costs more than the FMU.
"""

from __future__ import annotations

import ctypes
import logging
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import isfinite, ulp
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from .. import working_directory
from . import environment
from .description import Description
from .discarded import ShorterSteps
from .fmu_messages import Messages
from .folders import give, take
from .inputs import WARNING, Functions, Others, Reals, means
from .interface import ARRAY_THRESHOLD, WITHOUT_END, PortValues, SimulationEnded, Simulator, Span
from .outputs import derivatives, reader
from .states import FmuState, States
from .values import Block, blocks, decoded, same

if TYPE_CHECKING:
    from ...components.core.component import Component

LOG = logging.getLogger("cosimo.units")  # a worker process keeps it for the message about its end
DISCARD, FATAL = 2, 4
NEAR = 1e-6  # of a step
ITERATIONS = 100  # of the discrete states at an event
STATUS = {2: "discarded the call", 3: "reported an error", 4: "reported a fatal error"}
_once: set[str] = set()  # running FMUs that allow one instance in a process only


class DiscreteStates(NamedTuple):
    """What an FMU answers to an iteration of its discrete states; `next_event` in s."""

    again: bool  # it needs another one
    ends: bool  # it ends the simulation
    nominals: bool  # nominal values of continuous states have changed
    next_event: float


class FmuSimulator(Simulator):
    """An FMU that is extracted, instantiated and has its parameters; see `Simulator` for the order of calls.

    A version of FMI gives `prefix`, `truth_value`, `_callbacks`, `_set_up` and `_enter_initialization`, an interface of it
    `fmpy_class` and `step`; what has event mode `_update_states`, and model exchange `_sizes`, too.
    """

    kind = "FMU"
    prefix = ""
    truth_value: Any = ctypes.c_int
    fmpy_class: Any
    _update_states: Callable[[], DiscreteStates]  # in event mode: one iteration of the discrete states
    _sizes: Callable[[], tuple[int, int]]  # numbers of continuous states and of event indicators
    time_of_step: Callable[[], float] | None = None  # s, where compiled code takes the steps
    next_event = float("inf")  # s, where the FMU asks for an event
    _parts: ShorterSteps  # of an FMU for co-simulation, from `wire` on

    def __init__(
        self,
        name: str,
        description: Description,
        values: Mapping[str, Any],
        tolerance: float | None = None,
        twin: Component | None = None,
        span: Span = WITHOUT_END,
    ):
        """`twin`: the component that is in the FMU, to ask why it cannot start; FMI hands over a status, no reasons.

        span: what the FMU is told of the run.
        """
        self.name, self.description, self._values, self._twin = name, description, dict(values), twin
        self._tolerance, self._fmi3 = tolerance, description.fmi3
        self._span, self._time, self._steps = span, span.start, 0
        self._initializing = self._started = False
        self._ended: float | None = None  # s, where the FMU ended the simulation
        self._step_start = self._step_end = 0.0  # s, of the present step
        self._near = 0.0  # s: so near to the end of a step an end of the simulation completes it
        self._forget = 1  # argument of a step: no earlier state will come back
        self._last_held: list[Any] | None = None  # values and texts that the FMU has
        self._last_texts: list[str] | None = None
        self._usable = self._healthy = False  # whether the instance may be touched, and whether all its calls went well
        self._scalars = description.scalars
        self._log: deque[str] = deque(maxlen=3)
        self.messages = Messages()
        self._alone = self._identifier() if self._interface().canBeInstantiatedOnlyOncePerProcess else ""
        if self._alone in _once:
            raise BadInput(
                f"units.{name}",
                f"a second instance of {description.path}",
                "one; this FMU allows no more in a process",
                'Write isolation = "process".',
            )
        self._folder = ""
        try:
            self._folder = take(description.path)
        except Exception as error:  # FMPy raises bare exceptions, zipfile those of many kinds
            raise BadInput(
                f"units.{name}", f"{description.path} cannot be unpacked: {error}", "", "Get a sound FMU file."
            ) from None
        try:
            with working_directory.kept():  # FMPy goes to the library's folder, and stays there when loading fails
                self._fmu = self._instantiate()
            environment.restore()  # a library may change it where it is loaded
            self._usable = self._healthy = True
        except Exception as error:  # FMPy raises bare exceptions
            self.close()
            raise BadInput(
                f"units.{name}",
                f"{description.path} cannot be started: {error}{self._log_lines()}",
                "",
                "Has it a library for this platform?",
            ) from None
        if self._alone:
            _once.add(self._alone)
        self._states = States(self._fmi3, self._fmu.component, self._guarded, self._failed)
        try:
            self._set_up()  # first: some FMUs take back all start values there
            self._set_values(values)
        except StepFailed as error:
            self.close()
            raise BadInput(f"units.{name}", error.reason, "parameter values the FMU accepts") from None
        except BadInput:
            self.close()
            raise

    def _interface(self) -> Any:
        return self.description.interface

    def _identifier(self) -> str:
        return f"{self.description.path}:{self._interface().modelIdentifier}"

    def _instantiate(self) -> Any:
        """FMPy's object of the FMU with an instance."""
        fmu = self.fmpy_class(
            instanceName=self.name,
            guid=self.description.model.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self._interface().modelIdentifier,
        )
        fmu.instantiate(loggingOn=True, **self._callbacks())
        return fmu

    def _callbacks(self) -> dict[str, Any]:
        """Arguments of FMPy's `instantiate`."""
        raise NotImplementedError

    def _set_up(self) -> None:
        """What comes before the parameters and the initialization."""

    def _enter_initialization(self) -> None:
        raise NotImplementedError

    def _tell_span(self, function: str) -> None:
        """Call a function that takes tolerance, start and stop of the run."""
        tolerance, (start, stop, _), real = self._tolerance or 0.0, self._span, ctypes.c_double
        given = self.truth_value(tolerance > 0.0), real(tolerance), real(start), self.truth_value(stop is not None)
        self._call(function, *given, real(stop or 0.0))

    def start(self) -> None:
        self._call("ExitInitializationMode")
        self._started = True

    def _iterate_discrete_states(self) -> DiscreteStates:
        """In event mode: the answer to the last iteration of the discrete states, where they no longer change."""
        nominals = False
        for _ in range(ITERATIONS):
            states = self._update_states()
            nominals = nominals or states.nominals
            if states.ends:
                self._end_at(self._time)
                return states
            if not states.again:
                self.next_event = states.next_event
                return states._replace(nominals=nominals)
        reason = f"the discrete states do not converge in {ITERATIONS} iterations"
        raise StepFailed(self.name, self._time, reason + self._log_lines())

    # Calls of the library

    def noted(self, message: bytes | None, status: int) -> None:
        """A message of the FMU's log."""
        text = (message or b"").decode(errors="replace").strip()
        self._log.append(text)
        self.messages.add(self._time if self.time_of_step is None else self.time_of_step(), status, text)
        LOG.info("%s: %s", self.name, text)

    def _function(self, name: str, *types: Any) -> Callable[..., int]:
        """A C function under this unit's own argument types: indexing the library gives a new object each time.

        It may leave another floating-point environment: for calls behind which a `Callback` looks after that.
        """
        function = self._fmu.dll[self.prefix + name]
        function.argtypes, function.restype = (ctypes.c_void_p, *types), ctypes.c_int
        return function

    def _guarded(self, name: str, *types: Any) -> Callable[..., int]:
        """The same for all other calls."""
        return environment.guarded(self._function(name, *types))

    def _call(self, name: str, *arguments: Any) -> None:
        status = self._guarded(name, *(type(a) for a in arguments))(self._fmu.component, *arguments)
        self._check(status)

    def _log_lines(self) -> str:
        return "".join(f"\n  log: {line}" for line in self._log)

    def _failed(self, status: int, more: str = "", remedy: str = "") -> None:
        self._usable, self._healthy = status != FATAL, False
        reason = f"the FMU {STATUS.get(status, f'returned status {status}')}{more}{self._log_lines()}"
        raise StepFailed(self.name, self._time, reason, remedy)

    def _shorten(self, t: float, h: float, progress: float | None, back: bool) -> None:
        """The next steps get shorter, as of `ShorterSteps.discarded`; raises `StepFailed` where none is to be tried."""
        why = self._parts.discarded(h, progress, back) if self._parts.wanted else ""
        if why or not self._parts.wanted:
            got, remedy = (
                (f" and got to {t + progress:.9g} s", f"A macro step of at most {progress:.3g} s may help")
                if progress
                else ("", "")
            )
            self._failed(DISCARD, got + why, remedy)

    def _end_at(self, t: float) -> None:
        """The FMU ends the simulation: where that is the end of a step, all units complete it, and the next one is not begun.

        A step that is repeated to an end inside of it ends at the next tick of the clock, which may be a little later.
        """
        self._ended = t
        self._near = max(self._near, 4.0 * ulp(t), NEAR * (self._step_end - self._step_start))
        if not self._started or self._step_end - t > self._near:
            raise SimulationEnded(self.name, t)

    # Values

    def _set_values(self, values: Mapping[str, Any]) -> None:
        """Parameters and start values; of arrays all elements, because they can only be set as a whole."""
        given: dict[str, Any] = {}
        partly = {self._scalars[n].variable.name for n in values if self._scalars[n].size > 1}
        if partly:
            given = {n: s.start for n, s in self._scalars.items() if s.variable.name in partly}
        given |= values
        if missing := [n for n, value in given.items() if value is None]:
            raise BadInput(
                f"units.{self.name}.parameters",
                f"no value for {missing[0]!r}",
                "values for all elements of its array",
                "The FMU gives no start value for an array of this size.",
            )
        others = Others(self.name, list(given), *self._common())
        others.write(list(given.values()), 0.0)

    def _confirm_values(self) -> None:
        """Read back what was set; set again what the FMU has lost on its way here, and refuse what it does not take."""
        lost = self._differing(self._values)
        if lost:
            variables = {self._scalars[n].variable.name for n in lost}
            again = {
                n: v
                for n, v in self._values.items()
                if self._scalars[n].variable.name in variables and self._scalars[n].variable.causality != "structuralParameter"
            }
            with suppress(StepFailed):  # refused: the message below gives the FMU's log
                FmuSimulator._set_values(self, again)
                lost = self._differing({n: self._values[n] for n in lost})
        for name, actual in lost.items():
            raise BadInput(
                f"units.{self.name}.parameters",
                f"{name} = {self._values[name]!r}, which the FMU has as {actual!r} in initialization mode{self._log_lines()}",
                "a value that the FMU keeps",
                "It resets, limits or ignores this variable: leave it out, or set what it depends on.",
            )

    def _differing(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Those of some values that the FMU has otherwise, as it has them."""
        actual: dict[str, Any] = {}
        names = list(values)
        for block in blocks([self._scalars[n] for n in names], self._fmi3):
            actual |= zip([names[row] for row in block.rows], self._read(block), strict=True)
        return {n: actual[n] for n, value in values.items() if not same(value, actual[n])}

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self._input_names, self._output_names, self._instance = tuple(inputs), tuple(outputs), self._fmu.component
        scalars = [self._scalars[n] for n in inputs]
        held = [k for k, s in enumerate(scalars) if s.discrete]
        levels = [k for k, s in enumerate(scalars) if not s.discrete and s.variable.type == "Float32"]
        moving = [k for k in range(len(inputs)) if k not in {*held, *levels}]
        self._reals = self._make_reals([inputs[k] for k in moving]) if moving else None
        self._levels, self._held = (Others(self.name, [inputs[k] for k in part], *self._common()) for part in (levels, held))
        self._rows = moving, levels, held
        if not inputs:
            self.drive, self.update = _nothing, _nothing
        elif self._reals is not None and len(moving) == len(inputs):
            self.drive, self.update = self._reals.drive, self._reals.write
        else:
            self.drive, self.update = self._drive_mixed, self._update_mixed
        self.get = self.reader(outputs, len(outputs) > ARRAY_THRESHOLD, self._function)

    def _make_reals(self, names: Sequence[str]) -> Reals:
        return Reals(names, self.description.interpolates, *self._common(self._function))

    def _common(self, functions: Functions | None = None) -> tuple[Any, ...]:
        return self._scalars, self._fmi3, self._fmu.component, functions or self._guarded, self._failed

    def _drive_mixed(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        moving, levels, held = self._rows
        mean = values if slopes is None else means(values, slopes, quadratic, h)
        self._hold([values[k] for k in held])
        self._levels.write([mean[k] for k in levels], self._time)
        if self._reals is not None:
            first, *higher = (None if row is None else [row[k] for k in moving] for row in (values, slopes, quadratic))
            self._reals.drive(first, higher[0], higher[1], h)

    def _update_mixed(self, values: PortValues) -> None:
        self._drive_mixed(values, None, None, 0.0)

    def _hold(self, values: list[Any]) -> None:
        """Inputs that change at instants only: the FMU gets them when they do."""
        if values != self._last_held and self._ended is None:
            self._hand_over(self._held, values)
            self._last_held = values

    def _hand_over(self, inputs: Others, values: Sequence[Any]) -> None:
        """Inputs that have changed at this instant."""
        inputs.write(values, self._time)

    def put(self, name: str, value: float | str) -> None:
        self._hand_over(Others(self.name, [name], *self._common()), [value])

    def wire_texts(self, inputs: Sequence[str]) -> None:
        self._texts = Others(self.name, inputs, *self._common())

    def set_texts(self, values: Sequence[str]) -> None:
        if list(values) != self._last_texts and self._ended is None:
            self._hand_over(self._texts, values)
            self._last_texts = list(values)

    def text_reader(self, names: Sequence[str]) -> Callable[[], list[str]]:
        by_type = blocks([self._scalars[n] for n in names], self._fmi3)

        def read() -> list[str]:
            texts = {row: text for block in by_type for row, text in zip(block.rows, self._read(block), strict=True)}
            return [texts[row] for row in range(len(names))]

        return read

    def _read(self, block: Block) -> list[Any]:
        """Present values of a block's scalars."""
        self._check(self._guarded("Get" + block.type.suffix, *block.argument_types)(self._fmu.component, *block.arguments))
        return decoded(block)

    def _check(self, status: int, after: str = "") -> None:
        if status > WARNING:
            self._failed(status, after)
        if status == WARNING:
            self.messages.warned()

    def reader(self, names: Sequence[str], arrays: bool = False, functions: Functions | None = None) -> Callable[[], PortValues]:
        return reader(names, arrays, self._inexact, *self._common(functions))

    def _inexact(self, name: str, value: int) -> None:
        raise StepFailed(
            self.name,
            self._time,
            f"output {name} is {value}, beyond the whole numbers up to 2^53 that can be handed over exactly",
        )

    def initialize(self, t: float, values: PortValues) -> None:
        if not self._initializing:
            self._initializing = True
            self._enter_initialization()
            if self._twin is None:
                self._confirm_values()
            for block in (*([self._reals.block] if self._reals else []), *self._levels.blocks, *self._held.blocks):
                if not block.whole:  # elements of arrays that nothing drives keep their values
                    self._read(block)
        try:
            self.update(values)
            if self._twin is not None and not isfinite(sum(self.get())):  # of a foreign FMU the master says which
                raise StepFailed(self.name, t, f"the FMU gives no finite initial values{self._log_lines()}")
        except StepFailed:
            if self._twin is not None:
                for name, value in zip(self._input_names, values, strict=True):
                    self._twin.set(name, value)
                self._twin.initialize(t)  # raises with the component's own words, which may be `BadInput`
            raise

    # States and derivatives

    def save(self, reuse: FmuState | None = None) -> FmuState:
        self._forget = 0
        return self._states.save(self._beside(), reuse)

    def restore(self, state: FmuState) -> None:
        self._states.restore(state)
        self._healthy, self._ended = True, None  # whatever it reported in a step that is taken back
        self._take(state.beside)

    def _beside(self) -> Any:
        """What belongs to a state beside the FMU's own: numbers and texts."""
        return self.next_event, self._last_held, self._last_texts

    def _take(self, beside: Any) -> None:
        self.next_event, self._last_held, self._last_texts = beside

    def release(self, state: FmuState) -> None:
        self._states.release(state)
        self._forget = int(self._states.none)

    def pack(self, state: FmuState) -> bytes:
        return self._states.pack(state)

    def unpack(self, packed: bytes) -> FmuState:
        self._forget = 0
        return self._states.unpack(packed)

    def jacobian(self) -> np.ndarray:
        return derivatives(self._output_names, self._input_names, *self._common())

    def parameters(self) -> dict[str, Any]:
        """Also what nobody has set, by its start value; not what belongs to an effect that is off."""
        effects = {n: s.start for n, s in self._scalars.items() if n.startswith("effects.")} | self._values
        own = {
            n: s.start
            for n, s in self._scalars.items()
            if s.variable.causality in ("parameter", "structuralParameter")
            and s.start is not None
            and effects.get(f"effects.{n.partition('.')[0]}", True)
        }
        return own | self._values

    def work(self) -> Mapping[str, float]:
        return {"steps": self._steps, **self._parts.work()}

    def log_messages(self) -> Messages:
        """What the FMU has said so far; nothing of a component's FMU, whose reasons Python's log has."""
        return self.messages if self._twin is None else Messages()

    def close(self) -> None:
        if self._usable:  # after a fatal error the instance must not be touched
            if self._healthy:  # after an error only the last of these calls is allowed
                self._states.close()
                if self._started:
                    self._guarded("Terminate")(self._fmu.component)
            self._fmu.freeInstance()
            environment.restore()
            self._usable = False
        _once.discard(self._alone)
        if self._folder:
            give(self._folder, again=not self._alone)  # what allows no second instance may not stand a second run, either
            sys.path[:] = [p for p in sys.path if not p.startswith(self._folder)]  # pythonfmu leaves an entry at each start
            self._folder = ""


def _nothing(*_: Any) -> None:
    """For a unit without driven inputs."""
