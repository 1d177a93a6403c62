"""A report in a browser, as a file: figures drawn without any host, still pictures without scripts, its answer on one sheet."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from cosimo import BadInput, delivered, load_scene, run, write_report
from cosimo import compare as compare_runs
from cosimo.orchestrator.harness.charts.bands import dense_line
from cosimo.orchestrator.harness.charts.blocks import Figure
from cosimo.orchestrator.harness.charts.style import axis, layout
from cosimo.orchestrator.harness.report import for_cases
from cosimo.orchestrator.harness.report.page import Page, Section, write_page
from cosimo.orchestrator.harness.validation.case import Case, CaseResult, Findings, compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems import SYSTEMS

pytestmark = pytest.mark.full


@pytest.fixture(scope="module")
def browser():
    """A Chromium."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra 'docs')")
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_api.sync_playwright() as playwright:
        try:
            started = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        except sync_api.Error as error:
            pytest.skip(f"no browser starts: {error}")
        yield started
        started.close()


@pytest.fixture
def page(browser):
    """A page of it."""
    return browser.new_page()


def report(folder: Path, name: str = "mass-on-spring") -> Path:
    """Of a short run of a scene."""
    return write_report(run(load_scene(name), in_process=True), folder)


def test_a_report_is_one_file_that_draws_its_figures_and_unfolds_all_in_print(page, tmp_path):
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    path = report(tmp_path, "lumped-catenary")
    page.goto(path.as_uri())
    page.locator(".plot .main-svg").first.wait_for()
    curve = page.locator(".plot .scatterlayer path.js-line").first.get_attribute("d")
    assert curve.count("L") + curve.count("C") > 20  # bytes became a line
    folded = page.locator("details:not([open])")
    count = folded.count()
    assert count > 0
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert folded.count() == 0
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert folded.count() == count
    assert page.evaluate("[...document.querySelectorAll('.modebar-btn')].every((b) => b.tabIndex < 0)")
    assert errors == []
    assert {url.partition("#")[0] for url in asked} == {path.as_uri()}
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    assert path.stat().st_size < 3_500_000


@pytest.mark.parametrize("lost", ["scripts", "unpacking", "library"])
def test_where_figures_cannot_be_drawn_there_are_still_pictures(browser, tmp_path, lost):
    with delivered("beside" if lost == "library" else "inside"):
        path = report(tmp_path)
    path.with_name("plotly.min.js").unlink(missing_ok=True)
    page = browser.new_context(java_script_enabled=lost != "scripts").new_page()
    if lost == "unpacking":
        page.add_init_script("delete window.DecompressionStream")
    page.goto(path.as_uri())
    still = page.locator("svg.still").first
    still.wait_for()
    assert still.bounding_box()["height"] > 100.0
    assert page.locator("#no-plotly").is_visible() == (lost != "scripts")


def test_a_case_is_printed_with_verdict_and_all_rows_on_its_first_sheet(page, tmp_path):
    """An A4 sheet has 297 - 28 mm; 16 rows of two conditions."""
    rows = compare(load_table("en50318-2002").rows, {})
    case = Case("a-case", "A case", "Shows something.", ())
    path = for_cases([CaseResult(case, Findings(rows))], tmp_path, SYSTEMS)
    page.set_viewport_size({"width": 695, "height": 1000})
    page.emulate_media(media="print")
    page.goto(path.as_uri() + "#print")
    last = page.locator("table.ranges tr").last.bounding_box()
    assert len(rows) == 16
    assert last["y"] + last["height"] < (297 - 28) / 25.4 * 96


@pytest.mark.parametrize(("paper", "sheet"), [("A4", 267.0), ("Letter", 249.4)])
def test_printed_figures_fill_their_sheets(page, tmp_path, paper, sheet):
    """Five figures, of which two and a half would stand on a sheet: they grow or shrink until two or three do, and none is cut."""
    t = np.linspace(0.0, 1.0, 200)
    trace, _ = dense_line(t, np.sin(9.0 * t), "a", "#0072b2")
    drawn = [Figure(f"{k}", {"data": [trace], "layout": layout(560, xaxis=axis("time, s"), yaxis=axis("m"))}) for k in range(5)]
    with delivered(paper=paper):
        path = write_page(Page("Sheets", "", [Section("Figures", drawn)]), tmp_path / "page.html")
    page.goto(path.as_uri() + "#print")
    page.wait_for_function("document.querySelectorAll('.plot .main-svg').length >= 5")
    page.wait_for_timeout(800)
    sheet *= 96 / 25.4
    begin, filled = 0.0, []
    boxes = [figure.bounding_box() for figure in page.locator("main figure").all()]
    for box, before in zip(boxes, [boxes[0], *boxes[:-1]], strict=True):
        if box["y"] + box["height"] > begin + sheet:
            filled.append((before["y"] + before["height"] - begin) / sheet)
            begin = box["y"]
        assert box["height"] < sheet
    assert len(filled) >= 1
    assert min(filled) > 0.9


def test_a_report_is_printed_to_a_pdf(tmp_path):
    try:
        with delivered(pdf=True):
            path = report(tmp_path)
    except BadInput as error:
        pytest.skip(str(error))
    assert path.with_name("report.pdf").read_bytes().startswith(b"%PDF")


