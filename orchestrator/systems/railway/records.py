"""What of a run of pantographs under a catenary goes into the statistics, found by the scene's connections."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput
from ....components.railway.hung_line import HungLine
from ....components.railway.line.dropper_table import line_of
from ....components.railway.line.from_table import dropper_positions, resolved_sections
from ...harness.analysis.signals import ButterworthFilter
from . import RailwayKeys
from .contact import ContactRecord, ContactStatistics

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene


@dataclass(frozen=True)
class Passage:
    """One pantograph of a run. supports: position in m of each uplift in `record.uplifts`.

    part: "one wire alone" of two, or "one strip alone"; where it loses contact, the other may carry the current. "" of a whole.
    """

    pantograph: str
    catenary: str
    speed: float  # m/s
    record: ContactRecord
    supports: tuple[float, ...]
    part: str = ""


@dataclass(frozen=True)
class Track:
    """What lies along the track, as the catenary of a run has it. droppers: positions in m, of a uniform line in its first span.

    supports: positions in m of a line from a table; empty for a uniform one, which has `span` instead, 0 for none.
    """

    span: float
    droppers: tuple[float, ...]
    supports: tuple[float, ...] = ()

    def support(self, number: int) -> float:
        """Position of a support, counted from 0, m; the last one beyond it."""
        return self.supports[min(number, len(self.supports) - 1)] if self.supports else self.span * number

    def supports_between(self, low: float, high: float) -> list[tuple[int, float]]:
        """Numbers and positions of the supports between two places, m."""
        if self.supports:
            return [(i, x) for i, x in enumerate(self.supports) if low - 1e-9 <= x <= high + 1e-9]
        if not self.span:
            return []
        numbers = np.arange(np.ceil(low / self.span - 1e-9), np.floor(high / self.span + 1e-9) + 1)
        return [(round(i), float(i * self.span)) for i in numbers]

    @property
    def dropper_spacing(self) -> float:
        """The commonest distance of neighbouring droppers, m; NaN without any."""
        if len(self.droppers) < 2:
            return float("nan")
        values, counts = np.unique(np.diff(self.droppers).round(3), return_counts=True)
        return float(values[np.argmax(counts)])


def track_of(result: Result) -> Track:
    """Of the catenary above the foremost pantograph, by the parameters that the run had."""
    run_of = passages(result)
    return _track(result.info.units[run_of[0].catenary].parameters if run_of else {})


def _track(values: Mapping[str, Any]) -> Track:
    """Of the parameters of a catenary."""
    if "line_table.table" in values:
        sections = resolved_sections(line_of(values))
        supports = np.unique(np.concatenate([s.x for s in sections]).round(9))
        return Track(float(np.median(np.diff(supports))), dropper_positions(sections), tuple(supports.tolist()))
    count = int(values.get("droppers", 0))
    return Track(float(values.get("span_length", 0.0)), tuple(float(values[f"dropper_position[{i + 1}]"]) for i in range(count)))


def analysis_window(result: Result) -> tuple[float, float]:
    """The window of analysis, m along the track: the scene's spans of the catenary of the run, or what it gives in m."""
    return _window(result.scene.analysis_as(RailwayKeys), result.scene.name, lambda: track_of(result))


def _window(keys: RailwayKeys, scene: str, track_of: Callable[[], Track]) -> tuple[float, float]:
    if keys.window is not None:
        return keys.window
    if keys.spans is None:
        raise BadInput(
            f"{scene}: analysis.spans",
            "nothing",
            "the first and the last span for the statistics",
            "Add spans = [first, last] to [analysis], or window = [from, to] in m.",
        )
    track = track_of()
    if not track.span > 0.0:
        raise BadInput(
            f"{scene}: analysis.spans",
            f"[{keys.spans[0]}, {keys.spans[1]}]",
            "a catenary with a parameter span_length",
            "Give window = [from, to] in m instead.",
        )
    first, last = keys.spans
    return track.support(first - 1), track.support(last)


def check_window(scene: Scene, keys: RailwayKeys) -> None:
    """Refuse a window that the pantographs of a scene do not pass, as far as their parameters tell; one that gains speed does not."""
    for link in scene.coupling.links:
        (source, _), (unit, name) = link.source, link.target
        if name != "wire_height" or (keys.spans is None and keys.window is None):
            continue
        pantograph, catenary = _parameters(scene, unit), _parameters(scene, source)
        if not {"start_position", "speed"} <= pantograph.keys() or "acceleration.rate" in pantograph or not catenary:
            continue
        speed = float(pantograph["speed"])
        begin = float(pantograph["start_position"]) + speed * scene.start_time
        way = speed * np.array([scene.duration, 2.0 * scene.master.step])
        low, high = _window(keys, scene.name, lambda values=catenary: _track(values))  # type: ignore[misc]
        if begin > low or begin + way[0] < high - way[1]:
            raise BadInput(
                f"{scene.name}: analysis.{'window' if keys.spans is None else 'spans'}",
                f"from {low:g} to {high:g} m, where {unit} runs from {begin:g} to {begin + way[0]:g} m",
                "a window within the run",
                "Lengthen the run or move the window.",
            )


