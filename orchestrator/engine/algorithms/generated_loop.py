"""Stretches of macro steps in straight-line Python, where all units are components of this process.

The source of one function is written for the graph of the scene: every signal, and every sample of an input's history, is a
local variable, and inputs and outputs are elements of the components' own arrays. It does what `Jacobi.step` and
`GaussSeidel.step` do, in the same order and to the last bit, without their calls and lists: for components with little work
of their own a macro step takes a fifth of the time. `GeneratedLoop.source` is that source, to be read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import Any

import numpy as np

from ....components.core.errors import StepFailed
from ...units.component import ComponentUnit
from .gauss_seidel import GaussSeidel
from .initial import RUNAWAY
from .master import Master, Node


class GeneratedLoop:
    """Macro steps of a master in straight-line code; the nodes' histories are the only truth between two stretches."""

    def __init__(self, master: Master, units: Sequence[ComponentUnit], halt: np.ndarray):
        self._master = master
        self._late = master.late if isinstance(master, GaussSeidel) else [len(node.links) for node in master.nodes]
        self._links = [(k, j) for k, node in enumerate(master.nodes) for j in range(len(node.links))]
        self._width = len(master.positions)
        self.source = "\n".join(self._lines(units))
        flag: Any = halt
        names: dict[str, Any] = {"StepFailed": StepFailed, "abs": abs, "inf": inf, "halt": memoryview(flag)}
        for k, unit in enumerate(units):
            ports = unit.ports()
            names |= {f"step{k}": unit.component.step, f"refresh{k}": unit.component.refresh, f"y{k}": ports.outputs}
            names |= {f"u{k}_{d}": row for d, row in enumerate(ports.inputs)}
        exec(compile(self.source, "<steps of a scene>", "exec"), names)
        self._steps = names["steps"]

    @property
    def possible(self) -> bool:
        """Whether the next steps may be taken so: no fault alters inputs, and all histories are full and of one spacing."""
        pasts = [node.history for node in self._master.nodes if node.links]
        return all(node.alter is None for node in self._master.nodes) and all(
            past.count > self._master.degree and (past.h1, past.h2) == (pasts[0].h1, pasts[0].h2) for past in pasts)

    def run(self, times: list[float], h: float) -> tuple[np.ndarray, StepFailed | None]:
        """Steps from each of `times`, s, of length h: the signals behind every step that was completed, and why one was not."""
        master, nodes = self._master, self._master.nodes
        rows: list[tuple[float, ...]] = []
        pasts = [nodes[k].history for k, _ in self._links]
        samples = [v for (_, j), past in zip(self._links, pasts, strict=True) for v in _samples(past, j)]
        h1, h2 = (pasts[0].h1, pasts[0].h2) if pasts else (0.0, 0.0)
        results = self._steps(times, h, master.signals, samples, h1, h2, rows)
        master.signals[:], samples, (h1, h2), reached, interpolated, failure, far = results
        master.steps += len(rows)
        at = 0
        for node, interpolates in zip(nodes, interpolated, strict=True):
            n = len(node.links)
            if n and rows:
                past, mine = node.history, samples[3 * at : 3 * (at + n)]
                past.present, past.before, past.earlier = mine[::3], mine[1::3], mine[2::3]
                past.h1, past.h2 = h1, h2
                node.reached, node.known = (None, mine[::3]) if interpolates else (reached[at : at + n], None)
            at += n
        if far:
            failure = beyond(master, times[len(rows) - 1] + h)
            rows = rows[: len(rows) - (failure is not None)]
        return np.array(rows).reshape(len(rows), self._width), failure

    # The source

    def _lines(self, units: Sequence[ComponentUnit]) -> Iterator[str]:
        master, sequential = self._master, isinstance(self._master, GaussSeidel)
        signals = [f"s{j}" for j in range(len(master.signals))]
        links = range(len(self._links))
        samples = [f"{c}{i}" for i in links for c in "pbe"]
        yield "def steps(times, h, signals, samples, h1, h2, rows):"
        yield f"    {_tuple(signals)} = signals"
        yield f"    {_tuple(samples)} = samples"
        yield "    failure, far, keep = None, False, rows.append"
        yield from (f"    v{i} = d{i} = c{i} = 0.0" for i in links)
        yield "    try:"
        yield "        for t in times:"
        inner = " " * 12
        first = 0
        firsts = []
        for k, node in enumerate(master.nodes):
            firsts.append(first)
            for j in range(len(node.links)):
                yield from (inner + line for line in self._drive(node, j, first + j, k, units[k], self._late[k]))
            yield f"{inner}step{k}(t, h)"
            if sequential:
                yield from (inner + line for line in _outputs(node, k, units[k]))
            first += len(node.links)
        if not sequential:
            for k, node in enumerate(master.nodes):
                yield from (inner + line for line in _outputs(node, k, units[k]))
        yield from (inner + line for line in self._follow(units, firsts))
        for k, node in enumerate(master.nodes):
            for j in range(len(node.links)):
                i = firsts[k] + j
                shifts = (f"e{i}, b{i}, p{i} = b{i}, p{i}, ", f"b{i}, p{i} = p{i}, ", f"p{i} = ")
                yield f"{inner}{shifts[2 - master.degree]}{_input(node, j)}"
        if master.degree == 2:
            yield f"{inner}h2 = h1"
        yield f"{inner}h1 = h"
        yield f"{inner}keep({_tuple(signals[: self._width])})"
        sizes = " + ".join(f"s{j} * {w!r}" for j, w in enumerate(master.weights)) or "0.0"
        yield f"{inner}if not abs({sizes}) < {RUNAWAY!r}:"
        yield f"{inner}    far = True"
        yield f"{inner}    break"
        yield f"{inner}if halt[0]:"
        yield f"{inner}    break"
        yield "    except StepFailed as error:"
        yield "        failure = error"
        reached = [f"v{i} + h * (d{i} + h * c{i})" if master.degree == 2 else f"v{i} + h * d{i}" for i in links]
        interpolated = [str(self._interpolates(k)) for k in range(len(master.nodes))]
        states = f"[{', '.join(signals)}], [{', '.join(samples)}], (h1, h2), [{', '.join(reached)}]"
        yield f"    return {states}, {_tuple(interpolated)}, failure, far"

    def _interpolates(self, k: int) -> bool:
        node = self._master.nodes[k]
        return bool(node.links) and isinstance(self._master, GaussSeidel) and self._late[k] == 0 and node.follows

    def _drive(self, node: Node, j: int, i: int, k: int, unit: ComponentUnit, late: int) -> Iterator[str]:
        """The polynomial of one input over the step, as `History.ahead` or `History.towards` has it."""
        degree, column = self._master.degree, unit.ports().columns[j]
        if degree == 0:
            yield f"v{i} = " + (f"p{i}" if j < late else _input(node, j))
        elif j < late:
            yield f"v{i} = p{i}"
            yield f"d{i} = (p{i} - b{i}) / h1"
            if degree == 2:
                yield f"c{i} = (d{i} - (b{i} - e{i}) / h2) / (h1 + h2)"
                yield f"d{i} = d{i} + h1 * c{i}"
        else:
            yield f"v{i} = p{i}"
            yield f"d{i} = ({_input(node, j)} - p{i}) / h"
            if degree == 2:
                yield f"c{i} = (d{i} - (p{i} - b{i}) / h1) / (h + h1)"
                yield f"d{i} = d{i} + -h * c{i}"
        yield from (f"u{k}_{d}[{column}] = {'vdc'[d]}{i}" for d in range(degree + 1))

    def _follow(self, units: Sequence[ComponentUnit], firsts: Sequence[int]) -> Iterator[str]:
        """Outputs follow their inputs within the instant, as `Master._update` has it."""
        feedthrough_schedule = self._master.feedthrough_schedule
        if not feedthrough_schedule:
            return
        yield "updated = False"
        for node in feedthrough_schedule:
            k = self._master.nodes.index(node)
            first = firsts[k]
            columns = units[k].ports().columns
            yield f"if {'updated' if self._interpolates(k) else 'True'}:"
            for j in range(len(node.links)):
                yield f"    f{first + j} = {_input(node, j)}"
            stays = []
            for j, change in node.direct:
                i = first + j
                end = f"v{i} + h * (d{i} + h * c{i})" if self._master.degree == 2 else f"v{i} + h * d{i}"
                stays.append(f"abs(f{i} - ({end})) <= {change!r} * abs(f{i})")
            outputs_hold = "False" if self._interpolates(k) else " and ".join(stays) or "True"
            yield f"    if not ({outputs_hold}):"
            for j in range(len(node.links)):
                yield f"        u{k}_0[{columns[j]}] = f{first + j}"
            yield f"        refresh{k}()"
            yield from ("        " + line for line in _outputs(node, k, units[k]))
            yield "        updated = True"


def beyond(master: Master, t: float) -> StepFailed | None:
    """What is wrong with the master's signals at t, s; None where nothing is."""
    try:
        master.check_finite(t)
    except StepFailed as error:
        return error
    return None


def _samples(past: Any, j: int) -> tuple[float, float, float]:
    """Present sample of an input and the two before it; 0 for one that the degree does not need."""
    return tuple(0.0 if row is None else row[j] for row in (past.present, past.before, past.earlier))  # type: ignore[return-value]


def _tuple(names: Sequence[str]) -> str:
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _input(node: Node, j: int) -> str:
    """Present value of an input."""
    link, source = node.links[j], f"s{node.sources[j]}"
    return source if (link.factor, link.offset) == (1.0, 0.0) else f"({link.factor!r} * {source} + {link.offset!r})"


def _outputs(node: Node, k: int, unit: ComponentUnit) -> Iterator[str]:
    places = range(node.place.start, node.place.stop)
    yield from (f"s{j} = y{k}[{at}]" for j, at in zip(places, unit.ports().places, strict=True))
