"""The set of effects that a scene calls for, found once and kept in the user's cache; and what run.json says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

from ...kept import Kept
from ...run.dependence import depends_on
from ...run.run_record import EffectsRecord, RunRecord
from ...scene.scene import Scene
from .effects import Effects, Finding, effects
from .full_model import effects_on, with_effects

NUMBERS = ("actual", "breaking")


@dataclass(frozen=True)
class Choice:
    """on: effects of every unit that is a component.  why: by "unit.effect", for each.  error: against the full model.

    kept: the file it was read from, or is kept in.  fresh: whether it was found just now.
    """

    on: Mapping[str, tuple[str, ...]]
    why: Mapping[str, Mapping[str, Any]]
    error: float
    kept: Path
    fresh: bool

    def applied(self, scene: Scene) -> Scene:
        """The scene with exactly these effects."""
        return with_effects(scene, self.on)

    def with_reasons(self, info: RunRecord, tolerance: float) -> RunRecord:
        """The record of a run, with the reasons of the choice in the place of what the scene says of its effects."""
        listed = dict(info.effects)
        for unit, on in self.on.items():
            reasons = {name.removeprefix(f"{unit}."): why["why"] for name, why in self.why.items() if why["unit"] == unit}
            listed[unit] = EffectsRecord(
                on={e: reasons[e] for e in on}, off={e: why for e, why in reasons.items() if e not in on}
            )
        selection = {"tolerance": tolerance, "error": self.error, "effects": self.why, "kept": str(self.kept)}
        return replace(info, effects=listed, selection=selection)


def choose(scene: Scene, tolerance: float, on_message: Callable[[str], None] = lambda text: None) -> Choice:
    """The smallest set of effects within a tolerance: the one that is kept, or else a new one, which takes many runs."""
    place = kept_choice(scene, tolerance)
    if (data := place.read()) is None:
        return keep(effects(scene, tolerance, on_message=on_message))
    return Choice({u: tuple(e) for u, e in data["on"].items()}, data["why"], float(data["error"]), place.file, False)


def keep(study: Effects) -> Choice:
    """Put what a study has found into the user's cache."""
    on, why = effects_on(study.chosen), {f.name: _why(f, study.tolerance) for f in study.findings}
    place = kept_choice(study.scene, study.tolerance)
    place.write({"on": on, "why": why, "error": study.least.error})
    return Choice(on, why, study.least.error, place.file, True)


def kept_choice(scene: Scene, tolerance: float) -> Kept:
    """Where the set of a scene is kept."""
    return Kept("effects", depends_on(scene, scene.study.effects, tolerance, of="figures"))


def _why(finding: Finding, tolerance: float) -> dict[str, Any]:
    numbers = {n: v for n in NUMBERS if isfinite(v := getattr(finding, n))}
    return {"unit": finding.unit, "on": finding.chosen, "given": finding.given, "why": finding.why(tolerance), **numbers}
