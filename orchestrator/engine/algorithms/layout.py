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
    nodes, table, coupling = network.nodes, network.table, network.coupling
    rated = [node for node in nodes if node.own is not None]
    parts: list[tuple[int, tuple[Samples, ...]]] = [(len(node.links), node.samples) for node in nodes]
    for node in rated:
        own, seen = node.own  # type: ignore[misc]
        parts += [(len(node.links), (own,) if node.links else ()), (node.place.stop - node.place.start, (seen,))]
    first_links = [0, *accumulate(n for n, _ in parts)]
    first_pasts = [0, *accumulate(len(samples) for _, samples in parts)]
    places = {id(node): k for k, node in enumerate(nodes)}
    mapped = [(first_links[k] + i, link.map) for k, node in enumerate(nodes) for i, link in enumerate(node.links) if link.map]
    pairs = [number for _, pairs in mapped for pair in pairs for number in pair]
    owners = [(network.node_of[link.target[0]], link) for bond in coupling.bonds for link in bond.links]
    bonds = [first_links[places[id(node)]] + node.links.index(link) for node, link in owners]
    records = Records(
        len(parts),
        first_links[-1],
        first_pasts[-1],
        network.program,
        network.weights,
        bonds,
        table + sum(len(node.links) for node in rated) + len(pairs),
        first_links[len(nodes)],
        groups,
        [len(ends) for ends in coupling.faults],
    )
    units, links, pasts = records.memory.units, records.memory.links, records.memory.pasts
    units["first_link"], units["links"] = first_links[:-1], [n for n, _ in parts]
    units["first_past"], units["pasts"] = first_pasts[:-1], [len(samples) for _, samples in parts]
    units["every"], units["stop"], links["factor"] = 1, end, 1.0
    for (_, samples), first_link, first_past in zip(parts, first_links, first_pasts, strict=False):
        for k, sample in enumerate(samples, first_past):
            pasts["degree"][k], pasts["every"][k] = sample.degree, sample.every
            for held, which in ((0, sample.places), (JUMPS, sample.jumping), (CONSTANT, sample.constant)):
                links["held"][[first_link + place for place in which]] = held
            links["past"][[first_link + place for place in sample.places]] = k
    for k, node in enumerate(nodes):
        row, mine = units[k : k + 1], links[first_links[k] : first_links[k + 1]]
        row["n_extrapolated"], row["all_interpolated"] = (
            node.extrapolated,
            network.consistent and node.extrapolated == 0 and bool(node.links) and node.follows and not node.held,
        )
        row["first_signal"], row["signals"] = node.place.start, node.place.stop - node.place.start
        mine["source"] = node.sources
        for name in ("factor", "offset"):
            mine[name] = [getattr(link, name) for link in node.links]
        for place, change in node.direct:
            mine["direct"][place], mine["change"][place] = 1, change
    links["converted"] = (links["factor"] != 1.0) | (links["offset"] != 0.0)
    cells = table
    for k, node in enumerate(rated, 0):
        own, outer = len(nodes) + 2 * k, units[places[id(node)] : places[id(node)] + 1]
        outer["input_mode"], outer["slow"], outer["every"] = NOTED, own, node.every
        assert node.estimates is not None
        for row, first, n in ((own, node.place.start, outer["signals"][0]), (own + 1, node.estimates.start, 0)):
            units["first_signal"][row], units["signals"][row] = first, n
        links["source"][first_links[own] : first_links[own + 1]] = np.arange(cells, cells + len(node.links))
        links["source"][first_links[own + 1] : first_links[own + 2]] = np.arange(node.place.start, node.place.stop)
        cells += len(node.links)
    records.memory.signals[cells:] = pairs
    for row, of in mapped:
        links["first_pair"][row], links["pairs"][row] = cells, len(of)
        cells += 2 * len(of)
    for k, node in enumerate(nodes):
        node.bind(records, k)
    return records