def drawn_in(page, low, high):
    """(x, y) of the first line of the first figure, from low to high."""
    return np.array(
        page.evaluate(
            f"""() => {{ const t = document.querySelector(".plot")._fullData[0], rows = [];
        for (let k = 0; k < t.x.length; k++) if (t.x[k] >= {low} && t.x[k] <= {high}) rows.push([t.x[k], t.y[k]]);
        return rows; }}"""
        )
    ).T


@pytest.mark.parametrize("place", ["inside", "beside"])
def test_a_dense_line_has_all_its_samples_where_one_zooms_in(page, tmp_path, place):
    """With the mouse: a drag over a hundredth of the axis, then a double click."""
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    x = np.linspace(0.0, 100.0, 60_001)
    y = np.sin(400.0 * x) + (np.abs(x - 50.0) < 0.002)
    trace, banded = dense_line(x, y, "oscillation", "#0072b2")
    assert banded
    figure = Figure("Dense", {"data": [trace], "layout": layout(400, xaxis=axis("time, s"), yaxis=axis("m"))})
    with delivered(place):
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
    there, back = np.split(fine, 2, axis=1)  # of an outline without width
    assert there.shape[1] == np.count_nonzero(seen) > 2 * np.count_nonzero((coarse[0] > low) & (coarse[0] < high))
    assert np.array_equal(there, back[:, ::-1])
    assert np.abs(there - [x[seen], y[seen]]).max() < 1e-5
    page.wait_for_timeout(500)  # Plotly takes a click so soon after the drag began for the drag's second
    page.mouse.dblclick(box["x"] + 0.5 * box["width"], middle)
    page.wait_for_function(f"document.querySelector('.plot')._fullData[0].x.length == {coarse.shape[1]}")
    assert np.array_equal(drawn_in(page, 0.0, 100.0), coarse)
    assert page.evaluate("document.querySelector('.plot')._fullLayout.xaxis.range") == pytest.approx([0.0, 100.0], abs=1.0)
    assert errors == []
    files = (path, beside, path.with_name("plotly.min.js")) if place == "beside" else (path,)
    assert {url.partition("#")[0] for url in asked} == {p.as_uri() for p in files}


def test_the_slider_moves_a_machine_which_stands_where_less_motion_is_asked_for(browser, tmp_path):
    scene = load_scene("two-link-manipulator").with_changes({"stop_time": 0.4, "analysis.transient": 0.0})
    path = write_report(run(scene, in_process=True, verify="no"), tmp_path)
    page = browser.new_page(reduced_motion="reduce")
    page.goto(path.as_uri())
    figure = page.locator("figure.motion")
    figure.scroll_into_view_if_needed()
    pixels = "document.querySelector('figure.motion canvas').toDataURL()"
    before = page.evaluate(pixels)
    page.wait_for_timeout(300)
    assert page.evaluate(pixels) == before
    page.locator("figure.motion input").fill("60")
    moved = page.evaluate(pixels)
    assert moved != before
    assert figure.locator("output").text_content().endswith(" s")
    figure.get_by_role("button", name="Play").click()
    page.wait_for_function(f"{pixels} !== {json.dumps(moved)}")


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages of a run that is judged, of a comparison, and of a line with its drawing."""
    folder = tmp_path_factory.mktemp("pages")
    first = run(load_scene("lumped-catenary").with_changes({"limits": {"table": "en50367"}}), in_process=True)
    lines = run(load_scene("overlap").with_changes({"stop_time": 0.2}), in_process=True, verify="no")
    return [
        write_report(first, folder / "run"),
        compare_runs(first, run(load_scene("lumped-catenary"), in_process=True)).report(folder / "compare"),
        write_report(lines, folder / "line"),
    ]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_text_stands_out_from_what_is_behind_it(browser, pages, theme):
    """WCAG 2.2 AA, of folded parts and of drawings, too."""
    for path in pages:
        page = browser.new_page(color_scheme=theme)
        page.goto(path.as_uri())
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        for plot in page.locator(".plot").all():
            plot.scroll_into_view_if_needed()
            plot.locator(".main-svg").first.wait_for()
        seen = page.evaluate((Path(__file__).parents[2] / "contrast.js").read_text(encoding="utf-8"))
        assert seen["measured"] > 50
        assert seen["pale"] == []
        page.close()


def test_the_keyboard_goes_from_the_skip_link_to_texts_and_controls_alone(page, pages):
    page.goto(pages[0].as_uri())
    page.locator(".plot .main-svg").first.wait_for()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    assert page.evaluate("document.activeElement.getBoundingClientRect().left") >= 0
    page.keyboard.press("Enter")
    assert page.url.endswith("#content")
    assert page.evaluate("[...document.querySelectorAll('.plot *')].every((e) => !(e.tabIndex >= 0))")
    unnamed = "[...document.querySelectorAll('figure')].filter((f) => !f.querySelector('figcaption')?.textContent.trim())"
    assert page.evaluate(f"{unnamed}.length") == 0


def test_a_drawing_shrinks_with_the_page(browser, pages):
    page = browser.new_page(viewport={"width": 360, "height": 800})
    for path in pages:
        page.goto(path.as_uri())
        for drawing in page.locator(".sketch svg").all():
            assert drawing.evaluate("(e) => e.getBoundingClientRect().right") <= 360.0
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
    page.close()
