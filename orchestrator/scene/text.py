"""A scene as the text of a TOML file: what a study has chosen can be kept, read and changed by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from ..output import ensure_directory
from .scene import Scene


def write_scene(scene: Scene, path: str | Path, remarks: Sequence[str] = ()) -> Path:
    """Write the scene to a .toml file, which `load_scene` reads as the same scene; the remarks stand above it as comments."""
    path = Path(path)
    ensure_directory(path.parent)
    path.write_text(scene_text(scene.settings(), remarks), encoding="utf-8")
    return path


def scene_text(data: Mapping[str, Any], remarks: Sequence[str] = ()) -> str:
    """Settings of a scene as TOML, below the remarks as comments."""
    comments = "".join(f"# {line}\n" for remark in remarks for line in remark.splitlines())
    return comments + ("\n" if remarks else "") + tomli_w.dumps(_without_none(data))


def _without_none(value: Any) -> Any:
    """Tables without the keys that have no value, for which TOML has no word."""
    if isinstance(value, Mapping):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list | tuple) else value
