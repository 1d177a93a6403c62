"""What the repetition of a run has shown, and how it is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import nan

from ..run.comparison import SURE, Difference, SignalError
from ..run.run_record import Excerpt, ParametersRecord, PartRecord, VerificationRecord, WindowsRecord, known
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
    excerpt: of the signal with the largest error, where the two runs differ most.
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
    excerpt: Excerpt | None = None
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

    @property
    def record(self) -> VerificationRecord:
        """As it is written."""
        parameters = self.parameters.record if self.parameters is not None else ParametersRecord()
        if not self.done:
            return VerificationRecord(done=False, why=self.why, parameters=parameters)
        windows = WindowsRecord(begins=self.windows, length=self.length, slower=self.slower, growing=self.growing)
        worst = {place: self.worst_of_part(place) for place in self.parts}
        return VerificationRecord(
            done=True,
            why=self.why,
            step=self.step,
            how=self.how,
            runs=self.runs,
            signals={name: error.record for name, error in self.errors.items()},
            figures=_known(self.figures),
            windows=windows if self.windows else None,
            quantities={cause: _known(errors) for cause, errors in self.quantities.items()},
            mesh=self.mesh.record,
            parts={place: PartRecord(signal=name, difference=change) for place, (name, change) in worst.items()},
            not_refined=self.not_refined,
            unseen=self.unseen,
            inside=self.inside,
            excerpt=self.excerpt,
            parameters=parameters,
            seconds=self.seconds,
        )


def _known(numbers: Mapping[str, float]) -> dict[str, float | None]:
    return {name: known(number) for name, number in numbers.items()}
