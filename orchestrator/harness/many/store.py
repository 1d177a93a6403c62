"""Where the points of a sweep lie: parts that workers write, and what is made of them in the order of the plan.

points/<base>/*.arrow     what was computed; <base> is the digest of what results depend on besides the values that vary
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
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ....components.core.store import digest_of
from ...checkpoint import digest as scene_digest
from ...output import not_written, write_json, write_table
from ...scene.scene import Scene
from ..code_digests import components_digest
from .batches import SECTION, SIGNAL, SUFFIX, TIME, read_part, schema_of
from .measures import OUTCOMES, Row, Task
from .plan import Points

POINTS = "points"
DATA_SET = "sweep.zarr"
CHUNK = 4096  # points of the data set's and the table's pieces
PIECE = 16 * CHUNK  # points that are in memory at a time while the data set is written
LARGEST_PIECE = 8_000_000  # numbers of signals that are in memory at a time
NUMBER = "number "


@dataclass(frozen=True)
class Located:
    """Rows of a plan in the parts. part, row: (n,) where each point lies, -1 where it was not run. digests: (n,)."""

    folder: Path
    files: tuple[Path, ...]
    digests: np.ndarray
    part: np.ndarray
    row: np.ndarray

    @property
    def missing(self) -> np.ndarray:
        """Points that were not run, in the order of the plan, each digest once."""
        left = np.flatnonzero(self.part < 0)
        return left[np.sort(np.unique(self.digests[left], return_index=True)[1])]


@dataclass(frozen=True)
class Collected:
    """The columns of the numbers in the plan's order: (n,) each, in a file that the system reads as it is needed.

    outcomes, reason: (n,) places in `OUTCOMES` and in `reasons`.
    """

    numbers: Mapping[str, np.ndarray]
    outcomes: np.ndarray
    reasons: tuple[str, ...]
    reason: np.ndarray
    section: tuple[np.ndarray, ...]
    units: Mapping[str, str]
    signals: tuple[str, ...]


def base_of(scene: Scene, task: Task) -> str:
    """Digest of what the results of all points depend on: scene, what is kept, own code, version."""
    content = {
        "scene": scene_digest(scene),
        "analysis": scene.model_dump(mode="json")["analysis"],
        "quantities": list(scene.study.quantities),
        "keep": task.keep.model_dump(mode="json"),
        "version": _version(),
        "summary": task.summarize is not None,
        "components": components_digest(scene),
        "functions": {text: _source(text) for text in task.keep.functions},
    }
    return digest_of(json.dumps(content, sort_keys=True, default=str))[:16]


def _source(text: str) -> str:
    """Digest of the file of "module:name"."""
    with suppress(ImportError, ValueError, OSError):
        spec = find_spec(text.partition(":")[0])
        if spec is not None and spec.origin:
            return digest_of(Path(spec.origin).read_bytes())
    return ""


def _version() -> str:
    try:
        return version("cosimo")
    except PackageNotFoundError:
        return "not installed"


def points_folder(directory: Path, base: str) -> Path:
    """The folder of the parts, created; what killed processes have left half written is removed."""
    folder = directory / POINTS / base
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for part in folder.glob("*.part"):
            part.unlink(missing_ok=True)
    except OSError as error:
        raise not_written(directory, error) from None
    return folder


def locate_points(folder: Path, digests: np.ndarray, retry: bool = False) -> Located:
    """Where the points of a plan lie; `retry`: only those that are done count. Besides the digests, 41 bytes a point."""
    files = tuple(sorted(folder.glob("*" + SUFFIX)))
    order = np.argsort(digests, kind="stable")
    ordered = digests[order]
    part, row = (np.full(digests.size, -1, dtype=np.int32) for _ in range(2))
    done = np.zeros(digests.size, dtype=bool)
    for k, path in enumerate(files):
        try:
            table = read_part(path, columns=["digest", "outcome"])
        except Exception:  # damaged: as if it were not there
            continue
        mine = table.column("digest").to_numpy()
        good = np.array([o == "done" for o in table.column("outcome").to_pylist()], dtype=bool)
        first, last = (np.searchsorted(ordered, mine, side) for side in ("left", "right"))
        count = last - first  # points of the plan with the same values
        rows = np.repeat(np.arange(mine.size), count)
        places = order[np.repeat(last - np.cumsum(count), count) + np.arange(rows.size)]
        better = (part[places] < 0) | (good[rows] & ~done[places])  # a point that was run again after it had failed
        if retry:
            better &= good[rows]
        places, rows = places[better], rows[better]
        part[places], row[places], done[places] = k, rows, good[rows]
    return Located(folder, files, digests, part, row)


def digests_in(path: Path) -> list[int]:
    """Of the rows of a part, none where it is damaged."""
    try:
        return read_part(path, columns=["digest"]).column("digest").to_pylist()
    except Exception:  # damaged: as if it were not there
        return []


def read_row(path: Path, k: int) -> Row:
    """A row of a part."""
    table = read_part(path).slice(k, 1)
    row = Row(table.column("outcome")[0].as_py(), table.column("reason")[0].as_py())
    for field in table.schema:
        value, unit = table.column(field.name)[0], (field.metadata or {}).get(b"unit", b"").decode()
        if field.name.startswith(NUMBER):
            name = field.name.removeprefix(NUMBER)
            row.numbers[name], row.units[name] = value.as_py(), unit
        elif field.name.startswith(SIGNAL):
            name = field.name.removeprefix(SIGNAL)
            row.signals[name], row.units[name] = value.values.to_numpy(), unit
        elif field.name == TIME:
            row.time = value.values.to_numpy()
    return row


def collect(located: Located, directory: Path) -> Collected:
    """The numbers of all points in the plan's order, column by column in one file of the directory; NaN where there is none."""
    n = located.digests.size
    names: dict[str, int] = {}
    units: dict[str, str] = {}
    signals: dict[str, None] = {}
    used = [int(k) for k in np.unique(located.part[located.part >= 0])]
    for k in used:
        for item in schema_of(located.files[k]):
            name = item.name.removeprefix(NUMBER) if item.name.startswith(NUMBER) else item.name.removeprefix(SIGNAL)
            if name != item.name:
                if item.name.startswith(NUMBER):
                    names.setdefault(name, len(names))
                else:
                    signals[name] = None
                units[name] = (item.metadata or {}).get(b"unit", b"").decode()
    numbers = _mapped(directory, len(names), n)
    outcomes = np.full(n, OUTCOMES.index("not run"), dtype=np.int8)
    reasons, reason = {"": 0}, np.zeros(n, dtype=np.int32)
    sections: list[np.ndarray] = [np.zeros(0)] * n if n <= PIECE else []
    by_part = np.argsort(located.part, kind="stable")
    starts = np.searchsorted(located.part[by_part], np.arange(len(located.files) + 1))
    for k in used:
        mine = by_part[starts[k] : starts[k + 1]]
        rows = located.row[mine]
        table = read_part(located.files[k])
        outcomes[mine] = np.array([OUTCOMES.index(o) for o in table.column("outcome").to_pylist()], dtype=np.int8)[rows]
        texts = table.column("reason").to_pylist()
        reason[mine] = [reasons.setdefault(texts[r], len(reasons)) for r in rows]
        for name in table.column_names:
            if name.startswith(NUMBER):
                numbers[names[name.removeprefix(NUMBER)], mine] = table.column(name).to_numpy()[rows]
        if sections and SECTION in table.column_names:
            lists = table.column(SECTION)
            for i, r in zip(mine, rows, strict=True):
                sections[i] = np.array(lists[int(r)].as_py(), dtype=float)
    return Collected(
        {name: numbers[k] for name, k in names.items()}, outcomes, tuple(reasons), reason, tuple(sections), units, tuple(signals)
    )


