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
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ....components.core.store import replaced
from ....fmus.versions import version
from ...output import write_json, write_table
from ...scene.scene import Scene
from . import store as stores
from .measures import own_version
from .plan import unit_of
from .store import NUMBER, SECTION, SIGNAL, TIME, StoredPlan, array_of

DATA_SET = "sweep.zarr"
NOT_RUN = "not run"
CHUNK = 4096  # points of the data set's and the table's pieces
LARGEST_PIECE = 8_000_000  # numbers that are in memory at a time


@dataclass(frozen=True)
class Collected:
    """The columns in the plan's order: (n,) each; numbers of many points in a file that the system reads as it is needed.

    varied: numbers, or texts.  outcomes: of `measures.OUTCOMES`, with their reasons.  units: by column.  signals: names of the kept
    ones, of `longest` samples at most.  section: (k,) of each point; none of more points than a piece has.
    """

    varied: Mapping[str, np.ndarray]
    numbers: Mapping[str, np.ndarray]
    outcomes: np.ndarray
    reasons: np.ndarray
    section: tuple[np.ndarray, ...]
    units: Mapping[str, str]
    signals: tuple[str, ...]
    longest: int


def collect(scene: Scene, points: StoredPlan, directory: Path) -> Collected:
    """The rows of points, column by column; NaN where there is none."""
    import pyarrow.compute as compute

    n, plan, columns = points.plan.size, points.plan, points.store.columns
    free = iter(_mapped(directory, sum(name.startswith(NUMBER) for name in columns), n))
    numbers: dict[str, np.ndarray] = {}
    signals: dict[str, None] = {}
    outcomes, reasons = np.full(n, NOT_RUN, dtype=object), np.full(n, "", dtype=object)
    texts: dict[str, str] = {}  # each once in memory
    section: list[np.ndarray] = []
    longest = 0
    for some, table in points.pieces():
        for column, target, missing in (("outcome", outcomes, NOT_RUN), ("reason", reasons, "")):
            target[some] = [texts.setdefault(t, t) for t in compute.fill_null(table.column(column), missing).to_pylist()]
        for name in table.column_names:
            if name.startswith(NUMBER):
                if (key := name.removeprefix(NUMBER)) not in numbers:
                    numbers[key] = next(free)
                numbers[key][some] = table.column(name).to_numpy()
            elif name.startswith(SIGNAL):
                signals[name.removeprefix(SIGNAL)] = None
        if TIME in table.column_names:
            longest = max(longest, compute.max(compute.list_value_length(table.column(TIME))).as_py() or 0)
        if n <= stores.PIECE:
            section = [array_of(table, SECTION, k) for k in range(n)]
    units = {name: unit_of(scene, name) for name in plan.columns}
    units |= {n: columns[SIGNAL + n] for n in signals} | {n: columns[NUMBER + n] for n in numbers}
    units |= {n: limit.unit for n, limit in plan.settings.limits.items() if units.get(n) == ""}  # own functions say none
    varied = {name: column.labels for name, column in plan.columns.items()}
    return Collected(varied, numbers, outcomes, reasons, tuple(section), units, tuple(signals), longest)


def _mapped(directory: Path, columns: int, n: int) -> np.ndarray:
    """(columns, n) NaNs; of many points in a file that has no name any more, which the system pages in and out."""
    if columns * n <= LARGEST_PIECE:
        return np.full((columns, n), np.nan)
    path = directory / f".columns.{os.getpid()}"
    values = np.memmap(path, dtype=float, mode="w+", shape=(columns, n))
    with suppress(OSError):  # on Windows it stays until the end
        path.unlink()
    for column in values:
        column[:] = np.nan
    return values


