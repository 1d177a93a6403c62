"""How evenly the railway pair steps as native FMUs in a C program, which is what hardware in the loop needs.

A minute of macro steps of 1 ms: passes over the part of the line that the scene covers, each from the state after initialization.
"""

import pytest
from cosimo.fmus.native.build import own_target
from cosimo.tests.fmus.native.railway_pair import run_host

pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="the host is a program for Linux")
STEP, STEPS, MINUTE = 1e-3, 6000, 60.0


def test_longest_step_of_a_minute(tmp_path):
    _, durations = run_host(tmp_path, STEP, STEPS, round(MINUTE / (STEP * STEPS)))
    print("\nnative railway pair, macro step of 1 ms, a minute: duration of a step in us")
    print(f"{'':12}{'mean':>10}{'99.99 %':>10}{'longest':>10}")
    for name, values in zip(("clock", "processor"), durations, strict=True):
        print(f"{name:12}" + "".join(f"{value:10.2f}" for value in values))
    assert durations[1][0] < 100.0  # a tenth of the macro step
