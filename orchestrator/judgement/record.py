"""What the repetition of a run has shown, and its form in run.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import Any

from .comparison import SignalError


@dataclass(frozen=True)
class Verification:
    """What repetition has shown of a run.

    done: whether there is any; why: why not, or what of it is missing.  step: s, the macro step of the repeated run.  how:
    "whole", "windows".  signals: by name.  figures: errors of the summary's figures, in their units.  windows: begins (s) and
    length (s).  slower: signals slower than a window.
    growing: whose difference still grows there, see `windows`.
    excerpt: `time` (s) and the values `run` and `finer` of the signal with the largest error, where the two differ most.
    unseen: signals that their rows do not show -> how far they depart from straight lines between two.
    inside: internal steps that were halved, too, place -> s.  coupling: share of the largest error that half the macro step alone
    shows; NaN where it is not known.  parts: place of an internal setting -> worst signal and how much
    it changes.  seconds: CPU time that it took.
    """

    done: bool
    why: str = ""
    step: float = nan
    how: str = ""
    runs: int = 0
    signals: Mapping[str, SignalError] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)
    windows: tuple[float, ...] = ()
    length: float = nan
    slower: tuple[str, ...] = ()
    growing: tuple[str, ...] = ()
    parts: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    excerpt: Mapping[str, Any] = field(default_factory=dict)
    unseen: Mapping[str, float] = field(default_factory=dict)
    inside: Mapping[str, float] = field(default_factory=dict)
    coupling: float = nan
    seconds: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """The object `verification` of run.json."""
        if not self.done:
            return {"done": False, "why": self.why}
        return {
            "done": True,
            "why": self.why,
            "step": self.step,
            "how": self.how,
            "runs": self.runs,
            "signals": {name: error.to_json() for name, error in self.signals.items()},
            "figures": {name: error if isfinite(error) else None for name, error in self.figures.items()},
            **(
                {
                    "windows": {
                        "begins": list(self.windows),
                        "length": self.length,
                        "slower": list(self.slower),
                        "growing": list(self.growing),
                    }
                }
                if self.windows
                else {}
            ),
            **({"parts": {place: {"signal": s, "difference": d} for place, (s, d) in self.parts.items()}} if self.parts else {}),
            **({"unseen": dict(self.unseen)} if self.unseen else {}),
            **({"inside": dict(self.inside)} if self.inside else {}),
            **({"coupling": self.coupling} if isfinite(self.coupling) else {}),
            **({"excerpt": dict(self.excerpt)} if self.excerpt else {}),
            "seconds": self.seconds,
        }
