"""One run of a scene."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from signal import Signals
from typing import TYPE_CHECKING, Annotated

import typer

from ...components.core.errors import BadInput
from .choices import effects_within, setting_within, tolerance_of_effects
from .common import (
    FAILED_CHECK,
    FAILED_RUN,
    STOPPED,
    Changes,
    InProcess,
    Native,
    NoVerify,
    Output,
    Presets,
    app,
    changed,
    changes_of,
    listed,
    loaded_scene,
    print_table,
    share,
    status_spinner,
    switched_on,
    warn,
    wish_of,
)
from .completion import effects as effect_names
from .completion import scenes

if TYPE_CHECKING:
    from ..harness.summary import Summary
    from ..results import Result
    from ..scene.scene import Scene

CHECKPOINT = "checkpoint"  # file in the output directory


@app.command()
def run(
    scene: Annotated[str, typer.Argument(autocompletion=scenes, help="name of a shipped scene, or a scene file")],
    in_process: InProcess = False,
    native: Native = False,
    output: Output = None,
    values: Changes = None,
    presets: Presets = None,
    effects: Annotated[
        list[str] | None,
        typer.Option(
            "--effects",
            metavar="UNIT.EFFECT[,...]",
            autocompletion=effect_names,
            help=("Switch on effects beside those of the scene, may be repeated; or auto: those that the scene calls for."),
        ),
    ] = None,
    tolerance: Annotated[
        str | None,
        typer.Option(
            "--tolerance",
            metavar="SHARE",
            help=("With --effects auto: largest error against all effects, as in 1% or 0.01; default 1%."),
        ),
    ] = None,
    algorithm: Annotated[
        str | None, typer.Option("--algorithm", help=("jacobi, gauss-seidel, iterative or interface-model"))
    ] = None,
    step: Annotated[float | None, typer.Option("--step", help="Macro step, s.")] = None,
    stop: Annotated[float | None, typer.Option("--stop", help="End of the run, s.")] = None,
    record: Annotated[
        list[str] | None,
        typer.Option(
            "--record", metavar="UNIT.OUTPUT[,...]", help=("Outputs to keep instead of those of the scene; may be repeated.")
        ),
    ] = None,
    checkpoint_every: Annotated[
        float | None,
        typer.Option(
            "--checkpoint-every",
            metavar="SECONDS",
            help=(f"Write {CHECKPOINT} into the output directory, from which --resume goes on; s of simulated time."),
        ),
    ] = None,
    resume: Annotated[Path | None, typer.Option("--resume", help="A checkpoint of the same scene, to go on from.")] = None,
    isolate: Annotated[
        bool,
        typer.Option(
            "--isolate",
            help=(
                "Foreign code, FMUs and module:Class, in walled worker processes: limits of time and memory, no network, files read only."
            ),
        ),
    ] = False,
    accuracy: Annotated[
        str | None,
        typer.Option(
            "--accuracy",
            metavar="SHARE",
            help=("The quickest setting whose error stays within this, as in 1% or 0.01; measured first if nothing is known."),
        ),
    ] = None,
    verify: Annotated[
        str | None,
        typer.Option(
            "--verify",
            metavar="whole|full",
            help=(
                "Find errors by repeating the whole run with half the macro step, whatever it costs; full: and with finer internal "
                "steps and meshes. Default: the whole run where that takes at most 5 s of CPU time, else windows of it."
            ),
        ),
    ] = None,
    no_verify: NoVerify = False,
    real_time: Annotated[
        bool,
        typer.Option(
            "--real-time",
            help=("No macro step ends before its time on the clock; how late steps were is in the report and in summary.json."),
        ),
    ] = False,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run",
            help=(
                "Do not run: show units, connections and loops, how long the macro step may be, and what a run costs; "
                "with -o a drawing, too."
            ),
        ),
    ] = False,
) -> None:
    """Run a scene. Example: cosimo run scene.toml --set pantograph.speed=83.3 --effects pantograph.bump_stops -o out

    To see first what it would do: cosimo run scene.toml --step 2e-3 --dry-run. To go on after an interrupt: cosimo run
    scene.toml -o out --checkpoint-every 1, then cosimo run scene.toml -o out --resume out/checkpoint.
    """
    from ..harness.report.trust import percent
    from ..harness.summary import verification_text
    from ..judgement.verification import run as run_scene
    from ..output import ensure_directory, locked

    loaded = loaded_scene(scene)
    given = {
        "master.step": step,
        "stop_time": stop,
        "master.algorithm": algorithm,
        "record.signals": listed("--record", record) if record else None,
    }
    changes = {place: value for place, value in given.items() if value is not None}
    within = tolerance_of_effects(effects, tolerance)
    changes |= switched_on(loaded, effects or []) if within is None else {}
    changes |= changes_of(loaded, values, presets)
    changes |= _walled(loaded) if isolate else {}
    loaded = changed(loaded, changes)
    choice = None
    if within is not None:
        with status_spinner() as on_message:
            loaded, choice, messages = effects_within(loaded, within, on_message)
        print(messages[0])
        print(messages[1], file=sys.stderr)
    asked, reason = _tolerance(accuracy, step, algorithm), None
    if asked is not None:
        with status_spinner() as on_message:
            loaded, reason, messages = setting_within(loaded, asked, on_message, lambda text: print(text, file=sys.stderr))
        print(*messages, sep="\n")
    wish = wish_of(verify, no_verify, ("whole", "full"))
    if in_process and native:
        raise BadInput("--native", "--in-process as well", "one of them", "Remove one of them.")
    for option, wanted in (("--in-process", in_process), ("--native", native)):
        if wanted and all(unit.fmu for unit in loaded.units.values()):
            raise BadInput(option, "a scene of FMUs only", "components; it would have no effect", "Remove it.")
    if dry_run:
        for option, value in (
            ("--checkpoint-every", checkpoint_every),
            ("--resume", resume),
            ("--native", native or None),
            ("--real-time", real_time or None),
            ("--verify", verify),
            ("--no-verify", no_verify or None),
        ):
            if value is not None:
                raise BadInput(option, repr(str(value)), "none with --dry-run; it would have no effect", "Remove one of them.")
        _dry_run(loaded, in_process)
        if output is not None:
            print(f"wrote {loaded.show().save(ensure_directory(output) / 'scene.svg')}")
        return
    if checkpoint_every is not None and output is None:
        raise BadInput("--checkpoint-every", f"{checkpoint_every:g} s without -o", "an output directory as well")
    with locked(output) if output is not None else nullcontext():  # now, not after a long run, and until its report is written
        checkpoint = None if output is None or checkpoint_every is None else output / CHECKPOINT
        # at the pace of the clock nothing is written or drawn between the steps
        result = run_scene(
            loaded,
            verify=wish,
            in_process=in_process,
            native=native,
            progress=not real_time,
            checkpoint_every=checkpoint_every,
            checkpoint_to=checkpoint,
            resume=resume,
            output=None if real_time else output,
            real_time=real_time,
        )
        unchanged = None if real_time else result
        if reason is not None:
            result = replace(result, info={**result.info, "accuracy": reason})
        if choice is not None and within is not None:
            result = replace(result, info=choice.with_reasons(result.info, within))
        numbers, remark = _summary(result)
        if output is not None:
            if result is not unchanged:
                result.save(output)
            print(
                "wrote "
                + ", ".join(
                    str(output / name)
                    for name in ("result.parquet", "result.csv", "run.json", *_numbers(numbers, output), *_report(result, output))
                )
            )
    verification = result.info["verification"]
    errors = {name: percent(error["rms"]) for name, error in verification.get("signals", {}).items()}
    print_table(
        f"{loaded.title or loaded.name}: {result.outcome}",
        ("signal", "unit", "min", "max", "end", "error"),
        [
            (name, result.measures[name], *result.extremes(name), errors.get(name, "not known" if errors else ""))
            for name in result.columns
            if result.rows
        ],
    )
    if numbers:
        print_table("In numbers", ("quantity", "unit", "value", ""), [(r.name, r.unit, r.shown, r.text) for r in numbers])
    print(verification_text(verification))
    timing = result.info["timing"]
    compiling = f", {timing['compile']:.3g} s compiling (once)" if timing["compile"] else ""
    print(f"{timing['simulated']:g} s simulated in {timing['run']:.3g} s, {timing['start']:.3g} s to start{compiling}")
    warn([*result.info["warnings"], *remark])
    if result.outcome != "done":
        print(f"cosimo: {result.message}", file=sys.stderr)
        raise SystemExit(STOPPED + Signals[result.info["signal"]] if result.outcome == "stopped" else FAILED_RUN)
    if wish == "full" and asked is not None and not _verified(loaded, asked):
        raise SystemExit(FAILED_CHECK)


def _summary(result: Result) -> tuple[Summary, list[str]]:
    """The run in numbers, and a remark where [analysis] asks for what a run that reached its end does not have."""
    from ..harness.summary import pacing_rows
    from ..systems import summary

    if not result.held:
        return (), [f"no summary of {result.rows} rows, which are more than memory should hold"]
    try:
        return summary(result), []
    except BadInput as error:
        return pacing_rows(result.info), [f"no summary: {error}"] if result.outcome == "done" else []


def _numbers(numbers: Summary, output: Path) -> list[str]:
    """Write summary.json: its name, or none where there are no numbers or they cannot be written."""
    from ..harness.summary import to_json
    from ..output import write_json

    if not numbers:
        return []
    try:
        write_json(output / "summary.json", to_json(numbers))
    except OSError as error:
        print(f"cosimo: no summary.json: {error.strerror or error}", file=sys.stderr)
        return []
    return ["summary.json"]


def _report(result: Result, output: Path) -> list[str]:
    """Write the report of a run into its directory: its file's name, or none where it cannot be drawn."""
    from ..harness import report
    from ..results import HELD
    from ..systems import SYSTEMS

    if result.rows < 2:
        return []
    if not result.held:
        print(f"cosimo: no report.html: it is drawn of at most {HELD} numbers, not of {result.rows} rows", file=sys.stderr)
        return []
    try:
        return [report.for_run(result, output, SYSTEMS).name]
    except OSError as error:
        if result.outcome == "done":
            raise
        print(f"cosimo: no report.html: {error.strerror or error}", file=sys.stderr)
        return []


