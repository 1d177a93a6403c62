"""Geometry and kinematics of a ball bearing with grooved races."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import BadInput
from ..core.kernels import kernel
from .hertz import PointContact, exact_ellipse, fitted_ellipse, in_series, point_contact, solved_ellipse

INNER, OUTER = -1.0, 1.0  # sign of a race's curvature along its circumference


@kernel
def diameter_share(ball_diameter, pitch_diameter, contact_angle):
    """gamma, d cos(alpha) / dm."""
    return ball_diameter * math.cos(contact_angle) / pitch_diameter


@kernel
def cage_turn(gamma):
    """Speed of the balls round the shaft over that of the inner ring, the outer one at rest."""
    return 0.5 * (1.0 - gamma)


@kernel
def spin_turn(ball_diameter, pitch_diameter, gamma):
    """Speed of a ball about its own axis, seen from the cage, over that of the inner ring, the outer one at rest."""
    return 0.5 * pitch_diameter / ball_diameter * (1.0 - gamma**2)


@kernel
def relative_radii(race, conformity, ball_diameter, gamma):
    """Relative radii (Rx, Ry) of ball and race, m; race: `INNER` or `OUTER`."""
    return 0.5 * ball_diameter * (1.0 + race * gamma), conformity * ball_diameter / (2.0 * conformity - 1.0)


@kernel
def grooved_contact(radius_x, radius_y, modulus, fitted):
    """Hertzian contact of relative radii in m and E' in Pa, Ry/Rx in [1, LARGEST_RATIO]; fitted: by Brewe and Hamrock's fit."""
    ratio = radius_y / radius_x
    ellipse = fitted_ellipse(ratio) if fitted else solved_ellipse(ratio)
    return PointContact(1.0 / (1.0 / radius_x + 1.0 / radius_y), modulus, ellipse)


@dataclass(frozen=True)
class BallGeometry:
    """Lengths in m, angle in rad. Clearances are not part of it: each model says whether its own is diametral or radial."""

    balls: int
    ball_diameter: float
    pitch_diameter: float
    inner_conformity: float = 0.52  # groove radius over ball diameter
    outer_conformity: float = 0.52
    contact_angle: float = 0.0

    def __post_init__(self) -> None:
        if self.balls < 1:
            raise BadInput("ball bearing", f"{self.balls} balls", "at least one")
        if not 0.0 < self.ball_diameter < self.pitch_diameter:
            raise BadInput(
                "ball bearing",
                f"balls of {self.ball_diameter:g} m on a pitch diameter of {self.pitch_diameter:g} m",
                "balls smaller than the pitch diameter",
            )
        if min(self.inner_conformity, self.outer_conformity) <= 0.5:
            actual = f"groove radii of {self.inner_conformity:g} and {self.outer_conformity:g} ball diameters"
            raise BadInput("ball bearing", actual, "more than half a ball diameter")

    @property
    def gamma(self) -> float:
        """d cos(alpha) / dm."""
        return diameter_share(self.ball_diameter, self.pitch_diameter, self.contact_angle)

    @property
    def cage_ratio(self) -> float:
        """Speed of the balls round the shaft over that of the inner ring, the outer one at rest."""
        return cage_turn(self.gamma)

    @property
    def spin_ratio(self) -> float:
        """Speed of a ball about its own axis, seen from the cage, over that of the inner ring, the outer one at rest."""
        return spin_turn(self.ball_diameter, self.pitch_diameter, self.gamma)

    def radii(self, race: str) -> tuple[float, float]:
        """Relative radii (Rx, Ry) of ball and race, m; race: "inner" or "outer"."""
        sign, conformity = (INNER, self.inner_conformity) if race == "inner" else (OUTER, self.outer_conformity)
        return relative_radii(sign, conformity, self.ball_diameter, self.gamma)

    def curvature(self, race: str) -> tuple[float, float]:
        """Curvature sum, 1/m, and curvature difference F(rho) of ball and race."""
        across, along = (1.0 / r for r in self.radii(race))
        return across + along, (across - along) / (across + along)

    def contact(self, race: str, modulus: float, ellipse=exact_ellipse) -> PointContact:
        """Hertzian contact of ball and race for E' in Pa."""
        return point_contact(*self.radii(race), modulus, ellipse)

    def stiffness(self, modulus: float, ellipse=exact_ellipse) -> float:
        """Stiffness of a ball between both races, N/m^1.5."""
        return in_series(*(self.contact(race, modulus, ellipse).stiffness for race in ("inner", "outer")))

    def defect_frequencies(self, rotation: float, cage: float | None = None) -> dict[str, float]:
        """Characteristic frequencies in the unit of `rotation`, that of the inner ring with the outer one at rest.

        cage: the speed of a cage that slips, while the balls roll on the outer race; None: it does not slip.
        cage: of the ball set (FTF); outer, inner: of a ball over a defect of that race (BPFO, BPFI); ball: of a ball's spin
        (BSF), whose defect meets a race twice a turn.
        """
        spin = self.spin_ratio * rotation if cage is None else self.spin_ratio / self.cage_ratio * cage
        cage = self.cage_ratio * rotation if cage is None else cage
        return {"cage": cage, "outer": self.balls * cage, "inner": self.balls * (rotation - cage), "ball": spin}
