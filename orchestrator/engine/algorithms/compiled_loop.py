"""Stretches of macro steps in compiled code, where a scene allows it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, cast

import numpy as np

from ....components.core.errors import StepFailed
from ...units.component import ComponentUnit
from ..coupling import Endpoint
from .compiled import FAILED, run_steps
from .compiled_records import Records, Unit
from .energy import EnergyAccount
from .gauss_seidel import GaussSeidel
from .initial import RUNAWAY
from .jacobi import Jacobi
from .master import Master


class CompiledLoop:
    """Macro steps of a master in compiled code, with the same bits; made by `batch_loop_for`.

    The nodes' histories are the only truth between stretches, so that faults, checkpoints and whatever else looks at or
    changes a master there need not know of this. Of the last stretch: `inputs` (m, 2, L), the inputs in the order of the nodes'
    links behind the steps `looks` (m,), and where extrapolation has taken them; `outputs` (n, W), what `watch` has asked for;
    `kept`, what the master has saved behind each of the steps it was asked to.
    """

    def __init__(self, master: Master, units: Sequence[Unit], halt: np.ndarray, account: EnergyAccount | None = None,
                 trusted: Collection[str] = ()):
        self._master, self._units, self._halt, self._account, self._trusted = master, units, halt, account, trusted
        self._made_for: Any = None  # what the addresses of the units follow from
        self._records = r = Records(master, units)
        following = np.array([master.nodes.index(node) for node in master.feedthrough_schedule], dtype=np.int64)
        self._weights = np.array(master.weights[: len(master.positions)])
        self._bonded, self._watched = np.array(self._places_of_bonds(), dtype=np.int64), np.zeros(0, dtype=np.int64)
        slow = r.slow if self.rates else None
        self._layout = r.units, slow, r.links, r.pasts, following, r.outputs_at, self._weights, self._bonded
        self._fmus = [unit for unit in units if not isinstance(unit, ComponentUnit)]
        self._memory = r.signals, np.zeros(3 * r.links.size) if self._fmus else None, master.sequential
        self._run(np.empty(0), 0.0, np.zeros(0, dtype=np.int64), self._space(0, 0))  # compiles it

    def possible(self, h: float) -> bool:
        """Whether steps of this length may be taken so: their records can be made, and no unit has ended the simulation."""
        return not any(fmu.ended for fmu in self._fmus) and self._records.possible(h)

    @property
    def rates(self) -> bool:
        """Whether units have rates of their own; their last step may be a shorter one, and is not taken so."""
        return self._records.slow.size > 0

    def run(self, times: np.ndarray, h: float, looks: np.ndarray, keep: Sequence[int] = ()
            ) -> tuple[np.ndarray, BaseException | None]:
        """Steps from each of `times`, s, of length h: the signals behind every step that was completed, and why one was not.

        looks: (m,), steps counted from 0 behind which `inputs` are wanted; keep: those behind which the master is saved.
        """
        self.prepare(h)
        self._records.load()
        rows, given, self.inputs, self.outputs = self._space(times.size, looks.size)
        done, self.kept = 0, list[Any]()
        for end in (*(step + 1 for step in keep), times.size):
            seen, first = np.searchsorted(looks, done), done
            of_steps = rows[first:end], given[first:end], self.inputs[seen:], self.outputs[first:end]
            done, unit, status = self._run(times[first:end], h, looks[seen:] - first, of_steps)
            self._records.store(done, h)
            for one, taken, reached in zip(self._units, *self._records.taken(), strict=True):
                one.stepped(taken, reached)
            done += first
            if done < end or unit != -1:
                break
            if end < times.size:
                self.kept.append(self._master.save())
        failure: BaseException | None = None
        if unit >= 0:
            one, t = self._units[unit], float(times[done])
            begin, length = self._records.last_step(unit, t, h)
            try:
                if isinstance(one, ComponentUnit):
                    one.stopped(status // FAILED, begin)
                else:
                    one.stopped(status, begin, length)
                    self._complete(unit, t, h, given[done])
                    rows[done], done = self._master.signals[: self._weights.size], done + 1
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
        """Whether steps can be taken back, behind `prepare`: all units are components whose whole state is known."""
        return all(isinstance(u, ComponentUnit) and (u.name in self._trusted or u.written is not None) for u in self._units)

    def save(self) -> Any:
        """All that the next steps depend on, and counters of the units, which must all be components."""
        units = [unit for unit in self._units if isinstance(unit, ComponentUnit)]
        arrays = [unit.component.counts for unit in units]
        arrays += [array for unit in units if unit.name not in self._trusted for array in unit.written or ()]
        return (self._account or self._master).save(), [(array, array.copy()) for array in arrays]

    def restore(self, saved: Any) -> None:
        """Take back what `save` gave."""
        state, arrays = saved
        (self._account or self._master).restore(state)
        for array, values in arrays:
            array[...] = values

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

    def _run(self, times: np.ndarray, h: float, looks: np.ndarray, space: tuple[np.ndarray, ...]) -> tuple[int, int, int]:
        """What `run_steps` returns; looks and `_space` are those of these steps."""
        return run_steps(*self._layout, self._watched, *self._memory, times, h, RUNAWAY, self._halt, looks, *space)

    def _space(self, n: int, looks: int) -> tuple[np.ndarray, ...]:
        """For n steps: signals, what bonded inputs are given, inputs with their ends behind the looks, watched outputs."""
        return (np.empty((n, self._weights.size)), np.empty((n, self._bonded.size, 4)),
                np.empty((looks, 2, self._records.driven)), np.empty((n, self._watched.size)))

    def _places_of_bonds(self) -> list[int]:
        """Links of the account's inputs."""
        of_unit = {node.unit.name: at.start for node, at in zip(self._master.nodes, self._records.slices, strict=False)}
        return [of_unit[meter.name] + place for meter, place, _ in self._account.inputs] if self._account else []

    def prepare(self, h: float) -> None:
        """Find the addresses of the units for steps of length h, which those of components depend on."""
        needed = h, [unit.starts for unit in self._units if isinstance(unit, ComponentUnit)]
        if needed == self._made_for:
            return
        self._made_for = needed
        self._alive = self._records.address(h)

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
        if master.sequential:
            master.signals[node.place] = node.unit.get()
        master.step(t, h, unit + 1)
        driven = self._records.slices[unit].stop  # links before it were driven by compiled code
        for k, link in enumerate(self._bonded.tolist()):
            meter, place, _ = self._account.inputs[k]  # type: ignore[union-attr]
            record = self._records.links[["value", "slope", "half", "degree"]][link]
            given[k] = record.tolist() if link < driven else meter.given(place)
