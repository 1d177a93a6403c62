"""Object files of a component's entries and of all kernels that they call, without Python and without Numba's runtime.

Numba compiles, LLVM emits for the target. The kernels are those of the process, in LLVM's language: what has run is not compiled
again. What allocates counts references, which needs functions of Numba's runtime, and is refused with its line. The calling
convention between Numba's functions, `i32 f(result *, exception **, arguments ...)`, stays inside the object; each entry
gets a C function around it. An object may ask for nothing but the functions of `ALLOWED`, which libc and libm have.
"""

from __future__ import annotations

import re
import types
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import llvmlite.binding as llvm
from numba import njit
from numba import types as t
from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numba.core.typing.typeof import typeof

from ...components.core.block import ENTRIES, Block
from ...components.core.compiler import OPTIONS
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput
from ...components.core.kept_kernels import check_result, kinds_of
from ...components.core.kernel_sources import sources_digest
from ..derivatives.compiled import kept_object
from ..derivatives.grammar import heads
from ..derivatives.tangents import ELSEWHERE, derivative_of, derived, entry_of
from .kept_code import digest_of, load, save
from .wide_pointers import widened

NATIVE = "kernels that allocate nothing and call only functions of libm"
ALLOWED = {
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "ceil",
    "copysign",
    "cos",
    "cosh",
    "erf",
    "erfc",
    "exp",
    "exp2",
    "expm1",
    "fabs",
    "floor",
    "fma",
    "fmod",
    "frexp",
    "hypot",
    "ldexp",
    "lgamma",
    "log",
    "log10",
    "log1p",
    "log2",
    "memcpy",
    "memmove",
    "memset",
    "nearbyint",
    "pow",
    "rint",
    "round",
    "sin",
    "sincos",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "tgamma",
    "trunc",
}


# of a model whose outputs have no derivative; nothing calls it
NO_SLOPES = "define i32 @model_slopes(double %t, i64 %block, i64 %offset, i64 %stack, i64 %ties) {\nret i32 1\n}\n"
SHARED = ("-shared", "-s")
NEVER_RUN = "Its libraries for macOS were built and never run: no such machine was at hand."
WITHOUT_GAPS = ("-fPIC", "-Wl,-z,defs")  # a missing symbol is an error here, not a crash later


@dataclass(frozen=True)
class Target:
    """A machine and its C runtime."""

    triple: str  # for LLVM
    zig: str  # for zig's C compiler; the oldest glibc or macOS whose symbols are enough
    cpu: str
    folder2: str  # under binaries/ of FMI 2; "" where there is none
    folder3: str  # and of FMI 3
    suffix: str
    also2: str = ""  # where hosts of FMI 2 look that know no other name; taken unless a target owns it
    wide: str = ""  # features of processors for which a library has its code a second time; `model_wide` of the runtime says so
    flags: tuple[str, ...] = SHARED  # of the C compiler
    runtime: tuple[str, ...] = ("fmi2.c", "fmi3.c")
    features: str = ""  # of the processor
    short_pointers: bool = False  # of 32 bits
    note: str = ""  # for the documentation of an FMU


TARGETS = {
    "linux64": Target(
        "x86_64-unknown-linux-gnu",
        "x86_64-linux-gnu.2.17",
        "x86-64",
        "linux64",
        "x86_64-linux",
        ".so",
        wide="+avx",
        flags=SHARED + WITHOUT_GAPS,
    ),
    "win64": Target("x86_64-pc-windows-gnu", "x86_64-windows-gnu", "x86-64", "win64", "x86_64-windows", ".dll", wide="+avx"),
    # FMI 2.0 names no folder for it and refers, since 2.0.5, to those of FMI 3.0
    "linux-arm64": Target(
        "aarch64-unknown-linux-gnu",
        "aarch64-linux-gnu.2.17",
        "generic",
        "aarch64-linux",
        "aarch64-linux",
        ".so",
        "linux64",
        flags=SHARED + WITHOUT_GAPS,
    ),
    "macos-arm64": Target(
        "arm64-apple-macosx11.0.0",
        "aarch64-macos.11.0",
        "generic",
        "aarch64-darwin",
        "aarch64-darwin",
        ".dylib",
        "darwin64",
        note=NEVER_RUN,
    ),
    "macos-x64": Target(
        "x86_64-apple-macosx11.0.0", "x86_64-macos.11.0", "x86-64", "darwin64", "x86_64-darwin", ".dylib", note=NEVER_RUN
    ),
    # zig puts the stack first in memory: a kernel that needs more of it ends with an error, and overwrites nothing
    "wasm32": Target(
        "wasm32-unknown-wasi",
        "wasm32-wasi",
        "generic",
        "",
        "wasm32-unknown",
        ".wasm",
        flags=(
            "-mexec-model=reactor",
            "-msimd128",
            "-mbulk-memory",
            "-Wl,--strip-all,--export-dynamic,--export=malloc,--export=free,-z,stack-size=1048576",
        ),
        runtime=("fmi3.c", "wasm.c"),
        features="+simd128,+bulk-memory",
        short_pointers=True,
    ),
}


