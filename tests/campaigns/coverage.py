"""How often bands of 95 % hold the truth: machines whose unknown numbers are drawn from what the plan expects, with noise of each seed.

python -m cosimo.tests.campaigns.coverage                # the table of docs/estimation.md; an hour or two
python -m cosimo.tests.campaigns.coverage gimbal 5       # of one machine, with the seeds 0 to 4
python -m cosimo.tests.campaigns.coverage gimbal 5 half  # the truth takes half of the steps; estimates have their numerical errors

The truth has no disturbances; so the model has none either. Bands are those of noise alone: the numerical error stands beside them. So
the truth takes the model's steps. Where it takes half of them, bands hold less, and a remark has to say so.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cosimo
import numpy as np
from cosimo.orchestrator.estimation.bounds import Bounds
from cosimo.orchestrator.estimation.posterior import MAY_NOT
from cosimo.orchestrator.scene.measured import positive
from cosimo.orchestrator.scene.names import declared
from cosimo.tests.estimation.machines import BEARING, CATENARY, GIMBAL, TROCAR, VEHICLE, WIND_PUMP, Machine

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


@dataclass
class Coverage:
    """names: of what is estimated.  inside: (seeds, p), whether each band holds the truth.  off: (seeds, p), in deviations.

    said: (seeds,) whether the verdict says that bands may not hold the truth, or rejects the model.
    """

    names: tuple[str, ...]
    inside: list[list[bool]] = field(default_factory=list)
    off: list[list[float]] = field(default_factory=list)
    said: list[bool] = field(default_factory=list)
    rejected: int = 0

    def row(self, machine: str) -> str:
        """Of the table."""
        shares = ", ".join(f"`{n}` {k}" for n, k in zip(self.names, np.sum(self.inside, axis=0), strict=True))
        share, rms = np.mean(self.inside), np.sqrt(np.mean(np.square(self.off)))
        cells = (
            machine,
            len(self.inside),
            shares,
            f"{100.0 * share:.1f} % of {np.size(self.inside)}",
            f"{rms:.2f}",
            self.rejected,
            f"{sum(self.said)}, {sum(self.said[k] and not all(inside) for k, inside in enumerate(self.inside))}"
            f" of {sum(not all(inside) for inside in self.inside)} whose bands do not hold",
        )
        return f"| {' | '.join(map(str, cells))} |"


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


def coverage(machine: Machine, seeds: Sequence[int], half: bool = False) -> Coverage:
    """Of the bands of a machine's unknown numbers; half: the truth takes half of the steps, and numerical errors are known."""
    model, found = machine.model(), Coverage(tuple(machine.unknown))
    step = (0.5 if half else 1.0) * model.master.step
    every = round(machine.every * machine.truth.get("master.step", model.master.step) / step)
    sampled = replace(machine, every=every)
    with cosimo.open(machine.model(**{"master.step": step})) as truth:
        for seed in seeds:
            values = drawn(machine, model, seed)
            truth.reset()
            for name, value in values.items():
                truth[name] = value
            truth.initialize()
            truth.record()
            truth.until(model.stop_time)
            data = sampled.measured(truth.result(), seed)
            plan = machine.plan(states={}, suspected=[], smooth=False)
            answer = cosimo.estimate(model, plan, data=data, halved=half)
            parameters = [answer[n] for n in found.names]
            found.inside.append([p.low < values[p.name] < p.high for p in parameters])
            off = [
                (p.bounds.inner(values[p.name]) - p.bounds.inner(p.value)) * p.bounds.slope(p.bounds.inner(p.value))
                for p in parameters
            ]
            found.off.append([o / p.deviation for o, p in zip(off, parameters, strict=True)])
            found.rejected += not answer.explains
            warned = any(text.startswith(NUMERICAL) or MAY_NOT in text for text in answer.verdict.remarks)
            found.said.append(warned or not answer.explains)
    return found


def main(arguments: Sequence[str]) -> None:
    """The rows of the table."""
    some = {arguments[0]: MACHINES[arguments[0]]} if arguments else MACHINES
    count = int(arguments[1]) if len(arguments) > 1 else SEEDS
    for name, machine in some.items():
        print(coverage(machine, range(count), "half" in arguments[2:]).row(name), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
