"""Bifurcation diagram from arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .chart import Chart, Panel, Series

SHOWN_POINTS = 400  # of one section: more only blacken the picture
EXPONENT = "largest Lyapunov exponent"


def bifurcation_chart(
    title: str,
    x_label: str,
    y_label: str,
    parameter: Sequence[float] | np.ndarray,
    sections: Sequence[np.ndarray],
    exponents: Sequence[float] | np.ndarray | None = None,
    exponent_unit: str = "1/s",
    text: str = "",
) -> Chart:
    """Points of a section, (k,) for each of the values (n,) of a parameter; labels with their units.

    exponents: (n,) largest Lyapunov exponents, shown as the points' colour and in a panel below; NaN where unknown.
    """
    at = np.asarray(parameter, dtype=float)
    shown = [np.asarray(s, dtype=float).ravel()[-SHOWN_POINTS:] for s in sections]
    counts = [s.size for s in shown]
    y = np.concatenate([np.zeros(0), *shown])
    if exponents is None:
        points = Series("section", np.repeat(at, counts), y, "dots")
        return Chart(title, x_label, (Panel(y_label, (points,)),), text, height=400)
    values = np.asarray(exponents, dtype=float)
    label = f"{EXPONENT}, {exponent_unit}"
    points = Series("section", np.repeat(at, counts), y, "dots", shades=np.repeat(values, counts), shade_label=label)
    order = np.argsort(at, kind="stable")
    curve = Series(EXPONENT, at[order], values[order], "line")
    zero = Series("zero: above it the motion is chaotic", [at.min(), at.max()], [0.0, 0.0], faint=True)
    below = Panel(f"exponent, {exponent_unit}", (zero, curve))
    return Chart(title, x_label, (Panel(y_label, (points,)), below), text, height=300)
