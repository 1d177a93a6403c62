"""Gauss-Seidel: units step one after the other, later ones towards what earlier ones have reached."""

from __future__ import annotations

from ..coupling import Link
from .master import Acts, Master
from .records import TURN


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

    batched = True

    @property
    def extrapolated_links(self) -> list[int]:
        """Links from later units."""
        ranks = {node.unit.name: i for i, node in enumerate(self.nodes)}
        return [sum(ranks[link.source[0]] > i for link in node.links) for i, node in enumerate(self.nodes)]

    def usual_order(self, scene: tuple[str, ...]) -> tuple[str, ...]:
        """Each group of the graph behind those that feed it."""
        return self.coupling.order()

    def sorted_links(self, links: list[Link], order: tuple[str, ...]) -> list[Link]:
        """Links from later units first, so that both groups are contiguous."""
        return sorted(links, key=lambda link: order.index(link.source[0]) < order.index(link.target[0]))

    def acts(self) -> Acts:
        """Each unit steps when those before it have been read."""
        return [(TURN, self.nodes)]
