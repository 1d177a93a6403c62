"""Machine code of derivatives in this process, kept on disk as all machine code is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from ctypes import CFUNCTYPE, c_double, c_int32, c_int64
from functools import lru_cache
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba.core.compiler_lock import global_compiler_lock

from ...components.core import store
from ...components.core.block import CELL
from ...components.core.kernel_sources import private_folder, sources_digest
from .tangents import derivative_of, derived, entry_of

LINE = 8  # cells of a cache line
STACK = 1 << 15  # cells of the arena that functions keep what they hand on in


class Compiled:
    """The derivatives of some modules, in `width` directions at once; kept as long as this is."""

    def __init__(self, texts: Iterable[str], width: int, without_ties: Iterable[str] = ()):
        """without_ties: texts whose decisions are not told, see `tangents`. Raises `Unsupported`."""
        with global_compiler_lock:
            machine = _machine()
            self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
            for some, ties in ((texts, True), (without_ties, False)):
                for text in some:
                    self._engine.add_object_file(llvm.ObjectFileRef.from_data(_object(text, width, ties)))
            self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Of the derivative of a function, for a call by address from another one."""
        return int(self._engine.get_function_address(derivative_of(f"@{name}")[2:-1]))

    def entry(self, name: str, times: int) -> Callable[..., int]:
        """The derivative of an entry, for Python: so many times, s, and the addresses as `Arena.given` has them."""
        address = self._engine.get_function_address(entry_of(f"@{name}")[2:-1])
        function = CFUNCTYPE(c_int32, *[c_double] * times, *[c_int64] * 4)(address)
        function.code = self  # type: ignore[attr-defined] # which owns what the address points to
        return function


class Arena:
    """Memory with tangents. cells: (n,) float64; tangents: (n, width) of them."""

    def __init__(self, size: int, width: int):
        self.cells, self.tangents = _aligned(size + STACK), _aligned(width * (size + STACK)).reshape(-1, width)
        self.address = self.cells.ctypes.data
        self.stack = self.address + CELL * size
        self.offset = self.tangents.ctypes.data - width * self.address
        self.ties = np.zeros(1, dtype=np.int64)  # a bit of each direction, see `tangents`; of vectors several

    def given(self, first: int = 0) -> tuple[int, int, int, int]:
        """What an entry gets behind its times, for the block that begins at a cell."""
        return self.address + CELL * first, self.offset, self.stack, self.ties.ctypes.data


def _aligned(size: int) -> np.ndarray:
    """Zeros at the beginning of a cache line."""
    memory = np.zeros(size + LINE)
    first = -(memory.ctypes.data // CELL) % LINE
    return memory[first : first + size]


@lru_cache(maxsize=64)
def _object(text: str, width: int, ties: bool) -> bytes:
    machine = llvm.get_host_cpu_name(), _features()
    return kept_object(lambda: _compiled(derived(text, width, ties)), text, f"{width} {ties}", *machine)


def kept_object(make: Callable[[], bytes], *parts: str | bytes) -> bytes:
    """An object file or a library, from the user's cache where one of the same parts has been made there."""
    folder = private_folder("derivatives")
    name = store.digest_of(*parts, sources_digest(__file__), str(llvm.llvm_version_info))
    code = None if folder is None else store.read_kept(folder / f"{name}.o")
    if code is None:
        code = make()
        if folder is not None:
            store.write_kept(folder / f"{name}.o", code)
    return code


def _compiled(text: str) -> bytes:
    machine = _machine()
    module = llvm.parse_assembly(text)
    module.verify()
    module.triple, module.data_layout = llvm.get_default_triple(), str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return machine.emit_object(module)  # type: ignore[no-any-return]


def _features() -> str:
    return str(llvm.get_host_cpu_features().flatten())


def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=_features(), opt=2, jit=True)
