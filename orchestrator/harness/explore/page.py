"""The file: template, styles, scripts, data and modules in one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from ....components.core.errors import visible_in_page
from ....components.core.store import replaced
from ...output import ensure_directory
from ...scene.scene import Scene
from ..charts.style import BLUE, DARK, MUTED, ORANGE, RAW, VERMILION, axis, layout
from ..report.page import as_json, asset, compressed, compressed_plotly
from .content import content_of

SCRIPTS = ("words", "state", "kinematics", "slopes", "explore")


def explore_page(
    scene: Scene,
    path: Path,
    knowledge: Any = None,
    *,
    moves: Callable[[Any], Any] = lambda result: (),
    parameters: Mapping[str, tuple[float, float] | None] | None = None,
    effects: Sequence[str] | None = None,
    jobs: int | None = None,
    library: str = "",
    say: Callable[[str], None] = lambda text: None,
) -> Path:
    """Write a page that computes the scene in the browser; arguments as of `content_of`. Raises `BadInput`.

    library: where the page finds Plotly; without it Plotly is in the page.
    """
    content = content_of(scene, knowledge, moves=moves, parameters=parameters, effects=effects, jobs=jobs, say=say)
    colours = {"line": BLUE, "raw": RAW, "pinned": MUTED, "bad": VERMILION, "predicted": ORANGE}
    plain: dict[str, Any] = {
        "height": 300,
        "showlegend": True,
        "margin": {"l": 70, "r": 16, "t": 30, "b": 46},
        "uirevision": "kept",
    }
    figures = {
        "curve": layout(**plain, xaxis=axis("time, s"), yaxis=axis("", grid=True)),
        "accuracy": layout(**plain, xaxis=axis("macro step, s", type="log"), yaxis=axis("", grid=True, type="log")),
    }
    environment = Environment(
        loader=PackageLoader(__package__, "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["json"] = as_json
    html = environment.get_template("page.html").render(
        data=dict(content.data) | {"colours": colours, "layouts": figures},
        title=content.data["title"],
        drawing=str(scene.show()),
        css=asset("page.css") + _asset("explore.css"),
        dark=DARK,
        modules=[compressed(module) for module in content.modules],
        tangents=[compressed(module) if module else "" for module in content.tangents],
        worker=_asset("analysis.js") + _asset("tangents.js") + _asset("worker.js"),
        script=asset("shared.js") + asset("motion.js") + "".join(_asset(f"{name}.js") for name in SCRIPTS),
        library=library,
        plotly="" if library else compressed_plotly(),
    )
    ensure_directory(path.parent)
    with replaced(path) as file:
        file.write(visible_in_page(html))
    return path


def _asset(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")
