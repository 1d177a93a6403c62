"""FMUs without a library for this machine: their sources in C are compiled, once for each content and compiler.

The compiler is that of native FMUs. Nothing of an FMU is executed here, and of what it asks of a compiler definitions and folders
of headers alone are taken: other options may name files that a compiler executes.

Source: FMI 2.0.4, 2.2.7 (SourceFiles); FMI 3.0.2, 2.5.3 (buildDescription.xml).
"""

from __future__ import annotations

import subprocess
import tempfile
import zipfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any

import fmpy
from lxml import etree

from ...components.core.errors import BadInput
from ...components.core.store import digest_of, kept, replaced
from ...fmus.native.build import compiler, compiler_environment, compiler_version, own_target
from ...fmus.native.machine_code import TARGETS
from ...fmus.versions import version
from ..loading import check_archive
from .description import DESCRIPTION, Description

SOURCES, BUILD = "sources/", "sources/buildDescription.xml"
HEADERS = Path(fmpy.__file__).parent / "c-code"  # of FMI, which an FMU need not have
# functions without a prefix, as libraries have them; no operation is fused, and no sanitizer stops what a maker's build lets pass
PLAIN = [f"-DFMI{fmi}_{what}" for fmi in (2, 3) for what in ("OVERRIDE_FUNCTION_PREFIX", "FUNCTION_PREFIX=")]
FLAGS = ("-fPIC", "-O2", "-w", "-ffp-contract=off", "-fno-sanitize=all", *PLAIN)
LONGEST = 600.0  # s for a compiler
FUNCTIONS = {2: b"\0fmi2Instantiate\0", 3: b"\0fmi3Terminate\0"}


@dataclass(frozen=True)
class Sources:
    """What a compiler is told: files and folders of headers below `sources`, definitions as options."""

    files: tuple[str, ...]
    headers: tuple[str, ...] = ()
    definitions: tuple[str, ...] = ()


def with_library(description: Description, where: str) -> str:
    """The path of the FMU, or of one that has a library for this machine as well.

    Raises `BadInput` where it has neither a library nor sources, without a compiler, and for sources that do not compile.
    """
    path, target = description.path, own_target()
    if not target:
        return path
    kind, identifier = TARGETS[target], description.interface.modelIdentifier
    own = kind.folder3 if description.fmi3 else kind.folder2
    with zipfile.ZipFile(path) as file:
        check_archive(file, path)
        names = file.namelist()
        folders = {
            parts[1]
            for parts in (PurePosixPath(n.replace("\\", "/")).parts for n in names)
            if len(parts) > 2 and parts[0] == "binaries"
        }
        if folders & {own, kind.also2, kind.folder2, kind.folder3}:
            return path
        sources = _sources_of(file, names, description, where)
        if absent := [name for name in sources.files if str(PurePosixPath(SOURCES + name)) not in names]:
            raise BadInput(where, f"{path} without its source file {absent[0]!r}", "all that it lists", "Ask its maker for them.")
    if not sources.files:
        has = f"libraries for {', '.join(sorted(folders))} alone" if folders else "no library"
        raise BadInput(where, f"{path} with {has}", f"a library for {own}, or sources in C", "Ask its maker for one.")
    try:
        command = compiler(target)
    except BadInput as error:
        raise BadInput(
            where, f"{path}: no library for {own}, and no compiler for its sources", error.expected, error.remedy
        ) from None
    content = Path(path).read_bytes()
    place = f"binaries/{own}/{identifier}{kind.suffix}"  # a cache may be shared by machines whose compilers tell the same of themselves
    digest = digest_of(content, compiler_version(target), repr((FLAGS, kind.flags, place)), version("fmpy"))

    def make(result: Path) -> Path:
        with tempfile.TemporaryDirectory(prefix="cosimo-build-") as folder:
            library = _compiled(Path(folder), path, command + list(kind.flags), sources, where)
        if FUNCTIONS[description.model.fmiMajorVersion] not in library:
            raise BadInput(where, f"sources of {path} without the functions of FMI by their names", "functions without a prefix")
        result.parent.mkdir(parents=True, exist_ok=True)
        whole = BytesIO(content)
        with zipfile.ZipFile(whole, "a") as file:
            file.writestr(place, library)
        with replaced(result, "wb") as out:
            out.write(whole.getvalue())
        return result

    return str(kept("sources", digest, Path(path).name, make))


def _sources_of(file: zipfile.ZipFile, names: list[str], description: Description, where: str) -> Sources:
    interface: Any = description.interface
    if not description.fmi3:
        tag = "ModelExchange" if description.exchange else "CoSimulation"
        listed = [f.get("name", "") for f in _parsed(file, DESCRIPTION).iterfind(f"{tag}/SourceFiles/File")]
        files = listed or [
            n.removeprefix(SOURCES) for n in names if n.startswith(SOURCES) and n.endswith(".c") and n.count("/") == 1
        ]
        return _checked(Sources(tuple(files)), where)
    if BUILD not in names:
        return Sources(())
    wanted = [c for c in _parsed(file, BUILD).iter("BuildConfiguration") if c.get("modelIdentifier") == interface.modelIdentifier]
    for node in wanted[:1]:
        for each in node.iter("Library", "SourceFileSet"):
            if each.tag == "Library" or each.get("compilerOptions"):
                what = f"library {each.get('name')!r}" if each.tag == "Library" else f"options {each.get('compilerOptions')!r}"
                raise BadInput(where, f"sources that want the {what}", "sources of C alone")
        definitions = [f"-D{d.get('name')}={d.get('value') or ''}" for d in node.iter("PreprocessorDefinition")]
        files, headers = ([n.get("name", "") for n in node.iter(tag)] for tag in ("SourceFile", "IncludeDirectory"))
        return _checked(Sources(tuple(files), tuple(headers), tuple(definitions)), where)
    return Sources(())


def _parsed(file: zipfile.ZipFile, name: str) -> etree._Element:
    return etree.fromstring(file.read(name), etree.XMLParser(resolve_entities=False, no_network=True))


def _checked(sources: Sources, where: str) -> Sources:
    """No file of another language, and none outside of `sources`."""
    for name in (*sources.files, *sources.headers):
        if ".." in PurePosixPath(name).parts or name.startswith("/") or "\\" in name or ":" in name:
            raise BadInput(where, f"source file {name!r}", "one in the folder sources of the FMU")
    if other := [name for name in sources.files if not name.endswith(".c")]:
        raise BadInput(where, f"source file {other[0]!r}", "sources in C")
    return sources


def _compiled(folder: Path, path: str, command: list[str], sources: Sources, where: str) -> bytes:
    with zipfile.ZipFile(path) as file:
        file.extractall(folder, [n for n in file.namelist() if n.startswith(SOURCES)])
    headers = [f"-I./{name}" for name in ("", *sources.headers)]
    files = [f"./{name}" for name in sources.files]
    result = folder / "library"
    try:
        done = subprocess.run(
            [*command, *FLAGS, *sources.definitions, *headers, f"-I{HEADERS}", *files, "-o", str(result), "-lm"],
            cwd=folder / SOURCES,
            capture_output=True,
            text=True,
            errors="replace",
            env=compiler_environment(),
            timeout=LONGEST,
        )
    except subprocess.TimeoutExpired:
        raise BadInput(
            where, f"{path}, whose sources take a compiler longer than {LONGEST:g} s", "sources that compile"
        ) from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines() or ["no message"]
        raise BadInput(
            where,
            f"{path}, whose sources do not compile: {lines[0][:300]}",
            "sources in C that do",
            "Ask its maker for a library.",
        )
    return result.read_bytes()
