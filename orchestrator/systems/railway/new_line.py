"""A line from the CSV table of its supports, and a scene of pantographs under a line: files to start from, which run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.columns import read_table
from ....components.core.errors import BadInput, pick
from ....components.core.measure import number_in
from ....components.railway.line.from_table import resolved_sections
from ....components.railway.line.table import MOST_DROPPERS, Support, checked_number, read_line
from ....components.railway.pantograph import Pantograph
from ...scene.file_kinds import refuse_other
from ...scene.files import read_text, read_toml

COLUMNS = {  # of the table of supports -> key of a support in a line's table, "" for what is none; unit
    "position": ("", "m"),
    "section": ("", ""),
    "contact height": ("contact_height", "m"),
    "system height": ("system_height", "m"),
    "stagger": ("stagger", "m"),
    "held": ("held", ""),
    "contact stiffness": ("contact_stiffness", "N/m"),
    "main droppers": ("", "1"),
}
MAIN_DROPPERS = "It is the number of main droppers in the span from this support to the next one."
TRUTHS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
BOUNDS = {field.name: field.metadata for field in fields(Support)}  # of a support, by the keys of a line's table
START = 30.0  # m, of the last pantograph, at most half of the first span
TRANSIENT = 1.0  # s, of the start at full speed
CALM = 1.6  # times the way of the transient, before the first span that is judged: for runs at higher speeds, too
REFERENCE = "EN 50318:2002"  # whose static force and contact spring are the defaults of `Pantograph`
TAKEN = {  # parameter of a pantograph that a frequency response does not give -> what to give instead
    "static_force": "give that of your pantograph",
    "contact_stiffness": "of the model, not of the strip",
    "working_height": "where the lowest spring is relaxed, above the unloaded wire",
}
PORTS = ("contact", "second_pantograph")  # of the catenary, for the first two; then elements of `further_pantographs`
NUMBERED = ("first", "second", "third", "fourth")


def supports_of(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Section -> its supports in the order of their positions, of a CSV table with a row for each; raises `BadInput` with the line."""
    table = read_table(path, "supports")
    table.only(COLUMNS, "a column of supports")
    columns = {
        name: table.numbers(name, unit, asked=True) if unit else table.texts(name)
        for name, (_, unit) in COLUMNS.items()
        if name == "position" or table.place(name) is not None
    }
    sections: dict[str, list[dict[str, Any]]] = {}
    for i, (line, _) in enumerate(table.rows):
        cells = {name: values[i] for name, values in columns.items()}
        support: dict[str, Any] = {name: v if isinstance(v, str) else float(v) for name, v in cells.items() if v != "" and v == v}
        for name in ("contact height", "system height", "stagger"):
            if name in support:
                checked_number(BOUNDS[COLUMNS[name][0]], support[name], f"{path}, line {line}, column {name!r}")
        if "position" not in support:
            raise BadInput(f"{path}, line {line}", "no position", "the position of each support, m")
        if support.get("held", "yes").lower() not in TRUTHS:
            raise BadInput(f"{path}, line {line}, column 'held'", repr(support["held"]), "yes or no")
        count = support.get("main droppers", 0.0)
        if not (count.is_integer() and 0.0 <= count <= MOST_DROPPERS):
            place = f"{path}, line {line}, column 'main droppers'"
            raise BadInput(place, f"{count:g}", f"a whole number from 0 to {MOST_DROPPERS}", MAIN_DROPPERS)
        sections.setdefault(support.pop("section", "1"), []).append(support)
    for name, supports in sections.items():
        positions = [s["position"] for s in supports]
        if len(supports) < 2 or (np.diff(positions) <= 0.0).any():
            actual = f"supports at {', '.join(f'{x:g}' for x in positions[:8])}{', ...' if len(positions) > 8 else ''} m"
            raise BadInput(f"{path}, section {name}", actual, "at least two, each behind the one before")
        if "main droppers" in supports[-1]:
            actual = f"main droppers at {positions[-1]:g} m, the last support"
            raise BadInput(f"{path}, section {name}", actual, "an empty cell there", MAIN_DROPPERS)
    if not sections:
        raise BadInput(str(path), "no support", "a row for each support")
    return sections


