"""Pantograph and catenary: what the harness knows of this system."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ....components.core.errors import BadInput
from ...harness.system import System
from ...settings.analysis import AnalysisKeys, Endpoint, Span

Counted = Annotated[int, Field(strict=True, ge=1)]


class RailwayKeys(AnalysisKeys):
    """Figures of pantographs under a catenary; spans and droppers are those of the run's catenary."""

    spans: tuple[Counted, Counted] | None = Field(
        default=None, description="[first, last] span for the statistics, counted from 1 at position 0"
    )
    window: Span | None = Field(default=None, description="[from, to] in m along the track, instead of spans")

    supply: Literal["AC", "3 kV DC", "1.5 kV DC"] = Field(default="AC", description="supply of the line; limits depend on it")

    def judged(self, links: Sequence[tuple[Endpoint, Endpoint]]) -> Iterable[Endpoint]:
        """The wire's height at every contact point, on either wire, and the uplifts at supports, with which of them are followed."""
        heights = [source for source, (_, name) in links if name.rpartition(".")[2] == "wire_height"]
        lines = dict.fromkeys(unit for unit, _ in heights)
        return (*heights, *((unit, name) for unit in lines for name in ("support_uplift", "moving_window.rear")))

    def beside(self, recorded: Iterable[Endpoint]) -> Iterable[Endpoint]:
        """Of uplifts, from which place on the wires are followed."""
        return dict.fromkeys((unit, "moving_window.rear") for unit, name in recorded if name.startswith("support_uplift["))

    def check(self, scene: Any) -> None:
        """Refuse a window of analysis that a pantograph of the scene does not pass within the run."""
        from .records import check_window  # which needs these keys

        check_window(scene, self)

    @model_validator(mode="after")
    def _one_of_them(self) -> RailwayKeys:
        if self.spans is not None and self.window is not None:
            raise BadInput("window", "window and spans exclude each other", "", "Remove one.")
        if self.spans is not None and self.spans[0] > self.spans[1]:
            raise BadInput("spans", f"[{self.spans[0]}, {self.spans[1]}]", "a last span not before the first")
        return self


SYSTEM = System("railway", "Pantograph and catenary", __name__, RailwayKeys)
