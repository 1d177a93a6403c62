"""The gallery of shipped scenes, and a page for each: machine, curve, units, connections, file."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path
from typing import Any

import machines
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.scene.scene import read_toml, scene_files
from cosimo.orchestrator.systems import SYSTEMS
from prose import code, joined, plain, table, verbatim

CURVES = Path(__file__).resolve().parents[1] / "pictures" / "scenes"


def pages() -> dict[str, str]:
    """File name -> Markdown, of all scenes and of the gallery."""
    return {"index": _gallery(), **{name: _page(name, path) for name, path in scene_files().items()}}


def cards(system: str, folder: str) -> str:
    """The scenes of a system as cards: machine, curve, title. folder: where their pages are, seen from the page of the cards."""
    of_system = [name for name, path in scene_files().items() if path.parent.parent.name == system]
    return _raw(f'<ul class="gallery" data-system="{system}">{"".join(_card(name, folder) for name in of_system)}</ul>')


def picture(name: str) -> str:
    """Machine and curve of a scene, as HTML."""
    return f'<div class="pair large">{_machine(name)}{_curve(name)}</div>'


def _card(name: str, folder: str) -> str:
    data = read_toml(scene_files()[name])
    effects = sorted({effect for unit in data["units"].values() for effect in unit.get("effects", ())})
    title, attributes = escape(data.get("title", "")), f'data-effects="{" ".join(effects)}" data-figures="{_figures(name)}"'
    return (
        f'<li {attributes}><a href="{folder}{name}.html"><span class="pair" aria-hidden="true">{_machine(name)}{_curve(name)}</span>'
        f"<strong>{name}</strong> <span>{title}</span></a></li>"
    )


def _machine(name: str) -> str:
    return machines.of_scene(name, f"machine-{name}")


def _curve(name: str) -> str:
    """What a scene shows, as SVG; nothing where docs/pictures/thumbnails.py has not been run for it."""
    file = CURVES / f"{name}.svg"
    return file.read_text(encoding="utf-8").strip() if file.is_file() else ""


def _figures(name: str) -> str:
    """Titles of the figures of its report, with | between them."""
    kept = re.search(r'data-figures="([^"]*)"', _curve(name))
    return kept[1] if kept else ""


def _raw(html: str) -> str:
    return f"```{{raw}} html\n{html}\n```"


def _gallery() -> str:
    text = (
        "Each card has the machine and one curve of the report of `cosimo run NAME --in-process`. The fields choose by system, by an "
        "effect that is on, by a figure of the report, and by words."
    )
    parts = ["# Gallery of scenes", text, _raw('<form class="gallery-filter" hidden></form>')]
    for system in SYSTEMS.values():
        parts += [f"## [{system.title}](../../systems/{system.name}.md)", cards(system.name, "")]
    toctree = "\n".join(["```{toctree}", ":hidden:", "", *sorted(scene_files()), "```"])
    return joined(*parts, _raw('<script src="../../_static/gallery.js"></script>'), toctree)


def _page(name: str, path: Path) -> str:
    data = read_toml(path)
    system = path.parent.parent.name
    units = table(("unit", "what it is", "effects"), [_unit(unit, given) for unit, given in data["units"].items()])
    links = [c if isinstance(c, str) else f"{c['source']} -> {c['target']}" for c in data.get("connections", ())]
    run = verbatim(f"cosimo run {name} --in-process -o out\ncosimo show {name}")
    title = plain(data.get("title", "")) + f". System: [{SYSTEMS[system].title}](../../systems/{system}.md)."
    return joined(
        f"# {name}",
        title,
        _raw(picture(name)),
        run,
        "## Units",
        units,
        "## Connections" if links else "",
        verbatim("\n".join(links)) if links else "",
        "## The file",
        f"```toml\n{path.read_text(encoding='utf-8').rstrip()}\n```",
    )


def _unit(unit: str, given: dict[str, Any]) -> tuple[str, str, str]:
    component, scene = given.get("component", ""), given.get("scene", "")
    if component in CATALOGUE:
        what = f"[`{component}`](../components/{component}.md)"
    else:
        what = f"scene [`{scene}`]({scene}.md)" if scene in scene_files() else code(component or scene or given.get("fmu", ""))
    return code(unit), what, ", ".join(map(code, given.get("effects", ())))
