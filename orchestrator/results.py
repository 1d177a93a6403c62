"""The result of a run: time series, snapshots of arrays, and what is to be known about how they came about."""

from __future__ import annotations

import csv
import json
import signal
from collections.abc import Mapping
from dataclasses import dataclass, field
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


@dataclass(frozen=True, repr=False)
class Result:
    """What a run gave; after a failure, what it had until then.

    time: (n,) s.  columns: "unit.variable" -> (n,) numbers.  texts: "unit.variable" -> (n,) texts, of the same rows.
    measures: "unit.variable" -> unit of measure.
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
    texts: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __repr__(self) -> str:
        end = f" to t = {self.time[-1]:g} s" if self.time.size else ""
        warnings = len(self.info.get("warnings", ()))
        return (f"<Result of {self.scene.name}: {self.outcome}; {self.time.size} rows{end}, "
                f"{len(self.columns) + len(self.texts)} signals{f', {warnings} warnings' if warnings else ''}>")

    def __getitem__(self, name: str) -> np.ndarray:
        """The column "unit.variable", (n,) numbers or texts; raises `BadInput` with the near names."""
        everything = {**self.columns, **self.texts}
        if name not in everything:
            raise BadInput(f"result of {self.scene.name}", repr(name), "a recorded signal", nearest(name, everything))
        return everything[name]

    def unless_stopped(self) -> Result:
        """This result; where a signal stopped the run, the signal takes its usual effect, as it must for a study of many runs."""
        if self.outcome == "stopped":
            signal.raise_signal(signal.Signals[self.info["signal"]])
        return self

    def save(self, directory: str | Path) -> Path:
        """Write result.csv and run.json into the directory, which is made.

        result.csv: first column "time", then numbers, which keep every bit, then texts in quotation marks.
        """
        directory = ensure_directory(directory)
        try:
            with open(directory / "result.csv", "w", encoding="utf-8", newline="") as file:
                table = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
                table.writerow(["time", *self.columns, *self.texts])
                columns = [c.tolist() for c in (self.time, *self.columns.values(), *self.texts.values())]
                table.writerows(zip(*columns, strict=True))
            (directory / "run.json").write_text(json.dumps(self.info, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise not_written(directory, error) from None
        return directory
