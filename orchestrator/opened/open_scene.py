"""The units of a scene, started for a run, for many, or to be asked something."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...components.core.component import Component
from ...components.core.contract import KernelComponent
from ..engine.algorithms import master_of
from ..engine.algorithms.contact import ContactSimulator
from ..engine.algorithms.energy import EnergyAccount
from ..engine.algorithms.machine import Steps
from ..engine.algorithms.master import Saved
from ..engine.algorithms.step_control import counts_alone
from ..engine.coupling import Endpoint
from ..engine.stepping.adaptive import clock_for, stepping_of
from ..engine.stepping.discontinuities import missed, stops_of
from ..engine.stepping.faults import Faults
from ..engine.stepping.loop import Steppable
from ..scene.names import displaced, place_of
from ..scene.scene import Scene
from ..scene.shorter_steps import late_samples
from ..units import Simulator, open_unit
from ..units.exit_guard import ExitGuard
from ..units.interface import Span
from .state import State

if TYPE_CHECKING:
    from ..units.native import NativeFmu


def _judging_steps(scene: Scene) -> tuple[Endpoint, ...]:
    """Outputs whose errors the control of the macro step goes by although nobody may take them, recorded or not."""
    if scene.master.control is None or scene.master.control.method != "doubling":
        return ()
    interfaces = scene.coupling.interfaces
    return tuple((u, n) for u, one in interfaces.items() for n, s in one.outputs.items() if counts_alone(n, s))


class Course:
    """What begins anew with every run of an open scene: the account of energy, the faults, and the stepping; with its states."""

    def __init__(self, open_scene: OpenScene):
        self.open_scene = open_scene
        scene, self.master, clock = open_scene.scene, open_scene.master, open_scene.clock
        coupling, correction = scene.coupling, scene.master.energy_correction
        self.account = EnergyAccount(self.master, coupling, correction=correction) if coupling.bonds else None
        self._faults, self._start = Faults(scene.faults, coupling, self.master, clock), scene.start_time
        stops = self._faults.stops()
        for tick, acts in stops_of(scene, self.master, clock).items():
            stops.setdefault(tick, []).extend(acts)
        self.stepping = stepping_of(scene, coupling, self.master, self.account, clock, stops)

    def start(self) -> None:
        """Initialize the units, with the faults that act from the start; raises `StepFailed` where values do not converge."""
        self._faults.before_start()
        (self.account or self.master).initialize(self._start)

    def save(self, inputs: Sequence[Any] = (), to_bytes: Callable[[State], bytes] | None = None) -> State:
        """All that the next steps depend on; every unit has to save its state. inputs, to_bytes: of the `State`."""
        return self.keep(self.stepping.tick, self.stepping.master.save(), inputs, to_bytes)

    def keep(
        self,
        tick: int,
        saved: Saved,
        inputs: Sequence[Any] = (),
        to_bytes: Callable[[State], bytes] | None = None,
        stepping: Mapping[str, Any] | None = None,
    ) -> State:
        """The state of what was saved at a tick; FMUs hold their parts of it until it is released, or they are closed."""
        stepping = self.stepping.state() if stepping is None else stepping
        state = State(self.open_scene.scene, self.master, saved, tick, stepping, inputs, to_bytes)
        states = self.open_scene.states
        states[:] = [*(one for one in states if one() is not None), weakref.ref(state)]
        return state

    def pack(self, state: State) -> dict[str, Any]:
        """A state but for its parameters as numbers, texts, arrays and bytes, for a file or another opening of the scene."""
        saved = self.master.pack(state.saved)
        return {"tick": state.tick, "master": saved, "stepping": state.stepping, "inputs": [*state.inputs]}

    def unpack(self, packed: Mapping[str, Any]) -> State:
        """The state that was packed, with the present parameters. Raises `ValueError` where it is of another scene."""
        saved = self.master.unpack(packed["master"])
        return self.keep(packed["tick"], saved, packed["inputs"], stepping=packed["stepping"])

    def restore(self, state: State) -> None:
        """Back, or on, to a state, with the parameters that it was saved with: what follows from these comes first."""
        if state.scene is not self.open_scene.scene:
            self.open_scene.begin_anew(state.scene)
            for unit, name, value in state.inputs:
                self.open_scene.units[unit].put(name, value)
            self.start()
        self.stepping.master.restore(state.saved)
        self.stepping.set_state(state.stepping)
        self.stepping.tick = state.tick

    def stretch(self, h: float, steps: range) -> Steps:
        """The given ones of steps of a length h of their own, s, which begin where the clock stands, and do not move it.

        What judges a run makes some from a state, and goes back to it: `rows` has the master's signals behind each of them.
        """
        stepper: Steppable = self.account if self.account is not None and self.account.correction else self.master
        return stepper.take_steps(self.stepping.clock.time(self.stepping.tick) + h * np.arange(steps.start, steps.stop), h)

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far, but for energy."""
        return [*self.master.warnings(), *self.stepping.warnings()]


