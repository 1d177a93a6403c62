"""What a page that computes a wind pump shows: water, efficiency, starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.explore.figures import LiveFigure
from . import WindPumpKeys
from .records import Chain, chains
from .summary import TEXTS

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every wind pump whose pump speed was recorded, after the transient, as in the summary."""
    return tuple(f for chain in chains(result) for f in _figures(result, chain))


def _figures(result: Result, chain: Chain) -> list[LiveFigure]:
    transmission, turbine = RecordedUnit(result, chain.name), RecordedUnit(result, chain.turbine)
    pump, keys = transmission.driven_by("load_torque"), result.scene.analysis_as(WindPumpKeys)
    begin, rows = result.scene.analysis.transient, []

    def figure(name: str, signals: tuple[str, ...], kind: str = "integral", **more: object) -> LiveFigure | None:
        unit, text = TEXTS.get(name, ("1", name))
        combine = "product" if len(signals) > 1 else ""
        return LiveFigure(f"{chain.name}.{name}", text, unit, signals, kind, combine=combine, transient=begin, **more)  # type: ignore[arg-type]

    if pump is not None and (flow := pump.column("flow")):
        rows.append(figure("water", (flow,)))
    into = transmission.column("turbine_torque"), transmission.column("turbine_speed")
    out = transmission.column("load_torque"), transmission.column("speed")
    if all((*into, *out)):
        rows.append(figure("transmission_efficiency", out, over=figure("turbine_shaft_energy", into)))
    wind, power = turbine.column("wind"), turbine.column("power")
    if wind and power:  # of the air that would have passed the rotor's area
        area = (f"{chain.turbine}.density", 1.0), (f"{chain.turbine}.radius", 2.0)
        air = figure("wind_energy", (wind,) * 3, factor=0.5 * np.pi, powers=area)
        rows.append(figure("mean_power_coefficient", (power,), over=air))
    rows.append(figure("starts", (out[1],), "starts", limits=(keys.standstill, keys.pause)))
    if transmission.has("stresses.crank_pin_force"):
        pin = f"{chain.name}.stresses.crank_pin_force"
        rows.append(
            LiveFigure(f"{chain.name}.crank_pin_force", "largest force on the crank pin", "N", (pin,), "maximum", transient=begin)
        )
    return [row for row in rows if row is not None]
