"""One run of a scene."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from signal import Signals
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from ...components.core.errors import BadInput
from ..output import locked
from .common import (
    FAILED_CHECK,
    FAILED_RUN,
    STOPPED,
    app,
    changed,
    changes_of,
    fail,
    is_scene,
    loaded_scene,
    print_written,
    switched_on,
    warn,
)
from .completion import effects as effect_names
from .options import (
    TOLERANCE,
    Changes,
    Conditions,
    InProcess,
    Limits,
    Native,
    NoVerify,
    OptionalOutput,
    Presets,
    SceneName,
    Start,
    Step,
    Stop,
    limits_of,
    listed,
    refuse,
    reports,
    share,
    verify_mode,
)

if TYPE_CHECKING:
    from ..scene.scene import Scene

AUTO = "auto"
CHECKPOINT = "checkpoint"  # file in the output directory


@app.command()
@reports
def run(
    scene: SceneName,
    in_process: InProcess = False,
    native: Native = False,
    output: OptionalOutput = None,
    values: Changes = None,
    presets: Presets = None,
    effects: Annotated[
        list[str] | None,
        Option(
            metavar="UNIT.EFFECT[,...]",
            autocompletion=effect_names,
            help="Switch on effects in addition to those of the scene; may be repeated. auto: the smallest set "
            "of effects within --tolerance.",
        ),
    ] = None,
    tolerance: Annotated[
        str | None,
        Option(
            metavar="SHARE",
            help=f"With --effects auto: largest error against all effects, for example 1% or 0.01. Default: {TOLERANCE}.",
        ),
    ] = None,
    algorithm: Annotated[
        str | None, Option(help="Co-simulation algorithm: jacobi, gauss-seidel, iterative or interface-model.")
    ] = None,
    table: Annotated[
        Path | None,
        Option(
            "--input",
            metavar="FILE",
            help="Table over time (CSV, Parquet, Arrow or MAT 5). Its columns drive the unconnected inputs of "
            "the same names. A single FMU or "
            "component runs over the time of the table.",
        ),
    ] = None,
    step: Step = None,
    start: Start = None,
    stop: Stop = None,
    record: Annotated[
        list[str] | None,
        Option(metavar="UNIT.OUTPUT[,...]", help="Outputs to record instead of those of the scene. May be repeated."),
    ] = None,
    checkpoint_every: Annotated[
        float | None,
        Option(
            metavar="SECONDS",
            help=f"Interval of checkpoints, in s of simulated time. The file {CHECKPOINT} in the output directory is for --resume.",
        ),
    ] = None,
    resume: Annotated[Path | None, Option(help="Continue from a checkpoint of the same scene.")] = None,
    isolate: Annotated[
        bool,
        Option(
            "--isolate",
            help="Run foreign code (FMUs and module:Class) in the sandbox of bubblewrap: limits of time and memory, no network, "
            "read-only files.",
        ),
    ] = False,
    accuracy: Annotated[
        str | None,
        Option(
            metavar="SHARE",
            help="Use the fastest setting with an error below this value, for example 1% or 0.01. If none is "
            "known, cosimo measures settings first.",
        ),
    ] = None,
    verify: Annotated[
        str | None,
        Option(
            metavar="whole|full|steps",
            help="Error estimate. whole: repeat the complete run with half the steps and coarser meshes, regardless of cost. full: also "
            "refine tolerances. steps: no coarser meshes. Default: repeat the complete run if its counted work allows "
            "it (about 5 s, the same on every machine), else windows of it.",
        ),
    ] = None,
    no_verify: NoVerify = False,
    fmu_log: Annotated[
        str,
        Option(
            "--fmu-log",
            metavar="LEVEL",
            help="Lowest level of FMU messages in fmu.log of the output directory: none, fatal, error, discard, warning or info. "
            "run.json counts all messages.",
        ),
    ] = "warning",
    limits: Limits = "",
    conditions: Conditions = None,
    real_time: Annotated[
        bool,
        Option("--real-time", help="Run in step with the wall clock. The report and summary.json list the delay of the steps."),
    ] = False,
    dry_run: Annotated[
        bool,
        Option(
            "--dry-run",
            help="Do not run. Show units, connections, loops, the longest stable macro step and the cost; with -o also a "
            "drawing.",
        ),
    ] = False,
) -> None:
    """Run a scene. Example: cosimo run scene.toml --set pantograph.speed=83.3 --effects pantograph.bump_stops -o out

    Preview: cosimo run scene.toml --step 2e-3 --dry-run. Continue after an interrupt: cosimo run scene.toml -o out
    --checkpoint-every 1, then cosimo run scene.toml -o out --resume out/checkpoint.
    """
    from ..judgement.verification import run_verified
    from ..scene.files import SCENES
    from . import run_parts

    recorded = listed("--record", record) if record else None
    given = {
        "master.step": step,
        "start_time": start,
        "stop_time": stop,
        "master.algorithm": algorithm,
        "record.signals": recorded if not (effects or values or presets) else None,
        "limits": limits_of(limits, conditions),
    }
    loaded = loaded_scene(scene, given)
    if table is not None:
        whole = not scene.endswith(SCENES) and not is_scene(scene)
        loaded = loaded.with_input(table, whole=whole and start is None and stop is None)
    effects_within = _tolerance_of_effects(effects, tolerance)
    changes = switched_on(loaded, effects) if effects_within is None else {}
    changes |= changes_of(loaded.with_changes(changes), values, presets)
    changes |= {"record.signals": recorded} if recorded else {}  # of effects that are switched on, too
    changes |= _isolated(loaded) if isolate else {}
    loaded = changed(loaded, changes)
    mode = verify_mode(verify, no_verify, ("whole", "full", "steps"))
    if in_process and native:
        raise BadInput("run", "--native and --in-process exclude each other", "", "Remove one.")
    if not loaded.component_classes:
        for option, wanted in (("--in-process", in_process), ("--native", native)):
            if wanted:
                raise BadInput(option, "no effect with a scene of FMUs only", "", "Remove it.")
    if dry_run:
        without_effect = {
            "--checkpoint-every": checkpoint_every,
            "--resume": resume,
            "--native": native,
            "--real-time": real_time,
            "--verify": verify,
            "--no-verify": no_verify,
        }
        refuse(without_effect, "no effect with --dry-run", "Remove one of them.")
    if checkpoint_every is not None and output is None:
        raise BadInput("--checkpoint-every", f"{checkpoint_every:g} s without -o", "an output directory as well")
    accuracy_within = None if accuracy is None else share("--accuracy", accuracy)
    if accuracy_within is not None:
        refuse({"--step": step, "--algorithm": algorithm}, "--accuracy chooses it", "Remove one of them.")
    reasons = []  # functions that put those of a choice into run.json
    if effects_within is not None:
        from .choices import with_effects_within

        loaded, reason = with_effects_within(loaded, effects_within)
        reasons.append(reason)
    of_quantities = None
    if accuracy_within is not None:
        from .choices import with_setting_within

        loaded, reason = with_setting_within(loaded, accuracy_within)
        reasons.append(reason)
        if mode == "full":
            from ..harness.studies.quantities import distances, recording

            loaded, of_quantities = recording(loaded), distances
    if dry_run:
        run_parts.dry_run(loaded, in_process, output)
        return
    with locked(output) if output is not None else nullcontext():  # now, not after a long run, and until its report is written
        # at the pace of the clock nothing is written or drawn between the steps
        result = run_verified(
            loaded,
            verify=mode,
            in_process=in_process,
            native=native,
            progress=not real_time,
            checkpoint_every=checkpoint_every,
            checkpoint_to=None if output is None or checkpoint_every is None else output / CHECKPOINT,
            resume=resume,
            output=None if real_time else output,
            real_time=real_time,
            distances=of_quantities,
            fmu_log=fmu_log,
        )
        for reason in reasons:
            result = reason(result)
        numbers, remarks = run_parts.summary_of(result)
        if output is not None:
            if reasons or real_time:
                result.save(output)
            print_written(run_parts.write(result, numbers, output))
    run_parts.print_result(result, numbers)
    failed_limits = run_parts.print_limits(result, numbers)
    warn([*result.info.warnings, *remarks])
    if result.outcome != "done":
        raise fail(result.message, STOPPED + Signals[result.info.signal] if result.outcome == "stopped" else FAILED_RUN)
    if failed_limits:
        raise SystemExit(FAILED_CHECK)
    if of_quantities is not None and accuracy_within is not None:
        from .choices import is_verified

        if not is_verified(result, accuracy_within):
            raise SystemExit(FAILED_CHECK)


def _tolerance_of_effects(effects: list[str] | None, tolerance: str | None) -> float | None:
    """The share within which effects are to be chosen; None where they are not. Raises `BadInput` for half of it."""
    if AUTO not in listed("--effects", effects):
        refuse({"--tolerance": tolerance}, "no effect without --effects auto")
        return None
    if effects != [AUTO]:
        raise BadInput("--effects", repr(",".join(effects or ())), "auto alone", "It finds the others.")
    return share("--tolerance", tolerance or TOLERANCE)


def _isolated(scene: Scene) -> dict[str, Any]:
    """Changes that put all foreign code of a scene into a sandbox; `BadInput` where there is none."""
    foreign = [name for name, kind in scene.kinds.items() if not kind.of_catalogue]
    if not foreign:
        raise BadInput(
            "--isolate",
            f"{scene.name}, all of whose units are components of the catalogue",
            "a scene with foreign code",
            "Leave it out.",
        )
    return {f"units.{name}.isolation": "restricted" for name in foreign}
