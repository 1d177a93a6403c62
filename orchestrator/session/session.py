"""A scene that is held: opened once, and then set, stepped, read, saved and taken back by whoever holds it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import cached_property
from html import escape
from math import isfinite
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed, nearest
from ...components.core.measure import is_quantity, number_in
from ...components.core.variables import SEED
from ..engine.coupling import Endpoint
from ..judgement.verification import verified_result
from ..opened.open_scene import Course, OpenScene
from ..opened.state import State
from ..run.checkpoint import checkpoint_of, header, restore
from ..run.recorders import reading
from ..run.results import Result
from ..run.run_info import describe_run
from ..run.watch import Watch
from ..scene.names import declared, elements, variable_of
from ..scene.scene import Scene
from ..units.discarded import warnings_of as of_discarded
from ..units.interface import Signal, SimulationEnded
from ..verified_file import verified_bytes, verified_content
from .estimating import Estimating

if TYPE_CHECKING:
    from ..derivatives.continuation import Orbits
    from ..derivatives.gradient import Gradient
    from ..derivatives.linear import Linear
    from ..derivatives.trim import SteadyState
    from ..engine.algorithms import Master

Value = float | int | bool | str | np.ndarray | Sequence[float]
SHOWN = 40  # outputs in a notebook


class Session(Estimating):
    """A scene in the hand. Its steps are bit-identical to those of `run`.

        with cosimo.open("en50318-2002") as sim:
            sim["pantograph.static_force"] = "130 N"
            sim.initialize()
            sim.until(2.0)
            print(sim["pantograph.contact_force"])

    A parameter is set before `initialize`, an input that nothing drives at any time. After a step that has failed, with
    `StepFailed`, the session can be taken back (`restore`), begun anew (`reset`) and closed. A session is used by one thread.
    """

    def __init__(self, scene: Scene, *, in_process: bool = True, native: bool = False):
        """in_process: components run in this process, else as FMUs.  native: as native FMUs. Units are opened by `initialize`."""
        self._unopened, self._in_process, self._native = scene, in_process, native
        self._where = f"session of {scene.name}"
        self._stack = ExitStack()
        self._open_scene: OpenScene | None = None
        self._inputs: dict[Endpoint, Any] = {}  # that were set by hand
        self._initialized, self._closed = False, False
        self._failure, self._ended = "", ""  # of a step; where a unit has ended the simulation
        self._unseen = False  # whether a step may be taken that nothing has to be asked before
        self._readers: dict[tuple[str, ...], Callable[[], np.ndarray]] = {}
        self._observers: list[Any] = []
        self._watch: Watch | None = None  # where rows are recorded
        self._free: dict[str, tuple[str, str, Signal]] = {}  # inputs that were set, by name

    # -- from the beginning to the end -------------------------------------------------------------------------------
    @property
    def scene(self) -> Scene:
        """The scene as it stands, with the parameters that were set."""
        return self._unopened if self._open_scene is None else self._open_scene.scene

    def initialize(self) -> None:
        """Open the units where that has not been done, and find their initial states, at the scene's start_time.

        Raises `BadInput` for what cannot start, `StepFailed` where initial values are not found.
        """
        self._alive()
        if self._initialized:
            raise BadInput(self._where, "initialize() of a scene that runs", "a session before its start", "reset() comes first.")
        open_scene = self._open()
        if open_scene.takes({}):
            open_scene.begin_anew(open_scene.scene)
        self._course = Course(open_scene)
        self._master, self._stepping = open_scene.master, self._course.stepping
        for (unit, name), value in self._inputs.items():
            open_scene.units[unit].put(name, value)
        self._course.start()
        self._stepping.run(self._observers, 0)
        self._initialized = True

    def _open(self) -> OpenScene:
        """The open scene; opens it, if need be."""
        if self._open_scene is None:
            native = {}
            if self._native:
                from ..opened.native import native_fmus  # which loads a compiler

                native = native_fmus(self.scene)
            self._open_scene = OpenScene(self.scene, self._stack, self._in_process, native=native)
        return self._open_scene

    def step(self, steps: int = 1) -> None:
        """So many macro steps, fewer where the scene ends. Raises `StepFailed` where a unit fails, `BadInput` behind the end."""
        try:
            if type(steps) is int and steps == 1 and self._unseen and self._stepping.step_unseen():
                return
            self._check_step(steps)
            self._stepping.run(self._observers, steps)
            self._stepping.look_ahead()
            self._unseen = not self._observers
        except SimulationEnded as end:
            self._ended, self._unseen = str(end), False
        except StepFailed as error:
            self._fail(error)
            raise

    def _check_step(self, steps: int) -> None:
        self._started("step()")
        if not isinstance(steps, int) or isinstance(steps, bool) or steps < 1:
            raise BadInput(f"{self._where}: step", repr(steps), "a whole number of macro steps, 1 at least")
        if self.done:
            end, remedy = (
                (self._ended, "") if self._ended else (f"stop_time = {self.scene.stop_time:g} s", "Take a later stop_time.")
            )
            raise BadInput(f"{self._where}: step", f"a step behind {end}", "a time within the scene", remedy)

    def _fail(self, error: StepFailed) -> None:
        """A unit has failed: until the session is taken back or begun anew, nothing holds."""
        self._failure, self._unseen = str(error), False
        self._readers.clear()

    def until(self, t: float) -> None:
        """Macro steps up to the first instant of all units that is not before t, s; none where t has been reached."""
        self._started("until()")
        if not self.time <= t <= self.scene.stop_time:
            stretch = f"a time from {self.time:.9g} s, which is reached, to stop_time = {self.scene.stop_time:g} s"
            raise BadInput(f"{self._where}: until", f"{t:.9g} s", stretch)
        while self.time < t and not self.done:
            self.step(max(int((t - self.time) / self.scene.master.step) - 1, 1))

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._stepping.clock.time(self._stepping.tick) if self._initialized else self.scene.start_time

    @property
    def done(self) -> bool:
        """Whether the scene's stop_time is reached, or a unit has ended the simulation."""
        return self._initialized and (self._stepping.tick == self._stepping.end or bool(self._ended))

    def reset(self, seed: int | None = None) -> None:
        """Back to before `initialize`, with the parameters as they were set; what was recorded and set as an input is gone.

        seed: for every parameter of the scene that is a seed.
        """
        self._alive()
        self._initialized, self._unseen, self._failure, self._ended = False, False, "", ""
        self._inputs.clear()
        self._readers.clear()
        self._observers, self._watch, self._live = [], None, None
        if self._open_scene is not None and not self._open_scene.takes({}):
            self._close_units()
        if seed is not None:
            for name in self.seeds:
                self[name] = seed

    @property
    def seeds(self) -> list[str]:
        """Parameters of the scene that are a seed, by name; of effects that are on."""
        interfaces = self.scene.coupling.interfaces
        return [
            f"{unit}.{name}"
            for unit, cls in self.scene.component_classes.items()
            for name, v in cls.variables.items()
            if v.structural == SEED and ("." not in name or interfaces[unit].effects.get(name.rpartition(".")[0]))
        ]

    def close(self) -> None:
        """Close the units; a session that is closed can be asked nothing."""
        self._close_units()
        self._closed, self._initialized = True, False

    def _close_units(self) -> None:
        self._stack.close()
        self._unopened, self._open_scene, self._unseen, self._live = self.scene, None, False, None
        self._readers.clear()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- values by name ----------------------------------------------------------------------------------------------
    def __getitem__(self, name: str) -> Any:
        """A parameter, an input or an output by its name, "unit.variable"; an array by the name of all its elements, (n,).

        Outputs and driven inputs have values from `initialize` on. Raises `BadInput` with the near names.
        """
        unit, variable = variable_of(self.scene, name, self._where)
        interface = self.scene.coupling.interfaces[unit]
        if variable in interface.outputs or elements(interface.outputs, variable):
            self._started(f"the output {name!r}")
            if variable in interface.outputs and interface.outputs[variable].is_text:
                return reading(self._units, [(unit, variable)], texts=True)()[0]
            return self.values([name]) if variable not in interface.outputs else self._typed(unit, variable)
        if variable in interface.inputs:
            return self._input(unit, variable)
        return self._parameter(unit, variable)

    def __setitem__(self, name: str, value: Value) -> None:
        """Set a parameter before `initialize`, an input that nothing drives at any time; "250 km/h" is converted.

        Raises `BadInput` for a name, a value or a moment that cannot be.
        """
        if self._initialized and name in self._free:
            self._put(*self._free[name], value)
            return
        self._alive()
        unit, variable = variable_of(self.scene, name, self._where)
        interface = self.scene.coupling.interfaces[unit]
        if variable in interface.outputs:
            raise BadInput(f"{self._where}: {name}", repr(value), "a parameter or an input", "It is an output.")
        if variable in interface.inputs and (self._initialized or not interface.inputs[variable].is_text):
            self._put(unit, variable, interface.inputs[variable], value)
            self._free[name] = unit, variable, interface.inputs[variable]
            return
        if self._initialized:
            raise BadInput(
                f"{self._where}: {name}",
                f"{value!r} at t = {self.time:.9g} s",
                "a parameter that is set before initialize()",
                "reset() goes back to there.",
            )
        given = value.tolist() if isinstance(value, np.ndarray) else list(value) if isinstance(value, tuple) else value
        number = isinstance(given, float | int) and not isinstance(given, bool)
        if number and self._open_scene is not None and self._open_scene.takes({name: given}):
            self._open_scene.put({name: declared(self.scene, unit)[variable].checked(given, f"{self._where}: {unit}")})
            return
        changed = self.scene.with_changes({name: given})
        self._close_units()
        self._unopened = changed

    def values(self, names: Sequence[str]) -> np.ndarray:
        """Present values of outputs, (n,): numbers, truth values as 0 and 1; arrays by the names of all their elements."""
        read = self._readers.get(key := tuple(names))
        if read is None:
            self._started("values()")
            read = self._readers[key] = self._reader(key)
        return read()

    def _reader(self, names: tuple[str, ...]) -> Callable[[], np.ndarray]:
        ends: list[Endpoint] = []
        for name in names:
            unit, variable = variable_of(self.scene, name, self._where)
            outputs = self.scene.coupling.interfaces[unit].outputs
            cells = [variable] if variable in outputs else elements(outputs, variable)
            if not cells or outputs[cells[0]].is_text:
                known = [
                    f"{u}.{n}" for u, i in self.scene.coupling.interfaces.items() for n, s in i.outputs.items() if not s.is_text
                ]
                raise BadInput(f"{self._where}: values", repr(name), "an output that is a number", nearest(name, known))
            ends += [(unit, n) for n in cells]
        positions = self._master.positions
        if all(end in positions for end in ends):
            signals, places = self._master.signals, np.array([positions[end] for end in ends], dtype=np.intp)
            return lambda: signals[places]
        sample = reading(self._units, ends)
        return lambda: np.array(sample(), dtype=float)

    def _typed(self, unit: str, variable: str) -> float | int | bool:
        (value,) = self.values([f"{unit}.{variable}"]).tolist()
        kind = self.scene.coupling.interfaces[unit].outputs[variable].kind
        if kind == "boolean":
            return bool(value)
        return int(value) if kind in ("integer", "enumeration") else float(value)

    def _parameter(self, unit: str, variable: str) -> Any:
        known = self._open().units[unit].parameters()
        if variable in known:
            return known[variable]
        if cells := elements(known, variable):
            return np.array([known[n] for n in cells])
        raise BadInput(self._where, repr(f"{unit}.{variable}"), "a variable that has a value here", "Its effect is off.")

    def _input(self, unit: str, variable: str) -> Any:
        """The present value of an input."""
        if not self._initialized or (unit, variable) in self._inputs:
            start = self.scene.coupling.interfaces[unit].inputs[variable].start
            return self._inputs.get((unit, variable), start)
        assert self._open_scene is not None
        driven = self._open_scene.inputs(unit)
        return driven[variable] if variable in driven else self.scene.coupling.interfaces[unit].inputs[variable].start

    def _put(self, unit: str, variable: str, signal: Signal, value: Any) -> None:
        """Set an input from now on, and let what depends on it within the instant follow."""
        where = f"{self._where}: {unit}.{variable}"
        if source := self._sources.get((unit, variable)):
            raise BadInput(where, repr(value), "an input that nothing drives", f"It is connected to {'.'.join(source)}.")
        if is_quantity(value) and not signal.is_text:
            value = number_in(value, signal.unit, where, signal.measure, signal.relative)
        if not (isinstance(value, str) if signal.is_text else isinstance(value, Real | np.bool_) and isfinite(value)):
            raise BadInput(where, repr(value), "a text" if signal.is_text else f"a finite number in {signal.unit or '1'}")
        self._inputs[unit, variable] = value if signal.is_text else float(value)
        if not self._initialized:
            return
        self._started("an input")
        master, node = self._master, self._master.node_of[unit]
        before = master.signals.copy()
        try:
            self._units[unit].put(variable, self._inputs[unit, variable])
            node.read()
            master.follow(self.time)
        except StepFailed as error:
            self._fail(error)
            raise
        if not (moved := set(np.flatnonzero(master.signals != before).tolist())):
            return
        for other in master.nodes:  # what jumps tells nothing of where inputs go
            if not moved.isdisjoint(other.sources):
                other.restart()
        if self._course.account is not None:
            self._course.account.restart()

    @cached_property
    def _sources(self) -> dict[Endpoint, Endpoint]:
        """What drives each input that is driven."""
        coupling = self.scene.coupling
        return {link.target: link.source for link in (*coupling.links, *coupling.texts)}

    @property
    def _units(self) -> dict[str, Any]:
        assert self._open_scene is not None
        return self._open_scene.units

    def gradient(self, of: str | Sequence[str] | None = None, by: str | Sequence[str] | None = None, **options: Any) -> Gradient:
        """Derivatives of figures of a whole run by parameters, with those that were set; as of `cosimo.gradient`.

        The session stays where it is.
        """
        from ..derivatives.gradient import gradient

        return gradient(self._scene_anew, of, by, **options)

    def linearize(self, inputs: Sequence[str] = (), outputs: Sequence[str] = (), steps: int | None = None) -> Linear:
        """The scene about this instant as a linear system in discrete time, over so many macro steps; it stays where it is.

        inputs: that nothing drives.  outputs: default those that are recorded.  steps: default those that units with rates of their
        own and controllers have in common. Raises `BadInput` for what has no derivatives.
        """
        from ..derivatives.linear import linearize

        self._started("linearize()")
        return linearize(self.scene, self._master, self.time, inputs, outputs, steps)

    def trim(self, free: Sequence[str] = (), want: Mapping[str, float | str] | None = None, **options: Any) -> SteadyState:
        """The steady state that Newton's method reaches from here; the session stays where it is.

        free: parameters and inputs that are found.  want: as many outputs and their values, "0.5 m/s".  options: as of
        `derivatives.trim.trim`. Raises `BadInput` with the reason where there is none.
        """
        from ..derivatives.trim import trim

        self._alive()
        return trim(self._scene_anew, free, want, at=self.place, given=self._known_inputs, **options).points[0][1]

    def orbit(self, *forcing: Any, **options: Any) -> Orbits:
        """Periodic orbits from the scene's start, as of `derivatives.continuation.orbits`; the session stays where it is."""
        from ..derivatives.continuation import orbits

        self._alive()
        return orbits(self._scene_anew, *forcing, **options)

    @property
    def _scene_anew(self) -> Scene:
        """The scene as it stands, read anew, for those who open it themselves."""
        return self.scene if self._open_scene is None or self.scene is self._open_scene.first else self.scene.with_changes({})

    @property
    def place(self) -> tuple[Master, float] | None:
        """The master, and the time in s, for what follows from where the scene stands; None before the start."""
        return (self._master, self.time) if self._initialized and not self._failure else None

    # -- states ------------------------------------------------------------------------------------------------------
    def save(self) -> State:
        """All that the next steps depend on, between two steps; `restore` takes it, as often as wanted.

        bytes(state) is the same for a file, for a session of the same scene in any process. `BadInput`: a unit cannot, or it estimates.
        """
        self._started("save()")
        self._refuse_estimated("save")
        unable = [n for n, i in self.scene.coupling.interfaces.items() if not i.saves_state]
        if unable:
            raise BadInput(f"{self._where}: save", ", ".join(unable), "units that can save their state")
        return self._course.save([[*end, value] for end, value in self._inputs.items()], self._to_bytes)

    def restore(self, state: State | bytes) -> None:
        """Back, or on, to a saved state; rows that were recorded behind it are gone.

        Raises `BadInput` for one of another scene, or of units that were closed meanwhile.
        """
        self._alive()
        self._refuse_estimated("restore")
        if not self._initialized:
            self.initialize()
        if isinstance(state, bytes):
            self._take_bytes(state)
        else:
            self._go_to(state)
        self._failure, self._ended = "", ""
        if self._watch is not None:
            self._watch.signals.forget(self.time)

    def _go_to(self, state: State) -> None:
        self._check_held(state, "restore")
        self._course.restore(state)
        self._hold(state.inputs)

    def _check_held(self, state: State, what: str) -> None:
        if state.released or state.master is not self._master:
            raise BadInput(f"{self._where}: {what}", "a state of units that were closed", "a state that this session has saved")

    def _to_bytes(self, state: State) -> bytes:
        self._check_held(state, "bytes")
        unable = [n for n, i in self.scene.coupling.interfaces.items() if not i.packs_state]
        if unable:
            raise BadInput(f"{self._where}: bytes", ", ".join(unable), "units whose state can go to a file")
        beside = {"t": self._stepping.clock.time(state.tick), "parts": {}}
        return verified_bytes(header(state.scene, self._master) | self._course.pack(state) | beside)

    def _take_bytes(self, content: bytes) -> None:
        where, shown = f"{self._where}: restore", f"{len(content)} bytes"
        try:
            read = verified_content(content)
        except ValueError:
            raise BadInput(where, shown, "bytes of a state that a session has saved, undamaged") from None
        checkpoint = checkpoint_of(read, self.scene, where, shown, Path())
        restore(checkpoint, self._course, {}, where)
        self._hold(checkpoint.state["inputs"])

    def _hold(self, inputs: Sequence[Any]) -> None:
        self._inputs = {(unit, name): value for unit, name, value in inputs}

    # -- what was seen -----------------------------------------------------------------------------------------------
    def record(self) -> None:
        """From now on a row of all that the scene records, at every macro step; see `result`."""
        self._started("record()")
        self._watch = Watch(self._course, every_step=True)
        self._observers, self._unseen = [self._watch.signals], False
        self._watch.signals(self._stepping.tick, self.time)

    def result(self) -> Result:
        """What was recorded so far, as of `cosimo.run`: its summary, report and plots; not verified."""
        if self._watch is None:
            raise BadInput(f"{self._where}: result", "a session that records nothing", "a call of record() before")
        self._watch.signals.flush()
        outcome, message = ("done", self._ended) if self.done else ("stopped", f"held at t = {self.time:.9g} s")
        if self._failure:
            outcome, message = "failed", self._failure
        info = describe_run(self.scene, self.scene.coupling, self._units, self._master, outcome, message)
        info = replace(info, warnings=(*self._watch.warnings(self.scene), *of_discarded(info.counters.units)))
        return verified_result(self._watch.result(self.scene, info), "no")

    # -- what it is --------------------------------------------------------------------------------------------------
    def _alive(self) -> None:
        if self._closed:
            raise BadInput(self._where, "a session that is closed", "one that is open", "cosimo.open gives another one.")

    def _started(self, what: str) -> None:
        self._alive()
        if self._failure:
            raise BadInput(self._where, f"{what} after a step that failed", "restore(), reset() or close()", f"{self._failure}.")
        if not self._initialized:
            raise BadInput(self._where, f"{what} before the start", "a call of initialize() before")

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"at t = {self.time:.9g} s" if self._initialized else "before its start"
        return f"<Session of {self.scene.name}: {', '.join(self.scene.units)}; {state}{', failed' if self._failure else ''}>"

    def _repr_html_(self) -> str:
        rows = ""
        if self._initialized and not self._failure:
            interfaces = self.scene.coupling.interfaces
            numbers = [(u, n) for u, i in interfaces.items() for n, s in i.outputs.items() if not s.is_text]
            values = self.values([".".join(end) for end in numbers[:SHOWN]])
            for (unit, name), value in zip(numbers, values, strict=False):
                rows += f"<tr><td>{escape(unit)}.{escape(name)}</td><td>{value:.6g}</td>"
                rows += f"<td>{escape(interfaces[unit].outputs[name].unit)}</td></tr>"
            rows += f"<tr><td>and {len(numbers) - SHOWN} more</td></tr>" if len(numbers) > SHOWN else ""
        return f"<b>{escape(repr(self)[1:-1])}</b><table>{rows}</table>"
