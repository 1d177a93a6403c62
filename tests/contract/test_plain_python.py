"""The equations without the compiler: every configuration of every component, as a host without Numba would run it.

Numba takes seconds over each combination of effects, and these tests run each for some milliseconds: in plain Python, in a
process of their own, hundreds of combinations take less time than the compiler over a few.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.components.core.kernels import COMPILED

ROOT = Path(__file__).resolve().parents[2]
EVERYTHING = ("-m", "full or not full")
FILES = (
    "tests/contract/test_declaration.py",
    "tests/contract/test_effect_sizes.py",
    "tests/contract/test_steps.py",
    "tests/contract/test_hard_case_catalogue.py",
    # of these the compiled twins are in the complete run: many effects, short runs
    "tests/systems/drives/test_torque_motor.py tests/systems/drives/test_servo_motor.py",
    "tests/systems/railway/test_pantograph.py tests/systems/railway/test_lumped.py",
    "tests/systems/rov/test_thruster.py tests/systems/rov/test_rov_controller.py",
    "tests/systems/wrist/test_wrist_ligaments.py tests/systems/wrist/test_forearm_tendons.py",
    "tests/systems/wrist/test_wrist_motion.py",
    *(pytest.param(file, marks=pytest.mark.full) for file in (
        "tests/contract/test_effect_strength.py",
        "tests/contract/test_effects_absent.py",
        "tests/contract/test_effects_free.py",
        "tests/fmus/test_fmu_run.py",
        "tests/run/test_run.py",
        "tests/harness/report/test_short_runs.py",
        "tests/harness/studies/test_effects.py",
        "tests/harness/studies/test_selection.py",
    )),
)


@pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")
@pytest.mark.parametrize("files", FILES)
def test_without_the_compiler(files):
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *EVERYTHING, *files.split()]
    done = subprocess.run(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    assert done.returncode == 0, done.stdout[-20000:]
    assert " passed" in done.stdout
