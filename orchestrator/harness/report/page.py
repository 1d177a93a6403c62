"""A page of sections and blocks, and its rendering to one self-contained HTML file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from ....components.core.store import replaced
from ...output import PLOTLY, SAMPLES_ENDING
from ..charts.blocks import Block, Figure
from ..charts.style import DARK
from .embed import embedded, lost_samples


@dataclass(frozen=True)
class Section:
    """A heading with blocks; level 2 is a chapter, 3 a part of it. badge: a word beside the heading, such as an outcome."""

    title: str
    blocks: Sequence[Block]
    level: int = 2
    badge: str = ""


@dataclass(frozen=True)
class Page:
    """The whole page. lead: what a hurried reader should know."""

    title: str
    lead: str
    sections: Sequence[Section]
    footer: Sequence[str] = field(default=())


def _as_json(value: Any) -> str:
    """JSON that can stand inside a script element: no "<" that could end it, no NaN."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(__package__, "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["json"] = _as_json
    return environment


def _asset(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def write_page(page: Page, path: Path) -> Path:
    """Render to `path`; beside it go Plotly, once for all pages of a directory, and samples of lines that have no room in it.

    Nothing is asked of any network.
    """
    figures = [b for s in page.sections for b in s.blocks if isinstance(b, Figure)]
    specs, points = embedded([f.figure for f in figures])
    samples = lost_samples([f.figure for f in figures], points)
    beside = path.with_name(path.stem + SAMPLES_ENDING)
    html = (
        _environment()
        .get_template("page.html")
        .render(
            page=page,
            figure_number={id(f): i for i, f in enumerate(figures, 1)},
            specs=specs,
            points=points,
            samples=beside.name if samples.content else "",
            sample_points=samples.points,
            id=id,
            css=_asset("page.css"),
            dark=DARK,
            script=_asset("page.js"),
            plotly=PLOTLY if figures else "",
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    beside.unlink(missing_ok=True)
    if samples.content:
        with replaced(beside) as file:
            file.write(f"window.samples = {_as_json(samples.content)};\n")
    if figures:
        _put_plotly(path.with_name(PLOTLY))
    with replaced(path) as file:
        file.write(html)
    return path


def _put_plotly(path: Path) -> None:
    """The library beside a page, unless it is there: written anew only where another version is."""
    script = get_plotlyjs()
    if not path.is_file() or path.stat().st_size != len(script.encode("utf-8")):
        with replaced(path) as file:
            file.write(script)
