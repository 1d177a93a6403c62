"""Units and connections as a drawing: SVG without script, whose colours are those of the page around it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import NamedTuple

from ...components.core.errors import visible_in_page

WIDTH, HEIGHT = 180, 64  # px, of a box
GAP_X, GAP_Y, MARGIN = 230, 22, 16
ROW = 24  # px between lines that meet one side of a box
LOOP = 26  # px below the boxes, for lines from a box to itself
SIDE, PORTS = 240, 14  # px for the names at a component, and how many of them
LETTERS = 26  # of a line in a box, and of the name at an arrow: of its first signal; all of them at the pointer


@dataclass(frozen=True)
class Box:
    """A unit. name: unique.  lines: small text below it.  hint: what the pointer shows."""

    name: str
    lines: tuple[str, ...] = ()
    hint: str = ""


class Arrow(NamedTuple):
    """Signals from one box to another. port: what all of them are at one end, "" where they are not one port."""

    source: str
    target: str
    signals: tuple[str, ...]
    port: str = ""


class Drawing(str):
    """The text of an SVG file; notebooks show it as a picture."""

    def _repr_svg_(self) -> str:
        return str(self)

    def save(self, path: str | Path) -> Path:
        """Write it to a file; returns its path."""
        Path(path).write_text(self, encoding="utf-8")
        return Path(path)


def draw(boxes: Sequence[Box], arrows: Iterable[Arrow], title: str = "") -> Drawing:
    """Boxes in columns, so that arrows go to the right where that is possible; one line between two boxes, both ways."""
    arrows = list(arrows)
    columns = _columns([box.name for box in boxes], arrows)
    pairs = list(dict.fromkeys((a, b) if columns[a] <= columns[b] else (b, a) for a, b, *_ in arrows))
    tall = {box.name: _height(box.name, pairs) for box in boxes}
    members = _members(columns)
    sizes = {column: sum(tall[n] + GAP_Y for n in names) - GAP_Y for column, names in members.items()}
    deepest = max(sizes.values(), default=0.0)
    place = {}
    for column, names in members.items():
        y = MARGIN + (deepest - sizes[column]) / 2.0
        for name in names:
            place[name] = (MARGIN + column * (WIDTH + GAP_X), y)
            y += tall[name] + GAP_Y
    width = 2 * MARGIN + len(members) * (WIDTH + GAP_X) - GAP_X
    height = 2 * MARGIN + deepest + LOOP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="11" fill="currentColor" role="img">',
        f"<title>{escape(title)}</title>" if title else "",
    ]
    parts += _lines(arrows, pairs, place, tall)
    parts += [_box(box, *place[box.name], tall[box.name]) for box in boxes]
    return Drawing(visible_in_page("".join(parts)) + "</svg>")


def _height(name: str, pairs: Sequence[tuple[str, str]]) -> float:
    """Of a box: room for the names at the lines on each of its sides."""
    return max(HEIGHT, *(ROW * (1 + sum(pair[side] == name for pair in pairs)) for side in (0, 1)))


def _box(box: Box, x: float, y: float, tall: float) -> str:
    """Of its own colours, light in a dark page, too: lines run behind it."""
    lines = "".join(
        f'<text x="{x + 10:.0f}" y="{y + 36 + 15 * k:.0f}" fill="#5c6b7a">{escape(_short(line))}</text>'
        for k, line in enumerate(box.lines[:2])
    )
    return (
        f'<g><title>{escape(box.hint or box.name)}</title><rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{tall:.0f}" '
        f'rx="5" fill="#eef4fa" stroke="#5c6b7a"/><text x="{x + 10:.0f}" y="{y + 19:.0f}" font-size="13" font-weight="bold" '
        f'fill="#1c2733">{escape(_short(box.name))}</text>{lines}</g>'
    )


def _lines(
    arrows: Sequence[Arrow], pairs: Sequence[tuple[str, str]], place: Mapping[str, tuple[float, float]], tall: Mapping[str, float]
) -> Iterator[str]:
    """A curve for each pair of boxes between which something goes, with its ends spread over their sides."""
    signals = {(a.source, a.target): a.signals for a in arrows}
    ports = {(a.source, a.target): a.port for a in arrows}
    right, left = _ends(pairs, 0, place, tall), _ends(pairs, 1, place, tall)
    for a, b in pairs:
        there, back = signals.get((a, b), ()), signals.get((b, a), ()) if a != b else ()
        hint = "\n".join((*_listed(a, b, there), *_listed(b, a, back)))
        (x, y), (to_x, to_y) = place[a], place[b]
        if a == b:
            x, y = x + WIDTH * 0.7, y + tall[a]
            path = f"M{x:.0f} {y:.0f}c0 {LOOP} -{WIDTH * 0.4:.0f} {LOOP} -{WIDTH * 0.4:.0f} 0"
            labels = _label(there, ports.get((a, b), ""), x, y + 18, "start")
            tips = f"M{x - WIDTH * 0.4:.0f} {y:.0f}l-4 8h8z"
        else:
            x, y, to_y = x + WIDTH, y + right[a, b], to_y + left[a, b]
            middle = 0.5 * (x + to_x)
            path = f"M{x:.0f} {y:.0f}C{middle:.0f} {y:.0f} {middle:.0f} {to_y:.0f} {to_x:.0f} {to_y:.0f}"
            labels = _label(there, ports.get((a, b), ""), to_x - 12, to_y - 4, "end") + _label(
                back, ports.get((b, a), ""), x + 12, y + 12, "start"
            )
            tips = (f"M{to_x:.0f} {to_y:.0f}l-8 -4v8z" if there else "") + (f"M{x:.0f} {y:.0f}l8 -4v8z" if back else "")
        yield (
            f'<g><title>{escape(hint)}</title><path d="{path}" fill="none" stroke="currentColor"/><path d="{tips}"/>{labels}</g>'
        )


def _ends(
    pairs: Sequence[tuple[str, str]], side: int, place: Mapping[str, tuple[float, float]], tall: Mapping[str, float]
) -> dict[tuple[str, str], float]:
    """Where lines meet a side of a box, px from its top; in the order of their other ends."""
    at: dict[tuple[str, str], float] = {}
    for name in {pair[side] for pair in pairs}:
        own = sorted((p for p in pairs if p[side] == name), key=lambda pair: place[pair[1 - side]][1])
        at |= {pair: tall[name] * (k + 1) / (len(own) + 1) for k, pair in enumerate(own)}
    return at


def _listed(source: str, target: str, signals: tuple[str, ...]) -> tuple[str, ...]:
    return (f"{source} to {target}:", *signals) if signals else ()


def _label(signals: tuple[str, ...], port: str, x: float, y: float, anchor: str) -> str:
    if not signals:
        return ""
    first = signals[0].partition(" to ")[0]
    if len(signals) > 1:
        first = f"{_short(port, LETTERS - 5)} ({len(signals)})" if port else f"{_short(first, LETTERS - 5)} +{len(signals) - 1}"
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" font-size="10">{escape(_short(first))}</text>'


def _short(text: str, most: int = LETTERS) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"


def _columns(names: Sequence[str], arrows: Iterable[Arrow]) -> dict[str, int]:
    """Box -> column: each right of all that lead to it, but for arrows that close a circle, seen from the first boxes on."""
    leads: dict[str, list[str]] = {name: [] for name in names}
    for arrow in arrows:
        if arrow.target != arrow.source:
            leads[arrow.source].append(arrow.target)
    driven = {target for targets in leads.values() for target in targets}
    state: dict[str, int] = {}  # 1: on the way to the present box, 2: done
    order: list[str] = []
    ahead: dict[str, list[str]] = {name: [] for name in names}
    for root in sorted(names, key=lambda name: name in driven):
        pending = [(root, iter(leads[root]))] if root not in state else []
        state.setdefault(root, 1)
        while pending:
            name, targets = pending[-1]
            target = next(targets, None)
            if target is None:
                state[name] = 2
                order.append(name)
                pending.pop()
            elif state.get(target) != 1:
                ahead[name].append(target)
                if target not in state:
                    state[target] = 1
                    pending.append((target, iter(leads[target])))
    columns = dict.fromkeys(names, 0)
    for name in reversed(order):
        for target in ahead[name]:
            columns[target] = max(columns[target], columns[name] + 1)
    return columns


def _members(columns: Mapping[str, int]) -> dict[int, list[str]]:
    members: dict[int, list[str]] = {}
    for name, column in columns.items():
        members.setdefault(column, []).append(name)
    return members


def sketch(title: str, name: str, inputs: Sequence[str], outputs: Sequence[str]) -> Drawing:
    """A component as a box with its inputs at the left and its outputs at the right; long lists are cut, with a number."""
    sides = [[*names[:PORTS], *([f"{len(names) - PORTS} more"] if len(names) > PORTS else [])] for names in (inputs, outputs)]
    tall = max(HEIGHT, 18 * (1 + max(map(len, sides))))
    width, left = 2 * SIDE + WIDTH, SIDE
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {tall + 2 * MARGIN}" width="{width}" '
        f'height="{tall + 2 * MARGIN}" font-family="sans-serif" font-size="11" fill="currentColor" role="img">'
        f"<title>{escape(title)}</title>",
        _box(Box(name, (title,), title), left, MARGIN, tall),
    ]
    for side, names in enumerate(sides):
        for k, signal in enumerate(names):
            x, y = (left - 40, left + WIDTH)[side], MARGIN + tall * (k + 1) / (len(names) + 1)
            at, anchor = ((x - 4, "end"), (x + 44, "start"))[side]
            parts.append(
                f'<path d="M{x} {y:.0f}h40" stroke="currentColor"/><path d="M{x + 40} {y:.0f}l-8 -4v8z"/>'
                f'<text x="{at}" y="{y + 4:.0f}" text-anchor="{anchor}">{escape(_short(signal, 34))}</text>'
            )
    return Drawing(visible_in_page("".join(parts)) + "</svg>")
