"""State and parameters of a scene from measurements."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

from typer import Option

from .common import FAILED_CHECK, app, fail, print_cells, print_written, scene_of, status_spinner, warn
from .options import AsJson, Changes, Output, Presets, SceneName, Step, reports

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
    as_json: AsJson = False,
) -> None:
    """State and parameters from noisy signals. Example: cosimo estimate scene.toml --plan plan.toml -o out

    Writes states.csv, innovations.csv, estimate.json and a page. Exit code 1 if the model does not explain the measurement.
    """
    from ..harness.report.studies.estimate import for_estimate, parameter_cells
    from ..systems.many import estimate as find

    loaded = scene_of(scene, values, presets, {"master.step": step})
    with status_spinner("estimation"):
        answer = find(loaded, plan, halved=not no_verify, say=lambda text: warn([text]))
    written = [*answer.save(output), for_estimate(answer, output)]
    if as_json:
        print(json.dumps(answer.to_json(), indent=2))
    else:
        if answer.explains:
            print(answer.verdict)
        if answer.parameters:
            print_cells(parameter_cells(answer))
        print_written(written)
    warn(answer.verdict.remarks)
    if not answer.explains:
        raise fail(str(answer.verdict), FAILED_CHECK)
