"""Machine code of kernels that an entry calls, by their sources and the types of their arguments: found and loaded without Numba.

To load Numba and its cache of a kernel takes longer than a short run. What stands here is the machine code alone, one file for each
kernel and its arguments, with the name of its function and the types that it takes. What cannot be kept so is Numba's matter, as is
what is not there: code that refers to this process, or that needs functions that this process does not have.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from ctypes import CFUNCTYPE, addressof, c_double, c_int32, c_int64, c_void_p
from functools import lru_cache
from threading import RLock
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from .compiled_here import libraries
from .kernel_sources import packages, private_folder, sources_digest
from .store import digest_of, read_kept, write_kept

LOCK = RLock()  # LLVM's engines are made for one thread at a time, and its calls free Python's lock
_LOADED: dict[str, tuple[int, tuple[str, ...], Any]] = {}  # with the engine that owns the code
STATUS = ("int64", "none")  # what a kernel returns
_TYPES: dict[str, Any] = {"double": c_double, "i64": c_int64, "ptr": c_void_p}
_CALLS: dict[tuple[Any, str], Callable[..., int]] = {}  # by kernel and kinds of arguments


class Either(NamedTuple):
    """Among arguments for an effect that the kernel finds on or off when it runs, see `Effect.either_in`."""

    values: Any  # of the form that they have when it is on


def machine_code(kernel: Any, times: int, arguments: tuple[Any, ...]) -> tuple[int, tuple[str, ...]]:
    """(address, types of its arguments behind the times) of the machine code of a kernel for such arguments.

    Raises `TypeError` for a kernel that returns something else than a status.
    """
    key = _key(kernel, times, arguments)
    with LOCK:
        if (known := _LOADED.get(key)) is None and key:
            known = _LOADED[key] = _kept(key)  # type: ignore[assignment]
            kernel.hits += known is not None
        if known is None:
            known = (*_compiled(kernel, times, arguments, key), None)
            if key:
                _LOADED[key] = known
    return known[0], known[1]


def missing(kernel: Any, times: int, arguments: tuple[Any, ...]) -> str:
    """What names machine code that can be kept, and is not: neither in this process nor on disk; "" for all other."""
    folder, key = private_folder("machine"), _key(kernel, times, arguments)
    return "" if folder is None or not key or key in _LOADED or (folder / key).is_file() else key


def _key(kernel: Any, times: int, arguments: tuple[Any, ...]) -> str:
    """What the machine code follows from; "" where that is not known, or nothing can be kept."""
    function = kernel.py_func
    if function.__closure__ or private_folder("machine") is None:
        return ""
    own, neutral = packages(function.__module__)
    try:
        kinds = _kind(arguments).replace(f"{own}.", f"{neutral}.")
        sources = sources_digest(*kernel.files)
    except (OSError, SyntaxError, ValueError, TypeError):  # no file, as in an interactive session; arguments of other types
        return ""
    name = f"{function.__module__}.{function.__qualname__}".replace(own, neutral)
    code = function.__code__
    return digest_of(_host(), sources, name, f"{code.co_firstlineno} {times}", code.co_code, kinds)


@lru_cache(maxsize=1)
def _host() -> str:
    """The processor, and what machine code is made by."""
    return digest_of(
        sources_digest(__file__),
        libraries(),
        llvm.get_default_triple(),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
    )


def _kind(value: Any) -> str:
    """What decides on the type that a value has for the compiler. Raises `TypeError` for one that is not told here."""
    if isinstance(value, np.ndarray):
        order = "C" if value.flags.c_contiguous else "F" if value.flags.f_contiguous else "A"
        return f"{_numbers(value.dtype)}{value.ndim}{order}{value.flags.writeable:d}{value.flags.aligned:d}"
    if isinstance(value, np.void):
        return f"record {_numbers(value.dtype)}"
    if isinstance(value, tuple):
        cls = type(value)
        named = f"{cls.__module__}.{cls.__qualname__}{cls._fields}" if hasattr(cls, "_fields") else ""
        return f"{named}({', '.join(map(_kind, value))})"
    if value is None or type(value) in (bool, float) or (type(value) is int and -(2**63) <= value < 2**63):
        return type(value).__name__
    raise TypeError(type(value).__name__)


def _numbers(kind: np.dtype) -> str:
    return f"{kind.descr} {kind.itemsize} {kind.isalignedstruct}" if kind.names else kind.str


def _kept(key: str) -> tuple[int, tuple[str, ...], Any] | None:
    """What was kept; None where it is missing, or needs functions that are not in this process."""
    folder = private_folder("machine")
    content = None if folder is None else read_kept(folder / key)
    if content is None:
        return None
    head, _, code = content.partition(b"\n")
    symbol, kinds, needed = json.loads(head)
    engine = llvm.create_mcjit_compiler(
        llvm.parse_assembly(""), machine()
    )  # from then on LLVM knows the functions of this process
    if not all(map(llvm.address_of_symbol, needed)):
        return None
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine.get_function_address(symbol), tuple(kinds), engine


def _compiled(kernel: Any, times: int, arguments: tuple[Any, ...], key: str) -> tuple[int, tuple[str, ...]]:
    typeof = kernel.typeof_pyval
    overload = kernel.for_kernels((*[typeof(0.0)] * times, *map(typeof, arguments)))
    check_result(kernel, overload)
    symbol, kinds, library = overload.fndesc.llvm_func_name, kinds_of(overload, times), overload.library
    address = library.get_pointer_to_function(symbol)
    folder = private_folder("machine")
    if key and folder is not None and not (library.has_dynamic_globals or library._reload_init):
        module = library._get_module_for_linking()
        declared = [item.name for item in (*module.functions, *module.global_variables) if item.is_declaration]
        needed = [name for name in declared if not name.startswith("llvm.")]
        _, _, (code, _) = library.serialize_using_object_code()
        write_kept(folder / key, json.dumps([symbol, kinds, needed]).encode() + b"\n" + code)
    return address, kinds


def call(kernel: Any, *arguments: Any) -> None:
    """Call a kernel of floats, integers and arrays from Python, without Numba where its machine code was kept."""
    key = kernel, _kind(arguments)
    if (function := _CALLS.get(key)) is None:
        address, kinds = machine_code(kernel, 0, arguments)
        function = _CALLS[key] = CFUNCTYPE(c_int32, c_void_p, c_void_p, *map(_TYPES.__getitem__, kinds))(address)
    result, raised = c_int64(), c_void_p()
    if function(addressof(result), addressof(raised), *_flat(arguments)) not in (0, -2):  # -2: it returns nothing
        raise RuntimeError(f"{kernel.__name__} has raised an exception")


def _flat(arguments: tuple[Any, ...]) -> Iterator[Any]:
    """As Numba hands them on."""
    for value in arguments:
        if isinstance(value, np.ndarray):
            yield from (None, None, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)
        else:
            yield value


def kinds_of(overload: Any, times: int) -> tuple[str, ...]:
    """Types, in machine code, of a compiled kernel's arguments behind its times."""
    packer = overload.target_context.get_arg_packer(overload.fndesc.argtypes)
    return tuple("ptr" if str(k).endswith("*") else str(k) for k in packer.argument_types)[times:]


def check_result(kernel: Any, overload: Any) -> None:
    """Raises `TypeError` for a kernel that returns something else than a status."""
    from numba.core.types import unliteral

    if str(unliteral(overload.signature.return_type)) not in STATUS:
        raise TypeError(f"{kernel.__name__} returns {overload.signature.return_type}, expected a status")


def machine() -> Any:
    """What makes machine code of entries, and takes that of kernels into memory."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(opt=1, jit=True)
