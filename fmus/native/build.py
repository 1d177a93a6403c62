"""A component to FMU files that need no Python: compiled, linked with the runtime, packed. The same source and compiler give the
same file, byte for byte."""

from __future__ import annotations

import inspect
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ...components.core import store
from ...components.core.component import Component
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput, pick
from ...components.core.kernel_sources import sources_digest
from ..build import write
from ..derivatives.compiled import kept_object
from ..derivatives.grammar import Unsupported
from ..description import documentation, shared_files
from ..evidence import Evidence
from ..versions import version
from .description import HOST, description, listed, name_of
from .instance import Model, Places, model_of
from .machine_code import NATIVE, NO_SLOPES, TARGETS, compile_entries, object_code, slopes_of, source_of
from .variables import NativeVariable, native_variables, tables

RUNTIME = Path(__file__).parent / "runtime"
# contraction would form fused products, and other bits than those of the component in process
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fvisibility=hidden")
HERE = {
    ("Linux", "x86_64"): "linux64",
    ("Windows", "AMD64"): "win64",
    ("Linux", "aarch64"): "linux-arm64",
    ("Darwin", "arm64"): "macos-arm64",
    ("Darwin", "x86_64"): "macos-x64",
}


@dataclass(frozen=True)
class Library:
    """What FMUs of one model, for any version of FMI, have in common.

    name: the model's identifier.  component: the component, None for a scene.  described: what texts and attributes come from, a
    class of components or what has their attributes.  abilities: attributes of the model description by version of FMI.
    """

    name: str
    component: Any
    described: Any
    variables: tuple[Any, ...]
    token: str
    model: str  # model.c
    objects: dict[str, tuple[bytes, ...]]  # target -> object files
    binaries: dict[str, bytes]  # target -> library
    abilities: Mapping[int, Mapping[str, str]]
    host: str = HOST  # what the documentation says of hosts


def own_target() -> str:
    """The target that is this machine, or "" if it is none of them."""
    return HERE.get((platform.system(), platform.machine()), "")


def compiler(target: str) -> list[str]:
    """The command of a C compiler for a target: zig's where it is installed, else the system's own for this machine."""
    pick(target, TARGETS, "build --native", "one of " + ", ".join(TARGETS), "target")
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", TARGETS[target].zig]
    compiler = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
    if target == own_target() and compiler:
        return [compiler, "-Wl,--build-id=none"]
    raise BadInput(
        "build --native",
        f"no C compiler for {target}",
        "zig, which compiles for all targets" + (", or cc" if target == own_target() else ""),
        "Install it: pip install 'cosimo[native]'.",
    )


def library(name: str, make: Callable[[], Any], targets: Iterable[str]) -> Library:
    """Compile what `make` makes, a component with its effects, parameters and start values, for all targets."""
    compilers = {target: compiler(target) for target in targets}  # refused before anything is compiled
    component = initialized(make())
    text, places = compile_entries(source_of(component)), Places(component)
    variables = native_variables(component, places)
    return assembled(
        name,
        type(component),
        variables,
        model_of(component, places),
        (text,),
        compilers,
        component=component,
        slopes=_slopes(text),
    )


def _slopes(text: str) -> str:
    """The derivative of the outputs; none where they call something that has no derivative here."""
    try:
        return slopes_of(text)
    except Unsupported:
        return ""


