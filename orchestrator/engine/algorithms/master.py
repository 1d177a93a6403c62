"""What all master algorithms share: the table of signals, initialization, and outputs that follow within an instant.

What a scene does not use is decided when the master is made and costs nothing in a step: held inputs are another kind of
history, smoothing another kind of node, a unit with a rate of its own another unit in its place, texts another `step`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from math import inf, isfinite
from operator import mul
from typing import Any, Literal

import numpy as np

from ....components.core.errors import StepFailed
from ...units import Unit
from ...units.interface import ARRAY_THRESHOLD, PortValues
from ..coupling import Coupling, Endpoint, Link
from ..coupling.graph import Loop, is_discrete
from .initial import RUNAWAY, Group, InitializationResult
from .loops import LoopSolver
from .multirate import MultirateUnit, history
from .node import Node, SmoothNode
from .polynomial import History
from .rows import rows_for
from .texts import Texts

ROUNDING = 16 * 2.0**-52  # relative: an input this near to where its polynomial has led it has not moved


class Runaway(StepFailed):
    """Outputs that are no finite numbers; what would help is for those to say who know the scene."""


class Unstable(Runaway):
    """A coupling that has grown without bound."""


@dataclass
class Saved:
    """A master and its units at an instant."""

    units: list[Any]
    signals: PortValues
    histories: list[History]
    ends: list[tuple[PortValues | None, PortValues | None]]
    steps: int
    jacobians: list[np.ndarray | None]  # of the algebraic loops, (n, n) each


class Master:
    """Base of the algorithms: `initialize`, then `step` for each macro step; `signals` holds the outputs read in every step.

    `watched`: outputs to read in every step although no connection needs them. `end`: s, of the run; units with a rate of
    their own take a shorter last step to it. The table of signals may be longer than `positions`, for values that only the
    master goes by; `sample` gives the outputs alone, in their order.
    """

    def __init__(self, units: Mapping[str, Unit], coupling: Coupling, watched: Sequence[Endpoint] = (), *, degree: int = 1,
                 feedthrough: Literal["immediate", "delayed"] = "immediate", order: Sequence[str] = (), smoothing: bool = False,
                 moving_places: Literal["linear", "held"] = "linear", end: float = inf):
        read = list(dict.fromkeys([*(link.source for link in coupling.links), *watched]))
        # in the order of the units' own outputs, which they can hand over in one piece
        ranks = {(u, n): (i, k) for i, u in enumerate(units) for k, n in enumerate(coupling.interfaces[u].outputs)}
        read.sort(key=ranks.__getitem__)
        self.coupling, self.degree, self._moving_places = coupling, degree, moving_places
        self.positions: dict[Endpoint, int] = {end: k for k, end in enumerate(read)}
        guessed = [source for source in read if source[0] in coupling.rates]  # their estimates stand behind all that is read
        self.cells = self.positions | {source: len(read) + k for k, source in enumerate(guessed)}  # what links take, by source
        driven, given = Counter(link.target[0] for link in coupling.links), Counter(u for u, _ in read)
        wide = max([*driven.values(), *given.values()], default=0) > ARRAY_THRESHOLD
        n, whole = len(read), len(read) + len(guessed)
        signals: PortValues = np.zeros(whole) if wide else [0.0] * whole
        self.signals = signals
        self.sample = signals[:n].tolist if wide else (lambda: signals[:n]) if guessed else lambda: signals
        self.weights = sizes = [1.0 / coupling.interfaces[u].outputs[n].nominal for u, n in read] + [0.0] * len(guessed)
        inverse = np.array(sizes)
        self._size = (lambda: signals.dot(inverse)) if wide else (lambda: sum(map(mul, signals, sizes)))
        self.steps = 0
        self.initialization: list[InitializationResult] = []  # how each group came to its initial values
        order = tuple(order) or self.usual_order(tuple(units))
        make = SmoothNode if smoothing else Node
        nodes = {name: self._node(make, unit, read, order, end) for name, unit in units.items()}
        self.nodes = [nodes[name] for name in order]
        self.texts = Texts(units, coupling) if coupling.texts else None  # behind the nodes, which wire the units
        if self.texts is not None:
            self._step, self.step = self.step, self._step_with_texts  # type: ignore[method-assign]
        self.feedthrough_schedule, self.loops, self._plan = (
            self._following(nodes, read) if feedthrough == "immediate" else ([], [], []))
        self._fed = [node for node in self.nodes if node.sources]
        self._solving = bool(self.loops)  # algebraic loops are solved after each step
        self.delayed_feedthrough = ""  # why a coupling grows whose algebraic loop gets its values one step late
        loop = next((part for part in coupling.feedthrough_schedule if isinstance(part, Loop)), None)
        if feedthrough == "delayed" and loop is not None:
            self.delayed_feedthrough = (f"{' and '.join(loop.units)} depend on one another within an instant but exchange values "
                                        "one step late; where that amplifies, no shorter step helps. Use master.feedthrough = "
                                        "'immediate', which solves their loop")

    sequential = False  # units step one after the other
    batched = False  # many steps are one compiled loop; `step` takes the number of units that have stepped already

    @property
    def late(self) -> list[int]:
        """Of each node, how many of its links have their values extrapolated: those come first."""
        return [len(node.links) for node in self.nodes]

    def usual_order(self, scene: tuple[str, ...]) -> tuple[str, ...]:
        """The order of the units where the scene gives none; `scene`: as they stand there."""
        return scene

    def _node(self, make: type[Node], unit: Unit, read: Sequence[Endpoint], order: tuple[str, ...], end: float) -> Node:
        """The node of a unit, which is wired."""
        coupling, interfaces = self.coupling, self.coupling.interfaces
        name, rates = unit.name, coupling.rates
        mine = [k for k, source in enumerate(read) if source[0] == name]
        place = slice(mine[0], mine[-1] + 1) if mine else slice(0, 0)
        links = self.sorted_links([link for link in coupling.links if link.target[0] == name], order)
        unit.wire([link.target[1] for link in links], [read[k][1] for k in mine])
        rows = rows_for(len(links))
        held = [k for k, link in enumerate(links) if is_discrete(interfaces[link.source[0]].outputs[link.source[1]])
                or is_discrete(interfaces[name].inputs[link.target[1]])]
        follows = interfaces[name].input_degree >= self.degree and not held
        by_rate: dict[int, list[int]] = {}
        for k, link in enumerate(links):
            by_rate.setdefault(rates.get(link.source[0], 1), []).append(k)
        moving = [k for k, link in enumerate(links) if interfaces[name].inputs[link.target[1]].moving and k not in held
                  and self._moving_places == "linear"]
        past = history(self.degree, rows, len(links), held, by_rate, moving)
        used: Unit | MultirateUnit = unit
        if name in rates:
            still = [k for k, output in enumerate(mine) if is_discrete(interfaces[name].outputs[read[output][1]])]
            first = self.cells[read[mine[0]]] if mine else 0
            used = MultirateUnit(unit, rates[name], history(self.degree, rows, len(links), held, moving=moving),
                        history(self.degree, rows_for(len(mine)), len(mine), still), self.signals,
                        slice(first, first + len(mine)), end)
        sources = [self.cells[link.source] for link in links]
        return make(used, place, links, sources, self.signals, past, held, follows and set(by_rate) <= {1})

    def _following(self, nodes: Mapping[str, Node], read: Sequence[Endpoint]
                   ) -> tuple[list[Node], list[LoopSolver], list[LoopSolver | list[Node]]]:
        """What makes outputs follow their inputs: units that are updated, loops that are solved, and both in their order."""
        interfaces = self.coupling.interfaces
        plan: list[LoopSolver | list[Node]] = []
        for step in self.coupling.feedthrough_schedule:
            if isinstance(step, Loop):
                plan.append(LoopSolver(step, [nodes[name] for name in step.units], self.signals, self.positions, interfaces))
            elif plan and isinstance(plan[-1], list):
                plan[-1].append(nodes[step])
            else:
                plan.append([nodes[step]])
        updated = [node for part in plan if isinstance(part, list) for node in part]
        for node in dict.fromkeys(updated):
            interface = interfaces[node.unit.name]
            at_once = {i for k in range(*node.place.indices(len(read))) for i in interface.outputs[read[k][1]].feedthrough or ()}
            exact = interface.input_degree >= self.degree
            for k, link in enumerate(node.links):
                if link.target[1] in at_once:
                    node.direct.append((k, ROUNDING if exact or k in node.held else -inf))
        return updated, [part for part in plan if isinstance(part, LoopSolver)], plan

    def sorted_links(self, links: list[Link], order: tuple[str, ...]) -> list[Link]:
        """The links into one unit in the order the algorithm wants to have them."""
        return links

    def initialize(self, t: float) -> None:
        """Initialize the groups of the graph, those that feed others first; raises `StepFailed` where values do not converge."""
        signals, inputs = self.signals, self.coupling.interfaces
        nodes = {node.unit.name: node for node in self.nodes}
        for node in self.nodes:  # a source that has not been initialized yet stands at the start value of the input it feeds
            for link, k in zip(node.links, node.sources, strict=True):
                if link.factor:
                    signals[k] = (float(inputs[link.target[0]].inputs[link.target[1]].start) - link.offset) / link.factor
        for names in self.coupling.groups:
            members = sorted((nodes[name] for name in names), key=self._direct_share)
            group = Group(members, signals, self.cells, inputs, self.texts, self.check_finite, t)
            try:
                group.solve()
            finally:
                self.initialization += [group.initialization] if group.initialization else []
        for node in self.nodes:
            node.unit.start()
            signals[node.place] = node.unit.get()
        for loop in self.loops:
            loop.solve(t)
        self.check_finite(t)
        for node in self.nodes:
            node.history.push(node.inputs(), 0.0)

    def _direct_share(self, node: Node) -> float:
        """Share of a unit's signals that depend on its inputs directly.

        Units where it is small go first in a sweep: what they give stands already, and may be what others cannot start
        without, such as the place of a contact.
        """
        outputs = self.coupling.interfaces[node.unit.name].outputs
        direct = [outputs[n].feedthrough != () for u, n in self.positions if u == node.unit.name]
        return sum(direct) / max(len(direct), 1)

    def step(self, t: float, h: float) -> None:
        """One macro step from t to t + h."""
        raise NotImplementedError

    def _step_with_texts(self, t: float, h: float) -> None:
        assert self.texts is not None
        self.texts.hand_over()
        self._step(t, h)

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
        return []

    def save(self, reuse: Saved | None = None) -> Saved:
        """Everything a repeated step depends on; `reuse`: an older one that may be overwritten."""
        units = [node.unit.save(reuse.units[k] if reuse else None) for k, node in enumerate(self.nodes)]
        return Saved(units, self.signals[:] if isinstance(self.signals, list) else self.signals.copy(),
                     [copy(node.history) for node in self.nodes], [(node.reached, node.known) for node in self.nodes], self.steps,
                     [loop.jacobian for loop in self.loops])

    def restore(self, saved: Saved) -> None:
        """Take back what `save` gave; it can be restored again."""
        self.signals[:] = saved.signals
        self.steps = saved.steps
        for node, state, past, ends in zip(self.nodes, saved.units, saved.histories, saved.ends, strict=True):
            node.unit.restore(state)
            node.history.take(past)
            node.reached, node.known = ends
        for loop, jacobian in zip(self.loops, saved.jacobians, strict=True):
            loop.jacobian = jacobian

    def _finish(self, t: float, h: float) -> None:
        """After all units have stepped: let the outputs follow their inputs, and keep the inputs of the new instant."""
        updated = self._solve(t + h) if self._solving else self._update(self.feedthrough_schedule, False)
        for node in self._fed:
            known = node.known
            node.history.push(node.inputs() if known is None or updated else known, h)
        self.steps += 1
        if not abs(self._size()) < RUNAWAY:  # one cheap look at all before each is looked at
            self.check_finite(t + h)

    def follow(self, t: float) -> None:
        """Let the outputs follow inputs that were changed at an instant, between two steps."""
        for node in self.nodes:
            node.known = None
        self._solve(t)

    def _update(self, nodes: Sequence[Node], updated: bool) -> bool:
        """Update the units whose outputs depend on inputs that have moved; tells whether there were any, now or before."""
        signals = self.signals
        for node in nodes:
            if node.known is None or updated:
                values = node.inputs()
                if not node.outputs_hold(values):
                    node.unit.update(values)
                    signals[node.place] = node.unit.get()
                    updated = True
        return updated

    def _solve(self, t: float) -> bool:
        """The same for all units that have to follow, and algebraic loops solved, each where it stands among them."""
        updated = False
        for part in self._plan:
            if isinstance(part, LoopSolver):
                part.solve(t)
                updated = True
            else:
                updated = self._update(part, updated)
        return updated

    def check_finite(self, t: float) -> None:
        """Outputs that are no numbers, or so large that the coupling has grown without bound, end the run."""
        for (unit, name), value in zip(self.positions, self.sample(), strict=True):
            if not isfinite(value):
                raise Runaway(unit, t, f"output {name} is {value}")
            if abs(value) > RUNAWAY * self.coupling.interfaces[unit].outputs[name].nominal:
                raise Unstable(unit, t, f"output {name} has grown to {value:.3g}")
