"""A chain as it is drawn: means over some seconds, and the ratio of the mean speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..records import Chain, Running, moving_mean, runnings

HOUR = 3600.0  # s
LONG = 2.0 * HOUR  # from here on the time is in hours
COEFFICIENTS = (-0.05, 0.6)  # of an axis, up to Betz's limit; a rotor that overruns a dying wind has any negative value


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
