"""What every scene's [analysis] may say; a system's own keys are a model of its own that inherits from this one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any

from pydantic import Field

from .model import Model, Number

Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)]
Span = tuple[Number, Number]
Endpoint = tuple[str, str]  # unit, variable


class SectionKeys(Model):
    """Points of a motion each time an angle passes a multiple of a turn over `turns`."""

    signal: str = Field(default="", description="unit.output, the signal that a sweep keeps")
    angle: str = Field(description="unit.output, an angle in rad")
    turns: Annotated[float, Field(strict=True, gt=0.0, le=1e6)] = Field(default=1.0, description="points a turn of the angle")


class AnalysisKeys(Model):
    """What every system reads."""

    system: str = Field(default="", description="which figures the report has: a name of a system")
    transient: NotNegative = Field(default=0.0, description="time from the start left out of spectra, orbits, measures, sections")
    section: SectionKeys | None = Field(default=None, description="section of a sweep and of phase planes")

    def judged(self, links: Sequence[tuple[Endpoint, Endpoint]]) -> Iterable[Endpoint]:
        """Outputs and arrays of outputs that the system's figures need beside the scalar ones, of a scene without `[record]`.

        links: (unit, output) -> (unit, input).
        """
        return ()

    def beside(self, recorded: Iterable[Endpoint]) -> Iterable[Endpoint]:
        """Outputs without which recorded ones may be misread; those of them that there are, are recorded, too."""
        return ()

    def check(self, scene: Any) -> None:
        """Refuse, before a run of a scene with these keys, what the run cannot have, such as a window beyond its end."""
