"""A report in a browser, as a file: figures drawn by the library beside it, no other host asked, nothing folded in print."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from cosimo import load_scene, run, write_report
from cosimo.orchestrator.harness.charts.blocks import Figure
from cosimo.orchestrator.harness.charts.style import axis, dense_line, layout
from cosimo.orchestrator.harness.report.page import Page, Section, write_page

pytestmark = pytest.mark.full


@pytest.fixture
def page():
    """A page of a Chromium."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra 'docs')")
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_api.sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        except sync_api.Error as error:
            pytest.skip(f"no browser starts: {error}")
        yield browser.new_page()
        browser.close()


def report(folder: Path) -> Path:
    """Of a short run of a scene with many signals."""
    return write_report(run(load_scene("mass-on-spring"), in_process=True), folder)


def test_a_report_draws_its_figures_and_prints_its_settings(page, tmp_path):
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    path = report(tmp_path)
    page.goto(path.as_uri())
    page.locator(".plot .main-svg").first.wait_for()
    curve = page.locator(".plot .scatterlayer path.js-line").first.get_attribute("d")
    assert curve.count("L") + curve.count("C") > 20  # bytes became a line
    folded = page.locator("details:not([open])").count()
    assert folded > 0
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.locator("details:not([open])").count() == 0
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert page.locator("details:not([open])").count() == folded
    assert errors == []
    assert {url.partition("#")[0] for url in asked} == {path.as_uri(), path.with_name("plotly.min.js").as_uri()}
    assert path.stat().st_size < 1_500_000


def drawn_in(page, low, high):
    """(x, y) of the first line of the first figure, from low to high."""
    return np.array(
        page.evaluate(
            f"""() => {{ const t = document.querySelector(".plot")._fullData[0], rows = [];
        for (let k = 0; k < t.x.length; k++) if (t.x[k] >= {low} && t.x[k] <= {high}) rows.push([t.x[k], t.y[k]]);
        return rows; }}"""
        )
    ).T


def test_a_dense_line_has_all_its_samples_where_one_zooms_in(page, tmp_path):
    """With the mouse: a drag over a hundredth of the axis, then a double click."""
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    x = np.linspace(0.0, 100.0, 60_001)
    y = np.sin(400.0 * x) + (np.abs(x - 50.0) < 0.002)
    trace, thinned = dense_line(x, y, "oscillation", "#0072b2")
    assert thinned
    figure = Figure("Dense", {"data": [trace], "layout": layout(400, xaxis=axis("time, s"), yaxis=axis("m"))})
    path = write_page(Page("Dense lines", "", [Section("Signals", [figure])]), tmp_path / "page.html")
    beside = path.with_name("page.samples.js")
    page.goto(path.as_uri())
    page.locator(".plot .main-svg").first.wait_for()
    assert beside.as_uri() not in asked  # nothing is loaded before it is looked at
    coarse = drawn_in(page, 0.0, 100.0)
    box = page.locator(".plot .nsewdrag").first.bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.495 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.505 * box["width"], middle, steps=5)
    page.mouse.up()
    page.wait_for_function(f"document.querySelector('.plot')._fullData[0].x.length != {coarse.shape[1]}")
    low, high = page.evaluate("document.querySelector('.plot')._fullLayout.xaxis.range")
    assert 0.5 < high - low < 2.0
    seen = (x > low) & (x < high)
    fine = drawn_in(page, low, high)
    assert fine.shape[1] == np.count_nonzero(seen) > 2 * np.count_nonzero((coarse[0] > low) & (coarse[0] < high))
    assert np.abs(fine - [x[seen], y[seen]]).max() < 1e-5
    page.mouse.dblclick(box["x"] + 0.5 * box["width"], middle)
    page.wait_for_function(f"document.querySelector('.plot')._fullData[0].x.length == {coarse.shape[1]}")
    assert np.array_equal(drawn_in(page, 0.0, 100.0), coarse)
    assert page.evaluate("document.querySelector('.plot')._fullLayout.xaxis.range") == pytest.approx([0.0, 100.0], abs=1.0)
    assert errors == []
    assert {url.partition("#")[0] for url in asked} == {p.as_uri() for p in (path, beside, path.with_name("plotly.min.js"))}


def test_without_the_library_the_page_says_so(page, tmp_path):
    path = report(tmp_path)
    path.with_name("plotly.min.js").unlink()
    page.goto(path.as_uri())
    assert page.locator("#no-plotly").is_visible()
    assert page.locator("table").count() > 0
