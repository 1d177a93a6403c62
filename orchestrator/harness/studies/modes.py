"""Modes of a scene at an instant, or over values of a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput, StepFailed
from ...derivatives.linear import DISCRETE, SAMPLE, Linear, Mode
from ...output import write_table
from ...scene.scene import Scene
from ...session.session import Session

COLUMNS = "value", "rate, 1/s", "frequency, Hz", "damping ratio", "kind", "units"


@dataclass(frozen=True)
class Modes:
    """Linear systems at the values of a parameter, "" where there is one alone; refused: (value, reason) of those that are none."""

    scene: Scene
    parameter: str
    points: tuple[tuple[float | None, Linear], ...]
    refused: tuple[tuple[float | None, str], ...] = ()

    def __repr__(self) -> str:
        lines = [f"<Modes of {self.scene.name}>"]
        for value, linear in self.points:
            lines += ([] if value is None else [f"{self.parameter} = {value:g}"]) + [repr(linear)]
        return "\n".join([*lines, *(f"{value}: {reason}" for value, reason in self.refused)])

    def rows(self) -> list[tuple[float | None, Mode]]:
        """Modes that are no leftovers of steps and samples, with the value of the parameter."""
        return [(v, mode) for v, linear in self.points for mode in linear.modes() if mode.kind not in (SAMPLE, DISCRETE)]

    def save(self, directory: str | Path) -> list[Path]:
        """Write modes.csv and, of a single instant, linear.npz and linear.mat."""
        rows = [
            ["" if c is None or (isinstance(c, float) and not isfinite(c)) else c for c in (value, *_numbers(mode))]
            for value, mode in self.rows()
        ]
        header = (self.parameter or "time, s", *COLUMNS[1:])
        files = [write_table(directory, "modes.csv", header, rows)]
        if not self.parameter:
            files += [self.points[0][1].save(Path(directory) / f"linear.{kind}") for kind in ("npz", "mat")]
        return files

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data; a number that is not finite is None."""
        modes = [dict(zip(COLUMNS, (value, *_numbers(mode)), strict=True)) for value, mode in self.rows()]
        plain = [{k: None if isinstance(v, float) and not isfinite(v) else v for k, v in row.items()} for row in modes]
        return {"scene": self.scene.name, "parameter": self.parameter, "modes": plain, "refused": dict(self.refused)}


def _numbers(mode: Mode) -> tuple[float, float, float, str, str]:
    return mode.rate.real, mode.frequency, mode.damping, mode.kind, mode.where


def modes(
    scene: Scene,
    at: float | None = None,
    over: tuple[str, Sequence[float]] | None = None,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
) -> Modes:
    """Modes at a time, s, at the start without one; over: a parameter and its values, each of a run of its own to that time.

    inputs, outputs: of the linear systems. Raises `BadInput`; a value at which there is no linear system is noted.
    """
    parameter, values = ("", [None]) if over is None else (over[0], [float(v) for v in over[1]])
    points: list[tuple[float | None, Linear]] = []
    refused: list[tuple[float | None, str]] = []
    for value in values:
        try:
            with Session(scene if value is None else scene.with_changes({parameter: value})) as session:
                session.initialize()
                session.until(session.time if at is None else at)
                points.append((value, session.linearize(inputs, outputs)))
        except (BadInput, StepFailed) as error:
            if value is None or (not points and value is values[-1]):
                raise
            refused.append((value, str(error)))
    return Modes(scene, parameter, tuple(points), tuple(refused))
