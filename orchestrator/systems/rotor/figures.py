"""Figures of the rotors of a run: run-up, spectra, Campbell diagram, orbits and forces at the bearings.

Read from [analysis], beside what `rotor.whirl` says: orbit_windows = [[from, to], ...] in s, orders = [1, 2] (lines in the
waterfall).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.signals import amplitude_spectrum, uniform
from ...harness.analysis.spectra import Family, follow, turns_steadily, unwrapped, waterfall
from ...harness.charts.blocks import Block
from ...harness.charts.chart import Chart, Lines, Panel, Picture, Series
from ...harness.charts.charts import draw_chart
from ...run.key_results import after_transient
from ..bearings.figures import charts_over_time
from ..bearings.records import STEADY, since
from . import RotorKeys
from .records import RotorRecord, rotors
from .whirl import Whirl, whirl

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

TURNS = 8  # in the record, below which nothing is followed; of an orbit
FOLLOWED = 4  # turns of a window in which the synchronous part is followed
WINDOWS = 120  # of the waterfall
RESOLVED = 12  # turns at the mean speed in a window of the waterfall
SPECTRUM = 6.0  # times the speed, end of the spectrum
DECADES = 5.0
RPM = 30.0 / np.pi  # per rad/s
HERTZ = 0.5 / np.pi  # per rad/s
MICRO = 1e6
KINDS = ((1, "forward whirl"), (-1, "backward whirl"), (0, "mixed whirl"))


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures of every rotor of a run whose speed was recorded; none without one."""
    records = rotors(result)
    content = [b for record in records for b in _of_one(result, record, f"{record.unit}: " if len(records) > 1 else "")]
    return [*content, *map(draw_chart, charts_over_time(result))]


def _of_one(result: Result, record: RotorRecord, who: str) -> list[Block]:
    analysis = result.scene.analysis_as(RotorKeys)
    begin = float(result.time[after_transient(result).start])
    speed = record.signals["speed"][record.time >= begin]
    diagram = whirl(result, record)
    if diagram is not None:
        critical = diagram.critical
    else:
        critical = np.asarray(analysis.critical_speeds, dtype=float)
    varies = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    moves = {"x", "y"} <= record.signals.keys()
    turns = "angle" in record.signals and _turns(record.signals["angle"][record.time >= begin]) >= TURNS
    content: list[Block] = []
    if moves:
        content.append(draw_chart(history_chart(record, begin, who)))
    if moves and turns and varies:
        content += [draw_chart(chart(record, begin, critical, who)) for chart in (run_up_chart, polar_chart)]
        content.append(draw_chart(waterfall_chart(record, begin, critical, analysis.orders, who)))
    elif moves and speed.any():
        content.append(draw_chart(spectrum_chart(record, begin, who)))
    if diagram is not None:
        content.append(draw_chart(campbell_chart(diagram, who)))
    content += [draw_chart(c) for c in orbits_chart(record, _windows(analysis.orbit_windows, record), who)]
    if any("force_x" in p for p in record.ports.values()):
        content.append(draw_chart(forces_chart(record, begin, who)))
    return content


def _turns(angle: np.ndarray) -> float:
    """Turns of a recorded angle; 0 where it stands or turns back."""
    return abs(float(np.ptp(np.unwrap(angle)))) / (2.0 * np.pi) if turns_steadily(angle) else 0.0


def _windows(given: Sequence[Sequence[float]], record: RotorRecord) -> list[tuple[float, float]]:
    """Times of the orbits: the scene's, else the last turns at the last speed, else the last tenth."""
    first, last = float(record.time[0]), float(record.time[-1])
    if given:
        return [(float(a), float(b)) for a, b in given]
    speed = abs(float(record.signals["speed"][-1]))
    length = TURNS * 2.0 * np.pi / speed if speed > 0.0 else 0.1 * (last - first)
    return [(max(first, last - length), last)]


def named(critical: np.ndarray) -> tuple[Lines, ...]:
    """Critical speeds as lines over a speed axis in rpm."""
    if not critical.size:
        return ()
    return (Lines("critical speed (undamped)", tuple((RPM * float(c), f"{RPM * float(c):.0f}") for c in critical)),)


