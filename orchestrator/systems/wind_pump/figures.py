"""Figures of the wind pumps of a run: speeds, ratio, Cp and power over time and against the wind, starts and stops, water.

Read from [analysis]: average, standstill, pause, transient; see `WindPumpKeys`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Block, Cells
from ...harness.charts.chart import Chart, Lines, Panel, Series, filled
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from ...harness.preferred_units import preferred
from ...run.key_results import after_transient
from . import WindPumpKeys
from .records import Chain, Running, branches, chains, efficiencies, moving_mean, runnings, wind_energy

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

HOUR = 3600.0  # s
LONG = 2.0 * HOUR  # from here on the time is in hours
COEFFICIENTS = (-0.05, 0.6)  # of an axis, up to Betz's limit; a rotor that overruns a dying wind has any negative value
LITRES = 1e3  # per m³
MARKED = 6  # starts and stops in all that are marked; with more of them the marks hide what they mark
BIN = 0.5  # m/s, as IEC 61400-12-1 has it for power curves
FEWEST_MEANS = 3  # means in a bin that is drawn
MOST = 12  # rows of runs of one chain
NAMES = {
    "aerodynamic": "on the rotor",
    "turbine_shaft": "turbine to transmission",
    "pump_shaft": "transmission to pump",
    "hydraulic": "pump to water",
}


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every chain of turbine, transmission and pump whose speeds were recorded; none without one."""
    records = chains(result)
    if not records:
        return []
    keys = result.scene.analysis_as(WindPumpKeys)
    average = keys.average
    shown = [Shown.of(c, average, keys.standstill, keys.pause, f"{c.name}: " if len(records) > 1 else "") for c in records]
    content: list[Block] = [draw_chart(course_chart(shown))]
    wind = records[0].wind
    if wind is not None:
        smooth = moving_mean(result.time, wind, average)
        start = after_transient(result).start
        followed = branches(smooth[start:])
        if followed:
            content.append(draw_chart(branches_chart(shown, followed, start)))
        elif (binned := bins_chart(shown, start)) is not None:
            content.append(draw_chart(binned))
    content.append(runs_table(shown))
    water = water_chart(shown)
    if water is not None:
        content.append(draw_chart(water))
    if any(c.powers for c in records):
        content.append(efficiency_table(result, shown, after_transient(result).start))
    return content


@dataclass(frozen=True)
class Shown:
    """A chain with its moving means.

    who: what stands before the names where there are several chains, such as "fixed: ".
    average, standstill, pause: as in [analysis].
    wind, signals, powers: those of the chain as moving means; the power coefficient is that of the mean powers.
    ratio: of pump speed to turbine speed, NaN where the turbine stands; None without a turbine speed.
    runs: the times in which the pump ran.
    """

    chain: Chain
    who: str
    average: float
    standstill: float
    pause: float
    wind: np.ndarray | None
    signals: Mapping[str, np.ndarray]
    powers: Mapping[str, np.ndarray]
    ratio: np.ndarray | None
    runs: list[Running]

    @classmethod
    def of(cls, chain: Chain, average: float, standstill: float, pause: float, who: str) -> Shown:
        """The chain with means over `average` s."""

        def mean(values: np.ndarray) -> np.ndarray:
            return moving_mean(chain.time, values, average)

        signals = {n: mean(v) for n, v in chain.signals.items()}
        if average and chain.wind is not None and "power_coefficient" in signals:  # mean power over the wind's mean power
            cube = np.maximum(chain.wind, 0.0) ** 3
            below = mean(cube)
            blows = below > 0.0
            above = mean(chain.signals["power_coefficient"] * cube)
            signals["power_coefficient"] = np.where(blows, above / np.where(blows, below, 1.0), np.nan)
        ratio = None
        if "turbine_speed" in signals:
            turning = signals["turbine_speed"] > standstill
            ratio = np.where(turning, signals["pump_speed"] / np.where(turning, signals["turbine_speed"], 1.0), np.nan)
        wind = mean(chain.wind) if chain.wind is not None else None
        return cls(
            chain,
            who,
            average,
            standstill,
            pause,
            wind,
            signals,
            {n: mean(v) for n, v in chain.powers.items()},
            ratio,
            runnings(chain, standstill, pause),
        )

    @property
    def marks(self) -> list[tuple[str, float, float | None]]:
        """("starts" or "stops", time in s, wind in m/s) of every run of the pump that begins or ends in the record."""
        both = [[("starts", r.begin, r.begin_wind), ("stops", r.end, r.end_wind)] for r in self.runs]
        return [(word, time, wind) for pair in both for word, time, wind in pair if time is not None]

    @property
    def averaged(self) -> str:
        """A remark on the means; "" without."""
        return f"Moving means over {self.average:g} s." if self.average else ""


