"""Branches of periodic orbits over one parameter, for several values of another: where motions repeat, and where they are chaotic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ..output import write_table
from ..scene.scene import Scene
from .continuation import Mark, Orbits, orbits
from .motions import MOTION_COLUMNS
from .orbit import Forcing

EXPONENTS = 500  # periods of a run that measures an exponent


@dataclass(frozen=True)
class OrbitMap:
    """over, across: the parameters.  rows: (value of `across`, its orbits over `over`), which have motions at the same values each."""

    scene: Scene
    over: str
    across: str
    rows: tuple[tuple[float, Orbits], ...]

    @property
    def exponents(self) -> np.ndarray:
        """The largest Lyapunov exponents, 1/s, (values of `across`, values of `over`)."""
        return np.array([[motion.exponent for motion in study.motions] for _, study in self.rows])

    @property
    def marks(self) -> list[tuple[float, Mark]]:
        """All bifurcations, each with its value of `across`."""
        return [(value, mark) for value, study in self.rows for mark in study.marks]

    def save(self, directory: str | Path) -> list[Path]:
        """Write motions.csv and bifurcations.csv."""
        motions = [[value, *motion.row()] for value, study in self.rows for motion in study.motions]
        marks: list[list[Any]] = [[value, m.orbit.value, m.kind, m.orbit.period] for value, m in self.marks]
        return [
            write_table(directory, "motions.csv", (self.across, self.over, *MOTION_COLUMNS), motions),
            write_table(directory, "bifurcations.csv", (self.across, self.over, "kind", "period, s"), marks),
        ]

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data."""
        rows = [{"value": value, **study.to_json(), "motions": [m.row() for m in study.motions]} for value, study in self.rows]
        return {"scene": self.scene.name, "over": self.over, "across": self.across, "rows": rows}


def orbit_map(
    scene: Scene,
    forcing: Forcing,
    over: tuple[str, Sequence[float]],
    across: tuple[str, Sequence[float]],
    *,
    progress: Callable[[str], None] = lambda text: None,
    **options: Any,
) -> OrbitMap:
    """Orbits over a parameter for each value of another; options: as of `orbits`, with exponents. Raises `BadInput`."""
    if over[0] == across[0]:
        raise BadInput(f"orbits of {scene.name}", f"{over[0]} twice", "two parameters")
    rows = []
    for value in map(float, across[1]):

        def say(text: str, value: float = value) -> None:
            progress(f"{across[0]} = {value:g}, {text}")

        rows.append((value, orbits(scene.with_changes({across[0]: value}), forcing, over, progress=say, **options)))
    return OrbitMap(scene, over[0], across[0], tuple(rows))
