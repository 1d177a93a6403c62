"""A page of sections and blocks, and its rendering to one self-contained HTML file."""

from __future__ import annotations

import gzip
import json
import re
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs, get_plotlyjs_version

from ....components.core.errors import visible_in_page
from ....components.core.store import replaced
from ...delivery import DELIVERY, print_pdf
from ...output import PLOTLY, SAMPLES_ENDING
from ..charts.blocks import Block, Figure
from ..charts.motion import motion_data, still_motion
from ..charts.still import still
from ..charts.style import DARK
from .embed import SAMPLES_BESIDE, SAMPLES_INSIDE, embedded, lost_samples

# what limits say of a figure: class of its badge, and the badge's text
BADGES = {"in": "passed", "out": "failed", "undecided": "undecided", "unconfirmed": "unconfirmed"}
LIMITS_WORDS = {"in": "within", "out": "outside", "undecided": "undecided", "unconfirmed": "within unconfirmed limits"}
CDN = "https://cdn.plot.ly/plotly-{}.min.js"


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


def as_json(value: Any) -> str:
    """JSON that can stand inside a script element: no "<" that could end it, no NaN."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _breakable(name: str) -> Markup:
    """A name that may go on in the next line behind a dot or an underscore."""
    return Markup(re.sub(r"([._])(?=\w)", r"\1<wbr>", str(escape(name))))


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(__package__, "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["json"] = as_json
    environment.filters["breakable"] = _breakable
    return environment


def asset(name: str) -> str:
    """The text of a file beside this module."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def write_page(page: Page, path: Path) -> Path:
    """Render to `path`, and to a PDF beside it where the delivery wants one.

    The page is one file: figures with the library that draws them, a still picture of each for where no scripts run, and samples
    of lines that have no room in a figure. With another delivery library and samples are files beside it, or the library comes
    from its makers' network. Else nothing is asked of any network.
    """
    delivery = DELIVERY.get()
    figures = [b for s in page.sections for b in s.blocks if isinstance(b, Figure)]
    inside = delivery.plotly == "inside"
    specs, points = embedded([f.figure for f in figures])
    samples = lost_samples([f.figure for f in figures], points, SAMPLES_INSIDE if inside else SAMPLES_BESIDE)
    beside = path.with_name(path.stem + SAMPLES_ENDING)
    html = (
        _environment()
        .get_template("page.html")
        .render(
            page=page,
            figure_number={id(f): i for i, f in enumerate(figures, 1)},
            specs=specs,
            stills=[still(f.figure, f"f{i}") for i, f in enumerate(figures, 1)],
            points=points,
            samples="" if inside or not samples.content else beside.name,
            samples_inside=compressed(as_json(samples.content)) if inside and samples.content else "",
            sample_points=samples.points,
            id=id,
            badges=BADGES,
            limits_words=LIMITS_WORDS,
            css=asset("page.css"),
            paper=delivery.paper,
            dark=DARK,
            script=asset("shared.js") + asset("bands.js") + asset("page.js"),
            motion_script=asset("motion.js") if any(b.kind == "motion" for s in page.sections for b in s.blocks) else "",
            motion_data=motion_data,
            still_motion=still_motion,
            plotly={"beside": PLOTLY, "cdn": CDN.format(get_plotlyjs_version())}.get(delivery.plotly, "") if figures else "",
            plotly_inside=compressed_plotly() if inside and figures else "",
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    beside.unlink(missing_ok=True)
    if samples.content and not inside:
        with replaced(beside) as file:
            file.write(f"window.samples = {as_json(samples.content)};\n")
    if figures and delivery.plotly == "beside":
        _put_plotly(path.with_name(PLOTLY))
    with replaced(path) as file:
        file.write(visible_in_page(html))
    if delivery.browser:
        print_pdf(path, delivery.browser)
    return path


def compressed(content: str | bytes) -> str:
    """A text or bytes as gzip in letters, which browsers unpack."""
    raw = content.encode("utf-8") if isinstance(content, str) else content
    return b64encode(gzip.compress(raw, 6, mtime=0)).decode("ascii")


@cache
def compressed_plotly() -> str:
    """The library that draws figures, for a page."""
    return compressed(get_plotlyjs())


def _put_plotly(path: Path) -> None:
    """The library beside a page, unless it is there: written anew only where another version is."""
    script = get_plotlyjs()
    if not path.is_file() or path.stat().st_size != len(script.encode("utf-8")):
        with replaced(path) as file:
            file.write(script)
