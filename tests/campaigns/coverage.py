"""How often bands of 95 % hold the truth: machines whose unknown numbers are drawn from what the plan expects, with noise of each seed.

python -m cosimo.tests.campaigns.coverage                   # the table of docs/estimation.md; an hour
python -m cosimo.tests.campaigns.coverage gimbal 5          # of one machine, with the seeds 0 to 4
python -m cosimo.tests.campaigns.coverage gimbal 5 half     # the truth takes half of the steps
python -m cosimo.tests.campaigns.coverage gimbal 5 solved   # the truth is solved from equations that share no code with the model
python -m cosimo.tests.campaigns.coverage gimbal 5 chance   # no estimates: how far the noise alone pulls them
python -m cosimo.tests.campaigns.coverage gimbal 5 wrong    # whether the verdict rejects a wrong model, and beside it the right one

The truth has no disturbances; so the model has none either. Bands without numerical errors are those of noise alone, and of a truth that
takes the model's steps. Where the truth takes half of them, or is solved, bands hold numerical errors, too. A mass on a spring has
disturbances; its truth is a closed form. Verdicts on a wrong model doubt what the tests doubt.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Any

import cosimo
import numpy as np
from cosimo.orchestrator.estimation.answer import Estimate
from cosimo.orchestrator.estimation.bounds import Bounds
from cosimo.orchestrator.estimation.estimate import Record
from cosimo.orchestrator.estimation.filtered_scene import plan_of
from cosimo.orchestrator.estimation.measurements import measurements_of
from cosimo.orchestrator.estimation.posterior import MAY_NOT, Runs
from cosimo.orchestrator.scene.measured import positive
from cosimo.orchestrator.scene.names import declared
from cosimo.tests.estimation.machines import BEARING, CATENARY, GIMBAL, LOST, TROCAR, VEHICLE, WIND_PUMP, Machine, Solved
from cosimo.tests.estimation.oscillator import SIGNAL, Oscillator
from cosimo.tests.systems.equations import gimbal_scan
from scipy.stats import beta

SEEDS = 100
SAME, HALF, SOLVED = "same", "half", "solved"  # the truth: of the model's steps, of half of them, of equations that share no code
NUMERICAL = "the numerical error of"  # a remark begins so
COARSE = {"bearing.displacement_x": 1e-6, "bearing.displacement_y": 1e-6}, {"body.outer_angle": 3e-3, "body.inner_angle": 3e-3}
TESTED = {"bearing": BEARING, "gimbal": GIMBAL, "trocar": TROCAR, "vehicle": LOST, "catenary": CATENARY, "wind-pump": WIND_PUMP}
MACHINES = {
    **TESTED,
    "vehicle": VEHICLE,
    "bearing": replace(BEARING, noise=COARSE[0]),
    "gimbal": replace(GIMBAL, noise=COARSE[1], solution=lambda t, values: gimbal_scan(t, *values.values())),
    "gimbal-near": replace(GIMBAL, noise=COARSE[1], unknown={n: {"deviation": "5 %"} for n in GIMBAL.unknown}),
}
SPRING = "spring"
Draw = tuple[cosimo.Scene, dict[str, Any], dict[str, float], dict[str, tuple[np.ndarray, np.ndarray]]]  # model, plan, truth, data


def interval(inside: np.ndarray) -> tuple[float, float]:
    """95 % interval of a share, of (seeds, p) that hold: exact (Clopper, Pearson 1934) for as many independent ones as the scatter
    from seed to seed says there are (Korn, Graubard 1998; recalled)."""
    share, n = float(inside.mean()), inside.size
    scatter = float(inside.mean(axis=1).var(ddof=1)) / len(inside) if len(inside) > 1 else 0.0
    effective = min(share * (1.0 - share) / scatter, n) if scatter > 0.0 else n
    k = share * effective
    low = float(beta.ppf(0.025, k, effective - k + 1.0)) if k > 0.0 else 0.0
    return low, float(beta.ppf(0.975, k + 1.0, effective - k)) if k < effective else 1.0


@dataclass
class Coverage:
    """names: of what is estimated.  inside: (seeds, p), whether each band holds the truth.  off: (seeds, p), in deviations.

    said: (seeds,) whether the verdict says that bands may not hold the truth, or rejects the model.
    """

    names: tuple[str, ...] = ()
    inside: list[list[bool]] = field(default_factory=list)
    off: list[list[float]] = field(default_factory=list)
    said: list[bool] = field(default_factory=list)
    rejected: list[bool] = field(default_factory=list)

    def add(self, values: Mapping[str, float], answer: Estimate) -> None:
        """Of a seed; values: the truth, by name."""
        self.names = tuple(values)
        parameters = [answer[n] for n in self.names]
        self.inside.append([p.low < values[p.name] < p.high for p in parameters])
        inner = [p.bounds.inner(p.value) for p in parameters]
        off = [(p.bounds.inner(values[p.name]) - q) * p.bounds.slope(q) for p, q in zip(parameters, inner, strict=True)]
        self.off.append([o / p.deviation for o, p in zip(off, parameters, strict=True)])
        self.rejected.append(not answer.explains)
        warned = any(text.startswith(NUMERICAL) or MAY_NOT in text for text in answer.verdict.remarks)
        self.said.append(warned or not answer.explains)

    def row(self, machine: str) -> str:
        """Of the table."""
        inside = np.array(self.inside)
        shares = ", ".join(f"`{n}` {k}" for n, k in zip(self.names, inside.sum(axis=0), strict=True))
        missed = ~inside.all(axis=1)
        cells = (
            machine,
            f"{len(inside)}: {shares}",
            f"{100.0 * inside.mean():.1f} % of {inside.size} ({_ends(inside)})",
            f"{np.sqrt(np.mean(np.square(self.off))):.2f}",
            f"{sum(self.rejected)} ({_ends(np.array(self.rejected)[:, None])})",
            f"{sum(self.said)}, {(missed & np.array(self.said)).sum()} of {missed.sum()} whose bands do not hold",
        )
        return f"| {' | '.join(cells)} |"


def _ends(inside: np.ndarray) -> str:
    return " to ".join(f"{100.0 * end:.1f}" for end in interval(inside))


def drawn(machine: Machine, scene: cosimo.Scene, seed: int) -> dict[str, float]:
    """Unknown numbers as the plan expects them, with the limits that they have."""
    rng, values = np.random.default_rng(10_000 + seed), {}
    with cosimo.open(scene) as sim:
        for name, given in machine.unknown.items():
            unit, parameter = name.split(".", 1)
            variable, start = declared(scene, unit)[parameter], float(sim[name])
            bounds = Bounds(variable.low, variable.high)
            q = bounds.inner(start)
            deviation = positive(given["deviation"], variable.unit, name, start) / bounds.slope(q)
            values[name] = bounds.outer(q + deviation * rng.standard_normal())
    return values


def truths(machine: Machine, values: Sequence[Mapping[str, float]], kind: str = SAME) -> Iterator[cosimo.Result | Solved]:
    """Of a machine with each of the values."""
    model = machine.model(**machine.happens)
    if kind == SOLVED:
        yield from (machine.truth(one) for one in values)
        return
    with cosimo.open(model.with_changes({"master.step": model.master.step * (0.5 if kind == HALF else 1.0)})) as truth:
        for one in values:
            truth.reset()
            for name, value in one.items():
                truth[name] = value
            truth.initialize()
            truth.record()
            truth.until(model.stop_time)
            yield truth.result()


def draws(machine: Machine, seeds: Sequence[int], kind: str = SAME) -> Iterator[Draw]:
    """Of a machine, for its bands."""
    model, plan = machine.model(), machine.plan(states={}, suspected=[], smooth=False)
    values = [drawn(machine, model, seed) for seed in seeds]
    for seed, one, truth in zip(seeds, values, truths(machine, values, kind), strict=True):
        yield model, plan, one, machine.measured(truth, seed)


def judged(machine: Machine, seeds: Sequence[int], wrong: bool) -> Iterator[bool]:
    """Whether a model is rejected with each seed: a wrong one, or the right one. There are no disturbances, as for bands."""
    model = machine.model(**(machine.wrong if wrong else {}))
    plan, true = machine.plan(states={}, smooth=False), machine if wrong else replace(machine, happens={})
    values = [drawn(machine, machine.model(), seed) for seed in seeds]
    some = zip(seeds, values, truths(true, values), strict=True)
    with ExitStack() as stack:
        for *_, record in recorded(((model, plan, one, machine.measured(truth, seed)) for seed, one, truth in some), stack):
            yield not record.answer().explains


def springs(seeds: Sequence[int]) -> Iterator[Draw]:
    """Of masses on springs that are kicked, whose stiffness is expected to 12 %; the verdict doubts what it does by default."""
    for seed in seeds:
        stiffness = 100.0 * np.exp(0.12 * np.random.default_rng(10_000 + seed).standard_normal())
        case = Oscillator(count=120, stiffness=stiffness)
        unknown = case.plan()["estimated"] | {"spring.stiffness": {"deviation": "12 %"}}
        data = {SIGNAL: (case.times, case.drawn(seed)[0])}
        yield case.scene(**{"spring.stiffness": 100.0}), case.plan(estimated=unknown), {"spring.stiffness": stiffness}, data


def coverage(drawn_: Iterator[Draw], halved: bool = False) -> Coverage:
    """Of the bands of unknown numbers; halved: with numerical errors."""
    found = Coverage()
    with ExitStack() as stack:
        for model, plan, values, data, record in recorded(drawn_, stack):
            found.add(values, cosimo.estimate(model, plan, data=data) if halved else record.answer())
    return found


def recorded(drawn_: Iterator[Draw], stack: ExitStack) -> Iterator[tuple[*Draw, Record]]:
    """Each with the record of its measurements, for which the scene is opened once."""
    record = None
    for model, plan, values, data in drawn_:
        wanted, where, folder = plan_of(plan)
        measured = measurements_of(wanted, model, folder, data, where)
        record = record or Record(model, wanted, measured, stack, where)
        record.measure(measured)
        yield model, plan, values, data, record


def chances(drawn_: Iterator[Draw]) -> np.ndarray:
    """(seeds,) how far the noise alone pulls estimates off the truth, squared: the length of its part along the derivatives there.

    It has the chi square distribution of p degrees of freedom, whatever the shape of the likelihood (Rao's score; recalled), and
    needs no estimate: seeds whose value is large have a truth that a right band seldom holds.
    """
    found = []
    with ExitStack() as stack:
        for _, _, values, _, record in recorded(drawn_, stack):
            model = record.filtered.model
            runs = Runs(model, record.measured, record.noise)
            q = np.array([u.bounds.inner(values[u.name]) for u in model.unknowns])
            _, v, J = runs((q - runs.mean) / runs.deviation)
            pull = J.T @ v
            found.append(float(pull @ np.linalg.solve(J.T @ J, pull)))
    return np.array(found)


def main(arguments: Sequence[str]) -> None:
    """The rows of the table."""
    count = range(int(arguments[1]) if len(arguments) > 1 else SEEDS)
    word = arguments[2] if len(arguments) > 2 else SAME
    for name in arguments[:1] or (*MACHINES, SPRING):
        if word == "wrong":
            found = (np.array(list(judged(TESTED[name], count, one))) for one in (True, False))
            cells = (f"{one.sum()} of {one.size} ({_ends(one[:, None])})" for one in found)
            print(f"| {name} | {' | '.join(cells)} |", flush=True)
            continue
        some = springs(count) if name == SPRING else draws(MACHINES[name], count, SAME if word == "chance" else word)
        if word == "chance":
            pulls = chances(some)
            print(
                f"| {name} | mean {pulls.mean():.2f} | {', '.join(f'{p:.1f}' for p in np.sort(pulls)[::-1][:20])} |", flush=True
            )
        else:
            print(coverage(some, word != SAME).row(name), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
