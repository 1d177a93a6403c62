"""The layout of a line from its table, with what it leaves out from the parameters of `Catenary`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ...core.errors import BadInput
from .layout import SAID_BY_A_PARAMETER, SECOND, Droppers, Holds, Layout, Stretch, Wire, columns
from .table import MOST_DROPPERS, MOST_SPANS, Dropper, DropperData, Line, Section, Span, Stitch, Support, WireData, over

FIRST, GAP = 5.0, 6.5  # m, from the EN 50318:2002 reference model
NOT_AT_ANCHORS = ("stiffness", "damping", "held", "contact_stiffness", "arm", "stitch")
SYSTEM_HEIGHT = 1.2  # m, of that model, from memory


@dataclass(frozen=True)
class Resolved:
    """A section with all of its spans and supports, nothing left out. x: positions of the supports, (s,) m."""

    name: str
    section: Section
    spans: tuple[Span, ...]
    supports: tuple[Support, ...]
    x: np.ndarray


def resolved_sections(line: Line, where: str = "line") -> tuple[Resolved, ...]:
    """All sections with their spans and supports in place."""
    sections: list[Resolved] = []
    end = 0.0
    for i, section in enumerate(line.sections, 1):
        at = f"{where}.sections[{i}]"
        spans = tuple(_repeated(section, at))
        if not spans:
            raise BadInput(f"{at}.spans", "none", "at least one span", "Write spans = [length, ...].")
        if section.supports and len(section.supports) != len(spans) + 1:
            raise BadInput(f"{at}.supports", f"{len(section.supports)} for {len(spans)} spans", f"{len(spans) + 1}, or none")
        base = Support(
            contact_height=0.0,
            system_height=SYSTEM_HEIGHT,
            contact_stiffness=0.0,
            stagger=0.0,
            held=False,
            stitch=Stitch(half_length=0.0),
        )
        for k in (1, len(section.supports)):
            if ignored := [n for n in NOT_AT_ANCHORS if section.supports and _says(getattr(section.supports[k - 1], n))]:
                raise BadInput(
                    f"{at}.supports[{k}].{ignored[0]}",
                    "this key has no effect at an anchor, where both wires are fixed",
                    "",
                    "Remove it, or set it for a support between the first and the last.",
                )
        for key, wire in (("second_contact_wire", "second contact wire"), ("auxiliary", "auxiliary wire")):
            if getattr(section, key).tension is None and _says(getattr(section, key)):
                raise BadInput(f"{at}.{key}", "no tension", f"the tension of the {wire}")
        given = section.supports or (Support(),) * (len(spans) + 1)
        for k, support in enumerate(given, 1):
            own = over(support, section.support, Support(stitch=section.stitch))
            for part, key in (("arm", "length"), ("stitch", "half_length")):
                if _says(inside := getattr(own, part)) and getattr(inside, key) is None:
                    raise BadInput(f"{at}.supports[{k}].{part}", f"no {key}", f"its {key}", f"Without it there is no {part}.")
        supports = tuple(over(s, section.support, Support(stitch=section.stitch), base) for s in given)
        start = end if section.start is None else section.start
        if i == 1 and start != 0.0:
            raise BadInput(f"{at}.start", f"{start:g} m", "0 for the first section: positions count from its first support")
        x = start + np.concatenate(([0.0], np.cumsum([s.length for s in spans])))
        if sections and not sections[-1].x[0] <= x[0] <= sections[-1].x[-1]:
            raise BadInput(f"{at}.start", f"{x[0]:g} m", f"a position in section {i - 1}, up to {sections[-1].x[-1]:g} m")
        if len(sections) > 1 and x[0] < sections[-2].x[-1]:
            raise BadInput(f"{at}.start", f"{x[0]:g} m", f"at least {sections[-2].x[-1]:g} m: a third contact wire has no place")
        sections.append(Resolved(at, section, spans, supports, x))
        end = float(x[-1])
    return tuple(sections)


def _says(value: Any) -> bool:
    """Whether a table says something, or a key has a value."""
    return any(_says(getattr(value, f.name)) for f in fields(value)) if is_dataclass(value) else value is not None


def support_positions(line: Line) -> np.ndarray:
    """Positions of all supports, (s,) m."""
    return np.unique(np.concatenate([s.x for s in resolved_sections(line)]).round(9))


def _repeated(section: Section, where: str) -> Iterator[Span]:
    total = 0
    for k, span in enumerate(section.spans, 1):
        full = over(span, section.span)
        if full.length is None:
            raise BadInput(f"{where}.spans[{k}]", "no length", "a length in m")
        count = full.repeat or 1.0
        if not float(count).is_integer():
            raise BadInput(f"{where}.spans[{k}].repeat", f"{count:g}", "a whole number")
        total += int(count)
        if total > MOST_SPANS:
            raise BadInput(f"{where}.spans", f"more than {MOST_SPANS} spans", "fewer")
        yield from (replace(full, repeat=None) for _ in range(int(count)))


def lay_out(line: Line, bending: bool) -> Layout:
    """Layout of a line, with NaN where a parameter of `Catenary` decides; bending: whether the wires have bending stiffness."""
    sections = resolved_sections(line)
    reference = line.reference_height
    if reference is None:
        reference = sections[0].supports[0].contact_height
    two = any(s.section.second_contact_wire.tension is not None for s in sections)
    if two and len(sections) > 1:
        raise BadInput(
            "line.sections",
            "two contact wires in a line of several sections",
            "one section",
            "Overlaps of sections with two contact wires each are not modelled: a head would touch four wires.",
        )
    stitched = any(support.stitch.half_length for s in sections for support in s.supports[1:-1])
    compound = any(s.section.auxiliary.tension is not None for s in sections)
    beside = min(len(sections), 2)  # sections that a place may have
    contacts = 2 if two or beside > 1 else 1
    first_stitch = {(False, 1): 2, (True, 1): 3, (False, 2): 4}[two, beside]
    first_auxiliary = first_stitch + (beside if stitched else 0)
    lanes = first_auxiliary + (beside if compound else 0)
    wires: list[Any] = []
    droppers: list[Any] = []
    holds: list[Any] = []
    lateral: list[Any] = []
    for i, s in enumerate(sections):
        lane, side = SECOND * (i % 2), i % 2
        parts = _Section(s, bending, reference, (lane, lane + 1, first_stitch + side, first_auxiliary + side), len(wires))
        wires += parts.wires()
        droppers += parts.droppers()
        holds += parts.holds()
        lateral += parts.lateral()
    droppers.sort(key=lambda d: d[:2])
    if not droppers:
        raise BadInput("line.sections", "no dropper", "at least one")
    rows = Droppers(**_by_column(Droppers, droppers, "lower", "upper"))
    springs = Holds(**_by_column(Holds, holds, "lane", "wire"))
    supports = np.unique(np.concatenate([s.x for s in sections]).round(9))
    contact_lanes = tuple(range(0, 2 * contacts, 2))
    between = tuple(range(first_auxiliary, lanes))
    return Layout(
        lanes, supports, tuple(wires), rows, springs, contact_lanes, between, np.array(lateral).reshape(-1, 5), reference
    )


def _by_column(kind: type, rows: list[tuple[float, ...]], *whole: str) -> dict[str, np.ndarray]:
    """Fields of `Holds` or `Droppers` from rows in their order; whole: those that are integers."""
    names = [f.name for f in fields(kind)]
    if not rows:
        return columns(kind, 0, **{name: np.zeros(0, int) for name in whole})
    given = zip(names, zip(*rows, strict=True), strict=True)
    return {name: np.array(column, dtype=int if name in whole else float) for name, column in given}


def unused_by(layout: Layout, names: Iterable[str]) -> list[str]:
    """Of some parameters those that a layout leaves no use for."""
    contact = [w for w in layout.wires if w.lane in layout.contact_lanes]
    upper = [w for w in layout.wires if w.lane not in layout.contact_lanes]
    d, h = layout.droppers, layout.holds
    values: dict[str, Any] = {
        "contact_wire_tension": [w.tension for w in contact],
        "contact_wire_mass": [w.mass for w in contact],
        "messenger_tension": [w.tension for w in upper],
        "messenger_mass": [w.mass for w in upper],
        "bending_stiffness.contact_wire": [w.bending for w in contact],
        "bending_stiffness.messenger": [w.bending for w in upper],
        "dropper_stiffness": np.where(d.axial_stiffness > 0.0, 0.0, d.stiffness),
        "dropper_mass": d.mass,
        "contact_clamp_mass": d.contact_clamp,
        "messenger_clamp_mass": d.messenger_clamp,
        "support_stiffness": h.stiffness,
        "support_damping": h.damping,
    }
    return [name for name in names if not np.isnan(values[name]).any()]


def dropper_positions(sections: tuple[Resolved, ...]) -> tuple[float, ...]:
    """Positions of the droppers of the first contact wires, in order, m."""
    base = DropperData(FIRST, GAP)
    return tuple(
        sorted(
            round(float(x + row.position), 9)
            for s in sections
            for k, (x, span) in enumerate(zip(s.x[:-1], s.spans, strict=True))
            for row in _droppers(
                span,
                over(span.droppers, s.section.droppers, base),
                1,
                f"{s.name}.spans[{k + 1}]",
                s.section.auxiliary.tension is not None,
            )
        )
    )


class _Section:
    """Wires, droppers and springs of one section in its lanes."""

    def __init__(self, s: Resolved, bending: bool, reference: float, lanes: tuple[int, int, int, int], first: int):
        """lanes: of contact wire, messenger, stitch wires and auxiliary wire; first: number of the section's first wire among all."""
        self.s, self.reference, self.first = s, reference, first
        self.contact, self.messenger, self.stitch, self.between = lanes
        left_out = WireData(SAID_BY_A_PARAMETER, SAID_BY_A_PARAMETER, SAID_BY_A_PARAMETER)
        self.wire, self.upper = over(s.section.contact_wire, left_out), over(s.section.messenger, left_out)
        self.second = over(s.section.second_contact_wire, self.wire) if s.section.second_contact_wire.tension else None
        if not bending:
            self.wire, self.upper = replace(self.wire, bending=0.0), replace(self.upper, bending=0.0)
            self.second = self.second and replace(self.second, bending=0.0)
        self.auxiliary = s.section.auxiliary if s.section.auxiliary.tension is not None else None
        if self.auxiliary is not None:
            for key in ("mass", "height"):
                if getattr(self.auxiliary, key) is None:
                    raise BadInput(f"{s.name}.auxiliary", f"no {key}", f"the {key} of the auxiliary wire")
        elif _says(s.section.main_droppers) or any(span.main_positions is not None for span in s.spans):
            remedy = "Give auxiliary a tension, a mass and a height, or leave out main_droppers and main_positions."
            raise BadInput(s.name, "droppers of an auxiliary wire that is not there", "an auxiliary wire", remedy)
        self.bending = bending
        self.z = np.array([support.contact_height for support in s.supports]) - reference
        self.stitches = [
            (x, support.stitch) for x, support in zip(s.x[1:-1], s.supports[1:-1], strict=True) if support.stitch.half_length
        ]
        for x, own_stitch in self.stitches:
            if own_stitch.tension is None or own_stitch.mass is None:
                raise BadInput(f"{s.name}.stitch", f"a stitch at {x:g} m without tension or mass", "both")
        reaches = [(x - t.half_length, x + t.half_length) for x, t in self.stitches]
        inside = all(a >= s.x[0] and b <= s.x[-1] for a, b in reaches)
        if not inside or any(b > a for (_, b), (a, _) in pairwise(reaches)):
            raise BadInput(f"{s.name}.stitch", "stitch wires that meet or leave the section", "shorter ones")

    def wires(self) -> list[Wire]:
        """Contact wires, messenger, auxiliary wire, stitch wires."""
        s, a, b = self.s, float(self.s.x[0]), float(self.s.x[-1])
        worn = tuple(
            Stretch(float(x), float(x + span.length), 1.0 - span.wear)
            for x, span in zip(s.x[:-1], s.spans, strict=True)
            if span.wear
        )
        ends = (float(self.z[0]), float(self.z[-1]))
        tops = ends[0] + s.supports[0].system_height, ends[1] + s.supports[-1].system_height
        less = tuple(Stretch(x - t.half_length, x + t.half_length, -t.tension) for x, t in self.stitches)
        w, m = self.wire, self.upper
        wires = [
            Wire(self.contact, a, b, w.tension, w.mass, w.bending, ends, (), worn),
            Wire(self.messenger, a, b, m.tension, m.mass, m.bending, tops, less),
        ]
        if self.second is not None:
            w = self.second
            wires.append(Wire(SECOND, a, b, w.tension, w.mass, w.bending, ends, (), worn))
        if self.auxiliary is not None:
            own, above = self.auxiliary, self.auxiliary.height
            EI = own.bending or 0.0 if self.bending else 0.0
            wires.append(Wire(self.between, a, b, own.tension, own.mass, EI, (ends[0] + above, ends[1] + above)))
        wires += [
            Wire(self.stitch, x - t.half_length, x + t.half_length, t.tension, t.mass, 0.0, clamped_to=self.messenger)
            for x, t in self.stitches
        ]
        return wires

    def droppers(self) -> list[tuple[float, ...]]:
        """Rows in the order of the fields of `Droppers`."""
        clamp = SAID_BY_A_PARAMETER
        base = DropperData(FIRST, GAP, None, None, None, None, clamp, clamp)
        rows: list[tuple[float, ...]] = []
        for k, (x, span) in enumerate(zip(self.s.x[:-1], self.s.spans, strict=True)):
            where = f"{self.s.name}.spans[{k + 1}]"
            contact = over(span.droppers, self.s.section.droppers, base)
            main = over(self.s.section.main_droppers, base)
            for number, lane, d in self._rows(contact, main):
                own = _droppers(span, d, number, where, self.auxiliary is not None)
                at = np.array([row.position for row in own])
                heights, sag = self._heights(k, span, at, where, number)
                for row, z in zip(own, heights.tolist(), strict=True):
                    one = over(row, Dropper(stiffness=d.stiffness, axial_stiffness=d.axial_stiffness))
                    per_length = 0.0 if row.mass is not None else d.mass_per_length or 0.0
                    place, depth = float(x + row.position), sag
                    if row.height is not None or row.cut_length is not None:
                        z, depth = (math.nan if row.height is None else row.height - self.reference), 0.0
                    rows.append(
                        (
                            round(place, 9),
                            lane,
                            self._hangs_from(place, row, where, number),
                            _first(one.stiffness, SAID_BY_A_PARAMETER),
                            one.axial_stiffness or 0.0,
                            _first(row.mass, d.mass, 0.0 if per_length else SAID_BY_A_PARAMETER),
                            per_length,
                            _first(row.contact_clamp, d.contact_clamp),
                            _first(row.messenger_clamp, d.messenger_clamp),
                            z,
                            depth,
                            row.position,
                            at[0],
                            at[-1],
                            *(_first(value, math.nan) for value in (row.cut_length, row.length, row.preload)),
                        )
                    )
            if self.second is None and any(row.contact_wire == 2 for row in span.dropper_list or ()):
                raise BadInput(
                    f"{where}.dropper_list", "there is no second contact wire", "", "Give second_contact_wire a tension."
                )
            if self.second is None and span.second_positions is not None:
                raise BadInput(
                    f"{where}.second_positions", "there is no second contact wire", "", "Give second_contact_wire a tension."
                )
        return rows

    def _rows(self, contact: DropperData, main: DropperData) -> Iterator[tuple[int, int, DropperData]]:
        """Number of the contact wire, 0 for an auxiliary wire, its lane, and what its droppers have."""
        yield 1, self.contact, contact
        if self.second is not None:
            yield 2, SECOND, contact
        if self.auxiliary is not None:
            yield 0, self.between, main

    def _hangs_from(self, x: float, row: Dropper, where: str, number: int) -> int:
        if self.auxiliary is not None and number > 0:
            if row.hangs_from not in ("", "auxiliary"):
                raise BadInput(where, f"a dropper of the contact wire at {x:g} m that hangs from {row.hangs_from!r}", "auxiliary")
            return self.between
        under = any(abs(x - support) < t.half_length - 1e-6 for support, t in self.stitches)
        if row.hangs_from not in ("", name := "stitch" if under else "messenger"):
            raise BadInput(where, f"a dropper at {x:g} m that hangs from {row.hangs_from!r}", name, "Leave it out.")
        return self.stitch if under else self.messenger

    def _heights(self, k: int, span: Span, at: np.ndarray, where: str, number: int) -> tuple[np.ndarray, float]:
        """Heights of the clamps at rest, (n,) m, less a parabola of a depth, m; number: of the contact wire, or 0."""
        if number == 0 and self.auxiliary is not None:
            return self.z[k] + (self.z[k + 1] - self.z[k]) * at / span.length + self.auxiliary.height, 0.0
        if span.heights is not None:
            if len(span.heights) != at.size:
                raise BadInput(f"{where}.heights", f"{len(span.heights)} for {at.size} droppers", "one for each dropper")
            return np.array(span.heights) - self.reference, 0.0
        chord = self.z[k] + (self.z[k + 1] - self.z[k]) * at / span.length
        return chord, _first(span.sag, (span.relative_sag or 0.0) * span.length) if at.size > 1 else 0.0

    def kinks(self) -> np.ndarray:
        """By how much the line of the lateral positions turns at each support, (s,): 0 at the anchors."""
        b, L = np.array([support.stagger for support in self.s.supports]), np.diff(self.s.x)
        slopes = np.diff(b) / L
        return np.concatenate(([0.0], slopes[:-1] - slopes[1:], [0.0]))

    def holds(self) -> list[tuple[float, ...]]:
        """Rows in the order of the fields of `Holds`."""
        rows: list[tuple[float, ...]] = []
        kinks, no_arm = self.kinks(), (0.0, 0.0, 0.0, 0.0, self.first)
        lanes = [self.contact] if self.second is None else [self.contact, SECOND]
        for k in range(1, len(self.s.supports) - 1):
            x, support = round(float(self.s.x[k]), 9), self.s.supports[k]
            rows.append(
                (
                    x,
                    self.messenger,
                    _first(support.stiffness, SAID_BY_A_PARAMETER),
                    _first(support.damping, SAID_BY_A_PARAMETER),
                    0.0,
                    0.0,
                    self.z[k] + support.system_height,
                    *no_arm,
                )
            )
            height = self.z[k] if support.held else math.nan
            arm = support.arm
            angle = math.nan if arm.angle is None else math.radians(arm.angle)
            own = (arm.length or 0.0, angle, arm.mass or 0.0, kinks[k], self.first)
            rows += [(x, lane, support.contact_stiffness, 0.0, 0.0, 0.0, height, *own) for lane in lanes]
        return rows

    def lateral(self) -> list[tuple[float, ...]]:
        """Rows of contact wire, position, stagger, kink, wire whose tension pulls."""
        wires = [self.contact // 2] if self.second is None else [0, 1]
        return [
            (wire, float(x), support.stagger, float(kink), self.first)
            for wire in wires
            for x, support, kink in zip(self.s.x, self.s.supports, self.kinks(), strict=True)
        ]


def _droppers(span: Span, d: DropperData, wire: int, where: str, compound: bool = False) -> list[Dropper]:
    """Droppers of a wire in a span, one by one; wire: number of the contact wire, or 0 for the auxiliary wire of a compound line."""
    if span.dropper_list is None:
        key = ("main_positions", "positions", "second_positions")[wire]
        return [Dropper(position=float(x)) for x in _positions(getattr(span, key), span, d, where, key)]

    def carried(row: Dropper) -> float:
        main = compound and row.hangs_from in ("messenger", "stitch") and row.contact_wire is None
        return 0 if main else row.contact_wire or 1

    own = [row for row in span.dropper_list if carried(row) == wire]
    if any(row.position is None for row in own):
        raise BadInput(f"{where}.dropper_list", "a dropper without position", "its position, m")
    _positions(tuple(row.position for row in own), span, d, where, "dropper_list")
    return own


def _positions(given: tuple[float, ...] | None, span: Span, d: DropperData, where: str, key: str) -> np.ndarray:
    if given is None:
        room = span.length - 2.0 * d.first
        if room < 0.0:
            raise BadInput(where, f"a length of {span.length:g} m", f"more than twice the {d.first:g} m of the first dropper")
        count = math.ceil(room / d.gap - 1e-9) + 1
        if count > MOST_DROPPERS:
            raise BadInput(where, f"{count} droppers {d.gap:g} m apart", f"at most {MOST_DROPPERS} in a span", "Enlarge gap.")
        return d.first + np.linspace(0.0, room, count)
    at = np.array(given)
    if at.size and not (np.all(np.diff(at) > 1e-3) and at[0] > 1e-3 and at[-1] < span.length - 1e-3):
        raise BadInput(f"{where}.{key}", f"{list(given)}", f"increasing positions inside the span of {span.length:g} m")
    return at


def _first(*values: Any) -> Any:
    return next((v for v in values if v is not None), None)
