"""Spans, droppers and the window of the statistics are those of the run's catenary, whatever its scene was made for."""

import pytest
from cosimo import BadInput, load_scene
from cosimo.orchestrator.systems.railway.cases.en50367 import measures
from cosimo.orchestrator.systems.railway.figures.passage import track_marks
from cosimo.orchestrator.systems.railway.figures.wire import wire_figure
from cosimo.orchestrator.systems.railway.records import analysis_window, passages, statistics, track_of
from cosimo.tests.systems.railway.made_up import made_up_run


def changed_run(**values):
    run = made_up_run()
    run.info.units["catenary"].parameters.update(values)
    return run


def test_the_geometry_is_that_of_the_run():
    run = made_up_run()
    assert track_of(run).span == 60.0
    assert track_of(run).dropper_spacing == 6.5
    assert analysis_window(run) == (240.0, 360.0)


def test_another_span_moves_window_and_marks():
    run = changed_run(span_length=50.0, droppers=3, **{f"dropper_position[{k}]": 10.0 * k for k in (1, 2, 3)})
    assert analysis_window(run) == (200.0, 300.0)
    assert track_of(run).dropper_spacing == 10.0
    lines, texts = track_marks(track_of(run), 190.0, 310.0)
    assert [line["x0"] for line in lines] == [200.0, 250.0, 300.0]
    assert [text["text"] for text in texts] == ["span 5", "span 6"]


def test_a_catenary_without_spans_needs_a_window_in_metres():
    run = changed_run(span_length=0.0)
    assert track_marks(track_of(run), 0.0, 100.0) == ([], [])
    with pytest.raises(BadInput, match="window ="):
        analysis_window(run)


@pytest.mark.parametrize("keys", [{"spans": [5, 6], "window": [240.0, 360.0]}, {"spans": [6, 5]}, {"spans": [0, 2]}])
def test_spans_that_make_no_window_are_refused(keys):
    with pytest.raises(BadInput, match="analysis"):
        load_scene("en50318-2002").with_changes({"analysis": {"system": "railway", **keys}})


def test_the_wire_is_shown_with_all_marks_beside_the_window():
    """The window goes from 240 to 360 m, and the profile 60 m to either side of the contact point."""
    run = made_up_run()
    figure = wire_figure(run, passages(run)[0], "catenary.wire_profile.height")
    assert figure is not None
    shown = figure.figure["layout"]
    assert [shape["x0"] for shape in shown["shapes"]] == [180.0, 240.0, 300.0, 360.0, 420.0]


def test_limits_of_the_mean_force_at_250_km_h():
    """By hand: 0.00047 v² = 29.375 N, 0.00097 v² = 60.625 N, 0.00228 v² = 142.5 N."""
    run = made_up_run()
    mean, found = statistics(run).mean, measures(run)
    for name, limit in {
        "mean_less_upper": 119.375,
        "mean_less_lower": 89.375,
        "mean_less_target": 130.625,
        "mean_less_target_3kv": 170.625,
        "mean_less_target_1500v": 200.625,
        "mean_less_fast_1500v": 232.5,
    }.items():
        assert mean - found[name] == pytest.approx(limit, abs=0.01)
