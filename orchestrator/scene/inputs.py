"""A table of signals as the inputs of a scene that nothing drives: columns are joined to inputs by their names."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ...components.core.errors import BadInput, nearest
from ..units.signal_files import read_signals

UNIT = "input"
Scene = Any  # `scene.Scene`, which imports this module


def with_columns(scene: Scene, path: str | Path, written: str = "") -> tuple[dict[str, Any], str]:
    """Plain data of the scene with a unit of the table and its connections, and a remark on what found no partner, "" for none.

    written: the path as the scene is to have it. Raises `BadInput` for a table of which no column is an input.
    """
    table = read_signals(path, "--input")
    columns = list(table.columns())
    ends = open_inputs(scene)
    joined = {column: ends[column] for column in columns if column in ends}
    if not joined:
        known = ", ".join(sorted(name for name in ends if "." not in name)[:20]) or "none"
        guess = nearest(columns[0], ends) if ends else ""
        raise BadInput(
            f"--input {path}", f"columns {', '.join(columns)}", f"a column with the name of an open input: {known}", guess
        )
    name = next(n for k in range(len(scene.units) + 1) if (n := f"{UNIT}_{k + 1}" if k else UNIT) not in scene.units)
    data = scene.settings()
    data["units"][name] = {"signals": written or os.path.abspath(path)}
    for unit, variable in joined.values():
        data["units"][unit].get("parameters", {}).pop(variable, None)
    more = [{"source": f"{name}.{column}", "target": ".".join(end)} for column, end in joined.items()]
    data["connections"] = [*data.get("connections", ()), *more]
    if data.get("master", {}).get("order"):
        data["master"]["order"] = [name, *data["master"]["order"]]  # it has no inputs, so that all may see its present values
    free = {name: end for name, end in ends.items() if end not in joined.values()}
    left = [f"{c!r}{_guess(c, free)}" for c in columns if c not in joined]
    waiting = sorted({".".join(end) for end in ends.values()} - {".".join(end) for end in joined.values()})
    texts = [f"no input for column {', '.join(left)}"] if left else []
    texts += [f"no column for {', '.join(waiting)}, which keep their values"] if waiting else []
    return data, f"{Path(path).name}: {'; '.join(texts)}" if texts else ""


def _guess(column: str, ends: dict[str, tuple[str, str]]) -> str:
    text = nearest(column, ends)
    return f" ({text})" if text.startswith("Did you mean") else ""


def open_inputs(scene: Scene) -> dict[str, tuple[str, str]]:
    """Inputs that are numbers and that nothing drives, by the scene's own names of them, by "unit.input", and alone where unique."""
    coupling = scene.coupling
    driven = {link.target for link in (*coupling.links, *coupling.texts)}
    free = [
        (unit, name)
        for unit, interface in coupling.interfaces.items()
        if unit in scene.units
        for name, signal in interface.inputs.items()
        if (unit, name) not in driven and not signal.is_text
    ]
    alone = [name for _, name in free]
    ends = {name: (unit, name) for unit, name in free if alone.count(name) == 1}
    ends |= {f"{unit}.{name}": (unit, name) for unit, name in free}
    return ends | {shown: each.end for shown, each in coupling.shown.items() if each.causality == "input" and each.end in free}
