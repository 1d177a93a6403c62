"""Gauss-Seidel: units step one after the other, later ones towards what earlier ones have reached."""

from __future__ import annotations

from collections.abc import Mapping

from ...settings import MasterSettings
from ..coupling import Coupling, Link
from .algorithm import Algorithm
from .network import Network
from .records import READ, START


class GaussSeidel(Algorithm):
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

    def __init__(self, network: Network, settings: MasterSettings):
        self.acts = [(act, [node]) for node in network.nodes for act in (START, READ)]

    @staticmethod
    def order(coupling: Coupling, units: tuple[str, ...]) -> tuple[str, ...]:
        """Each group of the graph behind those that feed it."""
        return coupling.order()

    @staticmethod
    def extrapolated(link: Link, ranks: Mapping[str, int], coupling: Coupling) -> bool:
        """From later units."""
        return ranks[link.source[0]] >= ranks[link.target[0]]
