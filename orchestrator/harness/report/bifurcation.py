"""Bifurcation diagrams from arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..charts.chart import Chart, Panel, Series

SHOWN_POINTS = 400  # of one section: more only blacken the picture
EXPONENT = "largest Lyapunov exponent"


def section_panel(
    y_label: str,
    parameter: Sequence[float] | np.ndarray,
    sections: Sequence[np.ndarray],
    exponents: np.ndarray | None = None,
    unit: str = "1/s",
    title: str = "",
) -> Panel:
    """Points of a section, (k,) each, over the values (n,) of a parameter, shaded by the exponents (n,) where there are any."""
    shown = [np.asarray(s, dtype=float).ravel()[-SHOWN_POINTS:] for s in sections]
    counts = [s.size for s in shown]
    x, y = np.repeat(np.asarray(parameter, dtype=float), counts), np.concatenate([np.zeros(0), *shown])
    if exponents is None:
        return Panel(y_label, (Series("section", x, y, "dots"),), title=title)
    points = Series("section", x, y, "dots", shades=np.repeat(exponents, counts), shade_label=f"{EXPONENT}, {unit}")
    return Panel(y_label, (points,), title=title)


def bifurcation_chart(
    title: str,
    x_label: str,
    y_label: str,
    parameter: Sequence[float] | np.ndarray,
    sections: Sequence[np.ndarray],
    exponents: Sequence[float] | np.ndarray,
    unit: str = "1/s",
    text: str = "",
) -> Chart:
    """Points of a section over a parameter, shaded by the largest Lyapunov exponents (n,), and these in a panel below.

    parameter: (n,); labels with their units. An exponent that is NaN is unknown.
    """
    at, values = np.asarray(parameter, dtype=float), np.asarray(exponents, dtype=float)
    order = np.argsort(at, kind="stable")
    curve = Series(EXPONENT, at[order], values[order], "line")
    zero = Series("zero: above it the motion is chaotic", [at.min(), at.max()], [0.0, 0.0], faint=True)
    panels = (section_panel(y_label, at, sections, values, unit), Panel(f"exponent, {unit}", (zero, curve)))
    return Chart(title, x_label, panels, text, height=300)
