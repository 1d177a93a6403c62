"""The page asks nothing of the network, holds what it was given, and escapes it."""

import json
import re

import numpy as np
import plotly.graph_objects as go
import pytest
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.charts.bands import BAND_POINTS
from cosimo.orchestrator.harness.charts.chart import Band, Chart, Grid, Panel, Series
from cosimo.orchestrator.harness.charts.charts import draw_chart
from cosimo.orchestrator.harness.charts.style import SAMPLES, number
from cosimo.orchestrator.harness.validation.case import Case, CaseResult, Findings, compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.settings import AnalysisKeys
from cosimo.orchestrator.systems import SYSTEMS
from cosimo.orchestrator.systems.railway import figures as railway_figures

MEASURED = {
    "mean": 117.4,
    "std": 28.0,
    "statistical_max": 200.0,
    "statistical_min": 33.0,
    "max": 188.0,
    "min": 49.9,
    "uplift_mm": 54.0,
    "loss_raw": 0.0,
    "height_range_mm": 41.0,
    "std_0_5": 25.0,
    "std_5_20": 18.0,
}


def figures_of(html):
    texts = re.findall(r'<script type="application/json" id="f\d+-data">(.*?)</script>', html, re.DOTALL)
    return [json.loads(t, parse_constant=lambda c: pytest.fail(f"{c} is no JSON")) for t in texts]


def without_plotly(html):
    """The page without the compressed library in it."""
    assert html.count('id="plotly-inside"') == 1
    return re.sub(r'<script type="text/plain" id="plotly-inside">.*?</script>', "", html, flags=re.DOTALL)


def made_up_case(run, charts=(), notes=(), title="A case"):
    rows = compare(load_table("en50318-2002").under("250 km/h"), MEASURED)
    unconfirmed = compare(load_table("en50318-2018-ac-simple").under("275 km/h"), MEASURED)
    case = Case("a-case", title, "Shows something.", (), system="railway")
    settings = {"250 km/h": "window 240 to 360 m, 20 Hz"}
    return CaseResult(case, Findings((*rows, *unconfirmed), {"250 km/h": run}, charts, notes, settings))


CHART = Chart(
    "Study",
    "beta, s",
    (
        Panel(
            "σ, N",
            (Series("250 km/h", [0, 1e-3], [30, 31], "line+points"), Series("context", [0, 1e-3], [29, 30], faint=True)),
            (Band("range", 26, 31), Band("unconfirmed", None, 35, "unconfirmed")),
            ((5e-4, "mark"),),
            "left",
        ),
        Panel("uplift, mm", (Series("250 km/h", [0, 1e-3], [50, 52], "points", labels=("a", "b")),)),
    ),
    "A text.",
    2,
)
GRID = Grid("Variants", ("variant", "σ, N"), (("as is", 30.123), ("other", 31.0)))


