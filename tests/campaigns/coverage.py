"""How often bands of 95 % hold the truth: machines whose unknown numbers are drawn from what the plan expects, with noise of each seed.

python -m cosimo.tests.campaigns.coverage                 # the table of docs/estimation.md; an hour
python -m cosimo.tests.campaigns.coverage gimbal 5        # of one machine, with the seeds 0 to 4
python -m cosimo.tests.campaigns.coverage gimbal 5 half   # the truth takes half of the steps; estimates have their numerical errors
python -m cosimo.tests.campaigns.coverage gimbal 5 chance # no estimates: how far the noise alone pulls them

The truth has no disturbances; so the model has none either. Bands are those of noise alone: the numerical error stands beside them. So
the truth takes the model's steps. Where it takes half of them, bands hold less, and a remark has to say so. A mass on a spring has
disturbances; its truth is a closed form.
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
from cosimo.tests.estimation.machines import BEARING, CATENARY, GIMBAL, TROCAR, VEHICLE, WIND_PUMP, Machine
from cosimo.tests.estimation.oscillator import SIGNAL, Oscillator
from scipy.stats import beta

SEEDS = 100
NUMERICAL = "the numerical error of"  # a remark begins so
COARSE = {"bearing.displacement_x": 1e-6, "bearing.displacement_y": 1e-6}, {"body.outer_angle": 3e-3, "body.inner_angle": 3e-3}
MACHINES = {
    "bearing": replace(BEARING, noise=COARSE[0]),
    "gimbal": replace(GIMBAL, noise=COARSE[1]),
    "gimbal-near": replace(GIMBAL, noise=COARSE[1], unknown={n: {"deviation": "5 %"} for n in GIMBAL.unknown}),
    "trocar": TROCAR,
    "vehicle": VEHICLE,
    "catenary": CATENARY,
    "wind-pump": WIND_PUMP,
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


def draws(machine: Machine, seeds: Sequence[int], half: bool = False) -> Iterator[Draw]:
    """Of a machine; half: the truth takes half of the steps."""
    model = machine.model()
    step = (0.5 if half else 1.0) * model.master.step
    every = round(machine.every * machine.truth.get("master.step", model.master.step) / step)
    sampled, plan = replace(machine, every=every), machine.plan(states={}, suspected=[], smooth=False)
    with cosimo.open(machine.model(**{"master.step": step})) as truth:
        for seed in seeds:
            values = drawn(machine, model, seed)
            truth.reset()
            for name, value in values.items():
                truth[name] = value
            truth.initialize()
            truth.record()
            truth.until(model.stop_time)
            yield model, plan, values, sampled.measured(truth.result(), seed)


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
    count = int(arguments[1]) if len(arguments) > 1 else SEEDS
    half, chance = (word in arguments[2:] for word in ("half", "chance"))
    for name in arguments[:1] or (*MACHINES, SPRING):
        some = springs(range(count)) if name == SPRING else draws(MACHINES[name], range(count), half)
        if chance:
            pulls = chances(some)
            print(
                f"| {name} | mean {pulls.mean():.2f} | {', '.join(f'{p:.1f}' for p in np.sort(pulls)[::-1][:20])} |", flush=True
            )
        else:
            print(coverage(some, half).row(name), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
