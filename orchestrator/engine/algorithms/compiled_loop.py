"""Stretches of macro steps in compiled code, where a scene allows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from ....components.core.errors import StepFailed
from ...units.component import ComponentUnit
from ...units.fmi2 import Fmi2CoSimulation
from ..coupling import Endpoint
from .compiled import FAILED, WAY, LoopLayout, LoopState, run_steps
from .energy import EnergyAccount
from .gauss_seidel import GaussSeidel
from .initial import RUNAWAY
from .jacobi import Jacobi
from .master import Master

Unit = ComponentUnit | Fmi2CoSimulation


class CompiledLoop:
    """Macro steps of a master in compiled code, with the same bits; made by `batch_loop_for`.

    The nodes' histories are the only truth between stretches, so that faults, checkpoints and whatever else looks at or
    changes a master there need not know of this. `inputs`: of the last stretch, (n, 2, L), the inputs behind each step in the
    order of the nodes' links, and where extrapolation has taken them; `outputs`: of the same, (n, W), what `watch` has asked for.
    """

    def __init__(self, master: Master, units: Sequence[Unit], halt: np.ndarray, account: EnergyAccount | None = None):
        self._master, self._units, self._halt, self._account = master, units, halt, account
        self._made_for: Any = None  # what the addresses of the units follow from
        nodes = master.nodes
        links = [link for node in nodes for link in node.links]
        ends = np.cumsum([0] + [len(node.links) for node in nodes])
        n, u, signals = len(links), len(nodes), len(master.signals)
        late = master.late if isinstance(master, GaussSeidel) else [len(node.links) for node in nodes]
        shape = [(first, len(node.links), node.place.start, node.place.stop - node.place.start, 0, behind,
                  behind == 0 and node.follows) for node, first, behind in zip(nodes, ends, late, strict=False)]
        feedthrough_schedule = [nodes.index(node) for node in master.feedthrough_schedule]
        direct = [(k, place, change) for k, node in enumerate(nodes) for place, change in node.direct]
        factors, offsets = (np.array([getattr(link, name) for link in links], dtype=float) for name in ("factor", "offset"))
        self._plan = LoopLayout(
            calls=np.zeros((u, 8), dtype=np.int64), shape=np.array(shape, dtype=np.int64),
            inputs_at=np.zeros(n, dtype=np.int64), outputs_at=np.zeros(signals, dtype=np.int64),
            source=np.array([s for node in nodes for s in node.sources], dtype=np.int64),
            factor=factors, offset=offsets, converted=(factors != 1.0) | (offsets != 0.0),
            feedthrough_schedule=np.array(feedthrough_schedule, dtype=np.int64),
            direct=np.array([d[:2] for d in direct], dtype=np.int64).reshape(-1, 2),
            change=np.array([d[2] for d in direct], dtype=float),
            inverse=np.array(master.weights), bonded=np.array(self._bonded(ends), dtype=np.int64),
            watched=np.zeros(0, dtype=np.int64),
            degree=int(master.degree), sequential=isinstance(master, GaussSeidel),
        )
        link, unit = np.zeros(n), np.zeros(u)
        self._now = LoopState(
            signals=np.zeros(signals), present=link, before=link.copy(), earlier=link.copy(), reached=link.copy(),
            known=link.copy(), inputs=np.zeros(3 * n), given=np.zeros((n, 4)), samples=unit.astype(np.int64),
            spacing=np.zeros((u, 2)), interpolates=unit.astype(np.bool_), no_return=unit.astype(np.int32),
            taken=unit.astype(np.int64), time=unit,
        )
        run_steps(self._plan, self._now, np.empty(0), 0.0, RUNAWAY, halt, *self._empty(0))  # compiles it
        self._slices = [slice(a, b) for a, b in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]

    @property
    def possible(self) -> bool:
        """Whether the next steps may be taken so: no input is altered by a fault, and no unit has ended the simulation."""
        ended = any(unit.ended for unit in self._units if isinstance(unit, Fmi2CoSimulation))
        return not ended and all(node.alter is None for node in self._master.nodes)

    def run(self, times: np.ndarray, h: float) -> tuple[np.ndarray, BaseException | None]:
        """Steps from each of `times`, s, of length h: the signals behind every step that was completed, and why one was not."""
        self.prepare(h)
        self._load()
        rows, given, self.inputs, self.outputs = space = self._empty(len(times))
        done, unit, status = run_steps(self._plan, self._now, times, h, RUNAWAY, self._halt, *space)
        self._store(done)
        failure: BaseException | None = None
        t = float(times[min(done, len(times) - 1)])
        for k, (taken, reached) in enumerate(zip(self._now.taken.tolist(), self._now.time.tolist(), strict=True)):
            one = self._units[k]
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

    def watch(self, ends: Sequence[Endpoint]) -> slice | None:
        """Columns of `outputs` in which these outputs will stand; None where not all are those of components."""
        units = {unit.name: unit for unit in self._units}
        first, at = self._plan.watched.size, list[int]()
        for name, output in ends:
            unit = units.get(name)
            if not isinstance(unit, ComponentUnit):
                return None
            at += unit.outputs_at([output])
        self._plan = self._plan._replace(watched=np.array([*self._plan.watched, *at], dtype=np.int64))
        return slice(first, first + len(at))

    def _empty(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """For n steps: signals, what bonded inputs are given, all inputs with where they were led to, and watched outputs."""
        plan = self._plan
        return (np.empty((n, plan.inverse.size)), np.empty((n, plan.bonded.size, 4)), np.empty((n, 2, plan.source.size)),
                np.empty((n, plan.watched.size)))

    def _bonded(self, first: np.ndarray) -> list[int]:
        """Links of the account's inputs; `first`: of each node."""
        of_unit = {node.unit.name: int(k) for node, k in zip(self._master.nodes, first, strict=False)}
        return [of_unit[meter.name] + place for meter, place, _ in self._account.inputs] if self._account else []

    def prepare(self, h: float) -> None:
        """Find the addresses of the units for steps of length h, which those of components depend on."""
        needed = h, [unit.starts for unit in self._units if isinstance(unit, ComponentUnit)]
        if needed == self._made_for:
            return
        self._made_for, plan = needed, self._plan
        self._tables = [unit.call_table(h) for unit in self._units]  # keeps alive what the addresses point to
        for k, (table, at, node) in enumerate(zip(self._tables, self._slices, self._master.nodes, strict=True)):
            assert table is not None
            plan.calls[k], plan.shape[k, WAY] = table.calls, table.way
            plan.inputs_at[at], plan.outputs_at[node.place] = table.inputs_at, table.outputs_at

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
        for k, link in enumerate(self._plan.bonded.tolist()):
            meter, place, _ = self._account.inputs[k]  # type: ignore[union-attr]
            given[k] = self._now.given[link] if link < driven else meter.given(place)

    def _load(self) -> None:
        now = self._now
        now.taken[:] = 0
        now.signals[:] = self._master.signals
        for k, (node, at) in enumerate(zip(self._master.nodes, self._slices, strict=True)):
            past = node.history
            now.samples[k], now.spacing[k] = past.count, (past.h1, past.h2)
            unit = self._units[k]
            if isinstance(unit, ComponentUnit):
                now.time[k] = unit.component.t
            else:
                now.no_return[k] = not unit.keeps_states()
            for row, values in ((now.present, past.present), (now.before, past.before), (now.earlier, past.earlier)):
                if values is not None:
                    row[at] = values

    def _store(self, done: int) -> None:
        now, master = self._now, self._master
        master.signals[:] = now.signals if isinstance(master.signals, np.ndarray) else now.signals.tolist()
        master.steps += done
        for k, (node, at) in enumerate(zip(master.nodes, self._slices, strict=True)):
            if not node.links:
                continue
            take = node.rows.of_array
            past, count = node.history, int(now.samples[k])
            past.count, (past.h1, past.h2) = count, now.spacing[k].tolist()
            past.present = take(now.present[at])
            past.before, past.earlier = take(now.before[at]), take(now.earlier[at])
            interpolated = bool(now.interpolates[k])
            node.reached, node.known = (None, take(now.known[at])) if interpolated else (take(now.reached[at]), None)
