"""A new master algorithm is one file and one line: those of docs/extending.md, in a copy of the package."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCENE = """
import json, sys
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import two_masses

def chain(algorithm):  # a mass that flies, and one that is taken along: no circle
    mass = {"component": "cosimo.tests.support:Mass", "parameters": {"k": 10.0, "v0": 2.0}}
    return {"stop_time": 1.0, "connections": ["a.x_out -> b.position", "a.v_out -> b.velocity"],
            "units": {"a": mass, "b": {"component": "cosimo.tests.support:Oscillator"}},
            "master": {"algorithm": algorithm, "step": 0.01}}

def bits(scene):
    result = run(read_scene(scene))
    return [result.outcome, *(result[name].tobytes().hex() for name in sorted(result.columns))]

circle = lambda algorithm: two_masses(algorithm, 0.01, 1)
print(json.dumps({name: [bits(scene("grouped")) == bits(scene(other)) for other in ("jacobi", "gauss-seidel")]
                  for name, scene in (("chain", chain), ("circle", circle))}))
"""


@pytest.fixture
def copy(tmp_path) -> Path:
    """The package with the algorithm of the page in it; all other files are links."""
    text = (ROOT / "docs" / "extending.md").read_text()
    code = next(block for block in re.findall(r"```py\n(.*?)```", text, re.DOTALL) if "class Grouped" in block)
    line = next(block for block in re.findall(r"```text\n(.*?)```", text, re.DOTALL) if "grouped:Grouped" in block)
    package, parts = tmp_path / "cosimo", [("orchestrator", "engine", "algorithms"), ("orchestrator", "settings")]
    opened = {part[:k] for part in parts for k in range(len(part) + 1)}  # folders that are no links
    for folder in sorted(opened, key=len):
        package.joinpath(*folder).mkdir()
        for entry in ROOT.joinpath(*folder).iterdir():
            if (*folder, entry.name) not in opened and not entry.name.startswith("."):
                package.joinpath(*folder, entry.name).symlink_to(entry)
    package.joinpath(*parts[0], "grouped.py").write_text(code)
    table = package.joinpath(*parts[1], "algorithms.py")
    whole = table.read_text()
    table.unlink()
    table.write_text(whole.replace('    "iterative":', f'{line}    "iterative":'))
    return tmp_path


def test_the_algorithm_of_the_page_steps_scenes(copy):
    """A chain as Gauss-Seidel, a circle as Jacobi, to the last bit."""
    environment = os.environ | {"PYTHONPATH": str(copy)}
    done = subprocess.run([sys.executable, "-c", SCENE], cwd=copy, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"chain": [False, True], "circle": [True, False]}
