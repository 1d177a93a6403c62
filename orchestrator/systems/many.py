"""Many runs of a scene, with the figures of its system among what is kept of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...components.core.errors import BadInput
from ..harness import sweep as sweeps
from ..harness.many.plan import from_columns
from ..harness.sweep import Sweep
from ..renamed import renamed
from ..scene.scene import Scene
from ..settings.plan import KeepSettings, PlanSettings
from . import scene_of, summary

if TYPE_CHECKING:
    from ..derivatives.gradient import Gradient, Own
    from ..estimation.answer import Estimate
    from ..estimation.measurements import Data
    from ..harness.many.design import Design
    from ..harness.many.evaluations import SearchOptions
    from ..harness.many.fitting import SceneFit
    from ..harness.many.function import Function
    from ..harness.many.likelihood import Likelihood
    from ..harness.many.sensitivity import Sensitivity
    from ..harness.many.uncertainty import Uncertainty
    from ..harness.sweep import AnswerOptions
    from ..settings.answers import DesignSettings, FitSettings
    from ..settings.estimate import EstimateSettings

RENAMED = renamed(directory="output", scheduler="cluster")
PlanLike = PlanSettings | Mapping[str, Any] | str | Path


@RENAMED
def sweep(
    scene: Scene | str | Path,
    plan: PlanLike | None = None,
    output: str | Path | None = None,
    *,
    jobs: int | None = 1,
    cluster: str = "",
    add: int = 0,
    retry: bool = False,
    progress: bool = False,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
) -> Sweep:
    """Run the points of a plan, by default of the scene's [sweep]; one that fails leaves NaN and its reason.

    `plan`: a file, or the same as plain data, such as `{"vary": {"unit.parameter": [1.0, 2.0]}}`. `output`: where the points,
    the table and the data set go; what is there of the same scene is not run again. `jobs`: workers, 1: this thread alone, None:
    one for each core where it pays; they are threads, or processes of Dask where a step of the scene needs Python. `cluster`:
    address of a Dask scheduler. `add`: further points of a sampled plan. `retry`: failed points run again. `limits`: a validation table, or
    the file of one, whose rows are limits, under these `conditions`. `verify`: some points run again with half of every macro
    step, for the errors of the numbers. A script that uses several processes keeps its own calls behind
    `if __name__ == "__main__":`.
    Raises `BadInput`.
    """
    return sweeps.sweep(
        scene_of(scene),
        plan,
        output,
        jobs=jobs,
        cluster=cluster,
        add=add,
        retry=retry,
        progress=progress,
        summarize=summary,
        limits=limits,
        conditions=conditions,
        verify=verify,
    )


@RENAMED
def run_many(
    scene: Scene | str | Path,
    table: Mapping[str, Iterable[Any]],
    output: str | Path | None = None,
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
    return sweep(scene, plan, output, jobs=threads, verify=verify)


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


def gradient(
    scene: Scene | str | Path,
    of: str | Sequence[str] | Own | None = None,
    by: str | Sequence[str] | None = None,
    output: str | Path | None = None,
    *,
    differences: float = 0.0,
    halved: bool = True,
) -> Gradient:
    """Derivatives and elasticities of figures by real parameters, exact for scenes of kernels, with their errors.

    of: figures of the summary, "unit.output, kind" (mean, maximum, minimum, standard deviation, last), or a function of a `Result`
    that gives (value, unit) by name; default: the summary.  by: "unit.parameter", and inputs that nothing drives; default: all.
    output: a directory for gradient.csv and the report.  differences: by runs with this relative change instead, for scenes that
    have no derivatives.  halved: errors by derivatives with half of all steps. Raises `BadInput`, `StepFailed`.
    """
    from ..derivatives.gradient import gradient as find

    measured = find(scene_of(scene), of, by, differences=differences, halved=halved)
    if output is not None:
        from ..harness.report.studies.gradient import for_gradient

        measured.save(output)
        for_gradient(measured, output)
    return measured


def estimate(
    scene: Scene | str | Path,
    plan: EstimateSettings | Mapping[str, Any] | str | Path,
    output: str | Path | None = None,
    *,
    folder: str | Path = ".",
    data: Data | None = None,
    halved: bool = True,
    jobs: int | None = 1,
    say: Callable[[str], None] = lambda text: None,
) -> Estimate:
    """State and parameters of a scene from measured signals, with bands, and a verdict whether the model explains them.

    plan: a TOML file, or the same as plain data.  output: a directory for tables and the report.  folder: of measured files, where the
    plan is no file.  data: signal -> (time in s, values in SI units), (n,) each, in the place of files.  halved: numerical errors, by
    another filter with half of all steps.  jobs: threads for the runs of constants, which change no number; None: one for each core.
    say: is told beforehand what the measurements cannot tell. Raises `BadInput`, `StepFailed`.
    """
    from ..estimation.estimate import estimate as find
    from ..harness.many.execute import cores

    if jobs is not None and jobs < 1:
        raise BadInput("estimate: --jobs", str(jobs), "at least 1")
    answer = find(scene_of(scene), plan, folder=folder, data=data, halved=halved, threads=jobs or cores(), say=say)
    if output is not None:
        from ..harness.report.studies.estimate import for_estimate

        answer.save(output)
        for_estimate(answer, output)
    return answer


@RENAMED
def sensitivity(
    scene: Scene | str | Path,
    plan: PlanLike,
    output: str | Path | None = None,
    *,
    quantities: Sequence[str] = (),
    method: str = "sobol",
    samples: int = 128,
    jobs: int | None = 1,
    cluster: str = "",
    progress: bool = False,
    verify: bool = True,
) -> Sensitivity:
    """Which parameters matter: indices of quantities over what a plan varies, `samples` blocks of d + 2 (Sobol) or d + 1 (Morris) runs.

    method: "sobol" or "morris".  quantities: columns of a sweep; default: those of the plan or of the scene's [study]. The plan's
    own method and number of points do not count. Raises `BadInput`, also for correlated parameters, of which shares of the variance
    mean nothing.
    """
    from ..harness.many.sensitivity import sensitivity as answer

    how: AnswerOptions = {"jobs": jobs, "cluster": cluster, "progress": progress, "verify": verify, "summarize": summary}
    return answer(scene_of(scene), plan, output, quantities=quantities, method=method, samples=samples, **how)


@RENAMED
def uncertainty(
    scene: Scene | str | Path,
    plan: PlanLike | None = None,
    output: str | Path | None = None,
    *,
    quantities: Sequence[str] = (),
    limits: str = "",
    conditions: Sequence[str] = (),
    jobs: int | None = 1,
    cluster: str = "",
    progress: bool = False,
    verify: bool = True,
    first_order: bool = True,
    samples: int = 100,
) -> Uncertainty:
    """Distributions of quantities over the samples of a plan, and the probability of keeping each of its limits.

    Without a plan, `samples` are drawn of all tolerances of the scene and of all seeds of its effects.

    quantities: columns of a sweep; default: those of the plan or of the scene's [study].  limits: a validation table whose rows are
    limits as well, under these `conditions`.  first_order: samples follow from exact derivatives at the means where runs at the
    ends and at random agree, else all are run. Raises `BadInput`.
    """
    from ..harness.many.uncertainty import uncertainty as answer

    how: AnswerOptions = {"jobs": jobs, "cluster": cluster, "progress": progress, "verify": verify, "summarize": summary}
    return answer(
        scene_of(scene),
        plan,
        output,
        quantities=quantities,
        limits=limits,
        conditions=conditions,
        first_order=first_order,
        samples=samples,
        **how,
    )


@RENAMED
def fit(
    scene: Scene | str | Path,
    settings: FitSettings | Mapping[str, Any] | str | Path,
    output: str | Path | None = None,
    *,
    folder: str | Path = ".",
    verify: bool = True,
    jobs: int | None = 1,
    cluster: str = "",
    observe: Callable[[int], None] = lambda n: None,
) -> SceneFit:
    """Parameters from measurements: curves, spectra and numbers, by least squares over their standard deviations.

    folder: of the measured files, where the settings are no file.  verify: the fitted run is made again with half of every step.
    observe: is told how many runs there were. Runs that are kept in `output` are not made again.
    Raises `BadInput`, also where the start cannot be run.
    """
    from ..harness.many.fitting import fit as answer

    how: SearchOptions = {"jobs": jobs, "cluster": cluster, "observe": observe, "summarize": summary}
    return answer(scene_of(scene), settings, output, folder=folder, verify=verify, **how)


def likelihood(
    scene: Scene | str | Path, settings: FitSettings | Mapping[str, Any] | str | Path, *, folder: str | Path = "."
) -> Likelihood:
    """log p(measurements | x) as a function of the parameters in [vary], with its `gradient(x)`, for SciPy, emcee, PyMC.

    settings: of a fit, with exact derivatives; or an estimate's with [vary] beside it, whose filter gives the likelihood under process
    noise, with differences. The noise of each measurement is given.  folder: of measured files, where the settings are no file. Close
    it, or use `with`. Raises `BadInput`.
    """
    from ..harness.many.likelihood import Likelihood

    return Likelihood(scene_of(scene), settings, folder, summarize=summary)


@RENAMED
def design(
    scene: Scene | str | Path,
    settings: DesignSettings | Mapping[str, Any] | str | Path,
    output: str | Path | None = None,
    *,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
    jobs: int | None = 1,
    cluster: str = "",
    observe: Callable[[int], None] = lambda n: None,
) -> Design:
    """Parameters for the least or largest value of a quantity within bounds and limits; of several quantities a front.

    limits: a validation table whose rows are constraints as well, under these `conditions`.  verify: the best run, of a front some of its
    runs, are made again with half of every step.  observe: is told how many runs there were. Runs that are kept in `output` are not
    made again. Raises `BadInput`, also where the start cannot be run.
    """
    from ..harness.many.design import design as answer

    how: SearchOptions = {"jobs": jobs, "cluster": cluster, "observe": observe, "summarize": summary}
    return answer(scene_of(scene), settings, output, limits=limits, conditions=conditions, verify=verify, **how)
