"""Charts as data become figures that hold every number, picture and line they were given."""

import json
import re
from types import SimpleNamespace

import numpy as np
import plotly.graph_objects as go
import pytest
from cosimo.orchestrator.harness.charts.chart import Chart, Lines, Panel, Picture, Series
from cosimo.orchestrator.harness.charts.charts import DRAWN_DOTS, draw_chart
from cosimo.orchestrator.harness.charts.style import DARK
from cosimo.orchestrator.harness.report.bifurcation import bifurcation_chart, section_panel
from cosimo.orchestrator.harness.report.page import Page, write_page
from cosimo.orchestrator.systems.bearings.figures import charts_over_time


def drawn(*panels, **more):
    figure = draw_chart(Chart("t", "x, m", panels, **more)).figure
    go.Figure(figure)
    json.dumps(figure, allow_nan=False)
    return figure


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6, 7])
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_panels_of_any_number_fit_the_page(count, columns):
    figure = drawn(*(Panel("y, m", (Series("s", [0, 1], [0, 1]),), title="p") for _ in range(count)), columns=columns)
    domains = [a["domain"] for k, a in figure["layout"].items() if re.match(r"[xy]axis", k)]
    assert len(domains) == 2 * count
    assert all(0.0 <= a < b <= 1.0 for a, b in domains)


def test_panels_share_an_axis_unless_they_have_their_own():
    shared = Panel("y, m", (Series("s", [0, 1], [0, 1]),))
    own = Panel("y, m", (Series("s", [0, 1], [0, 1]),), x_label="z, m")
    layout = drawn(shared, shared, own)["layout"]
    assert layout["xaxis2"]["matches"] == "x"
    assert "matches" not in layout["xaxis3"]
    assert layout["xaxis3"]["title"]["text"] == "z, m"


def test_equal_panels_have_equal_lengths_about_the_middle_of_the_data():
    layout = drawn(Panel("y, m", (Series("s", [1, 3], [10, 11]),), equal=True))["layout"]
    assert layout["yaxis"]["scaleanchor"] == "x"
    assert np.mean(layout["xaxis"]["range"]) == pytest.approx(2.0)
    assert np.mean(layout["yaxis"]["range"]) == pytest.approx(10.5)
    assert np.ptp(layout["xaxis"]["range"]) == pytest.approx(np.ptp(layout["yaxis"]["range"]))
    assert np.ptp(layout["xaxis"]["range"]) > 2.0


def test_lines_reach_over_the_panel_and_name_what_has_room():
    lines = Lines("race", ((1.0, "one"), (1.1, "two"), (1.2, "three"), (5.0, "five"), (6.0, "")))
    figure = drawn(Panel("y, m", (Series("s", [0, 10], [1, 100]),), lines=(lines,), logarithmic=True, y_range=(0.1, 1000.0)))
    trace = next(t for t in figure["data"] if t["name"] == "race")
    assert trace["x"][:3] == [1.0, 1.0, None]
    assert trace["y"][:2] == [0.1, 1000.0]
    assert figure["layout"]["yaxis"]["range"] == pytest.approx([-1.0, 3.0])
    anchors = {n["text"]: n["xanchor"] for n in figure["layout"]["annotations"]}
    assert anchors == {"one": "right", "two": "left", "five": "left"}  # three would stand on two, or on the line of two
    assert trace["showlegend"]


def test_lines_above_linear_data_leave_room_for_their_texts():
    figure = drawn(Panel("y, m", (Series("s", [0, 10], [2, 4]),), lines=(Lines("f", ((5.0, "f"),)),)))
    assert figure["layout"]["yaxis"]["range"][0] == 0.0
    assert figure["layout"]["yaxis"]["range"][1] > 4.4


def test_binary_picture_keeps_every_pixel_and_others_their_scale():
    values = np.eye(4, dtype=bool)
    at = np.arange(4.0)
    binary = drawn(Panel("y, m", (), picture=Picture(at, at, values, palette="binary"), x_label="x, m", equal=True))["data"][0]
    assert binary["z"] == np.eye(4, dtype=int).tolist()
    assert binary["zsmooth"] is False
    assert binary["showscale"] is False
    rising = drawn(Panel("y, m", (), picture=Picture(at, at, -3.0 * np.eye(4), "µm", "diverging")))["data"][0]
    assert (rising["zmin"], rising["zmax"]) == (-3.0, 3.0)
    assert rising["colorbar"]["title"]["text"] == "µm"


