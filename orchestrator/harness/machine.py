"""Drawings of machines: masses, springs, dampers, wheels, beams and forces as SVG in the colours of the page around them.

A system's module `machines` has a drawing for each of its components: `MACHINES`, name -> function without arguments. Of those in a
scene the first in that list stands for the scene; where the module has a function `scene(units)`, its drawing does. The labels are
the symbols of the component's equations. Coordinates are px, y downwards.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from html import escape

Point = tuple[float, float]

SIZE = 14  # px, letters: a drawing at most 360 px wide is shown as it is on a telephone
GAP = 15.0  # px between a part and its label
WORD = re.compile(r"([A-Za-zα-ωΑ-Ω]+)|_\{([^}]*)\}|_(\w)|([^A-Za-zα-ωΑ-Ω_]+)")


class Machine:
    """A drawing that is made part by part; each method adds one and returns the drawing.

    title: what it shows, in a few words.  text: the same for those who do not see it.  width, height: px.
    """

    def __init__(self, title: str, text: str, width: float = 340.0, height: float = 230.0) -> None:
        self.title, self.text, self.width, self.height = title, text, width, height
        self.parts: list[str] = []

    def svg(self, name: str) -> str:
        """The SVG element. name: unique within its page."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" class="machine" role="img" aria-labelledby="{name}-title {name}-text" '
            f'width="{self.width:g}" height="{self.height:g}" viewBox="0 0 {self.width:g} {self.height:g}" fill="none" '
            f'stroke="currentColor" stroke-width="1.6" stroke-linejoin="round" font-size="{SIZE}" font-family="sans-serif">'
        )
        return (
            f'{head}<title id="{name}-title">{escape(self.title)}</title><desc id="{name}-text">{escape(self.text)}</desc>'
            f"{''.join(self.parts)}</svg>"
        )

    def _add(self, part: str) -> Machine:
        self.parts.append(part)
        return self

    # -- lines and letters ----------------------------------------------------------------------------------------------------
    def line(self, *points: Point, width: float = 1.6, dash: str = "", closed: bool = False) -> Machine:
        """A line through points."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        return self._add(f'<path d="{_path(points)}{"z" if closed else ""}" stroke-width="{width:g}"{dashed}/>')

    def beam(self, *points: Point) -> Machine:
        """A thick line: a rod, a shaft, a link."""
        return self._add(f'<path d="{_path(points)}" stroke-width="5" stroke-linecap="round"/>')

    def curve(self, path: str, width: float = 1.6, dash: str = "") -> Machine:
        """A line given as an SVG path."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        return self._add(f'<path d="{path}" stroke-width="{width:g}"{dashed}/>')

    def label(self, x: float, y: float, symbol: str, anchor: str = "middle") -> Machine:
        """A symbol as in "z_1" or "F_{tip}": letters in italics, indices small and low; y is the middle of the letters."""
        parts, low = [], False
        for letters, long, short, rest in WORD.findall(symbol):
            index = long or short
            shift = ' dy="4"' if index and not low else ' dy="-4"' if low and not index else ""
            style = ' font-size="10"' if index else ' font-style="italic"' if letters else ""
            parts.append(f"<tspan{shift}{style}>{escape(index or letters or rest)}</tspan>")
            low = bool(index)
        return self._text(x, y, "".join(parts), anchor)

    def word(self, x: float, y: float, text: str, anchor: str = "middle") -> Machine:
        """A plain word."""
        return self._text(x, y, escape(text), anchor, 12)

    def _text(self, x: float, y: float, inner: str, anchor: str, size: int = SIZE) -> Machine:
        return self._add(
            f'<text x="{x:.1f}" y="{y + 0.35 * size:.1f}" text-anchor="{anchor}" font-size="{size}" fill="currentColor" '
            f'stroke="none" xml:space="preserve">{inner}</text>'
        )

    # -- parts of machines ----------------------------------------------------------------------------------------------------
    def mass(self, x: float, y: float, width: float, height: float, symbol: str = "") -> Machine:
        """A body about its middle."""
        box = f'x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:g}" height="{height:g}"'
        self._add(f'<rect class="body" {box} rx="3" fill="currentColor" fill-opacity="0.12"/>')
        return self.label(x, y, symbol) if symbol else self

    def block(self, x: float, y: float, width: float, height: float, *words: str) -> Machine:
        """A block of a signal flow, words below each other."""
        self._add(f'<rect x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:g}" height="{height:g}" rx="3"/>')
        for k, word in enumerate(words):
            self.label(x, y + 17 * (k - (len(words) - 1) / 2), word)
        return self

    def wheel(self, x: float, y: float, radius: float, symbol: str = "", hub: bool = True) -> Machine:
        """A disk seen along its axis."""
        self._add(f'<circle class="body" cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="currentColor" fill-opacity="0.12"/>')
        if hub:
            self.node(x, y)
        return self.label(x, y + radius * 0.5, symbol) if symbol else self

    def ring(self, x: float, y: float, radius: float, width: float = 1.6, dash: str = "") -> Machine:
        """A circle."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        return self._add(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" stroke-width="{width:g}"{dashed}/>')

    def node(self, x: float, y: float, symbol: str = "", side: Point = (GAP, -GAP)) -> Machine:
        """A pin, a joint or a point, with its symbol at `side`."""
        self._add(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="currentColor"/>')
        return self.label(x + side[0], y + side[1], symbol) if symbol else self

    def spring(self, a: Point, b: Point, symbol: str = "", side: float = 1.0, turns: int = 5, width: float = 7.0) -> Machine:
        """A spring from a to b; its symbol on the right of that way, on the left with side = -1."""
        along, across, length = _axes(a, b)
        lead = 0.18 * length
        points = [a, _at(a, along, lead)]
        for k in range(2 * turns):
            place = lead + (length - 2 * lead) * (k + 0.5) / (2 * turns)
            points.append(_at(_at(a, along, place), across, width if k % 2 else -width))
        return self.line(*points, _at(b, along, -lead), b)._beside(a, b, symbol, side, width)

    def damper(self, a: Point, b: Point, symbol: str = "", side: float = 1.0, width: float = 8.0) -> Machine:
        """A dashpot from a to b: the cup at a."""
        along, across, length = _axes(a, b)
        floor, rim, piston = 0.36 * length, 0.66 * length, 0.52 * length
        foot, edge, head = (_at(a, along, d) for d in (floor, rim, piston))
        self.line(a, foot).line(head, b)
        self.line(_at(edge, across, -width), _at(foot, across, -width), _at(foot, across, width), _at(edge, across, width))
        self.line(_at(head, across, 0.7 - width), _at(head, across, width - 0.7), width=3.0)
        return self._beside(a, b, symbol, side, width)

    def _beside(self, a: Point, b: Point, symbol: str, side: float, width: float) -> Machine:
        if not symbol:
            return self
        _, across, _ = _axes(a, b)
        reach = width + 4.0 + 0.5 * SIZE * (abs(across[1]) + 0.5 * len(re.sub(r"[_{}]", "", symbol)) * abs(across[0]))
        x, y = _at(((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), across, side * reach)
        return self.label(x, y, symbol)

    def ground(self, a: Point, b: Point) -> Machine:
        """What stands still: a line with hatching on the left of the way from a to b, as seen on the screen."""
        along, across, length = _axes(a, b)
        self.line(a, b, width=2.4)
        count = max(2, round(length / 9))
        marks = [_at(a, along, length * (k + 0.7) / count) for k in range(count)]
        return self._add(
            f'<path d="{"".join(_path((m, _at(_at(m, across, -8.0), along, -6.0))) for m in marks)}" stroke-width="1.1"/>'
        )

    def arrow(self, a: Point, b: Point, symbol: str = "", at: Point | None = None, load: bool = True) -> Machine:
        """A force or a motion from a to b with its symbol beyond the tip, or at a place; load: drawn thick."""
        along, _, _ = _axes(a, b)
        size = 9.0 if load else 7.0
        self._add(f'<g class="{"load" if load else "motion"}">{_arrow(a, b, 2.6 if load else 1.3, size)}</g>')
        x, y = at or _at(b, along, GAP)
        return self.label(x, y, symbol) if symbol else self

    def turn(
        self,
        x: float,
        y: float,
        radius: float,
        begin: float,
        end: float,
        symbol: str = "",
        at: Point | None = None,
        load: bool = False,
    ) -> Machine:
        """An arrow about (x, y) from one angle to another, degrees, counted from the right towards up."""
        a, b = ((x + radius * math.cos(math.radians(v)), y - radius * math.sin(math.radians(v))) for v in (begin, end))
        sweep, large = int(end < begin), int(abs(end - begin) > 180)
        size = 9.0 if load else 7.0
        turned = math.radians(end) + math.copysign(math.pi / 2 - size / radius / 2, end - begin)
        back = (b[0] - math.cos(turned), b[1] + math.sin(turned))
        path = f'<path d="M{a[0]:.1f} {a[1]:.1f}A{radius:g} {radius:g} 0 {large} {sweep} {b[0]:.1f} {b[1]:.1f}"'
        self._add(
            f'<g class="{"load" if load else "motion"}">{path} stroke-width="{2.6 if load else 1.3}"/>{_tip(back, b, size)}</g>'
        )
        middle = math.radians((begin + end) / 2)
        place = at or (x + (radius + GAP) * math.cos(middle), y - (radius + GAP) * math.sin(middle))
        return self.label(*place, symbol) if symbol else self

    def measure(self, a: Point, b: Point, symbol: str, side: float = 1.0) -> Machine:
        """A length between two points, an arrow at either end."""
        _, across, _ = _axes(a, b)
        middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
        self._add(f'<path d="{_path((a, b))}" stroke-width="1"/>{_tip(a, b, 6.0)}{_tip(b, a, 6.0)}')
        reach = 7.0 + 4.0 * len(re.sub(r"[_{}]", "", symbol)) * abs(across[0]) + 5.0 * abs(across[1])
        return self.label(*_at(middle, across, side * reach), symbol) if symbol else self


def motor(machine: Machine, x: float, y: float) -> Machine:
    """A DC motor's circuit, its machine with the shaft beginning at (x, y)."""
    left, top, bottom = x - 195, y - 50, y + 50
    machine.line((left, y - 12), (left, top), (left + 50, top)).line(
        (left, y + 12), (left, bottom), (x - 22, bottom), (x - 22, y + 22)
    )
    machine.ring(left, y, 12).label(left - 22, y, "V").label(left, y - 4, "+").label(left, y + 5, "−")
    machine.mass(left + 70, top, 40, 14).label(left + 70, top - 18, "R").line((left + 90, top), (left + 115, top))
    loops = "".join("a7 7 0 0 1 14 0" for _ in range(3))
    machine.curve(f"M{left + 115:g} {top:g}{loops}").label(left + 136, top - 18, "L")
    machine.line((left + 157, top), (x - 22, top), (x - 22, y - 22)).arrow((left + 14, top), (left + 38, top), load=False)
    machine.label(left + 26, top - 14, "i")
    return machine.wheel(x - 22, y, 22, hub=False).word(x - 22, y, "M").label(x - 52, y, "k")


def _axes(a: Point, b: Point) -> tuple[Point, Point, float]:
    """Unit vectors along and across (to the right of the way, as seen on the screen), and the length."""
    x, y = b[0] - a[0], b[1] - a[1]
    length = math.hypot(x, y)
    return (x / length, y / length), (-y / length, x / length), length


def _at(point: Point, direction: Point, distance: float) -> Point:
    return point[0] + direction[0] * distance, point[1] + direction[1] * distance


def _path(points: Sequence[Point]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _arrow(a: Point, b: Point, width: float, size: float) -> str:
    along, _, _ = _axes(a, b)
    return f'<path d="{_path((a, _at(b, along, -size / 2)))}" stroke-width="{width:g}"/>{_tip(a, b, size)}'


def _tip(a: Point, b: Point, size: float) -> str:
    """The head of an arrow that comes from a, at b."""
    along, across, _ = _axes(a, b)
    base = _at(b, along, -size)
    corners = (b, _at(base, across, size * 0.42), _at(base, across, -size * 0.42))
    return f'<path d="{_path(corners)}z" fill="currentColor" stroke="none"/>'