def scale(time: np.ndarray) -> tuple[float, str]:
    """(seconds of a unit, its name) in which a run of this length is drawn."""
    return (HOUR, "h") if time[-1] - time[0] > LONG else (1.0, "s")


def course_chart(shown: Sequence[Shown]) -> Chart:
    """Wind, speeds, ratio, power coefficient and power over time, for all chains in the same panels."""
    seconds, unit = scale(shown[0].chain.time)
    t = shown[0].chain.time / seconds
    events = [(time / seconds, f"{s.who}{word}") for s in shown for word, time, _ in s.marks]
    few = len(events) <= MARKED
    marks = tuple(events) if few else ()
    plain = tuple((at, "") for at, _ in marks)
    panels = []
    if shown[0].wind is not None:
        winds = [Series("wind", t, shown[0].wind)]
        if shown[0].average and shown[0].chain.wind is not None:
            winds.insert(0, Series("wind as it blows", t, shown[0].chain.wind, faint=True))
        panels.append(Panel("wind, m/s", tuple(winds), x_marks=plain))
    speeds = [(f"{s.who}{name}", s.signals[key]) for s in shown
              for name, key in (("turbine", "turbine_speed"), ("pump", "pump_speed")) if key in s.signals]  # fmt: skip
    turning, factor = preferred("rad/s", 1.0, "speed")
    panels.append(Panel(f"speed, {turning}", tuple(Series(n, t, factor * v) for n, v in speeds), x_marks=marks))
    ratios = tuple(Series(f"{s.who}pump", t, s.ratio) for s in shown if s.ratio is not None)
    if ratios:
        panels.append(Panel("pump speed over turbine speed, 1", ratios, x_marks=plain))
    for label, source, key, name in (
        ("power coefficient Cp, 1", "signals", "power_coefficient", "turbine"),
        ("power at the turbine, W", "powers", "aerodynamic", "turbine"),
        ("power into the water, W", "powers", "hydraulic", "pump"),
    ):
        series = tuple(Series(f"{s.who}{name}", t, getattr(s, source)[key]) for s in shown if key in getattr(s, source))
        if series:
            panels.append(Panel(label, series, x_marks=plain, y_range=COEFFICIENTS if "Cp" in label else None))
    text = f"{shown[0].averaged} Gaps in the ratio: the turbine stands (below {factor * shown[0].standstill:.3g} {turning})."
    if events:
        text += " Thin vertical lines: the pump starts or stops." if few else " The pump's starts and stops are in the table."
    return Chart("Time histories", f"time, {unit}", tuple(panels), text.strip(), height=200)


def water_chart(shown: Sequence[Shown]) -> Chart | None:
    """Flow, water delivered and the tank's level over time; None where none of them was recorded."""
    seconds, unit = scale(shown[0].chain.time)
    t = shown[0].chain.time / seconds
    kinds = (("flow, l/s", "flow", LITRES), ("water delivered, m³", "delivered", 1.0), ("level in the tank, m", "level", 1.0))
    panels = filled(
        (label, [Series(f"{s.who}pump", t, factor * np.asarray(s.signals[key])) for s in shown if key in s.signals])
        for label, key, factor in kinds
    )
    return Chart("Water", f"time, {unit}", panels, shown[0].averaged, height=200) if panels else None


