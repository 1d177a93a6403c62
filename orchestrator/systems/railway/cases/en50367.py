"""Rules for contact force, uplift and arcing, applied to the runs of the reference models."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING, cast

from .....components.railway.pantograph import Pantograph
from ....harness.validation import Evidence, Runs
from ....harness.validation.limits_of_run import Rules
from ....harness.validation.reference import Row, TableRow, compare, load_table
from .. import RailwayKeys
from ..records import measured, of_each, passages, statistics, wave_speed
from ..runs import KMH, ac_simple_run, numbers, reference_run, target_mean

if TYPE_CHECKING:
    from ....run.results import Result
    from ....scene.scene import Scene

SLOW, FAST = 200.0, 250.0  # km/h, where other rules begin
MEAN_LESS = frozenset(
    {
        "mean_less_target",
        "mean_less_upper",
        "mean_less_lower",
        "mean_less_target_3kv",
        "mean_less_target_1500v",
        "mean_less_fast_1500v",
    }
)
ABOUT = {  # what a figure of the summary is judged by
    **dict.fromkeys(MEAN_LESS, "mean"),
    "std_over_mean": "std",
    "loss_gaps": "arcing",
}


def measure(runs: Runs) -> Evidence:
    """Every rule on every run; the rows' condition names the run."""
    table = load_table("en50367")
    cases = [(f"EN 50318:2018 AC simple, {v:g} km/h", v, ac_simple_run(v, runs.options)[0]) for v in (275.0, 320.0)]
    cases += [(f"EN 50318:2002, {v:g} km/h", v, reference_run(v, runs.options)) for v in (250.0, 300.0)]
    rows: list[Row] = []
    uplifts = []
    for name, speed, result in cases:
        rules = table.under("AC above 200 km/h") + table.under(
            "AC above 200, up to 250 km/h" if speed <= 250.0 else "AC above 250 km/h"
        )
        rows += compare(tuple(_under(r, name) for r in rules), measures(result))
        uplift = numbers(result)["uplift_mm"]
        uplifts.append((name, uplift, 2.0 * uplift, 1.5 * uplift))
    settings = {name: statistics(result).settings for name, _, result in cases}
    return Evidence(rows=tuple(rows), settings=settings, data={"uplifts": uplifts})


def _under(row: TableRow, condition: str) -> TableRow:
    return replace(row, condition=condition)


def measures(result: Result) -> dict[str, float]:
    """What the rules are about, of each pantograph, see `of_each`, by the rows' measures; no speed ratio where the catenary does not
    say what its wire is."""
    return of_each(result, lambda i: _measures(result, i))


def rules(result: Result) -> list[Rules]:
    """The conditions that hold for each pantograph of a run, by its speed and the supply of the line, and its numbers.

    A pantograph with two strips or under two wires is judged as a whole.
    """
    supply = result.scene.analysis_as(RailwayKeys).supply
    return [
        Rules(passage.pantograph, conditions(supply, passage.speed / KMH), _measures(result, i), ABOUT, MEAN_LESS)
        for i, passage in enumerate(passages(result))
        if not passage.part
    ]


def scene_conditions(scene: Scene, varied: Collection[str]) -> tuple[str, ...]:
    """Those with rows that hold for the speed that a scene sets; none where its pantographs have several, or one varies."""
    units = [name for name, cls in scene.component_classes.items() if issubclass(cls, Pantograph)]
    default = cast(float, Pantograph.variables["speed"].start)
    speeds = {float(scene.units[unit].parameters.get("speed", default)) for unit in units}
    changed = {name for name in varied if name.rpartition(".")[2] in ("speed", "supply", "acceleration")}
    if len(speeds) != 1 or changed or any(scene.coupling.interfaces[unit].effects["acceleration"] for unit in units):
        return ()
    held = conditions(scene.analysis_as(RailwayKeys).supply, speeds.pop() / KMH)
    known = {row.condition for row in load_table("en50367").rows}
    return tuple(condition for condition in held if condition in known)


def conditions(supply: str, speed: float) -> tuple[str, ...]:
    """Conditions of the table for a supply at a speed in km/h; some of them may have no row."""
    slow = round(speed, 3) <= SLOW
    if supply != "AC":
        return (f"{supply} up to {SLOW:g} km/h" if slow else f"{supply} above {SLOW:g} km/h", f"contact loss with {supply}")
    if slow:
        return (f"AC up to {SLOW:g} km/h",)
    arcing = f"AC above {SLOW:g}, up to {FAST:g} km/h" if round(speed, 3) <= FAST else f"AC above {FAST:g} km/h"
    return (f"AC above {SLOW:g} km/h", arcing)


def _measures(result: Result, pantograph: int) -> dict[str, float]:
    s, passage = statistics(result, pantograph=pantograph), passages(result)[pantograph]
    speed = passage.speed / KMH
    wave = wave_speed(result, passage.catenary)
    ratio = {"speed_ratio": passage.speed / wave} if wave else {}
    return (
        measured(s)
        | ratio
        | {
            "mean_less_target": s.mean - target_mean(speed),
            "mean_less_upper": s.mean - (0.00047 * speed**2 + 90.0),
            "mean_less_lower": s.mean - (0.00047 * speed**2 + 60.0),
            "mean_less_target_3kv": s.mean - target_mean(speed, 110.0),
            "mean_less_target_1500v": s.mean - target_mean(speed, 140.0),
            "mean_less_fast_1500v": s.mean - (0.00228 * speed**2 + 90.0),
            "std_over_mean": s.std / s.mean,
            "loss_gaps": s.arcing,
        }
    )
