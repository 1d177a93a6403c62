"""What a short run loads: what it does not need comes when it is needed."""

import json
import subprocess
import sys

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.commands import python

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
    "numba",
    "email.parser",
    "cosimo.fmus.build",
)
PROGRAM = """
import json, sys
from cosimo.components.core.closure import imports
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
scene = load_scene({scene!r}).with_changes({{"stop_time": 0.1}})
result = run(scene, in_process=True, output={output!r})
print(json.dumps([result.info.timing.compile, imports.cache_info().misses, [m for m in {heavy!r} if m in sys.modules]]))
"""


def second_start(
    heavy: tuple[str, ...], output: str | None = None, program: str = PROGRAM, scene: str = "mass-on-spring"
) -> list:
    """[s of compiling, sources that were parsed, what of `heavy` was loaded] of a process that finds everything in the cache."""
    for _ in range(2):
        source = program.format(heavy=heavy, output=output, scene=scene)
        done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True)
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


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
@pytest.mark.parametrize("scene", ["rov-station-keeping", "gimbal-scan", "en50318-2002"])
def test_the_compiler_is_not_loaded_where_machine_code_was_kept(scene):
    """With sampled controllers, an energy account, and a mesh."""
    assert second_start(("numba",), scene=scene) == [0.0, 0, []]


OF_FMUS = """
import sys
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.1})
print(run(scene).info.timing.compile, "numba" in sys.modules)
"""


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_what_fmus_compile_is_no_time_of_the_run(tmp_path):
    """Each has a package of its own, which loads the compiler."""
    for loaded in ("True", "False"):
        seconds, numba = python(OF_FMUS, NUMBA_CACHE_DIR=str(tmp_path)).split()
        assert (float(seconds) > 0.0, numba) == (loaded == "True", loaded)


OF_COMPONENTS = """
import json, sys
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
for cls in map(component_class, CATALOGUE):
    for effects in ((), *((effect,) for effect in cls.effects)):
        try:
            cls(effects)
        except BadInput:  # an effect that needs another one
            assert effects
print(json.dumps([m for m in {heavy!r} if m in sys.modules]))
"""


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_components_are_laid_out_without_the_compiler():
    """What their shapes ask of kernels, and of those that these call, is computed in Python."""
    assert second_start(("numba",), program=OF_COMPONENTS) == []


OF_SUMMARIES = """
import json, sys
from cosimo.orchestrator.systems import SYSTEMS
for system in SYSTEMS.values():
    system.summary
print(json.dumps([m for m in {heavy!r} if m in sys.modules]))
"""


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_summaries_are_made_without_the_compiler_and_plotly():
    """The command `run` makes one of every run."""
    assert second_start(("numba", "plotly", "jinja2", "pandas"), program=OF_SUMMARIES) == []