def _quantities(s: Shown) -> list[tuple[str, np.ndarray]]:
    """(label of the axis, values (n,)) of what is drawn against the wind."""
    unit, factor = preferred("rad/s", 1.0, "speed")
    speeds = ((f"{name} speed, {unit}", s.signals.get(f"{name}_speed")) for name in ("turbine", "pump"))
    quantities = [
        *((label, None if v is None else factor * v) for label, v in speeds),
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
    why = "the pump starts at a higher wind than it stops at: hysteresis" if both else "the rotor speed lags the wind"
    text = shown[0].averaged
    text += f" Where the branches part, {why}." if len({way for way, _ in followed}) == 2 else ""
    return Chart("Against the wind", "", _panels(shown, lines_of, lines), text.strip(), columns=2, height=260)


def bins_chart(shown: Sequence[Shown], start: int = 0) -> Chart | None:
    """Means over `average` s as dots and the means of bins of 0.5 m/s as a line; None without means or with a steady wind."""
    first = shown[0]
    time, width = first.chain.time[start:], first.average
    if width <= 0.0 or first.wind is None or time[-1] - time[0] < FEWEST_MEANS * width:
        return None
    at = np.arange(time[0] + 0.5 * width, time[-1] - 0.5 * width, width)
    if np.ptp(np.interp(at, time, first.wind[start:])) < BIN:
        return None

    def series_of(s: Shown, values: np.ndarray) -> list[Series]:
        wind, mean = (np.interp(at, time, v[start:]) for v in (s.wind, values))  # type: ignore[index]
        number = np.floor(wind / BIN).astype(int)
        known = [(k, mean[(number == k) & np.isfinite(mean)]) for k in np.unique(number)]
        full = [(k, v) for k, v in known if v.size >= FEWEST_MEANS]
        middle, mean_of = [(k + 0.5) * BIN for k, _ in full], [float(v.mean()) for _, v in full]
        dots = Series(f"{s.who}means over {width:g} s", wind, mean, "dots")
        return [dots, Series(f"{s.who}bins of {BIN:g} m/s", middle, mean_of)]

    text = (f"Dots: means over {width:g} s, one after the other. Line: their means in bins of wind. The spread at one wind is "
            "what inertia and the way the wind came leave of the past.")  # fmt: skip
    return Chart("Against the wind", "", _panels(shown, series_of), text, columns=2, height=260)


def runs_table(shown: Sequence[Shown]) -> Cells:
    """Every run of a pump: when it began and ended, and at which wind; times as in the figures, in s or h."""
    seconds, unit = scale(shown[0].chain.time)
    rows: list[tuple[str, ...]] = []
    for s in shown:
        for r in s.runs[:MOST]:
            begin, end = (None if at is None else at / seconds for at in (r.begin, r.end))
            cells = (begin, r.begin_wind, end, r.end_wind, r.turns)
            rows.append((s.chain.name, *("" if v is None else number(v) for v in cells)))
        if len(s.runs) > MOST:
            rows.append((s.chain.name, f"and {len(s.runs) - MOST} more", "", "", "", ""))
        if not s.runs:
            turned = float(np.max(s.chain.signals["pump_speed"])) > s.standstill
            rows.append((s.chain.name, "makes less than a turn" if turned else "never runs", "", "", "", ""))
    turning, factor = preferred("rad/s", 1.0, "speed")
    text = (f"A pump runs while its shaft is faster than {factor * shown[0].standstill:.3g} {turning} and makes a turn or more; a "
            f"standstill of up to {shown[0].pause:g} s is none. Empty: it ran when the record began, or still did when it "
            "ended.")  # fmt: skip
    return Cells("Starts and stops", ("transmission", f"starts at, {unit}", "wind then, m/s", f"stops at, {unit}",
                                      "wind then, m/s", "turns"), rows, text, frozenset(range(1, 6)))  # fmt: skip


def efficiency_table(result: Result, shown: Sequence[Shown], start: int = 0) -> Cells:
    """Energy that passed every interface of each chain, and the share of it that came from the one before."""
    rows: list[tuple[str, ...]] = []
    for s in shown:
        wind = wind_energy(result, s.chain, start)
        if wind is not None:
            rows.append((s.chain.name, "wind through the rotor's area", number(1e-3 * wind), ""))
        for stage, energy, share in efficiencies(s.chain, start):
            share = energy / wind if stage == "aerodynamic" and wind else share
            rows.append((s.chain.name, NAMES[stage], number(1e-3 * energy), "" if share is None else number(100.0 * share)))
    text = ("Integrals of the recorded powers. What lacks between two stages was lost there, or is still in the motion of the "
            "shafts: over a short run that is no loss.")  # fmt: skip
    return Cells("Energy along the chain", ("transmission", "interface", "energy, kJ", "of the one before, %"), rows, text,
                 frozenset({2, 3}))  # fmt: skip
