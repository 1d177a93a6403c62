"""A pump's own curves at its rated speed: head and power over the flow, from a table."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.columns import table_of
from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from ..core.table_curve import curve_at, read_curve, refuse_order, sloped_rates


@kernel_tuple
class PumpCurves(NamedTuple):
    """At n flows from 0, ascending, m³/s: `powers` at the shaft, W, and their rates, (n,).

    By the same rows upwards from the last, `heads`, ascending, m, with the flows there and their rates, (n,). `efficiencies`, (n,), are
    0 where the table has powers.
    """

    flows: Any
    powers: Any
    power_rates: Any
    efficiencies: Any
    heads: Any
    head_flows: Any
    head_rates: Any


def pump_curves(text: str, where: str) -> PumpCurves:
    """The curves of a table as `CurveTable` describes it; what `prepare` computes is 0 still. Raises `BadInput`."""
    columns = table_of(text, where)
    there = [name for name in ("power", "efficiency") if columns.place(name) is not None]
    if len(there) != 1:
        raise BadInput(
            where,
            f"columns {', '.join(map(repr, columns.header))}",
            "flow, head, and one of power and efficiency, each with its unit",
        )
    table, (flow, head, third) = read_curve(
        text, where, {"flow": "m3/s", "head": "m", there[0]: "W" if there[0] == "power" else "1"}
    )
    refuse_order(head, table, "head", falling=True)
    if flow[0] != 0.0 or head[-1] < 0.0:
        raise BadInput(
            where, f"flows from {flow[0]:g} m3/s and heads to {head[-1]:g} m", "a flow of 0 first, and heads of 0 or more"
        )
    empty, efficiencies = np.zeros_like(flow), np.zeros_like(flow)
    if there[0] == "efficiency":
        if flow.size < 3 or third[1:].min() <= 0.0 or third.max() > 1.0:
            raise BadInput(
                where, f"efficiencies {third.tolist()}", "three rows or more, above 0 where water flows, and at most 1 (100 %)"
            )
        efficiencies[1:] = third[1:]
    powers = third.copy() if there[0] == "power" else empty.copy()
    return PumpCurves(flow, powers, empty.copy(), efficiencies, head[::-1].copy(), flow[::-1].copy(), empty.copy())


@kernel
def prepare(curves, weight):
    """Powers where efficiencies are given, and rates of the cubics; weight: rho g, N/m³."""
    n = curves.flows.size
    if curves.efficiencies[1] > 0.0:
        for i in range(1, n):
            curves.powers[i] = weight * curves.heads[n - 1 - i] * curves.flows[i] / curves.efficiencies[i]
        slope = (curves.powers[2] - curves.powers[1]) / (curves.flows[2] - curves.flows[1])
        curves.powers[0] = curves.powers[1] - slope * curves.flows[1]
    sloped_rates(curves.flows, curves.powers, curves.power_rates)
    sloped_rates(curves.heads, curves.head_flows, curves.head_rates)


@kernel
def operating_point(n, head, curves):
    """Flow, m³/s, and head of the curve at it, m, at the relative speed n against a head, m; power at the rated speed, W.

    Without flow the head is that against the closed valve.
    """
    last = curves.flows.size - 1
    rated = head / (n * n) if n > 0.0 else curves.heads[last]  # the head as the rated speed would have it
    if not rated < curves.heads[last]:
        return 0.0, n * n * curves.heads[last], curves.powers[0]
    flow = curve_at(rated, curves.heads, curves.head_flows, curves.head_rates)
    power = curve_at(flow, curves.flows, curves.powers, curves.power_rates)
    if rated < curves.heads[0]:
        more = curves.head_rates[0] * (rated - curves.heads[0])
        flow, power = flow + more, power + curves.power_rates[last] * more
    return n * flow, n * n * rated, power
