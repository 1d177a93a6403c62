"""A result in a notebook, as data of other libraries, and as a figure."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from cosimo import BadInput, read_result, read_scene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.views.html import HEIGHT, sparkline
from cosimo.tests.support import two_masses

PROBE = {
    "stop_time": 1.0,
    "units": {"p": {"component": "cosimo.tests.support:Probe", "parameters": {"length": 4.0}}},
    "master": {"step": 0.1},
    "record": {"signals": ["p.time"], "snapshots": ["p.profile"], "snapshot_interval": 0.5},
}


@pytest.fixture(scope="module")
def masses():
    return run(read_scene({**two_masses("jacobi", 5e-3, 1), "stop_time": 2.0, "title": "Two <masses>"}), in_process=True)


def test_html_is_small_and_has_no_script(masses):
    html = masses._repr_html_()
    assert 500 < len(html) < 5000
    assert "<script" not in html
    assert "Two &lt;masses&gt;" in html
    assert html.count("<svg") == min(len(masses.columns), 6)
    warned = replace(masses, info=replace(masses.info, warnings=("a < b", *"cdef"), outcome="failed", message="no <reason>"))
    html = warned._repr_html_()
    assert "a &lt; b" in html
    assert "2 more warnings" in html
    assert "no &lt;reason&gt;" in html


def test_html_of_many_noisy_signals_stays_small(masses):
    time, noise = np.linspace(0.0, 1.0, 20_000), np.random.default_rng(1).normal(size=20_000)
    columns = {f"unit.signal_{k}": noise for k in range(50)}
    html = replace(masses, time=time, columns=columns, measures=dict.fromkeys(columns, "N"))._repr_html_()
    assert len(html) < 6000
    assert "44 more signals" in html


def test_a_sparkline_keeps_extremes_and_gaps():
    values = np.zeros(10_000)
    values[1234] = 1.0
    assert " 1L" in sparkline(np.arange(10_000.0), values)  # the one sample at the top
    assert f"{HEIGHT - 1}" in sparkline(np.arange(10_000.0), values)
    values[5000:6000] = np.nan
    assert sparkline(np.arange(10_000.0), values).count("M") == 2
    assert sparkline(np.arange(3.0), np.full(3, np.nan)) == ""


def test_data_frames_have_units_and_provenance(masses):
    pytest.importorskip("pandas")
    frame = masses.to_pandas()
    assert list(frame.columns) == list(masses.columns)
    assert frame.index.to_numpy().tobytes() == masses.time.tobytes()
    assert frame.attrs["units"] == {n: masses.measures[n] for n in masses.columns}
    assert frame.attrs["outcome"] == "done"
    assert list(masses.to_pandas(["a"]).columns) == [n for n in masses.columns if n.startswith("a.")]


def test_a_data_set_has_snapshots_units_and_all_of_run_json():
    pytest.importorskip("xarray")
    result = run(read_scene(PROBE), in_process=True)
    data = result.to_xarray()
    assert data["p.time"].attrs["units"] == result.measures["p.time"]
    assert data["p.profile"].dims == ("p.profile.time", "p.profile.index")
    assert data["p.profile"].values.tolist() == result.snapshots["p.profile"].values.tolist()
    assert data["p.profile.time"].values.tolist() == result.snapshots["p.profile"].time.tolist()
    assert json.loads(data.attrs["run"])["scene"]["stop_time"] == 1.0
    assert list(result.to_xarray(["p.profile"]).data_vars) == ["p.profile"]


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_a_missing_library_is_one_message(library, masses, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(BadInput, match=f"pip install {library}"):
        getattr(masses, f"to_{library}")()


def test_a_figure_has_a_panel_for_each_unit_of_measure(masses):
    figure = masses.plot()
    units = list(dict.fromkeys(masses.measures[n] for n in masses.columns))
    axes = [a for a in figure.layout if a.startswith("yaxis") and figure.layout[a].title.text]
    assert len(axes) == len(units) > 1
    assert {t.name for t in figure.data} == set(masses.columns)
    by_axis = {t.name: t.yaxis or "y" for t in figure.data}
    for one in masses.columns:
        for other in masses.columns:
            assert (by_axis[one] == by_axis[other]) == (masses.measures[one] == masses.measures[other])
    assert figure.layout.xaxis.title.text == "time, s" or len(units) > 1


def test_another_result_is_added_to_a_figure(masses):
    name = "a.x_out"
    figure = masses.plot(name)
    assert figure.layout.yaxis.title.text == f"x out, {masses.measures[name]}"
    masses.plot(name, fig=figure)
    assert len(figure.data) == 2
    assert len({t.line.color for t in figure.data}) == 2
    other = next(n for n in masses.columns if masses.measures[n] != masses.measures[name])
    with pytest.raises(BadInput, match="plot: fig"):
        masses.plot(other, fig=figure)
    with pytest.raises(BadInput, match="Did you mean"):
        masses.plot("a.x_uot")


def test_what_is_read_back_looks_the_same(masses, tmp_path):
    with pytest.raises(BadInput, match="not stored"):
        masses.report()
    masses.save(tmp_path)
    again = read_result(tmp_path)
    assert again._repr_html_() == masses._repr_html_()
    assert again.plot().to_plotly_json() == masses.plot().to_plotly_json()
    assert again.report() == tmp_path.resolve() / "report.html"
    assert again.summary == masses.summary == ()
