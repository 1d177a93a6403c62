"""Windows of faults are shaded where they were, and named, in all figures over time."""

import plotly.graph_objects as go
import pytest
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.charts.chart import Chart, Panel, Series
from cosimo.orchestrator.harness.charts.charts import draw_chart
from cosimo.orchestrator.harness.report.generic import time_series
from cosimo.orchestrator.harness.report.windows import Window, fault_windows, shaded
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import FaultSettings
from cosimo.orchestrator.systems import SYSTEMS, read_scene
from cosimo.orchestrator.systems.railway import figures as railway_figures
from cosimo.tests.support import two_masses
from cosimo.tests.systems.railway.made_up import made_up_run

FAULTS = [
    {"signal": "b.force", "kind": "offset", "value": 5.0, "begin": 0.1, "end": 0.3},
    {"signal": "a.x_out", "kind": "freeze", "begin": 0.25, "end": 0.4},
    {"signal": "b.velocity", "kind": "override", "value": -2.0, "begin": 0.5, "end": 0.6},
    {"signal": "b.position", "kind": "drop", "begin": 0.7, "end": 0.75},
    {"unit": "b", "kind": "lost", "begin": 0.9},
]
NAMES = ["b.force offset by 5", "a.x_out frozen", "b.velocity overridden with -2", "b.position dropped", "b lost"]


def rectangles(figure):
    return [(s["x0"], s["x1"]) for s in figure.figure["layout"]["shapes"] if s["type"] == "rect" and s["yref"] == "paper"]


def test_every_fault_is_shaded_and_named_in_the_recorded_signals(tmp_path):
    result = run(read_scene(two_masses() | {"faults": FAULTS}), in_process=True)
    windows = fault_windows(result)
    (plain,) = time_series(result)
    figure = shaded(plain, windows, (0.0, 1.0))
    go.Figure(figure.figure)
    assert rectangles(figure) == [(0.1, 0.3), (0.25, 0.4), (0.5, 0.6), (0.7, 0.75), (0.9, 1.0)]  # the lost unit stays lost
    assert [n["text"] for n in figure.figure["layout"]["annotations"]] == NAMES
    assert "faults" in figure.caption
    html = report.for_run(result, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    for name in NAMES:
        assert html.count(name) >= 2, "in the figure and among the facts"


def test_names_that_would_meet_stand_in_rows_and_the_panels_keep_their_size():
    result = run(read_scene(two_masses() | {"faults": FAULTS}), in_process=True)
    (plain,) = time_series(result)
    near = [
        Window("the first of some faults", 0.1, 0.3, "#d55e00"),
        Window("the second", 0.2, 0.3, "#aa4499"),
        Window("the third", 0.8, 0.9, "#009e73"),
    ]
    before, after = plain.figure["layout"], shaded(plain, near, (0.0, 1.0)).figure["layout"]
    heights = [n["yshift"] for n in after["annotations"]]
    assert heights[0] == heights[2] < heights[1]
    panels = [layout["height"] - layout["margin"]["t"] - layout["margin"]["b"] for layout in (before, after)]
    assert panels[0] == panels[1]
    assert after["height"] - before["height"] == 2 * (heights[1] - heights[0])
    assert after["annotations"][-1]["xanchor"] == "left"
    far = shaded(plain, [Window("a very long name of a fault", 0.99, 1.0, "#009e73")], (0.0, 1.0))
    assert far.figure["layout"]["annotations"][0]["xanchor"] == "right"


def test_a_legend_above_the_panels_makes_room_for_the_names():
    chart = Chart("t", "time, s", (Panel("y, m", (Series("a", [0, 1], [0, 1]), Series("b", [0, 1], [1, 0]))),))
    plain = draw_chart(chart)
    figure = shaded(plain, [Window("f", 0.2, 0.4, "#d55e00")], (0.0, 1.0))
    assert figure.figure["layout"]["legend"]["y"] > plain.figure["layout"]["legend"]["y"]
    other = draw_chart(Chart("t", "frequency, Hz", chart.panels))
    assert shaded(other, [Window("f", 0.2, 0.4, "#d55e00")], (0.0, 1.0)) is other


@pytest.mark.parametrize(("stop", "seen"), [(0.05, 0), (0.2, 1), (0.45, 2)])
def test_faults_behind_the_end_of_the_run_are_not_shown(stop, seen):
    result = run(read_scene(two_masses() | {"faults": FAULTS}), in_process=True)
    kept = int((result.time <= stop + 1e-9).sum())
    object.__setattr__(result, "time", result.time[:kept])
    windows = fault_windows(result)
    assert [w.name for w in windows] == NAMES[:seen]
    assert all(w.end <= stop + 1e-9 for w in windows)


def test_contact_force_is_shaded_where_the_pantograph_then_is():
    run_ = made_up_run()
    fault = FaultSettings(signal="pantograph.contact_force", kind="offset", value=50.0, begin=3.5, end=4.0)
    run_.scene = run_.scene.model_copy(update={"faults": (fault,)})
    force, uplift, *_ = railway_figures.figures(run_)
    assert rectangles(force)[-1] == pytest.approx((30.0 + 69.444 * 3.5, 30.0 + 69.444 * 4.0))
    assert not any("offset" in n["text"] for n in uplift.figure["layout"].get("annotations", ()))  # over time: with all others
