"""The gallery of shipped scenes, and a page for each: picture, units, connections, file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.scene.scene import read_toml, scene_files
from cosimo.orchestrator.systems import SYSTEMS
from prose import code, joined, plain, table, verbatim

PICTURES = Path(__file__).resolve().parents[1] / "pictures" / "scenes"


def pages() -> dict[str, str]:
    """File name -> Markdown, of all scenes and of the gallery."""
    return {"index": _gallery(), **{name: _page(name, path) for name, path in scene_files().items()}}


def cards(system: str, folder: str) -> str:
    """The scenes of a system as cards. folder: where their pages are, seen from the page of the cards."""
    grid = ["::::{grid} 1 2 3 3", ":gutter: 3", ""]
    for name, path in scene_files().items():
        if path.parent.parent.name == system:
            grid += [":::{grid-item-card} " + name, f":link: {folder}{name}", ":link-type: doc"]
            grid += [f":img-top: /pictures/scenes/{name}.png"] if (PICTURES / f"{name}.png").is_file() else []
            grid += [f":img-alt: first figure of the report of {name}"] if (PICTURES / f"{name}.png").is_file() else []
            grid += ["", plain(read_toml(path).get("title", "")), ":::", ""]
    return "\n".join([*grid, "::::"])


def _gallery() -> str:
    parts = ["# Gallery of scenes", "Each picture is the first figure of the report of `cosimo run NAME --in-process`."]
    for system in SYSTEMS.values():
        parts += [f"## [{system.title}](../../systems/{system.name}.md)", cards(system.name, "")]
    toctree = "\n".join(["```{toctree}", ":hidden:", "", *sorted(scene_files()), "```"])
    return joined(*parts, toctree)


def _page(name: str, path: Path) -> str:
    data = read_toml(path)
    system = path.parent.parent.name
    picture = f"![first figure of the report](../../pictures/scenes/{name}.png)" if (PICTURES / f"{name}.png").is_file() else ""
    units = table(("unit", "what it is", "effects"), [_unit(unit, given) for unit, given in data["units"].items()])
    links = [c if isinstance(c, str) else f"{c['source']} -> {c['target']}" for c in data.get("connections", ())]
    run = verbatim(f"cosimo run {name} --in-process -o out\ncosimo show {name}")
    title = plain(data.get("title", "")) + f". System: [{SYSTEMS[system].title}](../../systems/{system}.md)."
    return joined(
        f"# {name}",
        title,
        picture,
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
