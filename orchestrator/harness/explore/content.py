"""What a page that computes a scene holds, as plain data beside the modules."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Protocol

from ....components.core.errors import BadInput, nearest
from ....fmus.native.build import Library
from ....fmus.native.variables import NativeVariable
from ...judgement.comparison import SURE, UNSURE
from ...judgement.thresholds import ORDER_UNSURE
from ...run import run
from ...scene.scene import Scene
from ...scene_fmu import refuse_what_needs_python, scene_library
from ..validation.reference import STANDINGS, load_table, table_files
from .figures import LiveFigure, figures_of_study, filters
from .screening import screened

if TYPE_CHECKING:
    from ...results import Result

FACTORS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # macro steps that a page offers, over the scene's
FEWEST = 20  # macro steps of a run
MOST_EFFECTS = 3  # switches: a module for each set of them
NUMERICAL = ("*.substep", "*.tolerance")  # parameters that no slider is offered for: accuracy has its own place
FIRST = 8  # parameters with a slider, where the user names none
SPAN = 0.5  # of its value, to either side: a slider's range where none is given
EXACT = 2**53


class Knowledge(Protocol):
    """What a system knows of its pages, all of it optional: the attributes of its module `explore`."""

    def figures(self, result: Result) -> Sequence[LiveFigure]:
        """Its figures, for a run of the scene."""

    def conditions(self, result: Result, names: Iterable[str]) -> Mapping[str, Mapping[str, float]]:
        """Condition of a reference table -> the parameters that say so."""


@dataclass(frozen=True)
class Variant:
    """The scene with some of the offered effects on."""

    effects: Mapping[str, bool]
    library: Library


@dataclass(frozen=True)
class Content:
    """The data of a page, and the modules by the number of their variant."""

    data: Mapping[str, Any]
    modules: Sequence[bytes]


def content_of(
    scene: Scene,
    knowledge: Any,
    *,
    parameters: Mapping[str, tuple[float, float] | None] | None = None,
    effects: Sequence[str] | None = None,
    jobs: int | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> Content:
    """Compile a scene for a page. parameters: "unit.parameter" -> range of its slider, None for the usual one.

    effects: "unit.effect" that can be switched; by default none.  say: is told what is being done.  Raises `BadInput`.
    """
    refuse_what_needs_python(scene)
    scene = scene.with_changes({"record.interval": None})
    say("running the scene once")
    result = run(scene, in_process=True)
    variants = list(_variants(scene, _checked_effects(scene, effects or ()), say))
    base = variants[0].library
    ranges = parameters or {}
    rows = [_parameter(v, ranges.get(v.scalar.name)) for v in _numbers(base, "PARAMETER")]
    rows = [row for row in rows if _acts(scene, row["name"], row["to"])]
    names = [row["name"] for row in rows]
    if unknown := [name for name in parameters or () if name not in names]:
        raise BadInput(
            "explore", f"parameter {unknown[0]!r}", "a real parameter that is not structural", nearest(unknown[0], names)
        )
    if parameters:
        first = list(parameters)
    else:
        say("finding the parameters that move the figures most")
        limits = {r["name"]: (-inf if r["low"] is None else r["low"], inf if r["high"] is None else r["high"]) for r in rows}
        fixed = (*NUMERICAL, *getattr(knowledge, "FIXED", ()))
        first = [n for n in screened(scene, {row["name"]: row["value"] for row in rows}, limits, jobs) if not _is_any(n, fixed)][
            :FIRST
        ]
    steps = _steps(scene)
    figures = tuple(getattr(knowledge, "figures", lambda result: ())(result)) or figures_of_study(scene)
    table, conditions = _table(scene, knowledge, result, {f.measure for f in figures if f.measure})
    data = {
        "name": scene.name,
        "title": scene.title or scene.name,
        "stop": scene.stop_time,
        "step": scene.master.step,
        "steps": [s | {"filters": filters(figures, s["length"])} for s in steps],
        "variants": [_references(v) for v in variants],
        "effects": _described_effects(scene, variants),
        "parameters": sorted(rows, key=lambda row: first.index(row["name"]) if row["name"] in first else len(first)),
        "first": first,
        "signals": [
            {"name": v.scalar.name, "unit": v.scalar.unit or "1", "text": v.scalar.text} for v in _numbers(base, "OUTPUT")
        ],
        "figures": [f.to_json() for f in figures],
        "table": table,
        "presets": [{"name": name, "values": dict(values)} for name, values in conditions.items()],
        "settings": scene.settings(),
        "error": {"sure": SURE, "unsure": UNSURE, "limit": ORDER_UNSURE},
        "standings": STANDINGS,
    }
    return Content(data, [v.library.binaries["wasm32"] for v in variants])


def _acts(scene: Scene, name: str, value: float) -> bool:
    """Whether the scene takes another value of a parameter: one that would have no effect is refused."""
    unit, parameter = scene.split(name)
    try:
        scene.with_changes({f"units.{unit}.parameters.{parameter}": value})
    except BadInput:
        return False
    return True


def _is_any(name: str, patterns: Collection[str]) -> bool:
    return any(name.endswith(p.removeprefix("*")) for p in patterns)


def _checked_effects(scene: Scene, effects: Sequence[str]) -> list[str]:
    """The offered effects, those of the scene by their full names."""
    known = [f"{unit}.{effect}" for unit, settings in scene.units.items() for effect in settings.effects]
    if unknown := [e for e in effects if e not in known]:
        raise BadInput("explore", f"effect {unknown[0]!r}", "an effect that is on in the scene", nearest(unknown[0], known))
    if len(effects) > MOST_EFFECTS:
        raise BadInput("explore", f"{len(effects)} effects", f"at most {MOST_EFFECTS}: each set of them is a module of the page")
    return list(effects)


def _variants(scene: Scene, offered: Sequence[str], say: Callable[[str], None]) -> Iterator[Variant]:
    """All sets of the offered effects, the scene itself first."""
    sets = list(product((True, False), repeat=len(offered)))
    for k, states in enumerate(sets, 1):
        say(f"compiling module {k} of {len(sets)}")
        off = [name for name, on in zip(offered, states, strict=True) if not on]
        changes: dict[str, Any] = {}
        for unit, settings in scene.units.items():
            without = {name.rpartition(".")[2] for name in off if name.rpartition(".")[0] == unit}
            if without:
                changes[f"units.{unit}.effects"] = [e for e in settings.effects if e not in without]
                kept = {n: v for n, v in settings.parameters.items() if n.partition(".")[0] not in without}
                changes[f"units.{unit}.parameters"] = kept
        changed = scene.with_changes(changes) if changes else scene
        yield Variant(dict(zip(offered, states, strict=True)), scene_library(changed, ["wasm32"], ("live.c",)))


def _numbers(library: Library, role: str) -> list[NativeVariable]:
    """Real variables of a role; of parameters those that are no element of an array."""
    return [
        v
        for v in library.variables
        if v.role == role and v.scalar.type == "Real" and (role == "OUTPUT" or (v.size == 1 and "[" not in v.scalar.name))
    ]


def _references(variant: Variant) -> dict[str, Any]:
    places = {v.scalar.name: k for k, v in enumerate(variant.library.variables)}
    named = {
        role: {v.scalar.name: places[v.scalar.name] for v in _numbers(variant.library, role)} for role in ("PARAMETER", "OUTPUT")
    }
    return {
        "effects": variant.effects,
        "token": variant.library.token,
        "parameters": named["PARAMETER"],
        "outputs": named["OUTPUT"],
    }


def _described_effects(scene: Scene, variants: Sequence[Variant]) -> list[dict[str, str]]:
    from ....components.catalogue import component_class

    described = []
    for name in variants[0].effects:
        unit, _, effect = name.rpartition(".")
        text = component_class(scene.units[unit].component).effects[effect].__doc__ or ""
        described.append({"name": name, "text": " ".join(text.partition("\n\n")[0].split())})
    return described


def _parameter(variable: NativeVariable, given: tuple[float, float] | None) -> dict[str, Any]:
    """A parameter with its limits and the range of its slider."""
    s = variable.scalar
    value, low, high = float(s.start), float(s.low), float(s.high)
    span = SPAN * abs(value) or s.nominal
    first, last = given or (max(value - span, low), min(value + span, high))
    if not low <= first <= value <= last <= high or not first < last:
        text = f"{s.name} from {first:g} to {last:g}"
        raise BadInput("explore", text, f"a range around {value:g} within {low:g} and {high:g}")
    return {
        "name": s.name,
        "value": value,
        "low": low if isfinite(low) else None,
        "high": high if isfinite(high) else None,
        "from": first,
        "to": last,
        "unit": s.unit or "1",
        "text": s.text,
    }


def _steps(scene: Scene) -> list[dict[str, Any]]:
    """Macro steps that the run is a whole number of: length, s, and the same as whole numbers, 0 where there are none."""
    steps = []
    for factor in FACTORS:
        length = float(f"{factor * scene.master.step:.12g}")
        count = scene.stop_time / length
        if abs(count - round(count)) < 1e-9 * count and round(count) >= FEWEST:
            steps.append({"length": length, "exact": _whole(length), "half": _whole(0.5 * length)})
    return steps


def _whole(length: float) -> tuple[int, int]:
    numbers = Fraction(repr(length)).as_integer_ratio()
    return numbers if max(numbers) < EXACT else (0, 0)


def _table(
    scene: Scene, knowledge: Any, result: Result, measures: Collection[str]
) -> tuple[dict[str, Any] | None, Mapping[str, Mapping[str, float]]]:
    """The reference table of the scene's name, if there is one, and the parameters of its conditions."""
    if scene.name not in table_files() or not hasattr(knowledge, "conditions"):
        return None, {}
    table = load_table(scene.name)
    conditions = knowledge.conditions(result, list(dict.fromkeys(row.condition for row in table.rows)))
    rows = [
        {"quantity": r.quantity, "measure": r.measure, "condition": r.condition, "unit": r.unit, "low": r.low, "high": r.high,
         "standing": r.standing, "source": r.source}
        for r in table.rows
        if r.measure in measures and r.condition in conditions
    ]  # fmt: skip
    return {"title": table.title, "rows": rows, "conditions": {n: dict(v) for n, v in conditions.items()}}, conditions
