"""The work of a run, counted: which repetitions a run gets follows from it, so from the scene, and never from a clock.

A time would be another one on every machine and under every load, and with it what a run prints. The work is

    sum over units of calls * size  +  hand-overs * `HAND_OVER`, or `PYTHON` where steps are not in compiled batches

calls: all that the unit counts (steps, derivatives, solutions of the wire, factorizations).  size: its states, at most `LARGEST`;
`FOREIGN` of what computes outside of our compiled kernels, as nobody can count what it does within a call. So an FMU that takes long
in each call is repeated like a quick one, and Ctrl-C or --no-verify ends that.

Beside measured CPU times of the 51 shipped scenes, 10 ns each, the model is off by a factor of 1.8 (rms of the logarithm).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from signal import Signals
from typing import TYPE_CHECKING, Any

from ..interrupts import Interrupted
from ..scene.scene import Scene
from ..units import Simulator
from .run_record import Counters
from .thresholds import BUDGET, PROBED, PROBED_STEPS

if TYPE_CHECKING:
    from .results import Result

LARGEST = 500  # states that count: of a long wire, most are at rest or in vectors
HAND_OVER = 50.0  # of a unit in a macro step, in compiled code
PYTHON = 1500.0  # the same through Python: iterations, step control, events, algebraic loops
ANEW = "iterations", "restores"  # of a master, which a process counts anew; its steps go on
FOREIGN = 2000.0  # a call of an FMU or of a component in plain Python


def of_calls(unit: Simulator, calls: float) -> float:
    """The work of so many calls of a unit that was initialized."""
    if unit.kernels is not None:
        return calls * min(max(unit.kernels.x.size, 1), LARGEST)
    return calls * FOREIGN


def calls_of(counters: Mapping[str, float]) -> int:
    """All that a unit has counted but messages to its worker process."""
    return sum(int(n) for name, n in counters.items() if name != "requests")


def macro_steps(counters: Counters) -> int:
    """Macro steps that were tried."""
    stepping = counters.stepping
    return int((stepping.accepted + stepping.rejected if stepping else 0) or counters.master["steps"])


def hand_overs(counters: Counters) -> int:
    """Macro steps, or iterations where there are more of them, times units."""
    return max(macro_steps(counters), int(counters.master.get("iterations", 0))) * len(counters.units)


def counted(units: Mapping[str, Simulator], counters: Counters, *, compiled: bool) -> float:
    """The work of a run that has ended; compiled: whether its steps were in batches of compiled code."""
    steps = sum(of_calls(unit, calls_of(counters.units[name])) for name, unit in units.items())
    return steps + hand_overs(counters) * (HAND_OVER if compiled else PYTHON)


def joined(counters: Counters, earlier: Mapping[str, Any], begun: Counters) -> Counters:
    """The counters of a run that went on from a checkpoint, with those before it.

    earlier: counters up to the checkpoint.  begun: those of the units and the master when they went on, which had counted their start.
    """
    units = {name: _sums(now, earlier["units"][name], begun.units[name]) for name, now in counters.units.items()}
    anew = [{key: one[key] for key in ANEW if key in one} for one in (counters.master, earlier["master"], begun.master)]
    return replace(counters, units=units, master={**counters.master, **_sums(*anew)})


def _sums(now: Mapping[str, Any], earlier: Mapping[str, Any], begun: Mapping[str, Any]) -> dict[str, Any]:
    sums = {key: now.get(key, 0) + earlier.get(key, 0) - begun.get(key, 0) for key in {**earlier, **now}}
    shortest = [one["shortest"] for one in (now, earlier) if "shortest" in one]
    return sums | ({"shortest": min(shortest)} if shortest else {})


def allows(work: float, times: float, budgets: float = 1.0) -> bool:
    """Whether runs that take so many times some work may be made without being asked for, within so many budgets of a run."""
    return times * work <= budgets * BUDGET


def shown(work: float, times: float, budgets: float = 1.0) -> str:
    """For messages: the work beside its limit."""
    return f"counted work {times * work:.2g}, of which {budgets * BUDGET:.2g} are done without being asked for"


def as_repeated(scene: Scene, in_process: bool) -> bool:
    """Whether a run has its units as a repetition would have them."""
    return in_process or not scene.component_classes


def to_count(scene: Scene) -> Scene:
    """The first part of a scene, whose work tells that of the whole."""
    return beginning(scene, min(max(PROBED * scene.duration, PROBED_STEPS * scene.master.step), scene.duration))


def from_part(part: Result, duration: float) -> float:
    """The work of a run of so many s; part: what was run of it. Raises `Interrupted` where a signal has stopped that."""
    if part.outcome == "stopped":
        raise Interrupted(Signals[part.info.signal])
    if (counted := part.info.counters.work) is None:
        raise ValueError("a part of a run whose work is not counted")
    return counted * duration / part.scene.duration


def beginning(scene: Scene, length: float) -> Scene:
    """The scene up to so many s after its start, without faults and tolerances; rows that are farther apart come at every macro step."""
    record = {
        f"record.{key}": scene.master.step
        for key in ("interval", "snapshot_interval")
        if (given := getattr(scene.record, key)) is not None and given > length
    }
    exact: dict[str, Any] = {f"units.{name}.tolerances": {} for name, unit in scene.units.items() if unit.tolerances}
    exact |= {"correlations": {}} if exact else {}
    return scene.with_changes({"stop_time": scene.start_time + length, "faults": [], **record, **exact})
