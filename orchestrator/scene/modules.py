"""Modules of a user's own beside the scene that names them: for "springs:Spring", springs.py in the folder of the scene."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

from ...components.core.errors import BadInput


def find_beside(component: str, folder: Path, where: str) -> None:
    """Let Python find the module of "module:Class" in a folder, if it is there. Another module of its name is a `BadInput`.

    The folder comes last on the path, so that it hides nothing.
    """
    module = component.partition(":")[0]
    top = module.partition(".")[0]
    place = folder.resolve()
    if not (place / f"{top}.py").is_file() and not (place / top / "__init__.py").is_file():
        return
    if str(place) not in sys.path:
        sys.path.append(str(place))
    spec = find_spec(top)
    origin = Path(spec.origin).resolve() if spec is not None and spec.origin else None
    if origin is None or place not in origin.parents:
        raise BadInput(
            where,
            f"module {top!r}, which is {origin or 'built in'} and not the one beside the scene",
            "a name that no other module has",
            "Rename the file.",
        )
