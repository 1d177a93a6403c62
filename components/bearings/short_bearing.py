"""Oil film of a short plain bearing in closed form: load, equilibrium eccentricity, stiffness and damping.

The film is so short that oil flows along the shaft alone (Ocvirk), laminar and of one viscosity, with pressure in the half
where the gap narrows (Gümbel). With the gap c (1 - e cos a), a from the line of centres, Reynolds' equation gives the pressure
over the length L; its integral on the journal of radius R is, with B = eta L^3 R / c^2, the turning speed w, the relative
eccentricity e and its rate e', and the line of centres' rate p':

    F_r = -B (e' I_cc + e (p' - w/2) I_sc),   F_t = -B (e' I_sc + e (p' - w/2) I_ss)
    I_cc = pi (1 + 2 e²) / (2 (1 - e²)^(5/2)),  I_ss = pi / (2 (1 - e²)^(3/2)),  I_sc = -2 e / (1 - e²)²

Stiffness and damping are the derivatives of that force. Sources: Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines
(2010), section 5.5.1, for the model; the derivatives are our own. Length over diameter: up to 0.5 the model is usual (unconfirmed).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..core.errors import BadInput

LARGEST = 10.0  # m, of a journal: above the largest of hydroelectric plants (a bound of ours)
THIN = 0.01  # clearance over diameter: usual are 5e-4 to 2e-3 (handbooks), and Reynolds' equation leaves out its curvature
CLOSE = 1e-9  # of the gap, beyond which the journal touches and no load is found


class ShortBearing(NamedTuple):
    """Dimensions in m, viscosity in Pa.s; `clearance` is radial."""

    diameter: float
    length: float
    clearance: float
    viscosity: float


class FilmState(NamedTuple):
    """Equilibrium of the journal, and its K and C, (2, 2) each, in x and y, N/m and N.s/m.

    eccentricity: of the clearance.  attitude: angle from the load to the line of centres in the direction of rotation, rad.
    """

    eccentricity: float
    attitude: float
    stiffness: np.ndarray
    damping: np.ndarray


def film_load(eccentricity: float) -> float:
    """Force of the film over B w / 4 at a relative eccentricity at rest: the reciprocal of the modified Sommerfeld number.

    B w / 4 is D w eta L³ / (8 c²), with the diameter D.
    """
    e = eccentricity
    return e * math.sqrt(16.0 * e**2 + math.pi**2 * (1.0 - e**2)) / (1.0 - e**2) ** 2


def film_state(bearing: ShortBearing, load: tuple[float, float], speed: float) -> FilmState:
    """Equilibrium of the journal under a load on it, N along x and y, at a speed in rad/s, positive from x to y.

    Raises `BadInput` for dimensions of 0 or less, no speed, no load, and a load that the film carries at no eccentricity.
    """
    for name, value in bearing._asdict().items():
        if not value > 0.0:
            raise BadInput("short bearing", f"{name} = {value:g}", "more than 0")
    if bearing.diameter > LARGEST or bearing.clearance > THIN * bearing.diameter:
        sizes = f"a diameter of {bearing.diameter:g} m with a radial clearance of {bearing.clearance:g} m"
        raise BadInput(
            "short bearing", sizes, "a film far thinner than the journal", "Are these mm? Lengths without a unit are m."
        )
    weight = math.hypot(*load)
    if not (speed > 0.0 and 0.0 < weight < math.inf):
        raise BadInput(
            "short bearing",
            f"{weight:g} N at {speed:g} rad/s",
            "a load, and a positive speed",
            "Without a load there is no position, without speed no film; turn x about for the other direction.",
        )
    factor = bearing.viscosity * bearing.length**3 * bearing.diameter / (2.0 * bearing.clearance**2)
    wanted = 4.0 * weight / (factor * speed)
    if wanted > film_load(1.0 - CLOSE):
        raise BadInput("short bearing", f"{weight:g} N at {speed:g} rad/s", "a load that the film carries", "Give more speed.")
    e = float(brentq(lambda value: film_load(value) - wanted, 0.0, 1.0 - CLOSE, xtol=1e-15, rtol=1e-14))
    free = 1.0 - e**2
    along, across = math.pi * (1.0 + 2.0 * e**2) / (2.0 * free**2.5), math.pi / (2.0 * free**1.5)
    mixed = -2.0 * e / free**2
    # rows and columns: along the line of centres, and across it in the direction of rotation; per e, of forces over B w
    radial, tangential = -(e**2) / free**2, 0.25 * math.pi * e / free**1.5
    stiffness = np.array([[2.0 * e * (1.0 + e**2) / free**3, tangential / e], [-0.5 * along, -radial / e]])
    damping = np.array([[along, mixed], [mixed, across]])
    attitude = math.atan2(tangential, -radial)
    angle = math.atan2(load[1], load[0]) + attitude
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    size = factor / bearing.clearance
    return FilmState(e, attitude, turned @ (size * speed * stiffness) @ turned.T, turned @ (size * damping) @ turned.T)
