"""A user's own folders `components`, `fmus`, `orchestrator` and `tests` lie in the working directory and on PYTHONPATH."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

OWN_COMPONENT = """
import numpy as np

from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import output, parameter


class Ramp(Component):
    slope = parameter(2.0, "m/s", "slope")
    height = output("m", "height")

    def _initialize(self, t):
        self.x = np.zeros(1)
        return DONE

    def _step(self, t, h):
        self.x[0] += h * self.parameters["slope"]
        self._outputs(t + h)
        return DONE

    def _outputs(self, t):
        self.y[0] = self.x[0]
"""
OWN_SCENE = """
stop_time = 0.5
[units.ramp]
component = "components.ramps:Ramp"
[master]
step = 0.1
[sweep]
"ramp.slope" = [1.0, 3.0]
"""
SHIPPED = """
stop_time = 0.05
[units.pantograph]
component = "Pantograph"
effects = ["contact_loss"]
ISOLATION
[master]
step = 1e-3
"""
# Every module of the user's says that it was imported, so that one taken for ours is seen.
SPEAKING = "import sys\nprint('OWN', __name__, file=sys.stderr)\n"


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Path:
    """A folder of a user, with packages that have our folders' names and modules that have our modules' names."""
    root = tmp_path_factory.mktemp("project")
    for package, modules in {
        "components": ("catalogue", "core"),
        "fmus": ("build", "slave"),
        "orchestrator": ("run", "scene", "cli"),
        "tests": ("support",),
    }.items():
        (root / package).mkdir()
        for module in ("__init__", *modules):
            (root / package / f"{module}.py").write_text(SPEAKING)
    (root / "components" / "ramps.py").write_text(OWN_COMPONENT)
    (root / "own.toml").write_text(OWN_SCENE)
    return root


def cosimo(folder: Path, *arguments: str, own_path: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The command in a working directory; `-m` puts that first on the path, as PYTHONPATH does. In plain Python: no compiler."""
    path = [str(own_path)] if own_path else []
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": os.pathsep.join(path + [p for p in [os.environ.get("PYTHONPATH")] if p]),
    }
    done = subprocess.run(
        [sys.executable, "-m", "cosimo.orchestrator.cli", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def test_an_own_component_of_an_own_folder_called_components(project):
    done = cosimo(project, "run", "own.toml", "--in-process", "-o", "out", own_path=project)
    # its package and itself, nothing else of the project
    assert {line for line in done.stderr.splitlines() if line.startswith("OWN")} == {"OWN components"}
    last = (project / "out" / "result.csv").read_text().splitlines()[-1]
    assert [float(v) for v in last.split(",")] == pytest.approx([0.5, 1.0])


def test_a_sweep_of_it(project):
    done = cosimo(project, "sweep", "own.toml", "-o", "swept", own_path=project)
    assert "2 points, 0 failed" in done.stdout


@pytest.mark.first
@pytest.mark.parametrize("isolation", ["", 'isolation = "process"'], ids=["fmu", "worker process"])
def test_a_run_of_ours_is_bit_identical_and_imports_nothing_of_the_project(project, tmp_path, isolation):
    results = []
    for folder in (project, tmp_path):
        (folder / "ours.toml").write_text(SHIPPED.replace("ISOLATION", isolation))
        done = cosimo(folder, "run", "ours.toml", "-o", "ours", own_path=project if folder is project else None)
        assert "OWN" not in done.stderr
        results.append((folder / "ours" / "result.csv").read_bytes())
    assert results[0] == results[1]


def test_lists_are_ours(project, tmp_path):
    assert json.loads(cosimo(project, "list", "--json", own_path=project).stdout) == json.loads(
        cosimo(tmp_path, "list", "--json").stdout
    )