def _parameters(scene: Scene, unit: str) -> Mapping[str, Any]:
    """Of a component of a scene; none of another unit."""
    if unit not in scene.units or (cls := scene.kinds[unit].component_class) is None:
        return {}
    settings = scene.units[unit]
    return cls(settings.effects, settings.parameters, preset=settings.preset, name=unit).parameters


def wave_speed(result: Result, catenary: str) -> float | None:
    """Lowest wave speed of the contact wires, m/s, as the line of a run has them; None where the unit does not say.

    catenary: the unit, or an effect of it behind its name.
    """
    unit, _ = result.scene.split(f"{catenary}.")
    cls, values = result.scene.kinds[unit].component_class, result.info.units[unit].parameters
    if cls is not None and "line_table.table" in values:
        settings = result.scene.units[unit]
        line = cls(settings.effects, settings.parameters, preset=settings.preset, name=unit)
        assert isinstance(line, HungLine)
        layout = line.form().layout
        return min(math.sqrt(w.tension / (w.mass * w.least_worn)) for w in layout.wires if w.lane in layout.contact_lanes)
    if "contact_wire_tension" not in values or "line_table.table" in values:
        return None
    return math.sqrt(float(values["contact_wire_tension"]) / float(values["contact_wire_mass"]))


SECOND = ".second_wire"  # behind the name of a pantograph: what it does on a second contact wire
LATERAL = "stagger.lateral_position"  # of a catenary: where its first contact point is across the track
STRIPS = ".two_strips"  # behind the name of a pantograph: its rear strip


@dataclass(frozen=True)
class Contact:
    """A unit that a wire's height is connected to. source: the output that gives it.  needed: what a record of it is made of."""

    unit: str
    source: str
    needed: tuple[str, str, str]  # force, position, height


def contacts(scene: Scene, recorded: Collection[str]) -> list[Contact]:
    """The contacts of which all is recorded. Raises `BadInput` where a part of a collector's force is missing."""
    recorded_ones, left_out = [], {}
    for source, target in scene.ends:
        unit, _, name = target.rpartition(".")
        if name != "wire_height":
            continue
        needed = (f"{unit}.contact_force", f"{unit.removesuffix(SECOND)}.contact_position", source)
        if missing := [n for n in needed if n not in recorded]:
            left_out[unit] = missing
        else:
            recorded_ones.append(Contact(unit, source, needed))
    names = {contact.unit for contact in recorded_ones}
    for unit, missing in left_out.items():
        if names & {unit.removesuffix(SECOND), unit.removesuffix(STRIPS), unit + SECOND, unit + STRIPS}:
            raise BadInput(
                f"{scene.name}: record.signals",
                f"no {' and no '.join(missing)}",
                "all of a collector's force, which is judged as a whole",
                "Add it, or leave out [record].",
            )
    return recorded_ones


def whole_collectors(scene: Scene) -> tuple[str, ...]:
    """Names of the passages that a run of the scene will have and that are judged: of strips and wires the sums."""
    names = [contact.unit for contact in contacts(scene, {".".join(end) for end in scene.coupling.signals})]
    for part, whole in ((SECOND, ".both_wires"), (STRIPS, ".both_strips")):
        for first in [n.removesuffix(part) for n in names if n.endswith(part) and n.removesuffix(part) in names]:
            names = [n for n in names if n not in (first, first + part)] + [first + whole]
    return tuple(names)


def of_each(result: Result, numbers: Callable[[int], Mapping[str, float]]) -> dict[str, float]:
    """Numbers of the foremost pantograph by their names; of several those of each, too, with its name before them.

    numbers: of a passage by its place in `passages`.
    """
    whole = {p.pantograph: numbers(i) for i, p in enumerate(passages(result)) if not p.part}
    first = next(iter(whole.values()), {})
    return {**first, **({f"{name}.{n}": v for name, of in whole.items() for n, v in of.items()} if len(whole) > 1 else {})}


def check_contacts(scene: Scene) -> None:
    """Refuse a scene whose run has no passage to judge."""
    if not contacts(scene, {".".join(end) for end in scene.coupling.signals}):
        raise BadInput(
            f"{scene.name}: limits",
            "no pantograph on a catenary of which contact force, position and wire height are recorded",
            "one or more, which the table is about",
            "Name another table, or leave out [record].",
        )


