"""Machine code that makes the kernel calls of a component's hook: one function `int32 f(double t, double h, int64 *cells)`.

A kernel that Numba has compiled is called where it lies, with arguments that stand in cells of eight bytes: numbers, and of
arrays address, shape and strides. Functions that load arguments of the same types are one function, which takes milliseconds to
make and is kept on disk: nothing in it depends on the process or on the kernels.
"""

from __future__ import annotations

import ctypes
import hashlib
import inspect
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...components.core.kernels import DONE
from .hook_calls import KernelCall, PythonInHook, Symbol

HOOK = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_double, ctypes.c_double, ctypes.c_void_p)
RAISED = 99  # status of an error inside a kernel that is no status


class Entry:
    """A function and its argument; both addresses are valid as long as this lives. The arrays are those of the component."""

    def __init__(self, calls: Sequence[KernelCall]):
        """Raises `PythonInHook` where an argument has no form that a kernel takes."""
        cells: list[Any] = []
        shapes = []
        for call in calls:
            function, kinds = _compiled(call)
            values = list(_flat(_folded(call)))
            if len(values) != len(kinds):
                raise PythonInHook(f"arguments of {call.kernel.__name__}")
            shapes.append((kinds, tuple(v if isinstance(v, Symbol) else None for v in values), call.checked))
            cells += [function, *values]
        self.cells = np.zeros(max(len(cells), 1), dtype=np.int64)
        floats = self.cells.view(np.float64)
        for k, value in enumerate(cells):
            if isinstance(value, float):
                floats[k] = value
            elif not isinstance(value, Symbol):
                self.cells[k] = value
        self._calls = tuple(calls)  # keeps their arrays and machine code alive
        self.arrays = [array for call in calls for array in _arrays(call.arguments)]
        self.function, self.argument = _function(tuple(shapes)), self.cells.ctypes.data


class Callback:
    """A hook with Python in it, for compiled code: function and argument as in `entries.Entry`. Keeps what it has raised."""

    argument = 0
    error: BaseException | None = None

    def __init__(self, hook: Callable[[float, float], None], reason: str):
        """`reason`: what of it is not a call of a kernel."""
        self.reason = reason

        def call(t: float, h: float, _: int | None) -> int:
            try:
                hook(t, h)
            except BaseException as error:  # none may pass through compiled code
                self.error = error
                return RAISED
            return DONE

        self._call = HOOK(call)
        self.function = ctypes.cast(self._call, ctypes.c_void_p).value or 0


def _folded(call: KernelCall) -> tuple[Any, ...]:
    """Arguments as Numba has them: those behind a star are one tuple."""
    code = call.kernel.py_func.__code__
    if not code.co_flags & inspect.CO_VARARGS:
        return call.arguments
    return (*call.arguments[: code.co_argcount], call.arguments[code.co_argcount :])


def _compiled(call: KernelCall) -> tuple[int, tuple[str, ...]]:
    """(address, types of the arguments in machine code) of a kernel for these arguments."""
    kernel = call.kernel
    return _of_types(kernel, tuple(kernel.typeof_pyval(0.0 if isinstance(a, Symbol) else a) for a in _folded(call)), call.checked)


@lru_cache(maxsize=1024)
def _of_types(kernel: Any, signature: tuple[Any, ...], checked: bool) -> tuple[int, tuple[str, ...]]:
    from numba.core.types import unliteral

    if signature not in kernel.overloads:
        kernel.compile(signature)
    compiled = kernel.overloads[signature]
    kinds = [str(k) for k in compiled.target_context.get_arg_packer(compiled.fndesc.argtypes).argument_types]
    result = str(unliteral(compiled.signature.return_type))  # one that always returns DONE has a type of that number
    if result not in ("int64", "none") or (checked and result == "none"):
        raise PythonInHook(f"{kernel.__name__}, which returns {result}")
    return (compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name),
            tuple("ptr" if k.endswith("*") else k for k in kinds))


def _arrays(values: Sequence[Any]) -> Iterator[np.ndarray]:
    """The arrays among values, and in tuples among them."""
    for value in values:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, tuple):
            yield from _arrays(value)


def _flat(values: Sequence[Any]) -> Iterator[Any]:
    """The numbers that stand for values, in the order of Numba's data models."""
    for value in values:
        if isinstance(value, np.ndarray):
            yield from (0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)
        elif isinstance(value, tuple):
            yield from _flat(value)
        elif value is None:
            yield 0
        elif isinstance(value, float | np.floating):
            yield float(value)
        elif isinstance(value, bool | np.bool_ | int | np.integer):
            yield int(value)
        elif isinstance(value, Symbol):
            yield value
        else:
            raise PythonInHook(f"a {type(value).__name__} for a kernel")


@lru_cache(maxsize=256)
def _function(shapes: tuple[Any, ...]) -> int:
    """The address of a function that makes calls of these types: (types, symbols, checked) of each."""
    import llvmlite.binding as llvm

    from ...components.core.kept import read_kept, write_kept
    from ...components.core.kernel_cache import private_folder

    body = "\n".join(_lines(shapes))
    name = "entry_" + hashlib.sha256(f"{llvm.llvm_version_info} {llvm.get_default_triple()}\n{body}".encode()).hexdigest()
    folder = private_folder("entries")
    code = None if folder is None else read_kept(folder / f"{name}.o")
    engine = _engine()
    if code is None:
        code = _machine().emit_object(llvm.parse_assembly(f"define i32 @{name}(double %t, double %h, ptr %cells) {{\n{body}\n}}"))
        if folder is not None:
            write_kept(folder / f"{name}.o", code)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine.get_function_address(name)


@lru_cache(maxsize=1)
def _engine() -> Any:
    """What owns the machine code, as long as the process lives."""
    import llvmlite.binding as llvm

    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())


def _machine() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(opt=1, jit=True)


def _lines(shapes: tuple[Any, ...]) -> Iterator[str]:
    yield "%result = alloca i64\n%raised = alloca ptr\n%end = fadd double %t, %h"
    cell = 0
    for c, (kinds, symbols, checked) in enumerate(shapes):
        arguments = ["ptr %result", "ptr %raised"]
        for k, (kind, symbol) in enumerate(zip(("ptr", *kinds), (None, *symbols), strict=True)):
            if symbol is None:
                yield f"%p{c}_{k} = getelementptr i64, ptr %cells, i64 {cell}"
                yield f"%a{c}_{k} = load {kind}, ptr %p{c}_{k}"
            if k:
                arguments.append({Symbol.TIME: "double %t", Symbol.END: "double %end"}.get(symbol, f"{kind} %a{c}_{k}"))
            cell += 1
        yield f"%s{c} = call i32 %a{c}_0({', '.join(arguments)})"
        yield f"%f{c} = icmp ne i32 %s{c}, 0\nbr i1 %f{c}, label %raise, label %fine{c}\nfine{c}:"
        if checked:
            yield f"%v{c} = load i64, ptr %result\n%w{c} = trunc i64 %v{c} to i32\n%d{c} = icmp ne i32 %w{c}, 0"
            yield f"br i1 %d{c}, label %stop{c}, label %next{c}\nstop{c}:\nret i32 %w{c}\nnext{c}:"
    yield f"ret i32 0\nraise:\nret i32 {RAISED}"
