"""The first line of a scene file, which names the JSON schema by which editors check it."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ...components.core.errors import BadInput
from ...components.core.store import replaced

FIRST_LINE = "#:schema"  # starts it, as Taplo and Even Better TOML read it
NAME = "scene.schema.json"


def stale(name: str, components: Iterable[str]) -> list[str]:
    """Where the schema beside a scene file is not that of these components, a warning with the command that mends it."""
    path = Path(name)
    if path.suffix != ".toml":
        return []
    with suppress(OSError, ValueError, BadInput):  # whatever else is wrong with the file is no matter of a run
        with open(path, encoding="utf-8-sig") as file:
            first = file.readline().strip()
        if first.startswith(FIRST_LINE) and (place := _named(path, first)).is_file():
            from ..systems.scene_schema import is_stale

            content = json.loads(place.read_bytes())
            if isinstance(content, dict) and "UnitSettings" in content.get("$defs", {}) and is_stale(content, components):
                return [
                    f"{place} is of another version of cosimo, or of other components, and editors check the scene by it. "
                    f"Write it anew: cosimo schema {shlex.quote(name)}"
                ]
    return []


def schema_place(scene: Path) -> Path:
    """Where an editor looks for the schema of a scene file, which gets the line that says so if it has none."""
    if scene.suffix != ".toml" or not scene.is_file():
        raise BadInput("schema", repr(str(scene)), "a scene file, .toml")
    try:
        content = scene.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise BadInput("schema", repr(str(scene)), "a text in UTF-8") from None
    first = content.partition("\n")[0].strip().removeprefix("\ufeff")
    if not first.startswith(FIRST_LINE):
        with replaced(scene, "wb") as file:
            file.write(f"{FIRST_LINE} {NAME}\n{content.removeprefix(chr(0xFEFF))}".encode())
        return scene.with_name(NAME)
    return _named(scene, first)


def _named(scene: Path, first: str) -> Path:
    """The schema that the first line of a scene file names."""
    name = first.removeprefix(FIRST_LINE).strip()
    if "://" in name or not name:
        raise BadInput("schema", f"{scene}: first line {first!r}", "the path of a file", f"Such as {FIRST_LINE} {NAME}")
    return scene.parent / name
