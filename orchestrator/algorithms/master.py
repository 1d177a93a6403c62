"""What all master algorithms share: the table of signals, initialization, and outputs that follow within an instant."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from math import isfinite
from operator import mul
from typing import Any, Literal

import numpy as np

from components.core.errors import StepFailed

from ..coupling import Coupling, Endpoint, Link
from ..units import Unit
from ..units.interface import WIDE, Row
from .polynomial import History, Terms
from .rows import rows_for

SWEEPS = 30
CONVERGED = 1e-12  # relative change of an output from one sweep to the next
STANDING = 1e-9  # and what is left of it where stiff units answer the rounding of one another: it no longer falls then
RUNAWAY = 1e12  # times the nominal value: no answer of a model any more, even where a nominal value was left at 1
ROUNDING = 16 * 2.0**-52  # relative: an input this near to where its polynomial has led it has not moved
ABOUT_ZERO = 1e-3  # of the nominal value: an output below it is compared with it instead of with itself


class Node:
    """One unit in the graph: where its inputs come from and where its outputs go in the table of signals."""

    def __init__(self, unit: Unit, place: slice, links: Sequence[Link], sources: Sequence[int], table: Row, degree: int,
                 follows: bool):
        self.unit, self.place = unit, place
        self.follows = follows  # inputs end where their polynomials do; a unit that holds their mean does not
        self.links, self.sources = tuple(links), tuple(sources)
        self.rows = rows_for(len(links))
        self._pick = self.rows.picker(table, sources)
        converted = [(k, link.factor, link.offset) for k, link in enumerate(links) if (link.factor, link.offset) != (1.0, 0.0)]
        self._conversions = converted or None
        self.alter: Callable[[Row], Row] | None = None  # faults on purpose: what the unit gets instead of the values it should
        self.history = History(degree, self.rows)
        self.direct: list[tuple[int, float]] = []  # inputs that outputs depend on at once: position, relative change of none
        self.reached: Row | None = None  # where extrapolation has taken the inputs in the last step
        self.fresh: Row | None = None  # or what they were interpolated to: values that others had reached already

    def inputs(self) -> Row:
        """Present values of the driven inputs, in the order of `links`."""
        values = self._pick()
        if self._conversions is not None:
            for k, factor, offset in self._conversions:
                values[k] = factor * values[k] + offset
        return values if self.alter is None else self.alter(values)

    def restart(self) -> None:
        """After a jump: the past of the inputs tells nothing any more, their present values are the only sample."""
        self.history.restart(self.inputs())

    def drive(self, terms: Terms, h: float) -> None:
        """Give the unit its inputs over the coming step, and note where they will end."""
        self.unit.drive(*terms, h)
        self.fresh = None
        self.reached = self.rows.end(*terms, h)

    def lead(self, fresh: Row, h: float) -> None:
        """Give the unit inputs over the coming step that end at values which are known already."""
        self.unit.drive(*self.history.towards(fresh, h), h)
        self.fresh, self.reached = fresh, None

    def stands(self, values: Row) -> bool:
        """Whether the outputs hold for these inputs as they are: none that they depend on at once has moved."""
        reached = self.reached
        return reached is not None and all(
            abs(values[k] - reached[k]) <= change * abs(values[k]) for k, change in self.direct
        )


@dataclass
class Saved:
    """A master and its units at an instant."""

    units: list[Any]
    signals: Row
    histories: list[History]
    ends: list[tuple[Row | None, Row | None]]
    steps: int


class Master:
    """Base of the algorithms: `initialize`, then `step` for each macro step; `signals` holds the outputs read in every step.

    `watched`: outputs to read in every step although no connection needs them.
    """

    def __init__(self, units: Mapping[str, Unit], coupling: Coupling, watched: Sequence[Endpoint] = (), *,
                 degree: int = 1, feedthrough: Literal["fresh", "stale"] = "fresh", order: Sequence[str] = ()):
        read = list(dict.fromkeys([*(link.source for link in coupling.links), *watched]))
        # in the order of the units' own outputs, which they can hand over in one piece
        ranks = {(u, n): (i, k) for i, u in enumerate(units) for k, n in enumerate(coupling.interfaces[u].outputs)}
        read.sort(key=ranks.__getitem__)
        self.coupling = coupling
        self.positions: dict[Endpoint, int] = {end: k for k, end in enumerate(read)}
        driven, given = Counter(link.target[0] for link in coupling.links), Counter(u for u, _ in read)
        wide = max([*driven.values(), *given.values()], default=0) > WIDE
        signals: Row = np.zeros(len(read)) if wide else [0.0] * len(read)
        self.signals = signals
        self.sample = signals.tolist if wide else lambda: signals
        sizes = [1.0 / coupling.interfaces[u].outputs[n].nominal for u, n in read]
        inverse = np.array(sizes)
        self._size = (lambda: signals.dot(inverse)) if wide else (lambda: sum(map(mul, signals, sizes)))
        self.sweeps, self.residual, self.steps = 0, 0.0, 0
        nodes = {}
        for name, unit in units.items():
            mine = [k for k, end in enumerate(read) if end[0] == name]
            place = slice(mine[0], mine[-1] + 1) if mine else slice(0, 0)
            links = self.sorted_links([link for link in coupling.links if link.target[0] == name], tuple(order) or tuple(units))
            unit.wire([link.target[1] for link in links], [read[k][1] for k in mine])
            follows = coupling.interfaces[name].input_degree >= degree
            sources = [self.positions[link.source] for link in links]
            nodes[name] = Node(unit, place, links, sources, self.signals, degree, follows)
        self.nodes = [nodes[name] for name in order or units]
        self._passes = [nodes[name] for name in coupling.passes] if feedthrough == "fresh" else []
        for node in self._passes:
            interface = coupling.interfaces[node.unit.name]
            at_once = {i for k in range(*node.place.indices(len(read))) for i in interface.outputs[read[k][1]].feedthrough or ()}
            for k, link in enumerate(node.links):
                if link.target[1] in at_once:
                    node.direct.append((k, ROUNDING if node.follows else -1.0))

    def sorted_links(self, links: list[Link], order: tuple[str, ...]) -> list[Link]:
        """The links into one unit in the order the algorithm wants to have them."""
        return links

    def initialize(self, t: float) -> None:
        """Initialize and propagate until the outputs stop changing; raises `StepFailed` with what is left when they do not."""
        signals = self.signals
        nominals = [ABOUT_ZERO * self.coupling.interfaces[u].outputs[n].nominal for u, n in self.positions]
        for node in self.nodes:  # a source that has not been initialized yet stands at the start value of the input it feeds
            for link, k in zip(node.links, node.sources, strict=True):
                start = self.coupling.interfaces[link.target[0]].inputs[link.target[1]].start
                signals[k] = (float(start) - link.offset) / link.factor
        nodes = sorted(self.nodes, key=self._direct_share)
        for sweep in range(1, SWEEPS + 1):
            before = self.sample()[:]
            for node in nodes:
                node.unit.initialize(t, node.inputs())
                signals[node.place] = node.unit.get()
            self._check_finite(t)
            changes = [abs(a - b) / max(abs(a), abs(b), c) for a, b, c in zip(self.sample(), before, nominals, strict=True)]
            last, self.residual, self.sweeps = self.residual, max(changes, default=0.0), sweep
            if self.residual <= CONVERGED or 0.5 * last <= self.residual <= STANDING:
                break
        else:
            unit, name = list(self.positions)[changes.index(self.residual)]
            raise StepFailed(unit, t, f"the initial values did not settle in {SWEEPS} sweeps; {name} still changes by "
                                      f"{self.residual:.2g} of its value", "Give parameters closer to a common equilibrium")
        for node in self.nodes:
            node.unit.start()
            signals[node.place] = node.unit.get()
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

    def save(self, reuse: Saved | None = None) -> Saved:
        """Everything a repeated step depends on; `reuse`: an older one that may be overwritten."""
        units = [node.unit.save(reuse.units[k] if reuse else None) for k, node in enumerate(self.nodes)]
        return Saved(units, self.signals[:] if isinstance(self.signals, list) else self.signals.copy(),
                     [copy(node.history) for node in self.nodes], [(node.reached, node.fresh) for node in self.nodes], self.steps)

    def restore(self, saved: Saved) -> None:
        """Take back what `save` gave; it can be restored again."""
        self.signals[:] = saved.signals
        self.steps = saved.steps
        for node, state, history, ends in zip(self.nodes, saved.units, saved.histories, saved.ends, strict=True):
            node.unit.restore(state)
            node.history.take(history)
            node.reached, node.fresh = ends

    def _finish(self, t: float, h: float) -> None:
        """After all units have stepped: let the outputs follow their inputs, and keep the inputs of the new instant."""
        signals, updated = self.signals, False
        for node in self._passes:
            if node.fresh is None or updated:
                values = node.inputs()
                if not node.stands(values):
                    node.unit.update(values)
                    signals[node.place] = node.unit.get()
                    updated = True
        for node in self.nodes:
            if node.sources:
                node.history.push(node.inputs() if node.fresh is None or updated else node.fresh, h)
        self.steps += 1
        self._check_finite(t + h)

    def _check_finite(self, t: float) -> None:
        """Outputs that are no numbers, or so large that the coupling has grown without bound, end the run."""
        if not abs(self._size()) < RUNAWAY:  # one cheap look at all before each is looked at
            for (unit, name), value in zip(self.positions, self.sample(), strict=True):
                if not isfinite(value):
                    raise StepFailed(unit, t, f"output {name} is {value}", "Reduce the macro step")
                if abs(value) > RUNAWAY * self.coupling.interfaces[unit].outputs[name].nominal:
                    raise StepFailed(unit, t, f"output {name} has grown to {value:.3g}", "Reduce the macro step")
