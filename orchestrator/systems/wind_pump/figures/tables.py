"""Starts and stops with their winds, and where the wind's energy goes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....harness.charts.blocks import Cells
from ....harness.charts.style import number
from ..records import efficiencies, wind_energy
from .shown import Shown, scale

if TYPE_CHECKING:
    from ....results import Result

MOST = 12  # rows of runs of one chain
NAMES = {
    "aerodynamic": "on the rotor",
    "turbine_shaft": "turbine to transmission",
    "pump_shaft": "transmission to pump",
    "hydraulic": "pump to water",
}


def runs_table(shown: Sequence[Shown]) -> Cells:
    """Every run of a pump: when it began and ended, and at which wind; times as in the figures, in s or h."""
    seconds, unit = scale(shown[0].chain.time)
    rows: list[tuple[str, ...]] = []
    for s in shown:
        for r in s.runs[:MOST]:
            begin, end = (None if at is None else at / seconds for at in (r.begin, r.end))
            cells = (begin, r.begin_wind, end, r.end_wind, r.turns)
            rows.append((s.chain.name, *("" if v is None else number(v) for v in cells)))
        if len(s.runs) > MOST:
            rows.append((s.chain.name, f"and {len(s.runs) - MOST} more", "", "", "", ""))
        if not s.runs:
            turned = float(np.max(s.chain.signals["pump_speed"])) > s.standstill
            rows.append((s.chain.name, "makes less than a turn" if turned else "never runs", "", "", "", ""))
    text = (f"A pump runs while its shaft is faster than {shown[0].standstill:g} rad/s and makes a turn or more; a "
            f"standstill of up to {shown[0].pause:g} s is none. Empty: it ran when the record began, or still did when it "
            "ended.")  # fmt: skip
    return Cells("Starts and stops", ("transmission", f"starts at, {unit}", "wind then, m/s", f"stops at, {unit}",
                                      "wind then, m/s", "turns"), rows, text, frozenset(range(1, 6)))  # fmt: skip


def efficiency_table(result: Result, shown: Sequence[Shown], start: int = 0) -> Cells:
    """Energy that passed every interface of each chain, and the share of it that came from the one before."""
    rows: list[tuple[str, ...]] = []
    for s in shown:
        wind = wind_energy(result, s.chain, start)
        if wind is not None:
            rows.append((s.chain.name, "wind through the rotor's area", number(1e-3 * wind), ""))
        for stage, energy, share in efficiencies(s.chain, start):
            share = energy / wind if stage == "aerodynamic" and wind else share
            rows.append((s.chain.name, NAMES[stage], number(1e-3 * energy), "" if share is None else number(100.0 * share)))
    text = ("Integrals of the recorded powers. What lacks between two stages was lost there, or is still in the motion of the "
            "shafts: over a short run that is no loss.")  # fmt: skip
    return Cells("Energy along the chain", ("transmission", "interface", "energy, kJ", "of the one before, %"), rows, text,
                 frozenset({2, 3}))  # fmt: skip
