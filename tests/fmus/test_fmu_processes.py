"""What only shows in a process of its own: leaks, name clashes, Numba's cache, a host without Numba."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from cosimo.fmus.build import built
from cosimo.tests.c_compiler import compile_c
from cosimo.tests.fmus.driver import HERE, extract, run_script

RUN = """
import math, sys
from cosimo.tests.fmus.driver import Driven

def answers(path, folder=None, steps=50):
    unit = Driven(path, folder).start({"effects.contact_loss": True})
    rows = []
    for k in range(steps):
        unit.set({"wire_height": 0.01 * math.sin(0.2 * k)})
        assert unit.step(k * 1e-3, 1e-3) == 0, unit.log
        rows += unit.reals(["contact_force", "head_height"])
    unit.free()
    return rows
"""


@pytest.fixture(scope="module")
def pantograph():
    return built("Pantograph")


@pytest.mark.full
def test_many_instances_leave_no_trace(pantograph):
    lines = run_script(
        RUN
        + """
import gc
path, folder = sys.argv[1:]
def resident():
    gc.collect()
    return int(open("/proc/self/statm").read().split()[1]) * 4096
answers(path, folder, 2)
entries = len(sys.path)
unit = Driven(path, folder)
for n in range(2000):
    if n % 10 == 0:
        unit.start()
        assert unit.step(0.0, 1e-3) == 0
    unit.fmu.fmi2FreeInstance(unit.fmu.component)
    unit.fmu.instantiate(callbacks=unit.callbacks, loggingOn=True)
    if n == 500:
        before = resident()
print(len(sys.path) - entries, resident() - before)
""",
        pantograph,
        extract(str(pantograph)),
    )
    entries, growth = map(int, lines[-1].split())

    assert entries == 0
    # pythonfmu itself loses about 1 kB an instance (reprs of the class's bases); a lost instance would be 20 kB and more
    assert growth < 1500 * 3_000


def test_two_bundles_of_one_name_keep_their_code(pantograph, tmp_path):
    """Here the FMU comes before its changed copy; the other order is one of the checks every FMU passes."""
    run_script(
        RUN
        + """
import os
from pathlib import Path
from cosimo.fmus.check_worker import changed_copy
path, directory = sys.argv[1:]
own = answers(path)
os.environ["COSIMO_CACHE"] = directory
assert set(answers(changed_copy(Path(path), Path(directory)))) == {1.0}
assert answers(path) == own != [1.0] * len(own)
""",
        pantograph,
        tmp_path,
    )


def test_a_hosts_own_checkout_is_not_used(pantograph):
    run_script(
        RUN
        + """
path = sys.argv[1]
from cosimo.components.railway import pantograph
class Broken:
    def __getattr__(self, name): raise AssertionError("the host's checkout was used")
for name in ("Pantograph", "pantograph_outputs", "pantograph_derivatives"):
    setattr(pantograph, name, Broken())
assert all(map(math.isfinite, answers(path)))
""",
        pantograph,
    )


@pytest.mark.full
def test_the_second_process_compiles_nothing(pantograph, tmp_path):
    script = (
        RUN
        + """
import gc
answers(sys.argv[1])
kernels = [o for o in gc.get_objects() if type(o).__name__ == "Kernel" and o.__module__.startswith("bundle_")]
bundle = next(m for m in sys.modules if m.startswith("bundle_") and m.endswith(".core.kernels"))
print(*sys.modules[bundle].compiled_from_cache(*kernels))
"""
    )
    first, second = (
        run_script(script, pantograph, COSIMO_CACHE=tmp_path, NUMBA_CACHE_DIR=tmp_path)[-1].split() for _ in range(2)
    )

    assert int(first[1]) > 0  # misses
    assert int(second[0]) > 0
    assert int(second[1]) == 0


@pytest.mark.full
def test_without_numba_the_answers_are_nearly_the_same(pantograph):
    lines = [
        run_script(block + RUN + "print(*answers(sys.argv[1]))", pantograph)[-1].split()
        for block in ("", "import sys; sys.modules['numba'] = None\n")
    ]

    # same equations; the compiler may order and contract operations: a few rounding errors a step, over 50 steps
    assert [float(v) for v in lines[1]] == pytest.approx([float(v) for v in lines[0]], rel=1e-9, abs=1e-12)


def test_the_only_imports_of_an_fmu_are_numpy_and_the_standard_library(pantograph):
    run_script(
        RUN
        + """
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"cosimo", "scipy", "pydantic", "numba"}:
            raise ImportError(name)
sys.meta_path.insert(0, Refused())
answers(sys.argv[1], steps=3)
""",
        pantograph,
    )


LIBPYTHON = Path(sysconfig.get_config_var("LIBDIR") or "", sysconfig.get_config_var("LDLIBRARY") or "none")


def run_host(name, folder, log="quiet", path=""):
    """Three instances of an FMU in the program of host.c, in a Python that finds what `path` holds first."""
    program = compile_c(folder / "host", "-w", HERE / "host.c", "-ldl")
    fmu = Path(extract(str(built(name))))
    environment = os.environ | {
        "LD_PRELOAD": str(LIBPYTHON),
        "PYTHONHOME": sys.base_prefix,
        "PYTHONPATH": os.pathsep.join(filter(None, (str(path), str(Path(np.__file__).parent.parent)))),
    }
    library, resources = fmu / "binaries" / "linux64" / f"{name}.so", (fmu / "resources").as_uri()
    command = [program, library, "", resources, log, "3", "20", "1e-3"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)


in_a_host = pytest.mark.skipif(LIBPYTHON.suffix != ".so", reason="needs a shared libpython")


@in_a_host
@pytest.mark.parametrize(
    "name", ["Pantograph", *(pytest.param(n, marks=pytest.mark.full) for n in ("DeepGrooveBearing", "AngularContactConductance"))]
)
def test_a_host_in_c_ends_in_order(name, tmp_path):
    """Without the loader's `end_in_order` this ends in "free(): corrupted unsorted chunks", or in a segmentation fault."""
    done = run_host(name, tmp_path)

    assert done.stderr.endswith("done\n"), done.stderr
    assert done.returncode == 0, done.stderr


@in_a_host
def test_a_python_without_numpy_is_one_clear_message(tmp_path):
    """pythonfmu puts "Fatal py exception encountered" in front of it."""
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'numpy'\", name='numpy')")
    done = run_host("Pantograph", tmp_path, "log", path=tmp_path)

    assert done.returncode == 3, done.stdout + done.stderr  # no instance
    assert done.stderr.count("log ") == 1
    assert "Pantograph needs numpy, which Python" in done.stderr
    assert "-m pip install numpy" in done.stderr
    assert "Traceback" not in done.stderr
