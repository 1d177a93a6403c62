"""How far and how fast the robots came, how often friction switched, and where the energy went."""

from __future__ import annotations

from collections.abc import Sequence

from ....harness.charts.blocks import Cells
from ....harness.charts.style import number
from ..records import RobotRecord, energies, shares, steady_speed, switches

PERCENT = 100.0
ENERGIES = {"exciter": "exciter gave, J", "lost": "lost, J", "lifted": "lifted its weight, J", "towed": "pulled a load, J"}


def travel_table(records: Sequence[RobotRecord], kept: slice) -> Cells:
    """Way, mean speed and the modes of the friction after the transient."""
    rows = []
    for r in records:
        x = r.signals["position"][kept]
        share = shares(r, kept)
        numbers = (float(x[-1] - x[0]), steady_speed(r, kept), *(PERCENT * share[m] for m in (1, 0, -1)), switches(r, kept))
        rows.append((r.unit, *(number(v) for v in numbers)))
    header = ("robot", "way, m", "mean speed, m/s", "forwards, % of the time", "at rest, %", "backwards, %", "switches, 1/s")
    text = "After the transient. Modes and switches are those of the recorded samples; what happens in between is not counted."
    return Cells("Travel", header, rows, text, frozenset(range(1, len(header))))


def energy_table(records: Sequence[RobotRecord], kept: slice) -> Cells | None:
    """Energies after the transient, and what a metre costs; None where no power was recorded."""
    known = [(r, energies(r, kept)) for r in records]
    names = [n for n in ENERGIES if any(n in e for _, e in known)]
    if not names:
        return None
    rows = []
    for r, e in known:
        x = r.signals["position"][kept]
        way = float(x[-1] - x[0])
        cost = number(e["exciter"] / way) if "exciter" in e and way > 0.0 else ""
        rows.append((r.unit, *(number(e[n]) if n in e else "" for n in names), cost))
    header = ("robot", *(ENERGIES[n] for n in names), "exciter a metre, J/m")
    text = "Integrals of recorded powers after the transient. What is missing is in motion and springs, or between the samples."
    return Cells("Energy", header, rows, text, frozenset(range(1, len(header))))
