"""A line's table read from a file, its form as tables for the crew, and its drawing as text and SVG."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.columns import decoded
from ....components.core.errors import BadInput
from ....components.core.files import read_bytes
from ....components.railway.catenary import Catenary
from ....components.railway.line.dropper_table import OF_SECOND, column_names, with_droppers
from ....components.railway.line.form import Form, find_form
from ....components.railway.line.later import line_at
from ....components.railway.line.layout import GRAVITY
from ....components.railway.line.table import read_line
from ...output import ensure_directory
from ...scene.file_kinds import refuse_other
from ...scene.files import read_text

DROPPERS = column_names()
DROPPER_COLUMNS = tuple(name for key, name in DROPPERS.items() if key != "axial_stiffness")
CREW = DROPPER_COLUMNS[:7]  # what the terminal shows
SUPPORT_COLUMNS = ("position [m]", "reaction [N]", "rest height of the spring [m]")
WIDTH, HEIGHT = 110, 14  # characters of the drawing
PER_METRE, TALL, BESIDE = 8.0, 80.0, 120.0  # pixels a metre along, pixels a metre up, pixels a metre to the side
MOST_NAMED = 5  # droppers in a message
MARGIN = 40.0  # pixels at the left and at the right


def read(
    path: Path,
    values: Mapping[str, Any],
    droppers: Path | None = None,
    temperature: float | None = None,
    wear: float | None = None,
) -> tuple[Form, str]:
    """Form and title of the line in a file.

    values: parameters of `Catenary` for what it leaves out; droppers: a CSV file of them, in the place of those of the table;
    temperature: K above that of the table, as of the effect `temperature`; wear: share gone since, as of the effect `wear`.
    """
    refuse_other(path, "line")
    text = read_text(path, "line")
    line = read_line(text, str(path))
    tables = {"line_table.table": text}
    if droppers is not None:
        tables["line_table.droppers"] = decoded(read_bytes(droppers, "droppers"), str(droppers))
        line = with_droppers(line, tables["line_table.droppers"], str(droppers))
    later = {k: v for k, v in (("temperature.change", temperature), ("wear.share", wear)) if v is not None}
    effects = [name.partition(".")[0] for name in later]
    catenary = Catenary(["line_table", *effects], {**values, **tables, **later})
    catenary.refuse_unused(values)
    if doubts := catenary.doubts(values):
        raise BadInput("--set", doubts[0], "numbers that are usual, or with their units")
    p, title = catenary._declared_arguments()[0], line.title or path.stem
    form = line_at(line, p, temperature or 0.0, wear or 0.0)[1] if later else find_form(line, p)
    refuse_pushing(form, str(droppers or path))
    title += "" if temperature is None else f", {temperature:+g} K"
    return form, title if wear is None else f"{title}, {100.0 * wear:g} % worn since"


def refuse_pushing(form: Form, where: str) -> None:
    """Raises `BadInput` where droppers would push at rest: they cannot, so the wire hangs in another form."""
    slack = np.flatnonzero(form.preload <= 0.0)
    if slack.size:
        shown = ", ".join(
            f"{form.preload[k]:.4g} N at {form.layout.droppers.position[k]:.6g} m{_which(form, k)}" for k in slack[:MOST_NAMED]
        )
        more = f" and {slack.size - MOST_NAMED} more" if slack.size > MOST_NAMED else ""
        raise BadInput(
            where,
            f"{slack.size} of {form.preload.size} droppers with thrust at rest: {shown}{more}",
            "tension in every dropper",
            "Raise the wire there or lower it at the droppers beside, reduce the pre-sag, or move or remove these droppers.",
        )


def _which(form: Form, k: int) -> str:
    """Of a dropper the wire that it carries, where a line has several: contact wires as `dropper_rows` counts them, or `auxiliary`."""
    lower = form.layout.droppers.lower
    contact = f"contact wire {lower[k] // 2 + 1}" if lower[k] in form.layout.contact_lanes else "auxiliary"
    return f" ({contact})" if np.ptp(lower) else ""


def _wire(form: Form, lane: int) -> str:
    """What a wire is called."""
    if lane in form.layout.contact_lanes:
        return "contact wire"
    if lane in form.layout.auxiliary_lanes:
        return "auxiliary"
    stitch = any(w.lane == lane and w.clamped_to is not None for w in form.layout.wires)
    return "stitch" if stitch else "messenger"


DRAWN = {"contact wire": "=", "messenger": "-", "stitch": "~", "auxiliary": "~"}
COLOURS = {"messenger": "currentColor", "stitch": "#E69F00", "auxiliary": "#009E73"}


def dropper_rows(form: Form) -> list[tuple[Any, ...]]:
    """A row a dropper, columns `DROPPER_COLUMNS`; heights as in the line's table. One of an auxiliary wire has no contact wire."""
    d, half = form.layout.droppers, 0.5 * form.layout.droppers.mass
    numbers = (form.length, form.cut_length, form.preload, d.stiffness, d.mass, d.mass_below - half, d.mass_above - half)
    first = form.layout.auxiliary_lanes[:1]

    def carried(lower: int, upper: int) -> tuple[int | str, str]:
        if lower in form.layout.contact_lanes:
            return lower // 2 + 1, _wire(form, upper)
        return "", _wire(form, upper) if lower in first else OF_SECOND + _wire(form, upper)

    return [
        (x, *carried(lower, upper), z, *rest)
        for x, lower, upper, z, *rest in zip(
            d.position, d.lower, d.upper, d.height + form.layout.reference, *numbers, strict=True
        )
    ]


