"""What only shows in a process of its own: the kernels' cache on disk, and the same source without Numba."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from components.catalogue import CATALOGUE, component_class
from components.core.kernels import COMPILED

from .configurations import FACTS, SMALL

ROOT = Path(__file__).resolve().parents[2]

SHORT_RUNS = """
import json, sys
import numpy as np
from components.catalogue import CATALOGUE, component_class
from components.core.kernels import compiled_from_cache

def run(component, effects, parameters, steps):
    made = component_class(component)(effects, parameters)
    made.initialize(0.0)
    for k in range(steps):
        made.u[1] = 0.3 * np.array([made.variables[n].nominal for n in made.inputs])
        made.step(k * 1e-3, 1e-3)
    return [*made.y.tolist(), *made.x.tolist()]
"""

ONE_A_SYSTEM = {component_class(name).system: name for name in CATALOGUE}.values()
SECOND_PROCESS = SHORT_RUNS + f"\nSMALL = { {name: SMALL[name] for name in ONE_A_SYSTEM}!r}" + """
for name in SMALL:
    run(name, (), SMALL[name], 1)
kernels = {id(k): k for m in list(sys.modules.values()) if m.__name__.startswith("components.")
           for space in (vars(m), *(vars(c) for c in vars(m).values() if isinstance(c, type)))
           for k in space.values() if hasattr(k, "stats")}
print(json.dumps(compiled_from_cache(*kernels.values())))
"""

RUNS = {name: (name, list(FACTS[name].plain[0]), {**FACTS[name].plain[1]}, FACTS[name].plain[2]) for name in CATALOGUE}
for name in CATALOGUE:
    for way, effects in FACTS[name].other_ways:
        _, parameters, steps = FACTS[name].plain
        RUNS[f"{name}, {way}"] = (name, list(effects), {**parameters, **way}, steps)


def python(source: str, **environment: str) -> str:
    """What a new process prints."""
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, cwd=ROOT, timeout=300,
                          env={**os.environ, "PYTHONPATH": str(ROOT), **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compile")
def test_a_second_process_compiles_nothing(tmp_path):
    """In a cache of its own: other tests compile at the same time, and Numba's index of a cache is not made for that."""
    hits, misses = json.loads(python(SECOND_PROCESS, NUMBA_CACHE_DIR=str(tmp_path)))
    assert misses >= len(ONE_A_SYSTEM)  # the first process did compile
    hits, misses = json.loads(python(SECOND_PROCESS, NUMBA_CACHE_DIR=str(tmp_path)))
    assert misses == 0
    assert hits >= len(ONE_A_SYSTEM)


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


@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compare with")
def test_plain_python_gives_the_same_numbers():
    print_runs = SHORT_RUNS + f"\nprint(json.dumps({{k: run(*r) for k, r in {RUNS!r}.items()}}))"
    plain = json.loads(python("import sys\nsys.modules['numba'] = None\n" + print_runs))
    compiled = json.loads(python(print_runs))
    for name in RUNS:
        a, b = np.array(plain[name]), np.array(compiled[name])
        assert np.isfinite(a).all()
        # The same operations in the same order; LLVM may join sums in vectors, and tanh and cos differ in the last digit.
        # 100 steps of a stable system do not amplify that: 1e-12 of the largest number of each kind is 1e4 roundings.
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12 * np.abs(b).max(), err_msg=name)
