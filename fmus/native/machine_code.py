"""Object files of a component's entries and of all kernels that they call, without Python and without Numba's runtime.

Numba compiles, LLVM emits for the target. A kernel of a component carries flags for use from Python; here each is compiled once
more with flags of its own: no reference counts, no wrappers. What allocates is then refused by Numba, with its line. The calling
convention between Numba's functions, `i32 f(result *, exception **, arguments ...)`, stays inside the object; each entry
gets a C function around it. An object may ask for nothing but the functions of `ALLOWED`, which libc and libm have.
"""

from __future__ import annotations

import json
import re
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import llvmlite.binding as llvm
from numba import njit
from numba import types as t
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numba.core.typing.typeof import typeof

from ...components.core.block import ENTRIES, Block, check_result, kinds_of
from ...components.core.compiler import seldom_collected
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput
from ...components.core.kernel_library import kernel_libraries
from ...components.core.kernels import OPTIONS
from .kept_code import KERNELS, digest_of, load, save
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


class _Compiler:
    """Copies of kernels, compiled with the flags given here; callees likewise."""

    def __init__(self, counted: bool):
        options = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True} | ({} if counted else {"_nrt": False})
        self._compiled = {inline: njit(**options, forceinline=inline) for inline in (False, True)}
        self.kernels: dict[int, tuple[Any, Any]] = {}

    def clone(self, kernel: Any) -> Any:
        """A kernel, or a plain function that one calls, under these flags."""
        function = getattr(kernel, "py_func", kernel)
        if id(function) in self.kernels:
            return self.kernels[id(function)][0]
        package = "" if kernel is not function else function.__module__.partition(".")[0]
        cells = function.__closure__ and tuple(types.CellType(self._kernel(c.cell_contents)) for c in function.__closure__)
        new = types.FunctionType(function.__code__, dict(function.__globals__), function.__name__, function.__defaults__, cells)
        new.__qualname__, new.__module__ = function.__qualname__, function.__module__
        copy = self._compiled[getattr(kernel, "targetoptions", {}).get("forceinline", False)](new)
        self.kernels[id(function)] = (copy, function)  # before its callees: it may call itself
        for name in set(_names(function.__code__)):
            if is_kernel(new.__globals__.get(name), package):
                new.__globals__[name] = self.clone(new.__globals__[name])
        return copy

    def _kernel(self, value: Any) -> Any:
        return self.clone(value) if is_kernel(value, "") else value


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
        return _compile(source, counted=False)
    except refused as error:
        first = error
    try:
        # code that is never reached may mention allocation; what remains of it is seen among the symbols
        return _compile(source, counted=True)
    except refused as second:
        raise refusal(source.name, second) from first
    except BadInput as second:
        place = _place(_plain(first))
        raise BadInput(second.where, second.actual + place, second.expected, second.remedy) from first


def _compile(source: Source, counted: bool) -> str:
    block, compiler = source.block, _Compiler(counted)
    copies = {name: compiler.clone(kernel) for name, kernel in source.kernels.items()}
    reached = [function for _, function in compiler.kernels.values()]
    of_arguments = tuple(map(typeof, source.arguments))
    compiled = (*source.kernels, *map(str, of_arguments), *source.kernels.values())
    layout = "\n".join(map(repr, block.in_order()))
    digest = digest_of((source.prefix, layout, *compiled), called_kernels, reached, source.owner)
    text = load(digest) if digest else None
    if text is None:
        texts = {}
        of_kernels = digest_of(compiled, called_kernels, reached, source.owner)  # for blocks of any layout
        kept = load(of_kernels, KERNELS) if of_kernels else None
        kernels = json.loads(kept) if kept else _kernels(source, copies, of_arguments)
        for name, (code, symbol, kinds) in kernels.items():
            texts[name] = (
                code
                + f"""
define i32 @{source.prefix}_{name}({", ".join(block.entries[name])}, i64 %address) {{
%block = inttoptr i64 %address to ptr
{block.body(name, kinds, symbol)}
}}
"""
            )
        text = _linked(source, texts, [k.__name__ for k in reached])
        if digest:  # what is refused is not kept: the next refusal has to find its line again
            save(digest, text)
        if of_kernels and not kept:
            save(of_kernels, json.dumps(kernels), KERNELS)
    return text


