"""A component as a box with its signals, as SVG in the colours of the page around it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

LINE, TOP, ARROW, LETTER = 17, 44, 26, 7.3  # px: a signal's height, the title's, an arrow's length, width of a letter
MOST = 9  # signals of a port on one side that are written out; of more, the first ones and how many there are


def sketch(title: str, ports: Sequence[tuple[str, Sequence[str], Sequence[str]]], units: dict[str, str]) -> str:
    """SVG of a component. ports: (name, inputs, outputs), the name "" for signals that are always there; units by signal."""
    left, right = ([row for name, *sides in ports for row in _rows(name, sides[k], units)] for k in (0, 1))
    widths = [max((_width(row) for row in rows), default=40.0) for rows in (left, right)]
    body = max(widths[0] + widths[1] + 40.0, len(title) * 9.0 + 20.0)
    width, height = body + 2 * ARROW, TOP + LINE * max(len(left), len(right), 1) + 10
    parts = [
        f'<rect x="{ARROW}" y="1" width="{body:.0f}" height="{height - 2:.0f}" rx="4"/>',
        f'<text class="title" x="{width / 2:.0f}" y="24" text-anchor="middle">{escape(title)}</text>',
    ]
    parts += _side(left, ARROW + 8, "start", (2, ARROW - 2)) + _side(right, width - ARROW - 8, "end", (width - ARROW, width - 4))
    head = (
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="currentColor"/></marker></defs>'
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="signals" role="img" aria-label="signals of {escape(title)}" width="{width:.0f}" '
        f'height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}">{head}{"".join(parts)}</svg>'
    )


def _rows(port: str, signals: Sequence[str], units: dict[str, str]) -> list[tuple[str, str]]:
    """(text, unit) of what is written for a port's signals on one side; a port's name, without unit marks, above them."""
    names = list(dict.fromkeys(re.sub(r"\[\d+\]$", "[]", s) for s in signals))
    if not names:
        return []
    rows = [(port, "port")] if port else []
    rows += [(n.removeprefix(port + ".") if port else n, units.get(n.removesuffix("[]"), units.get(n, ""))) for n in names[:MOST]]
    return rows + ([(f"and {len(names) - MOST} more", "port")] if len(names) > MOST else [])


def _width(row: tuple[str, str]) -> float:
    return LETTER * (len(row[0]) + (0 if row[1] in ("", "1", "port") else len(row[1]) + 1))


def _side(rows: Iterable[tuple[str, str]], x: float, anchor: str, arrow: tuple[float, float]) -> list[str]:
    parts = []
    for k, (text, unit) in enumerate(rows):
        y = TOP + LINE * k + 8
        if unit == "port":
            parts.append(f'<text class="port" x="{x:.0f}" y="{y}" text-anchor="{anchor}">{escape(text)}</text>')
            continue
        measure = "" if unit in ("", "1") else f'<tspan class="unit"> {escape(unit)}</tspan>'
        parts.append(f'<text x="{x:.0f}" y="{y}" text-anchor="{anchor}">{escape(text)}{measure}</text>')
        parts.append(f'<line x1="{arrow[0]:.0f}" x2="{arrow[1]:.0f}" y1="{y - 4}" y2="{y - 4}" marker-end="url(#tip)"/>')
    return parts
