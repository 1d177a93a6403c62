"""Imports point one way, stay inside the packages they may use, and form no cycle."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")
ABOVE = {"components": {"fmus", "orchestrator", "tests"}, "fmus": {"orchestrator", "tests"}, "orchestrator": {"tests"}}
COMPONENTS_MAY_IMPORT = {"numpy", "scipy", "numba"}


def modules(package: str) -> list[Path]:
    """All source files of a package."""
    found = sorted((ROOT / package).rglob("*.py"))
    assert found, f"no sources of {package} under {ROOT}"
    return found


def imports(source: str) -> Iterator[tuple[int, str]]:
    """(level, module) of every import statement anywhere in a source; level 0 is absolute."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((0, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.level, node.module or ""


def absolute(source: str) -> set[str]:
    """Top-level packages a source imports by absolute name."""
    return {name.split(".")[0] for level, name in imports(source) if level == 0}


def test_the_parser_sees_every_form_of_import():
    source = "import a.b\nfrom c.d import e\nfrom . import f\nfrom ..g import h\ndef i():\n    import j\n"
    assert absolute(source) == {"a", "c", "j"}
    assert sorted(x for x in imports(source) if x[0]) == [(1, ""), (2, "g")]


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_point_one_way(package):
    against = {str(p.relative_to(ROOT)): bad for p in modules(package) if (bad := absolute(p.read_text()) & ABOVE[package])}
    assert against == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_inside_a_package_are_relative(package):
    """A bundle gives the package another name, which only relative imports survive."""
    assert [str(p.relative_to(ROOT)) for p in modules(package) if package in absolute(p.read_text())] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_relative_imports_stay_inside_the_package(package):
    out = []
    for path in modules(package):
        depth = len(path.relative_to(ROOT).parts) - 1  # packages above the module: components/core/x.py has 2
        out += [str(path.relative_to(ROOT)) for level, _ in imports(path.read_text()) if level > depth]
    assert out == []


def test_components_need_numpy_scipy_and_numba_only():
    allowed = COMPONENTS_MAY_IMPORT | set(sys.stdlib_module_names)
    others = {str(p.relative_to(ROOT)): bad for p in modules("components") if (bad := absolute(p.read_text()) - allowed)}
    assert others == {}


def relative_imports(path: Path) -> set[str]:
    """Dotted names of the modules of the same package that a module names anywhere, for types and inside functions too."""
    here = path.relative_to(ROOT).with_suffix("").parts
    package = here[:-1]  # of a module and of an __init__ alike, the folder
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = (*package[: len(package) - node.level + 1], *(node.module.split(".") if node.module else ()))
            found.add(".".join(base))
            found |= {".".join((*base, alias.name)) for alias in node.names}
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_no_modules_import_each_other_in_a_circle(package):
    """A package's __init__ does not count as imported by its own modules: `from .x import y` needs x, not the __init__."""
    names = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for p in modules(package)}
    graph = {}
    for name, path in names.items():
        wanted = relative_imports(path)
        # a package that is named stands for its __init__, unless the importing module lives inside it
        wanted |= {f"{w}.__init__" for w in wanted if not name.startswith(w + ".")}
        graph[name] = wanted & names.keys() - {name}
    while free := [name for name, wanted in graph.items() if not wanted & graph.keys()]:
        for name in free:
            del graph[name]
    assert graph == {}
