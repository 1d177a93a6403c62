"""What a kept result depends on, as one key: the only place that knows which parts of a scene change which results.

A result of a scene depends on one of three parts of it. Each contains files by their contents, and components by their code:

    rows      what a run records: checkpoints, runs of studies
    figures   also what is computed from rows and judged: key results, errors of meshes, sets of effects, points of many runs
    model     what is simulated and looked at, whatever coupling, macro step and internal steps: fronts, which compare these
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, Literal

from ...components.catalogue import component_name
from ...components.core.store import digest_of
from ...fmus.versions import version
from ..scene.scene import Scene, read_toml

Part = Literal["rows", "figures", "model"]
NO_RESULT = {"title", "document", "sweep", "explore", "interface"}  # tables that change no result of a run
OF_ROWS = {"analysis", "study", "limits"}  # which only read rows; what they let a run record is resolved
SETTINGS = {"master", "record", "connections"}  # which a front compares; links are the same however a scene writes them


def depends_on(*parts: Any, of: Part = "rows") -> str:
    """The key of a result: scenes by a part `of` them, classes of components by their code, all else as plain data.

    Raises `OSError` where a file that a scene names is gone.
    """
    return digest_of(version("cosimo"), json.dumps([_plain(part, of) for part in parts], sort_keys=True, default=repr))


def source_of(function: str) -> str:
    """Digest of the code of "module:name"; empty where there is none."""
    from ..code_digests import function_digest  # which loads what builds FMUs

    return function_digest(function)


def _plain(part: Any, of: Part) -> Any:
    if isinstance(part, type):
        return _code((component_name(part),))
    if not isinstance(part, Scene):
        return part
    data = _settings(part) | {"code": _code(tuple(sorted({name for kind in part.kinds.values() for name in kind.code})))}
    if of == "model":
        return _model(part, data)
    excluded = NO_RESULT | OF_ROWS
    data = {key: value for key, value in data.items() if key not in excluded} | {"recorded": part.coupling.signals}
    return data | _judged(part) if of == "figures" else data


def _settings(scene: Scene) -> dict[str, Any]:
    """All settings, with contents in the place of paths."""
    data = scene.model_dump(mode="json")
    return data | {"units": {name: kind.contents(data["units"][name]) for name, kind in scene.kinds.items()}}


def _judged(scene: Scene) -> dict[str, Any]:
    """What figures and quantities of rows depend on."""
    limits = scene.limits and [_table(scene.limits.table), scene.limits.conditions]
    analysis = scene.model_dump(mode="json", include={"analysis"})
    return analysis | {"quantities": scene.study.quantities, "limits": limits}


def _table(name: str) -> str | list[str]:
    """A shipped table, which has the version of cosimo; of a user's the digests of its files, and of those of its functions."""
    if not name.endswith(".toml"):
        return name
    path = Path(name)
    table = read_toml(path, "table", "case")
    files = [path, *([path.parent / rows] if isinstance(rows := table.get("rows"), str) else [])]
    functions = [text for text in table.values() if isinstance(text, str) and ":" in text]
    return [*(digest_of(file.read_bytes()) for file in files), *map(source_of, functions)]


def _model(scene: Scene, data: dict[str, Any]) -> dict[str, Any]:
    """Without the settings that are compared; with the other scene that is compared with."""
    for name, unit in data["units"].items():
        compared = {
            "substep",
            "front_threshold",
            *(mesh.removeprefix(f"{name}.") for mesh in scene.study.mesh if mesh.startswith(f"{name}.")),
        }
        unit["parameters"] = {key: value for key, value in unit["parameters"].items() if key not in compared}
    data = {key: value for key, value in data.items() if key not in NO_RESULT | OF_ROWS | SETTINGS} | _judged(scene)
    coupling, monolith = scene.coupling, scene.study.monolith
    ends = [".".join(end) for end in coupling.signals]
    return data | {
        "links": sorted([".".join(x.source), ".".join(x.target), x.factor, x.offset, *x.map] for x in coupling.links),
        "texts": sorted([".".join(x.source), ".".join(x.target)] for x in coupling.texts),
        "quantities": scene.study.quantities or ends,
        "mesh": scene.study.mesh,
        "monolith": monolith and [monolith.signals, _plain(scene.load_other(monolith.scene), "rows")],
    }


@cache
def _code(components: tuple[str, ...]) -> str:
    from ..code_digests import code_digest  # which loads what builds FMUs

    return code_digest(*components)
