"""Spectra with the lines that races, balls and cage make."""

from __future__ import annotations

import numpy as np

from ....harness.analysis.signals import amplitude_spectrum
from ....harness.analysis.spectra import Family, envelope_spectrum, peak, resonance_band
from ....harness.charts.chart import Chart, Lines, Panel, Series
from ..keys import BearingKeys
from ..records import BearingRecord
from .motion import after
from .scales import Scales

NAMES = {
    "outer": "outer race (BPFO)",
    "inner": "inner race (BPFI)",
    "ball": "ball (2 BSF)",
    "cage": "cage (FTF)",
    "shaft": "shaft",
}
LOWEST_BAND = 5.0  # times the highest defect frequency: below, the impacts' own harmonics are counted as resonance
HIGHEST_BAND = 30.0  # above, a simulated signal is free of noise and impulsive, but carries next to nothing
UNFOLDED = 0.25  # of the rate of recording: what an unfiltered record folds back to below that was above three times it
SHOWN_HARMONICS = 10.0  # of the outer race's frequency, in the plain spectrum
SHOWN_ENVELOPE = 4.5  # of the highest defect frequency, in the envelope's
DECADES = 5.0  # shown below the highest line


def families(record: BearingRecord, keys: BearingKeys) -> list[Family]:
    """Lines to look for: those the scene marks, else of what has a defect, the passing of balls and the shaft."""
    if not record.frequencies:
        return []
    wanted: tuple[str, ...] = keys.marks or tuple(dict.fromkeys([*record.defects, "outer", "shaft"]))
    f, turn = record.frequencies, abs(record.rotation)
    known = {
        "outer": Family(NAMES["outer"], f["outer"], 5),
        "inner": Family(NAMES["inner"], f["inner"], 3, turn, 2),
        "ball": Family(NAMES["ball"], 2.0 * f["ball"], 3, f["cage"], 2),
        "cage": Family(NAMES["cage"], f["cage"], 2),
        "shaft": Family(NAMES["shaft"], turn, 3),
    }
    return [known[name] for name in wanted]


def marked(line_families: list[Family], highest: float) -> tuple[Lines, ...]:
    """The families as lines of a chart: the fundamental carries the short name, harmonics their order."""
    marks = []
    for family in line_families:
        short = family.name.partition("(")[2].rstrip(")") or family.name
        lines = family.lines(highest)
        at = tuple((x.frequency, "" if x.side else (short if x.order == 1 else f"{x.order}×")) for x in lines)
        if at:
            marks.append(Lines(family.name, at))
    return tuple(marks)


def spectrum_chart(record: BearingRecord, begin: float, keys: BearingKeys, who: str = "") -> Chart:
    """Amplitude spectra of displacement and acceleration after the transient."""
    scales, kept = Scales(record), after(record, begin)
    line_families = families(record, keys)
    highest = 0.5 * record.rate
    if record.frequencies:
        highest = min(highest, SHOWN_HARMONICS * record.frequencies["outer"])
    highest = min(0.5 * record.rate, keys.highest_frequency or highest)
    panels = []
    for what in ("displacement", "acceleration"):
        series, top = [], 0.0
        for n in (f"{what}_x", f"{what}_y"):
            if n in record.signals:
                f, a = amplitude_spectrum(scales.factor(n) * record.signals[n][kept], record.rate)
                shown = (f > 0.0) & (f <= highest)
                series.append(Series(n[-1], f[shown], a[shown]))
                top = max(top, float(a[shown].max(initial=0.0)))
        if series:
            ends = (top * 10.0**-DECADES, top * 10.0**0.7) if top > 0.0 else None
            label = f"{what}, {scales.unit(f'{what}_x')}"
            lines = marked(line_families, highest)
            panels.append(Panel(label, tuple(series), lines=lines, logarithmic=True, x_range=(0.0, highest), y_range=ends))
    text = "Amplitudes: mean removed, Hann window, single-sided, a sine of amplitude A reads A."
    return Chart(f"{who}Amplitude spectrum", scales.frequency, tuple(panels), text + _strongest(record, begin, line_families))


def _strongest(record: BearingRecord, begin: float, line_families: list[Family]) -> str:
    """Where the lines of the first family were found, as a sentence."""
    name = "acceleration_x" if "acceleration_x" in record.signals else "displacement_x"
    x = record.signals[name][after(record, begin)]
    f, a = amplitude_spectrum(x, record.rate)
    if not line_families or line_families[0].frequency >= 0.45 * record.rate or not a.any():
        return ""
    scales = Scales(record)
    expected = line_families[0].frequency
    at, height = peak(f, a, expected, max(0.02 * expected, 2.5 * f[1]))
    signal, unit = name.replace("_", " "), f" {scales.unit(name)}" if scales.dimensional else ""
    return (
        f" The {line_families[0].name} is expected at {expected:.5g}{scales.hertz}; the highest line of {signal} thereabouts "
        f"is at {at:.5g}{scales.hertz}, {scales.factor(name) * height:.3g}{unit}."
    )


def envelope_chart(record: BearingRecord, begin: float, keys: BearingKeys, who: str = "") -> Chart | None:
    """Spectrum of the envelope of the acceleration in a band of resonance; None where the record holds no such band."""
    name = next((n for n in ("acceleration_x", "displacement_x") if n in record.signals), "")
    if not name or not record.frequencies:
        return None
    scales, x = Scales(record), record.signals[name][after(record, begin)]
    top = max(record.frequencies["inner"], 2.0 * record.frequencies["ball"])
    band = keys.envelope_band
    if band is None:
        bounds = LOWEST_BAND * top, min(HIGHEST_BAND * top, UNFOLDED * record.rate)
        if bounds[0] > 0.5 * bounds[1] or not np.ptp(x) > 0.0:
            return None
        band = resonance_band(x, record.rate, *bounds)
    low, high = (float(v) for v in band)
    f, a = envelope_spectrum(scales.factor(name) * x, record.rate, low, high)
    highest = SHOWN_ENVELOPE * top
    shown = (f > 0.0) & (f <= highest)
    line_families = families(record, keys)
    series = (Series("envelope", f[shown], a[shown]),)
    panel = Panel(f"envelope of {name.replace('_', ' ')}, {scales.unit(name)}", series, lines=marked(line_families, highest),
                  x_range=(0.0, highest))  # fmt: skip
    chosen = "given" if keys.envelope_band is not None else "the most impulsive of the signal (kurtogram)"
    text = (
        f"Envelope of the band {low:.4g} to {high:.4g}{scales.hertz}, {chosen}. What hits a resonance again and again shows here "
        "with the frequency of its repetition; sidebands: how its strength varies as it turns through the loaded zone."
    )
    return Chart(f"{who}Envelope spectrum", scales.frequency, (panel,), text, height=300)
