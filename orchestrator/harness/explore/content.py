"""What a page that computes a scene holds, as plain data beside the modules."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Protocol

from ....components.core.errors import BadInput, nearest, pick
from ....components.core.measure import number_in
from ....fmus.native.build import Library
from ....fmus.native.variables import NativeVariable
from ...derivatives.along import AGREE, ALONG
from ...derivatives.gradient import BESIDE, CLOSE, COUNTS, SAID
from ...run.comparison import SURE, UNSURE
from ...run.run import run
from ...run.thresholds import HARDLY, NO_MATTER, NOTHING, ORDER_UNSURE
from ...scene.names import numerical_of
from ...scene.scene import Scene
from ...scene.shorter_steps import refined
from ...scene_fmu import refuse_what_needs_python
from ...settings.explore import ENDS
from ..preferred_units import choices
from ..validation.reference import STANDINGS, load_table, table_files
from .figures import LiveFigure, figures_of_study, filters
from .modules import Variant, switches, variants
from .screening import screened

if TYPE_CHECKING:
    from ...run.results import Result
    from ..charts.motion import Kinematics

FACTORS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # macro steps that a page offers, over the scene's
FEWEST = 20  # macro steps of a run
NUMERICAL = (
    "*.substep",
    "*.tolerance",
    "*.front_threshold",
)  # parameters that no slider is offered for: accuracy has its own place
FIRST = 8  # parameters with a slider, where the user names none
SPAN = 0.5  # of its value, to either side: a slider's range where none is given
EXACT = 2**53


class Knowledge(Protocol):
    """What a system knows of its pages, all of it optional: the attributes of its module `explore`."""

    def figures(self, result: Result) -> Sequence[LiveFigure]:
        """Its figures, for a run of the scene."""

    def conditions(self, result: Result, names: Iterable[str]) -> Mapping[str, Mapping[str, float]]:
        """Condition of a reference table -> the parameters that say so."""


ERROR = {  # by which the page tells the error of a number
    "sure": SURE,
    "unsure": UNSURE,
    "limit": ORDER_UNSURE,
    "hardly": HARDLY,
    "nothing": NOTHING,
    "no_matter": NO_MATTER,
}
# by which the page tells whether a derivative holds
SLOPE = {"along": ALONG, "agree": AGREE, "beside": BESIDE, "close": CLOSE, "said": SAID, "counts": COUNTS}


@dataclass(frozen=True)
class Content:
    """The data of a page, and by the number of their variant the modules, and those of their derivatives, empty where there are none."""

    data: Mapping[str, Any]
    modules: Sequence[bytes]
    tangents: Sequence[bytes]


def content_of(
    scene: Scene,
    knowledge: Any,
    *,
    moves: Callable[[Result], Iterable[Kinematics]] = lambda result: (),
    parameters: Mapping[str, tuple[float, float] | None] | None = None,
    effects: Sequence[str] | None = None,
    jobs: int | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> Content:
    """Compile a scene for a page. moves: the pictures of machines in motion that its system makes of a run.

    parameters: "unit.parameter" -> range of its slider, None for the usual one.  effects: "unit.effect" that can be switched.
    Both by default those of the scene's table [explore], and without them those that move the figures most, and those without
    which the scene runs.
    say: is told what is being done.  Raises `BadInput`.
    """
    refuse_what_needs_python(scene)
    if scene.start_time:
        raise BadInput(f"{scene.name}: start_time", f"{scene.start_time:g} s", "0; a live page starts there")
    table = scene.explore
    scene = scene.with_changes({"record.interval": None})
    say("running the scene once")
    result = run(scene, in_process=True).unless_stopped()
    machines = list(moves(result)) if result.time.size > 1 else []
    arrays = {name: result.snapshots[name].values.shape[1] for m in machines for name in m.snapshots.values()}
    elements = [f"{name}[{k}]" for name, size in arrays.items() for k in range(1, size + 1)]
    recorded = scene.with_changes({"record.signals": [*scene.record.signals, *elements]}) if scene.record.signals else scene
    switched = switches(scene, table.effects if effects is None else effects, say)
    offered = table.parameters if parameters is None else parameters
    built = list(variants(recorded, switched, table.algorithms, say, slopes=offered is None or bool(offered)))
    numbers = {v.scalar.name: v for v in _numbers(built[0].library, "PARAMETER")}
    if parameters is None and table.parameters is not None:
        parameters = {name: _ends(scene, name, given, numbers) for name, given in table.parameters.items()}
    rows = _rows(scene, numbers, parameters or {})
    names = [row["name"] for row in rows]
    if parameters is None:
        say("finding the parameters that move the figures most")
    first = list(parameters) if parameters is not None else _most_moving(scene, rows, getattr(knowledge, "FIXED", ()), jobs)
    steps = _steps(scene)
    figures = tuple(getattr(knowledge, "figures", lambda result: ())(result)) or figures_of_study(scene)
    reference, conditions = _table(scene, knowledge, result, {f.measure for f in figures if f.measure})
    presets = [{"name": name, "values": dict(values)} for name, values in conditions.items()]
    presets += [_preset(scene, name, given, built, numbers, steps) for name, given in table.presets.items()]
    data = {
        "name": scene.name,
        "title": scene.title or scene.name,
        "stop": scene.stop_time,
        "step": scene.master.step,
        "steps": [s | {"filters": filters(figures, s["length"]), "coarse": filters(figures, 2.0 * s["length"])} for s in steps],
        "variants": [_references(v) for v in built],
        "effects": _described_effects(scene, built),
        "algorithms": list(dict.fromkeys(v.algorithm for v in built)),
        "extrapolation": scene.master.extrapolation,
        "parameters": sorted(rows, key=lambda row: first.index(row["name"]) if row["name"] in first else len(first)),
        "first": first,
        "signals": [_signal(v) for v in _numbers(built[0].library, "OUTPUT") if v.scalar.name not in elements],
        "snapshots": elements,
        "machines": [m for machine in machines if (m := machine.formulas(result, names))],
        "refined": sorted(refined(scene, 1.0)),  # what is halved with the macro step, as by the command
        "figures": [f.to_json() for f in figures],
        "table": reference,
        "presets": presets,
        "settings": {key: value for key, value in scene.settings().items() if key != "explore"},
        "error": ERROR,
        "standings": STANDINGS,
        "slope": SLOPE | {"refused": _refused(scene, built[0], names)},
    }
    return Content(data, [v.library.binaries["wasm32"] for v in built], [v.tangents for v in built])


def _refused(scene: Scene, variant: Variant, names: Sequence[str]) -> dict[str, str]:
    """The parameters that no derivative is taken by, with the reason."""
    if variant.refused:
        return dict.fromkeys(names, variant.refused)
    unknown = {name: "not a real parameter in use" for name in names if name not in variant.known}
    return unknown | numerical_of(scene, names)


def _rows(
    scene: Scene, numbers: Mapping[str, NativeVariable], ranges: Mapping[str, tuple[float, float] | None]
) -> list[dict[str, Any]]:
    """The parameters of the page; raises `BadInput` for a range of none of them."""
    described = [_parameter(v, ranges.get(name)) for name, v in numbers.items()]
    rows = [row for row in described if _acts(scene, row["name"], row["to"])]
    for name in ranges:
        pick(name, [row["name"] for row in rows], "explore", "a real parameter that is not structural", "parameter")
    return rows


def _most_moving(scene: Scene, rows: Sequence[Mapping[str, Any]], fixed: Sequence[str], jobs: int | None) -> list[str]:
    """The parameters that move the figures most."""
    limits = {r["name"]: (-inf if r["low"] is None else r["low"], inf if r["high"] is None else r["high"]) for r in rows}
    ranked = screened(scene, {row["name"]: row["value"] for row in rows}, limits, jobs)
    return [name for name in ranked if not _is_any(name, (*NUMERICAL, *fixed))][:FIRST]


def _signal(variable: NativeVariable) -> dict[str, Any]:
    scalar = variable.scalar
    counts = scalar.type != "Real"
    return {
        "name": scalar.name,
        "unit": scalar.unit or "1",
        "choices": choices(scalar.unit or "1", scalar.name),
        "text": scalar.text,
        "nominal": scalar.nominal,
        "counts": counts,
    }


def _number(scene: Scene, name: str, value: Any, numbers: Mapping[str, NativeVariable], where: str) -> float:
    """The number of a parameter of the page, of a text such as "250 km/h" in the parameter's unit; within its limits."""
    pick(name, numbers, f"{scene.name}: {where}", "a real parameter that is not structural", "parameter")
    scalar = numbers[name].scalar
    place = f"{scene.name}: {where}.{name}"
    number = number_in(value, scalar.unit or "1", place) if isinstance(value, str) else value
    if isinstance(number, bool) or not isinstance(number, int | float) or not scalar.low <= number <= scalar.high:
        raise BadInput(place, repr(value), f"a number in {scalar.unit or '1'} from {scalar.low:g} to {scalar.high:g}")
    return float(number)


