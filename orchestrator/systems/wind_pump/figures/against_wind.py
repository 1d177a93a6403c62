"""What the pump does at which wind: rising and falling where the wind can be followed, else means by bins of wind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Lines, Panel, Series
from .shown import COEFFICIENTS, Shown

BIN = 0.5  # m/s, as IEC 61400-12-1 has it for power curves
LEAST = 3  # means in a bin that is drawn


def _quantities(s: Shown) -> list[tuple[str, np.ndarray]]:
    """(label of the axis, values (n,)) of what is drawn against the wind."""
    quantities = [
        ("turbine speed, rad/s", s.signals.get("turbine_speed")),
        ("pump speed, rad/s", s.signals["pump_speed"]),
        ("pump speed over turbine speed, 1", s.ratio),
        ("power coefficient Cp, 1", s.signals.get("power_coefficient")),
        ("power at the turbine, W", s.powers.get("aerodynamic")),
        ("power into the water, W", s.powers.get("hydraulic")),
    ]
    return [(label, v) for label, v in quantities if v is not None]


def _panels(shown: Sequence[Shown], series_of, lines: tuple[Lines, ...] = ()) -> tuple[Panel, ...]:
    labels = list(dict.fromkeys(label for s in shown for label, _ in _quantities(s)))
    panels = []
    for label in labels:
        series = [x for s in shown for name, values in _quantities(s) if name == label for x in series_of(s, values)]
        panels.append(Panel(label, tuple(series), lines=lines if label.startswith("pump speed, ") else (), x_label="wind, m/s",
                            y_range=COEFFICIENTS if "Cp" in label else None))  # fmt: skip
    return tuple(panels)


def branches_chart(shown: Sequence[Shown], followed: Sequence[tuple[str, slice]], start: int = 0) -> Chart:
    """Every quantity over the wind while it rises and while it falls; the winds at which pumps start and stop are lines."""

    def lines_of(s: Shown, values: np.ndarray) -> list[Series]:
        wind, values = s.wind[start:], values[start:]  # type: ignore[index]
        branches: dict[str, tuple[list[np.ndarray], list[np.ndarray]]] = {}
        for way, part in followed:
            x, y = branches.setdefault(way, ([], []))
            x += [wind[part], np.array([np.nan])]
            y += [values[part], np.array([np.nan])]
        return [Series(f"{s.who}wind {way}", np.concatenate(x), np.concatenate(y)) for way, (x, y) in branches.items()]

    marks: dict[str, list[tuple[float, str]]] = {}
    for s in shown:
        for word, _, wind in s.marks:
            if wind is not None:
                marks.setdefault(f"{s.who}pump {word}", []).append((wind, f"{wind:.2f}"))
    lines = tuple(Lines(name, tuple(at)) for name, at in marks.items())
    both = {word for s in shown for word, _, _ in s.marks} == {"starts", "stops"}
    why = "the pump starts at a higher wind than it stops at: hysteresis" if both else "inertia is behind the wind"
    text = shown[0].averaged
    text += f" Where the branches part, {why}." if len({way for way, _ in followed}) == 2 else ""
    return Chart("Against the wind", "", _panels(shown, lines_of, lines), text.strip(), columns=2, height=260)


def bins_chart(shown: Sequence[Shown], start: int = 0) -> Chart | None:
    """Means over `average` s as dots and the means of bins of 0.5 m/s as a line; None without means or with a steady wind."""
    first = shown[0]
    time, width = first.chain.time[start:], first.average
    if width <= 0.0 or first.wind is None or time[-1] - time[0] < LEAST * width:
        return None
    at = np.arange(time[0] + 0.5 * width, time[-1] - 0.5 * width, width)
    if np.ptp(np.interp(at, time, first.wind[start:])) < BIN:
        return None

    def series_of(s: Shown, values: np.ndarray) -> list[Series]:
        wind, mean = (np.interp(at, time, v[start:]) for v in (s.wind, values))  # type: ignore[index]
        number = np.floor(wind / BIN).astype(int)
        known = [(k, mean[(number == k) & np.isfinite(mean)]) for k in np.unique(number)]
        full = [(k, v) for k, v in known if v.size >= LEAST]
        middle, mean_of = [(k + 0.5) * BIN for k, _ in full], [float(v.mean()) for _, v in full]
        dots = Series(f"{s.who}means over {width:g} s", wind, mean, "dots")
        return [dots, Series(f"{s.who}bins of {BIN:g} m/s", middle, mean_of)]

    text = (f"Dots: means over {width:g} s, one after the other. Line: their means in bins of wind. The spread at one wind is "
            "what inertia and the way the wind came leave of the past.")  # fmt: skip
    return Chart("Against the wind", "", _panels(shown, series_of), text, columns=2, height=260)
