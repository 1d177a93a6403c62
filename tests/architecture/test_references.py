"""Names in backticks exist: modules, files, classes, functions and variables that docstrings and documentation refer to."""

from __future__ import annotations

import ast
import importlib.util
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from cosimo.tests.architecture.test_sources import ROOT, SOURCES

PAGES = [ROOT / "README.md", *sorted(p for p in (ROOT / "docs").rglob("*.md") if "generated" not in p.parts)]
NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*(\(\))?")
EXTERNAL = {"tbb", "nohup", "X097_DE_time", "X097RPM", "DIR", "docs/generated"}  # of the system, of others' files, of a build
CLASS = re.compile(r"\b(?:[A-Z][a-z0-9]+){2,}\b")
FILE = re.compile(
    r"[\w./-]+\.(py|md)|(components|fmus|orchestrator|tests|docs)/[\w./-]+"
)  # others are written by commands or users


@cache
def read(path: Path) -> tuple[frozenset[str], tuple[str, ...]]:
    """The names that a module defines or uses, and its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return frozenset(defined(tree)), tuple(node.value for node in docstrings(tree))


def docstrings(tree: ast.Module) -> Iterator[ast.Constant]:
    """The docstrings of a module, its classes and its functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, clean=False) is not None:
            yield node.body[0].value


def defined(tree: ast.Module) -> Iterator[str]:
    """Every name in the code of a module, and every word of its texts without spaces, such as keys of tables."""
    documentation = set(map(id, docstrings(tree)))
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.Name(id=name) | ast.Attribute(attr=name):
                yield name
            case ast.arg(arg=name) | ast.keyword(arg=str(name)):
                yield name
            case ast.alias(name=name, asname=other):
                yield from (*name.split("."), other or name)
            case ast.ImportFrom(module=str(name)):
                yield from name.split(".")
            case ast.Constant(value=str(text)) if id(node) not in documentation:
                fields = re.findall(r"^ *(\w+) +[if] ", text, re.MULTILINE)  # of the records of the engine
                yield from (*fields, *(re.findall(r"\w+", text) if " " not in text.strip() else ()))


@cache
def names() -> frozenset[str]:
    """All names of the tree: of code, of modules and folders, and keys of TOML files."""
    known = {name for path in SOURCES for name in read(path)[0]}
    known |= {part for path in SOURCES for part in path.relative_to(ROOT).with_suffix("").parts}
    known |= {
        word for path in (ROOT / "orchestrator").rglob("*.toml") for word in re.findall(r"\w+", path.read_text(encoding="utf-8"))
    }
    return frozenset(known)


@cache
def files() -> frozenset[str]:
    """Paths of all files and folders below the root, each also without its first folders."""
    shipped = [p for p in ROOT.rglob("*") if not {".git", "__pycache__", "generated"} & set(p.parts)]
    return frozenset("/".join(parts[k:]) for p in shipped if (parts := p.relative_to(ROOT).parts) for k in range(len(parts)))


def missing(text: str, own: frozenset[str] = frozenset()) -> list[str]:
    """References in backticks to what does not exist; `own`: names that the text itself introduces."""
    prose = re.sub(r"^ *```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL)
    absent = []
    for quoted in re.findall(r"(?<!`)`([^`\n]+)`(?!`)", prose):
        if quoted in EXTERNAL:
            continue
        if FILE.fullmatch(quoted):
            written = Path(quoted).stem in own or f"`{quoted}`:\n\n```" in text  # by the page, which shows the file
            absent += [] if written or quoted.rstrip("/") in files() else [quoted]
        elif NAME.fullmatch(quoted) and not of_library(quoted):
            absent += [quoted] if set(quoted.removesuffix("()").split(".")) - names() - own else []
        elif quoted.startswith("cosimo "):
            absent += [name for name in CLASS.findall(quoted) if name not in names() | own]
    return absent


def defined_in(path: Path) -> Iterator[str]:
    """The module, its folders, its functions and classes, and the names that it and its classes assign."""
    yield from path.relative_to(ROOT).with_suffix("").parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        if isinstance(node, ast.Module | ast.ClassDef):
            assigned = (s for s in node.body if isinstance(s, ast.Assign | ast.AnnAssign))
            yield from (n.id for s in assigned for n in ast.walk(s) if isinstance(n, ast.Name))


def test_see_leads_to_a_module_or_something_defined():
    """A local variable of the same name somewhere is not enough."""
    product = [path for path in SOURCES if path.relative_to(ROOT).parts[0] != "tests"]
    known = {name for path in product for name in defined_in(path)}
    lost = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in product
        for text in read(path)[1]
        for name in re.findall(r"[Ss]ee `([A-Za-z_][\w.]*)(?:\(\))?`", text)
        if not set(name.removesuffix(".py").split(".")) <= known
    }
    assert lost == set()


def of_library(name: str) -> bool:
    """Whether a name belongs to a module of Python or of a library, such as `numpy.ndarray`."""
    first = name.partition(".")[0]
    return "." in name and first not in names() and importlib.util.find_spec(first) is not None


def test_docstrings_refer_to_what_exists():
    stale = {}
    for path in SOURCES:
        absent = [name for text in read(path)[1] for name in missing(text)]
        if absent:
            stale[path.relative_to(ROOT).as_posix()] = absent
    assert stale == {}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_documentation_refers_to_what_exists(page):
    text = page.read_text(encoding="utf-8")
    blocks = "".join(re.findall(r"^```.*?^```", text, re.MULTILINE | re.DOTALL))
    assert missing(text, frozenset(re.findall(r"\w+", blocks))) == []


def test_what_does_not_exist_is_noticed():
    absent = ["zyx" + "wvu", "core/zyx.py", "kernel.zyx" + "wvu"]
    present = ["kernel", "orchestrator/run/run.py", "numpy.ndarray", "a b"]
    assert missing(" ".join(f"`{name}`" for name in absent + present)) == absent
    assert missing("```text\n`zyx`\n```\n") == []
