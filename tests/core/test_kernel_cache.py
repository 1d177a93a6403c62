"""Machine code on disk: found by a second process, renewed by an edit in an inlined file and nothing else, healed if damaged."""

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from cosimo import components
from cosimo.components.core import kernel_sources
from cosimo.components.core.closure import imports
from cosimo.components.core.kernels import COMPILED

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")

CORE = Path(components.__file__).parent / "core"
INNER = "from .core.kernels import kernel\n\n@kernel\ndef inner(x):\n    return 2.0 * x\n"
OUTER = "from .core.kernels import kernel\nfrom .inner import inner\n\n@kernel\ndef outer(x):\n    return inner(x) + 1.0\n"
OTHER = "from .core.kernels import kernel\n\n@kernel\ndef other(x):\n    return 3.0 * x\n"
RUN = """
import json, sys, tempfile
{before}
from own.outer import outer
from own.other import other
values = [outer(5.0), other(5.0)]
print(json.dumps(values + [[k.stats.cache_hits.total(), k.stats.cache_misses.total()] for k in (outer, other)]))
"""
FOUND, COMPILED_ANEW = [1, 0], [0, 1]


@pytest.fixture
def package(tmp_path) -> Path:
    """A package with a copy of the core and three kernels, one of which is inlined into another."""
    folder = tmp_path / "somewhere" / "own"
    shutil.copytree(CORE, folder / "core", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in {"__init__": "", "inner": INNER, "outer": OUTER, "other": OTHER}.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def run(package: Path, cache: Path, before: str = "") -> list:
    """[outer(5), other(5), (hits, misses) of either] in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(package.parent), "COSIMO_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run([sys.executable, "-c", RUN.format(before=before)], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_second_process_compiles_nothing_and_an_edit_recompiles_what_depends_on_it(package, tmp_path):
    cache = tmp_path / "cache"
    assert run(package, cache) == [11.0, 15.0, COMPILED_ANEW, COMPILED_ANEW]
    (package / "inner.py").touch()
    assert run(package, cache) == [11.0, 15.0, FOUND, FOUND]
    (package / "inner.py").write_text(INNER.replace("2.0", "4.0"))
    assert run(package, cache) == [21.0, 15.0, COMPILED_ANEW, FOUND]
    copy = tmp_path / "elsewhere" / "own"
    shutil.copytree(package, copy)
    assert run(copy, cache) == [21.0, 15.0, FOUND, FOUND]
    assert [p.name for p in cache.iterdir()] == ["kernels"]


@pytest.mark.first
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_damaged_files_count_as_missing_and_are_written_anew(package, tmp_path, kind):
    cache = tmp_path / "cache"
    whole = run(package, cache)
    for file in cache.rglob(f"outer*.{kind}"):
        content = file.read_bytes()
        middle = len(content) // 2
        flipped = content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
        file.write_bytes(content[:-20] if kind == "nbi" else flipped)
    assert run(package, cache) == [*whole[:2], COMPILED_ANEW, FOUND]
    assert run(package, cache) == [*whole[:2], FOUND, FOUND]


def test_where_nothing_can_be_written_kernels_run_all_the_same(package, tmp_path):
    (tmp_path / "file").touch()
    nowhere = f"tempfile.tempdir = {str(tmp_path / 'file')!r}"
    assert run(package, tmp_path / "file" / "cache", nowhere) == [11.0, 15.0, COMPILED_ANEW, COMPILED_ANEW]
    (tmp_path / "temporary").mkdir()
    aside = f"tempfile.tempdir = {str(tmp_path / 'temporary')!r}"
    for expected in (COMPILED_ANEW, FOUND):
        assert run(package, tmp_path / "file" / "cache", aside) == [11.0, 15.0, expected, expected]


LATER = """
import json
from own.core.compiler import callable_from_python
from own.inner import inner
from own.outer import outer

seen = lambda: [callable_from_python(code) for code in inner.overloads.values()]
counts = lambda: [inner.stats.cache_hits.total(), inner.stats.cache_misses.total()]
print(json.dumps([outer(5.0), seen(), counts(), inner(5.0), seen(), counts()]))
"""


def test_what_only_kernels_call_has_no_code_for_python_before_python_calls_it(package, tmp_path):
    def called() -> list:
        environment = {**os.environ, "PYTHONPATH": str(package.parent), "COSIMO_CACHE": str(tmp_path / "cache")}
        environment.pop("NUMBA_CACHE_DIR", None)
        environment["PYTHONDONTWRITEBYTECODE"] = "1"  # which knows sources of one size by the second
        done = subprocess.run([sys.executable, "-c", LATER], env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    assert called() == [11.0, [False], [0, 1], 10.0, [True], [0, 2]]
    assert called() == [11.0, [], [0, 0], 10.0, [True], [1, 0]]
    (package / "outer.py").write_text(OUTER.replace("1.0", "2.0"))
    assert called() == [12.0, [False], [1, 0], 10.0, [True], [2, 0]]
    for folder in (tmp_path / "cache" / "kernels" / "own").glob("inner*"):
        shutil.rmtree(folder)
    assert called() == [12.0, [], [0, 0], 10.0, [True], [0, 1]]
    (package / "outer.py").write_text(OUTER)
    for folder in (tmp_path / "cache" / "kernels" / "own").glob("outer*"):
        shutil.rmtree(folder)
    assert called() == [11.0, [True], [1, 0], 10.0, [True], [1, 0]]  # code that Python may call serves kernels, too


ADDRESS = """
from numba.core.event import install_recorder
from own.inner import inner

with install_recorder("numba:compile") as recorder:
    code = inner.for_kernels((inner.typeof_pyval(5.0),))
address = code.library.get_pointer_to_function(code.fndesc.llvm_func_name)
print(address != 0, inner.stats.cache_hits.total(), inner.stats.cache_misses.total(), len(recorder.buffer))
"""


def test_what_only_kernels_call_has_machine_code_where_its_address_is_asked_for(package, tmp_path):
    def files() -> int:
        return len([*(tmp_path / "cache").rglob("inner*.nbc")])

    environment = {**os.environ, "PYTHONPATH": str(package.parent), "COSIMO_CACHE": str(tmp_path / "cache")}
    environment.pop("NUMBA_CACHE_DIR", None)
    run(package, tmp_path / "cache")
    assert files() == 1
    for events in (
        "2",
        "0",
    ):  # found in LLVM's language, which the begin and the end of a compilation announce; then as machine code
        done = subprocess.run([sys.executable, "-c", ADDRESS], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.split() == ["True", "1", "0", events]
        assert files() == 2


PRODUCT = """
import numpy as np
from .core.kernels import kernel

@kernel
def product(a, b, c):
    np.dot(a, b, c)
"""
MULTIPLY = """
import sys
import numpy as np
from own.outer import outer
from own.product import product

outer(5.0)
before = "scipy.linalg" in sys.modules
a, b, c = np.arange(9.0).reshape(3, 3), np.eye(3), np.zeros((3, 3))
product(a, b, c)
print(before, bool((a == c).all()), *product.stats.cache_hits.values(), "numba.np.arraymath" in sys.modules)
"""


def test_what_numba_translates_is_loaded_to_compile_and_libraries_only_to_multiply_matrices(package, tmp_path):
    environment = {**os.environ, "COSIMO_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(package.parent)}
    environment.pop("NUMBA_CACHE_DIR", None)
    (package / "product.py").write_text(PRODUCT)
    for expected in (["False", "True", "True"], ["False", "True", "1", "False"]):  # compiled, then found
        done = subprocess.run([sys.executable, "-c", MULTIPLY], capture_output=True, text=True, env=environment, check=True)
        assert done.stdout.split() == expected, done.stderr


def test_all_import_statements_of_all_sources_are_seen():
    def walked(source: bytes) -> set:
        nodes = list(ast.walk(ast.parse(source)))
        plain = {(0, a.name, ()) for n in nodes if isinstance(n, ast.Import) for a in n.names}
        return plain | {(n.level, n.module or "", tuple(a.name for a in n.names)) for n in nodes if isinstance(n, ast.ImportFrom)}

    sources = [path.read_bytes() for path in CORE.parent.rglob("*.py")]
    sources.append(
        b"match 1:\n    case 1:\n        try:\n            pass\n        except ValueError:\n            import one\n"
        b"        else:\n            import two\n        finally:\n            async def f():\n"
        b"                from . import three\n"
    )
    assert all(set(imports(source)) == walked(source) for source in sources)
    assert len(imports(sources[-1])) == 3


@pytest.mark.parametrize("folder", ["site-packages", "dist-packages"])
def test_libraries_of_another_environment_are_no_sources_of_kernels(folder, tmp_path, monkeypatch):
    """As those of the user or of the system. What a kernel follows from would depend on which of their modules are loaded."""
    for name, place in {"library": tmp_path / folder / "library.py", "of_user": tmp_path / "of_user.py"}.items():
        module = ModuleType(name)
        module.__file__ = str(place)
        monkeypatch.setitem(sys.modules, name, module)
    assert kernel_sources._own_module("library") is None
    assert kernel_sources._own_module("of_user") == tmp_path / "of_user.py"
