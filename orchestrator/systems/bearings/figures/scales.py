"""Units in which the motion of a bearing is shown: those of a dimensional model made readable, or none."""

from __future__ import annotations

from dataclasses import dataclass

from ..records import BearingRecord

SHOWN = {"m": (1e6, "µm"), "m/s": (1e3, "mm/s"), "m/s2": (1.0, "m/s²"), "N": (1.0, "N")}


@dataclass(frozen=True)
class Scales:
    """Factors and names of units; time and frequency of a dimensionless bearing are in its own unit of time."""

    record: BearingRecord

    @property
    def dimensional(self) -> bool:
        """Whether the displacement has a unit."""
        return self.record.measures.get("displacement_x", "") not in ("", "1")

    @property
    def time(self) -> str:
        """Label of the time axis."""
        return "time, s" if self.dimensional else "time, 1"

    @property
    def frequency(self) -> str:
        """Label of a frequency axis."""
        return "frequency, Hz" if self.dimensional else "frequency, 1"

    @property
    def hertz(self) -> str:
        """Unit of a frequency in a sentence."""
        return " Hz" if self.dimensional else ""

    def factor(self, signal: str) -> float:
        """What a recorded signal is multiplied with to be in `unit`."""
        return SHOWN.get(self.record.measures.get(signal, ""), (1.0, ""))[0]

    def unit(self, signal: str) -> str:
        """The unit in which a signal is shown."""
        measure = self.record.measures.get(signal, "")
        return SHOWN.get(measure, (1.0, measure or "1"))[1]
