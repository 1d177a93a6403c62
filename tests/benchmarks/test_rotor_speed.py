"""Speed of a beam rotor of 20 elements with two nonlinear bearings, against ROSS's Newmark response with linear ones.

Run with `pytest -n 0 tests/benchmarks --write-page`; COSIMO_ROSS_PYTHON names the interpreter of an environment with ross-rotordynamics and
plotly<6. Everything runs on one core at equal steps. ROSS compiles its Newmark loop at every start: both the first response
of a process, which is what a user waits for, and the next ones are printed.
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

STEPS, H = 2000, 1e-4
LENGTH, DIAMETER, SPEED, MOMENT = 0.6, 0.03, 500.0, 8e-5
DISK = {"mass": 8.0, "polar_inertia": 0.04, "diametral_inertia": 0.0225}
STIFFNESS, DAMPING = 5e7, 1250.0  # of a linear bearing, near the tangent of the nonlinear ones

ROSS = f"""
import json, time
import numpy as np
import ross as rs
steel = rs.Material("steel", rho=7810.0, E=211e9, G_s=81.2e9)
shaft = [rs.ShaftElement(L={LENGTH} / 20, idl=0.0, odl={DIAMETER}, material=steel) for _ in range(20)]
disk = rs.DiskElement(n=10, m={DISK["mass"]}, Ip={DISK["polar_inertia"]}, Id={DISK["diametral_inertia"]})
bearings = [rs.BearingElement(n=n, kxx={STIFFNESS}, cxx={DAMPING}) for n in (0, 20)]
rotor = rs.Rotor(shaft, [disk], bearings)
t = {H} * np.arange({STEPS} + 1)
force = np.zeros((t.size, rotor.ndof))
j = 10 * rotor.number_dof
force[:, j] = {MOMENT * SPEED**2} * np.cos({SPEED} * t)
force[:, j + 1] = {MOMENT * SPEED**2} * np.sin({SPEED} * t)
seconds = []
for _ in range(4):
    start = time.perf_counter()
    response = rotor.run_time_response({SPEED}, force, t, method="newmark")
    seconds.append(time.perf_counter() - start)
print(json.dumps([seconds[0], min(seconds[1:]), response.yout[-1, j], response.yout[-1, j + 1]]))
"""


@pytest.fixture(scope="module")
def ross(told):
    """Seconds of the first and of a later response, and the disk's last position, m."""
    python = os.environ.get("COSIMO_ROSS_PYTHON")
    if not python:
        pytest.skip("COSIMO_ROSS_PYTHON does not name a Python with ross-rotordynamics and plotly<6")
    threads = {f"{n}_NUM_THREADS": "1" for n in ("OMP", "OPENBLAS", "MKL")}
    done = subprocess.run(
        [python, "-W", "ignore", "-c", ROSS], capture_output=True, text=True, check=True, env={**os.environ, **threads}
    )
    first, later, x, y = json.loads(done.stdout.splitlines()[-1])
    told("rotor", "ROSS, Newmark, linear bearings", µs_a_step=1e6 * later / STEPS, first_response_of_a_process_s=first)
    return first, later, x, y


def rotor_parameters():
    numbers = {
        "length": LENGTH,
        "outer_diameter": DIAMETER,
        "element": LENGTH / 20,
        "watched_position": 0.5 * LENGTH,
        "start_speed": SPEED,
        "substep": H,
        "unbalance.moment[1]": MOMENT,
    }
    numbers |= {f"disks.{n}[{k}]": v * (k == 1) for n, v in DISK.items() for k in (1, 2)}
    return numbers | {"disks.position[1]": 0.5 * LENGTH, "disks.position[2]": 0.0}


def linear_rotor():
    """The rotor of the ROSS program; supports are a part of it."""
    supports = {"linear_supports.position[1]": 0.0, "linear_supports.position[2]": LENGTH}
    supports |= {
        f"linear_supports.{n}_{axis}[{k}]": v
        for n, v in (("stiffness", STIFFNESS), ("damping", DAMPING))
        for axis in "xy"
        for k in (1, 2)
    }
    return BeamRotor(("gyroscopic", "disks", "unbalance", "linear_supports"), rotor_parameters() | supports)


def nonlinear_scene():
    """Rotor and two deep groove bearings, coupled through their tangents."""
    rotor = {n.replace("]", ""): v for n, v in rotor_parameters().items()}
    tables: dict = {}
    for name, value in rotor.items():
        group, _, rest = name.partition(".")
        if not rest:
            tables[name] = value
        else:
            tables.setdefault(group, {}).setdefault(rest.split("[")[0], []).append(value)
    tables |= {"bearing_a": {"position": 0.0}, "bearing_b": {"position": LENGTH}}
    return load_scene("rotor-run-up").with_changes(
        {
            "stop_time": STEPS * H,
            "master.step": H,
            "units.rotor.parameters": tables,
            "units.rotor.effects": ["gyroscopic", "disks", "unbalance", "gravity", "bearing_a", "bearing_b"],
            "record": {"signals": ["rotor.displacement_x", "rotor.displacement_y"]},
        }
    )


def best(scene, in_process):
    """Shortest stepping time of several warm runs, s."""
    results = [run(scene, in_process=in_process) for _ in range(5)]
    assert all(r.outcome == "done" for r in results)
    return min(r.info.timing.run for r in results[1:])


def test_linear_bearings_at_equal_steps(ross, told):
    """The same model with the same method: equal results, at least 20 times faster."""
    _, later, x, y = ross
    seconds = []
    for _ in range(6):
        rotor = linear_rotor()
        rotor.initialize(0.0)
        start = time.perf_counter()
        for k in range(STEPS):
            rotor.step(k * H, H)
        seconds.append(time.perf_counter() - start)
    mine = min(seconds[1:])
    told("rotor", "cosimo, linear bearings in the rotor", µs_a_step=1e6 * mine / STEPS, ratio=later / mine)
    assert rotor.nodes.size == 21
    # both are of second order; after 100 rad of unbalance they differ by the shift in phase, 100 (w h)²/12 = 2 %, or less
    assert abs(complex(rotor["displacement_x"], rotor["displacement_y"]) - complex(x, y)) < 0.05 * abs(complex(x, y))
    assert later / mine >= 20.0


def test_nonlinear_bearings_in_process_and_as_fmus(ross, told):
    """Three units with contact, clearance and passing balls against a linear system in one compiled loop.

    Some 13 us of a step are kernels, the rest is the handling of 130 signals: twenty times ROSS's first response,
    compilation included, is reached, twenty times its later ones is not.
    """
    first, later, _, _ = ross
    scene = nonlinear_scene()
    for label, in_process, least in (("one process", True, 20.0), ("three FMUs", False, 10.0)):
        mine = best(scene, in_process)
        told("rotor", f"cosimo, two deep groove bearings, {label}", µs_a_step=1e6 * mine / STEPS, ratio=later / mine)
        assert first / mine >= least


def test_a_whole_job_in_a_fresh_process(ross, told):
    """Import, start and 0.2 simulated seconds: kernels come from the disk cache."""
    first = ross[0]
    program = f"""
import time
start = time.perf_counter()
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from {Path(__file__).stem} import nonlinear_scene, run
assert run(nonlinear_scene(), in_process=True).outcome == "done"
print(time.perf_counter() - start)
"""
    for _ in range(2):  # the first one may have to compile
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    mine = float(done.stdout.split()[-1])
    told("rotor", "the same, one process", first_response_of_a_process_s=mine)
    assert mine < first
