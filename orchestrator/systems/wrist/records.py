"""What of a run belongs to its wrists: hand and rows, postures with their row rule, muscles, ligaments, four-bar linkages.

    [analysis]
    system = "wrist"
    postures = [1.0, 2.5]   # s, instants at which the hand's posture is tabulated; without them, where its angles are largest

Units are found by the names of their outputs. The row rule is that of the abstract of Sandow (2020): both rows flex in flexion;
in radial deviation the proximal row flexes and the distal one extends; the reverse in the opposite motions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ....components.wrist.ligament_springs import LIGAMENTS
from ....components.wrist.tendons import MUSCLES
from ...harness.analysis.records import RecordedUnit, recorded_units

if TYPE_CHECKING:
    from ...run.results import Result

HAND = ("flexion", "deviation", "roll")
ROWS = ("proximal_flexion", "distal_flexion")
WRIST = (*HAND, *ROWS, "proximal_angle", "distal_angle")
LINKAGE = ("output_angle", "ratio", "transmission_angle", "coupler_point.x", "coupler_point.y")
# direction in the plane of flexion and radial deviation -> what the proximal and the distal row do there
RULES: Mapping[str, tuple[int, int]] = {"flexion": (1, 1), "radial deviation": (1, -1), "extension": (-1, -1),
                                        "ulnar deviation": (-1, 1)}  # fmt: skip
BETWEEN = ("radial flexion", "radial extension", "ulnar extension", "ulnar flexion")
NOTICED = np.radians(3.0)  # of the hand, below which it has no posture
STANDS = np.radians(0.5)  # of a row, below which it neither flexes nor extends


@dataclass(frozen=True)
class WristRecord:
    """The recorded part of a wrist. unit: its name, of wrists from subsystems that of the subsystem where it tells them apart.

    signals: those of `WRIST` that were recorded, (n,) rad.  columns: where they stand in the run.
    """

    unit: str
    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    columns: Mapping[str, str]


@dataclass(frozen=True)
class Posture:
    """A wrist at an instant. name: of the nearest of eight directions, "rest" near zero.  values: of `WRIST`, rad.

    rule: whether the rows do what the rule says; None where it says nothing, they hardly move or were not recorded.
    """

    wrist: str
    time: float
    name: str
    values: Mapping[str, float]
    rule: bool | None


@dataclass(frozen=True)
class Muscles:
    """Recorded activations and forces of a unit of muscles, (n,) each, by name of the muscle."""

    unit: str
    time: np.ndarray
    activation: Mapping[str, np.ndarray]
    force: Mapping[str, np.ndarray]
    torques: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Bundle:
    """Recorded tensions, N, and strains of the ligaments of a unit, (n,) each, by name of the ligament."""

    unit: str
    time: np.ndarray
    tension: Mapping[str, np.ndarray]
    strain: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class LinkageRecord:
    """A four-bar linkage whose crank angle and rocker angle were recorded; signals by name, (n,) rad, 1 and m."""

    unit: str
    crank: np.ndarray
    signals: Mapping[str, np.ndarray]


def wrists(result: Result) -> list[WristRecord]:
    """The wrists of a run whose angles were recorded, in the order of the scene."""
    records = []
    for unit in recorded_units(result, "flexion", "deviation"):
        if unit.has("proximal_angle") or unit.has("roll"):
            signals = unit.recorded(WRIST)
            records.append(WristRecord(unit.name, unit.time, signals, {name: unit.column(name) for name in signals}))
    outer = [r.unit.rpartition(".")[0] for r in records]
    return [replace(r, unit=name) for r, name in zip(records, outer, strict=True)] if distinct(outer) else records


def distinct(names: Sequence[str]) -> bool:
    """Whether there are several names, all different, none empty."""
    return len(names) > 1 and all(names) and len(set(names)) == len(names)


def direction(flexion: float, deviation: float) -> str:
    """The nearest of eight directions of the hand, by the angle in the plane of flexion and radial deviation."""
    if np.hypot(flexion, deviation) < NOTICED:
        return "rest"
    eighth = round(float(np.arctan2(deviation, flexion)) / (0.25 * np.pi)) % 8
    return BETWEEN[eighth // 2] if eighth % 2 else tuple(RULES)[eighth // 2]


def follows_rule(name: str, proximal: float, distal: float) -> bool | None:
    """Whether rows that flex by these angles, rad, do what the rule says of a posture.

    None where it says nothing, or where a row hardly moves and none contradicts.
    """
    if name not in RULES:
        return None
    ways = [sign * angle for sign, angle in zip(RULES[name], (proximal, distal), strict=True)]
    if min(ways) < -STANDS:
        return False
    return True if min(ways) > STANDS else None


def posture(record: WristRecord, sample: int) -> Posture:
    """The wrist at a sample of its record."""
    values = {n: float(v[sample]) for n, v in record.signals.items()}
    name = direction(values["flexion"], values["deviation"])
    rows = [values.get(n) for n in ROWS]
    rule = None if None in rows else follows_rule(name, *rows)  # type: ignore[arg-type]
    return Posture(record.unit, float(record.time[sample]), name, values, rule)


def postures(record: WristRecord, instants: Sequence[float] = (), start: int = 0) -> list[Posture]:
    """The wrist at the given times, s; without them where, from a sample on, its angles are largest either way, if noticed."""
    if instants:
        samples = [min(int(np.searchsorted(record.time, t - 1e-9)), record.time.size - 1) for t in instants]
    else:
        ends = [start + int(f(record.signals[n][start:])) for n in ("flexion", "deviation") for f in (np.argmax, np.argmin)]
        samples = sorted({k for k in ends if posture(record, k).name != "rest"})
    return [posture(record, k) for k in samples]


def muscles(result: Result) -> list[Muscles]:
    """The units of muscles of a run whose activations were recorded."""
    records = []
    names = [n.upper() for n in MUSCLES]
    for unit in recorded_units(result):
        if activation := _elements(unit, "activation", names):
            torques = {n: unit[f"{n}_torque"] for n in HAND[:2] if unit.has(f"{n}_torque")}
            records.append(Muscles(unit.name, unit.time, activation, _elements(unit, "force", names), torques))
    return records


def bundles(result: Result) -> list[Bundle]:
    """The ligaments of a run whose strains or tensions were recorded: of units of their own, and of wrists that have them."""
    names = [n.replace("_", "-") for n in LIGAMENTS]
    records = []
    for unit in recorded_units(result):
        for owner in ("", "constraint."):
            tension, strain = (_elements(unit, f"{owner}{what}", names) for what in ("tension", "strain"))
            if tension or strain:
                records.append(Bundle(unit.name, unit.time, tension, strain))
    return records


def _elements(unit: RecordedUnit, array: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    """The recorded elements of an array of the unit itself, by their names."""
    return {name: unit[f"{array}[{i}]"] for i, name in enumerate(names, 1) if unit.has(f"{array}[{i}]")}


def linkages(result: Result) -> list[LinkageRecord]:
    """The four-bar linkages of a run whose rocker angle and crank angle, or what drives it, were recorded."""
    units = recorded_units(result, "output_angle")
    return [LinkageRecord(u.name, u["input_angle"], u.recorded(LINKAGE)) for u in units if u.column("input_angle")]
