"""A page in long use: it does not grow, two pages do not disturb each other, and what it finds out beside the figures."""

import json

import pytest
from cosimo.orchestrator.systems import explore_page, load_scene
from cosimo.tests.fmus.native.web_assembly import needs_node
from cosimo.tests.harness.explore.test_explore_page import JUDGED, WAIT, at, opened, small  # noqa: F401
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401

pytestmark = needs_node
SCANNED = "Number(document.getElementById('results').dataset.scanned) === question"
CHANGES = 1000
MANY = """async ([first, count]) => { for (let k = first; k < first + count; k++) {
    change({ ...state, values: { "spring.stiffness": 99 * (1 + k % 7) }, step: k % data.steps.length, extrapolation: k % 3 }, k % 10 === 0);
    await new Promise((done) => setTimeout(done, 4));
} }"""


def size(page, session):
    """Bytes of the page's heap with its buffers, its nodes, and bytes of the module's memory."""
    session.send("HeapProfiler.collectGarbage")
    usage = session.send("Runtime.getHeapUsage")
    heap = usage["usedSize"] + usage.get("backingStorageSize", 0.0)  # of browsers from 2025 on
    return heap, page.evaluate("document.getElementsByTagName('*').length"), page.evaluate("shown.memory")


@pytest.mark.full
def test_a_thousand_changes_leave_nothing_behind(small, opened):  # noqa: F811
    # Seven stiffnesses in turn: Plotly keeps the size of up to 10 000 texts, some 5 MB, and every new value would bring some.
    page = opened(small)
    session = page.context.new_cdp_session(page)
    page.wait_for_function(SCANNED, timeout=WAIT)
    sizes = []
    for part in range(3):
        page.evaluate(MANY, [part * CHANGES // 3, CHANGES // 3])
        at(page, "spring.stiffness=200")
        page.wait_for_function(SCANNED, timeout=WAIT)
        sizes.append(size(page, session))
    (_, _, _), before, after = sizes  # the first part fills caches
    assert after[0] < before[0] + 1e6, "a change leaves 3 kB behind"
    assert after[1] <= before[1] + 20
    assert after[2] == before[2]


@pytest.mark.full
def test_two_pages_have_states_of_their_own(small, opened):  # noqa: F811
    one, other = opened(small, "#mass.mass=2"), opened(small, "#mass.mass=3")
    assert one.evaluate("state.values['mass.mass']") == 2
    assert other.evaluate("state.values['mass.mass']") == 3
    numbers = one.evaluate("JSON.stringify(shown.numbers)")
    assert other.evaluate("JSON.stringify(shown.numbers)") != numbers
    assert json.dumps(at(other, "mass.mass=2")["numbers"]) == json.dumps(json.loads(numbers))


@pytest.mark.full
def test_what_moves_a_figure_is_what_a_change_does(small, opened):  # noqa: F811
    page = opened(small)
    page.wait_for_function(SCANNED, timeout=WAIT)
    influences, base = page.evaluate("influences"), page.evaluate("shown.numbers")
    assert {one["name"] for one in influences} == set(page.evaluate("data.first"))
    for one in influences:
        assert at(page, f"{one['name']}={one['value']}")["numbers"] == one["numbers"] != base
    at(page, "")
    page.wait_for_function(SCANNED, timeout=WAIT)
    scanned = page.evaluate("scanned")
    assert [one["value"] for one in scanned][:: len(scanned) - 1] == [50.0, 800.0]
    page.select_option("#scanned", index=1)
    page.wait_for_function(SCANNED, timeout=WAIT)
    assert {one["name"] for one in page.evaluate("scanned")} == {page.evaluate("data.first")[1]}


@pytest.mark.full
def test_the_motion_of_a_bearing_stops_repeating_itself(opened, tmp_path):  # noqa: F811
    scene = load_scene("ball-bearing-clearance")
    page = opened(explore_page(scene, tmp_path / "page.html"), "#bearing.clearance.radial_clearance=2e-6")
    assert page.evaluate("shown.numbers['bearing.distinct_points']") == 1
    page.wait_for_function(SCANNED, timeout=WAIT)
    reach = {one["value"]: max(one["points"]) - min(one["points"]) for one in page.evaluate("scanned")}
    assert all(r < 1e-7 for c, r in reach.items() if 1e-6 < c < 15e-6)
    assert all(r > 1e-6 for c, r in reach.items() if c > 22e-6)


@pytest.mark.full
def test_a_page_prints_with_its_settings(small, opened, tmp_path):  # noqa: F811
    page = opened(small, "#mass.mass=2&extrapolation=0")
    page.emulate_media(media="print")
    assert page.locator("[id='p-mass.mass']").is_visible()
    assert page.locator("#extrapolation").is_visible()
    for hidden in ("#pin", "#presets", "[aria-label^='mass'][type='range']"):
        assert not page.locator(hidden).first.is_visible()
    page.locator("#scan .main-svg").first.wait_for(timeout=WAIT)
    assert len(page.pdf(path=tmp_path / "page.pdf")) > 30_000
    assert page.evaluate(JUDGED)
