"""What a worker process costs in a step, and what two of them gain on two cores.

Run with `pytest -n 0 tests/benchmarks --write-page` on a quiet machine.
"""

import os

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import input_, integer, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene

STEPS = 2000


class Busy(Component):
    """Computes for a while in each step; one core's worth of it."""

    work_per_step = integer(0, "iterations", low=0)
    u = input_(0.0, "1", "any number")
    result = output("1", "what has been computed")

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(1)
        return DONE

    def _step(self, t: float, h: float) -> int:
        x = self.x[0]
        for _ in range(self.parameters["work_per_step"]):
            x = 0.5 * x + 1.0
        self.x[0] = x
        self.refresh()
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[0] = self.x[0]


def seconds(work: int, isolation: str, steps: int = STEPS) -> float:
    """Of a run of two units under Jacobi, the best of three."""
    unit = {
        "component": "cosimo.tests.benchmarks.test_isolation_speed:Busy",
        "isolation": isolation,
        "parameters": {"work_per_step": work},
    }
    scene = read_scene(
        {
            "stop_time": 1.0,
            "units": {"a": unit, "b": unit},
            "connections": ["a.result -> b.u", "b.result -> a.u"],
            "master": {"algorithm": "jacobi", "step": 1.0 / steps},
        }
    )
    results = [run(scene) for _ in range(3)]
    assert all(r.outcome == "done" for r in results)
    return min(r.info.timing.run for r in results)


def test_a_step_in_a_worker_costs_less_than_two_hundred_microseconds(told):
    """Two messages through pipes and two changes of process; two cores with other work to do took 15 to 50 us a unit."""
    here, there = (seconds(0, way) / STEPS for way in ("none", "process"))
    told("workers", "a step of two trivial units, µs", in_process=1e6 * here, in_workers=1e6 * there)
    assert there - here < 400e-6  # two units


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="needs two cores")
def test_two_units_that_compute_gain_from_two_cores(told):
    """About a millisecond in each step, of which the messages are a small part."""
    here, there = (seconds(20_000, way, 400) for way in ("none", "process"))
    told("workers", "400 steps of two units that compute for a millisecond, s", in_process=here, in_workers=there)
    assert here / there > 1.5
