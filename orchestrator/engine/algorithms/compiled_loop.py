"""Stretches of macro steps in compiled code, where a scene allows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from ....components.core.errors import StepFailed
from ...units.component import ComponentUnit
from ...units.fmi2 import Fmi2CoSimulation
from ..coupling import Endpoint
from .compiled import FAILED, JUMPED, LINK, OVERRIDDEN, SHIFTED, SMOOTH, UNALTERED, UNIT, run_steps
from .energy import EnergyAccount
from .gauss_seidel import GaussSeidel
from .initial import RUNAWAY
from .jacobi import Jacobi
from .master import Master
from .node import Alteration, Node, SmoothNode

Unit = ComponentUnit | Fmi2CoSimulation


class CompiledLoop:
    """Macro steps of a master in compiled code, with the same bits; made by `batch_loop_for`.

    The nodes' histories are the only truth between stretches, so that faults, checkpoints and whatever else looks at or
    changes a master there need not know of this. Of the last stretch: `inputs` (m, 2, L), the inputs in the order of the nodes'
    links behind the steps `looks` (m,), and where extrapolation has taken them; `outputs` (n, W), what `watch` has asked for.
    """

    def __init__(self, master: Master, units: Sequence[Unit], halt: np.ndarray, account: EnergyAccount | None = None):
        self._master, self._units, self._halt, self._account = master, units, halt, account
        self._made_for: Any = None  # what the addresses of the units follow from
        nodes, sequential = master.nodes, isinstance(master, GaussSeidel)
        ends = np.cumsum([0] + [len(node.links) for node in nodes])
        self._slices = [slice(a, b) for a, b in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]
        self._now, self._links = np.zeros(len(nodes), dtype=UNIT), np.zeros(ends[-1], dtype=LINK)
        self._none = [[0.0] * len(node.links) for node in nodes]  # for samples that there are none of
        late = master.late if isinstance(master, GaussSeidel) else [len(node.links) for node in nodes]
        for node, at, behind, row in zip(nodes, self._slices, late, self._now, strict=True):
            row["first_link"], row["links"], row["late"] = at.start, len(node.links), behind
            row["first_signal"], row["signals"] = node.place.start, node.place.stop - node.place.start
            row["led"] = sequential and behind == 0 and bool(node.links) and node.follows
            row["degree"] = node.history.degree
            links = self._links[at]
            links["source"], links["held"][list(node.held)] = node.sources, True
            for name in ("factor", "offset"):
                links[name] = [getattr(link, name) for link in node.links]
            for place, change in node.direct:
                links[place]["direct"], links[place]["change"] = True, change
        self._links["converted"] = (self._links["factor"] != 1.0) | (self._links["offset"] != 0.0)
        following = np.array([nodes.index(node) for node in master.feedthrough_schedule], dtype=np.int64)
        self._outputs_at, self._signals = np.zeros(len(master.signals), dtype=np.int64), np.zeros(len(master.signals))
        self._watched = np.zeros(0, dtype=np.int64)
        self._bonded = np.array(self._places_of_bonds(ends), dtype=np.int64)
        self._layout = (self._now, self._links, following, self._outputs_at, np.array(master.weights), self._bonded)
        self._memory = self._signals, np.zeros(3 * ends[-1]), sequential
        self._run(np.empty(0), 0.0, np.zeros(0, dtype=np.int64))  # compiles it

    @property
    def possible(self) -> bool:
        """Whether the next steps may be taken so: what alters inputs has numbers, and no unit has ended the simulation."""
        ended = any(unit.ended for unit in self._units if isinstance(unit, Fmi2CoSimulation))
        return not ended and all(_changes(node) is not None for node in self._master.nodes)

    def run(self, times: np.ndarray, h: float, looks: np.ndarray) -> tuple[np.ndarray, BaseException | None]:
        """Steps from each of `times`, s, of length h: the signals behind every step that was completed, and why one was not.

        looks: (m,), steps counted from 0 behind which `inputs` are wanted.
        """
        self.prepare(h)
        self._load()
        (done, unit, status), (rows, given, self.inputs, self.outputs) = self._run(times, h, looks)
        self._store(done)
        failure: BaseException | None = None
        t = float(times[min(done, len(times) - 1)])
        for one, taken, reached in zip(self._units, self._now["taken"].tolist(), self._now["time"].tolist(), strict=True):
            one.stepped(taken, reached if isinstance(one, ComponentUnit) else t)
        if unit >= 0:
            one = self._units[unit]
            try:
                if isinstance(one, ComponentUnit):
                    one.stopped(status // FAILED, t)
                else:
                    one.stopped(status, t, h)
                    self._complete(unit, t, h, given[done])
                    rows[done], done = self._master.signals, done + 1
            except (Exception, SystemExit) as error:  # those of Python in a component, too: the steps before it stand
                failure = error
        if unit == -2:
            failure = self._beyond(float(times[done - 1]) + h)
            done -= failure is not None
        if self._account is not None and done:
            self._account.enter(h, rows[:done], given[:done])
        return rows[:done], failure

    @property
    def saves(self) -> bool:
        """Whether all units are components, which save their state in little time."""
        return all(isinstance(unit, ComponentUnit) for unit in self._units)

    def save(self) -> Any:
        """All that the next steps depend on, and counters of the units, which must all be components."""
        return (self._account or self._master).save(), [unit.component.counts.copy() for unit in self._components]

    def restore(self, saved: Any) -> None:
        """Take back what `save` gave."""
        state, counts = saved
        (self._account or self._master).restore(state)
        for unit, values in zip(self._components, counts, strict=True):
            unit.component.counts[:] = values

    @property
    def _components(self) -> list[ComponentUnit]:
        return [unit for unit in self._units if isinstance(unit, ComponentUnit)]

    def watch(self, ends: Sequence[Endpoint]) -> slice | None:
        """Columns of `outputs` in which these outputs will stand; None where not all are those of components."""
        units = {unit.name: unit for unit in self._units}
        first, at = self._watched.size, list[int]()
        for name, output in ends:
            unit = units.get(name)
            if not isinstance(unit, ComponentUnit):
                return None
            at += unit.outputs_at([output])
        self._watched = np.array([*self._watched, *at], dtype=np.int64)
        return slice(first, first + len(at))

    def _run(self, times: np.ndarray, h: float, looks: np.ndarray) -> tuple[tuple[int, int, int], tuple[np.ndarray, ...]]:
        """What `run_steps` returns; and its signals, what bonded inputs were given, inputs with their ends, watched outputs."""
        n = len(times)
        space = (np.empty((n, self._signals.size)), np.empty((n, self._bonded.size, 4)),
                 np.empty((looks.size, 2, self._links.size)), np.empty((n, self._watched.size)))
        return run_steps(*self._layout, self._watched, *self._memory, times, h, RUNAWAY, self._halt, looks, *space), space

    def _places_of_bonds(self, first: np.ndarray) -> list[int]:
        """Links of the account's inputs; `first`: of each node."""
        of_unit = {node.unit.name: int(k) for node, k in zip(self._master.nodes, first, strict=False)}
        return [of_unit[meter.name] + place for meter, place, _ in self._account.inputs] if self._account else []

    def prepare(self, h: float) -> None:
        """Find the addresses of the units for steps of length h, which those of components depend on."""
        needed = h, [unit.starts for unit in self._units if isinstance(unit, ComponentUnit)]
        if needed == self._made_for:
            return
        self._made_for = needed
        self._tables = [unit.call_table(h) for unit in self._units]  # keeps alive what the addresses point to
        for row, table, at, node in zip(self._now, self._tables, self._slices, self._master.nodes, strict=True):
            assert table is not None
            row["way"] = table.way
            for name, address in table.calls.items():
                row[name] = address
            self._links["at"][at], self._outputs_at[node.place] = table.inputs_at, table.outputs_at
            self._links["apart"][at], row["held"] = table.apart, sum(table.apart)

    def _beyond(self, t: float) -> StepFailed | None:
        """What is wrong with the master's signals at t, s; None where nothing is."""
        try:
            self._master.check_finite(t)
        except StepFailed as error:
            return error
        return None

    def _complete(self, unit: int, t: float, h: float, given: np.ndarray) -> None:
        """The rest of a step in which a unit has stepped although it does not say so: it has ended the simulation there.

        given: (B, 4), what bonded inputs were given in it.
        """
        node, master = self._master.nodes[unit], cast(Jacobi | GaussSeidel, self._master)
        if isinstance(master, GaussSeidel):
            master.signals[node.place] = node.unit.get()
        master.step(t, h, unit + 1)
        driven = self._slices[unit].stop  # links before it were driven by compiled code
        for k, link in enumerate(self._bonded.tolist()):
            meter, place, _ = self._account.inputs[k]  # type: ignore[union-attr]
            given[k] = self._links[["value", "slope", "half", "degree"]][link].tolist() if link < driven else meter.given(place)

    def _load(self) -> None:
        now, links, nodes = self._now, self._links, self._master.nodes
        pasts = [node.history for node in nodes]
        self._signals[:] = self._master.signals
        now["taken"], now["samples"] = 0, [past.count for past in pasts]
        now["h1"], now["h2"] = [past.h1 for past in pasts], [past.h2 for past in pasts]
        links["fault"] = UNALTERED
        rows = {"present": [past.present for past in pasts], "before": [past.before for past in pasts],
                "earlier": [past.earlier for past in pasts], "reached": [node.reached for node in nodes]}
        for name, values in rows.items():
            links[name] = [v for k, row in enumerate(values) for v in (self._none[k] if row is None else row)]
        for node, unit, at, row in zip(nodes, self._units, self._slices, now, strict=True):
            if isinstance(unit, ComponentUnit):
                row["time"] = unit.component.t
            else:
                row["no_return"], row["time"] = not unit.keeps_states(), unit.last_start()
            for place, (replaced, number) in (_changes(node) or {}).items():
                links["fault"][at.start + place] = OVERRIDDEN if replaced else SHIFTED
                links["alteration"][at.start + place] = number
            if isinstance(node, SmoothNode) and not row["led"]:
                row["smoothing"] = JUMPED if node.reached is None else SMOOTH

    def _store(self, done: int) -> None:
        now, master = self._now, self._master
        master.signals[:] = self._signals if isinstance(master.signals, np.ndarray) else self._signals.tolist()
        master.steps += done
        numbers = [now[name].tolist() for name in ("samples", "h1", "h2", "interpolates")]
        present, before, earlier, known, reached = (
            self._links[name].copy() for name in ("present", "before", "earlier", "known", "reached"))
        for node, at, samples, h1, h2, interpolated in zip(master.nodes, self._slices, *numbers, strict=True):
            if node.links:
                take, past = node.rows.of_array, node.history
                past.count, past.h1, past.h2 = samples, h1, h2
                past.present, past.before, past.earlier = take(present[at]), take(before[at]), take(earlier[at])
                node.reached, node.known = (None, take(known[at])) if interpolated else (take(reached[at]), None)


def _changes(node: Node) -> Mapping[int, tuple[bool, float]] | None:
    """What faults do to the node's inputs, as `Alteration.together`."""
    return {} if node.alter is None else node.alter.together if isinstance(node.alter, Alteration) else None
