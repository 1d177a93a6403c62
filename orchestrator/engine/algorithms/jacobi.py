"""Jacobi: all units step from the same instant, with inputs extrapolated from the past."""

from __future__ import annotations

from ...settings import MasterSettings
from .algorithm import Algorithm
from .network import Network
from .records import READ, START


class Jacobi(Algorithm):
    """All units step over the same interval; none sees what another has reached. The order of units does not matter.

    Order of accuracy: degree of the extrapolation + 1, with immediate and with delayed feedthrough alike.
    Stability, a mass m that gets the force of a spring-damper (k, d), exact units, w = k H²/m, z = d H/m: held force,
    immediate: stable for H < min(2 d/k, 2 m/d), never without damping; delayed (the force is one step old): q = w/2 - z must
    keep w + q + q² < 0 and |q| < 1, near H < 2 d/(3 k); linear and quadratic, immediate: the roots of
        λ³ + (2w/3 + 3z/2 - 2) λ² + (1 + 2w/3 - 2z) λ + (z/2 - w/3)
        λ⁴ + (19w/24 + 23z/12 - 2) λ³ + (1 + 17w/24 - 13z/4) λ² + (7z/4 - 19w/24) λ + (7w/24 - 5z/12)
    must not leave the unit circle. A higher degree helps below, and hurts above, half of critical damping.
    Needs of a unit: polynomial inputs up to the degree; one that holds its inputs gets the polynomial's mean.
    """

    def __init__(self, network: Network, settings: MasterSettings):
        # outputs are read when all have begun to step, so that units in processes of their own step at the same time
        self.acts = [(START, network.nodes), (READ, network.nodes)]
