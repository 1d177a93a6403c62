"""The units, links and histories of a master as records for compiled steps, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ...units.component import ComponentUnit
from .compiled import CONSTANT, JUMPED, JUMPS, LINK, NOTED, OVERRIDDEN, PAST, SHIFTED, SMOOTH, UNALTERED, UNIT
from .master import Master
from .multirate import Mixed, MultirateUnit
from .node import Alteration, Node, SmoothNode
from .polynomial import History

if TYPE_CHECKING:
    from ...units.fmi2 import Fmi2CoSimulation

Unit: TypeAlias = "ComponentUnit | Fmi2CoSimulation"


class Records:
    """Records of a master, see `compiled`: its units, and in `slow` two more for each unit with a rate of its own.

    links: those of the units, `driven` in number, and behind them those of the slow records; signals: the master's table, and
    behind it cells for the inputs of units with rates of their own. `slices` has the links of each record.
    """

    def __init__(self, master: Master, units: Sequence[Unit]):
        nodes = master.nodes
        self._master, self._units = master, units
        self._rated = [(k, node, node.unit) for k, node in enumerate(nodes) if isinstance(node.unit, MultirateUnit)]
        widths = [len(node.links) for node in nodes]
        self.driven, U, table = sum(widths), len(nodes), len(master.signals)
        widths += [n for _, node, _ in self._rated for n in (len(node.links), node.place.stop - node.place.start)]
        ends = np.cumsum([0, *widths]).tolist()
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        self._all, self.links = np.zeros(len(widths), dtype=UNIT), np.zeros(ends[-1], dtype=LINK)
        self.units, self.slow = self._all[:U], self._all[U:]
        self._all["first_link"], self._all["links"], self._all["every"] = ends[:-1], widths, 1
        self._called = np.arange(U)  # records with the addresses of each unit
        self.links["factor"] = 1.0
        for node, at, behind, row in zip(nodes, self.slices, master.late, self.units, strict=False):
            row["late"], row["led"] = behind, master.sequential and behind == 0 and bool(node.links) and node.follows
            row["first_signal"], row["signals"] = node.place.start, node.place.stop - node.place.start
            links = self.links[at]
            links["source"] = node.sources
            for name in ("factor", "offset"):
                links[name] = [getattr(link, name) for link in node.links]
            for place, change in node.direct:
                links[place]["direct"], links[place]["change"] = True, change
        self.links["converted"] = (self.links["factor"] != 1.0) | (self.links["offset"] != 0.0)
        cells = table
        for k, (place, node, unit) in enumerate(self._rated):
            row, own, seen = self.units[place], *self.slow[2 * k : 2 * k + 2]
            row["way"], row["slow"], row["every"], self._called[place] = NOTED, 2 * k, unit.every, U + 2 * k
            own["first_signal"], own["signals"], seen["first_signal"] = row["first_signal"], row["signals"], unit.estimates.start
            own_at, seen_at = self.slices[U + 2 * k : U + 2 * k + 2]
            self.links["source"][own_at] = np.arange(cells, cells + len(node.links))
            self.links["source"][seen_at] = np.arange(node.place.start, node.place.stop)
            cells += len(node.links)
        self.signals, self._table = np.zeros(cells), slice(0, table)
        self.outputs_at = np.zeros(table, dtype=np.int64)
        self._lay_out_pasts()

    def _lay_out_pasts(self) -> None:
        """Histories in the order of the units' records, and which links have their samples in each."""
        pasts: list[tuple[History, np.ndarray, int]] = []
        for past, at, row in zip(self._by_record(), self.slices, self._all, strict=True):
            parts = _samples(past, at.stop - at.start)
            row["first_past"], row["pasts"] = len(pasts), len(parts)
            pasts += [(history, at.start + np.array(places, dtype=np.int64), every) for history, places, every, _, _ in parts]
        self.pasts, self._places = np.zeros(len(pasts), dtype=PAST), [places for _, places, _ in pasts]
        for k, (history, places, every) in enumerate(pasts):
            self.pasts[k]["degree"], self.pasts[k]["every"], self.links["past"][places] = history.degree, every, k
            self.links["held"][places[list(getattr(history, "held", ()))]] = JUMPS
            self.links["held"][places[list(getattr(history, "constant", ()))]] = CONSTANT
        self._order = np.concatenate(self._places)
        self._none = [[0.0] * len(places) for places in self._places]  # for samples that there are none of

    def _by_record(self) -> list[History]:
        return [node.history for node in self._master.nodes] + [past for _, _, unit in self._rated for past in unit.histories]

    def _histories(self) -> list[tuple[History, Sequence[int], int, float, int]]:
        pasts = zip(self._by_record(), self.slices, strict=True)
        return [part for past, at in pasts for part in _samples(past, at.stop - at.start)]

    def possible(self, h: float) -> bool:
        """Whether what alters inputs has numbers, and units with rates of their own are within a step of macro steps of h, s."""
        even = all(count == 0 or length == count * h for _, _, unit in self._rated for count, _, length in (unit.progress,))
        return even and all(_changes(node) is not None for node in self._master.nodes)

    def address(self, h: float) -> list[object]:
        """Find the addresses of the units for macro steps of length h, s; returns what keeps alive that they point to."""
        tables = [unit.call_table(h * int(every)) for unit, every in zip(self._units, self.units["every"], strict=True)]
        for k, table, node in zip(self._called.tolist(), tables, self._master.nodes, strict=True):
            assert table is not None
            row, at = self._all[k], self.slices[k]
            row["way"] = table.way
            for name, address in table.calls.items():
                row[name] = address
            self.links["at"][at], self.outputs_at[node.place] = table.inputs_at, table.outputs_at
            self.links["apart"][at], row["held"] = table.apart, sum(table.apart)
        return list(tables)

    def taken(self) -> tuple[list[int], list[float]]:
        """Of each unit the steps since the last call, and the time it has reached, of an FMU the start of its last step, s."""
        taken, reached = (self._all[name][self._called].tolist() for name in ("taken", "time"))
        self._all["taken"] = 0
        return taken, reached

    def last_step(self, unit: int, t: float, h: float) -> tuple[float, float]:
        """Start and length, s, of a unit's step that ends with the macro step from t over h."""
        row = self.units[unit]
        return (float(row["start"]), float(row["length"])) if row["way"] == NOTED else (t, h)

    def load(self) -> None:
        """Take the present state of master and units."""
        links, pasts, nodes = self.links, self.pasts, self._master.nodes
        histories = self._histories()
        self.signals[self._table] = self._master.signals
        pasts["samples"], pasts["h1"], pasts["h2"], pasts["elapsed"], pasts["left"] = zip(*[
            (past.count, past.h1, past.h2, elapsed, left) for past, _, _, elapsed, left in histories], strict=True)
        links["fault"] = UNALTERED
        for name in ("present", "before", "earlier"):
            rows = zip([getattr(past, name) for past, *_ in histories], self._none, strict=True)
            links[name][self._order] = [v for row, none in rows for v in (none if row is None else row)]
        for node, unit, k, at, row in zip(nodes, self._units, self._called, self.slices, self.units, strict=False):
            if node.reached is not None:
                links["reached"][at] = node.reached
            if isinstance(node.history, Mixed):
                links["now"][at] = node.history.present
            if isinstance(unit, ComponentUnit):
                self._all[k]["time"] = unit.component.t
            else:
                self._all[k]["no_return"], self._all[k]["time"] = not unit.keeps_states(), unit.last_start()
            for place, (replaced, number) in (_changes(node) or {}).items():
                links["fault"][at.start + place] = OVERRIDDEN if replaced else SHIFTED
                links["alteration"][at.start + place] = number
            if isinstance(node, SmoothNode) and not row["led"]:
                row["smoothing"] = JUMPED if node.reached is None else SMOOTH
        for place, _, rated in self._rated:
            row = self.units[place]
            row["count"], row["start"], row["length"] = rated.progress

    def store(self, done: int, h: float) -> None:
        """Give it back behind `done` steps of length h, s."""
        links, master = self.links, self._master
        table = self.signals[self._table]
        master.signals[:] = table if isinstance(master.signals, np.ndarray) else table.tolist()
        master.steps += done
        samples = [links[name][self._order] for name in ("present", "before", "earlier")]
        numbers = [self.pasts[name].tolist() for name in ("samples", "h1", "h2")]
        first = 0
        for (past, *_), none, count, h1, h2 in zip(self._histories(), self._none, *numbers, strict=True):
            at, take = slice(first, first := first + len(none)), past.rows.of_array
            if none:
                past.count, past.h1, past.h2 = count, h1, h2
                past.present, past.before, past.earlier = [take(row[at]) for row in samples]
        now, known, reached = (links[name].copy() for name in ("now", "known", "reached"))
        for node, at, row in zip(master.nodes, self.slices, self.units, strict=False):
            take, past = node.rows.of_array, node.history
            if node.links:
                node.reached, node.known = (None, take(known[at])) if row["interpolates"] else (take(reached[at]), None)
            if isinstance(past, Mixed):
                past.present, past.h1, past.pushes = take(now[at]), h, past.pushes + done
                for part, elapsed in zip(past.parts, self.pasts["elapsed"][row["first_past"] :].tolist(), strict=False):
                    part.elapsed = elapsed
        for k, node, unit in self._rated:
            count, start, length = self.units[k][["count", "start", "length"]].tolist()
            unit.advance(count, start, length, unit.histories[1].rows.of_array(self.signals[node.place]))


def _samples(past: History, n: int) -> list[tuple[History, Sequence[int], int, float, int]]:
    """(history, which of the n inputs, macro steps between samples, s since the last one, steps before that to the next)."""
    if isinstance(past, Mixed):
        return [(part.history, part.at, part.every, part.elapsed, -past.pushes % part.every) for part in past.parts]
    return [(past, range(n), 1, 0.0, 0)]


def _changes(node: Node) -> Mapping[int, tuple[bool, float]] | None:
    """What faults do to the node's inputs, as `Alteration.together`."""
    return {} if node.alter is None else node.alter.together if isinstance(node.alter, Alteration) else None
