"""Gauss-Seidel: units step one after the other, later ones towards what earlier ones have reached."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...units import Unit
from ...units.interface import PortValues
from ..coupling import Coupling, Endpoint, Link
from .master import Master, Node
from .polynomial import History, Terms

ALONE, LED, AHEAD, BOTH = range(4)  # no inputs; led to known values; extrapolated; the late ones extrapolated, the others led


class GaussSeidel(Master):
    """Units step one after the other; inputs from earlier units are interpolated to their new values.

    The order is that of `order`. Where the scene gives none, a unit steps behind those that feed it, and units that feed one
    another in a circle step together in the order of the scene.

    Inputs from later units are extrapolated as in Jacobi. With degree 0 the new value is held over the whole step.
    Order of accuracy: degree + 1. Stability: sequential displacement-displacement coupling with held inputs is neutral
    even without damping; force-displacement coupling with the mass first, held, is limited like Jacobi's delayed form
    where the spring is stiff. It pays to let the unit step first whose extrapolated input is the smoother one: with
    pantograph and catenary that is the catenary, which gets the force.
    Needs of a unit: polynomial inputs up to the degree; one that holds its inputs gets the polynomial's mean.
    """

    sequential = batched = True

    def __init__(self, units: Mapping[str, Unit], coupling: Coupling, watched: Sequence[Endpoint] = (), **settings):
        super().__init__(units, coupling, watched, **settings)
        self._turns = [(node, node.unit, late, _way(node, late)) for node, late in zip(self.nodes, self.late, strict=True)]

    @property
    def late(self) -> list[int]:
        """Links from later units."""
        ranks = {node.unit.name: i for i, node in enumerate(self.nodes)}
        return [sum(ranks[link.source[0]] > i for link in node.links) for i, node in enumerate(self.nodes)]

    def usual_order(self, scene: tuple[str, ...]) -> tuple[str, ...]:
        """Each group of the graph behind those that feed it."""
        return self.coupling.order()

    def sorted_links(self, links: list[Link], order: tuple[str, ...]) -> list[Link]:
        """Links from later units first, so that both groups are contiguous."""
        return sorted(links, key=lambda link: order.index(link.source[0]) < order.index(link.target[0]))

    def step(self, t: float, h: float, done: int = 0) -> None:
        """As in `Steppable`; the first units may have been `done` already."""
        signals = self.signals
        for node, unit, late, way in self._turns[done:] if done else self._turns:
            if way == LED:
                node.interpolate(node.inputs(), h)
            elif way == AHEAD:
                node.drive(node.history.ahead(), h)
            elif way == BOTH:
                node.drive(_joined(node.history, node.inputs(), late, h), h)
            unit.step(t, h)
            signals[node.place] = unit.get()
        self._finish(t, h)


def _way(node: Node, late: int) -> int:
    if not node.sources:
        return ALONE
    if late == 0 and node.follows:
        return LED
    return AHEAD if late == len(node.sources) else BOTH


def _joined(history: History, known: PortValues, late: int, h: float) -> Terms:
    """Extrapolation of the first `late` inputs, interpolation of the others."""
    ahead, towards = history.ahead(), history.towards(known, h)
    n = len(known)
    values, slopes, halves = (history.rows.joined(a, b, late, n) for a, b in zip(ahead, towards, strict=True))
    return values, slopes, halves