def line_text(
    title: str, source: str, sections: Mapping[str, Sequence[Mapping[str, Any]]], data: Mapping[str, Mapping[str, float]]
) -> str:
    """A line's table. data: "contact_wire", "auxiliary", "droppers", "support", ... -> numbers of each section's table, SI."""
    parts = [f"title = {_quoted(title)}", f"source = {_quoted(source)}", ""]
    for supports in sections.values():
        positions = [s["position"] for s in supports]
        parts += ["[[sections]]", f"start = {positions[0]:.9g}"]
        parts += [f"{name} = {_table(values)}" for name, values in data.items() if values]
        parts += [f"spans = [{', '.join(map(_span, np.diff(positions).tolist(), supports))}]"]
        rows = [_table({COLUMNS[c][0]: v for c, v in s.items() if COLUMNS[c][0]}) for s in supports]
        parts += ["supports = [", *(f"    {row}," for row in rows), "]", ""] if any(row != "{}" for row in rows) else [""]
    return "\n".join(parts)


def _span(length: float, support: Mapping[str, Any]) -> str:
    """A span behind a support; main droppers that are counted there stand at equal distances, half of that from the supports."""
    if "main droppers" not in support:
        return f"{length:.9g}"
    count = int(support["main droppers"])
    return (
        f"{{ length = {length:.9g}, main_positions = [{', '.join(f'{length * (k + 0.5) / count:.9g}' for k in range(count))}] }}"
    )


def _table(values: Mapping[str, Any]) -> str:
    def shown(value: Any) -> str:
        if isinstance(value, float):
            return f"{value:.9g}"
        return "true" if TRUTHS[str(value).lower()] else "false"

    return "{ " + ", ".join(f"{key} = {shown(value)}" for key, value in values.items()) + " }" if values else "{}"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def scene_text(
    title: str,
    folder: Path,
    line: Path,
    droppers: Path | None,
    pantograph: str,
    count: int,
    distance: float,
    speed: str,
    limits: str,
    own: Mapping[str, float],
    later: Mapping[str, float],
) -> tuple[str, list[str]]:
    """A scene of pantographs under a line, and what a user should know of it; raises `BadInput`.

    folder: where the scene goes, from which its files are named.  own: parameters of every pantograph, SI.  later: parameters of the
    catenary's effects `temperature` and `wear`.
    """
    refuse_other(line, "line")
    form = read_line(read_text(line, "line"), str(line))
    resolved = resolved_sections(form)
    supports = np.unique(np.concatenate([s.x for s in resolved]).round(9))
    v = number_in(speed, "m/s", "--speed")
    second = len(resolved) > 1 or any(s.section.second_contact_wire.tension is not None for s in resolved)
    last = float(supports[0] + min(START, 0.5 * (supports[1] - supports[0])))
    starts = [last + distance * (count - 1 - k) for k in range(count)]
    end = float(supports[-1] - 0.5 * (supports[-1] - supports[-2]))
    begin = starts[0] + CALM * TRANSIENT * v
    inside = supports[(supports >= begin) & (supports <= end - distance * (count - 1))]
    if inside.size < 2:
        need = begin + distance * (count - 1) + 2.5 * float(np.diff(supports).max())
        raise BadInput(
            "new scene",
            f"a line of {supports[-1] - supports[0]:g} m",
            f"about {need:.0f} m: {count} at {v:g} m/s, {TRANSIENT:g} s of start, and a whole span to judge",
            "Make the line longer, or the pantographs fewer or slower.",
        )
    names = ["pantograph"] if count == 1 else ["leading", "trailing"] if count == 2 else list(NUMBERED[:count])
    ports = [PORTS[k] if k < 2 else f"further_pantographs[{k - 1}]" for k in range(count)]
    joined = [f"{name}.contact <-> catenary.{port}" for name, port in zip(names, ports, strict=True)]
    joined += [f"{name}.second_wire <-> catenary.second_wire[{k}]" for k, name in enumerate(names, 1) if second]
    effects = ["dropper_slackening", "gravity_sag", "damping", "line_table", "wire_profile"]
    effects += ["second_wire"] if second else []
    effects += ["second_pantograph"] if count > 1 else []
    effects += ["further_pantographs"] if count > 2 else []
    table = [f"line_table.table = {_quoted(_from(folder, line))}"]
    table += [f"line_table.droppers = {_quoted(_from(folder, droppers))}"] if droppers is not None else []
    effects += [name.partition(".")[0] for name in later]
    table += [f"{name} = {value:.9g}" for name, value in later.items()]
    table += [f"further_pantographs.count = {count - 2}"] if count > 2 else []
    first_watched = max(0, int(np.flatnonzero(supports == inside[0])[0]))
    parts = [
        f"title = {_quoted(title)}",
        f"stop_time = {(end - starts[0]) / v:.4g}                                   # s; to the middle of the last span",
        *([f"limits = {_quoted(limits)}"] if limits else []),
        "connections = [",
        *(f"    {_quoted(text)}," for text in joined),
        "]",
        "",
        "[units.catenary]",
        'component = "Catenary"',
        f"effects = [{', '.join(map(_quoted, effects))}]",
        "parameters = { "
        + ", ".join(
            [
                *table,
                f"first_watched_support = {first_watched}",
                "substep = 2.5e-4",
                "damping.beta = 1e-4",
                "damping.alpha = 0.0125",
            ]
        )
        + " }  # damping: of EN 50318:2018",
    ]
    unit = _pantograph(pantograph)
    unit["parameters"] |= own
    switched = [*unit["effects"], *(["second_wire"] if second and "second_wire" not in unit["effects"] else [])]
    for name, start in zip(names, starts, strict=True):
        given = {**unit["parameters"], "speed": speed, "start_position": start}
        parts += [
            "",
            f"[units.{name}]",
            'component = "Pantograph"',
            *([f"preset = {_quoted(unit['preset'])}"] if unit["preset"] else []),
        ]
        parts += [f"effects = [{', '.join(map(_quoted, switched))}]", "", f"[units.{name}.parameters]"]
        parts += [f"{key} = {_quoted(value) if isinstance(value, str) else f'{value:.9g}'}" for key, value in given.items()]
        parts += _taken(unit)
    parts += [
        "",
        "[master]",
        'algorithm = "gauss-seidel"',
        "step = 1e-3                                       # s",
        "extrapolation = 1",
        "",
    ]
    parts += [
        "[analysis]",
        'system = "railway"',
        f"transient = {TRANSIENT:g}                                    # s, of the start at full speed",
    ]
    parts += [
        f"window = [{inside[0]:.9g}, {inside[-1]:.9g}]                          # m, whole spans that all pantographs pass",
        "",
    ]
    origins = (" of preset ", " default:") if unit["preset"] else ()  # what a preset says, or leaves at rest, is no news
    taken = [line for line in _taken(unit) if not any(origin in line for origin in origins)]
    return "\n".join(parts), [line.replace("  # ", " ") + "; until then the scene has this number" for line in taken]


