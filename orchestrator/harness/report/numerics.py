"""How a run was computed: its macro steps, iterations and loops, initial values, energy account, checkpoints and faults,
and how punctual it was at the pace of the clock.

What a scene does not use has no row, no table and no figure.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import counted
from ...engine.algorithms.energy import BondEnergy
from ...engine.algorithms.initial import InitializationResult
from ...run.run_record import SteppingRecord
from ...run.thresholds import ENERGY
from ...settings import IterationSettings, SceneSettings
from ..charts.blocks import Block, Cells, Facts, Text
from ..charts.chart import Chart, Grid, Panel, Series
from ..charts.charts import draw_chart
from ..charts.style import number
from ..summary import PACING
from .generic import grid_table
from .windows import fault_name

if TYPE_CHECKING:
    from ...run.results import Result

WIDE = 5.0  # longest over shortest step, from which the axis of the steps is logarithmic


def blocks(result: Result) -> list[Block]:
    """The facts of the run as a table, the length of its macro steps, and its energy account; none where none applies."""
    parts: list[Block] = []
    if rows := list(_rows(result)):
        parts.append(Facts("Solver statistics", rows))
    if (given := result.info.counters.stepping) and (steps := steps_chart(result, given)) is not None:
        parts.append(steps)
    parts += _pacing(result)
    if energy := result.info.energy:
        parts.append(energy_table(energy, result.scene))
    return parts


def _rows(result: Result) -> Iterator[tuple[str, str]]:
    """Names and values."""
    info = result.info
    master = info.counters.master
    for group in info.initial_values:
        if len(group.units) > 1:
            yield f"initial values of {', '.join(group.units)}", _initial_values(group)
    if stepping := info.counters.stepping:
        yield "macro steps", _steps(result, stepping)
        if result.scene.master.events or stepping.events:
            located = f"; located: {', '.join(result.scene.master.events)}" if result.scene.master.events else ""
            yield "events", f"{counted(stepping.events, 'step')} ended at one{located}"
        if stepping.restores:
            yield "units taken back", f"{_times(stepping.restores)}, to repeat a step or to make it in halves"
    if "iterations" in master:
        yield "iterations", _iterations(result, master)
    for text, loop in master.get("algebraic_loops", {}).items():
        yield (
            f"algebraic loop of {text}",
            (
                f"solved at {counted(loop['points'], 'instant')} with {counted(loop['evaluations'], 'evaluation')} and "
                f"{counted(loop['jacobians'], 'Jacobian')}; largest residual {loop['residual']:.2g} of a signal's size"
            ),
        )
    if past := info.resumed:
        yield "resumed", f"at {past.at:.6g} s, from a checkpoint; iterations, loops, work and time are counted from there"
    if kept := info.checkpoints:
        last = f", the last at {kept.last:.6g} s" if kept.written else ""
        yield "checkpoints", f"every {kept.every:g} s to {kept.to}: {kept.written} written{last}"
    for fault in result.scene.faults:
        end = "the end" if fault.end is None else f"{fault.end:g} s"
        yield "fault", f"{fault_name(fault)}, {fault.begin:g} s to {end}"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _initial_values(group: InitializationResult) -> str:
    text = f"converged in {counted(group.sweeps, 'sweep')}"
    if group.secants:
        text += f" and {counted(group.secants, 'quasi-Newton step')}"
    return f"{text}; relative change in the last one {group.residual:.2g}"


def _steps(result: Result, counts: SteppingRecord) -> str:
    kept = counts.accepted
    parts = [f"{kept} kept"]
    if result.scene.master.control is not None:
        parts.append(f"{counts.rejected} rejected for their error")
    if counts.failed:
        parts.append(f"{counts.failed} that a unit could not complete, repeated shorter")
    if counts.inaccurate:
        parts.append(f"{counts.inaccurate} kept with an error above the tolerance")
    if kept and result.info.timing is not None:
        parts.append(f"mean length {result.info.timing.simulated / kept:.3g} s")
    if counts.shortest is not None:
        parts.append(f"chosen between {counts.shortest:.3g} and {counts.longest:.3g} s")
    return ", ".join(parts)


def _iterations(result: Result, counts: Mapping[str, Any]) -> str:
    count, steps = counts["iterations"], counts["steps"]
    if not count:
        return "none: no units feed one another"
    text = f"{count}"
    if steps and result.info.resumed is None:
        text += f" in {counted(steps, 'step')}, {count / steps:.3g} a step"
        text += ", those of rejected steps among them" if result.info.counters.stepping else ""
    tolerance = (result.scene.master.iteration or IterationSettings()).tolerance
    if counts.get("unconverged_steps"):
        missed = counted(counts["unconverged_steps"], "step")
        return f"{text}; {missed} did not converge, worst residual {counts['worst_miss']:.2g}"
    return f"{text}; residual in every step that was kept at most {tolerance:g}, the tolerance"


def steps_chart(result: Result, counts: SteppingRecord) -> Block | None:
    """Length of the macro steps over time, where every one is recorded; said where it is not. None for a run without steps."""
    if result.scene.record.interval is not None:
        return Text(["For a chart of the macro step length, remove record.interval: every step must be recorded."], "note")
    lengths = np.diff(result.time)
    if not lengths.size:
        return None
    logarithmic = bool(lengths.max() > WIDE * lengths.min())
    steps = Series("macro step", np.repeat(result.time, 2)[1:-1], 1e3 * np.repeat(lengths, 2))
    panel = Panel("macro step, ms", (steps,), logarithmic=logarithmic)
    text = f"{counted(counts.accepted, 'step')} kept"
    text += f", of which {counts.events} ended at an event" if counts.events else ""
    text += f"; {counts.rejected} rejected." if result.scene.master.control is not None else "."
    if result.scene.faults:
        text += " A step ends where a fault begins or ends, too."
    return draw_chart(Chart("Length of the macro steps", "time, s", (panel,), text, height=200))


def energy_table(energy: Mapping[str, BondEnergy], scene: SceneSettings) -> Cells:
    """The energy that went through each bond, and the energy that the coupling created there."""
    rows = [
        (bond, number(e.exchanged), number(e.created), _percent(e.created / e.exchanged) if e.exchanged else "–")
        for bond, e in energy.items()
    ]
    text = (
        "Exchanged: the energy through the bond, in both directions together. Created: the difference between the energies of the "
        "two sides, which extrapolate their inputs. Above 0, the coupling has fed the system, as negative damping "
        "would; below 0, it has damped it. Residual: created over exchanged; it falls with the macro step, and above "
        f"{100.0 * ENERGY:g} % amplitudes are off by several per cent."
    )
    if scene.master.energy_correction:
        text += " The energy that a step has created is returned in the next ones; the numbers are the rest."
    if scene.faults:
        text += " Energy that a fault adds or takes at a bond counts as created, too, and so does that which a lost unit does not take."
    return Cells("Energy account", ("bond", "exchanged, J", "created, J", "residual"), rows, text, frozenset((1, 2, 3)))


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %".replace("-", "−")


def _pacing(result: Result) -> list[Block]:
    """Distribution of the durations and the lateness, and their percentiles; none of a run that did not keep to the clock."""
    of = result.info.real_time
    if of is None:
        return []
    edges = 1e3 * np.array(of.bins)
    x = np.repeat(edges, 2)[1:-1]
    step = 1e3 * result.scene.master.step
    series = tuple(
        Series(text, x, np.maximum(np.repeat(np.array(counts, dtype=float), 2), 0.5))
        for counts, text in ((of.duration_counts, "duration of a step"), (of.lateness_counts, "behind the clock"))
    )
    largest = max(of.duration["100 %"], of.lateness["100 %"], 1e-3 * step)
    panel = Panel("steps", series, x_marks=((step, "macro step"),), logarithmic=True, x_range=(0.0, 1.2e3 * largest))
    text = f"{of.steps} steps, {of.late} of them behind the clock. Ten bins in a decade; an empty bin is drawn at 0.5."
    chart = Chart("Steps at the pace of the clock", "ms", (panel,), text, height=260)
    columns = tuple(of.duration)
    waits = {"behind the clock when the wait ended": of.waking} if of.waking else {}
    percentiles = {PACING["duration"]: of.duration, PACING["lateness"]: of.lateness, **waits}
    rows = tuple((text, *(f"{1e3 * values[p]:.3g}" for p in columns)) for text, values in percentiles.items())
    return [draw_chart(chart), grid_table(Grid("Percentiles, ms", ("", *columns), rows))]
