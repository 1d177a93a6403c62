"""EN 50318:2018, AC simple catenary: against ranges that are only recalled."""

from __future__ import annotations

from ....harness.validation.case import Case, Findings, Options, Row, compare
from ....harness.validation.reference import load_table
from ....results import Result
from ..records import statistics
from ..runs import ac_simple_run, numbers, target_mean

SPEEDS = (275.0, 320.0)  # km/h


def findings(options: Options) -> Findings:
    """Both speeds with the mean force set by the static force."""
    table = load_table("en50318-2018-ac-simple")
    runs: dict[str, Result] = {}
    rows: list[Row] = []
    notes: list[str] = []
    for v in SPEEDS:
        name = f"{v:g} km/h"
        runs[name], static_force, trial = ac_simple_run(v, options)
        if runs[name].outcome != "done":
            return Findings((), runs, notes=(runs[name].message,), complete=False)
        rows += compare(table.under(name), numbers(runs[name]))
        notes.append(
            f"At {name} the static force was set to {static_force:.1f} N, from one trial run whose mean was {trial:.1f} N, to "
            f"bring "
            f"the mean to {target_mean(v):.1f} N (0.00097 v² + 70); the run's own mean is {numbers(runs[name])['mean']:.1f} N. "
            "That row is set, not found."
        )
    inside = [f"{r.reference.quantity} at {r.reference.condition}" for r in rows if not r.inside]
    notes.append("Outside the recalled ranges: " + ("; ".join(inside) if inside else "none") + ".")
    notes.append(
        "At 320 km/h the ranges of the contact point's height and of the uplift are left out: what is recalled contradicts "
        "itself."
    )
    return Findings(tuple(rows), runs, notes=tuple(notes), settings={n: statistics(r).settings for n, r in runs.items()})


CASE = Case(
    "en50318-2018-ac-simple",
    "EN 50318:2018, AC simple catenary",
    "Runs the AC simple catenary with the three-mass pantograph at 275 and 320 km/h. The model data are read in public "
    "sources but for "
    "the steady arm and the order of the dampers; the ranges are recalled. So this shows where the model stands beside what is "
    "remembered of the table, and is no evidence of conformance to the standard.",
    "railway",
    findings,
)
