"""From a slider that moves to a curve that is drawn, in Chromium, on pages of two scenes."""

import pytest
from cosimo.orchestrator.systems import explore_page, load_scene
from cosimo.tests.harness.explore.test_explore_page import JUDGED, WAIT
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401

# a slider as a hand moves it: the next value when the frame with the curve of the last one is painted
DRAGGED = """async (name) => {
    const slider = document.getElementById(`p-${name}`).parentElement.querySelector("input[type=range]"), times = [];
    const frame = () => new Promise(requestAnimationFrame), results = document.getElementById("results");
    const drawn = () => new Promise((done) => {
        const watch = new MutationObserver(() => { watch.disconnect(); done(); });
        watch.observe(results, { attributeFilter: ["data-answered"] });
    });
    for (let k = 0; k < 40; k++) {
        const answered = drawn(), begin = performance.now();
        slider.value = Number(slider.min) + (0.3 + 0.01 * k) * (Number(slider.max) - Number(slider.min));
        slider.dispatchEvent(new Event("input"));
        await answered;
        await frame();
        times.push(performance.now() - begin);
    }
    return times.slice(10).sort((a, b) => a - b)[15];
}"""


@pytest.mark.parametrize(
    ("name", "parameter", "aim"),
    [("en50318-2002", "pantograph.static_force", 60.0), ("mass-on-spring", "spring.stiffness", 16.0)],
)
def test_a_slider_that_moves(name, parameter, aim, browser, tmp_path, told):  # noqa: F811
    page = browser.new_page()
    page.goto(explore_page(load_scene(name), tmp_path / "page.html").as_uri())
    page.wait_for_function(JUDGED, timeout=WAIT)
    page.locator("#curve1 .main-svg").first.wait_for()
    milliseconds = page.evaluate(DRAGGED, parameter)
    told.target(f"from a slider to the curve, `{name}`", milliseconds, aim, "ms by the clock")
    assert page.evaluate("shown.whole")