def support_rows(form: Form) -> list[tuple[float, ...]]:
    """Messenger supports, columns `SUPPORT_COLUMNS`; heights as in the line's table."""
    return list(zip(form.support, form.reaction, form.rest_height + form.layout.reference, strict=True))


def shown(rows: list[tuple[Any, ...]], columns: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The first columns of a table in the digits of a crew: mm, 0.1 mm of heights and lengths, 0.1 N."""
    digits = {"position [m]": ".3f", "preload [N]": ".1f", "reaction [N]": ".1f"}
    return [
        tuple(f"{v:{digits.get(c, '.4f')}}" if isinstance(v, float) else str(v) for c, v in zip(columns, row, strict=False))
        for row in rows
    ]


def save(form: Form, title: str, folder: Path) -> list[Path]:
    """droppers.csv, supports.csv and line.svg."""
    ensure_directory(folder)
    paths = [folder / "droppers.csv", folder / "supports.csv", folder / "line.svg"]
    for path, columns, rows in ((paths[0], DROPPER_COLUMNS, dropper_rows(form)), (paths[1], SUPPORT_COLUMNS, support_rows(form))):
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([f"{v:.15g}" if isinstance(v, float) else v for v in row] for row in rows)
    paths[2].write_text(svg(form, title), encoding="utf-8")
    return paths


def _shape(form: Form, wire: Any, points: int = 6) -> Iterator[tuple[float, float]]:
    """Positions and heights along a wire, with the parabola between its nodes."""
    inside = np.flatnonzero((form.position > wire.start - 1e-6) & (form.position < wire.end + 1e-6))
    for i, j in pairwise(inside):
        a, b = form.position[i], form.position[j]
        za, zb = form.height[i, wire.lane], form.height[j, wire.lane]
        for s in np.linspace(0.0, 1.0, points)[: points - 1 if j != inside[-1] else points]:
            sag = GRAVITY * wire.mass * (b - a) ** 2 / (2.0 * wire.tension) * s * (1.0 - s)
            yield float(a + s * (b - a)), float((1.0 - s) * za + s * zb - sag)


def text_drawing(form: Form, width: int = WIDTH) -> str:
    """The line to scale along the track, heights enlarged, as lines of text."""
    shapes = [list(_shape(form, wire)) for wire in form.layout.wires]
    every = np.array([p for shape in shapes for p in shape])
    (left, low), (right, high) = every.min(axis=0), every.max(axis=0)
    rows = [[" "] * width for _ in range(HEIGHT)]

    def place(x: float, z: float) -> tuple[int, int]:
        return (round((high - z) / max(high - low, 1e-9) * (HEIGHT - 1)), round((x - left) / (right - left) * (width - 1)))

    d = form.layout.droppers
    for x, lower, z, length in zip(d.position, d.lower, d.height, form.length, strict=True):
        (bottom, column), (top, _) = place(x, z), place(x, z + length)
        for row in range(top + 1, bottom):
            rows[row][column] = "|" if lower == 0 else ":"
    for shape, wire in zip(shapes, form.layout.wires, strict=True):
        line = np.array(shape)
        for column in range(width):
            x = left + (right - left) * column / (width - 1)
            if line[0, 0] <= x <= line[-1, 0]:
                row, _ = place(x, float(np.interp(x, line[:, 0], line[:, 1])))
                rows[row][column] = DRAWN[_wire(form, wire.lane)]
    marks = [" "] * width
    for x in form.layout.supports:
        marks[place(x, low)[1]] = "^"
    scale = (right - left) / (high - low) * HEIGHT / width * 2.0  # a character is twice as high as wide
    ends = f"{left:g} m" + f"{right:g} m".rjust(width - len(f"{left:g} m"))
    between = " or ".join(sorted({_wire(form, w.lane) for w in form.layout.wires} & {"auxiliary", "stitch"})) or "stitch"
    legend = f"= contact wire  - messenger  ~ {between}  | dropper  ^ support; heights {scale:.0f} times as large as lengths"
    return "\n".join(["".join(row).rstrip() for row in rows] + ["".join(marks).rstrip(), ends, legend])


def svg(form: Form, title: str, part: tuple[float, float] | None = None, width: float | None = None) -> str:
    """Side view and, where there is stagger, plan: lengths to scale, heights and sides enlarged by a stated factor.

    part: the positions that are drawn, m; default all. width: px; default `PER_METRE` for each metre.
    """
    shapes = [list(_shape(form, wire)) for wire in form.layout.wires]
    every = np.array([p for shape in shapes for p in shape])
    left, right = part or (float(every[:, 0].min()), float(every[:, 0].max()))
    shapes = [_clipped(shape, left, right) for shape in shapes]
    heights = np.array([z for shape in shapes for _, z in shape])
    low, high = float(heights.min()), float(heights.max())
    lateral = form.layout.lateral
    staggered = bool(lateral.size and np.any(lateral[:, 2]))
    width = (right - left) * PER_METRE + 2.0 * MARGIN if width is None else width
    per_metre = (width - 2.0 * MARGIN) / (right - left)
    side = (high - low) * TALL + 110.0
    total = side + (180.0 if staggered else 0.0)

    def along(x: float) -> float:
        return MARGIN + (x - left) * per_metre

    def path(points: list[tuple[float, float]], **style: str) -> str:
        styled = " ".join(f'{k.replace("_", "-")}="{v}"' for k, v in style.items())
        at = " ".join(f"{along(x):.1f},{60.0 + (high - z) * TALL:.1f}" for x, z in points)
        return f'<polyline points="{at}" fill="none" {styled}/>'

    def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(words)}</text>'

    parts = [
        text(MARGIN, 24.0, title, "start"),
        text(MARGIN, 42.0, f"at rest; heights {TALL / per_metre:.3g} times as large as lengths", "start"),
    ]
    for i, x in enumerate(form.layout.supports):
        if left <= x <= right:
            parts.append(
                path([(x, low - 0.2), (x, high + 0.1)], stroke="currentColor", stroke_opacity="0.5", stroke_dasharray="4 4")
            )
            parts.append(text(along(x), side - 12.0, f"S{i} {x:g} m"))
    d = form.layout.droppers
    for x, z, length in zip(d.position, d.height, form.length, strict=True):
        if left <= x <= right:
            parts.append(path([(x, z), (x, z + length)], stroke="currentColor", stroke_width="1"))
    for shape, wire in zip(shapes, form.layout.wires, strict=True):
        contact = wire.lane in form.layout.contact_lanes
        colour = ("#0072B2" if wire.lane == 0 else "#CC3311") if contact else COLOURS[_wire(form, wire.lane)]
        if shape:
            parts.append(path(shape, stroke=colour, stroke_width="2.5" if contact else "1.5"))
    if staggered:
        middle = side + 80.0
        scale = f"plan, sides {BESIDE / per_metre:.3g} times as large as lengths, and forces on the arms"
        parts.append(text(MARGIN, side + 16.0, scale, "start"))
        parts.append(
            f'<line x1="{MARGIN:g}" x2="{width - MARGIN:.1f}" y1="{middle}" y2="{middle}" stroke="currentColor" '
            'stroke-opacity="0.5" stroke-dasharray="8 4"/>'
        )
        for wire in np.unique(lateral[:, 0]):
            mine = lateral[:, 0] == wire
            rows = list(zip(*lateral[mine, 1:3].T, form.layout.lateral_force[mine], strict=True))
            at = [(along(x), middle - b * BESIDE) for x, b in _clipped([(x, b) for x, b, _ in rows], left, right)]
            points = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
            colour = "#0072B2" if wire == 0 else "#CC3311"
            parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>')
            parts += [
                text(along(x), middle - b * BESIDE + (16.0 if b < 0.0 else -8.0), f"{force:+.0f} N")
                for x, b, force in rows
                if force and left <= x <= right
            ]
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{total:.0f}" '
        f'viewBox="0 0 {width:.0f} {total:.0f}" font-family="sans-serif" font-size="12" fill="currentColor" role="img">\n'
        f"<title>{escape(title)}</title>\n{body}\n</svg>\n"
    )


def _clipped(points: list[tuple[float, float]], left: float, right: float) -> list[tuple[float, float]]:
    """The part of a line between two positions, with its ends there; empty where there is none."""
    x, z = np.array(points).T
    a, b = max(left, float(x[0])), min(right, float(x[-1]))
    if a >= b:
        return []
    inside = (x > a) & (x < b)
    return [
        (a, float(np.interp(a, x, z))),
        *zip(x[inside].tolist(), z[inside].tolist(), strict=True),
        (b, float(np.interp(b, x, z))),
    ]
