"""From the nodes of a master to its records: the place of each, and the program of the macro step."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from ...units.call_names import NOTED
from .memory import Records
from .network import Network
from .node import Samples
from .records import CONSTANT, JUMPS


def lay_out(network: Network, end: float, groups: Sequence[tuple[Sequence[int], Sequence[tuple[int, bool, float]]]]) -> Records:
    """The records of the nodes of a network, each bound to its own.

    A unit with a rate of its own has two more behind all units: the one that steps, whose inputs have cells behind the `table`
    of signals, and the one that gives its outputs between its steps. Maps of values stand behind all of these cells.
    end: s, of the run; groups: as of `Records`.
    """
    laid = _Layout(network)
    laid.records = records = laid.records_for(groups)
    records.memory.units["every"], records.memory.units["stop"] = 1, end
    laid.write_histories()
    laid.write_nodes()
    laid.write_maps(laid.write_rates())
    for k, node in enumerate(network.nodes):
        node.bind(records, k)
    return records


class _Layout:
    """Which records a network needs, and what stands in them. parts: links and samples of each unit's record, in their order."""

    records: Records

    def __init__(self, network: Network):
        self._network, nodes = network, network.nodes
        self._rated = [node for node in nodes if node.own is not None]
        self._parts: list[tuple[int, tuple[Samples, ...]]] = [(len(node.links), node.samples) for node in nodes]
        for node in self._rated:
            own, seen = node.own  # type: ignore[misc]
            self._parts += [(len(node.links), (own,) if node.links else ()), (node.place.stop - node.place.start, (seen,))]
        self._first_links = [0, *accumulate(n for n, _ in self._parts)]
        self._first_pasts = [0, *accumulate(len(samples) for _, samples in self._parts)]
        self._places = {id(node): k for k, node in enumerate(nodes)}
        maps = [(self._first_links[k] + i, link.map) for k, node in enumerate(nodes) for i, link in enumerate(node.links)]
        self._mapped = [(row, pairs) for row, pairs in maps if pairs]

    def records_for(self, groups: Sequence[tuple[Sequence[int], Sequence[tuple[int, bool, float]]]]) -> Records:
        """Records of the sizes that are needed."""
        network, rated, coupling = self._network, self._rated, self._network.coupling
        owners = [(network.node_of[link.target[0]], link) for bond in coupling.bonds for link in bond.links]
        bonds = [self._first_links[self._places[id(node)]] + node.links.index(link) for node, link in owners]
        return Records(
            len(self._parts),
            self._first_links[-1],
            self._first_pasts[-1],
            network.program,
            network.weights,
            bonds,
            network.table + sum(len(node.links) for node in rated) + sum(2 * len(pairs) for _, pairs in self._mapped),
            self._first_links[len(network.nodes)],
            groups,
            [len(ends) for ends in coupling.faults],
        )

    def write_histories(self) -> None:
        """Which links and samples are those of each unit, and which input is extrapolated by which samples."""
        units, links, pasts = self.records.memory.units, self.records.memory.links, self.records.memory.pasts
        units["first_link"], units["links"] = self._first_links[:-1], [n for n, _ in self._parts]
        units["first_past"], units["pasts"] = self._first_pasts[:-1], [len(samples) for _, samples in self._parts]
        for (_, samples), first_link, first_past in zip(self._parts, self._first_links, self._first_pasts, strict=False):
            for k, sample in enumerate(samples, first_past):
                pasts["degree"][k], pasts["every"][k] = sample.degree, sample.every
                for held, which in ((0, sample.places), (JUMPS, sample.jumping), (CONSTANT, sample.constant)):
                    links["held"][[first_link + place for place in which]] = held
                links["past"][[first_link + place for place in sample.places]] = k

    def write_nodes(self) -> None:
        """Of each node where its signals are, and of its links from where they come and what they make of it."""
        units, links = self.records.memory.units, self.records.memory.links
        links["factor"] = 1.0
        for k, node in enumerate(self._network.nodes):
            row, mine = units[k : k + 1], links[self._first_links[k] : self._first_links[k + 1]]
            follows = self._network.consistent and node.extrapolated == 0 and bool(node.links) and node.follows and not node.held
            row["n_extrapolated"], row["all_interpolated"] = node.extrapolated, follows
            row["first_signal"], row["signals"] = node.place.start, node.place.stop - node.place.start
            mine["source"] = node.sources
            for name in ("factor", "offset"):
                mine[name] = [getattr(link, name) for link in node.links]
            for place, change in node.direct:
                mine["direct"][place], mine["change"][place] = 1, change
        links["converted"] = (links["factor"] != 1.0) | (links["offset"] != 0.0)

    def write_rates(self) -> int:
        """The two further records of each unit with a rate of its own; returns the first cell behind those of their inputs."""
        units, links, first_links = self.records.memory.units, self.records.memory.links, self._first_links
        cells = self._network.table
        for own, node in zip(range(len(self._network.nodes), len(self._parts), 2), self._rated, strict=True):
            place = self._places[id(node)]
            outer = units[place : place + 1]
            outer["input_mode"], outer["slow"], outer["every"] = NOTED, own, node.every
            assert node.estimates is not None
            for row, first, n in ((own, node.place.start, outer["signals"][0]), (own + 1, node.estimates.start, 0)):
                units["first_signal"][row], units["signals"][row] = first, n
            links["source"][first_links[own] : first_links[own + 1]] = np.arange(cells, cells + len(node.links))
            links["source"][first_links[own + 1] : first_links[own + 2]] = np.arange(node.place.start, node.place.stop)
            cells += len(node.links)
        return cells

    def write_maps(self, cells: int) -> None:
        """Pairs of values that become others, from a cell on."""
        links = self.records.memory.links
        for row, pairs in self._mapped:
            links["first_pair"][row], links["pairs"][row] = cells, len(pairs)
            self.records.memory.signals[cells : cells + 2 * len(pairs)] = np.ravel(pairs)
            cells += 2 * len(pairs)
