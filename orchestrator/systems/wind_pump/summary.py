"""Water, energy and starts of the wind pumps of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.analysis.signals import accumulated
from ...harness.summary import Summary, rows
from ...run.key_results import after_transient
from . import WindPumpKeys
from .records import Chain, chains, efficiencies, runnings, wind_energy

if TYPE_CHECKING:
    from ...run.results import Result

TEXTS = {
    "water": ("m3", "water that the pump moved, integral of its flow"),
    "aerodynamic_energy": ("J", "energy of the wind on the rotor"),
    "turbine_shaft_energy": ("J", "energy from the turbine into the transmission"),
    "pump_shaft_energy": ("J", "energy from the transmission into the pump"),
    "hydraulic_energy": ("J", "energy from the pump into the water"),
    "transmission_efficiency": ("1", "share of the turbine's energy that reaches the pump, what is stored in motion included"),
    "mean_power_coefficient": ("1", "energy on the rotor over that of the wind through its area"),
    "starts": ("1", "times the pump began to run"),
    "running_share": ("%", "share of the time in which the pump ran"),
}
HEADLINE = ("water", "transmission_efficiency", "mean_power_coefficient", "starts")  # what a run is judged by


def summary(result: Result) -> Summary:
    """Of every wind pump whose pump speed was recorded, after the transient."""
    start = after_transient(result).start
    keys = result.scene.analysis_as(WindPumpKeys)
    return tuple(row for c in chains(result) for row in rows(c.name, _numbers(result, c, start, keys), TEXTS))


def _numbers(result: Result, chain: Chain, start: int, keys: WindPumpKeys) -> dict[str, float | None]:
    time = chain.time[start:]
    energies = {stage: energy for stage, energy, _ in efficiencies(chain, start)}
    runs = runnings(chain, keys.standstill, keys.pause)
    begin, end = float(time[0]), float(time[-1])
    ran = sum(max(0.0, (end if r.end is None else r.end) - max(begin, begin if r.begin is None else r.begin)) for r in runs)
    flow, wind = chain.signals.get("flow"), wind_energy(result, chain, start)
    on_rotor, into, out = energies.get("aerodynamic"), energies.get("turbine_shaft"), energies.get("pump_shaft")
    return {
        "water": None if flow is None else float(accumulated(time, flow[start:])[-1]),
        **{f"{stage}_energy": energy for stage, energy in energies.items()},
        "transmission_efficiency": out / into if into and out is not None and into > 0.0 else None,
        "mean_power_coefficient": on_rotor / wind if on_rotor is not None and wind else None,
        "starts": float(sum(r.begin is not None for r in runs)),
        "running_share": 100.0 * ran / (end - begin),
    }