def _ends(scene: Scene, name: str, given: Mapping[Any, Any], numbers: Mapping[str, NativeVariable]) -> tuple[float, float] | None:
    """The ends of a slider's range; None for the usual ones."""
    if not given:
        return None
    low, high = (_number(scene, name, given[end], numbers, "explore.parameters") for end in ENDS)
    return low, high


def _preset(
    scene: Scene,
    name: str,
    given: Mapping[str, Any],
    built: Sequence[Variant],
    numbers: Mapping[str, NativeVariable],
    steps: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """A state of the page: values of parameters, effects that are off, and settings of the master where the preset has some."""
    where = f"explore.presets.{name}"
    preset: dict[str, Any] = {"name": name, "values": {}}
    choices = {
        "master.step": [step["length"] for step in steps],
        "master.algorithm": [v.algorithm for v in built],
        "master.extrapolation": sorted(built[0].extrapolations),
    }
    for key, value in given.items():
        unit, rest = scene.split(key)
        if key in choices:
            if value not in choices[key]:
                offered = ", ".join(f"{choice}" for choice in dict.fromkeys(choices[key]))
                raise BadInput(f"{scene.name}: {where}.{key}", repr(value), f"one that the page offers: {offered}")
            preset[key.partition(".")[2]] = value
        elif rest.startswith("effects."):
            effect = f"{unit}.{rest.removeprefix('effects.')}"
            if effect not in built[0].effects or not isinstance(value, bool):
                raise BadInput(
                    f"{scene.name}: {where}",
                    f"{key} = {value!r}",
                    "true or false for an effect that the page offers",
                    nearest(effect, list(built[0].effects)),
                )
            preset.setdefault("effects", {})[effect] = value
        else:
            preset["values"][key] = _number(scene, key, value, numbers, where)
    return preset


def _acts(scene: Scene, name: str, value: float) -> bool:
    """Whether the scene takes another value of a parameter: one that would have no effect is refused."""
    unit, parameter = scene.split(name)
    try:
        scene.with_changes({f"{unit}.{parameter}": value})
    except BadInput:
        return False
    return True


def _is_any(name: str, patterns: Collection[str]) -> bool:
    return any(name.endswith(p.removeprefix("*")) for p in patterns)


def _numbers(library: Library, role: str) -> list[NativeVariable]:
    """Outputs; or what is set before a run and is no element of an array: parameters, and inputs that nothing drives."""
    roles = ("OUTPUT",) if role == "OUTPUT" else ("PARAMETER", "INPUT")
    return [
        v
        for v in library.variables
        if v.role in roles and (role == "OUTPUT" or (v.scalar.type == "Real" and v.size == 1 and "[" not in v.scalar.name))
    ]


def _references(variant: Variant) -> dict[str, Any]:
    places = {v.scalar.name: k for k, v in enumerate(variant.library.variables)}
    named = {
        role: {v.scalar.name: places[v.scalar.name] for v in _numbers(variant.library, role)} for role in ("PARAMETER", "OUTPUT")
    }
    return {
        "effects": variant.effects,
        "algorithm": variant.algorithm,
        "extrapolations": variant.extrapolations,
        "token": variant.library.token,
        "parameters": named["PARAMETER"],
        "outputs": named["OUTPUT"],
    }


def _described_effects(scene: Scene, variants: Sequence[Variant]) -> list[dict[str, str]]:
    described = []
    for name in variants[0].effects:
        unit, _, effect = name.rpartition(".")
        text = scene.component_classes[unit].effects[effect].__doc__ or ""
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
        "choices": choices(s.unit or "1", s.name),
        "text": s.text,
    }


def _steps(scene: Scene) -> list[dict[str, Any]]:
    """Macro steps that the run is a whole number of: length, s, and the same as whole numbers, 0 where there are none."""
    steps = []
    for factor in FACTORS:
        length = float(f"{factor * scene.master.step:.12g}")
        count = scene.stop_time / length
        if abs(count - round(count)) < 1e-9 * count and round(count) >= FEWEST:
            steps.append(
                {"length": length, "exact": _whole(length), "half": _whole(0.5 * length), "quarter": _whole(0.25 * length)}
            )
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
