"""A scene as the text of a TOML file: what a study has chosen can be kept, read and changed by hand."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..results import made
from .scene import Scene

BARE = re.compile(r"[A-Za-z0-9_-]+")
WIDTH = 130


def write_scene(scene: Scene, path: str | Path, remarks: Sequence[str] = ()) -> Path:
    """Write the scene to a .toml file, which `load_scene` reads as the same scene; the remarks stand above it as comments."""
    path = Path(path)
    made(path.parent)
    path.write_text(scene_text(scene.settings(), remarks), encoding="utf-8")
    return path


def scene_text(data: Mapping[str, Any], remarks: Sequence[str] = ()) -> str:
    """Settings of a scene as TOML: what is one line first, then the tables, one of its own for each unit."""
    lines = [f"# {remark}" for remark in remarks] + ([""] if remarks else [])
    tables = {k: v for k, v in data.items() if isinstance(v, Mapping)}
    lines += _entries({k: v for k, v in data.items() if k not in tables})
    for name, unit in tables.pop("units", {}).items():
        lines += ["", f"[units.{_key(name)}]", *_entries(unit)]
    for name, table in tables.items():
        if table:
            lines += ["", f"[{_key(name)}]", *_entries(table)]
    return "\n".join(lines) + "\n"


def _entries(table: Mapping[str, Any]) -> list[str]:
    return [_entry(k, v) for k, v in table.items() if v is not None]


def _entry(key: str, value: Any) -> str:
    text = f"{_key(key)} = {_value(value)}"
    if len(text) > WIDTH and isinstance(value, list | tuple):  # an array may have lines, an inline table may not
        text = f"{_key(key)} = [\n" + "".join(f"    {_value(v)},\n" for v in value) + "]"
    return text


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _string(name)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")  # which JSON takes as it is


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None)
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)
