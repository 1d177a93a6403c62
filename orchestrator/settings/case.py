"""A case of a user's own: a scene, under conditions, against ranges and measured curves; a TOML file.

title = "Line 7 at 200 km/h"
scene = "line-7.toml"                              # a file beside this one, or the name of a shipped scene
sources = { limits = "operator's limits, sheet 12 of 2025", train = "measuring train, run 4, 3 March 2026" }

limits = "en50367"                                 # optional: a table that every run is judged by

[[runs]]
condition = "200 km/h"
changes = { "pantograph.speed" = 55.56 }

[[rows]]
quantity = "mean force"
measure = "pantograph.mean"                        # of the run's summary, or "pantograph.contact_force, maximum below 20 Hz"
unit = "N"
low = 70.0
high = 120.0
standing = "verbatim"
source = "limits"

[[curves]]
signal = "pantograph.contact_force"
over = "pantograph.contact_position"               # the measurement stands over a position; without it over time
file = "force.csv"
over_column = "x_m"
column = "F_N"
cutoff = 20.0
tolerances = { mean = 0.05, "standard deviation" = 0.2 }
source = "train"
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from ..renamed import with_new_keys
from .chart import ChartSettings
from .document import DocumentSettings
from .measured import MeasuredSeries
from .model import Model, Number, Positive, Truth
from .plan import RunLimits

COMPARED = ("mean", "standard deviation", "maximum", "minimum", "difference")
Share = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]


class RunSettings(Model):
    """One run of the case's scene."""

    condition: str = Field(description="name of the run in rows, curves and the report")
    changes: dict[str, Any] = Field(default={}, description="dotted place of a setting of the scene -> its value")


class SceneChanges(Model):
    """A shipped scene with other settings."""

    scene: str
    changes: dict[str, Any] = Field(default={}, description="dotted place of a setting of the scene -> its value")


class CurveSettings(MeasuredSeries):
    """A measured curve that a signal of a run is compared with."""

    condition: str = Field(default="", description="the run; without it the only one")
    over: str = Field(default="", description='"unit.output" that rises throughout the run, such as a position; without it time')
    over_column: str = Field(default="", description="column of the signal in `over`, in its unit or that of the header")
    shift: Number = Field(default=0.0, description="added to the time, s, or to the column of `over`, in its unit")
    cutoff: Positive | None = Field(default=None, description="Hz, low-pass filter of both; without it none")
    tolerances: dict[str, Share] = Field(
        default={},
        description=(
            "mean, maximum, minimum: of the measured number's size; standard deviation: of the measured one; "
            "difference: root mean square difference over the measured standard deviation"
        ),
    )
    source: str = Field(description="a key of `sources`")

    @model_validator(mode="before")
    @classmethod
    def _of_earlier_versions(cls, data: Any) -> Any:
        """`abscissa` was the column of the time, or that of `over`."""
        if not isinstance(data, Mapping):
            return data
        return with_new_keys(data, {**cls.FORMER, "abscissa": "over_column" if data.get("over") else "time"})

    @model_validator(mode="after")
    def _over_what(self) -> CurveSettings:
        given = self.model_fields_set
        if self.over and (unused := sorted({"time", "delay"} & given)):
            raise BadInput(unused[0], f"{getattr(self, unused[0])!r} with over = {self.over!r}", "over_column, or a time alone")
        if "over_column" in given and not self.over:
            raise BadInput("over_column", repr(self.over_column), 'over = "unit.output" as well')
        return self


class CaseSettings(Model):
    """The whole file; rows are those of reference tables."""

    title: str
    text: str = Field(default="", description="text of the case: its statement and its limits")
    scene: str
    limits: RunLimits = Field(default=None, description="table that every run is judged by, as in a scene")
    sources: dict[str, str] = Field(default={}, description="sources of rows and curves, by name")
    runs: tuple[RunSettings, ...] = Field(default=(), description="without them one run of the scene with its own settings")
    rows: tuple[dict[str, Any], ...] | str = Field(
        default=(), description="rows of the table, or the name of a CSV file with them"
    )
    curves: tuple[CurveSettings, ...] = ()
    measure: str = Field(
        default="",
        description='"module:function" that gives numbers of the runs by the measures of rows and the names in charts, beside '
        "those of the summary; a module beside this file, or an installed one",
    )
    charts: tuple[ChartSettings, ...] = Field(default=(), description="figures of the runs, whose labels are the conditions")
    document: DocumentSettings = Field(
        default=DocumentSettings(), description="what the report says of itself, as in a scene; default: that of the scene"
    )


class QuestionSettings(Model):
    """A question of a shipped case: the function that measures, and what is run for it."""

    measure: str = Field(
        default="",
        description="module beside the case's file, with `measure(runs)` and, where it needs runs, `scenes()`; or "
        '"module:function"; without it rows are of the summaries of the runs that their conditions name',
    )
    scenes: str | dict[str, str | SceneChanges] = Field(
        default="", description='"module:function" that gives scenes by label, or label -> a shipped scene and its changes'
    )
    arguments: dict[str, Any] = Field(default={}, description="of the function that measures, beside the runs")
    may_fail: tuple[str, ...] = Field(default=(), description="labels of runs that may end before their end; patterns")
    at_its_steps: tuple[str, ...] = Field(
        default=(), description="labels of runs whose steps are what is asked about, so that a repetition leaves them; patterns"
    )
    in_process: Truth = Field(default=False, description="whatever is asked for, as there are many short runs")
    study: Truth = Field(default=False, description="it explains the answers of the others, and is not repeated for errors")
    claim: str = Field(default="", description="number of the paper's claim below whose rows its figures stand")
    notes: tuple[str, ...] = Field(default=(), description="sentences, which may show what is measured: {name:.2f}")
    show: tuple[str, ...] = Field(default=(), description="labels of runs whose figures are in the report; patterns")


class ShippedCaseSettings(Model):
    """The file of a shipped case; the rows of its table stand in the CSV file of its name."""

    title: str
    text: str = Field(description="text of the case: its statement and its limits")
    about: str = Field(default="", description="what the numbers of the table are of")
    measures: str = Field(default="", description='"module:function" that gives the measures of the rows of any run')
    rules: str = Field(default="", description='"module:function" that says of a run which conditions hold')
    scene_conditions: str = Field(default="", description='"module:function" that says which hold for all runs of a scene')
    objects: str = Field(
        default="", description='"module:function" that names the objects of a scene, each of which has the rows'
    )
    check: str = Field(default="", description='"module:function" that refuses a scene with nothing to compare')
    sources: dict[str, str] = Field(default={}, description="of rows, by the keys in their column")
    claims: tuple[dict[str, Any], ...] = Field(default=(), description="of a paper")
    questions: tuple[QuestionSettings, ...]
    charts: tuple[ChartSettings, ...] = ()
