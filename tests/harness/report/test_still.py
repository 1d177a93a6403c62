"""Still pictures of figures: numbers stand where the axes say, on linear, logarithmic and named axes; every kind of figure has one."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from cosimo.orchestrator.harness.charts.chart import Band, Chart, Panel, Picture, Series
from cosimo.orchestrator.harness.charts.charts import draw_chart
from cosimo.orchestrator.harness.charts.still import still
from cosimo.orchestrator.harness.charts.still_axes import WIDTH, axes_of
from cosimo.orchestrator.harness.charts.style import axis, layout, line

SVG = "{http://www.w3.org/2000/svg}"


def picture(figure, name="f1"):
    """Its elements; it is XML."""
    return ET.fromstring(still(figure, name))


def panel(series, **more):
    """A figure of one panel."""
    return draw_chart(Chart("t", "x", (Panel("y", series, **more),))).figure


def points(root):
    """Places (n, 2), px, of the path with the most points."""
    paths = [p.get("d") for p in root.iter(f"{SVG}path") if p.get("fill") == "none"]
    return np.array(re.findall(r"[ML]?(-?[\d.]+) (-?[\d.]+)", max(paths, key=len)), dtype=float)


def test_a_line_stands_where_its_axes_say():
    x, y = np.array([0.0, 1.0, 2.0]), np.array([1.0, 3.0, 2.0])
    figure = {
        "data": [line(x, y, "a", "#000000")],
        "layout": layout(300, xaxis=axis("x", range=[0, 2]), yaxis=axis("y", range=[0, 4])),
    }
    found = points(picture(figure))
    margin = figure["layout"]["margin"]
    width, height = WIDTH - margin["l"] - margin["r"], 300 - margin["t"] - margin["b"]
    assert found[:, 0] == pytest.approx(margin["l"] + 0.5 * width * x, abs=0.06)
    assert found[:, 1] == pytest.approx(margin["t"] + height * (1.0 - 0.25 * y), abs=0.06)


def test_a_logarithmic_axis_has_its_decades():
    axes = axes_of(
        {"data": [line([1.0, 2.0], [1e-3, 1e3], "a", "#000000")], "layout": layout(300, yaxis=axis("y", type="log"))} | {}
    )
    decades = [text for _, text in axes["y"].ticks()]
    assert decades == ["0.001", "0.01", "0.1", "1", "10", "100", "1000"]
    assert axes["y"].pixel(1.0) == pytest.approx(0.5 * (axes["y"].pixel(1e-3) + axes["y"].pixel(1e3)))


def test_gaps_stay_gaps_and_long_lines_keep_their_extremes():
    x = np.linspace(0.0, 1.0, 100_001)
    y = np.where((x > 0.4) & (x < 0.6), np.nan, np.sin(300.0 * x))
    y[77_777] = 9.0
    root = picture(panel((Series("a", x, y),)))
    (path,) = [p.get("d") for p in root.iter(f"{SVG}path") if len(p.get("d")) > 2000 and p.get("fill") == "none"]
    assert path.count("M") >= 2
    assert path.count("L") < 2000
    first, second, *_ = sorted(float(b) for b in re.findall(r" (-?[\d.]+)", path))
    assert second - first > 100.0  # px: the one sample of 9 is higher than all others


def test_every_kind_of_figure_has_a_picture():
    grid = np.add.outer(np.arange(3.0), np.arange(4.0))
    maps = Picture([0, 1, 2, 3], [0, 1, 2], grid, "z", "range", (2.5,))
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": ["a", "b"],
        "x": [1.0, 2.0],
        "error_x": {"array": [0.1, 0.2]},
        "marker": {"color": "#123456"},
    }
    for figure in (
        panel((Series("a", [0, 1], [0, 1], "points"), Series("b", [0, 1], [1, 0], "line+points")), bands=(Band("r", 0.2, 0.8),)),
        panel((Series("a", ["x", "y"], [1.0, 2.0], "line+points"),)),
        panel((Series("a", [0, 1, 2], [1, 2, 3], "points", shades=[-1.0, 0.0, 2.0]),)),
        panel((), picture=maps),
        {"data": [bars], "layout": layout(200, yaxis=axis("", autorange="reversed"))},
    ):
        text = still(figure, "f1")
        ET.fromstring(text)
        assert "nan" not in text


def test_a_figure_that_only_a_script_shows_has_none():
    assert still({"data": [{"type": "parcoords", "dimensions": []}], "layout": layout(300)}, "f1") == ""


def test_texts_are_escaped():
    evil = "</svg><script>alert(1)</script>"
    text = still(panel((Series(evil, [0, 1], [0, 1]), Series("b", [0, 1], [1, 0])), title=evil), "f1")
    assert "<script" not in text
    ET.fromstring(text)