def assembled(
    name: str,
    described: Any,
    variables: tuple[NativeVariable, ...],
    held: Model,
    texts: Sequence[str],
    compilers: Mapping[str, list[str]],
    *,
    component: Any = None,
    abilities: Mapping[int, Mapping[str, str]] = MappingProxyType({}),
    host: str = HOST,
    sources: Sequence[str] = (),
    slopes: str = "",
) -> Library:
    """The libraries of a model for the targets of some compilers.

    texts: of entries, in LLVM's language; sources: of the runtime, beside those of each FMU; slopes: of the
    outputs, see `slopes_of`, empty for a model that has none; others as of `Library`.
    """
    if not slopes:
        without = {f: {f"providesDirectionalDerivative{'s' * (f == 3)}": "false", **abilities.get(f, {})} for f in (2, 3)}
        abilities, slopes = without, NO_SLOPES
    texts = (*texts, slopes)
    objects = {target: tuple(code for text in texts for code in object_code(text, target)) for target in compilers}
    model_description = description(2, name, described, variables, "", abilities=abilities.get(2, {}))
    digest = store.digest_of(*texts, tables(held, variables, ""), *_runtime(), model_description)
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    model = tables(held, variables, token)
    binaries = {
        target: linked(name, target, command, model, objects[target], ("native.c", *TARGETS[target].runtime, *sources))
        for target, command in compilers.items()
    }
    return Library(name, component, described, variables, token, model, objects, binaries, abilities, host)


def initialized(component: Component) -> KernelComponent:
    """The component with its start values initialized, which refuses what cannot be built; `BadInput` for one in plain Python."""
    if not isinstance(component, KernelComponent):
        raise BadInput(
            type(component).__name__,
            "a component in plain Python",
            NATIVE,
            "Derive it from KernelComponent or one of its kinds: docs/extending.md.",
        )
    component.initialize(0.0)
    return component


def _files() -> list[str]:
    return sorted(f.name for f in RUNTIME.iterdir() if f.suffix in (".c", ".h"))


def _runtime() -> list[bytes]:
    return [(RUNTIME / file).read_bytes() for file in _files()]


def write_sources(folder: Path, model: str, codes: Sequence[bytes]) -> list[str]:
    """All that a C compiler needs: the runtime, model.c and the object files, whose names are returned."""
    for file in _files():
        shutil.copy(RUNTIME / file, folder)
    Path(folder, "model.c").write_text(model)
    names = [f"entries{k}.o" for k in range(len(codes))]
    for name, code in zip(names, codes, strict=True):
        Path(folder, name).write_bytes(code)
    return names


def built(name: str, make: Callable[[], Any], targets: Iterable[str]) -> Path:
    """The FMU (FMI 2) of what `make` makes, kept in the user's cache by the contents of all that it follows from.

    Raises `BadInput` as `build_native`.
    """
    targets, component = list(targets), make()
    return store.kept(
        "native", _contents(component, targets), f"{name}.fmu", lambda path: pack(library(name, make, targets), path.parent, 2)
    )


def _contents(component: Any, targets: list[str]) -> str:
    """Digest of a component's sources and configuration, of the runtime, and of what compiles and links them."""
    cls = type(component)
    versions = [f"{name} {version(name)}" for name in ("cosimo", "numpy", "scipy", "numba", "llvmlite")]
    configuration = (
        cls.__qualname__,
        targets,
        component.on,
        sorted(component.parameters.items()),
        component.inputs,
        component.u[0].tolist(),
    )
    compilers = [compiler_version(target) for target in targets]
    return store.digest_of(
        sources_digest(inspect.getfile(cls), __file__), *_runtime(), repr(configuration), sys.version, *versions, *compilers
    )


def compiler_version(target: str) -> str:
    """What tells one compiler for a target from another."""
    command = compiler(target)
    if "ziglang" in command:
        return f"zig {version('ziglang')} {TARGETS[target].zig}"
    return subprocess.run([command[0], "--version"], capture_output=True, text=True, check=False).stdout


def linked(name: str, target: str, command: list[str], model: str, codes: Sequence[bytes], sources: Sequence[str]) -> bytes:
    """The library of a model's tables, object files and sources of the runtime, by the command of a compiler for the target; kept."""
    words = name, *command, compiler_version(target), *FLAGS, *TARGETS[target].flags, *sources, model
    return kept_object(lambda: _linked(name, target, command, model, codes, sources), *words, *codes, *_runtime())


