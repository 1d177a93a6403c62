"""A plan with its scene: the points as columns, each point as changes of the scene. All that is random comes from one seed."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.columns import read_table
from ....components.core.errors import BadInput
from ...run.dependence import depends_on
from ...scene.names import declared, measure_of, parameter_of
from ...scene.scene import Scene, read_toml
from ...scene.written_units import axes_with_numbers
from ...settings.messages import validated
from ...settings.plan import MOST_RUNS, SAMPLED, Choices, Distribution, PlanSettings
from .limits import with_rows
from .measures import check_analysis

SMALLEST = 2.0**-53  # of a probability: quantiles at 0 and 1 may be infinite
MOST_CHECKED = 200  # values of one axis that are checked before the first run


@dataclass(frozen=True)
class Column:
    """What one name takes at the points: numbers (n,), or places (n,) in a list of choices."""

    numbers: np.ndarray
    choices: tuple[Any, ...] | None = None

    def value(self, i: int) -> Any:
        """At a point, as the scene takes it."""
        return float(self.numbers[i]) if self.choices is None else self.choices[int(self.numbers[i])]

    @property
    def labels(self) -> np.ndarray:
        """(n,) numbers, or texts where the values are no numbers."""
        if self.choices is None:
            return self.numbers
        if all(isinstance(c, int | float) and not isinstance(c, bool) for c in self.choices):
            return np.array([float(c) for c in self.choices])[self.numbers]
        return np.array([label(c) for c in self.choices])[self.numbers]


@dataclass(frozen=True)
class Points:
    """Points of a scene. columns: by name, each of `size` values.  doubts: questions about values, see `Variable.doubt`."""

    settings: PlanSettings
    columns: Mapping[str, Column]
    size: int
    doubts: tuple[str, ...] = ()

    def values(self, i: int) -> dict[str, Any]:
        """What varies, at point i."""
        return {name: column.value(i) for name, column in self.columns.items()}

    def at(self, places: Sequence[int]) -> Points:
        """Those at some places."""
        some = np.array(places, dtype=int)
        columns = {name: Column(column.numbers[some], column.choices) for name, column in self.columns.items()}
        return Points(self.settings, columns, some.size)

    @property
    def remarks(self) -> list[str]:
        """What a user should know of the points."""
        n, texts = self.size, []
        if self.settings.method == "sobol" and n & (n - 1):
            texts.append(f"{n} points of a Sobol sequence: it is balanced at powers of two only, such as {1 << n.bit_length()}")
        if self.settings.method == "latin-hypercube" and self.settings.correlation:
            texts.append("with correlations, a Latin hypercube keeps its even spacing in the first of the correlated names only")
        return [*texts, *self.doubts]

    def digests(self, base: str, scene: Callable[[], Scene]) -> np.ndarray:
        """(n,) 64-bit numbers: of a point's values on the background of `base`, what else results depend on.

        scene: that is run. A choice that may name a file, or code, counts with the scene that it makes, and so with their contents.
        """
        names = sorted(self.columns)
        texts = {n: [json.dumps(c, sort_keys=True) for c in column.choices or ()] for n, column in self.columns.items()}
        written = [n for n, column in self.columns.items() if any(map(_has_text, column.choices or ()))]
        own = scene() if written else None
        contents: dict[tuple[int, ...], str | None] = {}
        digests = np.empty(self.size, dtype=np.int64)
        for i in range(self.size):
            whole = hashlib.blake2b(base.encode(), digest_size=8)
            for name in names:
                column = self.columns[name]
                value = float(column.numbers[i]).hex() if column.choices is None else texts[name][int(column.numbers[i])]
                whole.update(f"\n{name}={value}".encode())
            if own is not None:
                places = tuple(int(self.columns[n].numbers[i]) for n in written)
                if places not in contents:
                    contents[places] = _contents(own, {n: self.columns[n].value(i) for n in written})
                text = contents[places] or _contents(own, self.values(i)) or ""  # which is refused when it is run
                whole.update(text.encode())
            digests[i] = int.from_bytes(whole.digest(), "little", signed=True)
        return digests


def _has_text(value: Any) -> bool:
    if isinstance(value, Mapping | list | tuple):
        return any(map(_has_text, value.values() if isinstance(value, Mapping) else value))
    return isinstance(value, str)


def _contents(scene: Scene, values: Mapping[str, Any]) -> str | None:
    """What the scene with some values depends on, by its content; None where it is refused."""
    try:
        return depends_on(scene.with_changes(values), of="figures")
    except (BadInput, OSError):
        return None


def plan_settings(
    data: PlanSettings | Mapping[str, Any] | str | Path, name: str = "plan", scene: Scene | None = None, sampled: bool = True
) -> PlanSettings:
    """A plan from plain data, or from its TOML file, with the rows of its tables, which are looked for beside the file; checked.

    scene: by whose parameters numbers with their units are converted, "250 km/h"; None where there are none.
    sampled: whether the plan's own method counts; one that does not may be left out.
    """
    given, name, folder = read_settings(data, name, scene)
    if not sampled and isinstance(given, Mapping) and "method" not in given:
        given = {"method": "sobol", "points": 1, **given}
    settings = with_rows(validated(PlanSettings, given, name), folder, scene=scene)
    return settings.model_copy(update={"table": str(folder / settings.table)}) if settings.table else settings


def read_settings(data: Any, name: str, scene: Scene | None, folder: Path = Path()) -> tuple[Any, str, Path]:
    """(the data of a plan, a fit or a design, with numbers in the place of texts with units in [vary]; their name; their folder).

    data: plain, or a TOML file, which gives name and folder.
    """
    if isinstance(data, str | Path):
        path = Path(data)
        data, name, folder = read_toml(path, name, "plan"), path.name, path.parent
    if scene is not None and isinstance(data, Mapping):
        units, data = scene.settings()["units"], dict(data)
        if isinstance(runs := data.get("runs"), list | tuple):  # of a fit
            data["runs"] = [dict(r) if isinstance(r, Mapping) else r for r in runs]
        for table in (data, *data.get("runs", ())):
            if isinstance(table, dict) and isinstance(table.get("vary"), Mapping):
                table["vary"] = axes_with_numbers(table["vary"], units, f"{name}: vary")
    return data, name, folder


def plan_of(scene: Scene, settings: PlanSettings, cube: np.ndarray | None = None) -> Points:
    """The points of a plan, and a check of every value on its own before anything runs; combinations are refused at their run.

    `cube`: points (n, d) of the unit cube in the place of the method's own. Raises `BadInput`.
    """
    if settings.table:
        settings = settings.model_copy(update={"vary": read_points(Path(settings.table), scene)})
    columns = _columns(settings, cube)
    size = next(iter(columns.values())).numbers.size
    doubts = []
    for name, column in columns.items():
        if (known := parameter_of(scene, name)) is not None:
            numbers = column.labels if column.labels.dtype.kind == "f" else ()
            texts = (f"{name} = {v:g}: {known.doubt(v)}" for v in numbers if known.doubt(v))
            doubts += [text for text in [next(texts, "")] if text]
    plan = Points(settings, columns, size, tuple(doubts))
    _check_values(scene, plan)
    return plan


def _columns(settings: PlanSettings, cube: np.ndarray | None) -> dict[str, Column]:
    axes, method = settings.vary, settings.method
    choices = {name: axis.values for name, axis in axes.items() if isinstance(axis, Choices)}
    if cube is None and method not in SAMPLED:
        lengths = [len(c) for c in choices.values()]
        if method == "list":
            return {name: Column(np.arange(lengths[0]), c) for name, c in choices.items()}
        if (size := int(np.prod(lengths, dtype=float))) > MOST_RUNS:
            raise BadInput("plan", f"{size} points", f"at most {MOST_RUNS}")
        places = np.unravel_index(np.arange(size), lengths)
        return {name: Column(k.astype(np.int32), c) for (name, c), k in zip(choices.items(), places, strict=True)}
    u = unit_points(method, settings.points or 0, len(axes), settings.seed) if cube is None else cube
    if settings.correlation:
        u = correlated(u, matrix_of([*axes], settings.correlation))
    columns = {}
    for k, (name, axis) in enumerate(axes.items()):
        if isinstance(axis, Distribution):
            columns[name] = Column(quantile(axis, u[:, k]))
        else:
            columns[name] = Column((u[:, k] * len(axis.values)).astype(np.int32), axis.values)
    return columns


def unit_points(method: str, n: int, d: int, seed: int) -> np.ndarray:
    """(n, d) in (0, 1). The first points of "sobol" and "random" do not depend on n, so that more can be added; those of a Latin
    hypercube do. Sequences are SciPy's (`scipy.stats.qmc`), Sobol's scrambled."""
    from scipy.stats import qmc

    if method == "random":
        u = np.random.default_rng(seed).random((n, d))
    elif method == "latin-hypercube":
        u = qmc.LatinHypercube(d, seed=seed).random(n)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # n is no power of two: see `Points.remarks`
            u = qmc.Sobol(d, seed=seed).random(n)
    return np.clip(u, SMALLEST, 1.0 - SMALLEST, out=u)


def other_starts(starts: int, d: int, seed: int) -> list[np.ndarray]:
    """Where searches start besides the first one, (d,) each in (0, 1): a Latin hypercube."""
    return list(unit_points("latin-hypercube", starts - 1, d, seed)) if starts > 1 else []


def correlated(u: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (n, d) of the unit cube whose normal scores have the correlation `matrix` (d, d): a normal copula, by Cholesky.

    Raises `BadInput` for a matrix that no correlations have. A Latin hypercube keeps its strata in the first of two only.
    """
    from scipy.special import ndtr, ndtri

    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise BadInput("correlation", "correlations that contradict one another", "a positive definite matrix") from None
    return np.clip(ndtr(ndtri(u) @ lower.T), SMALLEST, 1.0 - SMALLEST)


