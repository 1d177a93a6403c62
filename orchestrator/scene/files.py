"""Files of scenes: TOML, and systems of other tools; shipped ones by their name."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from ...components.core.columns import decoded
from ...components.core.errors import BadInput, nearest, syntax_remedy
from ...components.core.files import read_bytes
from ..loading import MOST_TOML, check_values, loading
from .file_kinds import SUFFIXES, kind_of_data, refuse_kind, refuse_other

SHIPPED = Path(__file__).parents[1] / "systems"  # a folder a system, with what it ships
ARCHIVE = (
    "This cosimo is imported from an archive, in which it does not find its scenes and tables. Install it, or unpack the archive."
)
SYSTEMS = (".ssd", ".ssp", ".xml")  # of SSP, and of Open Simulation Platform
SCENES = (".toml", *SYSTEMS)


def shipped(folder: str, suffix: str) -> dict[str, Path]:
    """Files with a suffix in the folders of that name of all systems, by their stem."""
    return dict(sorted((p.stem, p) for p in SHIPPED.glob(f"*/{folder}/*{suffix}")))


def scene_files() -> dict[str, Path]:
    """Shipped scenes by name."""
    return shipped("scenes", ".toml")


def scene_path(name_or_path: str | Path, where: str = "scene", folder: Path | None = None) -> Path:
    """The file of a shipped scene by its name, or a path, relative to `folder`."""
    path = Path(name_or_path)
    if path.suffix in SCENES:
        return path if folder is None else folder / path
    files = scene_files()
    if str(name_or_path) not in files:
        refuse_other(path if folder is None else folder / path, "scene")
        raise BadInput(
            where,
            repr(str(name_or_path)),
            "a shipped scene (cosimo list scenes) or the path of a .toml, .ssd or .ssp file, or of an OspSystemStructure.xml",
            nearest(str(name_or_path), files) if files else ARCHIVE,
        )
    return files[str(name_or_path)]


def read_file(path: Path, given: Collection[str] = ()) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The data of a scene's file, and remarks about what of it could not be used; faults are one `BadInput`.

    given: places of settings that are known from elsewhere, of which nothing has to be said.
    """
    with loading(str(path)):
        if path.suffix in SYSTEMS:
            from .ssp.read import read as read_system  # loads what only systems need

            system = read_system(path, given)
            return system.data, system.remarks
        return read_toml(path, "scene"), ()


def read_text(path: Path, where: str = "scene") -> str:
    """The text of a TOML file, or of a CSV table; one that is missing, too long or no text is one `BadInput`."""
    data = read_bytes(path, where, MOST_TOML)
    if path.suffix.lower() == ".csv":
        return decoded(data, str(path))
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise BadInput(str(path), "bytes that are no UTF-8", "a TOML file in UTF-8", "Save it in this encoding.") from None


def table_text(value: Any, folder: Path, where: str) -> Any:
    """The value of a parameter; of one that names a table's file by its ending, .toml or .csv, the text of the file."""
    is_file = isinstance(value, str) and value.endswith((".toml", ".csv")) and "\n" not in value
    return read_text(folder / value, where) if is_file else value


def read_toml(path: Path, *kinds: str) -> dict[str, Any]:
    """The file's tables; a missing file, a syntax error, or a file of another kind than wanted is one `BadInput` with file and line."""
    if kinds and (path.is_dir() or path.suffix.lower() in SUFFIXES):
        refuse_other(path, *kinds)
    text = read_text(path, kinds[0] if kinds else "file")
    try:
        data = tomllib.loads(text)
    except ValueError as error:  # of syntax, or of an integer of thousands of digits
        line = re.search(r"line (\d+)", str(error))
        raise BadInput(
            f"{path}:{line[1]}" if line else str(path), f"a syntax error: {error}", "TOML", syntax_remedy(text, error)
        ) from None
    if kinds:
        refuse_kind(path, kind_of_data(data), *kinds)
    check_values(data, str(path))
    return data
