"""Which effects a scene calls for: the size of each, and the smallest set that keeps a tolerance.

Errors are against the scene with all effects that go together, with the scene's own numbers and steps: what differs then is the
physics alone. The size of an effect is the error without it and what cannot be without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any, Generic, TypeVar

from ....components.core.errors import BadInput
from ...output import write_table
from ...scene.scene import Scene
from ...units.component import make
from .full_model import Model, Place, effects_on, full_model, with_effects, with_required
from .quantities import Quantity, errors, percent, quantities_to_judge, recording
from .trial import Trial, trial

COLUMNS = {  # of effects.csv: field of a finding -> column
    "unit": "unit",
    "effect": "effect",
    "given": "on in the scene",
    "chosen": "chosen",
    "status": "status",
    "reason": "reason",
    "actual": "actual",
    "worst": "largest in",
    "breaking": "error of the set without it",
    "states": "states",
    "calls": "calls",
    "seconds": "seconds, s",
}
PATIENCE = 1.0  # s: a run is not repeated any more once its runs have taken this together


@dataclass(frozen=True)
class Finding:
    """One effect of one unit.

    given: whether the scene has it.  status: "measured", "required" (by the scene, or without it nothing runs),
    "left out" (of the full model) or "unable" (cannot be run with the scene's numbers), with the reason.
    actual: error of the full model without it; NaN where there is none, infinite where the run fails.  worst: quantity of it.
    states, calls, seconds: what it adds.  chosen: whether it is in the set.  breaking: error of the set without it, if it is in it.
    """

    unit: str
    effect: str
    given: bool
    status: str
    reason: str = ""
    actual: float = nan
    worst: str = ""
    states: int = 0
    calls: int = 0
    seconds: float = nan
    chosen: bool = False
    breaking: float = nan

    @property
    def name(self) -> str:
        """ "unit.effect"."""
        return f"{self.unit}.{self.effect}"

    def why(self, tolerance: float) -> str:
        """Why the effect is in the set, or is not."""
        if self.status == "left out":
            return self.reason
        if self.status == "unable":
            return f"with it the scene does not come to its end: {self.reason}"
        if self.status == "required":
            return f"required: {self.reason}"
        if not self.chosen:
            return f"error without it {percent(self.actual)}, without all that is left out within {percent(tolerance)}"
        if not isfinite(self.breaking):
            return f"without it the run fails: {self.reason}"
        return f"error without it {percent(self.breaking)}, more than {percent(tolerance)}"


@dataclass(frozen=True)
class Cost:
    """What a run of a whole model takes."""

    calls: int
    seconds: float
    error: float


@dataclass(frozen=True)
class Effects:
    """What a study found. scene: as it was given; chosen: with the smallest set.

    full, given, least: costs and errors of the model with all effects, of the scene as it was given, and of the chosen one.
    quantities: by name.  runs: that the study has made.
    """

    scene: Scene
    chosen: Scene
    tolerance: float
    findings: tuple[Finding, ...]
    full: Cost
    given: Cost
    least: Cost
    quantities: tuple[str, ...]
    runs: int

    def __repr__(self) -> str:
        """A line an effect: whether it is in the smallest set, and why."""
        lines = [f"<Effects of {self.scene.name}: the smallest set within {percent(self.tolerance)}>"]
        lines += [f"{'with' if f.chosen else 'without'} {f.name}: {f.why(self.tolerance)}" for f in self.findings]
        return "\n".join(lines)

    def save(self, directory: str | Path) -> Path:
        """Write effects.csv: one row an effect, the first line the column names."""
        values = [[getattr(f, field) for field in COLUMNS] for f in self.findings]
        rows = [[_yes(v) if isinstance(v, bool) else v for v in row] for row in values]
        return write_table(directory, "effects.csv", list(COLUMNS.values()), rows)

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data; a number that is not finite is None."""

        def plain(record: Cost | Finding) -> dict[str, Any]:
            return {k: v if not isinstance(v, float) or isfinite(v) else None for k, v in asdict(record).items()}

        return {
            "scene": self.scene.name,
            "tolerance": self.tolerance,
            "quantities": list(self.quantities),
            "runs": self.runs,
            "full": plain(self.full),
            "given": plain(self.given),
            "chosen": plain(self.least),
            "effects": [plain(f) | {"why": f.why(self.tolerance)} for f in self.findings],
        }

    def comments(self) -> list[str]:
        """Lines above the chosen scene in a file."""
        return [
            f"Of the scene {self.scene.name}: the effects whose absence shows by more than {percent(self.tolerance)};",
            f"error of this scene {percent(self.least.error)} against all effects.",
            *(
                f"{'with' if f.chosen else 'without'} {f.name}: {' '.join(f.why(self.tolerance).split())}"
                for f in self.findings
                if f.chosen or f.given
            ),
        ]


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def effects(
    scene: Scene, tolerance: float, *, more: Iterable[str] = (), on_message: Callable[[str], None] = lambda text: None
) -> Effects:
    """Measure every effect of a scene and find the smallest set that keeps `tolerance`, a share.

    more: effects, "unit.effect", that are taken into the full model beside those that go with the scene. `on_message` gets what
    is being done. Raises `BadInput` where the scene itself does not come to its end.
    """
    bench = _Bench(_looking(scene), (*scene.study.effects, *more), on_message)
    model, own = bench.model, effects_on(scene)
    groups: dict[Place, frozenset[Place]] = {}
    findings: dict[Place, Finding] = {}
    for place in model.places:
        on_message(f"without {'.'.join(place)}")
        findings[place] = bench.measured(Finding(*place, place[1] in own[place[0]], "measured"), model.dependents(place))
        if findings[place].status == "measured":
            groups[place] = model.dependents(place)
    on_message("the smallest set")
    chosen = select({p: findings[p].actual for p in groups}, groups, bench.error, tolerance)
    for place in groups:
        findings[place] = replace(findings[place], chosen=place not in chosen.dropped, breaking=chosen.breaking.get(place, nan))
    left = [Finding(*place, False, "left out", reason) for place, reason in model.left.items()]
    left += [Finding(*place, False, "unable", reason) for place, reason in bench.unable.items()]
    on = {u: tuple(e for e in names if (u, e) not in chosen.dropped) for u, names in model.on.items()}
    order = {place: k for k, place in enumerate((u, e) for u, cls in scene.component_classes.items() for e in cls.effects)}
    return Effects(
        scene,
        with_effects(scene, on),
        tolerance,
        tuple(sorted((*findings.values(), *left), key=lambda f: order[f.unit, f.effect])),
        bench.cost(frozenset()),
        bench.cost(frozenset(p for p in model.places if p[1] not in own[p[0]])),
        bench.cost(chosen.dropped),
        tuple(q.name for q in bench.quantities),
        bench.runs,
    )


def _looking(scene: Scene) -> Scene:
    """The scene with its recorded signals named: without those of its effects, where nobody has asked for them by name."""
    recorded = scene.coupling.signals
    if scene.record.signals is None:
        own = effects_on(scene)
        recorded = tuple((u, n) for u, n in recorded if "." not in n or n.partition(".")[0] not in own.get(u, ()))
    return recording(scene.with_changes({"record.signals": [".".join(end) for end in recorded]}))


class _Bench:
    """Runs models and remembers what they gave.

    model: the full one.  unable: effects that were to be in it, but with which the scene does not come to its end, and why.
    """

    def __init__(self, scene: Scene, more: Iterable[str], on_message: Callable[[str], None]):
        self.scene, self._on_message, self.runs = scene, on_message, 0
        self.quantities: tuple[Quantity, ...] = quantities_to_judge(scene)
        self.model, self.unable = full_model(scene, more), dict[Place, str]()
        on_message("all effects")
        full = self._trial(self.model.scene)
        if not full.done:
            full = self._build_up(full)
        self._trials: dict[frozenset[Place], Trial] = {frozenset(): full}

    def _trial(self, scene: Scene) -> Trial:
        self.runs += 1
        return trial(scene, patience=PATIENCE)

    def _build_up(self, failed: Trial) -> Trial:
        """Make the model of the scene's own effects, with one more effect after the other as long as it runs; gives its trial."""
        whole, on = self.model, {unit: set(names) for unit, names in effects_on(self.scene).items()}
        added = [(unit, effect) for unit, effect in whole.places if effect not in on[unit]]
        best = self._trial(self.scene) if added else failed
        if not best.done:
            raise BadInput(
                f"{self.scene.name}: effects", f"a scene that {best.outcome}: {best.reason}", "one that comes to its end"
            )
        for unit, effect in added:
            self._on_message(f"with {unit}.{effect}")
            trying = on | {unit: on[unit] | set(with_required(self.scene.component_classes[unit], effect))}
            extended = self._trial(with_effects(self.scene, _ordered(whole, trying)))
            if extended.done:
                on, best = trying, extended
            else:
                self.unable[unit, effect] = extended.reason
        kept = _ordered(whole, on)
        self.model = Model(with_effects(self.scene, kept), kept, whole.left)
        return best

    def measured(self, finding: Finding, dropped: frozenset[Place]) -> Finding:
        """The finding with sizes and costs; required where the scene does not even start without it."""
        without, full = self._without(dropped), self._trials[frozenset()]
        if without.outcome == "refused":
            return replace(finding, status="required", reason=without.reason, chosen=True)
        error, worst = self._error(without)
        states = _states(self.model.scene) - _states(self.model.without(dropped))
        finding = replace(finding, actual=error, worst=worst, reason=without.reason, states=states)
        if not without.done:
            return finding
        return replace(finding, calls=full.work["calls"] - without.work["calls"], seconds=_difference(full, without))

    def error(self, dropped: frozenset[Place]) -> float:
        """Error of the full model without some effects; infinite where it does not come to its end."""
        return self._error(self._without(dropped))[0]

    def cost(self, dropped: frozenset[Place]) -> Cost:
        """Of the full model without some effects."""
        without = self._without(dropped)
        return Cost(without.work.get("calls", 0), without.seconds, self._error(without)[0])

    def _without(self, dropped: frozenset[Place]) -> Trial:
        if dropped not in self._trials:
            try:
                self._trials[dropped] = self._trial(self.model.without(dropped))
            except BadInput as error:
                self._trials[dropped] = Trial("refused", str(error))
        return self._trials[dropped]

    def _error(self, without: Trial) -> tuple[float, str]:
        """The largest error, and of what; infinite where the run failed."""
        if not without.done:
            return inf, ""
        each = errors(self.quantities, without.history, self._trials[frozenset()].history)
        lost = [q.name for q in self.quantities if q.name not in each]
        if lost and (self.model.scene.study.quantities or not each):  # asked for, and an output of an effect that is left out
            return inf, lost[0]
        worst = max(each, key=lambda name: each[name])
        return each[worst], worst if each[worst] else ""


def _states(scene: Scene) -> int:
    return sum(make(name, scene.units[name]).x.size for name in scene.component_classes)


def _difference(full: Trial, without: Trial) -> float:
    """How much longer the full model's run takes, s; NaN where that is no more than the times of either scatter by."""
    if full.timing is None or without.timing is None:
        return nan
    longer = full.timing.seconds - without.timing.seconds
    return longer if all(abs(longer) > timing.spread for timing in (full.timing, without.timing)) else nan


def _ordered(model: Model, on: Mapping[str, Iterable[str]]) -> dict[str, tuple[str, ...]]:
    return {u: tuple(e for e in model.on[u] if e in set(names)) for u, names in on.items()}


T = TypeVar("T")


@dataclass(frozen=True)
class Selection(Generic[T]):
    """dropped: what can be left out together.  error: without all of it.  breaking: what stays -> the error without it, too."""

    dropped: frozenset[T]
    error: float
    breaking: Mapping[T, float]


def select(
    sizes: Mapping[T, float], groups: Mapping[T, frozenset[T]], error: Callable[[frozenset[T]], float], tolerance: float
) -> Selection[T]:
    """Leave out as much as the tolerance allows, what matters least first.

    sizes: error without each alone.  groups: each with what cannot be without it, and goes with it.  error: of a set that is
    left out; it is asked once for every set. Of what stays nothing can be left out alone: that is what `breaking` shows. Sets
    that would be smaller still, by two errors that cancel, are not looked for.
    """
    known: dict[frozenset[T], float] = {frozenset(): 0.0}

    def of(dropped: frozenset[T]) -> float:
        if dropped not in known:
            known[dropped] = error(dropped)
        return known[dropped]

    order = sorted(sizes, key=lambda name: sizes[name])
    small = [name for name in order if sizes[name] <= tolerance]
    least, most = 0, len(small)
    while least < most:  # all of the smallest ones together, as many as go
        middle = (least + most + 1) // 2
        least, most = (middle, most) if of(_joined(groups, small[:middle])) <= tolerance else (least, middle - 1)
    dropped = _joined(groups, small[:least])
    while True:  # then one by one, until a round leaves nothing out
        before = dropped
        for name in order:
            if name not in dropped and of(dropped | groups[name]) <= tolerance:
                dropped |= groups[name]
        if dropped == before:
            return Selection(dropped, of(dropped), {n: of(dropped | groups[n]) for n in order if n not in dropped})


def _joined(groups: Mapping[T, frozenset[T]], names: list[T]) -> frozenset[T]:
    return frozenset().union(*(groups[name] for name in names))