def quantile(d: Distribution, u: np.ndarray) -> np.ndarray:
    """The numbers below which a share u (n,) of the distribution lies."""
    from scipy.special import ndtr, ndtri

    if d.shape == "uniform":
        return d.low + u * (d.high - d.low)
    if d.shape == "triangular":
        width, rise = d.high - d.low, d.mode - d.low
        return np.where(u * width < rise, d.low + np.sqrt(u * width * rise), d.high - np.sqrt((1.0 - u) * width * (width - rise)))
    side = (
        -1.0 if d.low > d.mean else 1.0
    )  # above the mean a probability is 1 less what is lost in its rounding: look from the other side
    ends = sorted(side * (end - d.mean) / d.deviation for end in (d.low, d.high))
    below, above = ndtr(ends)
    if not (below < above and above > 1e-300):
        raise BadInput("vary", f"a normal distribution cut off from {d.low:g} to {d.high:g}", "ends nearer to its mean")
    share = u if side > 0.0 else 1.0 - u
    return np.clip(d.mean + side * d.deviation * ndtri(below + share * (above - below)), d.low, d.high)


def matrix_of(names: Sequence[str], pairs: Sequence[tuple[str, str, float]]) -> np.ndarray:
    """Correlation matrix of names from pairs."""
    matrix, place = np.eye(len(names)), {n: k for k, n in enumerate(names)}
    for first, second, r in pairs:
        matrix[place[first], place[second]] = matrix[place[second], place[first]] = r
    return matrix


