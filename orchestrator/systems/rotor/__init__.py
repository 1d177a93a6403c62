"""Rotors: what the harness knows of this system."""

from __future__ import annotations

from typing import Any

from pydantic import Field, model_validator

from ....components.core.errors import BadInput
from ...harness.system import System
from ...settings.analysis import AnalysisKeys, Positive, Span


class RotorKeys(AnalysisKeys):
    """Figures of rotors."""

    orders: tuple[Positive, ...] = Field(default=(1.0, 2.0), min_length=1, description="multiples of the speed to draw")
    orbit_windows: tuple[Span, ...] = Field(default=(), description="[[from, to], ...] in s")
    critical_speeds: tuple[Positive, ...] = Field(default=(), description="rad/s, to mark; else from the rotor's matrices")
    campbell_speed: Positive | None = Field(default=None, description="end of the Campbell diagram, rad/s")

    @model_validator(mode="after")
    def _windows_rise(self) -> RotorKeys:
        for low, high in self.orbit_windows:
            if not low < high:
                raise BadInput("orbit_windows", f"[{low:g}, {high:g}]", "an end after the start")
        return self

    def check(self, scene: Any) -> None:
        for low, high in self.orbit_windows:
            if high > scene.stop_time * (1.0 + 1e-9) or low < scene.start_time:
                where = f"{scene.name}: analysis.orbit_windows"
                within = f"within the run{f' from {scene.start_time:g}' if scene.start_time else ''} to {scene.stop_time:g} s"
                raise BadInput(where, f"[{low:g}, {high:g}] s", within, "Lengthen the run.")


SYSTEM = System("rotor", "Rotors", __name__, RotorKeys)