def _walled(scene: Scene) -> dict[str, str]:
    """Changes that put all foreign code of a scene behind walls; `BadInput` where there is none."""
    foreign = [name for name, unit in scene.units.items() if unit.fmu or ":" in unit.component]
    if not foreign:
        raise BadInput(
            "--isolate",
            f"{scene.name}, all of whose units are components of the catalogue",
            "a scene with foreign code",
            "Leave it out.",
        )
    return {f"units.{name}.isolation": "restricted" for name in foreign}


def _tolerance(accuracy: str | None, step: float | None, algorithm: str | None) -> float | None:
    """The share that --accuracy asks for; raises `BadInput` for what it does not go with."""
    if accuracy is None:
        return None
    for option, value in (("--step", step), ("--algorithm", algorithm)):
        if value is not None:
            raise BadInput(option, repr(value), "none with --accuracy, which chooses it", "Remove one of them.")
    return share("--accuracy", accuracy)


def _verified(scene: Scene, tolerance: float) -> bool:
    """Print how far a finer run differs, quantity by quantity, and whether all stay within the tolerance."""
    from ..harness.studies.fronts import verify
    from ..harness.studies.quantities import percent

    differences = verify(scene)
    print_table(
        "against half the macro step and half the internal steps",
        ("quantity", "difference"),
        [(name, percent(value)) for name, value in differences.items()],
    )
    worst = max(differences.values())
    print(
        f"verified: {percent(worst)} is within {percent(tolerance)}"
        if worst <= tolerance
        else f"NOT verified: {percent(worst)} is more than {percent(tolerance)}"
    )
    return worst <= tolerance


def _dry_run(scene: Scene, in_process: bool) -> None:
    from ...components.core.errors import StepFailed
    from ..judgement import advise
    from ..judgement.dry_run import first_part, lines, tables

    try:
        advice = advise(scene, in_process=in_process)
    except StepFailed as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(FAILED_RUN) from None
    coupling = scene.coupling
    for table in tables(scene, coupling, advice):
        print_table(*table)
    for line in lines(scene, coupling, advice, in_process=in_process):
        print(line)
    text, warnings = first_part(scene)
    print(text)
    warn([*scene.remarks, *advice.warnings(scene), *warnings])
