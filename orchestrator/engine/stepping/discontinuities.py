"""Signals of tables that jump: macro steps end there, and behind them the units that take the signals go by the values behind.

A step that ends at a jump ends with the values before it, which inputs are interpolated to; then the table is updated, what follows
within the instant follows, and inputs that have jumped begin their samples anew, as where faults begin or end.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ...settings import SceneSettings
from ...units.kinds import kinds_of
from ..algorithms import Master
from .clock import Clock
from .faults import edges
from .loop import Action

NEAR = 1e-9  # of a macro step: rounding of a time that is a multiple of it


def jump_times(scene: SceneSettings, end: float | None = None) -> list[float]:
    """Times up to `end`, by default of the run, s, at which a step has to end because signals of tables jump, in their order.

    Held signals are discrete: they jump at the ends of steps as those of sampled controllers do. Where all steps are equal and end
    at all of these times, none is here.
    """
    stops: set[float] = set()
    held: set[float] = set()
    for kind in kinds_of(scene.units).values():
        (held if kind.holds else stops).update(kind.jump_times(scene.start_time, scene.stop_time if end is None else end))
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
    """Warnings of units of which macro steps miss something."""
    texts = {name: kind.missed(scene.master.step) for name, kind in kinds_of(scene.units).items()}
    return [f"{name}: {text}" for name, text in texts.items() if text]


def stops_of(scene: SceneSettings, master: Master, clock: Clock) -> dict[int, list[Action]]:
    """Ticks at which signals jump, each with what has to be done there."""
    return {clock.tick(t): [partial(_jump, master, t)] for t in jump_times(scene)}


def _jump(master: Master, t: float) -> None:
    master.records.call("begin_change", t)
    master.let_jump(t)
    master.follow(t)
    master.records.call("end_change", t)
