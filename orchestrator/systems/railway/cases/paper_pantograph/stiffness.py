"""The stiffness that statics gives along a span, and what a single harmonic keeps of it."""

from __future__ import annotations

import numpy as np

from ......components.railway.statics import elasticity, stiffness_series
from .....harness.validation import Evidence, Runs
from ..catenary_statics import RIGID, resting_catenary
from .lumped import SPAN, STIFFNESS, SWING

FORCES = (1.0, 200.0)  # N: as good as nothing, and enough to slacken droppers
DROPPER = 9  # harmonic of the droppers' distance of 6.25 to 7 m
HARMONICS = 10


def measure(runs: Runs) -> Evidence:
    """Nothing is simulated: elasticity of the reference wires as strings, under a small and a large force."""
    catenary = resting_catenary("en50318-2002", RIGID, bending=False)
    x = np.arange(0.0, SPAN, 0.25)
    p = catenary.arguments[1]
    k = {f: 1.0 / elasticity(catenary.mesh, SPAN * (p.spans // 2) + x, f) for f in FORCES}
    series = {f: stiffness_series(x, k[f], SPAN, HARMONICS) for f in FORCES}
    small, large = series[FORCES[0]], series[FORCES[1]]
    measured = {
        "mean": small[0],
        "first": float(small[1][0]),
        "second": float(small[1][1]),
        "dropper": float(small[1][DROPPER - 1]),
        "mean.large": large[0],
        "first.large": float(large[1][0]),
    }
    measured = {f"static.{name}": value for name, value in measured.items()}
    one = STIFFNESS * (1.0 + SWING * np.cos(2.0 * np.pi * x / SPAN))
    along = {**{f"statics, {f:g} N": k[f] for f in FORCES}, "one harmonic": one}
    return Evidence(measured, data={"position": x, "stiffness": along})
