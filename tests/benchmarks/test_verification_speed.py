"""What the errors beside the numbers cost: a verified run over the stepping of one without, CPU time, least of several in turns.

Run with `pytest -n 0 tests/benchmarks --write-page`.
Two runs have 1 + 2 times the steps, three 1 + 2 + 4 times; what is above is opening the
units again, comparing, and reading the figures from other rows.
"""

import cosimo
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

SCENES = (
    "en50318-2002",
    "en50318-2018-ac-simple",
    "gimbal-scan",
    "friction-drive-step",
    "rov-manoeuvre",
    "wind-pump-start",
    "pipe-robot-level",
    "wrist-motion",
    "critical-speed",
    "mass-on-spring",
)


@pytest.mark.parametrize("name", SCENES)
def test_a_verified_run_costs_its_steps_and_little_more(name, told):
    scene = load_scene(name)
    stepping, verifying, runs = [], [], 0
    cosimo.run(scene, in_process=True)
    for _ in range(7):
        stepping.append(run(scene, in_process=True).info.timing.cpu)
        verified = cosimo.run(scene, in_process=True).info
        verifying.append(verified.timing.cpu + verified.verification.seconds)
        runs = verified.verification.runs
    ratio, steps = min(verifying) / min(stepping), {2: 3, 3: 7}[runs]
    told("verification", f"`{name}`", runs=runs, steps_over_one_run=steps, stepping_ms=1e3 * min(stepping), over_stepping=ratio)
    if runs == 2:
        told.target(
            f"a verified run beside 3.2 times its stepping, `{name}`", 1e3 * (min(verifying) - 3.2 * min(stepping)), 20.0, "ms"
        )
    assert min(verifying) < 3.0 * steps * min(stepping) + 0.05  # s, of starts
