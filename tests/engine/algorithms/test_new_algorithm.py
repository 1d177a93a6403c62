"""A new master algorithm is one file and one line: those of docs/extending.md, in a copy of the package."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
START = """
import json, sys
import numpy as np
from cosimo import BadInput, open as open_scene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import exact_two_masses, two_masses

def chain(algorithm):  # a mass that flies, and one that is taken along: no circle
    mass = {"component": "cosimo.tests.support:Mass", "parameters": {"k": 10.0, "v0": 2.0}}
    return {"stop_time": 1.0, "connections": ["a.x_out -> b.position", "a.v_out -> b.velocity"],
            "units": {"a": mass, "b": {"component": "cosimo.tests.support:Oscillator"}},
            "master": {"algorithm": algorithm, "step": 0.01}}

def bits(scene):
    result = run(read_scene(scene))
    return [result.outcome, *(result[name].tobytes().hex() for name in sorted(result.columns))]
"""
GROUPED = """
circle = lambda algorithm: two_masses(algorithm, 0.01, 1)
print(json.dumps({name: [bits(scene("grouped")) == bits(scene(other)) for other in ("jacobi", "gauss-seidel")]
                  for name, scene in (("chain", chain), ("circle", circle))}))
"""
CORRECTED = """
def error(step, degree, algorithm="predictor-corrector"):
    scene = read_scene({**two_masses(algorithm, step, degree), "record": {"signals": ["a.x_out", "b.x_out"]}})
    result = run(scene)
    assert result.outcome == "done", result.message
    return np.hypot(*(result[f"{u}.x_out"][-1] - x for u, x in zip("ab", exact_two_masses(1.0)[::2])))

def refusal(**changes):
    scene = two_masses("predictor-corrector")
    scene["master"] |= changes
    try:
        read_scene(scene)
    except BadInput as error:
        return str(error)

ratios = [error(2e-3, degree) / error(1e-3, degree) for degree in (0, 1, 2)]
better = error(1e-3, 1) / error(1e-3, 1, "jacobi")
with open_scene(read_scene({**two_masses("predictor-corrector", 0.01, 1), "record": {"signals": ["a.x_out"]}})) as sim:
    sim.initialize()
    sim.step(20)
    state = sim.save()
    sim.step(30)
    ends = [sim["a.x_out"]]
    sim.restore(state)
    sim.step(30)
    ends.append(sim["a.x_out"])
    kept = bytes(state)
with open_scene(read_scene({**two_masses("predictor-corrector", 0.01, 1), "record": {"signals": ["a.x_out"]}})) as sim:
    sim.restore(kept)
    sim.step(30)
    ends.append(sim["a.x_out"])
refusals = [refusal(order=["a", "b"]), refusal(iteration={"tolerance": 1e-6}), refusal(feedthrough="delayed")]
scene = chain("predictor-corrector")
try:
    read_scene(scene)
except BadInput as refused:
    refusals.append(str(refused))
print(json.dumps({"ratios": ratios, "better": better, "ends": ends, "refusals": refusals}))
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """The package with the algorithms of the page in it; all other files are links."""
    text, tmp_path = (ROOT / "docs" / "extending.md").read_text(), tmp_path_factory.mktemp("copy")
    codes = [block for block in re.findall(r"```py\n(.*?)```", text, re.DOTALL) if "(Algorithm)" in block]
    lines = [block for block in re.findall(r"```text\n(.*?)```", text, re.DOTALL) if "Abilities(" in block]
    package, parts = tmp_path / "cosimo", [("orchestrator", "engine", "algorithms"), ("orchestrator", "settings")]
    opened = {part[:k] for part in parts for k in range(len(part) + 1)}  # folders that are no links
    for folder in sorted(opened, key=len):
        package.joinpath(*folder).mkdir()
        for entry in ROOT.joinpath(*folder).iterdir():
            if (*folder, entry.name) not in opened and not entry.name.startswith("."):
                package.joinpath(*folder, entry.name).symlink_to(entry)
    for code, line in zip(codes, lines, strict=True):
        module = re.search(r'"(\w+):\w+"', line)[1]
        package.joinpath(*parts[0], f"{module}.py").write_text(code)
    table = package.joinpath(*parts[1], "algorithms.py")
    whole = table.read_text()
    table.unlink()
    table.write_text(whole.replace('    "iterative":', f'{"".join(lines)}    "iterative":'))
    return tmp_path


def answer(copy: Path, script: str) -> dict:
    environment = os.environ | {"PYTHONPATH": str(copy)}
    done = subprocess.run(
        [sys.executable, "-c", START + script], cwd=copy, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_an_order_of_the_page_steps_scenes(copy):
    """A chain as Gauss-Seidel, a circle as Jacobi, to the last bit."""
    assert answer(copy, GROUPED) == {"chain": [False, True], "circle": [True, False]}


def test_the_predictor_corrector_of_the_page(copy):
    """Its order is the degree + 1, its error below that of Jacobi; a session goes on from its states; options are refused."""
    given = answer(copy, CORRECTED)
    for ratio, order in zip(given["ratios"], (1, 2, 3), strict=True):
        assert ratio == pytest.approx(2.0**order, rel=0.1)
    assert given["better"] < 0.5
    assert given["ends"] == [given["ends"][0]] * 3
    for text, words in zip(
        given["refusals"],
        (
            ("master.order", "no effect on predictor-corrector", '"gauss-seidel"'),
            ("master.iteration", "no effect on predictor-corrector", '"iterative"'),
            ("master.feedthrough", "no effect on predictor-corrector", '"jacobi"'),
            ("master.algorithm", "feed one another in a circle"),
        ),
        strict=True,
    ):
        assert all(word in text for word in words), text
