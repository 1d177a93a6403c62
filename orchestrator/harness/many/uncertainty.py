"""What uncertain parameters make of a quantity: its distribution, tolerance intervals, and how often it keeps its limits.

Tolerance intervals between order statistics (Wilks 1941): with n independent samples, a share p of all values lies between the
r-th smallest and the r-th largest with the probability 1 - B(p; n + 1 - 2 r, 2 r), B the distribution function of the beta
distribution. No shape of the distribution is assumed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput, counted
from ...output import write_table
from ...scene.scene import Scene
from ...scene.tolerances import tolerances_of
from ...session.session import Session
from ...settings.names import names_in
from ...settings.plan import SAMPLED, LimitSettings, PlanSettings
from ..sweep import AnswerOptions, Sweep, sweep
from .columns import column_name, for_columns
from .first_order import first_order as by_derivatives
from .limits import unconfirmed, with_rows
from .plan import plan_settings
from .repetition import blurred

CONTENT, CONFIDENCE = 0.95, 0.95
PERCENTILES = (2.5, 25.0, 50.0, 75.0, 97.5)
FEWEST = 8
SAMPLES = 100
SEEDS = 10_000  # from which samples take one each
FOR_TOLERANCE = 93  # samples, the fewest with a tolerance interval of this content and confidence


@dataclass(frozen=True)
class Spread:
    """A quantity over the samples. percentiles: at `PERCENTILES`.  tolerance: ends of the interval, NaN where there are too few
    samples for one.  count: samples that have a number."""

    quantity: str
    unit: str
    count: int
    mean: float
    deviation: float
    percentiles: tuple[float, ...]
    tolerance: tuple[float, float]


@dataclass(frozen=True)
class Inside:
    """How often a column keeps its limit. count: samples with a number, `inside` of them in the range.  low, high: interval of
    95 % of the probability, from independent samples (Clopper and Pearson, Biometrika 26 (1934) 404-413; from memory)."""

    column: str
    limit: LimitSettings | None  # None: all together
    count: int
    inside: int
    low: float
    high: float

    @property
    def probability(self) -> float:
        """Share of the samples, NaN without any."""
        return self.inside / self.count if self.count else float("nan")


@dataclass(frozen=True)
class Uncertainty:
    """spreads: of the quantities.  limits: how often each is kept, and all together.  messages: what a user should know.

    sweep: the runs.  values: of the samples, (n,) by column, by their runs or by first order; origin says which, in words.
    """

    sweep: Sweep
    spreads: tuple[Spread, ...]
    limits: tuple[Inside, ...] = ()
    messages: tuple[str, ...] = ()
    values: Mapping[str, np.ndarray] = field(default_factory=dict)
    origin: str = ""

    def __repr__(self) -> str:
        """A line a quantity: mean, standard deviation, the tolerance interval."""
        lines = [f"<Uncertainty of {self.sweep.scene.name}: {self.origin or 'stopped'}>"]
        for s in self.spreads:
            unit = f" {s.unit}" if s.unit != "1" else ""
            inside = (
                f", tolerance interval {s.tolerance[0]:.4g} to {s.tolerance[1]:.4g}{unit}"
                if np.isfinite(s.tolerance).all()
                else ""
            )
            lines.append(f"{s.quantity}: mean {s.mean:.5g}{unit}, deviation {s.deviation:.3g}{unit}{inside}")
        return "\n".join(lines)

    def save(self, directory: str | Path) -> list[Path]:
        """Write uncertainty.csv, and limits.csv where there are limits."""
        header = [
            "quantity",
            "unit",
            "samples",
            "mean",
            "standard deviation",
            *(f"{p:g} %" for p in PERCENTILES),
            "tolerance low",
            "tolerance high",
        ]
        rows: list[tuple[float | int | str, ...]] = [
            (s.quantity, s.unit, s.count, s.mean, s.deviation, *s.percentiles, *s.tolerance) for s in self.spreads
        ]
        files = [write_table(directory, "uncertainty.csv", header, rows)]
        if self.limits:
            header = [
                "column",
                "quantity",
                "unit",
                "low",
                "high",
                "standing",
                "source",
                "samples",
                "inside",
                "probability",
                "low (95 %)",
                "high (95 %)",
            ]
            files.append(
                write_table(
                    directory,
                    "limits.csv",
                    header,
                    [(i.column, *_limit_cells(i.limit), i.count, i.inside, i.probability, i.low, i.high) for i in self.limits],
                )
            )
        return files


def _limit_cells(limit: LimitSettings | None) -> tuple[float | str, ...]:
    """Quantity, unit, ends, standing and source of a limit, as a row has them."""
    if limit is None:
        return ("all limits together", "", "", "", "", "")
    ends = ("" if end is None else end for end in (limit.low, limit.high))
    return (limit.quantity, limit.unit, *ends, limit.standing, limit.source)


def probability(column: str, limit: LimitSettings | None, inside: np.ndarray) -> Inside:
    """Of truth values (n,): samples in the range."""
    from scipy.stats import beta

    n, k, tail = inside.size, int(inside.sum()), 0.5 * (1.0 - CONFIDENCE)
    low = float(beta.ppf(tail, k, n - k + 1)) if k > 0 else 0.0
    high = float(beta.ppf(1.0 - tail, k + 1, n - k)) if k < n else 1.0
    return Inside(column, limit, n, k, low, high)


def _kept(limits: Mapping[str, LimitSettings], values: Mapping[str, np.ndarray]) -> tuple[Inside, ...]:
    """How often each limit is kept, and all together; samples without a number do not count."""
    answers = []
    known = np.all([np.isfinite(values[name]) for name in limits], axis=0)
    together = np.ones(known.size, dtype=bool)
    for name, limit in limits.items():
        x = values[name]
        inside = np.array([limit.keeps(v) for v in x], dtype=bool)
        answers.append(probability(name, limit, inside[np.isfinite(x)]))
        together &= inside
    return (*answers, probability("", None, together[known])) if len(answers) > 1 else tuple(answers)


def tolerance_rank(n: int, content: float = CONTENT, confidence: float = CONFIDENCE) -> int:
    """The largest r such that the r-th smallest and largest of n samples hold a share `content` with `confidence`; 0: none."""
    from scipy.stats import beta

    r = np.arange(1, n // 2 + 1)
    return int(r[beta.sf(content, n + 1 - 2 * r, 2 * r) >= confidence].max(initial=0))


def plan_of_tolerances(scene: Scene, samples: int) -> dict[str, Any]:
    """Plain data of a plan that draws all tolerances of a scene, as normal distributions, and all seeds of its effects, at random.

    Raises `BadInput` for a scene that has neither.
    """
    tolerances = tolerances_of(scene)
    vary: dict[str, Any] = {}
    if tolerances is not None:
        numbers = zip(tolerances.names, tolerances.values.tolist(), tolerances.deviations.tolist(), strict=True)
        vary = {name: {"distribution": "normal", "mean": mean, "deviation": deviation} for name, mean, deviation in numbers}
    vary |= {name: list(range(SEEDS)) for name in Session(scene).seeds}
    if not vary:
        raise BadInput(
            f"{scene.name}: tolerances",
            "none, and no effect with a seed",
            "what is uncertain",
            'Give --plan, or tolerances of units, as in --set units.pantograph.tolerances.static_force="5 N".',
        )
    correlation = [[*names_in(pair), r] for pair, r in scene.correlations.items()]
    return {"method": "random", "points": samples, "vary": vary, **({"correlation": correlation} if correlation else {})}


def uncertainty(
    scene: Scene,
    plan: PlanSettings | Mapping[str, Any] | str | Path | None = None,
    directory: str | Path | None = None,
    *,
    quantities: Sequence[str] = (),
    limits: str = "",
    conditions: Sequence[str] = (),
    first_order: bool = True,
    samples: int = SAMPLES,
    **how: Unpack[AnswerOptions],
) -> Uncertainty:
    """Distributions of quantities over the samples of a plan, and the probability of keeping each of its limits.

    Without a plan `samples` of all tolerances and seeds of the scene, see `plan_of_tolerances`.

    `limits`, `conditions`: a validation table whose rows are limits as well, and which of them. `first_order`: samples follow from
    derivatives where some runs agree. `how`: as of a sweep. Raises `BadInput`.
    """
    settings = plan_settings(plan_of_tolerances(scene, samples) if plan is None else plan, scene=scene)
    if settings.method not in SAMPLED:
        raise BadInput("uncertainty", f"method {settings.method!r}", "one of " + ", ".join(SAMPLED))
    settings = with_rows(settings, table=limits, conditions=conditions, scene=scene)
    names, settings = for_columns(scene, settings, quantities, "uncertainty", settings.limits)
    tried = by_derivatives(scene, settings, [*names, *settings.limits], directory, **how) if first_order else None
    taken = tried is not None and (tried.holds or tried.runs.stopped is not None)
    runs = tried.runs if tried is not None and taken else sweep(scene, settings, directory, columns=names, **how)
    if runs.stopped is not None:
        return Uncertainty(runs, ())
    names = [column_name(runs.measures, name, "uncertainty") for name in names]
    origin, messages = f"{counted(len(runs.outcomes), 'sample')}", list[str]()
    values: Mapping[str, np.ndarray] = {name: x[runs.done] for name, x in runs.measures.items()}
    if tried is not None:
        judges = f"{counted(len(tried.runs.outcomes), 'run')}, at the ends and at random, differ from first order"
        so = "" if taken else ": all samples were run"
        messages = [f"{judges} by {100.0 * tried.rest:.2g} % of the standard deviation{so}"]
        if taken:
            values, origin = tried.values, f"{settings.points} samples by first order, {len(runs.outcomes)} of them run"
    spreads = tuple(spread(name, runs.units.get(name, ""), values[name]) for name in names)
    messages += _messages(runs, spreads, settings.method)
    return Uncertainty(runs, spreads, _kept(runs.plan.limits, values), tuple(messages), values, origin)


def spread(name: str, unit: str, values: np.ndarray) -> Spread:
    """Of values (n,), of which those that are not finite do not count."""
    x = np.sort(values[np.isfinite(values)])
    if x.size < FEWEST:
        raise BadInput(
            "uncertainty", f"{counted(x.size, 'run')} with {name!r}", f"{FEWEST} or more", "Look at the outcomes in sweep.csv."
        )
    r = tolerance_rank(x.size)
    ends = (float(x[r - 1]), float(x[-r])) if r else (float("nan"), float("nan"))
    return Spread(
        name, unit, x.size, float(x.mean()), float(x.std(ddof=1)), tuple(float(v) for v in np.percentile(x, PERCENTILES)), ends
    )


def _messages(runs: Sweep, spreads: Sequence[Spread], method: str) -> list[str]:
    texts = []
    if failed := sum(o != "done" for o in runs.outcomes):
        shares = " and the shares that keep limits" if runs.plan.limits else ""
        texts.append(
            f"{failed} of {len(runs.outcomes)} runs failed and are left out: the distributions{shares} are of what is left"
        )
    if any(np.isnan(s.tolerance[0]) for s in spreads):
        texts.append(f"too few samples for tolerance intervals of 95 % with 95 % confidence: they need {FOR_TOLERANCE}")
    intervals = ["tolerance intervals"] * bool(np.isfinite([s.tolerance for s in spreads]).any())
    intervals += ["the intervals of shares"] * bool(runs.plan.limits)
    if intervals and method != "random":
        texts.append(
            f"the confidence of {' and '.join(intervals)} is that of independent samples; those of method {method!r} are more "
            "even, so that it is not exact"
        )
    return [
        *texts,
        *runs.doubts,
        *unconfirmed(runs.plan.limits),
        *blurred(runs.repeated, {s.quantity: s.deviation for s in spreads}),
    ]
