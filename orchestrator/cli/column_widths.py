"""Widths of a table's columns on a narrow terminal: lines break between words, and numbers stay whole."""

from __future__ import annotations

from collections.abc import Sequence

WHOLE = (16, 10)  # characters: a cell that begins as a number does and is no longer, such as "0.00846 %", is not broken
LEAST = 8  # characters: a word is broken into parts of no fewer


def column_widths(columns: Sequence[Sequence[str]], width: int, first: int = 0) -> list[int | None]:
    """Width of each column, in characters, of a table of `width` with borders; None for all: they fit as they are.

    columns: the cells of each, its header among them. first: the first column has this width, if the others keep their words.
    """
    longest = [max((len(line) for cell in cells for line in cell.splitlines()), default=0) for cells in columns]
    room = width - 3 * len(columns) - 1
    if sum(longest) <= room:
        return [None] * len(columns)
    for whole in WHOLE:
        words = [max((_unbroken(cell, whole) for cell in cells), default=0) for cells in columns]
        if first and first + sum(words[1:]) <= room:
            words[0] = first
            break
    while sum(words) > room and max(words) > LEAST:
        widest = words.index(max(words))
        words[widest] -= 1
    spare = room - sum(words)
    while spare > 0 and (wanting := [k for k, w in enumerate(words) if w < longest[k]]):
        words[max(wanting, key=lambda k: longest[k] / max(words[k], 1))] += 1
        spare -= 1
    return [max(w, 1) for w in words]


def _unbroken(cell: str, whole: int) -> int:
    """Length of the longest part of a cell that no line end should be in."""
    if len(cell) <= whole and cell[:1] and cell[:1] in "0123456789-−±<>≤≥":
        return len(cell)
    return max(map(len, cell.split()), default=0)
