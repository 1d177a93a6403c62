"""Iterative: macro steps of units that feed one another are repeated until the inputs fit the outputs."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from ....components.core.errors import StepFailed
from ...settings import IterationSettings, MasterSettings
from ..coupling import Coupling, Endpoint, Link
from .algorithm import Algorithm
from .groups import StronglyConnectedGroup, groups_of
from .machine import Machine
from .network import Network
from .solve import QuasiNewton


class Iterative(Algorithm):
    """Units step in circles: a macro step is repeated until what each got at its end is what the others gave.

    Inputs are interpolated through their values at the end of the step; held (degree 0), they have that value all along.
    A unit in no circle steps once, after those that feed it. A circle is cut where the fewest signals are; inside it units
    step one after the other, and at the same time where none feeds the other, so that only the signals at the cut are
    unknown. An algebraic loop inside a circle is solved with the rest.

    Order of accuracy: degree + 1, as without iteration. Stability: force-force coupling is stable for any step with held
    and for w H < √12 with linear inputs (w² = contact stiffness / reduced mass), and limited about as without iteration with
    quadratic ones. With motion on a side, held inputs fail for stiff contacts; undamped, quadratic ones always grow slowly.
    Convergence: the plain fixed point leaves H² k/(6 m) + H d/(2 m) of an error (linear inputs, contact k, d on the reduced
    mass m) and needs it below 1; the quasi-Newton method has no such limit.
    Needs of a unit in a circle: to save and restore its state; polynomial inputs up to the degree, or it gets the mean.
    """

    solves_loops = True  # with the rest of their circles

    def __init__(self, network: Network, settings: MasterSettings):
        self.iteration = settings.iteration or IterationSettings()
        self._groups = [(group, QuasiNewton()) for group in groups_of(network)]
        self.iterations = self.restores = self.unconverged = 0
        self.worst = 0.0  # largest miss that was left, relative

    @staticmethod
    def extrapolated(link: Link, ranks: Mapping[str, int], coupling: Coupling) -> bool:
        """None: polynomials of inputs end at what others give, or are guessed to give."""
        return False

    def advance(self, machine: Machine, t: float, h: float) -> None:
        for group, method in self._groups:
            if group.cut:
                self._iterate(group, method, machine, t, h)
            else:
                group.sweep(machine, t, h)

    def _iterate(self, group: StronglyConnectedGroup, method: QuasiNewton, machine: Machine, t: float, h: float) -> None:
        """Repeat the step of a circle until little is missed; says so where that does not come about."""

        group.save()
        guess = group.predicted(machine, h)
        response = group.respond(guess, machine, t, h)
        method.begin(group.sizes(guess))
        missed, worst = group.missed(guess, response)
        count, given = 1, self.iteration
        while given.tolerance < missed < inf and count < given.max_iterations:
            guess = method.following(guess, response - guess)
            group.restore()
            response = group.respond(guess, machine, t, h)
            missed, worst = group.missed(guess, response)
            count += 1
        self.restores += count - 1
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
                "Reduce the macro step",
            )
        self.unconverged += 1
        self.worst = max(self.worst, missed)

    def counters(self) -> dict[str, Any]:
        more: dict[str, float] = {"iterations": self.iterations, "restores": self.restores}
        if self.iteration.not_converged == "warn":
            more |= {"unconverged_steps": self.unconverged, "worst_miss": self.worst}
        return more

    def warnings(self, steps: int) -> list[str]:
        if not self.unconverged:
            return []
        return [
            f"{self.unconverged} of {steps} steps did not converge in {self.iteration.max_iterations} iterations; the "
            f"largest miss of a coupled signal was {self.worst:.2g} of its size. Reduce master.step"
        ]

    @property
    def memory(self) -> Any:
        """What the methods have learned of how the circles answer, and what was missed in the steps that count."""
        return [[method.memory for _, method in self._groups], self.unconverged, self.worst]

    @memory.setter
    def memory(self, memory: Any) -> None:
        learned, self.unconverged, self.worst = memory
        for (_, method), of_method in zip(self._groups, learned, strict=True):
            method.memory = of_method
