"""How evenly the railway pair steps as native FMUs in a C program, which is what hardware in the loop needs.

A minute of macro steps of 1 ms: passes over the part of the line that the scene covers, each from the state after initialization.
"""

import pytest
from cosimo.fmus.native.build import own_target
from cosimo.tests.fmus.native.railway_pair import run_host

pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="the host is a program for Linux")
STEP, STEPS, MINUTE = 1e-3, 6000, 60.0


def test_longest_step_of_a_minute(tmp_path, told):
    _, durations = run_host(tmp_path, STEP, STEPS, round(MINUTE / (STEP * STEPS)))
    for name, values in zip(("by the clock", "of the processor"), durations, strict=True):
        told("jitter", name, **dict(zip(("mean, µs", "99.99 %, µs", "longest, µs"), values, strict=True)))
    assert durations[1][0] < 100.0  # a tenth of the macro step
