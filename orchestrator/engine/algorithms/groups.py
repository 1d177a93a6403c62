"""Units that step one after the other with interpolated inputs, and the signals at which a circle of units is cut."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import permutations
from math import inf
from typing import Any

import numpy as np

from ...units.interface import Interface
from ..coupling import Endpoint, Link
from ..coupling.graph import groups, smooth
from .machine import Machine
from .network import Network
from .node import Node
from .records import FORESEE, READ, START, UPDATE

TRIED = 6  # units of a circle all orders of which are tried; of a larger one every rotation is


def best_cut(names: Sequence[str], links: Iterable[Link]) -> tuple[str, ...]:
    """The units of a circle in the order, nearest to the given one, that leaves the fewest signals to be guessed."""
    inner = [link for link in links if {link.source[0], link.target[0]} <= set(names)]
    turned = [(*names[k:], *names[:k]) for k in range(len(names))]
    orders = permutations(names) if len(names) <= TRIED else turned

    def guessed(order: tuple[str, ...]) -> int:
        return len({link.source for link in inner if order.index(link.source[0]) > order.index(link.target[0])})

    return min(orders, key=guessed)


def groups_of(network: Network) -> list[StronglyConnectedGroup]:
    """Every circle, and between two of them all units in none as one group that is cut nowhere, each behind those that feed it."""
    interfaces, links = network.coupling.interfaces, smooth(network.coupling.interfaces, network.coupling.links)
    runs: list[list[str]] = [[]]
    for group in groups(interfaces, links):
        if len(group) > 1:
            runs += [[*best_cut(group, links)], []]
        else:
            runs[-1] += group
    return [StronglyConnectedGroup([network.node_of[name] for name in names], network) for names in runs if names]


class StronglyConnectedGroup:
    """Units in an order such that most are fed by earlier ones; `cut`: places of the signals that feed backwards.

    Signals that only jump between steps are held inside one, and need no guess. Units on one level feed none of each other,
    and step at the same time where they run in processes of their own.
    """

    def __init__(self, nodes: Sequence[Node], network: Network):
        self.nodes, self._ends, interfaces = list(nodes), list(network.positions), network.coupling.interfaces
        depths = _depths(self.nodes)
        self._levels = [[n for n, d in zip(nodes, depths, strict=True) if d == depth] for depth in sorted(set(depths))]
        guessed = _guessed(self.nodes, depths)
        self.cut, self._readers = list(guessed), list(guessed.values())
        self._least = np.array([interfaces[u].outputs[n].nominal for u, n in (self._ends[k] for k in self.cut)])
        # units that answer with what they held over the step; what they hand on belongs to its end
        self._behind = [node for node in nodes if _answers_at_once(node, interfaces[node.unit.name]) and not node.follows]
        self._states: list[Any] = [None] * len(nodes)
        self._foresee = network.rows((FORESEE, [node for node in nodes if node.sources]))
        acts: list[tuple[int, Sequence[Node]]] = []
        for level in self._levels:
            behind = [node for node in level if node in self._behind]
            acts += [(START, level), (READ, level), (UPDATE, behind), (READ, behind)]
        self._sweep = network.rows(*acts)

    def save(self) -> None:
        """Keep the units' states, over those of the last time."""
        self._states = [node.unit.save(state) for node, state in zip(self.nodes, self._states, strict=True)]

    def restore(self) -> None:
        """Take back the states of `save`."""
        for node, state in zip(self.nodes, self._states, strict=True):
            node.unit.restore(state)

    def predicted(self, machine: Machine, h: float) -> np.ndarray:
        """Where the signals at the cut will be h later, from what their readers have got so far."""
        machine.perform(self._foresee, 0.0, h)
        guess = []
        for k, reader in zip(self.cut, self._readers, strict=True):
            value = machine.signals[k]
            if reader is not None:
                node, j = reader
                link = node.links[j]
                value = (node.foreseen()[j] - link.offset) / link.factor
            guess.append(value)
        return np.array(guess)

    def missed(self, guess: np.ndarray, response: np.ndarray) -> tuple[float, Endpoint]:
        """Largest miss of a signal at the cut relative to its size, and that signal; infinite where it is no number."""
        misses = np.abs(response - guess) / self.sizes(response)
        worst = int(np.argmax(misses))  # of a row with NaN it is the NaN
        return (float(misses[worst]) if np.isfinite(misses[worst]) else inf), self._ends[self.cut[worst]]

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """Sizes that misses of the signals at the cut are compared with, (n,): their values or nominal values."""
        return np.maximum(np.abs(values), self._least)

    def respond(self, guess: np.ndarray, machine: Machine, t: float, h: float) -> np.ndarray:
        """Step from t to t + h with these values at the cut at the end, (n,), and give the values that come back."""
        machine.signals[self.cut] = guess
        self.sweep(machine, t, h)
        return machine.signals[self.cut]

    def sweep(self, machine: Machine, t: float, h: float) -> None:
        """Step every unit once, towards what the table of signals says that its inputs will be."""
        machine.perform(self._sweep, t, h)


def _owners(nodes: Sequence[Node]) -> dict[int, int]:
    """Signal -> the place of the unit among `nodes` that gives it."""
    return {k: i for i, node in enumerate(nodes) for k in range(node.place.start, node.place.stop)}


def _depths(nodes: Sequence[Node]) -> list[int]:
    """Levels: of each unit one more than the deepest of the earlier ones that feed it."""
    owner, depths = _owners(nodes), list[int]()
    for i, node in enumerate(nodes):
        depths.append(max((depths[owner[k]] + 1 for k in node.sources if owner.get(k, i) < i), default=0))
    return depths


def _guessed(nodes: Sequence[Node], depths: Sequence[int]) -> dict[int, tuple[Node, int] | None]:
    """Signals that feed backwards, each with a reader and the place of its input; None where no reader can tell the signal."""
    owner, guessed = _owners(nodes), dict[int, tuple[Node, int] | None]()
    for node, depth in zip(nodes, depths, strict=True):
        for j, (k, link) in enumerate(zip(node.sources, node.links, strict=True)):
            if k in owner and depths[owner[k]] >= depth and j not in node.held and guessed.get(k) is None:
                guessed[k] = (node, j) if link.factor else None
    return guessed


def _answers_at_once(node: Node, interface: Interface) -> bool:
    """Whether an output depends directly on an input that is driven."""
    driven = {link.target[1] for link in node.links}
    return any(driven & set(output.feedthrough or ()) for output in interface.outputs.values())