def _mapped(directory: Path, columns: int, n: int) -> np.ndarray:
    """(columns, n) NaNs; of many points in a file that has no name any more, which the system pages in and out."""
    if columns * n <= LARGEST_PIECE:
        return np.full((columns, n), np.nan)
    path = directory / f".columns.{os.getpid()}"
    values = np.memmap(path, dtype=float, mode="w+", shape=(columns, n))
    with suppress(OSError):  # on Windows it stays until the end
        path.unlink()
    for k in range(columns):
        values[k] = np.nan
    return values


def write_tables(directory: Path, varied: Mapping[str, np.ndarray], units: Mapping[str, str], collected: Collected) -> Path:
    """sweep.csv and sweep.parquet: what varies, what was measured, the outcome with its reason."""
    import pyarrow
    import pyarrow.parquet as parquet

    columns = {**varied, **collected.numbers}
    names = [f"{n}, {units[n]}" if units.get(n) else n for n in columns]
    n = collected.outcomes.size
    names_of, texts = np.array(OUTCOMES, dtype=object), np.array(collected.reasons, dtype=object)

    def rows() -> Iterator[tuple[Any, ...]]:
        for first in range(0, n, CHUNK):
            some = slice(first, first + CHUNK)
            outcome = [
                o if o in ("done", "not run") else f"{o}: {texts[r]}"
                for o, r in zip(names_of[collected.outcomes[some]], collected.reason[some], strict=True)
            ]
            yield from zip(*(c[some].tolist() for c in columns.values()), outcome, strict=True)

    path = write_table(directory, "sweep.csv", [*names, "outcome"], rows())
    fields = [
        pyarrow.field(
            name, pyarrow.float64() if c.dtype.kind == "f" else pyarrow.string(), metadata={"unit": units.get(name, "")}
        )
        for name, c in columns.items()
    ]
    schema = pyarrow.schema([*fields, pyarrow.field("outcome", pyarrow.string()), pyarrow.field("reason", pyarrow.string())])
    part = directory / f".sweep.parquet.{os.getpid()}"
    with parquet.ParquetWriter(part, schema, compression="zstd") as writer:
        for first in range(0, n, CHUNK):
            some = slice(first, first + CHUNK)
            data = [np.asarray(c[some]) if c.dtype.kind == "f" else c[some].tolist() for c in columns.values()]
            data += [names_of[collected.outcomes[some]].tolist(), texts[collected.reason[some]].tolist()]
            arrays = [pyarrow.array(x, type=f.type) for x, f in zip(data, schema, strict=True)]
            writer.write_table(pyarrow.table(arrays, schema=schema))
    os.replace(part, directory / "sweep.parquet")
    return path