class _Uncounted:
    """Copies of kernels that count no references, whatever they do; callees likewise."""

    def __init__(self):
        options = OPTIONS | {"no_cpython_wrapper": True, "_nrt": False}
        self._compiled = {inline: njit(**options, forceinline=inline) for inline in (False, True)}
        self._copies: dict[int, Any] = {}

    def clone(self, kernel: Any) -> Any:
        """A kernel without counts."""
        function = kernel.py_func
        if id(function) in self._copies:
            return self._copies[id(function)]
        cells = function.__closure__ and tuple(types.CellType(self._kernel(c.cell_contents)) for c in function.__closure__)
        new = types.FunctionType(function.__code__, dict(function.__globals__), function.__name__, function.__defaults__, cells)
        new.__qualname__, new.__module__ = function.__qualname__, function.__module__
        copy = self._copies[id(function)] = self._compiled[kernel.targetoptions.get("forceinline", False)](new)
        for name in set(_names(function.__code__)):  # behind the above: it may call itself
            if name in new.__globals__:
                new.__globals__[name] = self._kernel(new.__globals__[name])
        return copy

    def _kernel(self, value: Any) -> Any:
        return self.clone(value) if hasattr(value, "py_func") else value


def reached_kernels(kernels: Iterable[Any]) -> list[types.FunctionType]:
    """The functions of kernels and of all that they call."""
    functions: dict[int, types.FunctionType] = {}
    waiting = list(kernels)
    while waiting:
        kernel = waiting.pop()
        function = getattr(kernel, "py_func", kernel)
        if id(function) not in functions:
            functions[id(function)] = function
            waiting += [c.cell_contents for c in function.__closure__ or () if hasattr(c.cell_contents, "py_func")]
            waiting += called_kernels(function).values()
    return list(functions.values())


def called_kernels(function: Any) -> dict[str, Any]:
    """The kernels that a function names, by these names."""
    named = {name: function.__globals__.get(name) for name in set(_names(function.__code__))}
    return {name: value for name, value in named.items() if is_kernel(value, function.__module__.partition(".")[0])}


def is_kernel(value: Any, package: str) -> bool:
    """Whether a value is a kernel, or a plain function of the package, which a hook may call like one."""
    plain = isinstance(value, types.FunctionType) and value.__module__ is not None
    return hasattr(value, "py_func") or (plain and value.__module__.partition(".")[0] == package)


