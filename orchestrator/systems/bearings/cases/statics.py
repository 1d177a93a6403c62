"""Static equilibria of deep groove ball bearings: displacements after ISO/TS 16281, and how a load spreads over the balls.

The displacements are held against a commercial program's, the loads against Stribeck's number and Sjövall's integrals.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from .....components.bearings.deep_groove import DeepGrooveBearing
from .....components.bearings.load_zone import load_integrals, stribeck_number
from .....components.bearings.loads import StaticLoads
from .....components.bearings.motion import DISPLACEMENT
from .....components.core.errors import StepFailed
from .....components.core.kernels import DONE, REASONS
from ....harness.validation import Evidence, Runs
from .hertz_textbook import NEWTON_PER_MM

PRESET = "ISO/TS 16281 example"
LOAD, LOAD_RATING = 1000.0, 23.4e3  # N
ISO_CLEARANCES = (0.0, 10e-6)  # m, diametral
RADIAL, AXIAL = np.array([1.0, 0, 0, 0, 0]), np.array([0, 0, 1.0, 0, 0])
BALLS = (6, 7, 8, 9, 12, 16, 32, 64)
EPSILONS = (0.2, 0.5, 0.8, 1.0, 2.5)
SHARED = 100.0  # N; the shares do not depend on it without clearance, and balls of 2 mm bear twice that each
CLEARANCES = np.linspace(-10e-6, 40e-6, 51)  # m, diametral


def at_rest(model: DeepGrooveBearing, forces: np.ndarray, held: Collection[str] = ()) -> StaticLoads:
    """`DeepGrooveBearing.equilibrium`; raises `StepFailed` where there is none within the model's range."""
    loads = model.equilibrium(forces, held)
    if loads.status != DONE:
        raise StepFailed(model.name, model.t, *REASONS[loads.status])
    return loads


def bearing(clearance: float) -> DeepGrooveBearing:
    """The example with a diametral clearance in m, ready for its equilibrium."""
    parameters = {"diametral_clearance": clearance, "rating_life.load_rating": LOAD_RATING}
    model = DeepGrooveBearing(["rating_life"], parameters, preset=PRESET)
    model.initialize(0.0)
    return model


def life(model: DeepGrooveBearing, loads: StaticLoads) -> float:
    """Reference rating life at an equilibrium, 10^6 revolutions."""
    for name, value in zip(DISPLACEMENT, loads.displacement.tolist(), strict=True):
        model.set(name, value)
    model.refresh()
    return float(LOAD_RATING / model["rating_life.equivalent_load"]) ** 3


def displacements(runs: Runs) -> Evidence:
    """Equilibria of the component with their rating lives, and the displacements over the load."""
    tight, loose = (bearing(c) for c in ISO_CLEARANCES)
    radial, both = at_rest(tight, LOAD * RADIAL), at_rest(loose, LOAD * (RADIAL + AXIAL))
    lives = {
        f"{name}.life": life(model, at_rest(model, LOAD * way))
        for model, clearance in ((tight, 0), (loose, 10))
        for name, way in ((f"{clearance}.radial", RADIAL), (f"{clearance}.axial", AXIAL))
    }
    measured = {
        "0.radial": 1e6 * radial.displacement[0],
        "0.axial": 1e6 * at_rest(tight, LOAD * AXIAL).displacement[2],
        "10.radial": 1e6 * at_rest(loose, LOAD * RADIAL).displacement[0],
        "10.axial": 1e6 * at_rest(loose, LOAD * AXIAL).displacement[2],
        "10.both.radial": 1e6 * both.displacement[0],
        "10.both.axial": 1e6 * both.displacement[2],
        "10.both.life": life(loose, both),
        **lives,
        "0.first": radial.ball_loads[0],
        "0.second": radial.ball_loads[1],
        "stiffness": tight.arguments[0].contacts.stiffness / NEWTON_PER_MM,
    }
    loads = np.geomspace(1.0, 5000.0, 60)
    drawn = {
        kind: {
            n: [1e6 * at_rest(m, f * way).displacement[i] for f in loads] for n, m in (("no clearance", tight), ("10 um", loose))
        }
        for kind, way, i in (("radial", RADIAL, 0), ("axial", AXIAL, 2))
    }
    sixteenth = 1e6 * at_rest(tight, LOAD / 16.0 * AXIAL).displacement[2]
    angle = math.degrees(math.acos(1.0 - ISO_CLEARANCES[1] / (2.0 * 0.05 * 11.5e-3)))
    return Evidence(measured, data={"loads": loads, **drawn, "sixteenth": sixteenth, "angle": angle})


def shares(runs: Runs) -> Evidence:
    """Integrals, then the equilibria of bearings with 6 to 64 balls, then one over its clearance."""
    radial, axial = load_integrals(0.5)
    measured = {"many": stribeck_number(), "integral": radial, "axial": axial / radial}
    for epsilon in EPSILONS:
        measured[f"Jr.{epsilon}"], measured[f"Ja.{epsilon}"] = load_integrals(epsilon)
    for n in BALLS:
        measured[f"on.{n}"], measured[f"midway.{n}"] = (_largest(n, first) for first in (0.0, math.pi / n))
    over = {f"{load:g} N": [_largest(9, 0.0, c or 1e-12, load) for c in CLEARANCES] for load in (200.0, 1000.0, 5000.0)}
    return Evidence(measured, data={"rule": _largest(9, 0.0, 15e-6, 1000.0), "clearances": 1e6 * CLEARANCES, "over": over})


def _largest(balls: int, first: float, clearance: float = 0.0, load: float = SHARED) -> float:
    """Z Qmax / Fr of a bearing in equilibrium under a load along x, ball 1 at `first` rad from it."""
    small = {"ball_diameter": 2e-3, "pitch_diameter": 60e-3} if balls != 9 or not clearance else {}
    parameters = {"balls": balls, "first_ball": first, "diametral_clearance": clearance, **small}
    model = DeepGrooveBearing(parameters=parameters)
    model.initialize(0.0)
    return balls * float(at_rest(model, np.array([load, 0, 0, 0, 0]), ("tilt_x", "tilt_y")).ball_loads.max()) / load
