"""Sums of sines with random frequencies and phases, that stand for a spectrum: the same for the same seed."""

from __future__ import annotations

import math

import numpy as np

from ..core.kernels import kernel

TURN = 2.0 * math.pi
AMPLITUDE, NUMBER, PLACE, PHASE = range(4)  # rows of sines; number: rad/m or rad/s, place: 0 to 1 within the band, phases: rad


@kernel
def sum_of_sines(s, k, sines):
    """sum amplitude[i] cos(number[i] s + phase[k, i]) over a distance or a time s; sines: (3 + sums, n)."""
    total = 0.0
    for i in range(sines.shape[1]):
        total += sines[AMPLITUDE, i] * math.cos(sines[NUMBER, i] * s + sines[PHASE + k, i])
    return total


def random_phases(count: int, sums: int, seed: int) -> np.ndarray:
    """Sines of which only the random numbers are known: places within their bands, 0 to 1, and phases, (3 + sums, count)."""
    random = np.random.default_rng(seed)
    sines = np.zeros((PHASE + sums, count))
    sines[PLACE] = random.random(count)
    sines[PHASE:] = TURN * random.random((sums, count))
    return sines


@kernel
def fill_bands(lowest, highest, longest, exponent, deviation, sines):
    """Numbers and amplitudes of sines in bands of equal ratio between two frequencies, each with the energy of its band.

    The energy per frequency n goes as 1 / (1 + (n longest)^exponent), exponent 0: the same for all; the sum has the deviation.
    """
    count = sines.shape[1]
    first, step = math.log10(lowest), (math.log10(highest) - math.log10(lowest)) / count
    edge, total = lowest, 0.0
    for i in range(count):
        end = 10.0 ** (step * (i + 1) + first) if i < count - 1 else highest
        sines[NUMBER, i] = TURN * (edge * (end / edge) ** sines[PLACE, i])
        energy = 1.0 / (1.0 + (math.sqrt(end * edge) * longest) ** exponent) * (end - edge)
        sines[AMPLITUDE, i] = energy
        total += energy
        edge = end
    for i in range(count):
        sines[AMPLITUDE, i] = deviation * math.sqrt(2.0 * sines[AMPLITUDE, i] / total)