def _kernels(source: Source, copies: Mapping[str, Any], of_arguments: tuple[Any, ...]) -> dict[str, tuple[str, str, list[str]]]:
    """Of each kernel its code in LLVM's language, its symbol, and the types of its arguments behind its times."""
    kernels = {}
    for name, kernel in copies.items():
        times = len(source.block.entries[name])
        signature = (t.float64,) * times + of_arguments
        with seldom_collected(), kernel_libraries(kernel.targetctx.codegen()):
            kernel.compile(signature)
        overload = kernel.overloads[signature]
        check_result(kernel, overload)
        overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name)  # optimized with what it calls
        kernels[name] = (overload.library.get_llvm_str(), overload.fndesc.llvm_func_name, list(kinds_of(overload, times)))
    return kernels


def _linked(source: Source, texts: Mapping[str, str], kernels: list[str]) -> str:
    """One module of all entries, optimized for the baseline of x86-64; refuses symbols that are not `ALLOWED`."""
    modules = [llvm.parse_assembly(text) for text in texts.values()]
    module, *others = modules
    for other in others:
        module.link_in(other)
    for item in [*module.functions, *module.global_variables]:
        if not item.is_declaration and not item.name.startswith(source.prefix + "_"):
            item.linkage = "internal"
    before = str(module)
    _optimize(module, TARGETS["linux64"])
    declared = [f.name for f in [*module.functions, *module.global_variables] if f.is_declaration]
    foreign = sorted(n for n in declared if not n.startswith("llvm.") and n not in ALLOWED)
    if foreign:
        needed = ", ".join(foreign) + _users(before, foreign[0], kernels)
        remedy = "Give the kernel workspace, or write a loop."
        raise BadInput(source.name, f"machine code that needs {needed}", NATIVE, remedy)
    return str(module)


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


def _optimize(module: Any, target: Target, features: str = "") -> Any:
    machine = _machine(target, features)
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False  # Numba has done it
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return machine


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
    choices = "\n".join(_choice(name, times) for name, times in entries)
    forms = [_object(text, to, features, suffix) for features, suffix in (("", "_base"), (to.wide, "_wide"))]
    return (*forms, _object(f"@model_wide = external hidden global i32\n{choices}", to))


def _object(text: str, target: Target, features: str = "", suffix: str = "") -> bytes:
    module = llvm.parse_assembly(widened(text) if target.short_pointers else text)
    machine = _optimize(module, target, features)
    for function in module.functions:
        if not function.is_declaration and function.linkage.name == "external":
            function.visibility = "hidden"
            function.name += suffix
    module.verify()
    return machine.emit_object(module)  # type: ignore[no-any-return]


def _entries(text: str) -> list[tuple[str, int]]:
    """Names of the entries, and how many times they are given."""
    functions = llvm.parse_assembly(text).functions
    return [(f.name, len(list(f.arguments)) - 1) for f in functions if not f.is_declaration and f.linkage.name == "external"]


def _choice(name: str, times: int) -> str:
    """An entry that calls its wide form where the processor has it."""
    values = [f"double %t{k}" for k in range(times)] + ["i64 %block"]
    given, kinds = ", ".join(values), ", ".join(value.split()[0] for value in values)
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
        name, f"what has no native form{_place(text)}: {cause[:200]}", NATIVE, "Move it into a kernel with workspace."
    )


def _plain(error: Exception) -> str:
    return re.sub(r"\x1b\[[0-9;]*m", "", str(error))


def _place(text: str) -> str:
    """The deepest line outside of Numba that a message of it names: it goes from the inside to the outside."""
    frames = re.findall(r'File "([^"]+)", line (\d+)|at (\S+\.py) \((\d+)\)', text)
    places = [(a or c, b or d) for a, b, c, d in frames if "/numba/" not in a + c and not (a + c).startswith(("<", "unknown"))]
    return f" ({places[0][0]}, line {places[0][1]})" if places else ""
