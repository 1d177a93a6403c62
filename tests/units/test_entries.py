"""Functions that make the kernel calls of a hook: kept on disk for other processes, and made anew where they are damaged."""

from __future__ import annotations

import llvmlite.binding as llvm
import numpy as np
import pytest
from cosimo.components.core import kernel_cache
from cosimo.components.core.kernels import COMPILED, kernel
from cosimo.orchestrator.units import entries
from cosimo.orchestrator.units.entries import HOOK, Entry
from cosimo.orchestrator.units.hook_calls import KernelCall, Symbol

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")


@kernel
def add(values, gain, t, h):
    values[0] += gain * t
    values[1] += h
    return 0 if values[0] < 10.0 else 2


@pytest.fixture
def process(tmp_path, monkeypatch):
    """A function that runs an entry of `add` as another process would: (status, values, how often it was made)."""
    monkeypatch.setattr(kernel_cache, "private_root", lambda: tmp_path)
    made, engines, kept_function, kept_machine = [], [], entries._function, entries._machine

    class Machine:
        def emit_object(self, module):
            made.append(module)
            return kept_machine().emit_object(module)

    def run(t: float = 2.0) -> tuple[int, list[float], int]:
        engines.append(llvm.create_mcjit_compiler(llvm.parse_assembly(""), kept_machine()))
        monkeypatch.setattr(entries, "_engine", lambda: engines[-1])
        monkeypatch.setattr(entries, "_machine", Machine)
        monkeypatch.setattr(entries, "_function", kept_function.__wrapped__)
        values, before = np.array([1.0, 0.0]), len(made)
        entry = Entry([KernelCall(add, (values, 3.0, Symbol.TIME, Symbol.END), True)])
        status = HOOK(entry.function)(t, 0.5, entry.argument)
        return status, values.tolist(), len(made) - before

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