def history_chart(record: RotorRecord, begin: float, who: str = "") -> Chart:
    """Displacement of the watched place and, where it changes, speed over the whole run."""
    mark = ((begin, ""),) if begin > record.time[0] else ()
    motion = tuple(Series(n, record.time, MICRO * record.signals[n]) for n in ("x", "y"))
    panels: tuple[Panel, ...] = (Panel("displacement, µm", motion, x_marks=mark),)
    if np.ptp(record.signals["speed"]) > 0.0:
        panels += (Panel("speed, rpm", (Series("speed", record.time, RPM * record.signals["speed"]),), x_marks=mark),)
    text = "Shaft displacement at the measurement plane, x horizontal, y upwards."
    return Chart(f"{who}Time history", "time, s", panels, text + (" Thin vertical line: end of the transient." if mark else ""))


def run_up_chart(record: RotorRecord, begin: float, critical: np.ndarray, who: str = "") -> Chart:
    """Amplitude and phase lag of the synchronous motion against the speed."""
    kept = since(record.time, begin)
    t, angle = record.time[kept], record.signals["angle"][kept]
    tracks = {n: follow(t, angle, record.signals[n][kept], turns=FOLLOWED) for n in ("x", "y")}
    backward = bool(unwrapped(angle)[-1] < unwrapped(angle)[0])
    amplitude = tuple(Series(n, RPM * k.speed, MICRO * k.amplitude) for n, k in tracks.items())
    lag = tuple(Series(n, RPM * k.speed, _unwrapped_degrees(k.lag)) for n, k in tracks.items())
    lines = named(critical)
    panels = (Panel("amplitude, µm", amplitude, lines=lines), Panel("phase lag, degrees", lag, lines=lines))
    text = (
        f"Synchronous (1X) component of the displacement, from windows of {FOLLOWED} turns, one per turn. Phase lag: relative to the "
        "rotor's angle (Bode plot). Beats: free vibration that has not decayed yet."
    )
    return Chart(f"{who}Run-up: synchronous motion", "speed, rpm" + (" (backward)" if backward else ""), panels, text, height=260)


def _unwrapped_degrees(lag: np.ndarray) -> np.ndarray:
    """A lag (k,) rad in degrees without jumps by a turn; it begins within -90 to 270 degrees."""
    whole = np.degrees(np.unwrap(lag))
    return whole - 360.0 * np.floor((whole[:1] + 90.0) / 360.0)


def polar_chart(record: RotorRecord, begin: float, critical: np.ndarray, who: str = "") -> Chart:
    """The synchronous motion as a vector that the speed moves: amplitude as its length, phase lag as its angle."""
    kept = since(record.time, begin)
    t, angle = record.time[kept], record.signals["angle"][kept]
    panels = []
    for name in ("x", "y"):
        track = follow(t, angle, record.signals[name][kept], turns=FOLLOWED)
        across, up = (MICRO * track.amplitude * part(track.lag) for part in (np.cos, np.sin))
        curve = [Series("1X vector", across, up)]
        for speed in (c for c in critical if track.speed.min() <= c <= track.speed.max()):
            k = int(np.argmin(np.abs(track.speed - speed)))
            curve.append(Series(f"at {RPM * speed:.0f} rpm", across[k : k + 1], up[k : k + 1], "points"))
        panels.append(
            Panel(f"{name}: amplitude × sin(lag), µm", tuple(curve), x_label="amplitude × cos(lag), µm", equal=True, title=name)
        )
    text = (
        "Synchronous (1X) component of the displacement as a vector; the phase lag is its angle, anticlockwise. A resonance is a "
        "loop. Points: undamped critical speeds."
    )
    return Chart(f"{who}Run-up: polar plot", "", tuple(panels), text, columns=2, height=340)


def waterfall_chart(
    record: RotorRecord, begin: float, critical: np.ndarray, orders: tuple[float, ...] = (1.0, 2.0), who: str = ""
) -> Chart:
    """Spectra over the speed as a picture, with the lines of multiples of the rotation."""
    kept = since(record.time, begin)
    rate, t, (x, speed) = uniform(record.time[kept], record.signals["x"][kept], record.signals["speed"][kept])
    mean, top = float(np.abs(speed).mean()) / (2.0 * np.pi), float(np.abs(speed).max()) / (2.0 * np.pi)
    duration = min(RESOLVED / mean, 0.2 * float(t[-1] - t[0]))
    at, f, amplitude = waterfall(MICRO * x, rate, duration, WINDOWS)
    speeds = RPM * np.abs(np.interp(at + t[0], t, speed))
    order = np.argsort(speeds, kind="stable")
    shown = f <= min(0.5 * rate, 1.15 * max(orders) * top)
    rows = amplitude[order][:, shown].T
    even = np.linspace(speeds.min(), speeds.max(), WINDOWS)  # speeds may dwell; a picture has even columns
    values = np.array([np.interp(even, speeds[order], r) for r in rows])
    picture = Picture(even, f[shown], np.sqrt(values), "square root of amplitude, √µm", "rising")
    multiples = tuple(
        Series(f"{k:g} × speed", [even[0], even[-1]], [k * even[0] / 60.0, k * even[-1] / 60.0], faint=True) for k in orders
    )
    ends = (0.0, float(f[shown][-1]))
    panel = Panel("frequency, Hz", multiples, picture=picture, lines=named(critical), y_range=ends, x_range=(even[0], even[-1]))
    text = (
        f"Spectra of x in {WINDOWS} windows of {1e3 * duration:.0f} ms. Pale lines: {', '.join(f'{k:g}' for k in orders)} times "
        "the speed. What stays at one frequency while the speed changes is a natural frequency."
    )
    return Chart(f"{who}Waterfall", "speed, rpm", (panel,), text, height=420)


