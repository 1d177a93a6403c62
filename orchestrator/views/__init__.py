"""Results and scenes as users look at them: in a notebook, as data of other libraries, as drawings, all without Plotly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np


class Recorded(Protocol):
    """A result as `results.Result` is one."""

    @property
    def scene(self) -> Any:
        """The scene that was run."""

    @property
    def time(self) -> np.ndarray:
        """(n,) s."""

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """ "unit.variable" -> (n,) numbers."""

    @property
    def snapshots(self) -> Mapping[str, Any]:
        """ "unit.array" -> `results.Snapshot`."""

    @property
    def measures(self) -> Mapping[str, str]:
        """ "unit.variable" -> unit of measure."""

    @property
    def info(self) -> Any:
        """What run.json holds: a `RunRecord`."""

    @property
    def outcome(self) -> str:
        """How it ended."""

    @property
    def message(self) -> str:
        """Why."""

    @property
    def rows(self) -> int:
        """How many rows there are."""

    @property
    def end(self) -> float:
        """Time of the last row, s."""

    @property
    def held(self) -> bool:
        """Whether all of it is in memory."""

    @property
    def summary(self) -> Any:
        """Rows of numbers."""

    def __getitem__(self, name: str) -> np.ndarray:
        """The column "unit.variable"."""

    def extremes(self, name: str) -> tuple[float, float, float]:
        """Smallest, largest and last value of a column."""

    def signals(self, wanted: str | Iterable[str] | None = None) -> list[str]:
        """Names of recorded signals."""
