"""The master: the table of signals, initialization, and the loop of kernels that takes the steps of an algorithm.

The program has only the rows that the scene needs, so unused features cost nothing in a step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import inf, isfinite
from operator import itemgetter
from typing import Any, final

import numpy as np

from ....components.core.errors import StepFailed
from ...settings import MasterSettings
from ...units import Simulator
from ..coupling import Coupling, Endpoint
from .algorithm import class_of
from .feedthrough import Feedthrough
from .initial import Groups, InitializationResult
from .initial_kernels import RUNAWAY
from .layout import lay_out
from .loops import LoopSolver
from .machine import Machine, Space, Steps, singly
from .network import Network, RowRange
from .records import EXTRAPOLATED, FORESEE, INTERPOLATED, LOOK, PUSH, READ, UPDATE
from .texts import Texts

NONE: np.ndarray = np.zeros(0, dtype=np.int64)


class Runaway(StepFailed):
    """Outputs are not finite. The caller, who knows the scene, adds the advice."""


class Unstable(Runaway):
    """A coupling that has grown without bound."""


@dataclass
class Saved:
    """A master and its units at an instant; cells: its records and signals; memory: of the algorithm; account: of an `EnergyAccount`."""

    units: list[Any]
    cells: np.ndarray
    steps: int
    jacobians: list[np.ndarray | None]  # of the algebraic loops, (n, n) each
    memory: Any
    account: Any = None


@final
class Master:
    """`initialize`, then `step` for each macro step; `signals` holds the outputs read in every step.

    The table of signals may be longer than `positions`, for values that only the master goes by; `sample` gives the outputs alone,
    in their order.
    """

    def __init__(
        self,
        units: Mapping[str, Simulator],
        coupling: Coupling,
        settings: MasterSettings,
        watched: Sequence[Endpoint] = (),
        end: float = inf,
    ):
        """watched: outputs to read in every step although no connection needs them. end: s, of the run; units with a rate of their
        own take a shorter last step to it."""
        kind = class_of(settings.algorithm)
        order = settings.order or kind.order(coupling, tuple(units))
        ranks = {name: k for k, name in enumerate(order)}
        self.coupling, self.steps = coupling, 0
        self.no_numbers: dict[Endpoint, float] = {}  # outputs that nothing uses and that were no numbers -> s, when first
        self.network = network = Network(
            units, coupling, watched, order, settings, lambda link: kind.extrapolated(link, ranks, coupling), kind.consistent
        )
        self.texts = Texts(units, coupling) if coupling.texts else None  # behind the nodes, which wire the units
        self.algorithm = algorithm = kind(network, settings)
        self.feedthrough = feedthrough = Feedthrough(network, delayed=settings.feedthrough == "delayed")
        self._step, self._acts = network.rows(*algorithm.acts, *feedthrough.acts), network.rows(*algorithm.acts)
        self._finish, self._push = network.rows(*feedthrough.acts), network.rows((PUSH, network.fed))
        self._foresee = network.rows((FORESEE, network.fed))
        jumping = [node for node in network.nodes if coupling.interfaces[node.unit.name].is_discontinuous]
        self._jump = network.rows((UPDATE, jumping), (READ, jumping))
        for node in network.nodes:
            node.look_rows = network.rows((LOOK, [node]))
        self._groups = Groups(network)
        self.records = self._groups.records = lay_out(network, end, self._groups.layout)
        self.signals: np.ndarray = self.records.memory.signals[: network.table]
        self.sample = self.signals[: len(network.positions)].tolist
        self.machine = Machine(network.nodes, self.records, self.texts)
        self.nodes, self.node_of, self.positions = network.nodes, network.node_of, network.positions
        self._begin = algorithm.memory
        self.in_batches = bool(algorithm.acts) and not feedthrough.loops and self.texts is None  # many steps are one call

    @property
    def loops(self) -> list[LoopSolver]:
        """The algebraic loops that are solved."""
        return self.feedthrough.loops

    @property
    def initialization(self) -> list[InitializationResult]:
        """How each group has come to its initial values."""
        return self._groups.results

    # -- the run -----------------------------------------------------------------------------------------------------
    def initialize(self, t: float) -> None:
        """Initialize the units and solve the loops; raises `StepFailed` where values do not converge."""
        self.initialize_units(t)
        for node in self.nodes:
            node.unit.start()
            node.read()
        self.machine.address()
        self.records.memory.units["time"] = t
        for solver in self.loops:
            solver.solve(self.machine, t)
        self.check_finite(t)
        self.machine.perform(self._push, t, 0.0)

    def prepare(self) -> None:
        """Put what units go by that are initialized before their sources into the table of signals."""
        self._groups.prepare()

    def initialize_units(self, t: float) -> None:
        """Initialize the groups of the graph, those that feed others first; raises `StepFailed` where values do not converge."""
        self.prepare()
        self.machine.initialize(t)
        self._groups.check(t, self.check_finite)

    def step(self, t: float, h: float) -> None:
        """One macro step from t to t + h."""
        if self.texts is not None:
            self.texts.hand_over()
        if self.machine.fmus:
            self.machine.begin()
        if self.in_batches:
            beyond = self.machine.step(self._step, t, h)
        else:
            if self.algorithm.acts:
                self.machine.perform(self._acts, t, h)
            else:
                self.algorithm.advance(self.machine, t, h)
            solved = not self.loops or self.algorithm.solves_loops
            if not solved:
                self.feedthrough.solve(self.machine, t + h)
            beyond = self.machine.step(self._finish if solved else self._push, t, h)
        self.steps += 1
        if beyond:
            self.check_finite(t + h)

    def let_jump(self, t: float) -> None:
        """Let signals of tables be what they are behind a jump at an instant, between two steps."""
        self.machine.perform(self._jump, t, 0.0)

    def follow(self, t: float) -> None:
        """Let the outputs follow inputs that were changed at an instant, between two steps."""
        for node in self.nodes:
            if node.unit_record["ends"][0] == INTERPOLATED:
                node.jump()
        self.feedthrough.solve(self.machine, t)

    def foresee(self, h: float) -> None:
        """Note of every node where extrapolation will have taken its inputs after h."""
        self.machine.perform(self._foresee, 0.0, h)

    def take_steps(self, times: np.ndarray, h: float, sampled: np.ndarray = NONE, saved: Sequence[int] = ()) -> Steps:
        """Macro steps from each of `times`, s, of length h, in as few calls as possible.

        sampled: (m,), steps counted from 0 behind which `inputs` are wanted; saved: those behind which the master is saved. Both,
        and all but `rows` and `failure` of what is returned, where steps are taken `in_batches`.
        """
        if not self.in_batches:
            return singly(self, self, times, h)
        steps, states = self.machine.space(times, sampled), list[Any]()
        for last in (*(step + 1 for step in saved), times.size):
            before = steps.done
            failure = self.machine.take_batch(self._step, steps, h, last)
            self.steps += steps.done - before
            if failure is None and steps.beyond:
                failure = self._beyond(steps, h)
            if steps.done < last or failure is not None:
                break
            if last < times.size:
                states.append(self.save())
        self.records.ask(halt=0)
        return steps.completed(states, failure)

    def _beyond(self, steps: Space, h: float) -> BaseException | None:
        """What is wrong with the signals behind the last step, which counts only where that is nothing."""
        try:
            self.check_finite(float(steps.times[steps.done - 1]) + h)
        except StepFailed as error:
            steps.done -= 1
            return error
        return None

    def so_far(self) -> Steps:
        """What has been completed of a batch that is under way."""
        return self.machine.so_far()

    def watch(self, ends: Sequence[Endpoint]) -> slice | None:
        """Columns of a batch's `outputs` in which these outputs will stand; None where not all are those of components."""
        at: list[int] = []
        for name, of_unit in groupby(ends, key=itemgetter(0)):
            unit = self.node_of[name].unit if name in self.node_of else None
            if unit is None or (there := unit.outputs_at([output for _, output in of_unit])) is None:
                return None
            at += there
        return self.machine.watch(at)

    def halt(self) -> None:
        """End a batch behind its present step."""
        self.records.ask(halt=1)

    def owe(self, integrals: np.ndarray) -> None:
        """What bonded inputs still have to be given: their integrals over time, (B,)."""
        links, units = self.records.memory.links, self.records.memory.units
        links["owed"][self.records.memory.bonded] = integrals
        for bond in self.coupling.bonds:
            units["corrected"][[self.node_of[link.target[0]].index for link in bond.links]] = 1

    def extrapolated(self) -> np.ndarray:
        """Of all inputs whether they were extrapolated, (L,)."""
        return np.array([node.unit_record["ends"][0] == EXTRAPOLATED for node in self.nodes for _ in node.links], dtype=bool)

    def begin_anew(self, cells: np.ndarray) -> None:
        """Before another run, as it was when its block was copied to `cells`."""
        self.records.block.stand(cells)
        self.machine.watch_nothing()
        self._remember(0, [None] * len(self.loops), self._begin)

    def rows(self, name: str) -> RowRange:
        """Rows of the program: of a whole "step", of "push", which keeps the inputs of an instant, of "follow", or of "jump"."""
        return {"step": self._step, "push": self._push, "follow": self.feedthrough.rows, "jump": self._jump}[name]

    def counters(self) -> dict[str, Any]:
        """For run.json; algorithms add their own."""
        counters: dict[str, Any] = {
            "steps": self.steps,
            "initial_sweeps": max((group.sweeps + group.secants for group in self.initialization), default=0),
            "initial_residual": max((group.residual for group in self.initialization), default=0.0),
        }
        if self.loops:
            counters["algebraic_loops"] = {solver.loop.text: solver.counters() for solver in self.loops}
        return counters | self.algorithm.counters()

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far."""
        sample = dict(zip(self.positions, self.sample(), strict=True))
        texts = [
            f"{unit}.{name} was no number at t = {t:.9g} s{'' if isfinite(sample[unit, name]) else ', nor at the end'}; "
            "no connection uses it"
            for (unit, name), t in self.no_numbers.items()
        ]
        return texts + self.algorithm.warnings(self.steps)

    def save(self, reuse: Saved | None = None) -> Saved:
        """Everything a repeated step depends on; `reuse`: an older one that may be overwritten."""
        units = [node.unit.save(reuse.units[k] if reuse else None) for k, node in enumerate(self.nodes)]
        jacobians = [loop.newton.jacobian for loop in self.loops]
        return Saved(units, self.records.block.memory.copy(), self.steps, jacobians, self.algorithm.memory)

    def restore(self, saved: Saved) -> None:
        """Take back what `save` gave; it can be restored again."""
        self.records.block.stand(saved.cells)
        for node, state in zip(self.nodes, saved.units, strict=True):
            node.unit.restore(state)
        self._remember(saved.steps, saved.jacobians, saved.memory)

    def pack(self, saved: Saved) -> dict[str, Any]:
        """What `save` gave for a file, or for another master of the same scene: numbers, arrays, and of units bytes."""
        units = [node.unit.pack(state) for node, state in zip(self.nodes, saved.units, strict=True)]
        return vars(saved) | {"units": units, "cells": saved.cells.view(np.int64)[self.records.changing]}

    def unpack(self, packed: Mapping[str, Any]) -> Saved:
        """For `restore`, what was packed; raises `ValueError` where that was of a master of another size."""
        saved = Saved(**packed)
        saved.cells = self.records.with_changing(packed["cells"])
        saved.units = [node.unit.unpack(state) for node, state in zip(self.nodes, packed["units"], strict=True)]
        return saved

    def release(self, saved: Saved) -> None:
        """Give back what units hold for it."""
        for node, state in zip(self.nodes, saved.units, strict=True):
            node.unit.release(state)

    def _remember(self, steps: int, jacobians: Sequence[np.ndarray | None], memory: Any) -> None:
        self.steps, self.algorithm.memory = steps, memory
        for loop, jacobian in zip(self.loops, jacobians, strict=True):
            loop.newton.jacobian = jacobian

    def look_away(self, output: Endpoint, t: float) -> None:
        """An output was no number at t, s, and is looked at no more."""
        self.no_numbers.setdefault(output, t)
        self.records.memory.inverse[self.positions[output]] = 0.0

    def check_finite(self, t: float) -> None:
        """Outputs that are no numbers, or so large that the coupling has grown without bound, end the run.

        One of a foreign FMU that is no number, and that nothing uses, is noted and looked at no more.
        """
        for (unit, name), value in zip(self.positions, self.sample(), strict=True):
            if not isfinite(value):
                if not self.network.is_idle((unit, name)):
                    raise Runaway(unit, t, f"output {name} is {value}")
                self.look_away((unit, name), t)
                continue
            if abs(value) > RUNAWAY * self.coupling.interfaces[unit].outputs[name].nominal:
                raise Unstable(unit, t, f"output {name} has grown to {value:.3g}")
