"""Questions of a validation case: scenes to run, and what is measured in their results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from ...judgement.advice import remedy
from ...run.instability import unfollowed
from ...run.run import run
from ...scene.shorter_steps import runs_with
from ..charts.described import Described, with_numbers

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene
    from ...settings.chart import ChartSettings
    from ..charts.chart import Chart, Grid
    from .reference import Row, TableRow


@dataclass(frozen=True)
class Options:
    """How a case runs its scenes."""

    in_process: bool = False
    progress: bool = False


class RunFailed(Exception):
    """A run of a case did not reach its end."""

    def __init__(self, label: str, result: Result):
        self.label, self.result = label, result
        super().__init__(result.message)


def done(result: Result, label: str = "") -> Result:
    """A result that reached its end; raises `RunFailed` for any other. A signal that stopped the run takes its usual effect."""
    if result.unless_stopped().outcome != "done":
        raise RunFailed(label or result.scene.name, result)
    return result


def named(label: Any) -> str:
    """The label of a run as a text; one of several parts has them behind commas."""
    return ", ".join(map(str, label)) if isinstance(label, tuple) else str(label)


def _fits(label: str, patterns: Iterable[str]) -> bool:
    return any(fnmatchcase(label, p) for p in patterns)


class Runs(dict[Any, "Result"]):
    """Results of a question's scenes by their labels; `run` gives that of a further scene, such as one that depends on them.

    doubts: what they say that their coupling may be unstable, of those that are not expected to fail, nor asked for that.
    """

    def __init__(
        self, options: Options, scenes: Mapping[Any, Scene], may_fail: Collection[str] = (), at_its_steps: Collection[str] = ()
    ):
        self.options = options
        self.doubts: list[str] = []
        super().__init__()
        for label, scene in scenes.items():
            text = named(label)
            self[label] = self.run(scene, may_fail=_fits(text, may_fail), label=text, at_its_steps=_fits(text, at_its_steps))

    def run(self, scene: Scene, *, may_fail: bool = False, label: str = "", at_its_steps: bool = False) -> Result:
        """The result of a scene; raises `RunFailed` where it does not reach its end and is not expected to fail.

        at_its_steps: a repetition leaves its steps, as they are what is asked about: growth a step, the longest stable step.
        """
        with runs_with(parts=1) if at_its_steps else nullcontext():
            result = run(scene, in_process=self.options.in_process, progress=self.options.progress, remedy=remedy)
        if may_fail:
            return result.unless_stopped()
        doubts = [] if at_its_steps else unfollowed(result.info.missed)
        self.doubts += [f"{label or scene.name}: {text}" for text in doubts]
        return done(result, label)


@dataclass(frozen=True)
class Evidence:
    """The numbers that runs give for a question, with figures, runs worth showing, and sentences.

    numbers: {measure: number} with the `measure` of the table's rows; of a table with several conditions also
    {condition: {measure: number}}.
    rows: rows of references that the case computes itself.  shown: label -> result.
    claim: number of the paper's claim whose rows the figures stand below; without it they come after all claims.
    data: name -> further numbers for charts and texts: arrays, tables of a name -> array or -> (x, y), (x, y, values) of a picture.
    settings: condition -> how its numbers were computed (window, filter).  doubts: what may be a defect; `ask` adds those of `Runs`.
    """

    numbers: Mapping[str, float | Mapping[str, float]] = field(default_factory=dict)
    charts: tuple[Chart | Grid, ...] = ()
    shown: Mapping[str, Result] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    claim: str = ""
    rows: tuple[Row, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Question:
    """One question of a case: `measure(runs)` gives the evidence from the results of the scenes, which the harness runs.

    measure: gives `Evidence`, or just the numbers by the measures of the table's rows.
    scenes: function that gives the scenes by label; without it nothing is run before.  may_fail: patterns of labels of runs that
    may end before their end; any other run that does fails the case.
    at_its_steps: patterns of labels of runs whose steps are what is asked about, so that a repetition leaves them.
    in_process: runs are in process whatever is asked for: there are many short ones.
    claim, charts, notes, show: what the case's file says, see `settings.case.QuestionSettings`.  rows: for the ranges in charts.
    """

    measure: Callable[[Runs], Evidence | Mapping[str, Any]]
    scenes: Callable[[], Mapping[Any, Scene]] = dict
    may_fail: Collection[str] = ()
    in_process: bool = False
    at_its_steps: Collection[str] = ()
    claim: str = ""
    charts: tuple[ChartSettings, ...] = ()
    notes: tuple[str, ...] = ()
    show: tuple[str, ...] = ()
    rows: Callable[[], Mapping[str, TableRow]] = dict

    def ask(self, options: Options) -> Evidence:
        """Run the scenes and measure. Raises `RunFailed`; `StepFailed` of a component that is stepped alone."""
        if self.in_process:
            options = replace(options, in_process=True)
        runs = Runs(options, self.scenes(), self.may_fail, self.at_its_steps)
        answer = self.measure(runs)
        evidence = answer if isinstance(answer, Evidence) else Evidence(answer)
        by_label = {named(label): result for label, result in runs.items()}
        numbers = {**evidence.numbers, **evidence.data}
        drawn = Described("chart", numbers, by_label, self.rows)
        return replace(
            evidence,
            claim=self.claim or evidence.claim,
            charts=(*map(drawn.chart, self.charts), *evidence.charts),
            notes=(*evidence.notes, *(with_numbers(note, numbers) for note in self.notes)),
            shown={**evidence.shown, **{label: r for label, r in by_label.items() if _fits(label, self.show)}},
            doubts=(*evidence.doubts, *runs.doubts),
        )
