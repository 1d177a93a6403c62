"""Orbits of the shaft in windows of time, and the forces of its bearings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import RotorRecord

MICRO = 1e6
RPM = 30.0 / np.pi


def orbits_chart(record: RotorRecord, windows: Sequence[tuple[float, float]], who: str = "") -> list[Chart]:
    """For every window (from, to) in s the orbits at the watched place and at the bearings, all in one scale each."""
    places = {"watched place": record.signals} | {p.replace("_", " "): s for p, s in record.ports.items()}
    places = {name: s for name, s in places.items() if {"x", "y"} <= s.keys()}
    charts = []
    for start, end in windows:
        kept = (record.time >= start) & (record.time <= end)
        if not places or kept.sum() < 2:
            continue
        panels = []
        for name, s in places.items():
            x, y = MICRO * s["x"][kept], MICRO * s["y"][kept]
            series = (Series("orbit", x, y), Series("begin", x[:1], y[:1], "points"))
            panels.append(Panel("y, µm", series, title=name, x_label="x, µm", equal=True))
        speed = RPM * record.signals["speed"][kept]
        turning = f"{speed.mean():.0f} rpm" if np.ptp(speed) < 1.0 else f"{speed[0]:.0f} to {speed[-1]:.0f} rpm"
        text = f"{start:.4g} to {end:.4g} s, {turning}. x horizontal, y upwards; the same scale in both directions."
        charts.append(Chart(f"{who}Orbits", "", tuple(panels), text, columns=max(2, len(panels)), height=340))
    return charts


def forces_chart(record: RotorRecord, begin: float, who: str = "") -> Chart:
    """Forces of the bearings on the shaft, and the load of the most loaded ball, over the whole run."""
    mark = ((begin, ""),) if begin > record.time[0] else ()
    panels = []
    for port, s in record.ports.items():
        series = [Series(n[-1], record.time, s[n]) for n in ("force_x", "force_y") if n in s]
        series += [Series("most loaded ball", record.time, s["max_ball_load"])] if "max_ball_load" in s else []
        if series:
            panels.append(Panel("force, N", tuple(series), title=port.replace("_", " "), x_marks=mark))
    return Chart(f"{who}Forces of the bearings", "time, s", tuple(panels), "On the shaft; x horizontal, y upwards.", height=240)
