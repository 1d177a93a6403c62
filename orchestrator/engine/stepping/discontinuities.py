"""Signals of tables that jump: macro steps end there, and behind them the units that take the signals go by the values behind.

A step that ends at a jump ends with the values before it, which inputs are interpolated to; then the table is updated, what follows
within the instant follows, and inputs that have jumped begin their samples anew, as where faults begin or end.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ....components.core.signals import LOOKED_AT
from ...settings import SceneSettings
from ...units.component import table_of
from ..algorithms import Master
from .clock import Clock
from .faults import edges
from .loop import Action

MISSED = 0.01  # of a signal's deviation, rms: what steps may miss of it without a warning
NEAR = 1e-9  # of a macro step: rounding of a time that is a multiple of it


def jump_times(scene: SceneSettings, end: float | None = None) -> list[float]:
    """Times up to `end`, by default of the run, s, at which a step has to end because signals of tables jump, in their order.

    Held signals are discrete: they jump at the ends of steps as those of sampled controllers do. Where all steps are equal and end
    at all of these times, none is here.
    """
    stops: set[float] = set()
    held: set[float] = set()
    for unit in scene.units.values():
        if unit.signals:
            last = scene.stop_time if end is None else end
            times = table_of(unit).jump_times(unit.parameters, scene.start_time, last)
            (held if unit.parameters.get("interpolation") == "hold" else stops).update(times)
    if held and (
        scene.master.control
        or scene.master.events
        or between_steps(scene, [*stops, *held, *edges(scene.faults, scene.start_time)])
    ):
        stops |= held
    return sorted(stops)


def between_steps(scene: SceneSettings, times: Sequence[float]) -> list[float]:
    """Those of some times, s, that are no multiples of the macro step behind the start."""
    every = np.array(times)
    steps = (every - scene.start_time) / scene.master.step
    return every[np.abs(steps - np.round(steps)) > NEAR * np.maximum(np.abs(steps), 1.0)].tolist()


def missed(scene: SceneSettings) -> list[str]:
    """Warnings of tables whose rows lie closer than the macro steps, where straight lines from step to step miss something of them."""
    texts = []
    step = scene.master.step
    for name, unit in scene.units.items():
        if not unit.signals or unit.parameters.get("interpolation") == "hold":
            continue
        rows = table_of(unit).table[:LOOKED_AT]
        spacing = float(np.median(np.diff(rows[:, 0]))) if len(rows) > 1 else step
        if not 0.0 < spacing < 0.999 * step:
            continue
        times = rows[:, 0]
        ends = np.arange(times[0], times[-1] + step, step)
        at_jumps = np.floor((times[1:][np.diff(times) == 0.0] - times[0]) / step)
        smooth = ~np.isin(np.floor((times - times[0]) / step), at_jumps)
        shares = {}
        for column, values in zip(table_of(unit).columns(), rows[:, 1:].T, strict=True):
            chords = np.interp(times, ends, np.interp(ends, times, values))
            if (deviation := float(np.std(values))) > 0.0:
                shares[column] = float(np.sqrt(np.mean(np.where(smooth, values - chords, 0.0) ** 2))) / deviation
        if shares and (share := max(shares.values())) > MISSED:
            worst = max(shares, key=shares.__getitem__)
            texts.append(
                f"{name}: {step / spacing:.3g} rows in a macro step of {step:g} s. Between the ends of its steps the scene goes by "
                f"straight lines, which miss {100.0 * share:.2g} % of the deviation of {worst}. "
                f"Reduce master.step, at most to {spacing:.3g} s"
            )
    return texts


def stops_of(scene: SceneSettings, master: Master, clock: Clock) -> dict[int, list[Action]]:
    """Ticks at which signals jump, each with what has to be done there."""
    return {clock.tick(t): [partial(_jump, master, t)] for t in jump_times(scene)}


def _jump(master: Master, t: float) -> None:
    master.records.call("begin_change", t)
    master.let_jump(t)
    master.follow(t)
    master.records.call("end_change", t)