def _names(code: types.CodeType) -> Iterable[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _names(constant)


@dataclass(frozen=True)
class Source:
    """What is compiled: kernels by the name of their entry, for a block and arguments that lie in it.

    prefix: of the entries' symbols.  owner: a class whose sources the kernels depend on, too.
    """

    name: str
    prefix: str
    block: Block
    kernels: Mapping[str, Any]
    arguments: tuple[Any, ...]
    owner: type = object


def source_of(component: KernelComponent, prefix: str = "model") -> Source:
    """The entries of an initialized component."""
    cls, block = type(component), component.block
    assert block is not None
    kernels = {name: getattr(cls.kernels, name) for name in ENTRIES}
    return Source(cls.__name__, prefix, block, kernels, component.arguments, cls)


def compile_entries(source: Source) -> str:
    """Entries in LLVM's language; `BadInput` names the line that prevents it."""
    refused = (NumbaError, UnsupportedBytecodeError, NotImplementedError)
    try:
        return _compile(source)
    except refused as error:
        raise refusal(source.name, error) from error
    except BadInput as error:
        try:
            _refuse_counts(source)
        except refused as first:
            raise BadInput(error.where, error.actual + _place(_plain(first)), error.expected, error.remedy) from first
        raise


def _refuse_counts(source: Source) -> None:
    """Raises Numba's error that names the line where a kernel makes an array."""
    copies = _Uncounted()
    for name, kernel in source.kernels.items():
        copies.clone(kernel).compile(_signature(source, name))


def _signature(source: Source, name: str) -> tuple[Any, ...]:
    return (t.float64,) * len(source.block.entries[name]) + tuple(map(typeof, source.block.handed(name, source.arguments)))


def _compile(source: Source) -> str:
    reached = reached_kernels(source.kernels.values())
    compiled = (
        source.prefix,
        "\n".join(map(repr, source.block.in_order())),
        *source.kernels,
        *map(str, map(typeof, source.arguments)),
    )
    digest = digest_of((*compiled, *source.kernels.values()), called_kernels, reached, source.owner)
    text = load(digest) if digest else None
    if text is None:
        texts = []
        for name, (code, symbol, kinds) in _kernels(source).items():
            texts.append(code + _entry(source, name, kinds, symbol))
        text = _linked(source, texts, [k.__name__ for k in reached])
        if digest:  # what is refused is not kept: the next refusal has to find its line again
            save(digest, text)
    return text


def _entry(source: Source, name: str, kinds: Sequence[str], symbol: str) -> str:
    """An entry that calls a kernel by its symbol. kinds: types of the kernel's arguments behind its times."""
    return f"""
define i32 @{source.prefix}_{name}({", ".join(source.block.entries[name])}, i64 %address) {{
%block = inttoptr i64 %address to ptr
{source.block.body(name, kinds, symbol)}
}}
"""


def compile_apart(source: Source) -> tuple[str, str]:
    """Kernels and entries in LLVM's language, as two modules: kernels of one type of arguments are the same for every block."""
    reached, names = reached_kernels(source.kernels.values()), tuple(source.kernels)
    compiled = ("apart", source.prefix, *names, *map(str, map(typeof, source.arguments)))
    digest = digest_of((*compiled, *source.kernels.values()), called_kernels, reached, source.owner)
    text = load(digest) if digest else None
    if text is None:
        texts = []
        for name, (code, symbol, _) in _kernels(source).items():
            module = llvm.parse_assembly(code)
            kernel = module.get_function(symbol)
            kernel.name, kernel.linkage = f"{source.prefix}{ELSEWHERE}{name}", "external"
            texts.append(str(module))
        text = _linked(source, texts, [k.__name__ for k in reached])
        if digest:
            save(digest, text)
    entries = []
    for function in heads(text):
        symbol = function.name.strip('@"')
        if (name := symbol.removeprefix(f"{source.prefix}{ELSEWHERE}")) in names:
            kinds = tuple(a.type for a in function.arguments)
            behind = kinds[2 + len(source.block.entries[name]) :]  # the result, what it raises, the times
            entries.append(f"declare i32 {function.name}({', '.join(kinds)})\n{_entry(source, name, behind, symbol)}")
    return text, str(llvm.parse_assembly("".join(entries)))


def _kernels(source: Source) -> dict[str, tuple[str, str, tuple[str, ...]]]:
    """Of each kernel its code in LLVM's language, its symbol, and the types of its arguments behind its times.

    The code is that of the process, optimized with what it calls.
    """
    kernels = {}
    for name, kernel in source.kernels.items():
        with global_compiler_lock:
            overload = kernel.for_kernels(_signature(source, name))
            check_result(kernel, overload)
            code = str(overload.library._get_module_for_linking())
        kernels[name] = code, overload.fndesc.llvm_func_name, kinds_of(overload, len(source.block.entries[name]))
    return kernels


def _linked(source: Source, texts: Iterable[str], kernels: list[str]) -> str:
    """One module of all entries, optimized for the baseline of x86-64; refuses symbols that are not `ALLOWED`."""
    modules = [llvm.parse_assembly(text) for text in texts]
    module, *others = modules
    for other in others:
        module.link_in(other)
    for item in [*module.functions, *module.global_variables]:
        if not item.is_declaration and not item.name.startswith(source.prefix + "_"):
            item.linkage = "internal"
    before = str(module)
    _optimize(module, TARGETS["linux64"], _machine(TARGETS["linux64"]))
    declared = [f.name for f in [*module.functions, *module.global_variables] if f.is_declaration]
    foreign = sorted(n for n in declared if not n.startswith("llvm.") and n not in ALLOWED)
    if foreign:
        needed = ", ".join(foreign) + _users(before, foreign[0], kernels)
        remedy = "Give the kernel workspace, or write a loop."
        raise BadInput(source.name, f"machine code that needs {needed}", NATIVE, remedy)
    return str(module)


def slopes_of(text: str) -> str:
    """`model_slopes` in LLVM's language: the derivative of `model_outputs` in one direction, see `fmus.derivatives.tangents`.

    text: the entries.  Raises `Unsupported`.
    """
    module = llvm.parse_assembly(text)
    for function in module.functions:
        if not function.is_declaration and function.name != "model_outputs":
            function.linkage = "internal"
    _optimize(module, TARGETS["linux64"], _machine(TARGETS["linux64"]))  # without what outputs do not call
    slopes = derived(str(module), 1, ties=False)
    name, entry = derivative_of("@model_outputs"), entry_of("@model_outputs")
    return slopes.replace(f"define  i32 {name}(", f"define internal i32 {name}(").replace(entry, "@model_slopes")


def tangents_of(text: str, target: str, ties: bool = True) -> bytes:
    """The object file of the derivatives of entries in one direction, for a target without a wide form; raises `Unsupported`.

    It is kept, for those of a master are the same for all scenes. ties: as of `fmus.derivatives.tangents`.
    """
    parts = text, f"1 {ties}", target, sources_digest(__file__)
    return kept_object(lambda: _emitted(derived(text, 1, ties), TARGETS[target], "", ""), *parts)


def _users(text: str, symbol: str, kernels: list[str]) -> str:
    """The kernels whose code names a symbol."""
    names = set()
    for function in re.split(r"\ndefine ", text):
        head, _, body = function.partition("\n")
        if symbol in body:
            names |= {k for k in kernels if f"{len(k)}{k}B" in head or f"{k}" in head}
    return f" (in {', '.join(sorted(names, key=len)[-3:])})" if names else ""


def _machine(target: Target, features: str = "") -> Any:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(target.triple).create_target_machine(
        cpu=target.cpu, features=features or target.features, opt=3, reloc="pic", codemodel="default"
    )


def _optimize(module: Any, target: Target, machine: Any) -> None:
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False  # Numba has done it
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)


