"""Imports point one way, stay inside the packages they may use, and form no cycle."""

from __future__ import annotations

import ast
import re
import sys
from functools import cache
from pathlib import Path

import pytest
from cosimo.components.core.closure import closure

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")
COMPONENTS_MAY_IMPORT = {"numpy", "scipy", "numba", "llvmlite"}  # llvmlite is what Numba compiles with
# From the ground up; a module imports from its own floor and from those below it. Names in brackets share a floor.
FLOORS = (
    ("components",),
    ("fmus",),
    (
        "orchestrator.output",
        "orchestrator.delivery",
        "orchestrator.interrupts",
        "orchestrator.verified_file",
        "orchestrator.cache",
        "orchestrator.kept",
        "orchestrator.loading",
        "orchestrator.renamed",
        "orchestrator.working_directory",
        "orchestrator.code_digests",
        "orchestrator.settings",
    ),
    ("orchestrator.units",),
    ("orchestrator.engine",),
    ("orchestrator.scene",),
    ("orchestrator.views", "orchestrator.opened"),
    ("orchestrator.scene_fmu", "orchestrator.run"),
    ("orchestrator.derivatives",),
    ("orchestrator.judgement",),
    ("orchestrator.session", "orchestrator.estimation"),
    ("orchestrator.harness",),
    ("orchestrator.systems",),
    ("orchestrator.cli",),
)


def modules(package: str) -> list[Path]:
    """All source files of a package."""
    found = sorted((ROOT / package).rglob("*.py"))
    assert found, f"no sources of {package} under {ROOT}"
    return found


def dotted(path: Path) -> str:
    """A module's name below the root; of an __init__ that of its package."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def statements(source: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Every import statement anywhere in a source."""
    return tuple(node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import | ast.ImportFrom))


def imports(source: str) -> list[tuple[int, str]]:
    """(level, module) of every import statement; level 0 is absolute."""
    return [
        (0, alias.name) if isinstance(node, ast.Import) else (node.level, node.module or "")
        for node in statements(source)
        for alias in (node.names if isinstance(node, ast.Import) else node.names[:1])
    ]


def absolute(source: str) -> set[str]:
    """Top-level packages a source imports by absolute name."""
    return {name.split(".")[0] for level, name in imports(source) if level == 0}


def relative_imports(path: Path) -> set[str]:
    """Dotted names below the root that a module imports relatively anywhere, for types and inside functions too."""
    package = path.relative_to(ROOT).parts[:-1]  # of a module and of an __init__ alike, the folder
    found: set[str] = set()
    for node in statements(path.read_text()):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = (*package[: len(package) - node.level + 1], *(node.module.split(".") if node.module else ()))
            found.add(".".join(base))
            found |= {".".join((*base, alias.name)) for alias in node.names}
    return found


def imported_names(path: Path) -> set[str]:
    """What a module imports by name from the project, relatively or as cosimo.module: dotted names below the root."""
    package, found = path.relative_to(ROOT).parts[:-1], set()
    for node in statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.ImportFrom):
            own = (node.module or "").partition(".")[0] == "cosimo" and not node.level
            base = package[: len(package) - node.level + 1] if node.level else ()
            rest = (node.module or "").split(".")[1 if own else 0 :]
            # a test's file may be run as one of another package
            if own or (node.level and package[0] != "tests"):
                found |= {".".join(filter(None, (*base, *rest, alias.name))) for alias in node.names}
    return found


@cache
def is_there(name: str) -> bool:
    """Whether a name is a module, or bound in the module before its last dot."""
    place = ROOT / name.replace(".", "/")
    if place.is_dir() or place.with_suffix(".py").is_file():
        return True
    module, own = place.parent, place.name
    source = module.with_suffix(".py") if module.with_suffix(".py").is_file() else module / "__init__.py"
    return source.is_file() and (
        own == "*" or re.search(rf"\b{re.escape(own)}\b", source.read_text(encoding="utf-8")) is not None
    )


def floor(module: str) -> int:
    """Number of the floor that a module lies on; of names above all floors, -1."""
    on = [k for k, names in enumerate(FLOORS) for name in names if module == name or module.startswith(name + ".")]
    return on[0] if on else -1


def test_the_parser_sees_every_form_of_import():
    source = "import a.b\nfrom c.d import e\nfrom . import f\nfrom ..g import h\ndef i():\n    import j\n"
    assert absolute(source) == {"a", "c", "j"}
    assert sorted(x for x in imports(source) if x[0]) == [(1, ""), (2, "g")]


def test_every_module_has_a_floor():
    names = {dotted(p) for package in PACKAGES for p in modules(package)}
    assert {n for n in names if floor(n) < 0} == {"orchestrator"}


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_point_one_way(package):
    against = {}
    for path in modules(package):
        name = dotted(path)
        if bad := {i for i in relative_imports(path) if floor(i) > floor(name)}:
            against[name] = bad
    assert against == {}


@pytest.mark.parametrize("package", [*PACKAGES, "tests"])
def test_what_is_imported_is_there(package):
    """Wherever the import stands: a function's own is executed by few tests."""
    gone = {dotted(path): bad for path in modules(package) if (bad := {i for i in imported_names(path) if not is_there(i)})}
    assert gone == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_of_the_project_are_relative(package):
    """A bundle gives the package another name, which only relative imports survive; and a user may have a folder of any name."""
    own = {*PACKAGES, "cosimo", "tests"}
    assert [str(p.relative_to(ROOT)) for p in modules(package) if own & absolute(p.read_text())] == []


def test_relative_imports_of_components_stay_among_them():
    out = [dotted(p) for p in modules("components") if any(not i.startswith("components") for i in relative_imports(p))]
    assert out == []


def test_components_need_numpy_scipy_and_numba_only():
    allowed = COMPONENTS_MAY_IMPORT | set(sys.stdlib_module_names)
    others = {str(p.relative_to(ROOT)): bad for p in modules("components") if (bad := absolute(p.read_text()) - allowed)}
    assert others == {}


def test_no_modules_import_each_other_in_a_circle():
    """A package's __init__ does not count as imported by its own modules: `from .x import y` needs x, not the __init__."""
    names = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for package in PACKAGES for p in modules(package)}
    graph = {}
    for name, path in names.items():
        wanted = relative_imports(path)
        # a package that is named stands for its __init__, unless the importing module lives inside it
        wanted |= {f"{w}.__init__" for w in wanted if not name.startswith(w + ".")}
        graph[name] = wanted & names.keys() - {name}
    while free := [name for name, wanted in graph.items() if not wanted & graph.keys()]:
        for name in free:
            del graph[name]
    assert {n: w & graph.keys() for n, w in graph.items()} == {}


def test_machine_code_of_the_orchestrator_depends_on_few_files():
    """Each start reads the files that a kernel's file imports, and an edit in any of them compiles it anew."""
    with_kernels = [
        path
        for path in modules("orchestrator")
        if any(
            isinstance(node, ast.FunctionDef) and "kernel" in map(ast.unparse, node.decorator_list)
            for node in ast.parse(path.read_text(encoding="utf-8")).body
        )
    ]
    assert "orchestrator.engine.algorithms.kernels" in map(dotted, with_kernels)
    for path in with_kernels:
        read = {dotted(file) for file in closure(path)}
        others = {name for name in read if not name.startswith("components.core.")}
        assert others <= {
            dotted(path),
            "orchestrator.units.call_names",
            "orchestrator.units.calls",
            "orchestrator.engine.algorithms.records",
            "orchestrator.engine.algorithms.kernels",
            "orchestrator.engine.algorithms.polynomials",
        }, dotted(path)  # the types that machine code is made for