def write_tables(directory: Path, collected: Collected) -> Path:
    """sweep.csv and sweep.parquet: what varies, what was measured, the outcome with its reason."""
    import pyarrow
    import pyarrow.parquet as parquet

    units = collected.units
    columns = {**collected.varied, **collected.numbers}

    def rows() -> Iterator[tuple[Any, ...]]:
        for first in range(0, collected.outcomes.size, CHUNK):
            some = slice(first, first + CHUNK)
            ends = zip(collected.outcomes[some], collected.reasons[some], strict=True)
            outcome = [o if o in ("done", NOT_RUN) else f"{o}: {reason}" for o, reason in ends]
            yield from zip(*(c[some].tolist() for c in columns.values()), outcome, strict=True)

    header = [*(f"{n}, {units[n]}" if units.get(n) else n for n in columns), "outcome"]
    path = write_table(directory, "sweep.csv", header, rows())
    columns |= {"outcome": collected.outcomes, "reason": collected.reasons}
    kinds = {n: pyarrow.float64() if c.dtype.kind == "f" else pyarrow.string() for n, c in columns.items()}
    schema = pyarrow.schema([pyarrow.field(n, kind, metadata={"unit": units.get(n, "")}) for n, kind in kinds.items()])
    table = pyarrow.table([pyarrow.array(c, type=kinds[n]) for n, c in columns.items()], schema=schema)
    with replaced(directory / "sweep.parquet", "wb") as file:
        parquet.write_table(table, file, row_group_size=CHUNK, compression="zstd")
    return path


def write_data_set(directory: Path, collected: Collected, points: StoredPlan, attributes: Mapping[str, Any]) -> Path | None:
    """sweep.zarr, put in place when it is whole; None where xarray or zarr are not installed. Kept signals lie over "time" where
    all were interpolated at multiples of an interval, else over "sample"."""
    if find_spec("xarray") is None or find_spec("zarr") is None:
        return None
    import xarray

    n, longest, interval = collected.outcomes.size, collected.longest, points.plan.settings.keep.interval

    def described(name: str) -> dict[str, str]:
        return {"long_name": name, "units": collected.units.get(name) or "1"}

    def tables() -> Iterator[xarray.Dataset]:
        for first in range(0, n, stores.PIECE):
            some = slice(first, min(first + stores.PIECE, n))
            variables: dict[str, Any] = {m: ("point", np.asarray(c[some]), described(m)) for m, c in collected.numbers.items()}
            variables |= {"outcome": ("point", collected.outcomes[some]), "reason": ("point", collected.reasons[some])}
            coordinates = {name: ("point", c[some], described(name)) for name, c in collected.varied.items()}
            yield xarray.Dataset(variables, coordinates | {"point": np.arange(some.start, some.stop)}, dict(attributes))

    def signals() -> Iterator[xarray.Dataset]:
        along = "time" if interval is not None else "sample"
        columns = {SIGNAL + m: f"{m}, signal" if m in collected.numbers else m for m in collected.signals}
        for _, table in points.pieces([TIME, *columns], per):
            variables: dict[str, Any] = {
                name: (("point", along), _padded(table, column, longest), described(column.removeprefix(SIGNAL)))
                for column, name in columns.items()
            }
            coordinates: dict[str, Any] = {}
            if interval is not None:
                coordinates["time"] = ("time", interval * np.arange(longest), {"units": "s"})
            else:
                variables["time"] = (("point", along), _padded(table, TIME, longest), {"units": "s", "long_name": "time"})
            yield xarray.Dataset(variables, coordinates, dict(attributes))

    target, part = directory / DATA_SET, directory / f".{DATA_SET}.{os.getpid()}"
    shutil.rmtree(part, ignore_errors=True)
    _append(part, tables(), (min(CHUNK, n),))
    if longest:
        per = max(1, min(CHUNK, LARGEST_PIECE // (longest * (1 + len(collected.signals)))))
        _append(part, signals(), (per, longest))
    shutil.rmtree(target, ignore_errors=True)
    os.replace(part, target)
    return target


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
            "cosimo": own_version(),
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