def write_data_set(
    directory: Path,
    varied: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    collected: Collected,
    located: Located,
    attributes: Mapping[str, Any],
    interval: float | None,
) -> Path | None:
    """sweep.zarr, put in place when it is whole; None where xarray or zarr are not installed."""
    if find_spec("xarray") is None or find_spec("zarr") is None:
        return None
    import xarray

    target, part = directory / DATA_SET, directory / f".{DATA_SET}.{os.getpid()}"
    shutil.rmtree(part, ignore_errors=True)
    names, texts = np.array(OUTCOMES), np.array(collected.reasons)

    def described(name: str) -> dict[str, str]:
        return {"long_name": name, "units": units.get(name) or "1"}

    n = collected.outcomes.size
    for first in range(0, n, PIECE):
        some = slice(first, min(first + PIECE, n))
        variables: dict[str, Any] = {m: ("point", np.asarray(c[some]), described(m)) for m, c in collected.numbers.items()}
        variables |= {"outcome": ("point", names[collected.outcomes[some]]), "reason": ("point", texts[collected.reason[some]])}
        coordinates = {name: ("point", c[some], described(name)) for name, c in varied.items()}
        data = xarray.Dataset(variables, coordinates | {"point": np.arange(some.start, some.stop)}, dict(attributes))
        if first:
            _quietly(data, part, append_dim="point", consolidated=False)
        else:
            encoding = {name: {"chunks": (CHUNK,)} for name in data.variables if name != "point"} if n > CHUNK else {}
            _quietly(data, part, encoding=encoding, mode="w", zarr_format=3, consolidated=False)
    if collected.signals:
        _write_signals(part, collected, located, described, attributes, interval)
    shutil.rmtree(target, ignore_errors=True)
    os.replace(part, target)
    return target


