"""The drawing of a component or of a scene: an SVG file among the `drawings` of a system's folder, in the colours of the page around it.

A component's file has its name. The attribute `data-scenes` of a drawing names the scenes for which it stands.
"""

from __future__ import annotations

from pathlib import Path

import cosimo.orchestrator.systems

FILES = sorted(Path(cosimo.orchestrator.systems.__path__[0]).glob("*/drawings/*.svg"))
TEXTS = {path.stem: path.read_text(encoding="utf-8").strip() for path in FILES}
SCENES = {scene: text for text in TEXTS.values() for scene in text.partition('data-scenes="')[2].partition('"')[0].split()}


def of_component(name: str, unique: str) -> str:
    """Its drawing as an SVG element, whose ids begin with a text that is unique within the page; "" where it has none."""
    return _with_ids(TEXTS.get(name, ""), unique)


def of_scene(name: str, unique: str) -> str:
    """The drawing that stands for a scene, likewise."""
    return _with_ids(SCENES.get(name, ""), unique)


def _with_ids(text: str, unique: str) -> str:
    return text.replace("drawing-title", f"{unique}-title").replace("drawing-text", f"{unique}-text")
