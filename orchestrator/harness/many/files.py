"""The points of a sweep in the order of its plan, and the files that they are written to.

sweep.csv, sweep.parquet  the table, a row a point
sweep.zarr                the labelled data set that xarray opens (Zarr 3): the table's columns over "point", kept signals
                          over "point" and "sample" or "time"
sweep.json                plan, scene, versions, units: how it came about
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from signal import Signals
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput, counted
from ....components.core.store import replaced
from ....fmus.versions import version
from ...output import write_json, write_table
from ...scene.names import measure_of
from ...scene.scene import Scene
from ...settings.plan import PlanSettings
from ...views.data import library
from . import store as stores
from .failures import doubt_groups
from .repetition import NONE_REPEATED, Repeated
from .store import NUMBER, SECTION, SIGNAL, TIME, StoredPlan, array_of

if TYPE_CHECKING:
    import pandas as pd

DATA_SET = "sweep.zarr"
LONGEST, SHORT = 200, 40  # bytes of a variable's name in it, and characters that a longer one keeps
NOT_RUN = "not run"
SIGNALS_AT_ONCE = 64  # points whose signals are in memory at a time
CHUNK = 4096  # points of the data set's and the table's pieces
LARGEST_PIECE = 8_000_000  # numbers that are in memory at a time


@dataclass(frozen=True)
class Sweep:
    """What the points of a sweep gave, in the order of its plan.

    plan: how the points were chosen.  varied: "unit.parameter" -> values, (n,), numbers or texts.  measures: "unit.signal, kind"
    and the like -> (n,), NaN where a run failed.  kinds: (n,) of `measures.OUTCOMES`, with their reasons; of points that are
    done, why they may be unstable.  section: per point the values of
    the section's signal, (k,) each; none of more points than a piece has.  units: unit of measure of every column.
    longest: samples of the kept signals, at most.
    stopped: the signal that has ended it before its last point.  files: what was written.  computed: runs of this call.
    points: with their stored rows; None without a directory.  repeated: what half of every step changes at some points; None where
    nothing was repeated.
    """

    scene: Scene
    plan: PlanSettings
    varied: Mapping[str, np.ndarray]
    measures: Mapping[str, np.ndarray]
    kinds: np.ndarray
    reasons: np.ndarray
    section: tuple[np.ndarray, ...]
    units: Mapping[str, str]
    longest: int
    points: StoredPlan | None
    stopped: Signals | None = None
    files: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()
    computed: int = 0
    repeated: Repeated | None = None

    @cached_property
    def outcomes(self) -> tuple[str, ...]:
        """(n,) "done" or "not run", or the reason."""
        return tuple(k if k in ("done", NOT_RUN) else why for k, why in zip(self.kinds, self.reasons, strict=True))

    def signals(self, name: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """(time, values), (m,) each, of a kept signal at every point, read as they are asked for; empty where a run failed.

        Raises `BadInput` for a signal that was not kept, and for a sweep without a directory.
        """
        if self.points is None or name not in self.plan.keep.signals:
            raise BadInput("signals", repr(name), "a signal that the plan keeps, of a sweep with a directory")
        return (
            (array_of(table, TIME, k), array_of(table, SIGNAL + name, k))
            for some, table in self.points.pieces([TIME, SIGNAL + name], SIGNALS_AT_ONCE)
            for k in range(some.stop - some.start)
        )

    def __repr__(self) -> str:
        """Points, ranges, errors: one line each."""
        done = int(self.done.sum())
        lines = [
            f"<Sweep of {self.scene.name}: {done} of {len(self.outcomes)} points done, {counted(len(self.measures), 'column')}>"
        ]
        for name, values in self.varied.items():
            several = values.dtype.kind not in "fiu" and ", ".join(dict.fromkeys(map(str, values)))
            unit = f" {self.units[name]}" if self.units.get(name, "1") != "1" else ""
            lines.append(f"{name}: {several or f'{values.min():g} to {values.max():g}{unit}'}")
        lines.append(self.repeated.summary(len(self.outcomes)) if self.repeated is not None else NONE_REPEATED)
        lines += [f"warning: {text}" for text in self.remarks]
        return "\n".join(lines)

    def to_pandas(self) -> pd.DataFrame:
        """A row a point: what varies, every measure, outcome. attrs["units"]: of measure, by column.

        Raises `BadInput` where pandas is missing.
        """
        frame = library("pandas").DataFrame({**self.varied, **self.measures, "outcome": self.outcomes})
        frame.attrs = {"units": dict(self.units)}
        return frame

    @property
    def doubts(self) -> list[str]:
        """What keeps points that are done from being sure results, as sentences."""
        not_confirmed = self.repeated.not_confirmed() if self.repeated is not None else []
        return doubt_groups(self.kinds, self.reasons) + not_confirmed

    @property
    def done(self) -> np.ndarray:
        """(n,) truth values: points that gave their numbers."""
        return self.kinds == "done"


def collect(scene: Scene, points: StoredPlan) -> Sweep:
    """The rows of points, column by column; NaN where there is none."""
    import pyarrow.compute as compute

    n, plan, columns = points.plan.size, points.plan, points.store.columns
    numbers: dict[str, np.ndarray] = {}
    kinds, reasons = np.full(n, NOT_RUN, dtype=object), np.full(n, "", dtype=object)
    texts: dict[str, str] = {}  # each once in memory
    section: list[np.ndarray] = []
    longest = 0
    for some, table in points.pieces():
        for column, target, missing in (("outcome", kinds, NOT_RUN), ("reason", reasons, "")):
            target[some] = [texts.setdefault(t, t) for t in compute.fill_null(table.column(column), missing).to_pylist()]
        for name in table.column_names:
            if name.startswith(NUMBER):
                numbers.setdefault(name.removeprefix(NUMBER), np.full(n, np.nan))[some] = table.column(name).to_numpy()
        if TIME in table.column_names:
            longest = max(longest, compute.max(compute.list_value_length(table.column(TIME))).as_py() or 0)
        if n <= stores.PIECE:
            section = [array_of(table, SECTION, k) for k in range(n)]
    units = {name: measure_of(scene, name) for name in plan.columns}
    units |= {n: columns[SIGNAL + n] for n in plan.settings.keep.signals if SIGNAL + n in columns}
    units |= {n: columns[NUMBER + n] for n in numbers}
    units |= {n: limit.unit for n, limit in plan.settings.limits.items() if units.get(n) == ""}  # own functions say none
    varied = {name: column.labels for name, column in plan.columns.items()}
    return Sweep(scene, plan.settings, varied, numbers, kinds, reasons, tuple(section), units, longest, points)


def write_tables(directory: Path, sweep: Sweep) -> Path:
    """sweep.csv and sweep.parquet: what varies, what was measured, the outcome with its reason."""
    import pyarrow
    import pyarrow.parquet as parquet

    columns, units = {**sweep.varied, **sweep.measures}, sweep.units

    def rows() -> Iterator[tuple[Any, ...]]:
        for first in range(0, sweep.kinds.size, CHUNK):
            some = slice(first, first + CHUNK)
            ends = zip(sweep.kinds[some], sweep.reasons[some], strict=True)
            outcome = [o if o in ("done", NOT_RUN) else f"{o}: {reason}" for o, reason in ends]
            yield from zip(*(c[some].tolist() for c in columns.values()), outcome, strict=True)

    header = [*(f"{n}, {units[n]}" if units.get(n) else n for n in columns), "outcome"]
    path = write_table(directory, "sweep.csv", header, rows())
    columns |= {"outcome": sweep.kinds, "reason": sweep.reasons}
    kinds = {n: pyarrow.float64() if c.dtype.kind == "f" else pyarrow.string() for n, c in columns.items()}
    schema = pyarrow.schema([pyarrow.field(n, kind, metadata={"unit": units.get(n, "")}) for n, kind in kinds.items()])
    table = pyarrow.table([pyarrow.array(c, type=kinds[n]) for n, c in columns.items()], schema=schema)
    with replaced(directory / "sweep.parquet", "wb") as file:
        parquet.write_table(table, file, row_group_size=CHUNK, compression="zstd")
    return path


def write_data_set(directory: Path, sweep: Sweep, points: StoredPlan, attributes: Mapping[str, Any]) -> Path | None:
    """sweep.zarr, put in place when it is whole; None where xarray or zarr are not installed. Kept signals lie over "time" where
    all were interpolated at multiples of an interval, else over "sample"."""
    if find_spec("xarray") is None or find_spec("zarr") is None:
        return None
    import xarray

    n, longest, keep = sweep.kinds.size, sweep.longest, sweep.plan.keep
    stored = _stored([*sweep.measures, *sweep.varied, *keep.signals, *(f"{m}, signal" for m in keep.signals)])

    def described(name: str) -> dict[str, str]:
        return {"long_name": name, "units": sweep.units.get(name) or "1"}

    variables: dict[str, Any] = {stored[m]: ("point", c, described(m)) for m, c in sweep.measures.items()}
    variables |= {"outcome": ("point", sweep.kinds), "reason": ("point", sweep.reasons)}
    coordinates = {stored[name]: ("point", c, described(name)) for name, c in sweep.varied.items()}
    whole = xarray.Dataset(variables, coordinates | {"point": np.arange(n)}, dict(attributes))

    def signals() -> Iterator[xarray.Dataset]:
        along = "time" if keep.interval is not None else "sample"
        columns = {SIGNAL + m: stored[f"{m}, signal" if m in sweep.measures else m] for m in keep.signals}
        for _, table in points.pieces([TIME, *columns], per):
            variables: dict[str, Any] = {
                name: (("point", along), _padded(table, column, longest), described(column.removeprefix(SIGNAL)))
                for column, name in columns.items()
            }
            coordinates: dict[str, Any] = {}
            if keep.interval is not None:
                coordinates["time"] = ("time", sweep.scene.start_time + keep.interval * np.arange(longest), {"units": "s"})
            else:
                variables["time"] = (("point", along), _padded(table, TIME, longest), {"units": "s", "long_name": "time"})
            yield xarray.Dataset(variables, coordinates, dict(attributes))

    target, part = directory / DATA_SET, directory / f".{DATA_SET}.{os.getpid()}"
    shutil.rmtree(part, ignore_errors=True)
    _append(part, [whole], (min(CHUNK, n),))
    if longest:
        per = max(1, min(CHUNK, LARGEST_PIECE // (longest * (1 + len(keep.signals)))))
        _append(part, signals(), (per, longest))
    shutil.rmtree(target, ignore_errors=True)
    os.replace(part, target)
    return target


def _stored(names: Iterable[str]) -> dict[str, str]:
    """What variables of a data set are called, by their names: each has a folder, and so no name may be a path, unseen, or differ
    from another one in capitals alone. Their long_name has the whole name."""
    stored: dict[str, str] = {}
    taken = {"outcome", "reason", "point", "time", "sample"}
    for name in dict.fromkeys(names):
        plain = "".join(c if c.isprintable() and c not in "/\\" else f"%{ord(c):02X}" for c in name)
        plain = plain if len(plain.encode()) <= LONGEST else f"{plain[:SHORT]}~{sha256(name.encode()).hexdigest()[:16]}"
        text, k = plain, 2
        while text.casefold() in taken:
            text, k = f"{plain}~{k}", k + 1
        taken.add(text.casefold())
        stored[name] = text
    return stored


def _padded(table: Any, column: str, longest: int) -> np.ndarray:
    """(k, longest) a column of lists; NaN behind their ends and where there are none."""
    values = np.full((table.num_rows, longest), np.nan)
    for row in range(table.num_rows):
        one = array_of(table, column, row)
        values[row, : one.size] = one
    return values


def _append(path: Path, pieces: Iterable[Any], chunks: tuple[int, ...]) -> None:
    """Variables piece by piece over "point", new ones of a data set that is there or not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Zarr's type of texts is not in the specification yet
        for k, data in enumerate(pieces):
            along = [name for name in data.variables if "point" in data[name].dims]
            if k == 0:
                encoding = {name: {"chunks": chunks} for name in along if name != "point"}
                data.to_zarr(path, mode="a", encoding=encoding, zarr_format=3, consolidated=False)
            else:
                others = [name for name in data.variables if name not in along]
                data.drop_vars(others).to_zarr(path, append_dim="point", consolidated=False)


def write_provenance(directory: Path, scene: Scene, points: StoredPlan, units: Mapping[str, str], more: Mapping[str, Any]) -> str:
    """sweep.json, in place when it is whole: how the numbers came about, and `more`; the same as text for the data set."""
    settings = points.plan.settings.model_dump_json(exclude_unset=True, fallback=lambda x: vars(x))
    content = {
        "scene": {"name": scene.name, **scene.model_dump(mode="json")},
        "plan": json.loads(settings.replace("Infinity", "null")),
        "points": points.plan.size,
        "base": points.task.base,
        "units": dict(units),
        "remarks": points.plan.remarks,
        "versions": {
            "cosimo": version("cosimo"),
            "python": platform.python_version(),
            "numpy": np.__version__,
            **{name: version(name) for name in ("numba", "scipy", "pyarrow")},
        },
        **more,
    }
    try:
        write_json(directory / "sweep.json", content)
        return json.dumps(content)
    except (TypeError, ValueError) as error:
        raise BadInput("sweep.json", f"{type(error).__name__}: {error}", "values that JSON has") from None
