"""A run is judged by repeating it: every recorded signal and every figure of a run gets its numerical error.

The run is repeated with half of every step, the macro step and the internal steps of the units, and with a quarter if the two differ by
much. Where an error is large, a further run with half the macro step alone tells which of them makes it. A run that is too long for this
is repeated over windows, see `windows`. Meshes are coarsened, see `mesh`. With "full", tolerances of the units are
refined as well, one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from math import nan
from pathlib import Path
from signal import SIGINT, Signals
from time import process_time  # for what is shown; what is repeated follows from counted work
from typing import Any, Literal, NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from .. import working_directory
from ..interrupts import Interrupted, interruptible
from ..run import work
from ..run.comparison import (
    SURE,
    Difference,
    SignalError,
    between_rows,
    common_rows,
    differences,
    excerpt,
    figure_errors,
    needs_third,
    others,
    signal_errors,
    worst_of,
)
from ..run.instability import unfollowed
from ..run.key_results import KeyResults, key_results, known_results
from ..run.results import Result
from ..run.run import run
from ..run.thresholds import GROWN, LASTING, LOST, NO_MATTER, SECTIONS, UNSEEN, WARN
from ..run.windows import WindowsWish
from ..scene.scene import Scene
from ..scene.shorter_steps import numbers_in_use, shorter, substeps
from ..scene.tolerances import tolerances_of
from ..units.fmu_messages import DEFAULT
from .advice import remedy
from .mesh import mesh_error
from .parameter_errors import ParameterErrors, parameter_errors
from .record import NOT_ASKED, STEPS, Verification
from .sampling import between, of_parts, rows_of
from .warnings import of_macro_step, suggestion, warnings_of

FINER_TOLERANCE = 0.1  # components control the error of a step, not of the run


def refinements(scene: Scene) -> dict[str, dict[str, Any]]:
    """By the place of each tolerance: changes that refine it. Rows are recorded at the same times."""
    interval = {"record.interval": scene.master.step} if scene.record.interval is None and not scene.master.control else {}
    return {place: {place: FINER_TOLERANCE * value, **interval} for place, value in numbers_in_use(scene, "tolerance").items()}


Wish = Literal["auto", "whole", "full", "steps", "no"]
WISHES: tuple[Wish, ...] = ("auto", "whole", "full", "steps", "no")
Distances = Callable[[Result, Result], Mapping[str, float]]  # shares by which a run and a finer one differ in quantities, by name


def run_verified(
    scene: Scene,
    *,
    verify: Wish = "auto",
    in_process: bool = False,
    native: bool = False,
    progress: bool = False,
    checkpoint_every: float | None = None,
    checkpoint_to: str | Path | None = None,
    resume: str | Path | None = None,
    output: str | Path | None = None,
    real_time: bool = False,
    distances: Distances | None = None,
    fmu_log: str = DEFAULT,
) -> Result:
    """Simulate a scene to its stop_time, and find the numerical error of each number by repeating the run.

    verify: "auto" repeats the whole run where the counted work of that is within `BUDGET`, else windows of it; "whole" the whole run
    whatever it takes; "full" also refines the tolerances of the units; each finds the errors that meshes make, too, from a coarser
    one, see `judgement.mesh`, but for "steps", which is "auto" without them; "no" leaves the errors unknown.
    distances: of further quantities, whose errors are then in `info.verification.quantities`.
    The other arguments are those of `orchestrator.run.run`: packaging, progress, checkpoints, where the result is stored.
    Raises `BadInput` for what cannot start. `result.info.verification` says what was found.
    """
    if verify not in WISHES:
        raise BadInput("verify", repr(verify), f"one of {', '.join(WISHES)}")
    tolerances_of(scene)  # what cannot be is refused before the run
    wish = WindowsWish() if verify in ("auto", "steps") and work.as_repeated(scene, in_process) else None
    result = run(
        scene,
        in_process=in_process,
        native=native,
        progress=progress,
        checkpoint_every=checkpoint_every,
        checkpoint_to=checkpoint_to,
        resume=resume,
        output=output,
        real_time=real_time,
        windows=wish,
        remedy=remedy,
        fmu_log=fmu_log,
    )
    verified = verified_result(result, verify, in_process=in_process, windows=wish, distances=distances)
    if output is not None and verified is not result:
        verified.save(output)
    return verified


def verified_result(
    result: Result,
    wish: Wish = "auto",
    *,
    in_process: bool = False,
    windows: WindowsWish | None = None,
    distances: Distances | None = None,
) -> Result:
    """A result with `info.verification`, the warnings that follow, and another outcome where the run was unstable.

    Also where a signal comes meanwhile: the result is whole then, its outcome "stopped".
    """
    if result.outcome != "done":
        return _with(result, Verification(False, f"the run is {result.outcome}"))
    if wish == "no":
        return _judged(result, Verification(False, NOT_ASKED))
    if once := next((kind.once for kind in result.scene.kinds.values() if kind.once), ""):
        return _judged(result, Verification(False, f"the run cannot be repeated: {once}"))
    begun, of_steps = process_time(), "auto" if wish == "steps" else wish
    whole = replace(result, scene=_with_whole_paths(result.scene))
    try:
        foreign = any(kind.foreign for kind in result.scene.kinds.values())
        with interruptible(), working_directory.of_its_own(foreign):  # the first run's files stay
            if windows is not None and (windows.result or windows.why):
                verification = _of_windows(result.scene, windows)
            else:
                verification = _repeated(whole, of_steps, in_process, distances or (lambda *_: {}))
            if verification.done and wish != "steps":
                verification = _with_mesh(whole, verification, wish, distances)
            verification = _with_parameters(whole, verification, wish)
    except BadInput as error:  # such as units that cannot be opened in this process
        verification = Verification(False, f"the run cannot be repeated: {error}")
    except MemoryError:
        verification = Verification(False, "the run cannot be repeated: out of memory")
    except KeyboardInterrupt as stop:
        verification = Verification(False, "the repetition was stopped", stopped=getattr(stop, "signal", SIGINT).name)
    return _judged(result, replace(verification, seconds=process_time() - begun))


def _with_mesh(result: Result, verification: Verification, wish: Wish, distances: Distances | None) -> Verification:
    """The verification with what meshes make of the errors."""

    def again(scene: Scene, changes: Mapping[str, Any]) -> tuple[Result | None, str]:
        coarse, why = _again(scene, changes)
        return coarse, why.text

    of_meshes = mesh_error(result, again, lambda: wish != "auto" or work.allows(_work(result), 0.75), distances)
    figures = {
        name: e + of_meshes.figures.get(name, nan if of_meshes.places else 0.0) for name, e in verification.figures.items()
    }
    of_mesh = {", ".join(of_meshes.places): of_meshes.quantities} if of_meshes.quantities else {}
    return replace(verification, mesh=of_meshes, figures=figures, quantities={**verification.quantities, **of_mesh})


def _with_parameters(result: Result, verification: Verification, wish: Wish) -> Verification:
    """The verification with what tolerances make of the figures, where the scene has some."""
    if (tolerances := tolerances_of(result.scene)) is None or not result.held or result.rows < 2:
        return verification

    def again(scene: Scene, changes: Mapping[str, Any]) -> tuple[Result | None, str]:
        moved, why = _again(scene, changes)
        return moved, why.text

    each = _work(result) if wish in ("auto", "steps") else 0.0
    try:
        errors = parameter_errors(result, tolerances, lambda times: work.allows(each, times), again)
    except (BadInput, StepFailed) as error:
        errors = ParameterErrors(str(error))
    return replace(verification, parameters=errors)


def _with_whole_paths(scene: Scene) -> Scene:
    """The scene as it is read in another working directory."""
    paths = {name: path for kind in scene.kinds.values() for name, path in kind.whole_path().items()}
    return scene.with_changes(paths) if paths else scene


class _Why(NamedTuple):
    """Why a repetition has no result, and whether that is because it became unstable."""

    text: str = ""
    unstable: bool = False


def _again(scene: Scene, changes: Mapping[str, Any]) -> tuple[Result | None, _Why]:
    """The run of the scene with changes; None where it is refused or does not come to its end, and why.

    Raises `Interrupted` where a signal has stopped it.
    """
    try:
        again = run(scene.with_changes(changes), in_process=True)
    except BadInput as error:  # such as an FMU whose step is fixed
        return None, _Why(str(error))
    if again.outcome == "stopped":
        raise Interrupted(Signals[again.info.signal])
    where = " (in a working directory of its own)" if any(kind.foreign for kind in scene.kinds.values()) else ""
    why = _Why(f"the run is {again.outcome}{where}: {again.message}", again.outcome == "unstable")
    return (again, _Why()) if again.outcome == "done" else (None, why)


def _repeated(result: Result, wish: Wish, in_process: bool, distances: Distances) -> Verification:
    """What the run shows beside runs with half and, where they differ by much, a quarter of its steps."""
    scene = result.scene
    if not result.held or result.rows < 2:
        return Verification(False, "too many rows to compare in memory" if result.rows > 1 else "no two rows to compare")
    each = _work(result) if wish == "auto" else 0.0
    if not work.allows(each, 2.0):
        if not work.as_repeated(scene, in_process):
            return _over_windows(scene)
        return Verification(False, f"to repeat the run is much work ({work.shown(each, 2.0)}): ask with --verify whole")
    second, why = _again(scene, shorter(scene, 2))
    if second is None:
        return Verification(False, f"the run cannot be repeated with half its steps: {why.text}", unstable=why.unstable)
    gaps, of_quantities = differences(result, second), _as_differences(distances(result, second))
    third, unsure = None, ""
    if (needs_third(gaps) or of_quantities) and work.allows(each, 6.0):
        third, why = _again(scene, shorter(scene, 4))
        if third is None:
            unsure = f"a third run, with a quarter of the steps, failed ({why.text}): errors are those of two"
    signals = signal_errors(gaps, differences(second, third) if third is not None else None)
    quantities = {}
    if of_quantities:
        errors = signal_errors(of_quantities, _as_differences(distances(second, third)) if third is not None else None)
        quantities[STEPS] = {name: e.rms for name, e in errors.items()}
    inside = substeps(scene)
    if inside and any(e.rms > WARN for e in signals.values()) and work.allows(each, 8.0):
        signals = _with_shares(result, gaps, signals)
    runs = [r for r in (result, second, third) if r is not None]
    verification = Verification(
        True,
        unsure,
        step=0.5 * scene.master.step,
        how="whole",
        runs=len(runs),
        signals=signals,
        figures=_figures(runs, unsure=needs_third(gaps), parted=[name for name, e in signals.items() if e.parted]),
        quantities=quantities,
        excerpt=excerpt(result, second, worst_of(signals)),
        unseen={name: gap for name, gap in between_rows(result, second).items() if gap > UNSEEN},
        inside=inside,
    )
    return _refined(result, verification, distances) if wish == "full" else verification


def _refined(result: Result, verification: Verification, distances: Distances) -> Verification:
    """The verification with what each tolerance of the units makes of the errors."""
    parts: dict[str, Mapping[str, Difference]] = {}
    not_refined, figures, quantities = {}, verification.figures, dict(verification.quantities)
    for place, finer in refinements(result.scene).items():
        refined, why = _again(result.scene, finer)
        if refined is None:
            not_refined[place] = why.text
            continue
        parts[place], of_place = differences(result, refined), _figures([result, refined], unsure=False)
        if quantities:
            quantities[place] = {name: SURE * d for name, d in distances(result, refined).items()}
        figures = {name: e + of_place.get(name, nan) for name, e in figures.items()}
    return replace(verification, parts=parts, not_refined=not_refined, figures=figures, quantities=quantities)


def _as_differences(distances: Mapping[str, float]) -> dict[str, Difference]:
    return {name: Difference(distance, distance, np.zeros(SECTIONS)) for name, distance in distances.items()}


def _with_shares(result: Result, gaps: Mapping[str, Difference], signals: Mapping[str, SignalError]) -> dict[str, SignalError]:
    """The errors with the share that half the macro step alone shows, where a run with it comes to its end.

    gaps: to the run with half of all steps.
    """
    again, _ = _again(result.scene, shorter(result.scene, 2, inside=False))
    if again is None:
        return dict(signals)
    alone = differences(result, again)
    return {
        name: replace(e, coupling=min(alone[name].rms / gaps[name].rms, 1.0)) if e.rms > WARN and gaps[name].rms else e
        for name, e in signals.items()
    }


def _figures(results: list[Result], *, unsure: bool, parted: Collection[str] = ()) -> dict[str, float]:
    """Errors of the figures of a summary; none where there is no summary. All runs are read at the times of the first one's rows.

    parted: signals whose histories part: figures of their units have the error of their mean over parts of the run, and the
    difference of two runs, each as good as the other, counts once.
    """
    first, second, *more = results
    try:
        same = [key_results(first), *(key_results(rows_of(run, common_rows(first.time, run.time)[1])) for run in (second, *more))]
    except BadInput:
        return {}
    gaps = _between_rows(first, second, same)
    errors = {
        name: error + max((gap.get(name, 0.0) for gap in gaps), default=0.0)
        for name, error in figure_errors(same, unsure=unsure).items()
    }
    if units := {first.scene.split(name)[0] for name in parted}:
        gap, of_mean = same[0].gaps(same[1]), of_parts(first, key_results)
        errors |= {n: max(of_mean[n], gap[n]) for n in errors if n in of_mean and n.rpartition(".")[0] in units}
    return errors


def _between_rows(first: Result, second: Result, figures: list[KeyResults]) -> list[Mapping[str, float]]:
    """What lies between the rows of a run, such as the largest value: how far figures move where each other row is left out, in
    the rows that the second run has between them, and where rows are filled up with a curve."""
    gaps: list[Mapping[str, float]] = [_gaps(first, figures[0], np.arange(k, first.rows, 2)) for k in (0, 1)]
    there = common_rows(first.time, second.time)[1]
    if there is not None and 2 * second.rows >= 3 * there.size:
        gaps.append(_gaps(second, figures[1], others(second.rows, there)))
    return [*gaps, between(first, figures[0], key_results)]


def _gaps(result: Result, figures: KeyResults, rows: np.ndarray) -> dict[str, float]:
    """How far the figures of some rows are from those given: without the ends of the run, as spectra need even rows, and where
    that matters with them, from which ways and energies count; the smaller one.
    """
    gaps: dict[str, float] = {}
    inner = rows[(rows > 0) & (rows < result.rows - 1)]
    for some in (rows, np.concatenate(([0], inner, [result.rows - 1]))):
        if gaps and all(gap <= NO_MATTER * abs(figures[name]) for name, gap in gaps.items()):
            break
        for name, gap in figures.finite_gaps(known_results(rows_of(result, some))).items():
            gaps[name] = min(gap, gaps.get(name, gap))
    return gaps


def work_of(scene: Scene, counted: float | None) -> float:
    """The work of running a scene as repetitions do, in this process; counted: in a run of it, None where its components were FMUs.

    Raises `BadInput` where a unit cannot be opened in this process, `Interrupted` where a signal has come.
    """
    return counted if counted is not None else work.from_part(run(work.to_count(scene), in_process=True), scene.duration)


def _work(result: Result) -> float:
    return work_of(result.scene, result.info.counters.work)


def _over_windows(scene: Scene) -> Verification:
    """Of a run that was made of FMUs and is too long to repeat as a whole: it is run in process, which is bit-identical."""
    wish = WindowsWish(in_any_case=True)
    again = run(scene, in_process=True, windows=wish)
    if again.outcome == "stopped":
        raise Interrupted(Signals[again.info.signal])
    return _of_windows(scene, wish) if again.outcome == "done" else Verification(False, again.message)


def _of_windows(scene: Scene, wish: WindowsWish) -> Verification:
    seen = wish.result
    if seen is None:
        return Verification(False, f"the run is too long to be repeated without being asked for (--verify whole), and {wish.why}")
    recorded = {".".join(end) for end in scene.coupling.signals}
    errors = signal_errors({name: d for name, d in seen.differences.items() if name in recorded}, None)
    return Verification(
        True,
        "windows of a run that takes long; figures have no error. Ask for it with --verify whole",
        0.5 * scene.master.step,
        "windows",
        2,
        errors,
        windows=seen.begins,
        length=seen.length,
        slower=seen.slower,
        growing=seen.growing,
        inside=substeps(scene) if seen.inside else {},
    )


def _with(result: Result, verification: Verification) -> Result:
    return replace(result, info=replace(result.info, verification=verification.record))


def made_by_coupling(signals: Mapping[str, SignalError]) -> list[str]:
    """Signals with a motion that shorter steps do not have, and that does not decay."""
    return [name for name, e in signals.items() if e.rms > LOST and e.grown > GROWN and e.late > LASTING]


def _judged(result: Result, verification: Verification) -> Result:
    """The result with what was found, and what follows for its outcome and its warnings."""
    outcome, message = result.outcome, result.message
    if verification.stopped:
        outcome = "stopped"
        message = (
            f"stopped by {verification.stopped} while the run was repeated; the run itself is whole, its errors are not known"
        )
    elif verification.unstable:
        outcome, message = "unstable", f"the run is not confirmed: {verification.why}"
    elif unstable := made_by_coupling(verification.signals):
        worst = max(unstable, key=lambda name: verification.signals[name].grown)
        outcome = "unstable"
        grown = verification.signals[worst].grown
        message = (
            f"the {'coupling' if of_macro_step(verification, worst) else 'run'} is unstable: the deviation of {worst} is "
            f"{grown:.2g} times that of a run with shorter steps. {suggestion(result.scene, verification, worst)}"
        )
    texts = warnings_of(result.scene, verification) if outcome == "done" else []
    if outcome == "done" and verification.parameters is not None:
        texts += verification.parameters.warnings
    if outcome == "done" and not verification.done:
        texts += unfollowed(result.info.missed)
    info = replace(
        result.info,
        signal=verification.stopped or result.info.signal,
        verification=verification.record,
        outcome=outcome,
        message=message,
        warnings=(*result.info.warnings, *texts),
    )
    return replace(result, info=info)
