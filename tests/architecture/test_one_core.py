"""What a component computes is asked of its kernels, never of its source."""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# files that read sources as files: which of them belong together, and where a declaration stands
READERS = {
    "components/core/closure.py": "imports of a source: what is packed, and what machine code depends on",
    "components/core/declaration.py": "the line of a declaration, for a message",
    "fmus/own.py": "the lines of imports that become relative in a bundle",
    "orchestrator/code_digests.py": "a digest that comments do not change",
}
READ = {"getsource", "getsourcelines", "findsource", "dis"}
FILES = sorted(path for package in ("components", "fmus", "orchestrator") for path in (ROOT / package).rglob("*.py"))


def offences(text: str) -> list[str]:
    """Imports of `ast` and calls that read the source or the byte code of functions."""
    tree = ast.parse(text)
    imports = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    imports += [str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names = [node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    names += [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)]
    return sorted({n for n in imports if n in ("ast", "dis")} | {n for n in names if n in READ})


def test_no_product_code_reads_how_a_function_is_written():
    texts = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in FILES}
    suspects = {place: text for place, text in texts.items() if re.search(rf"\b({'|'.join(['ast', *READ])})\b", text)}
    assert {place: bad for place, text in suspects.items() if place not in READERS and (bad := offences(text))} == {}


def test_what_may_read_sources_is_there():
    assert all(offences((ROOT / place).read_text(encoding="utf-8")) for place in READERS)


def test_an_offence_is_seen():
    assert offences("import ast, inspect\nx = inspect.getsource(f)\n") == ["ast", "getsource"]
