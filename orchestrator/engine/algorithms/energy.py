"""The energy account: what a co-simulation creates or loses at its power bonds, as diagnosis and correction.

Both units of a bond integrate the power of their own output and of the input they were given in place of the other's output.
The difference is energy that the coupling has created: Sadjina, Kyllingstad, Skjong, Pedersen, "Energy conservation and
power bonds in co-simulations" (Engineering with Computers 33, 2017, arXiv 1602.06434); the correction: Sadjina, Pedersen,
"Energy conservation and coupling error reduction in non-iterative co-simulations" (Engineering with Computers 36, 2020).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from ....components.core.kernels import COMPILED
from ..coupling import Coupling
from .energy_steps import POINTS, enter_steps
from .machine import Steps, singly
from .master import NONE, Master, Saved

if COMPILED:
    from ....components.core.kept_kernels import call

_enter = partial(call, enter_steps) if COMPILED else enter_steps


@dataclass(frozen=True)
class BondEnergy:
    """What went through a bond in either direction, and what the coupling made of nothing on the way, J."""

    exchanged: float
    created: float


class Sums(NamedTuple):
    """Of all steps up to an instant: their time, s, and by bond the energies created and exchanged, J."""

    elapsed: float
    created: np.ndarray
    exchanged: np.ndarray


STATE = "times", "samples", "jumped", "integrals", "created", "exchanged", "elapsed"  # attributes that the next entries depend on


class EnergyAccount:
    """A master whose steps are audited at the bonds.

    The outputs over a step are taken as polynomials one degree above those of the inputs, through the last samples: the
    energy that a step creates, H^(degree + 2), is then right in its leading term, also for uneven steps. Where outputs jump at the end
    of a step, the older samples jump with them.

    `correction`: what the integral of an input over time has missed is returned with the next step (NEPCE), so that the
    impulse a force gives is right but for the last step. Both inputs of a bond are corrected; where the bonds take all that a
    unit feels, the order of accuracy rises by one.

    It wraps the master, for an observer sees instants that are reached for good: step control tries steps and halves of them, takes
    them back with their entries, and keeps two halves for one instant; and what the account owes acts on the very next of them.
    """

    def __init__(self, master: Master, coupling: Coupling, *, correction: bool):
        self.master, self.bonds = master, coupling.bonds
        ends = [(end, link) for bond in self.bonds for end, link in zip(bond.given, bond.links, strict=True)]
        self._places = np.array([master.positions[end] for end, _ in ends])
        self._factors = np.array([link.factor for _, link in ends])
        self._degrees = np.array([coupling.interfaces[link.target[0]].input_degree for _, link in ends])
        self._watts = np.array([bond.watts for bond in self.bonds])
        nominals = np.array([coupling.interfaces[u].outputs[n].nominal for (u, n), _ in ends])
        self.nominal = np.abs(self._watts * nominals[::2] * nominals[1::2])  # W
        self._kept = master.network.degree + 2
        self.correction = correction
        self.times, self.samples = np.zeros(0), np.zeros((0, len(ends)))  # s, the newest at 0; newest first
        self.jumped = np.zeros((0, len(ends)))  # of the samples, where their steps ended
        self._work = np.zeros((2, len(ends), len(POINTS)))
        self.integrals = np.zeros(len(ends))  # of what each input has been given beyond the output it stands for
        self.created, self.exchanged = np.zeros(len(self.bonds)), np.zeros(len(self.bonds))  # J, in the whole run
        self.elapsed = 0.0  # s, of all steps so far
        self._course = np.zeros((1, 1 + len(ends)))  # sums before and behind each of the steps that were entered together last

    def initialize(self, t: float) -> None:
        """As `Master.initialize`."""
        self.master.initialize(t)
        self.restart()

    def restart(self) -> None:
        """After a jump: the past of the outputs tells nothing any more."""
        self.times, self.samples = np.zeros(1), self.master.signals[None, self._places]
        self.jumped = np.zeros(self.samples.shape)

    def step(self, t: float, h: float) -> None:
        """One macro step from t to t + h, and its entry in the account."""
        self.master.step(t, h)
        self.enter(h, self.master.signals[None], self.master.machine.given()[None])

    def take_steps(self, times: np.ndarray, h: float, sampled: np.ndarray = NONE, saved: Sequence[int] = ()) -> Steps:
        """As `Master.take_steps`, with their entries in the account."""
        if self.correction or not self.master.in_batches:
            return singly(self, self.master, times, h)
        steps = self.master.take_steps(times, h, sampled, saved)
        if len(steps.rows):
            self.enter(h, steps.rows, steps.given)
        return steps

    def enter(self, h: float, signals: np.ndarray, given: np.ndarray) -> None:
        """Enter n equal steps: the master's signals behind each, (n, S), and what each input was given, (n, inputs, 5)."""
        n, kept, first = len(signals), len(self.samples), 0
        outputs = np.empty((kept + n, self._places.size))  # oldest first
        outputs[:kept], outputs[kept:] = self.samples[::-1], signals[:, self._places]
        jumped = np.concatenate((self.jumped[::-1], given[:, :, 4] / self._factors))
        self._course = course = np.empty((n + 1, 1 + 2 * len(self.bonds)))
        course[0] = np.concatenate(((self.elapsed,), self.created, self.exchanged))
        self.integrals = self.integrals.copy()
        while first < n:
            times = np.concatenate(((0.0,), (self.times - h)[: self._kept - 1]))
            even = times.tobytes() == self.times.tobytes()  # and will be from here on
            last = n if even else first + 1
            _enter(
                float(h),
                _basis(times.tobytes()),
                outputs[kept + first + 1 - times.size :],
                jumped[kept + first + 1 - times.size :],
                given[first:last],
                self._degrees,
                self._factors,
                self._watts,
                self._work,
                self.integrals,
                course[first : last + 1],
            )
            self.times, first = times, last
        self.samples, self.jumped = outputs[: -self.times.size - 1 : -1], jumped[: -self.times.size - 1 : -1]
        self.elapsed, self.created, self.exchanged = self.sums_behind(n - 1)
        if self.correction:
            self._owe()

    def _owe(self) -> None:
        self.master.owe(-self._factors * self.integrals)

    @property
    def in_batches(self) -> bool:
        """Whether many macro steps are one call."""
        return self.master.in_batches and not self.correction

    @property
    def sums(self) -> Sums:
        """Of all steps so far."""
        return Sums(self.elapsed, self.created, self.exchanged)

    def sums_behind(self, step: int) -> Sums:
        """The sums behind one of the steps that were entered together last, counted from 0."""
        elapsed, powers = float(self._course[step + 1, 0]), self._course[step + 1, 1:].reshape(2, -1)
        return Sums(elapsed, powers[0], powers[1])

    def save(self, reuse: Saved | None = None) -> Saved:
        """As `Master.save`, with the account."""
        saved = self.master.save(reuse)
        saved.account = self._entries()
        return saved

    def restore(self, saved: Saved) -> None:
        """As `Master.restore`, with the account, unless the master alone was saved."""
        self.master.restore(saved)
        if saved.account is not None:
            self._set_entries(saved.account)

    def _entries(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in STATE}

    def _set_entries(self, entries: Mapping[str, Any]) -> None:
        for name in STATE:
            setattr(self, name, entries[name])
        if self.correction:
            self._owe()

    def report(self) -> dict[str, BondEnergy]:
        """Energies by bond."""
        return {
            bond.text: BondEnergy(exchanged, created)
            for bond, exchanged, created in zip(self.bonds, self.exchanged.tolist(), self.created.tolist(), strict=True)
        }


@lru_cache(maxsize=64)
def _basis(samples: bytes) -> np.ndarray:
    """Lagrange's polynomials for samples at times (k,), s, whose bytes are given, at `POINTS` of the last step: (3, k)."""
    times = np.frombuffer(samples)
    at, others = times[1] * (1.0 - POINTS), ~np.eye(times.size, dtype=bool)
    return np.stack(
        [np.prod((at[:, None] - times[o]) / (time - times[o]), axis=1) for time, o in zip(times, others, strict=True)], axis=1
    )
