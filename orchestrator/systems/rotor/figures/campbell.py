"""Campbell diagram from frequencies handed in."""

from __future__ import annotations

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..whirl import Whirl
from .speed import RPM, named

KINDS = ((1, "forward whirl"), (-1, "backward whirl"), (0, "neither"))
HERTZ = 0.5 / np.pi  # per rad/s


def campbell_chart(diagram: Whirl, who: str = "") -> Chart:
    """Whirl frequencies over the speed, by direction, with the line on which they equal it and the critical speeds."""
    speed, frequency = RPM * diagram.speed, HERTZ * diagram.frequency
    highest = 2.2 * HERTZ * float(diagram.speed[-1])
    series = []
    for direction, name in KINDS:
        x, y = [], []
        for k in range(frequency.shape[1]):
            here = np.where(_held(diagram.direction[:, k]) == direction, frequency[:, k], np.nan)
            if np.nanmin(np.where(np.isnan(here), np.inf, here)) < highest:
                x += [*speed, np.nan]
                y += [*here, np.nan]
        if x or direction:  # both directions always, so that each keeps its colour
            series.append(Series(name, np.array(x), np.array(y)))
    synchronous = Series("1 × speed", [speed[0], speed[-1]], [speed[0] / 60.0, speed[-1] / 60.0], faint=True)
    panel = Panel("frequency, Hz", (synchronous, *series), lines=named(diagram.critical), x_range=(speed[0], speed[-1]),
                  y_range=(0.0, highest))  # fmt: skip
    criticals = ", ".join(f"{RPM * c:.0f}" for c in diagram.critical)
    text = f"Pale: frequency = speed; unbalance excites what crosses it. Critical speeds: {criticals or 'none in this range'}"
    text += f"{' rpm' if criticals else ''}. {diagram.bearings}"
    return Chart(f"{who}Campbell diagram", "speed, rpm", (panel,), text.strip(), height=420)


def _held(direction: np.ndarray) -> np.ndarray:
    """Directions (k,) with the one at rest, where there is none, taken from the next speed: lines begin at the axis."""
    held = direction.copy()
    if held.size > 1 and held[0] == 0:
        held[0] = held[1]
    return held
