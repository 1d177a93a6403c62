"""Functions that call a kernel on its block: kept on disk for other processes, and made anew where they are damaged."""

from typing import NamedTuple

import llvmlite.binding as llvm
import numpy as np
import pytest
from cosimo.components.core import block, kept_kernels, kernel_sources
from cosimo.components.core.block import Block, callable_of
from cosimo.components.core.kernels import COMPILED, kernel, kernel_tuple

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")


@kernel_tuple
class Memory(NamedTuple):
    values: np.ndarray
    flags: np.ndarray


@kernel_tuple
class Parameters(NamedTuple):
    gain: float
    count: int
    weights: np.ndarray


@kernel_tuple
class On(NamedTuple):
    strength: float
    on: bool


@kernel_tuple
class Effects(NamedTuple):
    first: None
    second: On


@kernel
def add(t, h, s, p, e):
    if e.first is not None:
        s.values[0] = 1e9
    s.values[0] += p.gain * t + p.weights[1] - p.count
    s.values[1] += t + h
    s.flags[1, 0] = 7 if e.second.on else 8
    return 0 if s.values[0] < 10.0 else 2


def made() -> Block:
    s = Memory(np.array([1.0, 0.0]), np.zeros((2, 3), dtype=np.int64))
    p, e = Parameters(3.0, 4, np.array([0.0, 4.0])), Effects(None, On(0.5, True))
    one = Block(s, p, e)
    one.arguments = (one.s, one.write(("p",), p), one.write(("e",), e))
    return one


def test_the_block_holds_all_of_it_and_its_entry_works_on_it():
    one = made()
    function = callable_of(one.take("step", one.entry("step", add, one.arguments)))
    assert function(2.0, 0.5, one.address) == 0
    assert one.s.values.tolist() == [7.0, 2.5]
    assert one.s.flags.tolist() == [[0, 0, 0], [7, 0, 0]]
    one.memory[one.cell("p", "gain")] = 5.0  # a parameter that is written into its cell acts
    one.view(("p", "weights"))[1] = 5.0
    assert function(2.0, 0.5, one.address) == 2
    assert one.s.values.tolist() == [18.0, 5.0]


def test_a_copy_of_the_memory_is_another_of_the_same():
    one = made()
    function, copy = callable_of(one.take("step", one.entry("step", add, one.arguments))), one.memory.copy()
    function(2.0, 0.5, copy.ctypes.data)
    assert one.s.values.tolist() == [1.0, 0.0]
    function(2.0, 0.5, one.address)
    assert (copy.view(np.int64) == one.memory.view(np.int64)).all()


@pytest.fixture
def process(tmp_path, monkeypatch):
    """A function that runs an entry of `add` as another process would: (status, values, how often it was made)."""
    monkeypatch.setattr(kernel_sources, "private_root", lambda: tmp_path)
    made_here, engines, kept_function, kept_machine = [], [], block._function, kept_kernels.machine

    class Machine:
        def emit_object(self, module):
            made_here.append(module)
            return kept_machine().emit_object(module)

    def run(t: float = 2.0) -> tuple[int, list[float], int]:
        engines.append((llvm.create_mcjit_compiler(llvm.parse_assembly(""), kept_machine()), set()))
        monkeypatch.setattr(block, "_engine", lambda: engines[-1])
        monkeypatch.setattr(block, "machine", Machine)
        monkeypatch.setattr(block, "_function", kept_function.__wrapped__)
        one, before = made(), len(made_here)
        status = callable_of(one.take("step", one.entry("step", add, one.arguments)))(t, 0.5, one.address)
        return status, one.s.values.tolist(), len(made_here) - before

    return run


def test_the_second_process_makes_none(process, tmp_path):
    assert process() == (0, [7.0, 2.5], 1)
    assert process() == (0, [7.0, 2.5], 0)
    assert process(4.0) == (2, [13.0, 4.5], 0)
    assert len(list((tmp_path / "entries").iterdir())) == 1


@pytest.mark.parametrize("damage", [lambda c: c[:-9], lambda c: c[:90] + bytes([c[90] ^ 1]) + c[91:], lambda c: b""])
def test_a_damaged_one_is_made_again(process, tmp_path, damage):
    process()
    (file,) = (tmp_path / "entries").iterdir()
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert process() == (0, [7.0, 2.5], 1)
    assert file.read_bytes() == whole


def test_a_folder_that_others_may_write_is_not_read(process, tmp_path):
    process()
    (tmp_path / "entries").chmod(0o777)
    for _ in range(2):
        assert process() == (0, [7.0, 2.5], 1)