def _quietly(data: Any, path: Path, **options: Any) -> None:
    """Zarr warns that its type of texts is not in the specification yet."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data.to_zarr(path, **options)


def _write_signals(
    path: Path, collected: Collected, located: Located, described: Any, attributes: Mapping[str, Any], interval: float | None
) -> None:
    """Kept signals, piece by piece over the points: over "time" where all were interpolated at its multiples, else "sample"."""
    import xarray

    longest = max((m for m, _ in _lengths(located)), default=0)
    if not longest:
        return
    n, per = located.digests.size, max(1, min(CHUNK, LARGEST_PIECE // (longest * (1 + len(collected.signals)))))
    along = "time" if interval is not None else "sample"
    for first in range(0, n, per):
        piece = _signals(located, collected.signals, slice(first, min(first + per, n)), longest)
        variables: dict[str, Any] = {
            f"{name}, signal" if name in collected.numbers else name: (("point", along), piece[name], described(name))
            for name in collected.signals
        }
        coordinates: dict[str, Any] = {}
        if interval is not None:
            coordinates["time"] = ("time", interval * np.arange(longest), {"units": "s"})
        else:
            variables["time"] = (("point", along), piece[TIME], {"units": "s", "long_name": "time"})
        data = xarray.Dataset(variables, coordinates, dict(attributes))
        if first == 0:
            chunks = {name: {"chunks": (per, longest)} for name in variables}
            _quietly(data, path, encoding=chunks, mode="a", consolidated=False)
        else:
            _quietly(data.drop_vars("time") if interval is not None else data, path, append_dim="point", consolidated=False)


def _lengths(located: Located) -> Iterator[tuple[int, int]]:
    """(rows of signals, part) of the parts that have them."""
    import pyarrow.compute as compute

    for k in np.unique(located.part[located.part >= 0]):
        path = located.files[int(k)]
        if TIME in schema_of(path).names:
            lengths = compute.list_value_length(read_part(path, columns=[TIME]).column(TIME))
            yield int(compute.max(lengths).as_py() or 0), int(k)


def _signals(located: Located, names: Sequence[str], some: slice, longest: int) -> dict[str, np.ndarray]:
    """Time and signals of some points, (k, longest) each; NaN behind their ends and where there are none."""
    part, row = located.part[some], located.row[some]
    columns = [TIME, *(SIGNAL + name for name in names)]
    values = {c.removeprefix(SIGNAL): np.full((part.size, longest), np.nan) for c in columns}
    for k in np.unique(part[part >= 0]):
        path = located.files[int(k)]
        there = [c for c in columns if c in schema_of(path).names]
        table = read_part(path, columns=there)
        for i in np.flatnonzero(part == k):
            for c in there:
                one = table.column(c)[int(row[i])].values
                if one is not None:
                    values[c.removeprefix(SIGNAL)][i, : len(one)] = one.to_numpy(zero_copy_only=False)
    return values


def signals_of(located: Located, name: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """(time, values) of a kept signal at every point in the plan's order."""
    last, table = -1, None
    for part, row in zip(located.part.tolist(), located.row.tolist(), strict=True):
        if part < 0:
            yield np.zeros(0), np.zeros(0)
            continue
        if part != last:
            path = located.files[part]
            there = TIME in schema_of(path).names
            table = read_part(path, columns=[TIME, SIGNAL + name]) if there else None
            last = part
        pair = [table.column(c)[row].values for c in (TIME, SIGNAL + name)] if table is not None else [None, None]
        time, values = (np.zeros(0) if x is None else x.to_numpy(zero_copy_only=False) for x in pair)
        yield time, values


def provenance(scene: Scene, plan: Points, base: str, units: Mapping[str, str]) -> dict[str, Any]:
    """What sweep.json and the data set's attributes tell of how the numbers came about."""
    return {
        "scene": {"name": scene.name, **scene.model_dump(mode="json")},
        "plan": _plain_plan(plan),
        "points": plan.size,
        "base": base,
        "units": dict(units),
        "remarks": plan.remarks,
        "versions": {
            "cosimo": _version(),
            "python": platform.python_version(),
            "numpy": np.__version__,
            **{name: version(name) for name in ("numba", "scipy", "pyarrow")},
        },
    }


def _plain_plan(plan: Points) -> dict[str, Any]:
    return json.loads(plan.settings.model_dump_json(exclude_unset=True, fallback=lambda x: vars(x)).replace("Infinity", "null"))


def write_provenance(directory: Path, content: Mapping[str, Any]) -> None:
    """sweep.json, in place when it is whole."""
    try:
        write_json(directory / "sweep.json", content)
    except (TypeError, ValueError) as error:
        raise BadInput("sweep.json", f"{type(error).__name__}: {error}", "values that JSON has") from None