def test_run_page_has_figures_of_its_system_and_is_self_contained(run, tmp_path):
    html = report.for_run(run, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    own = without_plotly(html)
    assert not re.findall(r"""(?:src|href|action|srcset)\s*=\s*["']?(?!#|data:image/png)[^"'\s>]+""", own), "an address to fetch"
    assert not re.findall(r"@import|url\((?!#)|<link|<iframe|fetch\(|XMLHttpRequest", own)
    assert "showSendToCloud: false" in own  # Plotly's default shows a button that sends the data away
    titles = re.findall(r"<b>Figure \d+\.</b> (.*?)</figcaption>", html)
    assert titles[0] == "Contact force at 250 km/h"
    assert {"Uplift of the contact wire at the supports", "Amplitude spectrum of the contact force", "Recorded signals"} <= set(
        titles
    )
    figures = figures_of(html)
    assert len(figures) == len(titles)
    for f in figures:
        go.Figure({k: v for k, v in f.items() if k != "frames"})  # raises for properties Plotly does not know
        assert f["layout"]["xaxis"]["title"]["text"]


def test_every_axis_of_the_railway_figures_has_its_unit(run):
    for figure in railway_figures.figures(run):
        axes = [v for k, v in figure.figure["layout"].items() if re.fullmatch(r"[xy]axis\d*", k)]
        for axis in axes:
            assert re.search(r", (m|N|s|mm|Hz)\b", axis["title"]["text"]) or "ticktext" in axis


def test_force_figure_carries_raw_filtered_and_ranges(run):
    rows = made_up_case(run).findings.rows[:8]
    (figure, *_) = railway_figures.figures(run, rows)
    raw, filtered = figure.figure["data"][:2]
    assert np.std(filtered["y"]) < np.std(raw["y"])  # 60 Hz is filtered out
    assert raw["line"]["width"] < filtered["line"]["width"]
    bands = {(s["y0"], s["y1"]) for s in figure.figure["layout"]["shapes"] if s["type"] == "rect"}
    assert {(110, 120), (175, 210), (50, 75), (190, 210), (20, 40)} <= bands
    assert "zero phase" in figure.caption


def test_spectrum_marks_span_and_dropper_passing(run):
    figure = next(f for f in railway_figures.figures(run) if "spectrum" in f.title)
    at = {round(s["x0"], 3) for s in figure.figure["layout"]["shapes"]}
    assert {round(69.444 / 60, 3), round(69.444 / 6.5, 3)} <= at
    trace = figure.figure["data"][0]
    # the made-up force has 35 N at span passing; the window holds whole spans up to one sample
    assert max(trace["y"]) == pytest.approx(35.0, rel=0.02)
    assert trace["x"][int(np.argmax(trace["y"]))] == pytest.approx(69.444 / 60, abs=0.1)


def test_case_page_shows_standing_margins_settings_and_studies(run, tmp_path):
    html = report.for_cases([made_up_case(run, (CHART, GRID), ("a note",))], tmp_path, SYSTEMS).read_text(encoding="utf-8")
    own = without_plotly(html)
    assert "(medium confidence)" in own
    assert 'class="badge failed"' in own  # actual minimum 49.9 N lies outside 50 to 75 N
    assert "49.9" in own
    assert "−0.1" in own
    assert "window 240 to 360 m" in own
    assert "a note" in own
    assert "30.12" in own
    for text in ("verbatim", "Table III", "Source"):
        assert text in own


def test_texts_are_escaped_everywhere(run, tmp_path):
    evil = "</script><script>alert(1)</script><b>"
    run.scene = run.scene.model_copy(update={"title": evil})
    run.info.effects["pantograph"].on["contact_loss"] = evil
    chart = Chart(evil, evil, (Panel(evil, (Series(evil, [0, 1], [0, 1]),), title="t"),), evil)
    case = made_up_case(run, (chart, Grid(evil, (evil,), ((evil,),))), (evil,), title=evil)
    for html in (report.for_run(run, tmp_path, SYSTEMS).read_text(), report.for_cases([case], tmp_path, SYSTEMS).read_text()):
        assert "<script>alert" not in html
        assert "&lt;script&gt;alert" in html
    assert chart.title in [evil]
    assert any(evil in json.dumps(f, ensure_ascii=False).replace('\\"', '"') for f in figures_of(html))


def test_failed_run_is_shown_as_far_as_it_went(run, tmp_path):
    run.outcome, run.message = "failed", "catenary failed at t = 3 s"
    html = report.for_run(run, tmp_path, SYSTEMS).read_text()
    assert "catenary failed at t = 3 s" in html
    assert "Recorded signals" in html


def test_a_scene_of_no_known_system_gets_the_general_page(run, tmp_path):
    run.scene = run.scene.model_copy(update={"analysis": AnalysisKeys()})
    html = report.for_run(run, tmp_path, SYSTEMS).read_text()
    assert "Recorded signals" in html
    assert "Contact force at" not in html


def test_chart_is_valid_and_shares_names_over_panels():
    figure = draw_chart(CHART).figure
    go.Figure(figure)
    assert [t["showlegend"] for t in figure["data"]] == [True, True, False]
    assert {(s["y0"], s["y1"]) for s in figure["layout"]["shapes"] if s["type"] == "rect"} >= {(26, 31)}


def test_not_finite_numbers_become_gaps():
    trace = draw_chart(Chart("t", "x", (Panel("y", (Series("s", [0, 1, 2], [1.0, np.nan, np.inf]),)),))).figure["data"][0]
    assert trace["y"] == [1.0, None, None]


def test_a_long_history_is_drawn_as_the_band_between_its_extremes_and_keeps_its_samples():
    x, y = np.arange(100_000.0), np.sin(np.arange(100_000.0))
    y[77_777] = 40.0
    figure = draw_chart(Chart("t", "x", (Panel("y", (Series("s", x, y), Series("short", x[:90], y[:90]))),)))
    long, short = figure.figure["data"]
    assert len(long["x"]) <= BAND_POINTS
    assert (long["fill"], max(long["y"]), min(long["y"])) == ("toself", 40.0, -1.0)
    assert np.array_equal(long[SAMPLES], (x, y))
    assert "fill" not in short
    assert "Bands" in figure.caption


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (27.4321, 26, 31, "27.4"),
        (208.26, 190, 210, "208.3"),
        (-5.25, -5, 20, "−5.2"),
        (4512.3, 4588, 4872, "4512"),
        (0.0, 0, 0, "0"),
        (float("nan"), 0, 1, "–"),
        (0.26953, 0.2646, 0.2754, "0.270"),
    ],
)
def test_numbers_have_sensible_digits(value, low, high, text):
    assert number(value, low, high) == text
