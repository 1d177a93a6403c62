"""Systems written here, run by libcosim. `COSIMO_LIBCOSIM_PYTHON` names a Python that has libcosimpy; without it, this one."""

import json
import os
import subprocess
import sys

import pytest
from cosimo.orchestrator.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.systems import read_scene

PYTHON = os.environ.get("COSIMO_LIBCOSIM_PYTHON", sys.executable)
CLIENT = """
import json, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=int(sys.argv[2]))  # ns
observer = CosimObserver.create_last_value()
execution.add_observer(observer=observer)
assert execution.step(step_count=int(sys.argv[3]))
found = {}
for unit in execution.slave_infos():
    for variable in execution.slave_variables(slave_index=unit.index):
        if variable.name.decode() in ("x", "y"):
            (value,) = observer.last_real_values(slave_index=unit.index, variable_references=[variable.reference])
            found[f"{unit.name.decode()}.{variable.name.decode()}"] = value
print("found " + json.dumps(found))
"""


def libcosim(*arguments: object) -> dict[str, float]:
    """Values of the outputs after some steps, from a process of its own: a fault of libcosim ends the process."""
    if subprocess.run([PYTHON, "-c", "import libcosimpy"], capture_output=True).returncode:
        pytest.skip("needs libcosimpy")
    done = subprocess.run([PYTHON, "-c", CLIENT, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(next(line for line in done.stdout.splitlines() if line.startswith("found ")).removeprefix("found "))


def test_libcosim_comes_to_the_same_numbers(folder):
    """Jacobi with held inputs and no feed-through within an instant is what libcosim does; units of measure are converted by
    a transformation, parameters of three types are set."""
    scene = read_scene({
        "stop_time": 1.0,
        "units": {"a": {"fmu": str(folder / "metres.fmu"), "parameters": {"u": 0.3, "count": 1, "flag": True, "text": "abc"}},
                  "b": {"fmu": str(folder / "mixed.fmu"), "parameters": {"gain": 1.5}}, "c": {"fmu": str(folder / "metres.fmu")}},
        "connections": ["a.y -> b.u", {"source": "b.x", "target": "c.u", "factor": 0.1, "offset": 2.0}],
        "master": {"algorithm": "jacobi", "step": 0.01, "extrapolation": 0, "feedthrough": "delayed"},
    }, "adders", folder)
    ours = {name: column[-1] for name, column in run(scene).columns.items()}
    theirs = libcosim(write(scene, folder / "there.ssp"), 10_000_000, 100)
    assert theirs["b.x"] == pytest.approx(1000.0 * 30101.3, rel=1e-13)  # a.y, in mm, over one second
    moved = [n for n in ours if n != "c.y"]  # which follows c's input: libcosim shows it with that of the step before
    assert [theirs[n] for n in moved] == pytest.approx([ours[n] for n in moved], rel=1e-13)  # rounding of 100 steps
    assert theirs["c.y"] == pytest.approx(2.0 + 0.1 * 1000.0 * 30101.3 * 0.99, rel=1e-13)
