"""The sources of a user's component, packed so that its FMU needs nothing of cosimo where it runs.

The user's module and those beside it that it imports go to a folder `own` beside cosimo's components. Their imports of cosimo
become relative imports, because the bundle of an FMU has another name.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from ..components.core.closure import closure, imports
from ..components.core.errors import BadInput
from ..components.public_names import PLACE

PACKAGE = __name__.partition(".")[0]
PUBLIC = "public.py"  # in `components`: the names that `from cosimo import ...` asks for
LIBRARIES = {"numpy", "scipy", "numba"}
_STATEMENT = re.compile(r"^([ \t]*)(from|import)[ \t]+([\w.]+)(.*)$", re.MULTILINE)


def own_sources(name: str, components: Path) -> tuple[str, dict[str, bytes]]:
    """(module below `components`, relative path -> content) of "module:Class", whose module has been imported.

    Raises `BadInput` for imports that the FMU's host could not follow: of other libraries, or of cosimo beyond components.
    """
    module = name.partition(":")[0]
    file = Path(str(getattr(sys.modules[module], "__file__", None) or ""))
    if module == "__main__" or file.suffix != ".py":
        raise BadInput(
            "build",
            f"component {name!r}",
            "a class of a module in a file",
            "What is packed is the module: put the class into a file of its own.",
        )
    root = file.resolve().parents[module.count(".") + (file.name == "__init__.py")]
    start = [
        file.resolve(),
        *(
            p
            for parent in file.resolve().parents
            if parent.is_relative_to(root) and parent != root
            for p in [parent / "__init__.py"]
            if p.is_file()
        ),
    ]
    paths = {path for first in start for path in closure(first, lambda n: _file_of(n, root, components))}
    contents = {path: path.read_bytes() for path in paths}
    own = {path: text for path, text in contents.items() if not path.is_relative_to(components)}
    wanted = sorted(
        {n for text in own.values() for level, m, names in imports(text) if not level and m == PACKAGE for n in names or PLACE}
    )
    library = {path for path in paths if path.is_relative_to(components)}
    for public in wanted:
        library |= closure(components.joinpath(*_place(public, file).split(".")).with_suffix(".py")).keys()
    folders = {p for path in library for p in path.parents if p.is_relative_to(components)}
    files = {
        path.relative_to(components).as_posix(): path.read_bytes()
        for path in [*library, *(f / "__init__.py" for f in folders | {components})]
    }
    files |= {f"own/{path.relative_to(root).as_posix()}": _relative(path, text, root, own) for path, text in own.items()}
    files["own/__init__.py"] = b""
    if wanted:
        lines = [f"from .{_place(public, file)} import {public} as {public}\n" for public in wanted]
        files[PUBLIC] = "".join(lines).encode()
    inner = file.resolve().relative_to(root).with_suffix("").parts
    return ".".join(("own", *(inner[:-1] if inner[-1] == "__init__" else inner))), files


def _place(public: str, file: Path) -> str:
    """The module below `components` of a public name."""
    if public not in PLACE:
        raise BadInput(
            f"build: {file}",
            f"an import of {PACKAGE}.{public}",
            f"names that components use: {', '.join(PLACE)}",
            "Scenes and runs belong into another file.",
        )
    return PLACE[public].removeprefix("components.")


def _file_of(name: str, root: Path, components: Path) -> Path | None:
    """The source of a module imported by its full name: of cosimo's components, or of the user."""
    first, _, rest = name.partition(".")
    if first == PACKAGE:
        place = components.parent.joinpath(*rest.split("."))
        return _source(place) if rest.startswith("components.") else None
    return _source(root.joinpath(*name.split("."))) if first not in LIBRARIES | sys.stdlib_module_names else None


def _source(place: Path) -> Path | None:
    return next((p for p in (place.with_name(place.name + ".py"), place / "__init__.py") if p.is_file()), None)


def _relative(path: Path, text: bytes, root: Path, own: Mapping[Path, bytes]) -> bytes:
    """A user's source whose imports of cosimo and of own modules are relative to its place in the bundle."""
    up = "." * len(path.relative_to(root).parts)  # up to `own`; one more up to `components`

    def statement(match: re.Match[str]) -> str:
        indent, kind, module, rest = match.groups()
        first, _, inner = module.partition(".")
        if first == PACKAGE:
            if kind == "from" and not inner:
                return f"{indent}from {up}.{PUBLIC.removesuffix('.py')}{rest}"
            if kind == "from" and inner.startswith("components."):
                return f"{indent}from {up}.{inner.removeprefix('components.')}{rest}"
            if kind == "import" and not inner:
                alias = rest.strip().removeprefix("as ").strip() or PACKAGE
                return f"{indent}from {up}. import {PUBLIC.removesuffix('.py')} as {alias}"
            raise BadInput(
                f"build: {path}",
                f"{match[0].strip()!r}",
                f"'from {module} import ...'" if kind == "import" else "imports of cosimo's public names or of its components",
                "The FMU carries components only.",
            )
        if _source(root.joinpath(*module.split("."))) in own:
            if kind == "from":
                return f"{indent}from {up}{module}{rest}"
            if not inner:
                return f"{indent}from {up} import {module}{rest}"
            raise BadInput(
                f"build: {path}",
                f"{match[0].strip()!r}",
                f"'from {module} import ...'",
                "Modules of a package are packed by that form.",
            )
        if first not in LIBRARIES | sys.stdlib_module_names:
            raise BadInput(
                f"build: {path}",
                f"an import of {first!r}",
                "numpy, scipy, numba, cosimo, the standard library, or a module beside this one",
                "The FMU's host has no other.",
            )
        return match[0]

    lines = text.decode("utf-8-sig").splitlines(keepends=True)
    starts = _import_lines(text)
    result = "".join(_STATEMENT.sub(statement, line) if k in starts else line for k, line in enumerate(lines, 1)).encode()
    for level, name, _ in imports(result):
        if not level and (name.partition(".")[0] == PACKAGE or _source(root.joinpath(*name.split("."))) in own):
            raise BadInput(f"build: {path}", f"an import of {name!r} together with others", "an import statement of its own")
    return result


def _import_lines(text: bytes) -> set[int]:
    """Lines on which absolute imports start."""
    return {
        n.lineno
        for n in ast.walk(ast.parse(text))
        if isinstance(n, ast.Import) or (isinstance(n, ast.ImportFrom) and not n.level)
    }
