"""The result of a run: time series, snapshots of arrays, and what is to be known about how they came about."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...components.core.errors import BadInput, counted, nearest
from ...components.core.measure import conversion
from ..output import UNFINISHED, is_locked, locked, not_written
from ..renamed import OUTPUT
from ..scene.scene import NO_SYSTEMS, KnownSystems, recorded_scene
from .recording import INFO, RESULT, SNAPSHOTS, TABLE, OutputFailed, ResultFiles
from .rows import STREAM, TIME, Rows, joined
from .run_record import RunRecord
from .series import Series

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    import xarray as xr

    from ..scene.scene import Scene

HELD = 20_000_000  # numbers that a result holds in memory; of one with more, columns are read when they are asked for


class Views(Protocol):
    """What sums up and draws results; `orchestrator.systems` gives scenes one that knows all systems."""

    def summary(self, result: Result) -> Any:
        """Figures of its system in numbers."""

    def report(self, result: Result, directory: str | Path) -> Path:
        """Write report.html."""

    def plot(self, result: Result, signals: str | Iterable[str] | None, fig: Any) -> Any:
        """A Plotly figure of signals over time."""


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
    info: what run.json holds.
    directory: where it is stored, if it is.
    """

    scene: Scene
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    snapshots: Mapping[str, Snapshot]
    measures: Mapping[str, str]
    info: RunRecord
    texts: Mapping[str, np.ndarray] = field(default_factory=dict)
    directory: Path | None = None

    def __repr__(self) -> str:
        end = f" to t = {self.end:g} s" if self.rows else ""
        warnings = len(self.info.warnings)
        return (
            f"<Result of {self.scene.name}: {self.outcome}; {counted(self.rows, 'row')}{end}, "
            f"{counted(len(self.columns) + len(self.texts), 'signal')}{f', {warnings} warnings' if warnings else ''}>"
        )

    def _repr_html_(self) -> str:
        from ..views.html import result_html

        return result_html(self)

    def __getitem__(self, name: str) -> np.ndarray:
        """The column "unit.variable", (n,) numbers or texts; raises `BadInput` with the near names."""
        for group in (self.columns, self.texts):
            if name in group:
                return group[name]
        raise BadInput(
            f"result of {self.scene.name}", repr(name), "a recorded signal", nearest(name, [*self.columns, *self.texts])
        )

    @property
    def outcome(self) -> str:
        """How it ended: "done", "failed", "unstable" or "stopped"."""
        return self.info.outcome

    @property
    def message(self) -> str:
        """Why it did not end as "done"."""
        return self.info.message

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return self.time.size

    @property
    def end(self) -> float:
        """Time of the last row, s."""
        return float(self.time[-1])

    @property
    def held(self) -> bool:
        """Whether all of it is in memory; else each look at a column reads it from the directory."""
        return True

    def signals(self, wanted: str | Iterable[str] | None = None) -> list[str]:
        """Names of recorded signals: all, or those wanted: "unit.variable", "unit.array" for its elements, "unit" for all of it.

        Raises `BadInput` with the near names for one that is not recorded.
        """
        known = [*self.columns, *self.texts]
        if wanted is None:
            return known
        names: dict[str, None] = {}
        for name in [wanted] if isinstance(wanted, str) else wanted:
            some = [name] if name in known else [n for n in known if n.startswith((f"{name}[", f"{name}."))]
            if not some:
                raise BadInput(f"result of {self.scene.name}", repr(name), "a recorded signal", nearest(name, known))
            names |= dict.fromkeys(some)
        return list(names)

    def series(
        self,
        signal: str,
        name: str = "",
        *,
        over: str = TIME,
        scale: float | str = 1.0,
        over_scale: float | str = 1.0,
        since: float | None = None,
        until: float | None = None,
        every: int = 1,
        kind: str = "line",
        faint: bool = False,
    ) -> Series:
        """A recorded signal as the line of a chart: over time, or over another signal.

        name: in the legend, the signal's own without one.  scale, over_scale: a number, or the unit of measure that is shown.
        since, until: s, ends of what is shown.  every: rows from one point to the next.  kind, faint: of `Series`.
        Raises `BadInput` with the near names for a signal that is not recorded, and for a unit of another dimension.
        """
        first = 0 if since is None else int(np.searchsorted(self.time, since))
        kept = slice(first, None if until is None else int(np.searchsorted(self.time, until, "right")), every)
        x = self._shown(over, over_scale) if over != TIME else _scaled(self.time, "s", over_scale)
        return Series(name or signal, x[kept], self._shown(signal, scale)[kept], kind, faint)

    def _shown(self, signal: str, scale: float | str) -> np.ndarray:
        return _scaled(self[signal], self.measures.get(signal, "1"), scale)

    def to_pandas(self, signals: Iterable[str] | None = None) -> pd.DataFrame:
        """Signals as columns over the index "time", s; units of measure by column in attrs["units"]."""
        from ..views.data import to_pandas

        return to_pandas(self, signals)

    def to_xarray(self, signals: Iterable[str] | None = None) -> xr.Dataset:
        """Signals and snapshots as a labelled data set; units of measure, and where it comes from, as attributes."""
        from ..views.data import to_xarray

        return to_xarray(self, signals)

    def export(
        self, path: str | Path, signals: str | Iterable[str] | None = None, *, separator: str = ",", decimal: str = "."
    ) -> Path:
        """Write signals into a file of another program: .csv of a dialect, .xlsx or .mat, see `views.export.export`."""
        from ..views.export import export

        return export(self, path, signals, separator, decimal)

    @property
    def _views(self) -> Views:
        if self.scene.views is None:
            raise BadInput(
                f"result of {self.scene.name}", "a scene that knows no systems", "one of cosimo.load_scene or cosimo.read_scene"
            )
        return self.scene.views

    @property
    def summary(self) -> Any:
        """Figures of the run in numbers, as its system has them: rows of name, value, unit and text; also by name.

        Raises `BadInput` where [analysis] asks for what the run does not have.
        """
        return self._views.summary(self)

    def plot(self, signals: str | Iterable[str] | None = None, *, fig: go.Figure | None = None) -> go.Figure:
        """A Plotly figure of signals over time, a panel for each unit of measure. `fig`: one of another result, to add to it.

        signals: "unit.variable", "unit.array" for its elements, "unit" for all of it; default: the first 40. Raises `BadInput`
        for signals that are not recorded.
        """
        return self._views.plot(self, signals, fig)

    @OUTPUT
    def report(self, output: str | Path | None = None) -> Path:
        """Write report.html into a directory, or into the one where the result is stored; returns its path."""
        where = output if output is not None else self.directory
        if where is None:
            raise BadInput(
                f"report of {self.scene.name}",
                "no directory",
                "one, for a result that is not stored",
                "As in result.report('out').",
            )
        return self._views.report(self, where)

    def extremes(self, name: str) -> tuple[float, float, float]:
        """Smallest, largest and last value of a column of numbers, which has at least one row."""
        column = self.columns[name]
        return float(column.min()), float(column.max()), float(column[-1])

    def unless_stopped(self) -> Result:
        """This result; where a signal stopped the run, the signal takes its usual effect, as it must for a study of many runs."""
        if self.outcome == "stopped":
            signal.raise_signal(signal.Signals[self.info.signal])
        return self

    @OUTPUT
    def save(self, output: str | Path) -> Path:
        """Write result.parquet, result.csv, run.json and snapshots into the directory `output`, which is created.

        result.csv: first column "time", then numbers, which keep every bit, then texts in quotation marks. Where the result is
        stored there already, only run.json is written anew. Raises `BadInput` where that is impossible; what was there stays.
        """
        with locked(output) as path:
            try:
                if self.directory is not None and self.directory == path.resolve():
                    self.info.write(path / INFO)
                else:
                    self._write(path)
            except OSError as error:
                raise not_written(output, error) from None
            except OutputFailed as error:
                raise BadInput("output directory", str(error), "a place that can be written") from None
        return path

    def _write(self, path: Path) -> None:
        files, info = ResultFiles(path), replace(self.info, scene=self.info.scene or self.scene.info())
        table = files.open([*self.columns], [*self.texts], self.measures, info)
        rows = max(HELD // 20 // (1 + len(self.columns)), 1)
        for first in range(0, self.rows, rows):
            some = slice(first, first + rows)
            texts = np.array([c[some] for c in self.texts.values()], dtype=object)
            time, n = self.time[some], len(self.columns)
            table.append(
                time, np.array([c[some] for c in self.columns.values()]).reshape(n, time.size).T, texts.reshape(-1, time.size).T
            )
        for name, snapshot in self.snapshots.items():
            elements = [f"{name}[{k + 1}]" for k in range(snapshot.values.shape[1])]
            none = np.zeros((snapshot.time.size, 0), dtype=object)
            files.snapshots(name, elements).append(snapshot.time, snapshot.values, none)
        files.finish(info)

    @classmethod
    def read(cls, directory: str | Path, systems: KnownSystems = NO_SYSTEMS) -> Result:
        """The result in a directory; of a run that was killed, what it had written, with the outcome "failed".

        `systems`: those that its [analysis] may name. Raises `BadInput` where there is none.
        """
        path = Path(directory)
        if path.is_dir() and not any(place.exists() for place in (path / INFO, path / UNFINISHED)):
            raise BadInput(
                "result",
                f"the folder {str(path)!r} without {INFO}",
                "a directory that a run has written",
                "As by cosimo run SCENE -o DIR.",
            )
        killed = (path / UNFINISHED / INFO).is_file() and not is_locked(path)
        folder = path / UNFINISHED if killed else path
        try:
            info = RunRecord.read(folder / INFO)
            scene = recorded_scene(info.scene, systems)
            file = folder / (RESULT + STREAM) if killed else path / TABLE
            rowless = (killed or info.outcome != "done") and not file.exists()  # ended before its first row
            table = Rows.read(file) if not rowless else None
            pieces = folder.glob(f"{SNAPSHOTS}-*{STREAM}") if killed else (path / SNAPSHOTS).glob("*.parquet")
            snapshots = [Rows.read(p) for p in sorted(pieces)]
        except OSError as error:
            raise BadInput(
                "result", repr(str(path)), "a directory that a run has written", f"{error.strerror or error}."
            ) from None
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            if isinstance(error, BadInput):
                raise
            raise BadInput("result", repr(str(path)), "a directory that a run has written", f"{error}.") from None
        if killed and info.outcome == "running":
            last = table.extremes(TIME)[2] if table and table.rows else 0.0
            info = replace(info, outcome="failed", message=f"the run was killed; its rows up to t = {last:.9g} s were written")
        return result_of(
            scene,
            table,
            {t.title: t for t in snapshots},
            table.units if table else {},
            info,
            path.resolve() if not killed else None,
        )


class _Held:
    """Time of a stored result: given as its table, and read from that when it is asked for."""

    def __get__(self, result: StoredResult | None, owner: type) -> Any:
        if result is None:
            return self
        given = result.__dict__["_time"]
        return given.column(TIME) if isinstance(given, Rows) else given

    def __set__(self, result: StoredResult, value: Any) -> None:
        result.__dict__["_time"] = value


class StoredResult(Result):
    """A result too large for the memory."""

    time: Any = _Held()

    @property
    def rows(self) -> int:
        return self.columns.table.rows  # type: ignore[attr-defined]

    @property
    def end(self) -> float:
        return self.columns.table.extremes(TIME)[2]  # type: ignore[attr-defined]

    @property
    def held(self) -> bool:
        return False

    def extremes(self, name: str) -> tuple[float, float, float]:
        return self.columns.table.extremes(name)  # type: ignore[attr-defined]


class OnDemand(Mapping[str, Any]):
    """Values by name that are read or computed when they are asked for, and not kept."""

    def __init__(self, names: Iterable[str], read: Callable[[str], Any], table: Rows | None = None):
        self._names, self._read, self.table = dict.fromkeys(names), read, table

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        return self._read(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def result_of(
    scene: Scene,
    table: Rows | None,
    snapshots: Mapping[str, Rows],
    measures: Mapping[str, str],
    info: RunRecord,
    directory: Path | None,
) -> Result:
    """The result whose rows are in tables, held in memory unless they are many; `directory`: where they are stored."""
    if table is not None and table.on_disk and table.rows * (1 + len(table.names)) > HELD:
        return StoredResult(
            scene,
            table,  # type: ignore[arg-type]
            OnDemand(table.names, table.column, table),
            OnDemand(snapshots, lambda name: Snapshot(*joined(snapshots[name])[:2])),
            measures,
            info,
            OnDemand(table.texts, table.column),
            directory,
        )
    time, values, texts = joined(table) if table is not None else (np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)))
    names, strings = (table.names, table.texts) if table is not None else ((), ())
    columns = dict(zip(names, (c.copy() for c in values.T), strict=True))
    return Result(
        scene,
        time,
        columns,
        {name: Snapshot(*joined(t)[:2]) for name, t in snapshots.items()},
        measures,
        info,
        dict(zip(strings, texts.T, strict=True)),
        directory,
    )


def _scaled(values: np.ndarray, unit: str, scale: float | str) -> np.ndarray:
    """Numbers times a factor, or in another unit of measure."""
    factor, offset = conversion(unit, scale) if isinstance(scale, str) else (scale, 0.0)
    return factor * values + offset if offset else factor * values
