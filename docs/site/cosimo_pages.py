"""Sphinx extension: pages from the declarations before the build, links from tables of the systems' pages to them.

`python docs/site/cosimo_pages.py FOLDER` writes the pages alone.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive

HERE = Path(__file__).resolve().parent


def version() -> str:
    """Of the installed package; "development" where it only lies on the path."""
    try:
        return importlib.metadata.version("cosimo")
    except importlib.metadata.PackageNotFoundError:
        return "development"


def write(folder: Path) -> None:
    """All pages into a folder, which is made anew."""
    import component_pages
    import reference_pages
    import scene_pages

    shutil.rmtree(folder, ignore_errors=True)
    for name, module in (("components", component_pages), ("scenes", scene_pages), ("reference", reference_pages)):
        (folder / name).mkdir(parents=True)
        for page, text in module.pages().items():
            (folder / name / f"{page}.md").write_text(text, encoding="utf-8")


def generate(app: Any) -> None:
    """In a process without the compiler: some pages initialize every component, which would compile it."""
    command = [sys.executable, str(HERE / "cosimo_pages.py"), str(Path(app.srcdir) / "generated")]
    path = os.pathsep.join(p or os.curdir for p in sys.path)
    subprocess.run(command, check=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path})


def link(app: Any, page: str, source: list[str]) -> None:
    """Names of components and scenes in tables of a system's page lead to their pages; below them the scenes as cards.

    The index of the papers, which is written from the tables, gets its pages into the navigation.
    """
    if page == "papers/index":
        source[0] += "\n```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"
    from live import frame

    if page == "index":
        source[0] = source[0].replace("\n## ", f"\n{frame(page)}\n## ", 1)
    if not page.startswith("systems/"):
        return
    from cosimo.components.catalogue import CATALOGUE
    from cosimo.orchestrator.scene.scene import scene_files
    from scene_pages import cards

    folders = dict.fromkeys(CATALOGUE, "components") | dict.fromkeys(scene_files(), "scenes")

    def linked(match: re.Match[str]) -> str:
        name = match[1]
        return f"| [`{name}`](../generated/{folders[name]}/{name}.md) |" if name in folders else match[0]

    text = re.sub(r"^\| `([\w.-]+)` \|", linked, source[0], flags=re.MULTILINE)
    heading, _, rest = text.partition("\n")
    text = f"{heading}\n\n{frame(page)}{rest}"
    source[0] = text.rstrip() + "\n\n## Gallery\n\n" + cards(page.partition("/")[2], "../generated/scenes/") + "\n"


class MachineDirective(Directive):
    """`{machine} NAME`: the drawing of a component."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Raw HTML, which the search leaves out."""
        import machines

        svg = machines.of_component(self.arguments[0], f"machine-{self.arguments[0]}")
        if not svg:
            raise self.error(f"machine {self.arguments[0]!r}: expected a component with a drawing in its system's folder")
        return [nodes.raw("", f'<div class="sketch">{svg}</div>', format="html")]


class SceneDirective(Directive):
    """`{scene} NAME`: the machine of a scene, and the curve that it is there for."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Raw HTML, which the search leaves out."""
        import scene_pages

        return [nodes.raw("", scene_pages.picture(self.arguments[0]), format="html")]


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_directive("machine", MachineDirective)
    app.add_directive("scene", SceneDirective)
    app.connect("builder-inited", generate)
    app.connect("source-read", link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    write(Path(sys.argv[1]))
