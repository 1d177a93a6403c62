"""What many runs of one scene vary and keep: a plan, a TOML file or the same as plain data in Python.

method = "sobol"                                  # grid, list, latin-hypercube, sobol or random
points = 256                                      # of the last three
seed = 7

[vary]
"pantograph.static_force" = { distribution = "normal", mean = 70.0, deviation = 5.0, low = 50.0 }
"pantograph.speed" = { distribution = "uniform", low = 40.0, high = 90.0 }
"catenary.effects.dropper_slackening" = [true, false]
"units.pantograph.preset" = ["first", "second"]

[keep]
quantities = ["pantograph.contact_force, maximum below 20 Hz"]
signals = ["pantograph.contact_force"]
interval = 0.01

[limits]                                          # that columns of a run should keep; in a design they are [constraints]
"pantograph.std" = { high = 40.0 }

Limits may as well be rows of a validation table, above the first table of the plan:
rows = { table = "en50367", conditions = ["AC above 200 km/h"] }
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from ...components.core.errors import BadInput, counted, nearest, pick
from .model import RANGE, Model, Number, Seconds, Truth, ranged
from .ranges import OLD_STANDINGS, Range
from .study import Quantities

SAMPLED = ("latin-hypercube", "sobol", "random")
MOST_RUNS = 10_000_000
SHAPES = {  # of a distribution: what it must say, what it may say
    "normal": (("mean", "deviation"), ("low", "high")),
    "uniform": (("low", "high"), ()),
    "triangular": (("low", "mode", "high"), ()),
}


Standing = Annotated[
    Literal["", "verbatim", "measured", "computed", "inferred", "unconfirmed"],
    BeforeValidator(lambda word: OLD_STANDINGS.get(word, word) if isinstance(word, str) else word),
]


class LimitSettings(Range, Model):
    """A column of a run that must stay between two numbers, one or both."""

    low: Number | None = None
    high: Number | None = None
    quantity: str = Field(default="", description="in words, with its condition")
    unit: str = Field(default="", description="unit of measure of both numbers; it must fit the column")
    standing: Standing = Field(default="", description="source of the range; a range quoted from memory is marked")
    source: str = ""

    @model_validator(mode="after")
    def _limits(self) -> LimitSettings:
        self.check_ends()
        return self


class RowsSettings(Model):
    """Rows of a validation table."""

    table: str = Field(description="name of a shipped table, or a TOML file with sources and rows, such as a case of one's own")
    conditions: tuple[str, ...] = Field(default=(), description="conditions that apply; default: all rows of the table")


RunLimits = Annotated[RowsSettings | None, BeforeValidator(lambda value: {"table": value} if isinstance(value, str) else value)]


@dataclass(frozen=True)
class Distribution:
    """Of a number: normal (cut off at low and high where they are given), uniform or triangular; numbers in the SI unit."""

    shape: str
    low: float = -float("inf")
    high: float = float("inf")
    mean: float = 0.0
    deviation: float = 1.0
    mode: float = 0.0


@dataclass(frozen=True)
class Choices:
    """Values that are taken as they are: numbers, texts, truth values, lists of effects, tables of units."""

    values: tuple[Any, ...]


Axis = Distribution | Choices


class KeepSettings(Model):
    """What is kept of every run."""

    statistics: Truth = Field(default=True, description="minimum, maximum, mean, standard deviation of every recorded signal")
    summary: Truth = Field(default=True, description="the figures of the scene's system, as in summary.json")
    quantities: Quantities = Field(default=(), description='"unit.output, kind", as in [study]; those of the scene as well')
    functions: tuple[str, ...] = Field(
        default=(), description='"module:function" of a Result, which returns a number or numbers by name'
    )
    signals: tuple[str, ...] = Field(default=(), description='"unit.output", kept as time histories')
    interval: Seconds | None = Field(default=None, description="s: signals interpolated at its multiples; default: every row")

    @field_validator("functions")
    @classmethod
    def _named(cls, functions: tuple[str, ...]) -> tuple[str, ...]:
        for text in functions:
            if not all(text.partition(":")[::2]):
                raise BadInput("", repr(text), '"module:function"')
        return functions

    @model_validator(mode="after")
    def _interval_has_effect(self) -> KeepSettings:
        if self.interval is not None and not self.signals:
            raise BadInput("interval", f"{self.interval:g} s without signals", "signals = [...] as well")
        return self


class PlanSettings(Model):
    """The points that are run, and the results that are kept of them."""

    method: Literal["grid", "list", "latin-hypercube", "sobol", "random"] = Field(
        default="grid", description="grid: every combination; list: the first values together, the second ...; others: samples"
    )
    points: Annotated[int, Field(strict=True, ge=1, le=MOST_RUNS)] | None = Field(default=None, description="number of samples")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(
        default=0, description="seed of the samples; equal seeds give equal points"
    )
    table: str = Field(default="", description="CSV of points beside the plan: names in the first line; method list")
    vary: Annotated[dict[str, Any], WithJsonSchema({"type": "object"})] = Field(
        default={}, description="name = [values], { from, to, points } or { distribution = ... }"
    )
    correlation: tuple[tuple[str, str, Number], ...] = Field(
        default=(), description="[name, name, r]: r of the normal scores of two distributions (a normal copula)"
    )
    keep: KeepSettings = KeepSettings()
    limits: dict[str, LimitSettings] = Field(default={}, description="column = { low = ..., high = ... }, drawn in the figures")
    rows: RowsSettings | None = Field(default=None, description="rows of a validation table that are limits as well")

    @field_validator("vary", mode="before")
    @classmethod
    def _axes(cls, table: Any) -> Any:
        return dict(_axes(table)) if isinstance(table, Mapping) else table

    @model_validator(mode="after")
    def _fits(self) -> PlanSettings:
        sampled = self.method in SAMPLED
        if bool(self.vary) == bool(self.table):
            actual = "both table and vary" if self.table else "neither vary nor table"
            raise BadInput("", actual, "one of them", 'Write [vary] with "unit.parameter" = [values], or table = "points.csv".')
        if self.table and self.method != "list":
            raise BadInput("table", f"with method {self.method!r}", 'method = "list"')
        if sampled and self.points is None:
            raise BadInput("points", "nothing", f"how many points method {self.method!r} takes")
        if not sampled:
            for key in ("points", "seed", "correlation"):
                if key in self.model_fields_set:
                    raise BadInput(
                        key, f"with method {self.method!r}", "one of " + ", ".join(SAMPLED), "It would have no effect."
                    )
            for name, axis in self.vary.items():
                if isinstance(axis, Distribution):
                    raise BadInput(
                        f"vary.{name}",
                        f"a distribution with method {self.method!r}",
                        "values, or another method",
                        'Samples are taken by method = "latin-hypercube", "sobol" or "random".',
                    )
        lengths = {name: len(axis.values) for name, axis in self.vary.items() if isinstance(axis, Choices)}
        if self.method == "list" and len(set(lengths.values())) > 1:
            raise BadInput("vary", ", ".join(f"{n}: {counted(k, 'value')}" for n, k in lengths.items()), "lists of one length")
        pairs = [frozenset(pair[:2]) for pair in self.correlation]
        for k, (first, second, r) in enumerate(self.correlation):
            if pairs[k] in pairs[:k]:
                raise BadInput("correlation", f"{first}, {second} twice", "each pair of names once")
            for name in (first, second):
                if not isinstance(self.vary.get(name), Distribution):
                    raise BadInput(
                        "correlation",
                        repr(name),
                        "a name that varies by a distribution",
                        nearest(name, [n for n, a in self.vary.items() if isinstance(a, Distribution)]),
                    )
            if first == second or not -1.0 < r < 1.0:
                raise BadInput("correlation", f"{first}, {second}: {r:g}", "two names, and a number between -1 and 1")
        return self


def _axes(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Axis]]:
    """Full names with what they vary over; nested tables are names with dots."""
    for key, value in table.items():
        name = prefix + key
        if isinstance(value, Distribution | Choices):
            yield name, value
        elif isinstance(value, Mapping) and "distribution" in value:
            yield name, _distribution(name, value)
        elif isinstance(value, Mapping) and value.keys() & set(RANGE):
            ((_, values),) = ranged({name: value})
            yield name, Choices(tuple(values))
        elif isinstance(value, Mapping):
            yield from _axes(value, name + ".")
        elif isinstance(value, list | tuple) and value:
            yield name, Choices(tuple(_element(name, v) for v in value))
        else:
            raise BadInput(name, repr(value), "a list of values, { from, to, points } or { distribution = ... }")


def _element(name: str, value: Any) -> Any:
    """A value of a list: what TOML has, but for dates, and finite."""
    if hasattr(value, "item"):
        value = value.item()  # of NumPy
    if not isinstance(value, bool | int | float | str | list | tuple | Mapping) or (
        isinstance(value, float) and not isfinite(value)
    ):
        raise BadInput(name, repr(value), "finite numbers, texts, truth values, lists or tables")
    return value


def _distribution(name: str, table: Mapping[str, Any]) -> Distribution:
    where, shape = name, table["distribution"]
    pick(shape, SHAPES, where, "one of " + ", ".join(SHAPES), "distribution")
    needed, optional = SHAPES[shape]
    given = {key: value for key, value in table.items() if key != "distribution"}
    if not set(needed) <= given.keys() <= {*needed, *optional}:
        raise BadInput(
            where,
            ", ".join(given) or "nothing else",
            f"{', '.join(needed)} of a {shape} distribution" + (f", and possibly {', '.join(optional)}" if optional else ""),
        )
    for key, value in given.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise BadInput(f"{where}.{key}", repr(value), "a finite number")
    d = Distribution(shape, **{key: float(value) for key, value in given.items()})
    if not d.low < d.high or d.deviation <= 0.0 or (shape == "triangular" and not d.low <= d.mode <= d.high):
        expected = {"triangular": "low <= mode <= high", "normal": "a positive deviation, low < high"}.get(shape, "low < high")
        raise BadInput(where, ", ".join(f"{k} = {v:g}" for k, v in given.items()), expected)
    return d
