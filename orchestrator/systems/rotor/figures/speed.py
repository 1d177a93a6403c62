"""Motion of the watched place over time, over speed and over frequency."""

from __future__ import annotations

import numpy as np

from ....harness.analysis.signals import amplitude_spectrum, uniform
from ....harness.analysis.spectra import Family, follow, unwrapped, waterfall
from ....harness.charts.chart import Chart, Lines, Panel, Picture, Series
from ..records import RotorRecord

RPM = 30.0 / np.pi  # per rad/s
MICRO = 1e6
WINDOWS = 120  # of the waterfall
TURNS = 4  # of a window in which the synchronous part is followed
RESOLVED = 12  # turns at the mean speed in a window of the waterfall
SPECTRUM = 6.0  # times the speed, end of the spectrum
DECADES = 5.0


def named(critical: np.ndarray) -> tuple[Lines, ...]:
    """Critical speeds as lines over a speed axis in rpm."""
    if not critical.size:
        return ()
    return (Lines("critical speed (undamped)", tuple((RPM * float(c), f"{RPM * float(c):.0f}") for c in critical)),)


def _from(record: RotorRecord, begin: float) -> slice:
    return slice(int(np.searchsorted(record.time, begin - 1e-12)), None)


def history_chart(record: RotorRecord, begin: float, who: str = "") -> Chart:
    """Displacement of the watched place and, where it changes, speed over the whole run."""
    mark = ((begin, ""),) if begin > record.time[0] else ()
    motion = tuple(Series(n, record.time, MICRO * record.signals[n]) for n in ("x", "y"))
    panels: tuple[Panel, ...] = (Panel("displacement, µm", motion, x_marks=mark),)
    if np.ptp(record.signals["speed"]) > 0.0:
        panels += (Panel("speed, rpm", (Series("speed", record.time, RPM * record.signals["speed"]),), x_marks=mark),)
    text = "Displacement of the watched place of the shaft, x horizontal, y upwards."
    return Chart(f"{who}Time history", "time, s", panels, text + (" Thin vertical line: end of the transient." if mark else ""))


def run_up_chart(record: RotorRecord, begin: float, critical: np.ndarray, who: str = "") -> Chart:
    """Amplitude and phase lag of the synchronous motion against the speed."""
    kept = _from(record, begin)
    t, angle = record.time[kept], record.signals["angle"][kept]
    tracks = {n: follow(t, angle, record.signals[n][kept], turns=TURNS) for n in ("x", "y")}
    backward = bool(unwrapped(angle)[-1] < unwrapped(angle)[0])
    amplitude = tuple(Series(n, RPM * k.speed, MICRO * k.amplitude) for n, k in tracks.items())
    lag = tuple(Series(n, RPM * k.speed, _within_turn(k.lag)) for n, k in tracks.items())
    lines = named(critical)
    panels = (
        Panel("amplitude, µm", amplitude, lines=lines),
        Panel("phase lag, degrees", lag, lines=lines, y_range=(-100.0, 310.0)),
    )
    text = (
        f"Part of the motion that turns with the shaft (once a turn), over windows of {TURNS} turns a turn apart; phase lag "
        "behind the rotor's angle. Beats: free vibration that is not yet damped away."
    )
    return Chart(f"{who}Run-up: synchronous motion", "speed, rpm" + (" (backward)" if backward else ""), panels, text, height=260)


def _within_turn(lag: np.ndarray) -> np.ndarray:
    """A lag (k,) rad within -90 to 270 degrees; a gap, NaN, where it jumps by a turn."""
    turned = np.degrees((lag + 0.5 * np.pi) % (2.0 * np.pi) - 0.5 * np.pi)
    jumps = np.flatnonzero(np.abs(np.diff(turned)) > 180.0)
    turned[jumps] = np.nan
    return turned


def waterfall_chart(
    record: RotorRecord, begin: float, critical: np.ndarray, orders: tuple[float, ...] = (1.0, 2.0), who: str = ""
) -> Chart:
    """Spectra over the speed as a picture, with the lines of multiples of the rotation."""
    kept = _from(record, begin)
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
    kept = _from(record, begin)
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
