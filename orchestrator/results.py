"""The result of a run: time series, snapshots of arrays, and what is to be known about how they came about."""

from __future__ import annotations

import json
import signal
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..components.core.errors import BadInput, nearest
from .output import ensure_directory, not_written

if TYPE_CHECKING:
    from .scene.scene import Scene


@dataclass(frozen=True)
class Snapshot:
    """A whole array at some times. time: (k,) s; values: (k, m)."""

    time: np.ndarray
    values: np.ndarray


@dataclass(frozen=True)
class Result:
    """What a run gave; after a failure, what it had until then.

    time: (n,) s.  columns: "unit.variable" -> (n,).  measures: "unit.variable" -> unit of measure.
    info: what run.json holds.  outcome: "done", "failed", "unstable" or "stopped", with the reason in `message`.
    """

    scene: Scene
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    snapshots: Mapping[str, Snapshot]
    measures: Mapping[str, str]
    info: Mapping[str, Any]
    outcome: str
    message: str

    def __getitem__(self, name: str) -> np.ndarray:
        """The column "unit.variable", (n,); raises `BadInput` with the near names."""
        if name not in self.columns:
            raise BadInput(f"result of {self.scene.name}", repr(name), "a recorded signal", nearest(name, self.columns))
        return self.columns[name]

    def unless_stopped(self) -> Result:
        """This result; where a signal stopped the run, the signal takes its usual effect, as it must for a study of many runs."""
        if self.outcome == "stopped":
            signal.raise_signal(signal.Signals[self.info["signal"]])
        return self

    def save(self, directory: str | Path) -> Path:
        """Write result.csv (first column "time"; numbers keep every bit) and run.json into the directory, which is made."""
        directory = ensure_directory(directory)
        try:
            with open(directory / "result.csv", "w", encoding="utf-8") as file:
                file.write(",".join(['"time"', *(f'"{name}"' for name in self.columns)]) + "\n")
                for row in zip(self.time.tolist(), *(c.tolist() for c in self.columns.values()), strict=True):
                    file.write(",".join(map(repr, row)) + "\n")
            (directory / "run.json").write_text(json.dumps(self.info, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise not_written(directory, error) from None
        return directory
