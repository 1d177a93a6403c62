"""What a short run loads: what it does not need comes when it is needed."""

import json
import subprocess
import sys

import pytest
from cosimo.components.core.kernels import COMPILED

HEAVY = (
    "fmpy",
    "lxml",
    "pandas",
    "plotly",
    "jinja2",
    "pyarrow",
    "typer",
    "rich",
    "scipy.interpolate",
    "scipy.linalg",
    "numba.np.arraymath",
    "email.parser",
    "cosimo.fmus.build",
)
PROGRAM = """
import json, sys
from cosimo.components.core.closure import imports
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
scene = load_scene("mass-on-spring").with_changes({{"stop_time": 0.02}})
result = run(scene, in_process=True, output={output!r})
print(json.dumps([result.info["timing"]["compile"], imports.cache_info().misses, [m for m in {heavy!r} if m in sys.modules]]))
"""


def second_start(heavy: tuple[str, ...], output: str | None = None, program: str = PROGRAM) -> list:
    """[s of compiling, sources that were parsed, what of `heavy` was loaded] of a process that finds everything in the cache."""
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", program.format(heavy=heavy, output=output)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_a_second_start_compiles_nothing_parses_nothing_and_loads_no_libraries_that_it_does_not_use():
    assert second_start(HEAVY) == [0.0, 0, []]


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_a_run_that_is_verified_parses_nothing_either():
    verified = PROGRAM.replace("from cosimo.orchestrator.run.run import run", "from cosimo import run")
    assert second_start(tuple(m for m in HEAVY if m != "cosimo.fmus.build"), program=verified) == [0.0, 0, []]


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_writing_a_result_loads_arrow_and_no_pandas(tmp_path):
    assert second_start(("pandas", "pyarrow"), str(tmp_path / "out")) == [0.0, 0, ["pyarrow"]]
