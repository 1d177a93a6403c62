"""A defect of a bearing, located in a measured acceleration: which lines stand in the spectrum of its envelope.

python -m cosimo.orchestrator.systems.bearings.locate record.csv --bearing "JIS 6306" --speed "1800 rpm"

The band is that in which the signal is most impulsive. Balls slip, so that each frequency is looked for within `SLIP`. Ordinates of the
power of an envelope of noise are nearly exponential about their local mean, so that the least of `HARMONICS` of them is beyond s with
exp(-`HARMONICS` s): this, times the number of places that are tried, is the probability of a line by chance. All multiples have to stand
out, since one of them may be that of another defect. Multiples of the shaft's frequency are left out.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from pathlib import Path

import numpy as np

from ....components.bearings.ball_bearing import BallBearing
from ....components.core.columns import read_table
from ....components.core.errors import BadInput
from ....components.core.measure import is_quantity, number_in
from ...harness.analysis.signals import uniform
from ...harness.analysis.spectra import TURN, envelope_spectrum, resonance_band
from .figures import LOWEST_BAND, NAMES, UNFOLDED

LEVEL = 0.01  # that any of the defects is named where there is none
SLIP = 0.02  # relative: balls slip by a percent or two (recalled)
HARMONICS = 3
NEIGHBOURS = 101  # ordinates about a line, of whose median the local mean follows
BESIDE = 3  # ordinates beside a multiple of the shaft's frequency that belong to it: a Hann window spreads a line over two
TURNS = 50  # of the shaft, in the shortest record


@dataclass(frozen=True)
class FoundLine:
    """Of a place of the bearing: expected and best frequency, Hz.

    strength: power of its weakest multiple over the local mean.  p: probability by chance.
    """

    place: str
    expected: float
    frequency: float
    strength: float
    p: float


def locate(time: np.ndarray, acceleration: np.ndarray, frequencies: Mapping[str, float], rotation: float) -> list[FoundLine]:
    """Lines of outer race, inner race, ball and cage in a record, (n,) each, the least likely first; rotation: turns per second.

    frequencies: of a bearing, see `BallGeometry.defect_frequencies`. Raises `BadInput` for a record too short or too slow.
    """
    from scipy.ndimage import median_filter

    rate, _, (x,) = uniform(time, acceleration)
    if (turns := x.size / rate * rotation) < TURNS:
        raise BadInput("record", f"{turns:.3g} turns of the shaft", f"{TURNS} or more")
    places = {"outer": frequencies["outer"], "inner": frequencies["inner"], "ball": 2.0 * frequencies["ball"]}
    low, high = LOWEST_BAND * max(places.values()), UNFOLDED * rate
    if low > 0.5 * high:
        raise BadInput("record", f"{rate:.4g} samples a second", f"{2.0 * low / UNFOLDED:.4g} or more", "Its lines lie too high.")
    f, amplitude = envelope_spectrum(x, rate, *resonance_band(x, rate, low, high))
    power = amplitude**2
    strength = power / np.maximum(median_filter(power, NEIGHBOURS) / log(2.0), 1e-300)
    step = f[1] - f[0]
    strength[np.abs(f - rotation * np.round(f / rotation)) <= BESIDE * step] = 0.0
    lines = []
    for place, expected in {**places, "cage": frequencies["cage"]}.items():
        tried = np.arange(expected * (1.0 - SLIP), expected * (1.0 + SLIP), step / HARMONICS)
        at = np.round(np.outer(tried, np.arange(1, HARMONICS + 1)) / step).astype(int)
        least = strength[np.minimum(at, f.size - 1)].min(axis=1)
        k = int(np.argmax(least))
        p = min(1.0, exp(-HARMONICS * float(least[k])) * tried.size * (len(places) + 1))
        lines.append(FoundLine(place, expected, float(tried[k]), float(least[k]), p))
    return sorted(lines, key=lambda line: (line.p, -line.strength))


def main(arguments: Sequence[str] | None = None) -> None:
    """Of a CSV file. Exit code 2 for what cannot be judged."""
    parser = argparse.ArgumentParser(prog="python -m cosimo.orchestrator.systems.bearings.locate", description=__doc__)
    parser.add_argument("file", type=Path, help="CSV with columns of time and acceleration")
    parser.add_argument("--bearing", required=True, help='preset of BallBearing, "JIS 6306"')
    parser.add_argument("--speed", required=True, help='of the shaft, "1800 rpm"')
    parser.add_argument("--time", default="time", help="column of the time")
    parser.add_argument("--column", default="acceleration", help="column of the acceleration")
    given = parser.parse_args(arguments)
    try:
        if not is_quantity(given.speed):
            raise BadInput("--speed", repr(given.speed), 'a number with its unit, "1800 rpm"')
        rotation = number_in(given.speed, "rad/s", "--speed") / TURN
        bearing = BallBearing((), {}, preset=given.bearing, name="bearing")
        table = read_table(given.file)
        time, x = table.numbers(given.time, "s"), table.numbers(given.column, "m/s2")
        kept = ~np.isnan(time + x)
        lines = locate(time[kept], x[kept], bearing.geometry.defect_frequencies(rotation), rotation)
    except BadInput as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    named = [line for line in lines if line.p < LEVEL]
    print(f"A defect: {NAMES[named[0].place]}." if named else "No line of a defect stands out of the noise.")
    for line in lines:
        print(
            f"{NAMES[line.place]:18} expected {line.expected:8.2f} Hz, best {line.frequency:8.2f} Hz, "
            f"{line.strength:7.3g} times the noise, by chance with {line.p:.2g}"
        )


if __name__ == "__main__":
    main()
