"""State and parameters of a scene from measurements: the whole course from a plan to a verdict."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..scene.scene import Scene
from ..scene.shorter_steps import shorter
from ..scene.sums import parts_alone
from ..settings.estimate import EstimateSettings
from .answer import Estimate, Parameter
from .figures import figure_bands
from .filtered_scene import ENSEMBLE, EXTENDED, UNSCENTED, FilteredScene, PlanLike, plan_of
from .filtering import Filter, history
from .measurements import Data, Measurements, measurements_of
from .observability import Observability, observability
from .posterior import MAY_NOT, Posterior, Runs, posterior
from .suspects import judged
from .verdict import verdict

NOISE_ROUNDS, NOISE_AGREES = 8, 0.02  # of the search for the noise; relative
PASSES, STANDS = 8, 0.1  # of the filter, for constants; standard deviations by which these move from pass to pass
MOST_STEPS = 1e8  # of a filter: hours, and more instants than memory holds
FAR = 100.0  # times the scene's own duration behind which a unit of time may be mistaken
LARGE = 0.5  # standard deviations that a numerical error may have
WORSE = 2.0  # log units that the error of the steps may take from the likelihood
HOW = {EXTENDED: "extended Kalman filter", UNSCENTED: "unscented Kalman filter", ENSEMBLE: "ensemble of {}"}


def estimate(
    scene: Scene,
    plan: PlanLike,
    *,
    folder: str | Path = ".",
    data: Data | None = None,
    halved: bool = True,
    threads: int = 1,
    say: Callable[[str], None] = lambda text: None,
) -> Estimate:
    """State and parameters of a scene from measured signals, with bands and a verdict.

    plan: a TOML file, or the same as plain data.  folder: of measured files, where the plan is no file.  data: signal -> (time in s,
    values in SI units), in the place of files.  halved: the numerical error, by another filter with half of all steps.  threads:
    for runs of constants, which change no number.  say: is told beforehand what the measurements cannot tell. Raises `BadInput`,
    and `StepFailed` where the scene cannot go on from an estimate.
    """
    wanted, where, folder = plan_of(plan, folder)
    measured = measurements_of(wanted, scene, folder, data or {}, where)
    span, own = measured.time[-1] - scene.start_time, scene.stop_time - scene.start_time
    if span > FAR * own:
        say(f"measurements end after {span:g} s, the scene after {own:g} s: are their times in ms? Then write 'time [ms]'")
    with ExitStack() as stack:
        course = Record(scene, wanted, measured, stack, where, threads=threads)
        for text in course.observable.texts:
            say(text)
        answer = course.answer()
    return _with_numerical_errors(answer, scene, wanted, measured, where) if halved else answer


class Record:
    """A record of measurements, from the survey of the scene's cells to the answer."""

    def __init__(
        self,
        scene: Scene,
        plan: EstimateSettings,
        measured: Measurements,
        stack: ExitStack,
        where: str,
        coarse: Estimate | None = None,
        threads: int = 1,
    ):
        """coarse: the answer with other steps, of which this is for the numbers alone."""
        self._threads = threads
        self.again, self.plan, self.coarse = coarse is not None, plan, coarse.posterior if coarse else None
        self.known: Posterior | None = None
        self.moves = 0.0
        step, first = scene.master.step, scene.start_time
        if not measured.time[-1] > first:
            raise BadInput(f"{where}: measured", f"times up to {measured.time[-1]:g} s", f"some behind the start, {first:g} s")
        if (steps := (measured.time[-1] - first) / step) > MOST_STEPS:
            reach = f"times from {measured.time[0]:.10g} to {measured.time[-1]:.10g} s, {steps:.2g} macro steps"
            raise BadInput(
                f"{where}: measured",
                reach,
                f"times near the start of the scene, {first:g} s",
                "Give shift, or the unit of the times.",
            )
        scene = scene.with_changes({"stop_time": first + step * (np.ceil((measured.time[-1] - first) / step) + 2.0)})
        self.filtered = filtered = FilteredScene(scene, plan, measured, stack, where, int((measured.time[-1] - first) / step))
        self.measure(measured)
        self.observable = Observability((), np.zeros(0), ())
        if not (self.again or filtered.model.large):
            self.observable = observability(filtered.model, self.measured, self.noise)

    def measure(self, measured: Measurements) -> None:
        """Measurements up to the same time as those that there are, in the place of these."""
        filtered, model = self.filtered, self.filtered.model
        model.held = None
        model.begin()
        self.measured = filtered.measured = measured.within(model.block.time, np.inf)
        self.left_out = int(measured.time.size - self.measured.time.size)
        if not self.measured.time.size:
            begin = f"{model.block.time:.6g} s"
            raise BadInput(
                f"{filtered.where}: measured",
                f"no sample behind {begin}",
                "some there: the filter begins behind the first macro steps",
            )
        self.noise = filtered.noise = self.measured.rough_noise()

    def _run(self, doubts: bool, smooth: bool) -> Filter:
        filtered = self.filtered.filter(doubts, smooth)
        filtered.run(self.measured)
        return filtered

    def _find_noise(self) -> bool:
        """Standard deviations that are not known: the residual behind an update times the innovation before it has the mean R
        (Desroziers et al. 2005; recalled). Whether they have changed."""
        unknown, first = np.flatnonzero(np.isnan(self.measured.noise)), self.noise.copy()
        for _ in range(NOISE_ROUNDS if unknown.size else 0):
            innovations, before = self._run(False, False).innovations, self.noise.copy()
            which, residual = np.array(innovations.which), np.array(innovations.residual)
            product = residual * (np.array(innovations.measured) - np.array(innovations.predicted))
            for k in unknown:
                self.noise[k] = np.sqrt(max(float(product[which == k].mean()), (1e-3 * before[k]) ** 2))
            if (np.abs(self.noise / before - 1.0) < NOISE_AGREES).all():
                break
        return bool((np.abs(self.noise / first - 1.0) > NOISE_AGREES).any())

    def _find_constants(self) -> None:
        """Where constants are linearised: at the maximum of their likelihood, or where a filter that begins there ends."""
        model, filtered = self.filtered.model, self.filtered
        self.known, self.moves = None, 0.0
        if filtered.name != EXTENDED or not model.constants.size:
            return
        if not model.disturbs:
            runs = Runs(model, self.measured, self.noise, self._threads)
            if self.coarse is None:
                self.known = posterior(runs)
            else:  # of the same maximum with other steps, all else is as it was
                at = runs.climb((self.coarse.at - runs.mean) / runs.deviation).u
                self.known = self.coarse.moved(runs.mean + runs.deviation * at - self.coarse.at)
            model.held = self.known.at
            return
        for _ in range(PASSES):
            belief, k = self._run(False, False).belief, model.constants
            moved = belief.q[k] - model.at[k]
            model.held = model.at.copy()
            model.held[k] = belief.q[k]
            self.moves = float(np.max(np.abs(moved) / np.sqrt((belief.Tq[k] ** 2).sum(axis=1))))
            if self.moves < STANDS:
                return

    def answer(self) -> Estimate:
        """Filter, smooth and judge."""
        self._find_noise()
        self._find_constants()
        if self._find_noise():
            self._find_constants()
        doubts = self.filtered.name == EXTENDED and not self.again
        done = self._run(doubts, self.plan.smooth)
        q, deviations = done.belief.q, np.sqrt((done.belief.Tq**2).sum(axis=1))
        parameters, remarks = self.filtered.parameters(done.belief), []
        if (known := self.known) is not None:
            q, deviations = known.mean, known.deviation
            done.track.end = known.columns(done.belief)
            every = zip(self.filtered.model.unknowns, q, deviations, zip(known.low, known.high, strict=True), strict=True)
            parameters, remarks = tuple(Parameter.of(*one) for one in every), known.remarks(self.filtered.model.unknowns)
        elif self.moves >= STANDS:
            text = f"constants do not settle: from pass to pass they move by {self.moves:.2g} standard deviations"
            remarks = [f"{text}. {MAY_NOT}"]
        filtered, model, innovations = self.filtered, self.filtered.model, done.innovations
        some, sensors = filtered.suspected, self.measured
        suspects = judged(model, some, sensors.signals, sensors.units, innovations) if doubts and some else []
        interfaces = model.scene.coupling.interfaces
        units = {".".join(end): interfaces[end[0]].outputs[end[1]].unit for end in model.block.signals}
        kept, names = list(filtered.columns), tuple(filtered.columns.values())
        seen = history(done.track, self.plan.smooth)
        seen = replace(seen, values=seen.values[:, kept], deviations=seen.deviations[:, kept])
        judgement = verdict(self.measured, innovations, model.unknowns, q, deviations, suspects)
        places = {name: k for k, name in enumerate(names)}
        remarks += parts_alone(model.scene, sensors.signals, lambda name: seen.values[:, places[name]])
        remarks += [f"{self.left_out} measurements lie before the first step, and are left out"] * bool(self.left_out)
        how = HOW[filtered.name].format(self.plan.members)
        why = "as asked for" if self.plan.filter else f"by default, {len(model.state)} states"
        return Estimate(
            model.scene,
            self.measured,
            f"{how} ({why}){', smoothed' if self.plan.smooth else ''}",
            self.observable,
            parameters,
            names,
            {n: units.get(n, "") for n in names},
            seen,
            history(done.track, False),
            innovations,
            self.noise,
            replace(judgement, remarks=(*remarks, *judgement.remarks)),
            figure_bands(filtered, done.track, filtered.where) if self.plan.smooth else (),
            posterior=self.known,
        )