def _linked(name: str, target: str, command: list[str], model: str, codes: Sequence[bytes], sources: Sequence[str]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="cosimo-build-") as folder:
        objects = write_sources(Path(folder), model, codes)
        result = name + TARGETS[target].suffix
        done = subprocess.run(
            [*command, *FLAGS, *TARGETS[target].flags, *sources, "model.c", *objects, "-o", result, "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            env=compiler_environment(),
        )
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines() or ["no message"]
            raise BadInput(
                "build --native",
                f"{command[0]} for {target} failed: {lines[0][:300]}",
                "a C compiler that links",
                "Check its installation.",
            )
        return Path(folder, result).read_bytes()


def compiler_environment() -> dict[str, str]:
    """Of a compiler: zig keeps what it has compiled in the cache of cosimo, unless the user has set its own variables."""
    folder = store.cache_folder("zig")
    if folder is None:
        return dict(os.environ)
    return {"ZIG_GLOBAL_CACHE_DIR": str(folder), "ZIG_LOCAL_CACHE_DIR": str(folder)} | os.environ


def build_native(
    name: str,
    make: Callable[[], Any],
    directory: Path,
    targets: Iterable[str],
    standards: Iterable[int] = (2,),
    derivatives: bool = False,
    evidence: Evidence | None = None,
) -> list[Path]:
    """Write directory/<name>.fmu (FMI 2) and directory/<name>.fmi3.fmu (FMI 3), as asked for, and return their paths.

    `BadInput` for a component that cannot be compiled ahead of time, with the line that prevents it, and for a missing compiler.
    """
    targets, standards = list(targets), list(standards)
    check_versions(targets, standards)
    done = library(name, make, targets)
    return [pack(done, directory, fmi, derivatives, evidence=evidence) for fmi in standards]


def check_versions(targets: Iterable[str], standards: Iterable[int]) -> None:
    """`BadInput` for a target whose libraries have no place in an FMU of a version of FMI."""
    for target in targets:
        if target in TARGETS and not TARGETS[target].folder2 and 2 in standards:
            raise BadInput("build --native", f"target {target!r} with FMI 2", "FMI 3, whose functions it has", "Add --fmi 3.")


def pack(
    done: Library, directory: Path, fmi: int, derivatives: bool = True, file: str = "", evidence: Evidence | None = None
) -> Path:
    """One FMU file of a library; `derivatives`: list those of its inputs; `file`: its name without suffix, else the library's."""
    described = done.described
    present = [v for _, v in listed(done.variables, derivatives)]
    scalars = tuple(v.scalar for v in present)
    ends = scalars if fmi == 2 else tuple(replace(v.scalar, name=name_of(v)) for v in present if v.size)
    notes = dict.fromkeys(TARGETS[target].note for target in done.binaries if TARGETS[target].note)
    members = {
        "modelDescription.xml": description(
            fmi, done.name, described, done.variables, done.token, derivatives, abilities=done.abilities.get(fmi, {})
        ),
        "documentation/index.html": documentation(
            done.name, described, scalars, " ".join([done.host, *notes]), evidence.section() if evidence else ""
        ),
        **shared_files(done.name, described, ends, fmi),
        **(evidence.members(fmi == 3) if evidence else {}),
    }
    if evidence is not None:
        members["modelDescription.xml"] = evidence.described(members["modelDescription.xml"])
    for folder, (target, content) in _folders(done.binaries, fmi).items():
        members[f"binaries/{folder}/{done.name}{TARGETS[target].suffix}"] = content
    return write(members, Path(directory) / f"{file or done.name}{'.fmi3' if fmi == 3 else ''}.fmu")


def _folders(binaries: dict[str, bytes], fmi: int) -> dict[str, tuple[str, bytes]]:
    """Folder under binaries/ -> target and library."""
    if fmi == 3:
        return {TARGETS[target].folder3: (target, content) for target, content in binaries.items()}
    also = {TARGETS[target].also2: (target, content) for target, content in binaries.items() if TARGETS[target].also2}
    return also | {TARGETS[target].folder2: (target, content) for target, content in binaries.items()}