def passages(result: Result) -> list[Passage]:
    """The pantographs of a run, foremost first: units whose contact force and wire height are recorded.

    One with two strips comes three times: with the sum of their forces, as EN 50317 judges it, then either strip. So does one on
    two contact wires: with the sum, at the lower wire's height, then on either wire.
    """
    all_passages = []
    for contact in contacts(result.scene, result.columns):
        force, position, height = (result.columns[n] for n in contact.needed)
        catenary = contact.source.rpartition(".")[0].removesuffix(SECOND)
        watched = [n for n in result.columns if n.startswith(f"{catenary}.support_uplift[")]
        speed = float((position[-1] - position[0]) / (result.time[-1] - result.time[0]))
        supports = _support_positions(result, catenary, watched)
        end = result.columns.get(f"{catenary}.moving_window.rear", np.zeros(result.time.size))
        uplifts = tuple(np.where(end <= x, result.columns[n], np.nan) for n, x in zip(watched, supports, strict=True))
        record = ContactRecord(result.time, position, force, height, uplifts)
        all_passages.append(Passage(contact.unit, catenary, speed, record, supports))
    named = {p.pantograph: p for p in all_passages}
    parts: dict[str, str] = {}
    for name, rear in named.items():
        if name.endswith(SECOND) and (first := named.get(name.removesuffix(SECOND))):
            height = np.minimum(first.record.height, rear.record.height)
            whole = replace(first.record, force=first.record.force + rear.record.force, height=height)
            all_passages.insert(0, replace(first, pantograph=f"{first.pantograph}.both_wires", record=whole))
            parts |= dict.fromkeys((name, first.pantograph), "one wire alone")
        if name.endswith(STRIPS) and (front := named.get(name.removesuffix(STRIPS))):
            whole = replace(front.record, force=front.record.force + rear.record.force)
            all_passages.insert(0, replace(front, pantograph=f"{front.pantograph}.both_strips", record=whole))
            parts |= dict.fromkeys((name, front.pantograph), "one strip alone")
    all_passages = [replace(p, part=parts.get(p.pantograph, "")) for p in all_passages]
    return sorted(all_passages, key=lambda p: -p.record.position[0])


def lateral_position(result: Result, passage: Passage) -> np.ndarray | None:
    """Of the contact wire at the contact point, (n,) m; None where it was not recorded."""
    return result.columns.get(f"{passage.catenary}.{LATERAL}")


def _support_positions(result: Result, catenary: str, watched: list[str]) -> tuple[float, ...]:
    if not watched:
        return ()
    values = result.info.units[catenary].parameters
    for name in ("span_length", "first_watched_support"):
        if name not in values:
            raise BadInput(
                f"units.{catenary}",
                f"no parameter {name!r}",
                "what tells where the supports of its uplifts are",
                f"Or do not record {catenary}.support_uplift.",
            )
    first, track = values["first_watched_support"], _track(values)
    return tuple(track.support(first + int(n[n.index("[") + 1 : -1]) - 1) for n in watched)


def statistics(result: Result, low_pass: ButterworthFilter | None = None, pantograph: int = 0) -> ContactStatistics:
    """Statistics of a pantograph (0: the foremost) over the scene's window; uplifts of the supports in it, ends included."""
    all_passages = passages(result)
    if not all_passages:
        raise BadInput(
            result.scene.name, "no recorded contact force with its wire height", "a run of a pantograph under a catenary"
        )
    passage = all_passages[pantograph]
    start, end = analysis_window(result)
    inside = [u for u, x in zip(passage.record.uplifts, passage.supports, strict=True) if start - 1e-6 <= x <= end + 1e-6]
    r = passage.record
    return ContactRecord(r.time, r.position, r.force, r.height, tuple(inside)).statistics((start, end), low_pass)


def measured(s: ContactStatistics) -> dict[str, float]:
    """Statistics under the names and in the units of the reference tables."""
    return {
        "mean": s.mean,
        "std": s.std,
        "statistical_max": s.statistical_max,
        "statistical_min": s.statistical_min,
        "max": s.max,
        "min": s.min,
        "std_0_5": s.std_0_5,
        "std_5_20": s.std_5_20,
        "loss_raw": s.loss_raw,
        "loss_filtered": s.loss_filtered,
        "arcs": float(len(s.arcs)),
        "arcing": s.arcing,
        "longest_arc_ms": 1e3 * max(s.arcs, default=0.0),
        "uplift_mm": 1e3 * s.max_uplift,
        "height_range_mm": 1e3 * s.height_range,
    }
