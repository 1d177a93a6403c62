"""Stretches of macro steps in compiled code, where a scene allows it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....components.core.errors import StepFailed
from ....components.core.kernels import COMPILED
from ...units.call_table import FmiCallTable
from ...units.fmi2 import Fmi2CoSimulation
from .compiled import LoopLayout, LoopState, run_steps
from .gauss_seidel import GaussSeidel
from .generated_loop import beyond
from .initial import RUNAWAY
from .master import Master


class CompiledLoop:
    """Macro steps of a master in compiled code, with the same bits; made by `compiled_loop_for`.

    The nodes' histories are the only truth between stretches, so that faults, checkpoints and whatever else looks at or
    changes a master there need not know of this.
    """

    def __init__(self, master: Master, units: Sequence[Fmi2CoSimulation], tables: Sequence[FmiCallTable], halt: np.ndarray):
        self._master, self._units, self._alive, self._halt = master, units, tables, halt
        nodes = master.nodes
        links = [link for node in nodes for link in node.links]
        ends = np.cumsum([0] + [len(node.links) for node in nodes])
        n, u = len(links), len(nodes)
        late = master.late if isinstance(master, GaussSeidel) else [len(node.links) for node in nodes]
        shape = [(first, len(node.links), node.place.start, node.place.stop - node.place.start, table.way, behind,
                  behind == 0 and node.follows)
                 for node, table, first, behind in zip(nodes, tables, ends, late, strict=False)]
        feedthrough_schedule = [nodes.index(node) for node in master.feedthrough_schedule]
        direct = [(k, place, change) for k, node in enumerate(nodes) for place, change in node.direct]
        factors, offsets = (np.array([getattr(link, name) for link in links], dtype=float) for name in ("factor", "offset"))
        self._plan = LoopLayout(
            calls=np.array([table.calls for table in tables], dtype=np.int64),
            shape=np.array(shape, dtype=np.int64),
            source=np.array([s for node in nodes for s in node.sources], dtype=np.int64),
            factor=factors, offset=offsets, converted=(factors != 1.0) | (offsets != 0.0),
            feedthrough_schedule=np.array(feedthrough_schedule, dtype=np.int64),
            direct=np.array([d[:2] for d in direct], dtype=np.int64).reshape(-1, 2),
            change=np.array([d[2] for d in direct], dtype=float),
            inverse=np.array(master.weights),
            degree=int(master.degree), sequential=isinstance(master, GaussSeidel),
        )
        link, unit = np.zeros(n), np.zeros(u)
        self._now = LoopState(
            signals=np.zeros(len(master.signals)), present=link, before=link.copy(), earlier=link.copy(), reached=link.copy(),
            known=link.copy(), inputs=np.zeros(3 * n), samples=unit.astype(np.int64), spacing=np.zeros((u, 2)),
            interpolates=unit.astype(np.bool_), no_return=unit.astype(np.int32), taken=unit.astype(np.int64),
        )
        run_steps(self._plan, self._now, np.empty(0), 0.0, RUNAWAY, halt, np.empty((0, self._now.signals.size)))  # compiles it
        self._slices = [slice(a, b) for a, b in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]

    @property
    def possible(self) -> bool:
        """Whether the next steps may be taken so: no input is altered by a fault."""
        return all(node.alter is None for node in self._master.nodes)

    def run(self, times: list[float], h: float) -> tuple[np.ndarray, StepFailed | None]:
        """Steps from each of `times`, s, of length h: the signals behind every step that was completed, and why one was not."""
        self._load()
        rows = np.empty((len(times), self._now.signals.size))
        done, unit, status = run_steps(self._plan, self._now, np.array(times), h, RUNAWAY, self._halt, rows)
        self._store(done)
        failure = None
        t = times[min(done, len(times) - 1)]
        for fmu, steps in zip(self._units, self._now.taken.tolist(), strict=True):
            fmu.stepped(steps, t)
        if unit >= 0:
            try:
                self._units[unit].stopped(status, t)
            except StepFailed as error:
                failure = error
        if unit == -2:
            failure = beyond(self._master, times[done - 1] + h)
            done -= failure is not None
        return rows[:done], failure

    def _load(self) -> None:
        now = self._now
        now.taken[:] = 0
        now.signals[:] = self._master.signals
        for k, (node, at) in enumerate(zip(self._master.nodes, self._slices, strict=True)):
            past = node.history
            now.samples[k], now.spacing[k] = past.count, (past.h1, past.h2)
            now.no_return[k] = not self._units[k].keeps_states()
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


def compiled_loop_for(master: Master, halt: np.ndarray) -> CompiledLoop | None:
    """The stretches of a master whose units are FMUs; None where one of them needs Python. `halt`: as in `batch_loop_for`."""
    if not COMPILED:
        return None
    units = [node.unit for node in master.nodes if isinstance(node.unit, Fmi2CoSimulation)]
    tables = [table for unit in units if (table := unit.call_table()) is not None]
    return CompiledLoop(master, units, tables, halt) if len(tables) == len(master.nodes) else None
