"""Sums of sines with random frequencies and phases, that stand for a spectrum: the same for the same seed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import kernel, kernel_tuple

TURN = 2.0 * math.pi


@kernel_tuple
class Sines(NamedTuple):
    """sum amplitude[i] cos(number[i] s + phase[k, i]) over a distance or a time s; number: (n,) 1/m or 1/s, phase: (m, n)."""

    amplitude: np.ndarray
    number: np.ndarray
    phase: np.ndarray


@kernel
def sum_of_sines(s, k, sines):
    """Row k of `sines` at s."""
    total = 0.0
    for i in range(sines.amplitude.size):
        total += sines.amplitude[i] * math.cos(sines.number[i] * s + sines.phase[k, i])
    return total


def random_bands(lowest: float, highest: float, count: int, random) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`count` bands of equal ratio between two frequencies: a random frequency in each, its middle and its width, (n,)."""
    edges = np.geomspace(lowest, highest, int(count) + 1)
    number = edges[:-1] * (edges[1:] / edges[:-1]) ** random.random(int(count))
    return number, np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)


def random_sines(lowest: float, highest: float, count: int, density, deviation: float, rows: int, seed: int) -> Sines:
    """Sines in `count` bands of equal ratio between two frequencies, each at random within its band, with the band's energy.

    density: of the energy over the frequency, to a factor; the sum has the standard deviation.
    """
    random = np.random.default_rng(int(seed))
    number, middle, width = random_bands(lowest, highest, count, random)
    energy = density(middle) * width
    amplitude = deviation * np.sqrt(2.0 * energy / energy.sum())
    return Sines(amplitude, TURN * number, TURN * random.random((rows, int(count))))