def spectrum_chart(record: RotorRecord, begin: float, who: str = "") -> Chart:
    """Amplitude spectrum of the watched place at the steady speed."""
    kept = since(record.time, begin)
    rate, _, (x, y) = uniform(record.time[kept], record.signals["x"][kept], record.signals["y"][kept])
    turn = float(np.abs(record.signals["speed"][kept]).mean()) / (2.0 * np.pi)
    highest = min(0.5 * rate, SPECTRUM * turn)
    series, top = [], 0.0
    for name, values in (("x", x), ("y", y)):
        f, a = amplitude_spectrum(MICRO * values, rate)
        shown = (f > 0.0) & (f <= highest)
        series.append(Series(name, f[shown], a[shown]))
        top = max(top, float(a[shown].max(initial=0.0)))
    at = tuple((k.frequency, k.text or "1×") for k in Family("shaft", turn, int(SPECTRUM)).lines(highest))
    ends = (top * 10.0**-DECADES, top * 10.0**0.7) if top > 0.0 else None
    panel = Panel("displacement, µm", tuple(series), lines=(Lines("speed and multiples", at),), logarithmic=True, y_range=ends,
                  x_range=(0.0, highest))  # fmt: skip
    text = "Amplitudes after the transient: mean removed, Hann window, single-sided, a sine of amplitude A reads A."
    return Chart(f"{who}Amplitude spectrum at {60.0 * turn:.0f} rpm", "frequency, Hz", (panel,), text)


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


def orbits_chart(record: RotorRecord, windows: Sequence[tuple[float, float]], who: str = "") -> list[Chart]:
    """For every window (from, to) in s the orbits at the watched place and at the bearings, all in one scale each."""
    places = {"watched place": record.signals} | {p.replace("_", " "): s for p, s in record.ports.items()}
    places = {name: s for name, s in places.items() if {"x", "y"} <= s.keys()}
    charts = []
    for start, end in windows:
        kept = (record.time >= start) & (record.time <= end)
        if not places or kept.sum() < 2:
            continue
        panels = []
        for name, s in places.items():
            x, y = MICRO * s["x"][kept], MICRO * s["y"][kept]
            series = (Series("orbit", x, y), Series("begin", x[:1], y[:1], "points"))
            panels.append(Panel("y, µm", series, title=name, x_label="x, µm", equal=True))
        speed = RPM * record.signals["speed"][kept]
        turning = f"{speed.mean():.0f} rpm" if np.ptp(speed) < 1.0 else f"{speed[0]:.0f} to {speed[-1]:.0f} rpm"
        text = f"{start:.4g} to {end:.4g} s, {turning}. x horizontal, y upwards; the same scale in both directions."
        charts.append(Chart(f"{who}Orbits", "", tuple(panels), text, columns=max(2, len(panels)), height=340))
    return charts


def forces_chart(record: RotorRecord, begin: float, who: str = "") -> Chart:
    """Forces of the bearings on the shaft, and the load of the most loaded ball, over the whole run."""
    mark = ((begin, ""),) if begin > record.time[0] else ()
    panels = []
    for port, s in record.ports.items():
        series = [Series(n[-1], record.time, s[n]) for n in ("force_x", "force_y") if n in s]
        series += [Series("most loaded ball", record.time, s["max_ball_load"])] if "max_ball_load" in s else []
        if series:
            panels.append(Panel("force, N", tuple(series), title=port.replace("_", " "), x_marks=mark))
    return Chart(f"{who}Forces of the bearings", "time, s", tuple(panels), "On the shaft; x horizontal, y upwards.", height=240)