def test_cloud_of_a_periodic_motion_keeps_all_its_places_when_it_is_thinned():
    n = 3 * DRAWN_DOTS
    figure = drawn(Panel("y, m", (Series("s", np.arange(n), np.arange(n) % 3, "dots"),)))
    trace = figure["data"][0]
    assert len(trace["x"]) == DRAWN_DOTS
    assert {0.0, 1.0, 2.0} == set(trace["y"])
    assert np.bincount(np.array(trace["y"], dtype=int)) == pytest.approx(DRAWN_DOTS / 3, rel=0.1)
    assert [x % 3 for x in trace["x"]] == trace["y"]


def test_orbit_is_not_thinned_by_extremes():
    phi = np.linspace(0, 2 * np.pi, 500)
    trace = drawn(Panel("y, m", (Series("s", np.cos(phi), np.sin(phi)),)))["data"][0]
    assert np.hypot(trace["x"], trace["y"]) == pytest.approx(1.0, abs=1e-4)  # five digits


def test_bifurcation_diagram_has_every_point_at_its_parameter_and_its_exponent():
    sections = [np.array([1.0]), np.array([2.0, 3.0]), np.zeros(0)]
    chart = bifurcation_chart("t", "gap, µm", "x, µm", [10.0, 20.0, 30.0], sections, [-5.0, 7.0, np.nan])
    figure = draw_chart(chart).figure
    go.Figure(figure)
    points, zero, curve = figure["data"]
    assert (points["x"], points["y"]) == ([10.0, 20.0, 20.0], [1.0, 2.0, 3.0])
    assert points["marker"]["color"] == [-5.0, 7.0, 7.0]
    # The scale's neutral colour stands at zero.
    low, high = points["marker"]["cmin"], points["marker"]["cmax"]
    assert points["marker"]["colorscale"][1][0] == pytest.approx(-low / (high - low))
    assert curve["y"] == [-5.0, 7.0, None]
    assert zero["y"] == [0.0, 0.0]
    plain = section_panel("x, µm", [10.0, 20.0], [np.array([1.0]), np.array([2.0, 3.0])])
    assert plain.series[0].x.tolist() == [10.0, 20.0, 20.0]
    assert not len(plain.series[0].shades)


def test_heat_is_shown_where_temperatures_are_recorded():
    t = np.array([0.0, 1.0])
    columns = {"a.inner_temperature": np.array([293.15, 303.15]), "a.clearance_change": np.array([0.0, -5e-6])}
    (chart,) = charts_over_time(SimpleNamespace(time=t, columns=columns))
    assert chart.title == "Heat"
    assert chart.panels[0].series[0].y == pytest.approx([20.0, 30.0])
    assert chart.panels[1].series[0].y == pytest.approx([0.0, -5.0])
    assert list(charts_over_time(SimpleNamespace(time=t, columns={"a.clearance_change": t}))) == []


def test_dark_paper_has_another_colour_for_every_one_of_light_paper(tmp_path):
    """Contrast after WCAG: at least 3 to 1 against the dark paper for lines and marks, 4.5 to 1 for text."""

    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        return np.dot([0.2126, 0.7152, 0.0722], [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts])

    paper = luminance(DARK["#ffffff"])

    def contrast(light):
        return (luminance(DARK[light]) + 0.05) / (paper + 0.05)

    for text in ("#1c2733", "#5c6b7a"):
        assert contrast(text) > 4.5
    for line in ("#0072b2", "#d55e00", "#009e73", "#aa4499", "#e69f00", "#56b4e9"):
        assert contrast(line) > 3.0
    assert not set(DARK) & set(DARK.values())  # replacing one does not bring up another
    html = write_page(Page("t", "", []), tmp_path / "page.html").read_text(encoding="utf-8")
    assert json.loads(re.search(r'id="dark-colours">(.*?)</script>', html)[1]) == DARK
