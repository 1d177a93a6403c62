"""The picture of the passage shows what was recorded, where it was."""

from types import SimpleNamespace

import numpy as np
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
from cosimo.orchestrator.systems.railway.figures.passage import FRAMES, passage_figure
from cosimo.orchestrator.systems.railway.records import passages
from cosimo.tests.systems.railway.made_up import made_up_run


def with_profiles(slack_at: float):
    """A run whose messenger is 10 mm up and whose dropper at a position, m, is slack whenever it is seen."""
    run = made_up_run()
    snapshot = run.snapshots["catenary.wire_profile.height"]
    at = np.interp(snapshot.time, run.time, run.columns["pantograph.contact_position"])
    tension = np.full(snapshot.values.shape, -1.0)
    for k, position in enumerate(at):
        cell = int(np.floor(slack_at - (position - 60.0) + 0.5))
        if 0 <= cell < tension.shape[1]:
            tension[k, cell] = 0.0
    for name, values in (("messenger_uplift", np.full(tension.shape, 0.01)), ("dropper_tension", tension)):
        run.snapshots[f"catenary.line_profile.{name}"] = SimpleNamespace(time=snapshot.time, values=values)
    return run


def test_no_picture_without_the_profiles():
    run = made_up_run()
    assert passage_figure(run, passages(run)[0], ButterworthFilter()) is None


def test_wires_droppers_and_force_are_where_they_were_recorded():
    run = with_profiles(slack_at=330.0)  # the middle dropper of span 6
    figure = passage_figure(run, passages(run)[0], ButterworthFilter())
    assert figure is not None
    frames = figure.figure["frames"]
    assert 2 <= len(frames) <= FRAMES
    names = [trace["name"] for trace in figure.figure["data"]]
    order = figure.figure["data"]
    for frame in frames:
        traces = {names[i]: data for i, data in zip(frame["traces"], frame["data"], strict=True)}
        at = traces["force now"]["x"][0]
        wire = traces["contact wire"]
        assert wire["x"][0] < at < wire["x"][-1]
        assert len(wire["x"]) == 121
        assert np.mean(traces["messenger"]["y"]) > max(wire["y"])
        slack = [x for x in traces["slack dropper"]["x"] if x is not None]
        assert slack == ([330.0, 330.0] if 330.0 - at <= 60.0 else [])
        assert 330.0 not in (traces["dropper"]["x"] if slack else [])
        assert len(traces["dropper"]["x"]) > 60
    assert all(trace["type"] == "scatter" for trace in order)
    assert "times as large" in figure.caption