def _with_numerical_errors(
    answer: Estimate, scene: Scene, plan: EstimateSettings, measured: Measurements, where: str
) -> Estimate:
    """Twice the change of the estimates when all steps are halved, with bands that hold it, too."""
    first = np.nextafter(min(answer.innovations.time), -np.inf)  # a shorter step would begin with earlier samples
    known = replace(measured.within(first, np.inf), noise=answer.noise)
    try:
        with ExitStack() as stack:
            halved = Record(scene.with_changes(shorter(scene, 2)), plan, known, stack, where, answer).answer()
    except (BadInput, StepFailed) as error:
        remarks = (*answer.verdict.remarks, f"no numerical error: with half of all steps, {error}")
        return replace(answer, verdict=replace(answer.verdict, remarks=remarks))
    if (gain := halved.log_likelihood - answer.log_likelihood) > WORSE:
        text = f"half of all steps explain the measurement better by {gain:.3g} log units: reduce master.step"
        answer = replace(answer, verdict=replace(answer.verdict, remarks=(*answer.verdict.remarks, text)))
    parameters = tuple(
        p.with_error(2.0 * abs(p.value - h.value)) for p, h in zip(answer.parameters, halved.parameters, strict=True)
    )
    again = {f.name: f.at_mean for f in halved.figures}
    figures = tuple(f.with_error(2.0 * abs(f.at_mean - again.get(f.name, np.nan))) for f in answer.figures)
    large = [p.name for p in parameters if p.error > LARGE * p.deviation]
    large += [f.name for f in figures if f.error > LARGE * f.deviation]
    if large:
        text = f"the numerical error of {', '.join(large)} is more than half of a standard deviation: reduce master.step"
        answer = replace(answer, verdict=replace(answer.verdict, remarks=(*answer.verdict.remarks, text)))
    own, other = answer.history, halved.history
    change = np.array([np.interp(own.time, other.time, v) for v in other.values.T]).T - own.values
    return replace(answer, parameters=parameters, figures=figures, steps=2.0 * np.abs(change))
