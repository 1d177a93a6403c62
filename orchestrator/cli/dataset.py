"""Data sets of simulated records, for those who train and test diagnosis."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from .common import FAILED_RUN, app, print_table
from .many import Jobs, Scheduler, stopped_early

dataset = typer.Typer(no_args_is_help=True, rich_markup_mode=None, help="Data sets of simulated records.")
app.add_typer(dataset, name="dataset")


@dataset.callback()
def _group() -> None:
    """Data sets of simulated records."""


@dataset.command("bearing-faults")
def bearing_faults(
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the records, labels.csv and the runs.")] = Path(
        "bearing-faults"
    ),
    individuals: Annotated[int, typer.Option("--individuals", help="Bearings of each class; each is in one part only.")] = 5,
    duration: Annotated[float, typer.Option("--duration", help="Length of a record, s; 0.25 or more.")] = 1.0,
    conditions: Annotated[int, typer.Option("--conditions", help="Of the four speeds and loads, how many.")] = 4,
    rate: Annotated[float, typer.Option("--rate", help="Samples a second.")] = 12_000.0,
    resonance: Annotated[float, typer.Option("--resonance", help="Of the structure between bearing and sensor, Hz.")] = 3_000.0,
    snr: Annotated[float, typer.Option("--snr", help="Ratio of signal to noise, dB.")] = 30.0,
    run_up: Annotated[bool, typer.Option("--run-up", help="A run-up beside every steady record.")] = False,
    layout: Annotated[str, typer.Option("--layout", help="cwru or paderborn.")] = "cwru",
    seed: Annotated[int, typer.Option("--seed")] = 1,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
) -> None:
    """Healthy, outer, inner, ball, cage and combined faults. Example: cosimo dataset bearing-faults --individuals 5 -o faults"""
    from ..output import locked
    from ..systems.bearings.fault_check import check
    from ..systems.bearings.fault_data import Sensor, fault_data

    sensor = Sensor(rate=rate, resonance=resonance, snr=snr)
    with locked(output):
        records, runs = fault_data(
            output,
            individuals=individuals,
            duration=duration,
            seed=seed,
            run_up=run_up,
            conditions=conditions,
            sensor=sensor,
            layout=layout,
            jobs=jobs,
            scheduler=scheduler,
            progress=True,
        )
    stopped_early(runs, runs.outcomes.count("not run"))
    parts = {part: sum(r.part == part for r in records) for part in ("train", "validation", "test")}
    print(f"{len(records)} records ({', '.join(f'{n} {p}' for p, n in parts.items())}); wrote {output / 'labels.csv'}")
    if layout == "cwru" and find_spec("sklearn") is not None:
        result = check(output, sensor)
        names = list(next(iter(result.by_label.values())))
        print_table("Medians", ["label", *names], [(label, *row.values()) for label, row in result.by_label.items()])
        print(
            f"a random forest labels {100.0 * result.accuracy:.0f} % of {result.records} test records right "
            f"(by chance {100.0 * result.chance:.0f} %)"
        )
    if failed := [o for o in runs.outcomes if o != "done"]:
        print(f"cosimo: {len(failed)} runs failed: {failed[0]}", file=sys.stderr)
        raise SystemExit(FAILED_RUN)
