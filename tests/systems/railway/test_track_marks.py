"""Spans, droppers and the window of the statistics are those of the run's catenary, whatever its scene was made for."""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.figures.passage import track_marks
from cosimo.orchestrator.systems.railway.records import analysis_window, track_of
from cosimo.tests.systems.railway.made_up import made_up_run


def changed_run(**values):
    run = made_up_run()
    run.info["units"]["catenary"]["parameters"].update(values)
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
