"""Settings of studies: quantities of interest, meshes, a monolithic scene to compare with, maps of stability.

[study]
quantities = ["pantograph.contact_force, time history below 20 Hz", "rotor.displacement_x, amplitude at 12.5 Hz"]
mesh = ["catenary.element"]                     # parameters whose halving refines the mesh of a unit
monolith = { scene = "one-body", signals = { "left.position" = "body.x" } }
stability = { wall.stiffness = { from = 1e3, to = 1e6, points = 7 } }
"""

from __future__ import annotations

import re
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, Field, field_validator

from ...components.core.errors import BadInput, nearest
from .model import Model, Sweep

QUANTITY_KINDS = ("minimum", "maximum", "mean", "standard deviation", "end", "time history", "amplitude at F Hz")
RUNNING_KINDS = QUANTITY_KINDS[:4]  # which can be computed step by step
EVERY_KIND = ", ".join(QUANTITY_KINDS) + '; all but the last also "... below F Hz", of the low-pass-filtered signal'
AMPLITUDE = re.compile(r"amplitude at (\S+) Hz")
FILTERED = re.compile(r"(.*\S) below (\S+) Hz")


class Wanted(NamedTuple):
    """A quantity of interest as a scene names it.

    kind: one of `QUANTITY_KINDS`.  frequency: Hz, of an amplitude.  cutoff: Hz, of a low-pass-filtered signal; 0 without filter.
    """

    signal: str
    kind: str
    frequency: float = 0.0
    cutoff: float = 0.0

    def __str__(self) -> str:
        below = f" below {self.cutoff:g} Hz" if self.cutoff else ""
        return f"{self.signal}, {self.kind.replace('F Hz', f'{self.frequency:g} Hz')}{below}"


def wanted(text: str) -> Wanted:
    """Of "unit.output, kind"; raises `BadInput`."""
    signal, comma, kind = (part.strip() for part in text.rpartition(","))  # an element of an array has commas, too
    if not (signal and comma):
        raise BadInput("quantities", repr(text), '"unit.output, kind"', f"Kinds: {EVERY_KIND}.")
    if amplitude := AMPLITUDE.fullmatch(kind):
        return Wanted(signal, QUANTITY_KINDS[-1], frequency=_frequency(text, amplitude[1]))
    filtered = FILTERED.fullmatch(kind)
    kind = filtered[1] if filtered else kind
    if kind not in QUANTITY_KINDS[:-1]:
        raise BadInput("quantities", f"kind {kind!r}", f"one of {EVERY_KIND}", nearest(kind, QUANTITY_KINDS))
    return Wanted(signal, kind, cutoff=_frequency(text, filtered[2]) if filtered else 0.0)


def _frequency(text: str, number: str) -> float:
    try:
        frequency = float(number)
    except ValueError:
        frequency = -1.0
    if not 0.0 < frequency < float("inf"):
        raise BadInput("quantities", repr(text), "a positive frequency", 'Such as "amplitude at 12.5 Hz".')
    return frequency


def _readable(quantities: tuple[str, ...]) -> tuple[str, ...]:
    for text in quantities:
        wanted(text)
    return quantities


Quantities = Annotated[tuple[str, ...], AfterValidator(_readable)]  # texts that `wanted` reads


class MonolithSettings(Model):
    """Another scene with the same physics in one unit: its solution is what the coupled scene should give."""

    scene: str = Field(description="name of a shipped scene or path of a file")
    signals: dict[str, str] = Field(
        default={}, description="unit.output of this scene -> unit.output of that one; those of one name need no entry"
    )


class StudySettings(Model):
    """Read by cosimo accuracy, stability and effects."""

    quantities: Quantities = Field(
        default=(),
        description=(
            '"unit.output, kind", after the transient of [analysis]; kinds: '
            + EVERY_KIND
            + "; without it the time history and the maximum of every recorded signal"
        ),
    )
    mesh: tuple[str, ...] = Field(default=(), description="unit.parameter, lengths of elements; halved, the mesh is finer")
    monolith: MonolithSettings | None = Field(default=None, description="a scene that gives the same signals from one unit")
    effects: tuple[str, ...] = Field(
        default=(),
        description=("unit.effect: parts, defects, loads and the like that cosimo effects takes into the full model, too"),
    )
    stability: Sweep = Field(
        default={},
        description=(
            "unit.parameter = [values] or { from, to, points }, one or two of them: axes of the map of cosimo stability"
        ),
    )

    @field_validator("stability")
    @classmethod
    def _drawable(cls, table: dict[str, Any]) -> dict[str, Any]:
        if len(table) > 2:
            raise BadInput("", f"{len(table)} parameters", "one or two, the axes of a map")
        return table
