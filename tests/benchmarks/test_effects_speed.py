"""What an effect costs while it is off: components against themselves with the source of every effect cut out."""

from __future__ import annotations

import time
from statistics import median

import pytest

from components.catalogue import component_class

from ..never_written import never_written

pytestmark = pytest.mark.benchmark

MOST = 1.03  # of the time of the component in which no effect was ever written
REPEATS = 15  # each, by turns
SPAN = 0.05  # s of real time that a measured run takes at least


@pytest.mark.parametrize("name", ["Pantograph", "BallBearing", "RovHull"])
def test_effects_that_are_off_cost_nothing(name):
    cls = component_class(name)
    pair = [cls(), never_written(cls)()]
    assert cls.effects

    def seconds(component, steps) -> float:
        component.initialize(0.0)
        begin = time.perf_counter()
        for k in range(steps):
            component.step(k * 1e-3, 1e-3)
        return time.perf_counter() - begin

    for component in pair:
        seconds(component, 10)  # compiles
    steps = max(round(1000 * SPAN / seconds(pair[0], 1000)), 1000)
    times = [[seconds(component, steps) for component in pair] for _ in range(REPEATS)]
    off, never = zip(*times, strict=True)
    ratio = min(off) / min(never)
    print(f"{name}: {1e6 * min(off) / steps:.2f} us a step; over never written: {ratio:.3f}, "
          f"median of pairs {median(a / b for a, b in times):.3f}")
    assert ratio <= MOST
