"""Charts of a case as data: panels of signals of its runs, of the numbers that it measures, and of the ranges of its rows."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from .model import Model, Number, Truth, Whole

Names = str | tuple[str | Number, ...]


class LineSettings(Model):
    """What a series says; a panel or a chart may say it for all of its series."""

    run: str = Field(
        default="", description="label of the run whose signal is drawn; a pattern such as * for several, a series each"
    )
    over: str = Field(default="time", description='"unit.output" along the x axis; without it time')
    x: Names = Field(default="", description="numbers along the x axis: the name of what is measured, or a list")
    scale: Number | str = Field(
        default=1.0, description="times the signal or the numbers; of a signal also the unit that is shown"
    )
    x_scale: Number | str = Field(default=1.0, description="times what is along the x axis; of a signal also its unit")
    since: Number | None = Field(default=None, description="s, where what is shown of a run begins")
    until: Number | None = Field(default=None, description="s, where it ends")
    every: Whole = Field(default=1, description="rows of the run from one point to the next", ge=1)
    kind: Literal["line", "points", "line+points", "dots"] = "line"
    faint: Truth = Field(default=False, description="context, thin and pale")


class SeriesSettings(LineSettings):
    """One line or set of points: a `signal` of a run, numbers `y`, or `each` of a table."""

    name: str = Field(default="", description="in the legend; without it the signal, or the run where `run` is a pattern")
    signal: str = Field(default="", description='"unit.output"')
    y: Names = Field(
        default="", description='numbers: the name of what is measured, a pattern such as "lag.*", or a list of both'
    )
    each: str = Field(default="", description="name of a table that is measured: name of a series -> its y, or its (x, y)")
    labels: str | tuple[str, ...] = Field(default=(), description="a text for each point, or the name of what is measured")
    shades: str = Field(
        default="", description="numbers that are shown as the colours of the points: the name of what is measured"
    )
    shade_label: str = ""


class BandSettings(Model):
    """A range that is shaded."""

    name: str = ""
    low: Number | None = None
    high: Number | None = None


class PictureSettings(Model):
    """Values over a rectangle."""

    values: str = Field(description="name of what is measured: (x, y, values (len(y), len(x)))")
    label: str = Field(default="", description="of the scale")
    palette: Literal["binary", "rising", "range", "diverging"] = "rising"
    limits: tuple[Number, ...] = Field(default=(), description="values with a line through the places that have them")


class PanelSettings(LineSettings):
    """One pair of axes."""

    label: str = Field(description="of the y axis, with the unit: feed, mm")
    series: tuple[SeriesSettings, ...] = ()
    title: str = ""
    limits: dict[str, str] | tuple[str, ...] = Field(
        default=(),
        description='rows whose ranges are shaded, by their measures, or "condition: measure"; name in the chart -> row',
    )
    bands: tuple[BandSettings, ...] = ()
    marks: str | tuple[tuple[Number, str], ...] = Field(
        default=(), description="thin vertical lines: [position, short text], or the name of what is measured"
    )
    lines: dict[str, str | tuple[tuple[Number, str], ...]] = Field(
        default={},
        description="name in the legend -> places on the x axis: [position, short text], or the name of what is measured",
    )
    picture: PictureSettings | None = None
    x_label: str = Field(default="", description="of an x axis of its own")
    equal: Truth = Field(default=False, description="one length in both directions, as for orbits")
    logarithmic: Truth = False
    x_range: tuple[Number, Number] | None = None
    y_range: tuple[Number, Number] | None = None


class ChartSettings(LineSettings):
    """A figure of panels over one x axis, or a table: a header and rows.

    Title and text may show what is measured: {name}, with a format as in {name:.2f}.
    """

    title: str
    question: str = Field(
        default="", description="`measure` of the question whose runs and numbers it shows, if there are several"
    )
    text: str = ""
    x_label: str = ""
    columns: Whole = Field(default=1, description="panels side by side")
    height: Whole = Field(default=0, description="of a panel, px; 0: as usual")
    panels: tuple[PanelSettings, ...] = ()
    header: tuple[str, ...] = Field(default=(), description="of a table, with units")
    rows: str | tuple[tuple[Any, ...], ...] = Field(
        default=(), description="of a table: the name of what is measured, or lists of numbers by name and of texts"
    )
