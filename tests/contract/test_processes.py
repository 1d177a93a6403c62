"""What only shows in a process of its own: the kernels' cache on disk, and the same source without Numba."""

import json
import pickle

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.commands import python
from cosimo.tests.contract.configurations import FACTS, SMALL
from cosimo.tests.short_run import ONE_A_SYSTEM

SHORT_RUNS = """
import json, sys
import numpy as np
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.kernels import compiled_from_cache

def run(component, effects, parameters, steps):
    made = component_class(component)(effects, parameters)
    made.initialize(0.0)
    for k in range(steps):
        made.u[1] = 0.3 * np.array([made.variables[n].nominal for n in made.inputs])
        made.step(k * 1e-3, 1e-3)
    return [*made.y.tolist(), *made.x.tolist()]
"""

FEW = ("Pantograph",)
SECOND_PROCESS = """
for name in SMALL:
    run(name, (), SMALL[name], 1)
kernels = {id(k): k for m in list(sys.modules.values()) if m.__name__.startswith("cosimo.components.")
           for space in (vars(m), *(vars(c) for c in vars(m).values() if isinstance(c, type)))
           for k in space.values() if type(k).__name__ == "Kernel"}
print(json.dumps(compiled_from_cache(*kernels.values())))
"""

RUNS = {name: (name, list(FACTS[name].plain[0]), {**FACTS[name].plain[1]}, FACTS[name].plain[2]) for name in CATALOGUE}
for name in CATALOGUE:
    for way, effects in FACTS[name].other_ways:
        _, parameters, steps = FACTS[name].plain
        RUNS[f"{name}, {way}"] = (name, list(effects), {**parameters, **way}, steps)


@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compile")
@pytest.mark.full
def test_a_second_process_compiles_nothing(tmp_path):
    """In a cache of its own: other tests compile at the same time, and Numba's index of a cache is not made for that."""
    source = f"{SHORT_RUNS}\nSMALL = { {name: SMALL[name] for name in ONE_A_SYSTEM}!r}{SECOND_PROCESS}"
    hits, misses = json.loads(python(source, NUMBA_CACHE_DIR=str(tmp_path)))
    assert misses >= len(ONE_A_SYSTEM)  # the first process did compile
    hits, misses = json.loads(python(source, NUMBA_CACHE_DIR=str(tmp_path)))
    assert misses == 0
    assert hits >= len(ONE_A_SYSTEM)


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compile")
def test_a_cache_of_other_sources_is_not_read(tmp_path):
    """Its index may name classes that are gone; what stands behind another version is never looked at."""
    one = SHORT_RUNS + "\nrun('LumpedCatenary', (), {}, 1)"
    python(one, NUMBA_CACHE_DIR=str(tmp_path))
    numba = pytest.importorskip("numba")
    indices = list(tmp_path.rglob("*.nbi"))
    assert indices
    for index in indices:
        index.write_bytes(pickle.dumps(numba.__version__) + b"no pickle")
    python(one, NUMBA_CACHE_DIR=str(tmp_path))


TWICE = """
import sys
sys.path.insert(0, sys.argv[1])
from doubled import doubled
print(repr(doubled(1.0) if sys.argv[2] == "real" else doubled(1)), doubled.stats.cache_misses.total())
"""
AT_ONCE = """
import subprocess, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from doubled import doubled
file = doubled._cache._open()._cache_file
write = file._save_data
def slowly(name, data):  # another process finds no index, compiles for other arguments, and is done before
    Path(file._index_path).unlink()
    subprocess.run([sys.executable, *sys.argv[2:], sys.argv[1], "real"], check=True)
    write(name, data)
file._save_data = slowly
doubled(1)
"""


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compile")
def test_processes_that_compile_one_kernel_at_once_do_not_get_each_others_code(tmp_path):
    (tmp_path / "doubled.py").write_text(
        "from cosimo.components.core.kernels import kernel\n\n\n@kernel\ndef doubled(x):\n    return x + x\n"
    )
    other = tmp_path / "other.py"
    other.write_text(TWICE)
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    python(AT_ONCE, str(tmp_path), str(other), **cache)
    assert python(TWICE, str(tmp_path), "real", **cache).split() == ["2.0", "0"]  # found, and its own
    assert python(TWICE, str(tmp_path), "whole", **cache).split() == ["2", "1"]  # lost from the index, and compiled anew


@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compare with")
@pytest.mark.parametrize("runs", [{n: RUNS[n] for n in FEW}, pytest.param(RUNS, marks=pytest.mark.full)], ids=["one", "all"])
def test_plain_python_gives_the_same_numbers(runs):
    print_runs = SHORT_RUNS + f"\nprint(json.dumps({{k: run(*r) for k, r in {runs!r}.items()}}))"
    plain = json.loads(python("import sys\nsys.modules['numba'] = None\n" + print_runs))
    compiled = json.loads(python(print_runs))
    for name in runs:
        a, b = np.array(plain[name]), np.array(compiled[name])
        assert np.isfinite(a).all()
        # The same operations in the same order; LLVM may join sums in vectors, and tanh and cos differ in the last digit.
        # 100 steps of a stable system do not amplify that: 1e-12 of the largest number of each kind is 1e4 roundings.
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12 * np.abs(b).max(), err_msg=name)
