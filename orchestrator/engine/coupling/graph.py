"""The directed graph of a scene: circles of units, and what follows within an instant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from graphlib import TopologicalSorter

from ...units import Interface
from ...units.interface import Signal

Endpoint = tuple[str, str]  # unit, variable


@dataclass(frozen=True)
class Link:
    """One connection: target = factor * source + offset, or by a map of values; such a target follows no change, so its factor is 0."""

    source: Endpoint
    target: Endpoint
    factor: float
    offset: float
    map: tuple[tuple[float, float], ...] = ()  # (source, target)


def is_discrete(signal: Signal) -> bool:
    """Whether a signal changes at instants only, and is held between them."""
    return signal.discrete or signal.kind != "real"


def smooth(interfaces: Mapping[str, Interface], links: Iterable[Link]) -> list[Link]:
    """The links whose values change inside a step: neither end jumps."""
    return [
        link
        for link in links
        if not is_discrete(interfaces[link.source[0]].outputs[link.source[1]])
        and not is_discrete(interfaces[link.target[0]].inputs[link.target[1]])
    ]


def groups(interfaces: Mapping[str, Interface], links: Iterable[Link]) -> tuple[tuple[str, ...], ...]:
    """Strongly connected groups of units, each in the order of the scene; a group stands behind all that feed it."""
    names = list(interfaces)
    pairs = {(names.index(link.source[0]), names.index(link.target[0])) for link in links}
    label = _strong(len(names), pairs)
    members: dict[int, list[str]] = {}
    for name, group in zip(names, label, strict=True):
        members.setdefault(group, []).append(name)
    before: dict[int, list[int]] = {group: [] for group in members}
    for source, target in sorted(pairs):
        if label[source] != label[target]:
            before[label[target]].append(label[source])
    return tuple(tuple(members[group]) for group in TopologicalSorter(before).static_order())


@dataclass(frozen=True)
class Loop:
    """An algebraic loop: outputs that depend on one another within an instant, with no state between them."""

    outputs: tuple[Endpoint, ...]  # in the order of the scene
    units: tuple[str, ...]

    @property
    def text(self) -> str:
        """The outputs as a user names them."""
        return ", ".join(map(".".join, self.outputs))


def feedthrough_schedule(interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> tuple[str | Loop, ...]:
    """Levels of the graph of direct dependences: a unit is updated once for each level its outputs stand on.

    Outputs that depend on one another are a loop, which has a level as one.
    """
    sources = {link.target: link.source for link in links}
    ends = [(u, n) for u, interface in interfaces.items() for n in interface.outputs]
    ranks = {end: k for k, end in enumerate(ends)}
    behind: list[list[int]] = []
    for unit, name in ends:
        direct = interfaces[unit].outputs[name].feedthrough or ()
        behind.append([ranks[sources[unit, i]] for i in direct if (unit, i) in sources])
    label = _strong(len(ends), [(source, k) for k, before in enumerate(behind) for source in before])
    members: dict[int, list[int]] = {}
    for k, group in enumerate(label):
        members.setdefault(group, []).append(k)
    feeding = {group: {label[s] for k in inside for s in behind[k]} - {group} for group, inside in members.items()}
    levels: dict[int, int] = {}
    names = list(interfaces)
    steps: set[tuple[int, int, Loop | None]] = set()
    for group in TopologicalSorter(feeding).static_order():
        inside = members[group]
        loop = len(inside) > 1
        levels[group] = level = max((levels[g] + 1 for g in feeding[group]), default=int(loop))
        if loop:
            circle = tuple(ends[k] for k in inside)
            steps.add((level, names.index(circle[0][0]), Loop(circle, tuple(dict.fromkeys(unit for unit, _ in circle)))))
        elif level:
            steps.add((level, names.index(ends[inside[0]][0]), None))
    return tuple(loop or names[rank] for _, rank, loop in sorted(steps, key=lambda step: (step[:2], step[2] is not None)))


def _strong(n: int, pairs: Iterable[tuple[int, int]]) -> list[int]:
    """A number for each of n points, the same for those that can reach one another along the pairs (from, to).

    Kosaraju's two walks. SciPy has the same, but takes a quarter of a second of every start to load.
    """
    ahead: list[list[int]] = [[] for _ in range(n)]
    back: list[list[int]] = [[] for _ in range(n)]
    for source, target in pairs:
        ahead[source].append(target)
        back[target].append(source)
    left = _walked(ahead, range(n))
    label = [0] * n
    seen: set[int] = set()
    for number, point in enumerate(reversed(left)):
        for k in _walked(back, [point], seen):
            label[k] = number
    return label


def _walked(following: list[list[int]], starts: Iterable[int], seen: set[int] | None = None) -> list[int]:
    """The points reached from `starts` that are not in `seen`, which grows by them, in the order in which a walk leaves them."""
    seen, left = set() if seen is None else seen, []
    for start in starts:
        path = [] if start in seen else [(start, iter(following[start]))]
        seen.add(start)
        while path:
            rest = path[-1][1]
            new = next((k for k in rest if k not in seen), None)
            if new is None:
                left.append(path.pop()[0])
            else:
                seen.add(new)
                path.append((new, iter(following[new])))
    return left
