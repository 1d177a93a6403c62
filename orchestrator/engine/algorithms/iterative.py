"""Iterative: macro steps of units that feed one another are repeated until the inputs fit the outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from ....components.core.errors import StepFailed
from ...settings import IterationSettings
from ...units import Simulator
from ..coupling import Coupling, Endpoint
from ..coupling.graph import groups, smooth
from .acceleration import Acceleration, Memory, accelerated
from .groups import StronglyConnectedGroup, best_cut
from .master import Acts, Master, Saved


@dataclass
class SavedIterative(Saved):
    """With what the methods have learned of how the circles answer, and what was missed in the steps that count."""

    memories: list[Memory]
    missed: tuple[int, float]  # steps, the largest


class Iterative(Master):
    """Units step in circles: a macro step is repeated until what each got at its end is what the others gave.

    Inputs are interpolated through their values at the end of the step; held (degree 0), they have that value all along.
    A unit in no circle steps once, after those that feed it. A circle is cut where the fewest signals are; inside it units
    step one after the other, and at the same time where none feeds the other, so that only the signals at the cut are
    unknown. An algebraic loop inside a circle is solved with the rest.

    Order of accuracy: degree + 1, as without iteration. Stability: force-force coupling is stable for any step with held
    and for w H < √12 with linear inputs (w² = contact stiffness / reduced mass), and limited about as without iteration with
    quadratic ones. With motion on a side, held inputs fail for stiff contacts; undamped, quadratic ones always grow slowly.
    Convergence: the plain fixed point leaves H² k/(6 m) + H d/(2 m) of an error (linear inputs, contact k, d on the reduced
    mass m) and needs it below 1; quasi-Newton and Newton have no such limit, and relaxation none for one signal at the cut.
    Needs of a unit in a circle: to save and restore its state; polynomial inputs up to the degree, or it gets the mean.
    """

    def __init__(
        self,
        units: Mapping[str, Simulator],
        coupling: Coupling,
        watched: Sequence[Endpoint] = (),
        *,
        iteration: IterationSettings | None = None,
        **settings: Any,
    ):
        self.iteration = iteration or IterationSettings()
        super().__init__(units, coupling, watched, **settings)
        self.iterations = self.restores = self.unconverged = 0
        self.worst = 0.0  # largest miss that was left, relative

    solves_loops = False  # they are solved with the rest of their circles

    @property
    def extrapolated_links(self) -> list[int]:
        """None: polynomials of inputs end at what others give, or are guessed to give."""
        return [0] * len(self.nodes)

    def own_acts(self) -> dict[str, Acts]:
        """A sweep of each circle, and of what stands between two of them."""
        coupling, links = self.coupling, smooth(self.coupling.interfaces, self.coupling.links)
        runs: list[list[str]] = [[]]  # every circle, and between two of them all units in none
        for group in groups(coupling.interfaces, links):
            if len(group) > 1:
                runs += [[*best_cut(group, links)], []]
            else:
                runs[-1] += group
        chains = [
            StronglyConnectedGroup(f"sweep {' '.join(names)}", [self.node_of[name] for name in names], self, coupling.interfaces)
            for names in runs
            if names
        ]
        self._chains = [(chain, accelerated(self.iteration.method, chain.derivatives)) for chain in chains]
        return {chain.name: chain.acts() for chain in chains}

    def advance(self, t: float, h: float) -> None:
        for chain, method in self._chains:
            if chain.cut:
                self._iterate(chain, method, t, h)
            else:
                chain.sweep(t, h)

    def _iterate(self, chain: StronglyConnectedGroup, method: Acceleration, t: float, h: float) -> None:
        """Repeat the step of a circle until little is missed; says so where that does not come about."""

        def respond(guess: np.ndarray) -> np.ndarray:
            self.restores += 1
            chain.restore()
            return chain.respond(guess, t, h)

        chain.save()
        guess = chain.predicted(h)
        response = chain.respond(guess, t, h)
        method.begin(chain.sizes(guess))
        missed, worst = chain.missed(guess, response)
        count, given = 1, self.iteration
        while given.tolerance < missed < inf and count < given.max_iterations:
            try:
                guess = method.following(guess, response - guess, respond)
            except np.linalg.LinAlgError:
                raise StepFailed(
                    worst[0],
                    t,
                    f"no value of {worst[1]} solves the algebraic loop: its output equals its input",
                    "Give one of its units a state or a smaller gain",
                ) from None
            response = respond(guess)
            missed, worst = chain.missed(guess, response)
            count += 1
        self.iterations += count
        if missed > given.tolerance:
            self._not_converged(missed, worst, count, t)

    def _not_converged(self, missed: float, worst: Endpoint, count: int, t: float) -> None:
        if self.iteration.not_converged == "stop" or missed == inf:
            raise StepFailed(
                worst[0],
                t,
                f"the step did not converge in {count} iterations; {worst[1]} still misses by "
                f"{missed:.2g} of its size, where {self.iteration.tolerance:g} is allowed",
                "Reduce the macro step, or take another master.iteration.method",
            )
        self.unconverged += 1
        self.worst = max(self.worst, missed)

    def counters(self) -> dict[str, Any]:
        more: dict[str, float] = {"iterations": self.iterations, "restores": self.restores}
        if self.iteration.not_converged == "warn":
            more |= {"unconverged_steps": self.unconverged, "worst_miss": self.worst}
        return super().counters() | more

    def warnings(self) -> list[str]:
        texts = super().warnings()
        if not self.unconverged:
            return texts
        return [
            *texts,
            f"{self.unconverged} of {self.steps} steps did not converge in {self.iteration.max_iterations} iterations; the "
            f"largest miss of a coupled signal was {self.worst:.2g} of its size. Reduce master.step, or take another "
            "master.iteration.method",
        ]

    def save(self, reuse: Saved | None = None) -> SavedIterative:
        saved = super().save(reuse)
        memories = [method.memory for _, method in self._chains]
        return SavedIterative(**vars(saved), memories=memories, missed=(self.unconverged, self.worst))

    def restore(self, saved: Saved) -> None:
        super().restore(saved)
        if isinstance(saved, SavedIterative):
            self._take_memories(saved.memories, saved.missed)

    def state(self) -> dict[str, Any]:
        memories = [method.memory for _, method in self._chains]
        return super().state() | {"memories": memories, "missed": (self.unconverged, self.worst)}

    def take(self, state: Mapping[str, Any]) -> None:
        super().take(state)
        self._take_memories(state["memories"], state["missed"])

    def _take_memories(self, memories: Sequence[Memory], missed: tuple[int, float]) -> None:
        self.unconverged, self.worst = missed
        for (_, method), memory in zip(self._chains, memories, strict=True):
            method.memory = memory
