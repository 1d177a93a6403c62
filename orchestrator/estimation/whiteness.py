"""Whether numbers follow from earlier ones, at a level that is exact however few they are."""

from __future__ import annotations

import numpy as np

LEAST, LAGS = 8, 20  # numbers that are tested; distances at which a correlation is looked for


def white(e: np.ndarray) -> tuple[float, str]:
    """Probability of white normal noise to have a spectrum so uneven, and what is seen of numbers e, (n,).

    Ordinates of its periodogram are independent and exponential at every n, so that their cumulative shares are uniform order
    statistics (Kolmogorov-Smirnov, Bartlett 1955), and the largest share g of q ordinates has a probability of at most
    q (1 - g)^(q - 1) (Fisher 1929); recalled. The former sees a slope of the spectrum, the latter a line. The statistic of Ljung and
    Box has a heavier tail than its chi square: with 100 samples of 5 signals it exceeds the limit of 0.14 % in 1.5 %.
    """
    from scipy.stats import kstwo

    n = e.size
    power = np.abs(np.fft.rfft(e)[1 : (n - 1) // 2 + 1]) ** 2
    share, q = power / power.sum(), power.size
    below, k = np.cumsum(share)[:-1], np.arange(1, q)
    slope = float(kstwo.sf(max((k / (q - 1) - below).max(), (below - (k - 1) / (q - 1)).max()), q - 1))
    top = int(np.argmax(share))
    line = q * (1.0 - float(share[top])) ** (q - 1)
    if line < slope:
        return min(1.0, 2.0 * line), f"{share[top]:.0%} of their power has a period of {n / (top + 1):.3g} measurements"
    r = np.array([e[lag:] @ e[:-lag] for lag in range(1, min(LAGS, n // 2) + 1)]) / (e @ e)
    lag = int(np.argmax(np.abs(r))) + 1
    return min(1.0, 2.0 * slope), f"correlation {r[lag - 1]:+.2g} with the {_th(lag)} before"


def _th(n: int) -> str:
    return {1: "1st", 2: "2nd", 3: "3rd"}.get(n, f"{n}th")
