"""The directed graph of a scene: circles of units, and what follows within an instant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from graphlib import TopologicalSorter

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from components.core.errors import BadInput

from .units import Interface

Endpoint = tuple[str, str]  # unit, variable


@dataclass(frozen=True)
class Link:
    """One connection: target = factor * source + offset."""

    source: Endpoint
    target: Endpoint
    factor: float
    offset: float


def groups(interfaces: Mapping[str, Interface], links: Iterable[Link]) -> tuple[tuple[str, ...], ...]:
    """Strongly connected groups of units, each in the order of the scene; a group stands behind all that feed it."""
    names = list(interfaces)
    pairs = {(names.index(link.source[0]), names.index(link.target[0])) for link in links}
    rows, columns = np.array(sorted(pairs), dtype=int).reshape(-1, 2).T
    graph = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(len(names), len(names)))
    label = connected_components(graph, connection="strong")[1].tolist()
    members: dict[int, list[str]] = {}
    for name, group in zip(names, label, strict=True):
        members.setdefault(group, []).append(name)
    before: dict[int, list[int]] = {group: [] for group in members}
    for source, target in sorted(pairs):
        if label[source] != label[target]:
            before[label[target]].append(label[source])
    return tuple(tuple(members[group]) for group in TopologicalSorter(before).static_order())


def passes(interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> tuple[str, ...]:
    """Levels of the graph of direct dependences: a unit is updated once for each level its outputs stand on."""
    sources = {link.target: link.source for link in links}
    levels: dict[Endpoint, int] = {}
    path: list[Endpoint] = []

    def level(end: Endpoint) -> int:
        if end in path:
            loop = " -> ".join(".".join(e) for e in reversed([end, *path[path.index(end) + 1 :], end]))
            raise BadInput("connections", f"an algebraic loop: {loop}", "a loop that at least one state breaks",
                           "Give one of the units a state, or put the loop inside one unit.")
        if end not in levels:
            path.append(end)
            direct = interfaces[end[0]].outputs[end[1]].feedthrough or ()
            behind = [sources[end[0], i] for i in direct if (end[0], i) in sources]
            levels[end] = max((level(s) + 1 for s in behind), default=0)
            path.pop()
        return levels[end]

    steps = {(level((u, n)), k) for k, (u, i) in enumerate(interfaces.items()) for n in i.outputs}
    return tuple(list(interfaces)[k] for depth, k in sorted(steps) if depth)