def read_points(path: Path, scene: Scene) -> dict[str, Choices]:
    """Points from a CSV: names in the first line, with or without their units; raises `BadInput`."""
    table = read_table(path, "table")
    if not table.rows:
        raise BadInput(str(path), "no points", "a line of names and at least one line of values")
    columns: dict[str, Choices] = {}
    for text, name, unit in zip(table.header, table.names, table.units, strict=True):
        if _is_variable(scene, text):  # of an FMU, whose names may look as if they had a unit
            name, unit = text, ""
        own, where = measure_of(scene, name), f"{path}, column {text!r}"
        if name in columns:
            raise BadInput(str(path), f"{name!r} twice", "each name once")
        if unit and not own:
            raise BadInput(where, f"unit {unit!r}", f"a name alone, as the unit of {name} is not known")
        cells = table.texts(text)
        if not all(cells):
            raise BadInput(f"{path}, line {table.rows[cells.index('')][0]}, column {text!r}", "an empty cell", "a value")
        values = [_cell(cell) for cell in cells]
        if unit or any(isinstance(value, str) for value in values):
            try:
                values = table.numbers(text, own).tolist()
            except BadInput:
                if unit or all(cell[-1:].isdigit() for cell in cells):
                    raise
        columns[name] = Choices(tuple(values))
    return columns


def _is_variable(scene: Scene, name: str) -> bool:
    unit, variable = scene.split(name)
    return variable in declared(scene, unit)


def from_columns(columns: Mapping[str, Iterable[Any]]) -> dict[str, Any]:
    """Plain data of a plan for points in columns: a mapping of lists, or a data frame of pandas."""
    return {"method": "list", "vary": {str(name): list(columns[name]) for name in columns}}


def _cell(text: str) -> Any:
    text = text.strip()
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            pass
    return {"true": True, "false": False}.get(text.lower(), text)


def label(value: Any) -> str:
    """A value that is no number, as tables and axes show it."""
    if isinstance(value, list | tuple):
        return ", ".join(map(label, value)) or "none"
    if isinstance(value, Mapping):
        return json.dumps(value, sort_keys=True)
    return str(value).lower() if isinstance(value, bool) else str(value)


def _check_values(scene: Scene, plan: Points) -> None:
    """Refuse, before the first run, what the scene cannot take on the background of the first point."""
    first = plan.values(0)
    checked = {0}
    if plan.settings.method != "list":
        for column in plan.columns.values():
            if column.choices is not None:
                checked |= {int(k) for k in np.unique(column.numbers, return_index=True)[1][:MOST_CHECKED]}
    check_analysis(scene.with_changes(first))
    for i in sorted(checked - {0}):
        other = plan.values(i)
        for name in plan.columns:
            if other[name] != first[name]:
                try:
                    check_analysis(scene.with_changes(first | {name: other[name]}))
                except BadInput:
                    # refused with the first point's other values; only what no other values could mend ends the sweep
                    if plan.settings.method != "grid" or len(plan.columns) == 1 or not _elsewhere(scene, name, other[name]):
                        raise


def _elsewhere(scene: Scene, name: str, value: Any) -> bool:
    """Whether the scene's own settings take the value."""
    try:
        check_analysis(scene.with_changes({name: value}))
    except BadInput:
        return False
    return True
