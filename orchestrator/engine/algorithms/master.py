"""What all master algorithms share: the table of signals, initialization, and the loop of kernels that takes the steps.

The program has only the rows that the scene needs, so unused features cost nothing in a step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import inf, isfinite
from operator import itemgetter
from typing import Any, Literal

import numpy as np

from ....components.core.errors import StepFailed
from ...units import Simulator
from ...units.component import ComponentSimulator
from ..coupling import Coupling, Endpoint, Link
from ..coupling.graph import Loop, is_discrete
from .initial import Groups, InitializationResult
from .initial_kernels import ABOUT_ZERO, RUNAWAY
from .layout import UNMOVED, Program, lay_out
from .loops import LoopSolver
from .machine import Machine, Space, Steps, singly
from .node import Node, Samples, samples_of
from .records import EXTRAPOLATED, FOLLOW, FORESEE, INTERPOLATED, LEFT, LOOK, PUSH, RIGHT, SHIFT
from .texts import Texts

Acts = Sequence[tuple[int, Sequence[Node]]]  # rows of the program: what is done with which units
NONE: np.ndarray = np.zeros(0, dtype=np.int64)


class Runaway(StepFailed):
    """Outputs are not finite. The caller, who knows the scene, adds the advice."""


class Unstable(Runaway):
    """A coupling that has grown without bound."""


@dataclass
class Saved:
    """A master and its units at an instant; cells: its records and signals."""

    units: list[Any]
    cells: np.ndarray
    steps: int
    jacobians: list[np.ndarray | None]  # of the algebraic loops, (n, n) each


class Master:
    """Base of the algorithms: `initialize`, then `step` for each macro step; `signals` holds the outputs read in every step.

    `watched`: outputs to read in every step although no connection needs them. `end`: s, of the run; units with a rate of
    their own take a shorter last step to it. The table of signals may be longer than `positions`, for values that only the
    master goes by; `sample` gives the outputs alone, in their order. An algorithm gives `acts`, or `advance` where it decides
    something inside a step.
    """

    def __init__(
        self,
        units: Mapping[str, Simulator],
        coupling: Coupling,
        watched: Sequence[Endpoint] = (),
        *,
        degree: int = 1,
        feedthrough: Literal["immediate", "delayed"] = "immediate",
        order: Sequence[str] = (),
        smoothing: bool = False,
        moving_places: Literal["linear", "held"] = "linear",
        end: float = inf,
    ):
        self.handed_over = frozenset(link.source for link in coupling.links)  # initialization and step control go by these alone
        read = list(dict.fromkeys([*(link.source for link in coupling.links), *watched]))
        # in the order of the units' own outputs, which they can hand over in one piece
        ranks = {(u, n): (i, k) for i, u in enumerate(units) for k, n in enumerate(coupling.interfaces[u].outputs)}
        read.sort(key=ranks.__getitem__)
        self.coupling, self.degree, self._moving_places = coupling, degree, moving_places
        self.positions: dict[Endpoint, int] = {end: k for k, end in enumerate(read)}
        guessed = [source for source in read if source[0] in coupling.rates]  # their estimates stand behind all that is read
        self.cells = self.positions | {source: len(read) + k for k, source in enumerate(guessed)}  # what links take, by source
        self.weights = [1.0 / coupling.interfaces[u].outputs[n].nominal for u, n in read]
        self.steps = 0
        order = tuple(order) or self.usual_order(tuple(units))
        self.nodes = [self._node(units[name], read, order) for name in order]
        self.node_of = {node.unit.name: node for node in self.nodes}
        self.texts = Texts(units, coupling) if coupling.texts else None  # behind the nodes, which wire the units
        self._plan = self._following() if feedthrough == "immediate" else []
        self.loops = [part for part in self._plan if isinstance(part, LoopSolver)]
        self._fed = [node for node in self.nodes if node.sources]
        program, following = Program(self.nodes), [part for part in self._plan if isinstance(part, list)]
        acts, push = self.acts(), (PUSH, self._fed)
        follow = [(FOLLOW, part) for part in following]
        finish: Acts = [*follow, push]
        if any(k in node.held for part in following for node in part for k, _ in node.direct):
            left, right = ([(act, part) for part in following] for act in (LEFT, RIGHT))
            finish = [*left, (LOOK, self._fed), *right, (SHIFT, self._fed), push]
        self._rows = {
            "step": program.add(*acts, *finish),
            "advance": program.add(*acts),
            "finish": program.add(*finish),
            "push": program.add(push),
            "follow": program.add(*follow),
            "foresee": program.add((FORESEE, self._fed)),
        }
        self._rows |= {name: program.add(*acts) for name, acts in self.own_acts().items()}
        self._rows |= {solver.loop.text: program.add(*solver.acts()) for solver in self.loops}
        self._follow = {id(part): program.add((FOLLOW, part)) for part in following}
        for node in self.nodes:
            node.look_rows = program.add((LOOK, [node]))
        bonded = [(self.node_of[link.target[0]], link) for bond in coupling.bonds for link in bond.links]
        table = len(read) + len(guessed)
        self._used = {link.source for link in coupling.links} | {*coupling.events}
        self.no_numbers: dict[Endpoint, float] = {}  # outputs that nothing uses and that were no numbers -> s, when first
        groups = [sorted((self.node_of[name] for name in names), key=self._direct_share) for names in coupling.groups]
        answers = [self._answers(group) for group in groups]
        places = [[self.nodes.index(node) for node in group] for group in groups]
        initial = list(zip(places, answers, strict=True))
        faults = [len(ends) for ends in coupling.faults]
        self.records = records = lay_out(
            self.nodes, self.extrapolated_links, program, self.weights, bonded, table, smoothing, end, initial, faults
        )
        ends = {cell: end for end, cell in self.cells.items()}
        self._groups = Groups([[node.unit.name for node in group] for group in groups], records, ends)
        self.signals: np.ndarray = records.memory.signals[:table]
        self.sample = self.signals[: len(read)].tolist
        self.machine = Machine(self.nodes, records, self.texts)
        self.delayed_feedthrough = ""  # why a coupling grows whose algebraic loop gets its values one step late
        loop = next((part for part in coupling.feedthrough_schedule if isinstance(part, Loop)), None)
        if feedthrough == "delayed" and loop is not None:
            self.delayed_feedthrough = (
                f"{' and '.join(loop.units)} depend on one another within an instant but exchange values "
                "one step late; where that amplifies, no shorter step helps. Use master.feedthrough = "
                "'immediate', which solves their loop"
            )

    batched = False  # a macro step is `acts` alone, unless there are algebraic loops
    solves_loops = True  # behind a step; else the algorithm has done so in it

    @property
    def in_batches(self) -> bool:
        """Whether many macro steps are one call of the kernels."""
        return self.batched and not self.loops and self.texts is None

    @property
    def extrapolated_links(self) -> list[int]:
        """Of each node, how many of its links have their values extrapolated: those come first."""
        return [len(node.links) for node in self.nodes]

    def usual_order(self, scene: tuple[str, ...]) -> tuple[str, ...]:
        """The order of the units where the scene gives none; `scene`: as they stand there."""
        return scene

    def acts(self) -> Acts:
        """What a macro step begins with, before outputs follow their inputs."""
        return []

    def own_acts(self) -> dict[str, Acts]:
        """Rows of the program that the algorithm takes by these names, see `perform`."""
        return {}

    def _node(self, unit: Simulator, read: Sequence[Endpoint], order: tuple[str, ...]) -> Node:
        """The node of a unit, which is wired."""
        coupling, interfaces = self.coupling, self.coupling.interfaces
        name, rates = unit.name, coupling.rates
        mine = [k for k, source in enumerate(read) if source[0] == name]
        place = slice(mine[0], mine[-1] + 1) if mine else slice(0, 0)
        links = self.sorted_links([link for link in coupling.links if link.target[0] == name], order)
        unit.wire([link.target[1] for link in links], [read[k][1] for k in mine])
        held = [
            k
            for k, link in enumerate(links)
            if is_discrete(interfaces[link.source[0]].outputs[link.source[1]])
            or is_discrete(interfaces[name].inputs[link.target[1]])
        ]
        by_rate: dict[int, list[int]] = {}
        for k, link in enumerate(links):
            by_rate.setdefault(rates.get(link.source[0], 1), []).append(k)
        moving = [
            k
            for k, link in enumerate(links)
            if interfaces[name].inputs[link.target[1]].moving and k not in held and self._moving_places == "linear"
        ]
        samples = tuple(samples_of(self.degree, at, every, held, moving) for every, at in by_rate.items())
        own: tuple[Samples, Samples] | None = None
        estimates: slice | None = None
        if name in rates:
            still = [k for k, output in enumerate(mine) if is_discrete(interfaces[name].outputs[read[output][1]])]
            first = self.cells[read[mine[0]]] if mine else 0
            estimates = slice(first, first + len(mine))
            own = (
                samples_of(self.degree, range(len(links)), 1, held, moving),
                samples_of(self.degree, range(len(mine)), 1, still),
            )
        sources = tuple(self.cells[link.source] for link in links)
        return Node(
            unit,
            place,
            tuple(links),
            sources,
            tuple(held),
            interfaces[name].input_degree >= self.degree and set(by_rate) <= {1},
            samples,
            own,
            rates.get(name, 1),
            estimates,
        )

    def _following(self) -> list[LoopSolver | list[Node]]:
        """What makes outputs follow their inputs: units that are updated, loops that are solved, and both in their order."""
        interfaces = self.coupling.interfaces
        plan: list[LoopSolver | list[Node]] = []
        for step in self.coupling.feedthrough_schedule:
            if isinstance(step, Loop):
                plan.append(LoopSolver(step, [self.node_of[name] for name in step.units], self, interfaces))
            elif plan and isinstance(plan[-1], list):
                plan[-1].append(self.node_of[step])
            else:
                plan.append([self.node_of[step]])
        for node in dict.fromkeys(node for part in plan if isinstance(part, list) for node in part):
            interface = interfaces[node.unit.name]
            # of all outputs, read or not: when a unit is updated must not depend on what is recorded of it
            at_once = {i for output in interface.outputs.values() for i in output.feedthrough or ()}
            exact = interface.input_degree >= self.degree
            for k, link in enumerate(node.links):
                if link.target[1] in at_once:
                    node.direct.append((k, UNMOVED if exact or k in node.held else -inf))
        return plan

    def sorted_links(self, links: list[Link], order: tuple[str, ...]) -> list[Link]:
        """The links into one unit in the order the algorithm wants to have them."""
        return links

    # -- steps -------------------------------------------------------------------------------------------------------
    def perform(self, rows: str, t: float, h: float) -> None:
        """Take rows of the program, in the step from t to t + h; raises what a unit raises."""
        self.machine.perform(self._rows[rows], t, h)

    def step(self, t: float, h: float) -> None:
        """One macro step from t to t + h."""
        if self.texts is not None:
            self.texts.hand_over()
        self.machine.begin()
        if self.in_batches:
            beyond = self.machine.step(self._rows["step"], t, h)
        else:
            self.advance(t, h)
            beyond = self._finish(t, h)
        self.machine.note()
        self.steps += 1
        if beyond:
            self.check_finite(t + h)

    def advance(self, t: float, h: float) -> None:
        """The steps of all units from t to t + h, where they are more than `acts`."""
        self.perform("advance", t, h)

    def _finish(self, t: float, h: float) -> bool:
        """After all units have stepped: let the outputs follow their inputs, and keep the inputs of the new instant.

        Returns whether the outputs have to be looked at.
        """
        if self.loops and self.solves_loops:
            self._solve(t + h)
            return self.machine.step(self._rows["push"], t, h)
        return self.machine.step(self._rows["finish"], t, h)

    def follow(self, t: float) -> None:
        """Let the outputs follow inputs that were changed at an instant, between two steps."""
        for node in self.nodes:
            if node.unit_record["ends"][0] == INTERPOLATED:
                node.jump()
        self._solve(t)

    def _solve(self, t: float) -> None:
        """Update the units whose inputs have moved, and solve algebraic loops, each where it stands among them."""
        self.records.ask(updated=0)
        for part in self._plan:
            if isinstance(part, list):
                self.machine.perform(self._follow[id(part)], t, 0.0)
            else:
                part.solve(t)
                self.records.ask(updated=1)

    def run_steps(self, times: np.ndarray, h: float, sampled: np.ndarray = NONE, saved: Sequence[int] = ()) -> Steps:
        """Macro steps from each of `times`, s, of length h, in as few calls as possible.

        sampled: (m,), steps counted from 0 behind which `inputs` are wanted; saved: those behind which the master is saved. Both,
        and all but `rows` and `failure` of what is returned, where steps are taken `in_batches`.
        """
        if not self.in_batches:
            return singly(self, self, times, h)
        steps, states = self.machine.space(times, sampled), list[Any]()
        for last in (*(step + 1 for step in saved), times.size):
            before = steps.done
            failure = self.machine.run_steps(self._rows["step"], steps, h, last)
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
            if not isinstance(unit, ComponentSimulator):
                return None
            at += unit.outputs_at([output for _, output in of_unit])
        return self.machine.watch(at)

    def halt(self) -> None:
        """End a batch behind its present step."""
        self.records.ask(halt=1)

    # -- what others look at -----------------------------------------------------------------------------------------
    def owe(self, integrals: np.ndarray) -> None:
        """What bonded inputs still have to be given: their integrals over time, (B,)."""
        links, units = self.records.memory.links, self.records.memory.units
        links["owed"][self.records.memory.bonded] = integrals
        for node in self.nodes:
            if any(link in bond.links for bond in self.coupling.bonds for link in node.links):
                units["corrected"][node.index] = 1

    def extrapolated(self) -> np.ndarray:
        """Of all inputs whether they were extrapolated, (L,)."""
        return np.array([node.unit_record["ends"][0] == EXTRAPOLATED for node in self.nodes for _ in node.links], dtype=bool)

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
            solver.solve(t)
        self.check_finite(t)
        self.perform("push", t, 0.0)

    def _is_idle(self, end: Endpoint) -> bool:
        """Whether nothing in the coupling depends on an output, and it is one of a foreign FMU, which may be no number."""
        return self.coupling.interfaces[end[0]].foreign and end not in self._used

    def initialize_units(self, t: float) -> None:
        """Initialize the groups of the graph, those that feed others first; raises `StepFailed` where values do not converge."""
        self.prepare_initial_signals()
        self.machine.initialize(t)
        self._groups.check(t, self.check_finite)

    def begin_anew(self, cells: np.ndarray) -> None:
        """Before another run, as it was when its block was copied to `cells`."""
        self.records.begin_anew(cells)
        self.machine.watch_nothing()
        self._take_counts(0, [None] * len(self.loops))

    def prepare_initial_signals(self) -> None:
        """Put what units go by that are initialized before their sources into the table of signals."""
        signals, inputs = self.signals, self.coupling.interfaces
        for node in self.nodes:  # a source that has not been initialized yet stands at the start value of the input it feeds
            for link, k in zip(node.links, node.sources, strict=True):
                start = float(inputs[link.target[0]].inputs[link.target[1]].start) if link.factor or link.map else 0.0
                if link.factor:
                    signals[k] = (start - link.offset) / link.factor
                elif link.map:
                    signals[k] = next((value for value, becomes in link.map if becomes == start), link.map[0][0])

    def rows(self, name: str) -> tuple[int, int]:
        """Rows of the program by their name: the first one, and the one behind the last."""
        return self._rows[name]

    @property
    def initialization(self) -> list[InitializationResult]:
        """How each group has come to its initial values."""
        return self._groups.results

    def _answers(self, group: Sequence[Node]) -> list[tuple[int, bool, float]]:
        """Of each output of a group its cell, whether a sweep depends on it, and the least value that a change is compared with."""
        names = {node.unit.name for node in group}
        ends = {cell: end for end, cell in self.cells.items() if end[0] in names and end in self.handed_over}
        given: set[int] = set()
        needed: set[int] = set()  # cells that a sweep reads before it writes them: it depends on no others
        for node in group:
            needed |= set(node.sources) - given
            given |= {cell for cell, end in ends.items() if end[0] == node.unit.name}
        interfaces = self.coupling.interfaces
        return [
            (cell, cell in needed, ABOUT_ZERO * interfaces[u].outputs[n].nominal)
            for cell, (u, n) in ends.items()
            if not self._is_idle((u, n))
        ]

    def _direct_share(self, node: Node) -> float:
        """Share of a unit's signals that depend on its inputs directly.

        Units where it is small go first in a sweep: what they give stands already, and may be what others cannot start
        without, such as the place of a contact.
        """
        outputs = self.coupling.interfaces[node.unit.name].outputs
        direct = [outputs[n].feedthrough != () for u, n in self.handed_over if u == node.unit.name]
        return sum(direct) / max(len(direct), 1)

    def counters(self) -> dict[str, Any]:
        """For run.json; algorithms add their own."""
        counters: dict[str, Any] = {
            "steps": self.steps,
            "initial_sweeps": max((group.sweeps + group.secants for group in self.initialization), default=0),
            "initial_residual": max((group.residual for group in self.initialization), default=0.0),
        }
        if self.loops:
            counters["algebraic_loops"] = {solver.loop.text: solver.counters() for solver in self.loops}
        return counters

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far."""
        sample = dict(zip(self.positions, self.sample(), strict=True))
        return [
            f"{unit}.{name} was no number at t = {t:.9g} s{'' if isfinite(sample[unit, name]) else ', nor at the end'}; "
            "no connection uses it"
            for (unit, name), t in self.no_numbers.items()
        ]

    def save(self, reuse: Saved | None = None) -> Saved:
        """Everything a repeated step depends on; `reuse`: an older one that may be overwritten."""
        units = [node.unit.save(reuse.units[k] if reuse else None) for k, node in enumerate(self.nodes)]
        return Saved(units, self.records.block.memory.copy(), self.steps, [loop.jacobian for loop in self.loops])

    def restore(self, saved: Saved) -> None:
        """Take back what `save` gave; it can be restored again."""
        self.records.block.memory[:] = saved.cells
        for node, state in zip(self.nodes, saved.units, strict=True):
            node.unit.restore(state)
        self._take_counts(saved.steps, saved.jacobians)

    def state(self) -> dict[str, Any]:
        """The same for a file, or for another master of the same scene: numbers, arrays, and of units bytes."""
        units = []
        for node in self.nodes:
            saved = node.unit.save()
            try:
                units.append(node.unit.pack(saved))
            finally:
                node.unit.release(saved)
        jacobians = [loop.jacobian for loop in self.loops]
        return {"units": units, "records": self.records.state(), "steps": self.steps, "jacobians": jacobians}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; raises `ValueError` where the master is of another size."""
        self.records.take(state["records"])
        for node, packed in zip(self.nodes, state["units"], strict=True):
            saved = node.unit.unpack(packed)
            node.unit.restore(saved)
            node.unit.release(saved)
        self._take_counts(state["steps"], state["jacobians"])

    def _take_counts(self, steps: int, jacobians: Sequence[np.ndarray | None]) -> None:
        self.steps = steps
        for loop, jacobian in zip(self.loops, jacobians, strict=True):
            loop.jacobian = jacobian

    def check_finite(self, t: float) -> None:
        """Outputs that are no numbers, or so large that the coupling has grown without bound, end the run.

        One of a foreign FMU that is no number, and that nothing uses, is noted and looked at no more.
        """
        for (unit, name), value in zip(self.positions, self.sample(), strict=True):
            if not isfinite(value):
                if not self._is_idle((unit, name)):
                    raise Runaway(unit, t, f"output {name} is {value}")
                self.no_numbers.setdefault((unit, name), t)
                self.records.memory.inverse[self.positions[unit, name]] = 0.0
                continue
            if abs(value) > RUNAWAY * self.coupling.interfaces[unit].outputs[name].nominal:
                raise Unstable(unit, t, f"output {name} has grown to {value:.3g}")
