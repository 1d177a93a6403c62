"""Runs of the pantograph under a lumped catenary, and the closed form of a wire without mass.

Under k(x) = k0 (1 + a cos(2 pi x / L)) at the speed v, to first order in a, the contact force P = F_m + P' exp(i w t) has

    P' + Z(w) y' = 0,    P' = k0 y' + a F_m,    w = 2 pi v / L
    Z = -m1 w² + Z_h Z_f / (Z_h + Z_f),    Z_h = k1 + i w c1,    Z_f = k2 - m2 w² + i w c2

so that its standard deviation is (a / sqrt 2) F_m |Z / (k0 + Z)|. m1, m2: head and frame of EN 50318:2002. A spring k_c between
head and wire makes Z / (1 + Z / k_c) of Z; mass and damping of the wire add to k0. Derived for this project.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .....harness.validation import Evidence, Runs, done
from .....run.results import Result
from .....run.run import run
from .....scene.shorter_steps import kept_runs
from .... import load_scene
from ...runs import KMH, at_speed

SPAN = 60.0  # m
STIFFNESS, SWING = 2870.0, 0.38  # N/m, 1: static truth of the reference wires, computed with another string model
HARMONICS = 10
MASSLESS = (0.1, 2.0)  # kg, N.s/m: 0.2 and 0.5 % of k0 at the passing frequency; what is left so that the wire has a state
STEP = 2.5e-4  # s
CONTACT = 50e3  # N/m
LAST_SPANS = 6  # whole spans at the end of a long run
HEAD, FRAME, HEAD_SPRING, FRAME_SPRING, HEAD_DAMPER, FRAME_DAMPER = 7.2, 15.0, 4200.0, 50.0, 10.0, 90.0  # kg, N/m, N.s/m
SPEEDS = (160.0, 200.0, 250.0, 300.0, 350.0)  # km/h
SMALL, MIDDLE = 0.0125, 0.2  # swing of the stiffness: first order, and half-way to the static truth
LONG = 12.0  # s


def impedance(speed: float) -> complex:
    """Z of the pantograph at the span-passing frequency of a speed in km/h, N/m: minus force per height."""
    w = 2.0 * math.pi * speed * KMH / SPAN
    head, frame = complex(HEAD_SPRING, w * HEAD_DAMPER), complex(FRAME_SPRING - FRAME * w * w, w * FRAME_DAMPER)
    return -HEAD * w * w + head * frame / (head + frame)


def relative_deviation(speed: float, whole: bool = False) -> float:
    """Standard deviation of the force over swing times mean, to first order.

    whole: with the contact spring, and with the mass and damping that the wire of the runs has.
    """
    z, wire, w = impedance(speed), complex(STIFFNESS), 2.0 * math.pi * speed * KMH / SPAN
    if whole:
        z /= 1.0 + z / CONTACT
        wire += complex(-MASSLESS[0] * w * w, MASSLESS[1] * w)
    return abs(z / (wire + z)) / math.sqrt(2.0)


@kept_runs
def lumped_run(
    speed: float,
    stiffness: float = STIFFNESS,
    swings: Sequence[float] = (SWING,),
    wire: tuple[float, float] = MASSLESS,
    stop: float | None = None,
) -> Result:
    """A run at a speed in km/h. swings: harmonics of k(x) over its mean, the first one a span long; wire: kg, N.s/m."""
    scene = at_speed(
        load_scene("lumped-catenary"),
        speed,
        {
            "catenary.mean_stiffness": stiffness,
            "catenary.harmonic": [*swings, *[0.0] * (HARMONICS - len(swings))],
            "catenary.mass": wire[0],
            "catenary.damping": wire[1],
            "master.step": STEP,
        },
    )
    return done(run(scene if stop is None else scene.with_changes({"stop_time": stop}), in_process=True))


def last_force(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Position in the span, m, and contact force, N, over the last whole spans of a run."""
    x, force = result["pantograph.contact_position"], result["pantograph.contact_force"]
    end = x[-1] - x[-1] % SPAN
    kept = (x >= end - LAST_SPANS * SPAN) & (x < end)
    return x[kept] % SPAN, force[kept]


def measure(runs: Runs) -> Evidence:
    """Runs with three swings of the stiffness at five speeds."""
    ratio = {(a, v): scatter(a, v) for a in (SMALL, MIDDLE, SWING) for v in SPEEDS}
    measured = {f"order.{v:g}": ratio[SMALL, v] / relative_deviation(v, whole=True) for v in SPEEDS}
    measured |= {f"excess.{a:g}.{v:g}": ratio[a, v] / relative_deviation(v) for a in (MIDDLE, SWING) for v in (250.0, 300.0)}
    # the next order is of a²: what halving the swing leaves of the difference
    near, far = (scatter(a, 250.0) / relative_deviation(250.0) for a in (0.1, 0.2))
    exact = scatter(SMALL, 250.0) / relative_deviation(250.0)
    measured["excess.order"] = (far - exact) / (near - exact)
    x = np.linspace(120.0, 380.0, 131)
    drawn = {
        "speeds": SPEEDS,
        "closed": {"closed form, first order": (x, [relative_deviation(v, whole=True) for v in x])},
        "runs": {f"runs, a = {a:g}": [ratio[a, v] for v in SPEEDS] for a in (SMALL, MIDDLE, SWING)},
    }
    return Evidence(measured, data=drawn)


def scatter(swing: float, speed: float) -> float:
    """Standard deviation of the contact force over swing and mean."""
    _, force = last_force(lumped_run(speed, swings=(swing,), stop=LONG))
    return float(force.std() / (swing * force.mean()))
