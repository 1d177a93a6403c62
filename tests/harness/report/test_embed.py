"""Figures in a page: as many points as there is room for, extremes and gaps kept, numbers as bytes that give them back."""

import base64
from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.orchestrator.harness.charts.bands import band, outline
from cosimo.orchestrator.harness.report.embed import FEWEST, ROOM, embedded
from cosimo.orchestrator.harness.report.generic import time_series


def back(packed):
    """The array of a typed array of Plotly."""
    values = np.frombuffer(base64.b64decode(packed["bdata"]), dtype=np.dtype(packed["dtype"]).newbyteorder("<"))
    return values.reshape([int(n) for n in packed["shape"].split(",")]) if "shape" in packed else values


def lines(count, points, seed=0):
    """A figure of so many lines of noise."""
    x, noise = np.linspace(0.0, 100.0, points), np.random.default_rng(seed).normal(size=(count, points))
    return {"data": [{"type": "scatter", "mode": "lines", "x": x.tolist(), "y": y.tolist()} for y in noise], "layout": {}}


def test_lines_that_have_room_keep_every_point():
    figure = lines(3, 2000)
    (spec,), points = embedded([figure])
    assert points == 0
    for trace, packed in zip(figure["data"], spec["data"], strict=True):
        assert back(packed["y"]) == pytest.approx(trace["y"], rel=1e-6)


def test_many_dense_lines_have_room_together_and_keep_their_extremes():
    figures = [lines(12, 8000, k) for k in range(4)]
    specs, points = embedded(figures)
    assert FEWEST <= points < 8000
    assert sum(back(t[k]).size for s in specs for t in s["data"] for k in "xy") <= ROOM
    for figure, spec in zip(figures, specs, strict=True):
        for trace, packed in zip(figure["data"], spec["data"], strict=True):
            kept = back(packed["y"])
            assert (kept.min(), kept.max()) == pytest.approx((min(trace["y"]), max(trace["y"])), rel=1e-6)


def test_an_orbit_keeps_its_shape_where_lines_lose_points():
    """A hundred turns of an ellipse that turns slowly: every point that is drawn is one of it, every chord is near it."""
    turn = np.linspace(0.0, 200.0 * np.pi, 60_000)
    path = (np.cos(turn) + 0.4j * np.sin(turn)) * np.exp(0.003j * turn)
    orbit = {"type": "scatter", "mode": "lines", "x": path.real.tolist(), "y": path.imag.tolist()}
    (spec, _), points = embedded([{"data": [orbit], "layout": {}}, lines(20, 20_000)])
    drawn = back(spec["data"][0]["x"]) + 1j * back(spec["data"][0]["y"])
    assert 1000 < drawn.size < 60_000
    assert points < 60_000
    middle = 0.5 * (drawn[1:] + drawn[:-1])
    assert np.abs(middle[:, None] - path[None, ::6]).min(axis=1).max() < 0.05  # of an extent of 2


def test_a_page_that_is_full_without_long_lines_stays_as_it_is():
    orbits = {"type": "scatter", "mode": "markers", "x": list(range(ROOM)), "y": [0.5] * ROOM}
    (spec,), points = embedded([{"data": [orbits], "layout": {}}])
    assert points == 0
    assert back(spec["data"][0]["x"]).size == ROOM


def test_points_with_texts_and_short_arrays_stay_as_they_are():
    labelled = {"type": "scatter", "mode": "lines", "x": list(range(9000)), "y": [0.0] * 9000, "text": ["a"] * 9000}
    dots = {"type": "scatter", "mode": "markers", "x": [1.0, 2.0], "y": [None, 3.0]}
    (spec, _), _ = embedded([{"data": [labelled, dots], "layout": {}}, lines(30, 9000)])
    assert back(spec["data"][0]["y"]).size == 9000
    assert spec["data"][1] == dots


def test_pictures_and_times_that_single_precision_would_merge_come_back():
    rows = [[float(10 * i + j) if i != j else None for j in range(9)] for i in range(8)]
    late = [1e6 + 1e-3 * k for k in range(100)]
    (spec,), _ = embedded([{"data": [{"type": "heatmap", "z": rows}, {"type": "scatter", "x": late, "y": late}], "layout": {}}])
    assert np.array_equal(back(spec["data"][0]["z"]), np.array(rows, dtype=float), equal_nan=True)
    assert back(spec["data"][1]["x"]).tolist() == late


def test_a_band_holds_every_sample_and_stays_broken_where_the_line_is():
    """Of each piece the least and the largest value; the piece of a gap ends the outline, of which a short history is its own."""
    x, y = np.arange(20_000.0), np.sin(np.linspace(0.0, 600.0, 20_000))
    y[5000:9000] = np.nan
    y[12_345], y[12_346] = 7.0, np.inf
    at, least, largest = band(x, y, 500)
    for k in np.flatnonzero(np.isfinite(y)):
        piece = np.flatnonzero((np.abs(at - x[k]) <= 40.0) & ~np.isnan(least))
        assert least[piece].min() <= y[k] <= largest[piece].max()
    assert (at[0], at[-1], np.nanmax(largest)) == (0.0, 19_999.0, 7.0)
    assert not ((at > 5040) & (at < 8960) & ~np.isnan(least)).any()
    xs, ys = outline(at, least, largest)
    assert np.count_nonzero(np.isnan(xs)) == 2  # three closed lines
    assert np.array_equal(np.isnan(xs), np.isnan(ys))
    first = np.flatnonzero(np.isnan(xs))[0]
    assert np.array_equal(xs[:first], xs[:first][::-1])  # there and back
    assert (ys[:first] >= ys[:first][::-1])[: first // 2].all()  # the largest values, then the least
    assert all(np.array_equal(column, y[:100]) for column in band(x[:100], y[:100], 500)[1:])


def test_signals_share_an_axis_by_unit_of_measure_and_size():
    t = np.linspace(0.0, 1.0, 50)
    columns = {
        "a.force": 100.0 * t,
        "b.force": 90.0 * t,
        "c.force": 0.1 * t,
        "a.position": t,
        "b.position": 1e-3 * t,
        "d.mass": 0.0 * t + 3.0,
    }
    measures = dict.fromkeys(columns, "N") | {"a.position": "m", "b.position": "m", "d.mass": "kg"}
    (figure,) = time_series(SimpleNamespace(time=t, columns=columns, measures=measures))
    axis_of = {trace["name"]: trace["yaxis"] for trace in figure.figure["data"]}
    assert axis_of["a.force"] == axis_of["b.force"]
    assert len(set(axis_of.values())) == 4
    assert "d.mass" not in axis_of
    assert "d.mass = 3" in figure.caption


def test_only_an_angle_within_a_turn_is_unwrapped_and_a_gap_stays_a_gap():
    t = np.arange(60.0)
    around = np.mod(0.3 * t, 2.0 * np.pi)
    columns = {"a.around": np.where(t == 30.0, np.nan, around), "b.counted": 0.9 * 2.0 * np.pi * t}
    (figure,) = time_series(SimpleNamespace(time=t, columns=columns, measures=dict.fromkeys(columns, "rad")))
    lines = {trace["name"]: np.asarray(trace["y"], dtype=float) for trace in figure.figure["data"]}
    assert set(lines) == {"a.around, unwrapped", "b.counted"}  # unwrapped, the second would turn backwards
    assert np.flatnonzero(np.isnan(lines["a.around, unwrapped"])).tolist() == [30]
    assert np.nanmax(lines["a.around, unwrapped"]) / np.nanmin(lines["a.around, unwrapped"][1:]) == pytest.approx(59.0, rel=1e-4)
