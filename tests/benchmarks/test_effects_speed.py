"""What an effect costs while it is off: components against themselves with the source of every effect cut out."""

import time
from statistics import median

import pytest
from cosimo.components.catalogue import component_class
from cosimo.tests.contract.never_written import never_written

MOST = 1.03  # of the time of the component in which no effect was ever written
REPEATS = 301  # each, by turns: short ones, of which the least disturbed count
SPAN = 4e-3  # s of real time that a measured run takes


@pytest.mark.parametrize("name", ["Pantograph", "Thruster", "RovHull"])
def test_effects_that_are_off_cost_nothing(name, told):
    cls = component_class(name)
    pair = [cls(), never_written(cls)()]
    assert cls.effects

    def seconds(component, length) -> float:
        component.initialize(0.0)
        begin = time.perf_counter()
        component.step(0.0, length)  # one macro step: nothing but internal ones
        return time.perf_counter() - begin

    for component in pair:
        seconds(component, 1e-2)  # compiles
    length = SPAN / min(seconds(pair[0], 0.1) for _ in range(5)) * 0.1
    times = [[seconds(component, length) for component in pair] for _ in range(REPEATS)]
    off, never = zip(*times, strict=True)
    ratio = min(off) / min(never)
    told("off", name, over_never_written=ratio, median_of_pairs=median(a / b for a, b in times))
    assert ratio <= MOST