def _from(folder: Path, file: Path) -> str:
    """The path of a file as a scene in the folder names it."""
    try:
        return file.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        return file.resolve().as_posix()


def _pantograph(name: str) -> dict[str, Any]:
    """Preset, effects and parameters of a preset's name, or of a fitted pantograph's file."""
    if not name.endswith(".toml"):
        pick(name, Pantograph.presets, "--pantograph", "a preset of Pantograph, or the file of a fitted one")
        return {"preset": name, "effects": ["contact_loss"], "parameters": {}}
    data = read_toml(Path(name), "scene").get("units", {})
    unit = next(iter(data.values()), None) if isinstance(data, Mapping) else None
    if not isinstance(unit, Mapping) or unit.get("component") != "Pantograph":
        raise BadInput(
            "--pantograph", repr(name), "a file with a unit that is a Pantograph", "As `cosimo railway fit-pantograph` writes it."
        )
    parameters = _flat(unit.get("parameters", {}))
    return {"preset": unit.get("preset", ""), "effects": list(unit.get("effects", ["contact_loss"])), "parameters": parameters}


def _taken(unit: Mapping[str, Any]) -> list[str]:
    """Lines for what neither a fit nor an option says of a pantograph, and from where it is taken."""
    name = unit["preset"]
    preset = Pantograph.presets[name].parameters if name else {}
    reference = Pantograph.presets[REFERENCE].parameters
    lines = []
    for key, text in TAKEN.items():
        variable = Pantograph.variables[key]
        if key in unit["parameters"]:
            continue
        origin = f"of preset {name}" if key in preset else f"of {REFERENCE}" if key in reference else "default"
        value = preset.get(key, reference.get(key, variable.start))
        lines.append(f"{key} = {value:.9g}  # {variable.unit}, {origin}: {text}")
    return lines


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else {prefix + key: value}
    return flat