@lru_cache(maxsize=16)
def object_code(text: str, target: str) -> tuple[bytes, ...]:
    """The object files of entries for a target; they are hidden from other libraries of the process.

    Where the target has a wide form, too: those of both forms, and of entries that choose. No operations are fused in either, so
    that both give the same numbers.
    """
    to = TARGETS[target]
    if not to.wide:
        return (_object(text, to),)
    entries = _entries(text)
    choices = "\n".join(_choice(name, types) for name, types in entries)
    forms = [_object(text, to, features, suffix) for features, suffix in (("", "_base"), (to.wide, "_wide"))]
    return (*forms, _object(f"@model_wide = external hidden global i32\n{choices}", to))


def _object(text: str, target: Target, features: str = "", suffix: str = "") -> bytes:
    """Kept, for units and masters of other scenes have the same: LLVM takes seconds over those of a line."""
    parts = text, repr(target), features, suffix, sources_digest(__file__)
    return kept_object(lambda: _emitted(text, target, features, suffix), *parts)


def _emitted(text: str, target: Target, features: str, suffix: str) -> bytes:
    module = llvm.parse_assembly(widened(text) if target.short_pointers else text)
    machine = _machine(target, features)
    # Entries come optimized for x86-64; a second time takes seconds, and changes neither the numbers nor the speed.
    if target.triple != TARGETS["linux64"].triple:
        _optimize(module, target, machine)
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    for function in module.functions:
        if not function.is_declaration and function.linkage.name == "external":
            function.visibility = "hidden"
            function.name += suffix
    module.verify()
    return machine.emit_object(module)  # type: ignore[no-any-return]


def _entries(text: str) -> list[tuple[str, list[str]]]:
    """Names of the entries, and the types of their arguments."""
    functions = llvm.parse_assembly(text).functions
    entries = (f for f in functions if not f.is_declaration and f.linkage.name == "external")
    return [(f.name, [str(a.type) for a in f.arguments]) for f in entries]


def _choice(name: str, types: Sequence[str]) -> str:
    """An entry that calls its wide form where the processor has it."""
    given, kinds = ", ".join(f"{kind} %a{k}" for k, kind in enumerate(types)), ", ".join(types)
    return f"""
declare hidden i32 @{name}_base({kinds})
declare hidden i32 @{name}_wide({kinds})
define i32 @{name}({given}) {{
%wide = load i32, ptr @model_wide
%has = icmp ne i32 %wide, 0
%form = select i1 %has, ptr @{name}_wide, ptr @{name}_base
%status = tail call i32 %form({given})
ret i32 %status
}}
"""


def refusal(name: str, error: Exception) -> BadInput:
    """Numba's message, shortened to its cause and the deepest line that it names."""
    text = _plain(error)
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    ignored = ("During:", "File", "This error", "Failed in", "Overload", "<source", "-", "^")
    causes = [line for line in lines if not line.startswith(ignored)]
    cause = next((c for c in reversed(causes) if len(c) > 12), type(error).__name__)
    return BadInput(
        name, f"Python without a native form{_place(text)}: {cause[:200]}", NATIVE, "Move it into a kernel with workspace."
    )


def _plain(error: Exception) -> str:
    return re.sub(r"\x1b\[[0-9;]*m", "", str(error))


def _place(text: str) -> str:
    """The deepest line outside of Numba that a message of it names: it goes from the inside to the outside."""
    frames = re.findall(r'File "([^"]+)", line (\d+)|at (\S+\.py) \((\d+)\)', text)
    places = [(a or c, b or d) for a, b, c, d in frames if "/numba/" not in a + c and not (a + c).startswith(("<", "unknown"))]
    return f" ({places[0][0]}, line {places[0][1]})" if places else ""
