"""Native FMUs in hosts that are C programs, with an empty environment: no Python is near.

Machine code for other machines runs in emulators. Their mathematics libraries differ from this one's in last digits.
"""

import re
import struct
import subprocess

import numpy as np
import pytest
from cosimo.fmus.native.build import library, own_target
from cosimo.fmus.native.machine_code import ALLOWED, TARGETS
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene_fmu import scene_library
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.fmus.native.machines import HERE, OTHERS, environment, program
from cosimo.tests.fmus.native.railway_pair import in_process, run_host
from cosimo.tests.fmus.native.support import amplitudes, driven, maker
from cosimo.tests.fmus.native.support import in_process as alone
from cosimo.tests.fmus.native.web_assembly import EXACT

pytestmark = [pytest.mark.full, pytest.mark.skipif(own_target() != "linux64", reason="the host is a program for Linux")]
STEPS = 300


def test_a_host_in_c_gives_the_bits_of_the_components_in_process(tmp_path):
    outputs, durations = run_host(tmp_path, 1e-3, 500, 2)
    assert outputs == in_process(1e-3, 500)
    assert all(0.0 < mean <= longest for mean, _, longest in durations)


@pytest.mark.parametrize("target", OTHERS)
def test_libraries_for_another_machine_give_the_same_numbers(target, tmp_path):
    outputs, _ = run_host(tmp_path, 1e-3, 500, 1, target)
    assert outputs == pytest.approx(in_process(1e-3, 500), rel=1e-12)


@pytest.mark.parametrize("target", OTHERS)
@pytest.mark.parametrize(("name", "effects"), [
    ("RovHull", ()), ("ServoMotor", ("inductance",)), ("GimbalBody", ("high_order",)), ("DeepGrooveBearing", ("outer_defect",)),
])  # fmt: skip
def test_driven_components_on_another_machine(target, name, effects, tmp_path):
    make = maker(name, effects)
    found, component = library(name, make, [target]), make()
    h = component.default_step
    expected = alone(component, h, STEPS)
    numbers = on_another_machine(found, target, tmp_path, h)
    assert np.ptp(expected, axis=0).any(), "nothing moves: the comparison would say nothing"
    worst = np.abs(numbers - expected).max(axis=0)
    print(f"{name} for {target}: differences over the size of an output up to {(worst / np.abs(expected).max(axis=0)).max():.1e}")
    assert (worst <= 1e-12 * np.abs(expected).max(axis=0)).all(), worst


@pytest.mark.parametrize("target", OTHERS)
@pytest.mark.parametrize("name", ["mass-on-spring", "en50318-2002", "gimbal-rotor"])
def test_scenes_on_another_machine(target, name, tmp_path):
    scene = load_scene(name)
    found, h = scene_library(scene, [target]), scene.master.step
    reference = run(scene.with_changes({"stop_time": STEPS * h, "record.interval": None}), in_process=True)
    outputs = [v.scalar.name for v in found.variables if v.role == "OUTPUT" and v.scalar.name in reference.columns]
    expected = np.column_stack([np.asarray(reference[name]) for name in outputs])
    numbers = outputs_on_another_machine(found, target, tmp_path, h, [], outputs, [[]] * STEPS)
    worst = np.abs(numbers - expected).max(axis=0) / np.maximum(np.abs(expected).max(axis=0), 1e-300)
    print(f"{name} for {target}: differences over the size of an output up to {worst.max():.1e}")
    assert (worst <= 1e-12).all(), worst


def on_another_machine(found, target, folder, h):
    """Outputs after initialization and after each step of a component that is driven as the one in process."""
    inputs = [form.format(name) for form in ("{}", "der({})", "der({},2)") for name in found.component.inputs]
    start = found.component.u[0].copy()
    moved = amplitudes(found.component, start)
    rows = [[v for row in driven(found.component, start, moved, k, h) for v in row] for k in range(STEPS)]
    return outputs_on_another_machine(found, target, folder, h, inputs, found.component.outputs, rows)


def outputs_on_another_machine(found, target, folder, h, inputs, outputs, rows):
    """Outputs after initialization and after each step; rows: values of the inputs in each step."""
    file = folder / (found.name + TARGETS[target].suffix)
    file.write_bytes(found.binaries[target])
    references = {v.scalar.name: k for k, v in enumerate(found.variables)}
    lines = [
        f"{len(inputs)} {len(outputs)} {len(rows)}",
        " ".join(str(references[n]) for n in [*inputs, *outputs]),
        *(" ".join(struct.pack(">d", v).hex() for v in row) for row in rows),
    ]
    command = [*program("driven.c", folder, target), str(file), found.token, repr(h)]
    done = subprocess.run(
        command, input="\n".join(lines), text=True, capture_output=True, env=environment(target, folder), check=False
    )
    assert done.returncode == 0, done.stderr
    return np.array([[float.fromhex(word) for word in line.split()] for line in done.stdout.splitlines()])


@pytest.mark.parametrize("target", [o for o in OTHERS if "linux-arm64" in o.values])
def test_functions_of_mathematics_libraries_differ_in_last_digits_only(target, tmp_path):
    """Why numbers differ at all: the machine code itself has the same operations in the same order."""
    flags = ("-fno-builtin", "-ffp-contract=off")
    count = 20_000
    found = []
    for where in ("linux64", target):
        folder = tmp_path / where
        folder.mkdir()
        command = [*program("functions.c", folder, where, *flags), str(count)]
        done = subprocess.run(command, capture_output=True, env=environment(where, folder), check=True)
        found.append(np.frombuffer(done.stdout).reshape(-1, count))
    names = re.findall(r"\{(\w+)_, ", (HERE / "functions.c").read_text())
    assert set(names) == {n for n in ALLOWED if not n.startswith("mem")}
    here, there = found
    units = dict(zip(names, (np.abs(here - there) / np.spacing(np.abs(here))).max(axis=1), strict=True))
    print({name: value for name, value in units.items() if value})
    assert {name for name in EXACT if units[name]} == set()
    assert max(units.values()) <= 4.0, units  # units in the last place
