"""A report in a browser, as a file: figures drawn by the library beside it, no other host asked, nothing folded in print."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from cosimo import load_scene, run, write_report

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


def test_without_the_library_the_page_says_so(page, tmp_path):
    path = report(tmp_path)
    path.with_name("plotly.min.js").unlink()
    page.goto(path.as_uri())
    assert page.locator("#no-plotly").is_visible()
    assert page.locator("table").count() > 0
