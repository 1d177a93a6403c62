"""A run of a scene with tangents, from its start to its end: the derivatives of all signals by parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..engine.stepping.loop import lengths
from ..run.results import Result
from ..run.run_record import RunRecord, UnitRecord
from ..scene.names import displaced
from .tangent_block import TangentBlock


class TangentRows(NamedTuple):
    """Signals at the start and behind each macro step, with their derivatives.

    time: (n,) s; values: (n, S); tangents: (n, S, d); at_tie: (d,) of each direction whether a decision stood at its boundary.
    """

    time: np.ndarray
    values: np.ndarray
    tangents: np.ndarray
    at_tie: np.ndarray


def tangent_run(block: TangentBlock, parameters: Sequence[str]) -> TangentRows:
    """All macro steps, with the derivatives of all signals by each parameter, as many as wanted; raises `StepFailed`."""
    cells = block.places(parameters)
    parts = [_pass(block, some.stop - some.start) for some in block.starts(cells)]
    tangents, at_tie = (np.concatenate(of, axis=-1) for of in ([p.tangents for p in parts], [p.at_tie for p in parts]))
    return TangentRows(parts[0].time, parts[0].values, tangents, at_tie)


def _pass(block: TangentBlock, d: int) -> TangentRows:
    """On from the start, with the tangents of so many directions."""
    scene, clock = block.scene, block.clock
    block.end_at(scene.stop_time)
    times, tick = [np.array([scene.start_time])], 0
    values, tangents = [block.cells[None, block.table]], [block.tangents[None, block.table]]
    for length, count in lengths(0, clock.tick(scene.stop_time), clock.ticks(scene.master.step), last=True):
        at = clock.times(range(tick, tick + (count + 1) * length, length))
        for some, by in block.along(at[:-1], clock.time(length) - clock.time(0)):
            values.append(some.copy())
            tangents.append(by.copy())
        times.append(at[1:])
        tick += count * length
    return TangentRows(np.concatenate(times), np.concatenate(values), np.concatenate(tangents)[:, :, :d], block.at_tie()[:d])


def beside(block: TangentBlock, parameter: str, way: float) -> TangentRows:
    """As `tangent_run` by one parameter, so far from its value: close to a boundary, the derivatives are those of this side."""
    value = block.value(parameter)
    block.set({parameter: value + way})
    try:
        return tangent_run(block, [parameter])
    finally:
        block.set({parameter: value})


def recorded(
    block: TangentBlock, point: Mapping[str, float], parameters: Sequence[str]
) -> tuple[Result, list[dict[str, np.ndarray]], np.ndarray]:
    """The run with other numbers, by name; of each parameter the tangents (n,) of its columns, and whether it was at a tie.

    It is what figures need of a run: `info` has the parameters of the units. Raises `StepFailed`.
    """
    scene = block.scene
    block.set(point)
    rows = tangent_run(block, parameters)
    since, interval = rows.time - scene.start_time, scene.record.interval or scene.master.step
    passed = np.floor(since / interval * (1.0 + 1e-12) + 1e-9)
    kept = np.flatnonzero([True, *(np.diff(passed[:-1]) > 0.0), True])
    ends = scene.coupling.signals
    names = [".".join(end) for end in ends]
    some = np.ix_(kept, np.array([block.signals.index(end) for end in ends]))
    values = {u.name: u.component.parameters for u in block.layout.units}
    parts = {unit: {n: point.get(f"{unit}.{n}", v) for n, v in own.items()} for unit, own in values.items()}
    result = Result(
        displaced(scene, point),
        rows.time[kept],
        dict(zip(names, rows.values[some].T, strict=True)),
        {},
        {name: scene.coupling.interfaces[unit].outputs[n].unit for name, (unit, n) in zip(names, ends, strict=True)},
        RunRecord(outcome="done", units={unit: UnitRecord(parameters=own) for unit, own in parts.items()}),
    )
    of_each = np.moveaxis(rows.tangents[some], 2, 0)
    return result, [dict(zip(names, t.T, strict=True)) for t in of_each], rows.at_tie
