"""Masters of other makers as functions: a package in, histories of its signals out. Each run is a process of its own.

`COSIMO_INTEROP_PYTHON` names a Python that has the extra `interop` and what the FMUs need; without it, this one. A master that is
asked for, by this variable or by being installed, and cannot be imported is a failure; one that nobody installed is skipped.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

PYTHON = os.environ.get("COSIMO_INTEROP_PYTHON", sys.executable)
LIBCOSIM = """
import json, sys
from time import process_time
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

package, step, looks, every, signals = sys.argv[1], *map(json.loads, sys.argv[2:])
execution = CosimExecution.from_ssp_file(ssp_path=package, step_size=round(step * 1e9))
observer = CosimObserver.create_last_value()
execution.add_observer(observer=observer)
units = {u.name.decode(): u.index for u in execution.slave_infos()}
known = {n: {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=i)} for n, i in units.items()}
readers = {kind: getattr(observer, f"last_{kind}_values") for kind in ("real", "integer", "boolean")}
places = [(readers[kind], units[unit], known[unit][name]) for unit, name, kind in signals]
rows, began = [], process_time()
for _ in range(looks):
    assert execution.step(step_count=every)
    rows.append([float(read(slave_index=u, variable_references=[r])[0]) for read, u, r in places])
print("found " + json.dumps([rows, process_time() - began]))
"""
ECOS = """
import json, sys
from time import process_time
from ecospy import EcosSimulation

package, step, looks, every, signals = sys.argv[1], *map(json.loads, sys.argv[2:])
with EcosSimulation(ssp_path=package, step_size=step) as simulation:
    simulation.init(parameter_set="initialValues")
    readers = {"real": simulation.get_real, "integer": simulation.get_integer, "boolean": simulation.get_bool}
    rows, began = [], process_time()
    for _ in range(looks):
        simulation.step(every)
        rows.append([float(readers[kind](f"{unit}::{name}")) for unit, name, kind in signals])
    print("found " + json.dumps([rows, process_time() - began]), flush=True)
    simulation.terminate()
"""
# FMPy applies no parameter sets by itself, records every connector, and ends a step behind a sum of steps
FMPY = """
import json, sys, zipfile
from time import process_time
from types import SimpleNamespace
from xml.etree import ElementTree
from fmpy.ssp import simulation

package, step, looks, every, signals = sys.argv[1], *map(json.loads, sys.argv[2:])
spaces = {"ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription", "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues"}
root, parameters = ElementTree.fromstring(zipfile.ZipFile(package).read("SystemStructure.ssd")), []
for component in root.iterfind(".//ssd:Component", spaces):
    for parameter in component.iterfind(".//ssv:Parameter", spaces):
        value = parameter[0].get("value")
        if parameter[0].tag.rpartition("}")[2] in ("Real", "Integer", "Boolean"):
            number = float(value == "true") if value in ("true", "false") else float(value)
            parameters.append(SimpleNamespace(name=f"{component.get('name')}.{parameter.get('name')}", value=number))
steps, loop = [], simulation.do_step
simulation.do_step = lambda *given: (steps.append(process_time()), loop(*given))  # time of the loop alone
found = simulation.simulate_ssp(package, 0.0, (looks * every - 0.5) * step, step, SimpleNamespace(parameters=parameters))
rows = [[float(found[k * every - 1][f"{unit}.{name}"]) for unit, name, _ in signals] for k in range(1, looks + 1)]
print("found " + json.dumps([rows, steps[-1] - steps[0]]))
"""
PROGRAMS = {"libcosim": ("libcosimpy", LIBCOSIM), "Ecos": ("ecospy", ECOS), "FMPy": ("fmpy", FMPY)}
CLIENTS = ("libcosim", "Ecos")  # those that begin with the inputs of a package; FMPy's first step has 0 for each


def surroundings() -> dict[str, str]:
    """Environment of a process in which ecospy finds libtbb, which the package `tbb` lays beside the Python libraries."""
    folders = [str(Path(PYTHON).parent.parent / "lib"), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(folders)}


def require(master: str) -> None:
    """Skip the test where a master is not installed, fail it where one that should be there cannot be imported."""
    module = PROGRAMS[master][0]
    if "COSIMO_INTEROP_PYTHON" not in os.environ and find_spec(module) is None:
        pytest.skip(f"needs {module}, of the extra interop")
    there = subprocess.run([PYTHON, "-c", f"import {module}"], capture_output=True, text=True, env=surroundings())
    assert there.returncode == 0, f"{PYTHON} cannot import {module}: {there.stderr[-2000:]}"


def run_in(
    master: str, package: Path, step: float, looks: int, every: int, signals: Sequence[tuple[str, str, str]]
) -> tuple[np.ndarray, float]:
    """Values of signals, (looks, signals), after each `every` steps, from a master, and the CPU time of its steps, s.

    Skips the test where the master is missing.

    signals: (unit, name, "real", "integer" or "boolean"), in the order of the columns.
    """
    require(master)
    numbers = [repr(step), str(looks), str(every), json.dumps(signals)]
    done = subprocess.run(
        [PYTHON, "-c", PROGRAMS[master][1], str(package), *numbers],
        capture_output=True,
        text=True,
        timeout=600,
        env=surroundings(),
    )
    rows = [line.removeprefix("found ") for line in done.stdout.splitlines() if line.startswith("found ")]
    assert rows, f"{master} ended with {done.returncode}: {done.stderr[-2000:]}"
    values, seconds = json.loads(rows[0])
    return np.array(values), seconds
