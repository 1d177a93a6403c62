"""Statements of each folder: `python -m cosimo.tests.architecture.statements` prints the table of docs/development/architecture.md.

A statement is one of Python's grammar (`ast.stmt`) that is no docstring: lines say little where the formatter writes an argument on each.
"""

from __future__ import annotations

import ast
import functools
import re
from collections import Counter
from pathlib import Path

from cosimo.tests.architecture.test_sources import ROOT, shipped_files

PAGE = ROOT / "docs" / "development" / "architecture.md"
ROW = re.compile(r"^\| `([\w/]+)` \| (\d*) \| (\d+) \|$", re.MULTILINE)


def statements(path: Path) -> int:
    """Number of statements of a file."""
    return statements_in(ast.parse(path.read_text(encoding="utf-8")))


def statements_in(node: ast.AST) -> int:
    """Of the blocks of a node: expressions, nine tenths of a tree, have none."""
    count = 0
    for block in ("body", "orelse", "finalbody", "handlers", "cases"):
        for child in getattr(node, block, ()):
            text = isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant) and isinstance(child.value.value, str)
            count += (isinstance(child, ast.stmt) and not text) + statements_in(child)
    return count


def folder(path: str) -> str:
    """The folder that a file counts for: components, fmus, docs; below orchestrator and tests each folder of its own."""
    parts = path.split("/")
    if parts[0] in ("orchestrator", "tests"):
        return "/".join(parts[: 2 if len(parts) > 2 else 1])
    return parts[0] if len(parts) > 1 else "cosimo"


@functools.cache
def counted() -> Counter[str]:
    """Folder -> statements of the files that the tree ships."""
    sizes: Counter[str] = Counter()
    for path in shipped_files():
        if path.suffix == ".py":
            sizes[folder(path.relative_to(ROOT).as_posix())] += statements(path)
    return sizes


def budgets() -> dict[str, int]:
    """Folder -> statements that it may have, as the page says."""
    return {name: int(budget) for name, _, budget in ROW.findall(PAGE.read_text(encoding="utf-8"))}


def main() -> None:
    """Print the rows with budgets as small as they can be, and what both sides have together."""
    sizes, before = counted(), {name: old for name, old, _ in ROW.findall(PAGE.read_text(encoding="utf-8"))}
    for name in sorted(sizes):
        print(f"| `{name}` | {before.get(name, '')} | {-(-sizes[name] // 50) * 50} |")
    tests = sum(size for name, size in sizes.items() if name.startswith("tests"))
    print(
        f"now: product {sum(sizes.values()) - tests - sizes['docs']}, tests {tests}, pictures of the documentation {sizes['docs']}"
    )


if __name__ == "__main__":
    main()
