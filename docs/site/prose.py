"""Docstrings and texts of declarations as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import equations

_SIGNS = re.compile(r"([*_<>$\[\]|~#])")


def plain(text: str, symbols: set[str] | None = None) -> str:
    """A text in which nothing but `code` has a meaning to Markdown, on one line. symbols: of equations beside it, if there are."""
    if symbols is not None:
        return equations.sentences(" ".join(text.split()), symbols, plain_word)
    return plain_word(" ".join(text.split()))


def plain_word(text: str) -> str:
    """The same of any part of a text."""
    pieces = re.split(r"(`[^`]*`)", text)
    return "".join(p.replace("|", "\\|") if p.startswith("`") else _SIGNS.sub(r"\\\1", p) for p in pieces)


def code(text: str) -> str:
    """A name as code, in a table or not; nothing of nothing."""
    return f"`{text}`" if text else ""


def verbatim(text: str) -> str:
    """Lines as they stand, such as equations."""
    return f"```text\n{text.rstrip()}\n```"


def formula(text: str) -> str:
    """Lines of equations as a formula; as they stand where they are something else."""
    try:
        return equations.block(text)
    except equations.NotAnEquation:
        return verbatim(text)


def docstring(text: str, symbols: set[str] | None = None) -> str:
    """A cleaned docstring: paragraphs, and indented blocks: as they stand, or equations where there are symbols."""
    parts = []
    for block in re.split(r"\n\s*\n", text.strip("\n")):
        lines = block.splitlines()
        split = next((k for k, line in enumerate(lines) if line.startswith("    ")), len(lines))
        if lines[:split]:
            parts.append(plain(" ".join(lines[:split]), symbols))
        if lines[split:]:
            block = "\n".join(line.removeprefix("    ") for line in lines[split:])
            parts.append(verbatim(block) if symbols is None else formula(block))
    return "\n\n".join(parts)


def table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A Markdown table; cells are Markdown already. Nothing of no rows."""
    body = ["| " + " | ".join(str(cell).replace("\n", " ") for cell in row) + " |" for row in rows]
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header), *body]) if body else ""


def joined(*parts: str) -> str:
    """Parts of a page, empty ones left out."""
    return "\n\n".join(part for part in parts if part) + "\n"
