"""Many runs of a scene, with the figures of its system among what is kept of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..harness import sweep as sweeps
from ..harness.many.plan import from_columns
from ..harness.sweep import Sweep
from ..scene.scene import Scene
from ..settings.plan import KeepSettings, PlanSettings
from . import scene_of, summary

if TYPE_CHECKING:
    from ..harness.many.design import Design
    from ..harness.many.fitting import SceneFit
    from ..harness.many.function import Function
    from ..harness.many.sensitivity import Sensitivity
    from ..harness.many.uncertainty import Uncertainty
    from ..settings.answers import DesignSettings, FitSettings

PlanLike = PlanSettings | Mapping[str, Any] | str | Path


def sweep(
    scene: Scene | str | Path,
    plan: PlanLike | None = None,
    directory: str | Path | None = None,
    *,
    jobs: int | None = 1,
    scheduler: str = "",
    add: int = 0,
    retry: bool = False,
    progress: bool = False,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
) -> Sweep:
    """Run the points of a plan, by default of the scene's [sweep]; one that fails leaves NaN and its reason.

    `plan`: a file, or the same as plain data, such as `{"vary": {"unit.parameter": [1.0, 2.0]}}`. `directory`: where the points,
    the table and the data set go; what is there of the same scene is not run again. `jobs`: workers, 1: this thread alone, None:
    one for each core where it pays; they are threads, or processes where a step of the scene needs Python. `scheduler`: address
    of a Dask cluster. `add`: further points of a sampled plan. `retry`: failed points run again. `limits`: a validation table, or
    the file of one, whose rows are limits, under these `conditions`. `verify`: some points run again with half of every macro
    step, for the errors of the numbers. A script that uses several processes keeps its own calls behind
    `if __name__ == "__main__":`.
    Raises `BadInput`.
    """
    return sweeps.sweep(
        scene_of(scene),
        plan,
        directory,
        jobs=jobs,
        scheduler=scheduler,
        add=add,
        retry=retry,
        progress=progress,
        summarize=summary,
        limits=limits,
        conditions=conditions,
        verify=verify,
    )


def run_many(
    scene: Scene | str | Path,
    table: Mapping[str, Iterable[Any]],
    directory: str | Path | None = None,
    *,
    threads: int | None = None,
    keep: KeepSettings | Mapping[str, Any] | None = None,
    verify: bool = True,
) -> Sweep:
    """Run a scene once for each row of a table: a sweep whose points are listed.

    `table`: "unit.parameter" -> values, (n,) each, as a mapping or a data frame. `threads`: default: one for each core. `keep`:
    what is kept of each run, as [keep] of a plan; default: statistics of all recorded signals and the figures of the system.
    The rest is that of `sweep`. Raises `BadInput`.
    """
    plan = from_columns(table) | ({} if keep is None else {"keep": keep})
    return sweep(scene, plan, directory, jobs=threads, verify=verify)


def function(
    scene: Scene | str | Path, parameters: str | Sequence[str], figures: str | Sequence[str], *, threads: int | None = None
) -> Function:
    """A scene as a function f(x) -> y of parameters, for optimizers and samplers: x (k,) gives y (m,), x (n, k) gives (n, m).

    parameters: "unit.parameter", or "unit.parameter [unit of measure]", in which x is then.  figures: as in plans, "unit.output,
    kind" or a figure of summary.json.  threads: for many points at once; None: one for each core. A text instead of a list: x or y
    without that axis. A run that fails gives NaN and its `reason`, no exception. The units are opened once where the scene is
    kernels alone. Close it, or use `with`. Raises `BadInput` for names that the scene does not have.
    """
    from ..harness.many.function import Function

    return Function(scene_of(scene), parameters, figures, summarize=summary, threads=threads)


def sensitivity(scene: Scene | str | Path, plan: PlanLike, directory: str | Path | None = None, **options: Any) -> Sensitivity:
    """Which parameters matter: as `harness.many.sensitivity`, with the figures of the scene's system among the quantities."""
    from ..harness.many.sensitivity import sensitivity as answer

    return answer(scene_of(scene), plan, directory, summarize=summary, **options)


def uncertainty(scene: Scene | str | Path, plan: PlanLike, directory: str | Path | None = None, **options: Any) -> Uncertainty:
    """Distributions of quantities: as `harness.many.uncertainty`, with the figures of the scene's system among them."""
    from ..harness.many.uncertainty import uncertainty as answer

    return answer(scene_of(scene), plan, directory, summarize=summary, **options)


def fit(
    scene: Scene | str | Path,
    settings: FitSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None = None,
    **options: Any,
) -> SceneFit:
    """Parameters from measurements: as `harness.many.fitting`, with the figures of the scene's system among the targets."""
    from ..harness.many.fitting import fit as answer

    return answer(scene_of(scene), settings, directory, summarize=summary, **options)


def design(
    scene: Scene | str | Path,
    settings: DesignSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None = None,
    **options: Any,
) -> Design:
    """Parameters for a small or large quantity: as `harness.many.design`, with the figures of the scene's system."""
    from ..harness.many.design import design as answer

    return answer(scene_of(scene), settings, directory, summarize=summary, **options)
