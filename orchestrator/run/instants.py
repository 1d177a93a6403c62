"""Values of a recorded signal between its rows."""

from __future__ import annotations

import numpy as np


def at_instants(instants: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m,) values of a signal (n,) with rising times (n,) at instants (m,) within them; exact on the rows, held beyond the ends.

    Cubic polynomials through four rows, of which the two nearest always are and the others are those about which the signal
    bends least: an error of h^4 where it is smooth, and no overshoot beside a jump or a kink, which stays within its own cell
    (essentially non-oscillatory interpolation: Harten, Engquist, Osher and Chakravarthy, J. Comput. Phys. 71 (1987) 231-303;
    from memory). Linear between rows that are no numbers.
    """
    linear = np.interp(instants, time, values)
    n = time.size
    if n < 4:
        return linear
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        slope = np.diff(values) / np.diff(time)
        second = np.diff(slope) / (time[2:] - time[:-2])
        third = np.diff(second) / (time[3:] - time[:-3])
        t = np.clip(instants, time[0], time[-1])
        cell = np.clip(np.searchsorted(time, t, side="right") - 1, 0, n - 2)
        start, added = cell, []
        for order, divided in ((2, second), (3, third)):
            left, right = np.maximum(start - 1, 0), np.minimum(start, n - 1 - order)
            to_left = (start > 0) & ((start > n - 1 - order) | (np.abs(divided[left]) < np.abs(divided[right])))
            start = np.where(to_left, left, right)
            added.append((divided[start], time[np.where(to_left, start, start + order)]))
        (bend, further), (twist, _) = added
        within = (t - time[cell]) * (t - time[cell + 1])
        cubic = values[cell] + slope[cell] * (t - time[cell]) + within * (bend + twist * (t - further))
    return np.where(np.isfinite(cubic) & (within != 0.0), cubic, linear)
