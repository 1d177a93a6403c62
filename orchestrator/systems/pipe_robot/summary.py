"""Way, mean speed, modes of the friction and energy per metre of the pipe robots of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.summary import Summary, rows
from ...run.key_results import after_transient
from .records import RobotRecord, energies, robots, shares, steady_speed, switches

if TYPE_CHECKING:
    from ...run.results import Result

TEXTS = {
    "way": ("m", "way after the transient"),
    "mean_speed": ("m/s", "mean speed after the transient, in whole periods of the exciter"),
    "rest_share": ("%", "share of the recorded samples at rest"),
    "switches_per_second": ("1/s", "changes of the friction's direction among the recorded samples"),
    "exciter_energy": ("J", "energy that the exciter gave after the transient"),
    "lost_energy": ("J", "energy lost after the transient"),
    "energy_per_metre": ("J/m", "energy of the exciter over the way"),
}
HEADLINE = ("mean_speed", "rest_share", "energy_per_metre")  # what a run is judged by


def summary(result: Result) -> Summary:
    """Of every robot whose position and velocity were recorded."""
    kept = after_transient(result)
    return tuple(row for r in robots(result) for row in rows(r.unit, _numbers(r, kept), TEXTS))


def _numbers(record: RobotRecord, kept: slice) -> dict[str, float | None]:
    x, flows = record.signals["position"][kept], energies(record, kept)
    way = float(x[-1] - x[0])
    given = flows.get("exciter")
    return {
        "way": way,
        "mean_speed": steady_speed(record, kept),
        "rest_share": 100.0 * shares(record, kept)[0],
        "switches_per_second": switches(record, kept),
        "exciter_energy": given,
        "lost_energy": flows.get("lost"),
        "energy_per_metre": given / way if given is not None and way > 0.0 else None,
    }
