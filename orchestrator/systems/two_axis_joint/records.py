"""What of a run belongs to its joints with two axes: angles and rates, where the axis points, what should stay constant.

A unit is a joint by the names of its outputs: outer_angle and outer_rate with inner_angle and inner_rate (gimbal), first_angle
... with second_angle ... (chain), or angle and rate alone (a link); the links of a scene are taken together as one chain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.analysis.sections import crossings, section
from ...harness.analysis.spectra import TURN

if TYPE_CHECKING:
    from ....components.core.component import Component
    from ...run.results import Result

PAIRS = (("outer", "inner"), ("first", "second"))
LOSSES = {"viscous", "smoothed_friction", "lugre_friction", "stick_friction", "stops"}
EXCHANGE = {"base_motion", "payload"}  # with what is outside
MOMENTA = ("outer_momentum", "angular_momentum")
ENERGY = "mechanical_energy"
MOST_DRAWN = 6000  # samples of a curve
STILL = 1e-9  # of the fastest axis of a joint: one that is slower stands but for rounding


@dataclass(frozen=True)
class Axis:
    """One angle of a joint and its rate: (n,) rad and rad/s."""

    name: str
    angle: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class JointRecord:
    """The recorded part of a joint of a run.

    pointing: (3, n) unit vector along the body's axis in base axes, z down; None where no gimbal is.  tip: (2, n) m or None.
    reach: m, of a chain's tip.  kept: name of a quantity -> (n,), energy in J and momentum in kg.m2/s; constant: those of them
    that the equations keep.
    """

    unit: str
    time: np.ndarray
    axes: tuple[Axis, ...]
    pointing: np.ndarray | None
    tip: np.ndarray | None
    reach: float
    kept: Mapping[str, np.ndarray]
    constant: frozenset[str]

    @property
    def moving(self) -> tuple[Axis, ...]:
        """The axes that move; of one that only rounding moves, figures would show the rounding."""
        fastest = [float(np.abs(a.rate).max(initial=0.0)) for a in self.axes]
        return tuple(a for a, rate in zip(self.axes, fastest, strict=True) if rate > STILL * max(fastest))


def joints(result: Result) -> list[JointRecord]:
    """The joints of a run whose angles and rates were recorded, in the order of the scene."""
    records, links = [], []
    for u in recorded_units(result):
        pair = next((p for p in PAIRS if all(u.has(f"{n}_angle", f"{n}_rate") for n in p)), None)
        if pair is not None:
            kind = "axis" if pair == PAIRS[0] else "link"
            axes = tuple(Axis(f"{n} {kind}", u[f"{n}_angle"], u[f"{n}_rate"]) for n in pair)
            records.append(_joint(u, axes))
        elif u.has("angle", "rate", "tip_x", "tip_y"):
            links.append(u)
    if links:
        axes = tuple(Axis(u.name, u["angle"], u["rate"]) for u in links)
        kept = {"energy": np.sum([u[ENERGY] for u in links], axis=0)} if all(u.has(ENERGY) for u in links) else {}
        tip = np.array([links[-1]["tip_x"], links[-1]["tip_y"]])
        records.append(JointRecord("links", result.time, axes, None, tip, 0.0, kept, frozenset()))
    return records


def _joint(u: RecordedUnit, axes: tuple[Axis, ...]) -> JointRecord:
    component = u.component
    gimbal = axes[0].name.startswith("outer")
    pointing = None
    if gimbal and component is not None:
        pointing = axis_direction(axes[0].angle, axes[1].angle, component.get("axis_orientation"))
    tip = np.array([u["tip_x"], u["tip_y"]]) if u.has("tip_x", "tip_y") else None
    reach = 0.0
    if tip is not None and component is not None:
        reach = component.get("first_length") + component.get("second_length")
    momentum = next((n for n in MOMENTA if u.has(n)), "")
    kept = u.recorded({"energy": ENERGY, **({"momentum": momentum} if momentum else {})})
    return JointRecord(u.name, u.time, axes, pointing, tip, reach, kept, _constant(u, component))


def axis_direction(outer: np.ndarray, inner: np.ndarray, orientation: str) -> np.ndarray:
    """Unit vector along the body's axis of a gimbal in base axes (x and y horizontal, z down), (3, n).

    At angles 0 it points down; the inner axis is y, the outer axis z where it is vertical and x where it is horizontal.
    """
    sa, ca, sb, cb = np.sin(outer), np.cos(outer), np.sin(inner), np.cos(inner)
    if orientation == "vertical":
        return np.array([ca * sb, sa * sb, cb])
    return np.array([sb, -sa * cb, ca * cb])


def _constant(u: RecordedUnit, component: Component | None) -> frozenset[str]:
    """What the equations of a joint keep: nothing where motors, losses or partners change it, or nothing is known of it."""
    if component is None or (LOSSES | EXCHANGE) & set(component.on):
        return frozenset()
    if any(u.source(name) for name in component.inputs) or any(component.u[0]):
        return frozenset()
    about_vertical = "axis_orientation" in component.parameters and component.get("axis_orientation") == "vertical"
    return frozenset({"energy"} if "gravity" in component.on and not about_vertical else {"energy", "momentum"})


def after(record: JointRecord, begin: float) -> slice:
    """The samples of a record from a time on."""
    return slice(int(np.searchsorted(record.time, begin - 1e-12)), None)


def drawn(record: JointRecord, begin: float) -> tuple[slice, str]:
    """The samples of a record from a time on that a curve should show, and what to say of it: more only blacken a picture."""
    kept = after(record, begin)
    if record.time.size - kept.start <= MOST_DRAWN + MOST_DRAWN // 10:  # a little more is no reason to leave the end out
        return kept, ""
    end = kept.start + MOST_DRAWN
    return slice(kept.start, end), f" Shown up to {record.time[end]:.4g} s of {record.time[-1]:.4g} s."


def poincare(result: Result, record: JointRecord, begin: float) -> list[tuple[str, Axis]]:
    """Poincaré sections of a record after `begin`: when it is taken, and the axis with its angle and rate there, (k,) each.

    At the scene's `section`, every axis that moves; without it, each axis of the first two, if both move, whenever the other
    one passes 0, of a motion that keeps its energy: of one that dies down, a section says nothing.
    """
    kept = after(record, begin)
    if (wanted := result.scene.analysis.section) is not None:
        angle, turns = result[wanted.angle][kept], wanted.turns
        when = f"{wanted.angle} at {'each turn' if turns == 1.0 else f'{turns:g} places of a turn'}"
        return [(when, Axis(a.name, *section(angle, TURN / turns, a.angle[kept], a.rate[kept]))) for a in record.moving]
    if len(record.moving) < 2 or "energy" not in record.constant:
        return []
    first, second = record.moving[:2]
    return [
        (f"the {passed.name} passes 0", _passages(record.time[kept], passed, other, kept))
        for passed, other in ((first, second), (second, first))
    ]


def _passages(time: np.ndarray, passed: Axis, other: Axis, kept: slice) -> Axis:
    """The other axis each time one passes 0, in one direction: with a positive rate, or where it has none, with a negative."""
    turned = passed.angle[kept] if passed.rate[kept].max() > 0.0 else -passed.angle[kept]
    if time.size < 4 or not np.ptp(turned):
        return Axis(other.name, np.zeros(0), np.zeros(0))
    front, angle, rate = crossings(time, np.sin(turned), np.cos(turned), other.angle[kept], other.rate[kept])
    return Axis(other.name, angle[front > 0.0], rate[front > 0.0])
