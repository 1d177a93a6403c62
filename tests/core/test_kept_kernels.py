"""Machine code that is found without the compiler: by the contents of sources, the types of arguments and the processor."""

import importlib.util
import json
import sys
from ctypes import CFUNCTYPE, addressof, c_double, c_int32, c_int64, c_void_p

import numpy as np
import pytest
from cosimo.components.core import kept_kernels, kernel_cache, kernel_sources
from cosimo.components.core.kernels import COMPILED
from cosimo.components.core.store import read_kept, write_kept
from cosimo.tests.commands import python

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")

SOURCE = """
import math
import numpy as np
from cosimo.components.core.kernels import kernel

@kernel
def put(t, row):
    total = 0.0
    for value in row:
        total += math.cos(value)
    row[0] = FACTOR * t + total
    return 3
"""
TYPES = {"ptr": c_void_p, "i64": c_int64, "double": c_double}
FOUND, COMPILED_ANEW = True, False


@pytest.fixture
def process(tmp_path, monkeypatch):
    """A function that calls the kernel with a factor on an array as another process would: (number, whether it was found)."""
    for module in (kernel_sources, kernel_cache):
        monkeypatch.setattr(module, "private_root", lambda: tmp_path)
    copies = iter(range(100))

    def run(factor: float = 2.0, row: np.ndarray | None = None) -> tuple[float, bool]:
        monkeypatch.setattr(kept_kernels, "_LOADED", {})
        kept_kernels._host.cache_clear()
        file = tmp_path / f"copy{next(copies)}" / "putting.py"
        file.parent.mkdir()
        file.write_text(SOURCE.replace("FACTOR", str(factor)))
        spec = importlib.util.spec_from_file_location("putting", file)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "putting", module)
        spec.loader.exec_module(module)
        row = np.zeros(3) if row is None else row
        address, kinds = kept_kernels.machine_code(module.put, 1, (row,))
        function = CFUNCTYPE(c_int32, c_void_p, c_void_p, c_double, *(TYPES[k] for k in kinds))(address)
        result, raised = c_int64(), c_void_p()
        assert function(addressof(result), addressof(raised), 1.5, *kept_kernels._flat((row,))) == 0
        assert result.value == 3
        assert ("dispatcher" in vars(module.put)) == (module.put.hits == 0)  # the compiler is loaded for what is not found
        return row[0], module.put.hits == 1

    return run


def test_another_process_finds_it_and_an_edit_is_compiled(process):
    assert process() == (6.0, COMPILED_ANEW)
    assert process() == (6.0, FOUND)
    assert process(4.0) == (9.0, COMPILED_ANEW)
    assert process() == (6.0, FOUND)  # the edit is undone


def test_arrays_of_another_kind_have_code_of_their_own(process):
    process()
    assert process(row=np.zeros(8)) == (11.0, FOUND)
    assert process(row=np.zeros(8)[::2]) == (7.0, COMPILED_ANEW)
    assert process(row=np.zeros(4, dtype=np.int64)) == (7, COMPILED_ANEW)
    assert process(row=np.zeros(6)[::2]) == (6.0, FOUND)


def test_another_processor_finds_nothing(process, monkeypatch):
    process()
    features = kept_kernels.llvm.get_host_cpu_features()
    other = type(features)({**features, "avx2": not features.get("avx2")})
    monkeypatch.setattr(kept_kernels.llvm, "get_host_cpu_features", lambda: other)
    assert process() == (6.0, COMPILED_ANEW)
    monkeypatch.undo()


@pytest.mark.parametrize("damage", [lambda c: c[:-9], lambda c: c[:700] + bytes([c[700] ^ 1]) + c[701:], lambda c: b""])
def test_a_damaged_one_is_made_again(process, tmp_path, damage):
    process()
    (file,) = (tmp_path / "machine").iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert process() == (6.0, COMPILED_ANEW)
    assert process() == (6.0, FOUND)


def test_a_folder_that_others_may_write_is_not_read(process, tmp_path):
    process()
    (tmp_path / "machine").chmod(0o777)
    assert [process(), process()] == [(6.0, COMPILED_ANEW)] * 2


def test_code_that_needs_a_function_that_is_not_here_is_not_taken(process, tmp_path):
    process()
    (file,) = (tmp_path / "machine").iterdir()
    head, _, code = read_kept(file).partition(b"\n")
    name, kinds, needed = json.loads(head)
    write_kept(file, json.dumps([name, kinds, [*needed, "function_of_another_process"]]).encode() + b"\n" + code)
    assert process() == (6.0, COMPILED_ANEW)


ARRAYS = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from made_inside import entered
from cosimo.components.core.kept_kernels import call

row = np.zeros(2)
call(entered, 3, row)
print(*row)
"""


def test_code_that_makes_arrays_runs_in_every_process(tmp_path):
    """It calls functions of Numba's, which are in a process once Numba is loaded."""
    (tmp_path / "made_inside.py").write_text(
        "import numpy as np\nfrom cosimo.components.core.kernels import kernel\n\n\n@kernel\ndef entered(n, row):\n"
        "    made = np.ones(n)\n    row[0], row[1] = made.sum(), made.size\n    return 0\n"
    )
    for _ in range(3):
        assert python(ARRAYS, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "cache")).split() == ["3.0", "3.0"]


def test_a_kernel_that_returns_no_status_is_refused(process):
    from cosimo.tests.core.test_compiler import made

    with pytest.raises(TypeError, match=r"made returns array\(.*expected a status"):
        kept_kernels.machine_code(made, 0, (3,))