def remarks_of(scene: Scene, units: Mapping[str, Simulator]) -> list[str]:
    """What a user should know of a scene before it is run; units: that were started for it."""
    remarks = {name: interface.remarks for name, interface in scene.coupling.interfaces.items()}
    for name, unit in units.items():  # one that was begun anew has other numbers than its interface was made of
        if unit.component is not None:
            remarks[name] = tuple(unit.component.doubts(scene.units[name].parameters))
    return [
        *scene.remarks,
        *late_samples(scene),
        *missed(scene),
        *(f"{name}: {text}" for name, texts in remarks.items() for text in texts),
    ]


class OpenScene:
    """A scene whose units are started, with the master on them and the clock: for one run, or for many that differ in numbers.

    units: by name, and the contacts, which are units of the graph.  scene: as it stands, with the numbers that the units have now;
    first: as it was opened.
    """

    def __init__(
        self,
        scene: Scene,
        stack: ExitStack,
        in_process: bool,
        rescue: Callable[[str], None] | None = None,
        native: Mapping[str, NativeFmu] | None = None,
        watched: Sequence[Endpoint] | None = None,
    ):
        """`stack` closes the units.

        rescue: called with what has happened where an FMU ends this process.  native: native FMUs of components.
        watched: outputs that the master reads in every step; None: those that a run of the scene needs, which has all that is
        recorded there, however seldom: the interval of the rows must not change what stands in them.
        """
        self.scene = self.first = scene
        self.clock = clock_for(scene, scene.coupling)
        stack.enter_context(ExitGuard([n for n, kind in scene.kinds.items() if kind.foreign and not kind.in_worker], rescue))
        self.units: dict[str, Simulator] = {}
        controlled = scene.master.control is not None and all(i.saves_state for i in scene.coupling.interfaces.values())
        span = Span(scene.start_time, scene.stop_time, parts=not controlled)
        for name, unit in scene.units.items():
            self.units[name] = open_unit(name, unit, in_process=in_process, native=(native or {}).get(name), span=span)
            stack.callback(self.units[name].close)
        self.units |= {contact.name: ContactSimulator(contact, scene.master.extrapolation) for contact in scene.contacts}
        if watched is None:
            watched = (*scene.coupling.signals, *scene.coupling.events, *_judging_steps(scene))
        self.master = master_of(scene, self.units, scene.coupling, watched)
        self.states: list[weakref.ref[State]] = []  # which units hold parts of
        stack.callback(self._release)
        # before the first run: cells of the master, and of each unit parameters and inputs
        starts = {name: (dict(component.parameters), component.u.copy()) for name, component in self._kernels.items()}
        self._before = self.master.records.block.memory.copy(), starts

    def _release(self) -> None:
        for reference in self.states:
            if (state := reference()) is not None:
                state.release()
        self.states.clear()

    @property
    def order(self) -> list[str]:
        """The units in the order of the master."""
        return list(self.master.node_of)

    @property
    def signals(self) -> list[Endpoint]:
        """Outputs that the master reads in every step, in the order of its rows."""
        return list(self.master.positions)

    def inputs(self, unit: str) -> dict[str, float]:
        """Present values of the inputs of a unit that connections drive."""
        node = self.master.node_of[unit]
        return {link.target[1]: float(value) for link, value in zip(node.links, node.inputs(), strict=True)}

    def alone(self, unit: str, h: float) -> None:
        """A step of h, s, of a unit by itself, which is left as it was; it has to save its state. Raises `StepFailed`."""
        one, values = self.units[unit], self.master.node_of[unit].inputs()
        state = one.save()
        try:
            if len(values):
                one.drive(values, None, None, h)
            one.step(self.scene.start_time, h)
        finally:
            one.restore(state)
            one.release(state)

    def takes(self, changes: Mapping[str, Any]) -> bool:
        """Whether changes of the scene, by name, are numbers that units can be begun anew with, see `begin_anew`."""
        return self._able and all(self._number(name) is not None for name in changes)

    @cached_property
    def _kernels(self) -> dict[str, KernelComponent]:
        """The components of the units whose steps are kernels."""
        return {name: unit.kernels for name, unit in self.units.items() if unit.kernels is not None}

    @cached_property
    def _able(self) -> bool:
        """Whether all units can be begun anew: whatever a run changes of them lies in the blocks of kernels."""
        scene, master = self.scene, self.master
        inherited = ("set", "initialize", "_prepare", "_parameters")
        own = [type(c) for name, c in self._kernels.items() if not scene.kinds[name].of_catalogue]
        return (
            self._kernels.keys() == self.units.keys()
            and master.in_batches
            and not (scene.faults or scene.contacts or scene.master.control or scene.master.energy_correction)
            and all(getattr(c, name) is getattr(KernelComponent, name) for c in own for name in (*inherited, "_initialize"))
            and all(c.stepped is Component.stepped for c in own)
        )

    def _number(self, change: str) -> tuple[str, str] | None:
        """The unit and the name of a parameter whose value is a number in a block; None for every other setting."""
        place = place_of(self.scene, change)
        unit, name = place.unit, place.parameter
        if not name:
            return None
        component = self._kernels[unit]
        known: Any = type(component).variables.get(name)
        whole = name.partition("[")[0]
        if name not in component.parameters or known.structural or (whole != name and whole in self.scene.units[unit].parameters):
            return None
        return unit, name

    def put(self, numbers: Mapping[str, Any]) -> None:
        """Set parameters that it `takes`, by name, before a run."""
        for change, value in numbers.items():
            unit, name = self._number(change)  # type: ignore[misc]
            self._kernels[unit].set(name, value)
        self.scene = displaced(self.scene, numbers)

    def begin_anew(self, scene: Scene) -> None:
        """Let units and master be as they were before the first run, with the numbers of a scene that has those it `takes`.

        Raises `BadInput`.
        """
        cells, starts = self._before
        self.master.begin_anew(cells)
        for unit, (parameters, u) in starts.items():
            component, given, before = self._kernels[unit], scene.units[unit].parameters, self.first.units[unit].parameters
            numbers = {} if given is before else {n: v for n, v in given.items() if n not in before or v != before[n]}
            for name, value in (parameters | numbers).items():
                if component.parameters[name] != value:
                    component.set(name, value)
            component.u[:], component.y[:] = u, 0.0
            component.refuse_unused(given)
        self.scene = scene


@contextmanager
def started(scene: Scene, *, in_process: bool = True, watched: Sequence[Endpoint] | None = None) -> Iterator[Course]:
    """A scene outside of a run, opened and initialized; arguments as of `OpenScene`. Raises `BadInput` and `StepFailed`."""
    with ExitStack() as stack:
        course = Course(OpenScene(scene, stack, in_process, watched=watched))
        course.start()
        yield course
