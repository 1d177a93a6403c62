"""What the repetition of a run has shown, and its form in run.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, nan
from typing import Any

from ..run.comparison import SURE, Difference, SignalError
from .mesh import MeshError
from .parameter_errors import ParameterErrors

NOT_ASKED = "not asked for"
STEPS = "steps"  # macro step and internal steps, as what makes an error


@dataclass(frozen=True)
class Verification:
    """What repetition has shown of a run.

    done: whether there is any; why: why not, or what of it is missing.  step: s, the macro step of the repeated run.  how:
    "whole", "windows".  signals: errors by name that steps make.  figures: errors of the summary's figures, in their units.
    quantities: `STEPS`, or place of a tolerance or mesh -> errors that these make of further quantities, as shares.
    windows: begins (s) and length (s).  slower: signals slower than a window.
    growing: whose difference still grows there, see `windows`.
    excerpt: `time` (s) and the values `run` and `finer` of the signal with the largest error, where the two differ most.
    unseen: signals that their rows do not show -> how far they depart from straight lines between two.
    unstable: whether a repetition became unstable.  stopped: the signal that ended the repetition, by its name.
    inside: internal steps that were halved, too, place -> s.  parts: place of a tolerance or mesh -> how the signals change where
    it alone is refined.  mesh: what meshes make of the errors.
    not_refined: place of one that could not be refined -> why.  seconds: CPU time that it took.
    """

    done: bool
    why: str = ""
    step: float = nan
    how: str = ""
    runs: int = 0
    signals: Mapping[str, SignalError] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)
    quantities: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    windows: tuple[float, ...] = ()
    length: float = nan
    slower: tuple[str, ...] = ()
    growing: tuple[str, ...] = ()
    parts: Mapping[str, Mapping[str, Difference]] = field(default_factory=dict)
    not_refined: Mapping[str, str] = field(default_factory=dict)
    excerpt: Mapping[str, Any] = field(default_factory=dict)
    unseen: Mapping[str, float] = field(default_factory=dict)
    inside: Mapping[str, float] = field(default_factory=dict)
    mesh: MeshError = field(default_factory=MeshError)
    parameters: ParameterErrors | None = None  # of a scene with tolerances
    seconds: float = 0.0
    unstable: bool = False
    stopped: str = ""

    @property
    def errors(self) -> dict[str, SignalError]:
        """Errors of signals that steps, tolerances and meshes make together."""
        of_parts = {name: [gaps[name] for gaps in self.parts.values()] for name in self.signals}
        of_mesh = {
            name: self.mesh.signals.get(name, (0.0, 0.0)) if not e.parted else (0.0, 0.0) for name, e in self.signals.items()
        }
        return {
            name: replace(
                e,
                rms=e.rms + SURE * sum(gap.rms for gap in of_parts[name]) + of_mesh[name][0],
                largest=e.largest + SURE * sum(gap.largest for gap in of_parts[name]) + of_mesh[name][1],
            )
            for name, e in self.signals.items()
        }

    def worst_of_part(self, place: str) -> tuple[str, float]:
        """The signal that changes most where an internal setting is refined, and by how much of its deviation (rms)."""
        gaps = self.parts[place]
        worst = max(gaps, key=lambda name: gaps[name].rms)
        return worst, gaps[worst].rms

    def to_json(self) -> dict[str, Any]:
        """The object `verification` of run.json."""
        of_parameters = {} if self.parameters is None else {"parameters": self.parameters.to_json()}
        if not self.done:
            return {"done": False, "why": self.why, **of_parameters}
        windows = {
            "begins": list(self.windows),
            "length": self.length,
            "slower": list(self.slower),
            "growing": list(self.growing),
        }
        where_known = {
            "windows": windows if self.windows else {},
            "quantities": {cause: _finite(errors) for cause, errors in self.quantities.items()},
            "mesh": self.mesh.to_json(),
            "parts": {place: dict(zip(("signal", "difference"), self.worst_of_part(place), strict=True)) for place in self.parts},
            "not_refined": dict(self.not_refined),
            "unseen": dict(self.unseen),
            "inside": dict(self.inside),
            "excerpt": dict(self.excerpt),
        }
        return {
            "done": True,
            "why": self.why,
            "step": self.step,
            "how": self.how,
            "runs": self.runs,
            "signals": {name: error.to_json() for name, error in self.errors.items()},
            "figures": _finite(self.figures),
            **{name: value for name, value in where_known.items() if value},
            **of_parameters,
            "seconds": self.seconds,
        }


def _finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """What is not known is null."""
    return {name: number if isfinite(number) else None for name, number in numbers.items()}
