"""State and parameters of a scene from measurements."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

from typer import Option

from ...components.core.errors import pick
from ..output import write_table
from .common import FAILED_CHECK, app, fail, print_cells, print_written, scene_of, status_spinner, warn
from .new import new
from .new_scene import File, write_new
from .options import AsJson, Changes, Output, Presets, SceneName, Step, reports

SAMPLES, NOISE = 400, 0.1  # of a new plan: about how many, and their noise as a share of the signal's standard deviation
PlanOfEstimate = Annotated[Path, Option(help="TOML file with the measured signals, and with what is not known.")]


@app.command()
@reports
def estimate(
    scene: SceneName,
    plan: PlanOfEstimate,
    output: Output = Path("estimate"),
    no_verify: Annotated[
        bool, Option("--no-verify", help="Without numerical errors, which another filter with half of all steps tells.")
    ] = False,
    step: Step = None,
    values: Changes = None,
    presets: Presets = None,
    jobs: Annotated[int | None, Option("--jobs", help="Threads for the runs of constants; default: one for each core.")] = None,
    as_json: AsJson = False,
) -> None:
    """State and parameters from noisy signals. Example: cosimo estimate scene.toml --plan plan.toml -o out

    Writes states.csv, innovations.csv, estimate.json and a page. Exit code 1 if the model does not explain the measurement.
    """
    from ..harness.report.studies.estimate import figure_cells, for_estimate, parameter_cells
    from ..systems.many import estimate as find

    loaded = scene_of(scene, values, presets, {"master.step": step})
    with status_spinner("estimation"):
        answer = find(loaded, plan, halved=not no_verify, jobs=jobs, say=lambda text: warn([text]))
    written = [*answer.save(output), for_estimate(answer, output)]
    if as_json:
        print(json.dumps(answer.to_json(), indent=2))
    else:
        if answer.explains:
            print(answer.verdict)
        if answer.parameters:
            print_cells(parameter_cells(answer))
        if answer.figures:
            print_cells(figure_cells(answer))
        print_written(written)
    warn(answer.verdict.remarks)
    if not answer.explains:
        raise fail(str(answer.verdict), FAILED_CHECK)


@new.command("plan")
def new_plan(
    file: File,
    scene: SceneName,
    signal: Annotated[list[str], Option(metavar="UNIT.OUTPUT", help="A measured signal. May be repeated.")],
    unknown: Annotated[list[str], Option(metavar="UNIT.PARAMETER", help="A parameter that is not known. May be repeated.")],
) -> None:
    """Write a plan for cosimo estimate. Example: cosimo new plan plan.toml mass-on-spring --signal mass.base_x --unknown spring.stiffness

    The CSV file beside it has a run of the scene with noise. Replace it by what your sensor has written.
    """
    import numpy as np
    import tomli_w

    from ..systems import run

    loaded = scene_of(scene, None, None)
    result = run(loaded, in_process=True, verify="no")
    for name in signal:
        pick(name, result.columns, "--signal", "a recorded output")
    rng, every = np.random.default_rng(0), max(result.time.size // SAMPLES, 1)
    noise = {n: float(f"{max(NOISE * result[n].std(), 1e-9):.2g}") for n in signal}
    columns = [result[n][every::every] + s * rng.standard_normal(result.time[every::every].size) for n, s in noise.items()]
    units = [f" [{u}]" if (u := result.measures[n]) not in ("", "1") else "" for n in signal]
    header = ["time [s]", *(f"{n}{u}" for n, u in zip(signal, units, strict=True))]
    rows = np.column_stack([result.time[every::every], *columns]).tolist()
    measured = [{"signal": n, "file": f"{file.stem}.csv", "column": n, "noise": s} for n, s in noise.items()]
    plan = {"measured": measured, "estimated": {n: {"deviation": "10 %"} for n in unknown}}
    write_new(file, tomli_w.dumps(plan))
    print_written([file, write_table(file.parent, f"{file.stem}.csv", header, rows)])
