"""The units of a scene as the nodes of a network, and the program on them: what an algorithm is built on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ...settings import MasterSettings
from ...units import Simulator
from ..coupling import Coupling, Endpoint, Link
from ..coupling.graph import is_discrete
from .node import Node, Samples, samples_of

Acts = Sequence[tuple[int, Sequence[Node]]]  # what is done, and with which units, one after the other
RowRange = tuple[int, int]  # of the program: the first one, and the one behind the last


class Network:
    """Nodes in the order of the units, the table of signals that they share, and the rows of the program.

    positions: of the outputs that are read in every step, in the table of signals. cells: these, with the estimates that others go by
    of a unit with a rate of its own: what links take, by source.
    """

    def __init__(
        self,
        units: Mapping[str, Simulator],
        coupling: Coupling,
        watched: Sequence[Endpoint],
        order: Sequence[str],
        settings: MasterSettings,
        extrapolated: Callable[[Link], bool],
        consistent: bool,
    ):
        """Wire the units. extrapolated, consistent: as of `Algorithm`, in this order of the units."""
        self.coupling, self.degree, self._moving_places = coupling, settings.extrapolation, settings.moving_places
        self._extrapolated, self.consistent = extrapolated, consistent
        self.handed_over = frozenset(link.source for link in coupling.links)  # initialization and step control go by these alone
        read = list(dict.fromkeys([*(link.source for link in coupling.links), *watched]))
        # in the order of the units' own outputs, which they can hand over in one piece
        ranks = {(u, n): (i, k) for i, u in enumerate(units) for k, n in enumerate(coupling.interfaces[u].outputs)}
        read.sort(key=ranks.__getitem__)
        self.positions: dict[Endpoint, int] = {end: k for k, end in enumerate(read)}
        guessed = [source for source in read if source[0] in coupling.rates]  # their estimates stand behind all that is read
        self.cells = self.positions | {source: len(read) + k for k, source in enumerate(guessed)}
        self.table = len(read) + len(guessed)
        self.weights = [1.0 / coupling.interfaces[u].outputs[n].nominal for u, n in read]
        self.nodes = [self._node(units[name], read) for name in order]
        self.node_of = {node.unit.name: node for node in self.nodes}
        self.fed = [node for node in self.nodes if node.sources]
        self.program: list[tuple[int, int]] = []
        self._used = self.handed_over | {*coupling.events}

    def rows(self, *acts: tuple[int, Sequence[Node]]) -> RowRange:
        """Rows of the program that do these acts; `Machine.perform` takes them."""
        first, places = len(self.program), {id(node): k for k, node in enumerate(self.nodes)}
        self.program += [(act, places[id(node)]) for act, nodes in acts for node in nodes]
        return first, len(self.program)

    def is_idle(self, end: Endpoint) -> bool:
        """Whether nothing in the coupling depends on an output, and it is one of a foreign FMU, which may be no number."""
        return self.coupling.interfaces[end[0]].foreign and end not in self._used

    def _node(self, unit: Simulator, read: Sequence[Endpoint]) -> Node:
        """The node of a unit, which is wired; its extrapolated links come first."""
        coupling, interfaces = self.coupling, self.coupling.interfaces
        name, rates = unit.name, coupling.rates
        mine = [k for k, source in enumerate(read) if source[0] == name]
        place = slice(mine[0], mine[-1] + 1) if mine else slice(0, 0)
        links = [link for link in coupling.links if link.target[0] == name]
        links.sort(key=lambda link: not self._extrapolated(link))
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
        return Node(
            unit,
            place,
            tuple(links),
            sum(map(self._extrapolated, links)),
            tuple(self.cells[link.source] for link in links),
            tuple(held),
            interfaces[name].input_degree >= self.degree and set(by_rate) <= {1},
            tuple(samples_of(self.degree, at, every, held, moving) for every, at in by_rate.items()),
            own,
            rates.get(name, 1),
            estimates,
        )
