"""A page that computes a scene, opened from a disk without a network: its numbers against runs in process, and how it is used."""

import gzip
import json
import random
import re
import subprocess
import tomllib
from base64 import b64decode
from math import isfinite, nan
from pathlib import Path

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.derivatives.gradient import gradient
from cosimo.orchestrator.harness.studies.quantities import TimeHistory, quantities_of
from cosimo.orchestrator.harness.summary import with_error
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import explore_page, load_scene, read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.fmus.native.web_assembly import NODE, needs_node
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401

pytestmark = needs_node
WAIT = 60_000  # ms: a busy machine
JUDGED = "Number(document.getElementById('results').dataset.judged) === question"
LADDERED = "Number(document.getElementById('results').dataset.laddered) === question"


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A page of a small scene."""
    varied = {"spring.stiffness": (50.0, 800.0), "mass.mass": None}
    return explore_page(load_scene("mass-on-spring"), tmp_path_factory.mktemp("page") / "small.html", parameters=varied)


@pytest.fixture(scope="module")
def railway(tmp_path_factory):
    """The page of the railway scene, as the command writes it."""
    path = tmp_path_factory.mktemp("page") / "railway.html"
    main_done(["explore", "en50318-2002", "-o", str(path)])
    return path


def main_done(arguments):
    end = exit_code(*arguments)
    assert end in (0, None)


@pytest.fixture
def opened(browser):  # noqa: F811
    """Opens a page without a network; nothing but the page may be asked for, and no script may fail."""
    context = browser.new_context(offline=True)
    asked, failed = [], []

    def of(path, fragment=""):
        page = context.new_page()
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: failed.append(str(error)))
        page.goto(path.as_uri() + fragment)
        page.wait_for_function(JUDGED, timeout=WAIT)
        return page

    yield of
    assert failed == []
    assert {url.partition("#")[0].split(":")[0] for url in asked} <= {"file", "blob"}
    assert sum(url.startswith("file") for url in asked) <= 3  # the page itself, once for each time it was opened
    context.close()


def at(page, fragment):
    """The numbers of a state, by the address."""
    page.evaluate(f"location.hash = {json.dumps(fragment)}")
    page.wait_for_function(f"decodeURIComponent(location.hash).slice(1) === {json.dumps(fragment)} && {JUDGED}", timeout=WAIT)
    return page.evaluate("({numbers: shown.numbers, errors: shown.errors, count: shown.count, said: shown.said})")


def test_numbers_are_those_of_a_run_in_process(small, opened):
    page = opened(small)
    assert len(small.read_bytes()) - len(page.inner_html("#plotly-inside")) < 1_000_000
    for stiffness, mass in ((100.0, 1.0), (333.0, 2.5)):
        changes = {"spring.stiffness": stiffness, "mass.mass": mass, "record.interval": None}
        scene = load_scene("mass-on-spring").with_changes(changes)
        result = run(scene, in_process=True)
        history = TimeHistory(result.time, result.columns)
        page_numbers = at(page, f"spring.stiffness={stiffness}&mass.mass={mass}")["numbers"]
        expected = {q.name: q.value(history) for q in quantities_of(scene) if q.kind != "time history"}
        assert expected
        assert {name: page_numbers[name] for name in expected} == pytest.approx(expected, rel=1e-12)


def slopes(page, folder, *jobs):
    """What the page's own worker answers under Node: of each job the derivatives of all figures, and why there are none."""
    job, result = folder / "job.json", folder / "answers.json"
    job.write_text(json.dumps({"jobs": jobs, "result": str(result)}))
    host = str(Path(__file__).with_name("worker_host.mjs"))
    done = subprocess.run([NODE, host, str(page), str(job)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    answers = json.loads(result.read_text())
    assert [answer["kind"] for answer in answers] == ["slope"] * len(jobs), answers
    return [answer["figures"] for answer in answers]


def like_gradient(figures, slopes, rel=1e-9, errors=0.0):
    """Whether the figures of an answer have the derivatives that the command gives, to one side or both, and none where that has none."""
    for expected in slopes:
        here = figures[expected.figure]
        number = here["derivative"] if here["derivative"] is not None else nan
        tolerance = max(1e-12, errors * expected.error)
        assert number == pytest.approx(expected.derivative, rel=rel, abs=tolerance, nan_ok=True), (expected, here)
        assert here["how"] == expected.how.partition(", ")[2]
        assert (here["why"] == "") == isfinite(expected.derivative)


def test_slopes_are_those_of_the_command(small, tmp_path):
    """By a mass; by a place at which a decision stands at its boundary; by what sets the error alone there is none."""
    state = {"spring.stiffness": 333.0, "mass.mass": 2.5}
    names = ["mass.mass", "mass.start_x", "mass.substep"]
    *answers, refused = slopes(small, tmp_path, *({"slope": name, "values": state} for name in names))
    scene = load_scene("mass-on-spring").with_changes(state | {"record.interval": None})
    quantities = [q for q in quantities_of(scene) if q.kind != "time history"]

    def own(r):
        return {q.name: (q.value(TimeHistory(r.time, r.columns)), q.unit) for q in quantities}

    expected = gradient(scene, own, names, halved=False)
    assert len(expected.slopes) == 2
    for name, figures in zip(names, answers, strict=False):
        like_gradient(figures, [s for s in expected.slopes if s.parameter == name])
    assert {figure["why"] for figure in refused.values()} == set(expected.refused.values())
    assert {figure["derivative"] for figure in refused.values()} == {None}


@pytest.mark.full
def test_slopes_of_a_line_whose_droppers_stand_at_their_boundary(railway, tmp_path):
    """By the force, exact; by a tension upwards alone, for droppers at rest slacken when it falls."""
    scene = load_scene("en50318-2002").with_changes(
        {"record.snapshots": (), "record.snapshot_interval": None, "record.interval": None}
    )
    names = ["pantograph.static_force", "catenary.contact_wire_tension"]
    expected = gradient(scene, None, names, halved=False).slopes
    for name, figures in zip(names, slopes(railway, tmp_path, *({"slope": name} for name in names)), strict=True):
        like_gradient(figures, [s for s in expected if s.parameter == name and s.figure in figures], errors=2.0)


@pytest.mark.full
def test_a_slope_is_asked_for_by_a_button_and_seen_beside_the_next_runs(small, opened):
    page = opened(small)
    assert page.evaluate("slopeSources") is None
    assert page.locator("[id='s-mass.mass']").get_attribute("aria-pressed") == "false"
    page.locator("[id='s-mass.mass']").click()
    sloped = "Number(document.getElementById('results').dataset.sloped) === question"
    page.wait_for_function(sloped, timeout=WAIT)
    force = json.dumps("spring.second_force_x, maximum")
    slope, was = page.evaluate(f"[slope.figures[{force}].derivative, shown.numbers[{force}]]")
    assert f"slope +{slope:.3g} N per kg; 1 % moves it +{slope / was:.2g} %" in page.inner_text("#numbers")
    page.locator("#curve1 .main-svg").first.wait_for(timeout=WAIT)
    assert "by the slope, +0.1 kg" in page.inner_text("#curve1")
    page.evaluate("change({ ...state, values: { 'mass.mass': 1.05 } }, false, true)")  # as a slider that is dragged
    page.wait_for_function(f"shown.numbers[{force}] !== {was}", timeout=WAIT)
    assert f"by the slope {was + 0.05 * slope:.5g} N" in page.inner_text("#numbers")
    assert page.evaluate(f"shown.numbers[{force}]") == pytest.approx(was + 0.05 * slope, rel=2e-3)
    page.locator("[id='p-spring.stiffness']").focus()
    page.wait_for_function(f"slope.name === 'spring.stiffness' && {sloped}", timeout=WAIT)
    assert page.locator("[id='s-mass.mass']").get_attribute("aria-pressed") == "false"


@pytest.mark.full
def test_the_railway_page_at_random_states(railway, opened):
    page, chance = opened(railway), random.Random(20261126)
    base = load_scene("en50318-2002").with_changes({"record.snapshots": (), "record.snapshot_interval": None})
    offered = {p["name"]: p for p in page.evaluate("data.parameters")}
    first, compared = page.evaluate("data.first"), 0
    for _ in range(12):
        names = chance.sample(first, 3)
        low = {"pantograph.speed": 1.0}  # slower, the run does not reach the window of the figures
        values = {n: float(f"{chance.uniform(low.get(n, 0.8), 1.2) * offered[n]['value']:.5g}") for n in names}
        step, off = chance.choice((0.001, 0.002)), chance.random() < 0.3
        fragment = "&".join([*(f"{n}={v}" for n, v in values.items()), *(["off=catenary.dropper_slackening"] if off else []),
                             *([f"step={step}"] if step != 0.001 else [])])  # fmt: skip
        changes = {f"{u}.{p}": v for n, v in values.items() for u, _, p in [n.partition(".")]}
        changes |= (
            {"units.catenary.effects": [e for e in base.units["catenary"].effects if e != "dropper_slackening"]} if off else {}
        )
        result = run(base.with_changes(changes | {"master.step": step}), in_process=True)
        here = at(page, fragment)
        assert here["said"] == "", here["said"]
        for row in result.summary:
            if row.name in here["numbers"] and isfinite(row.value):
                number = here["numbers"][row.name]
                assert number == pytest.approx(row.value, rel=1e-6, abs=1e-6), (fragment, row.name)
                compared += 1
    assert compared > 80


@pytest.mark.full
def test_the_ranges_and_the_stability_limit(railway, opened):
    page = opened(railway)
    assert page.locator("#ranges tbody tr.in").count() == 8
    page.get_by_role("button", name="300 km/h").click()
    page.wait_for_function(JUDGED, timeout=WAIT)
    assert "300 km/h" in page.inner_text("#ranges caption")
    assert page.locator("#ranges tbody tr").count() == 8
    page.get_by_role("button", name="Reset", exact=True).click()
    page.select_option("#step", label="20 ms")
    page.wait_for_function(LADDERED, timeout=WAIT)
    assert "beyond the stability limit" in page.inner_text("#sentence")
    assert "unstable" in page.inner_text("#limit")


@pytest.mark.full
def test_while_dragging_the_latest_change_wins(railway, opened):
    page = opened(railway)
    slider = page.get_by_label("uplift force of the drive, slider")
    box = slider.bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.5 * box["width"], middle)
    page.mouse.down()
    for k in range(30):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.01 * k), middle)
    page.mouse.up()
    page.wait_for_function(JUDGED, timeout=WAIT)
    force = float(page.input_value("[id='p-pantograph.static_force']"))
    assert force > 130.0
    assert page.evaluate("location.hash") == f"#pantograph.static_force={force:g}"
    dragged = page.evaluate("shown.numbers")
    assert at(page, f"pantograph.static_force={force - 1:g}")["numbers"] != dragged
    assert at(page, f"pantograph.static_force={force:g}")["numbers"] == dragged


@pytest.mark.full
def test_nonsense_is_one_message_and_changes_nothing(small, opened):
    page = opened(small)
    before = page.evaluate("JSON.stringify(shown.numbers)")
    field = page.locator("[id='p-mass.mass']")
    for nonsense in ("-1", "", "heavy", "1e999", "NaN"):
        field.fill(nonsense)
        assert field.get_attribute("aria-invalid") == "true"
        assert "expected a number" in page.inner_text("[id='p-mass.mass-wrong']")
    assert page.evaluate("JSON.stringify(shown.numbers)") == before
    field.fill("2")
    field.press("Enter")
    assert field.get_attribute("aria-invalid") == "false"
    page.wait_for_function(JUDGED, timeout=WAIT)
    assert page.evaluate("JSON.stringify(shown.numbers)") != before
    at(page, "")
    page.evaluate("location.hash = 'mass.mass=-3&no=1'")
    page.wait_for_function("!document.getElementById('sentence').hidden", timeout=WAIT)
    assert "mass.mass=-3, no=1" in page.inner_text("#sentence")


@pytest.mark.full
def test_a_run_that_fails_says_why_and_the_page_goes_on(small, opened):
    page = opened(small)
    page.evaluate("location.hash = 'spring.stiffness=1e9'")
    page.wait_for_function("shown.said !== ''", timeout=WAIT)
    assert "The run ended at" in page.inner_text("#sentence")
    assert at(page, "spring.stiffness=100")["said"] == ""
    assert page.locator("#sentence").is_hidden()


@pytest.mark.full
def test_a_refused_state_shows_the_sentence_of_the_command_and_the_next_one_is_computed(railway, opened, capsys):
    """The wires' damping shortens the longest internal step: the component refuses its own before the first step."""
    page = opened(railway)
    look = "document.getElementById('results').className"
    for damping in (0.002, 0.0025, 0.02):
        before = page.inner_text("#numbers")
        page.evaluate(f"location.hash = 'catenary.damping.beta={damping}'")
        page.wait_for_function(f"state.values['catenary.damping.beta'] === {damping} && {JUDGED}", timeout=WAIT)
        assert exit_code("run", "en50318-2002", "--in-process", "--no-verify", "--set", f"catenary.damping.beta={damping}") == 2
        sentence = " ".join(capsys.readouterr().err.split()).removeprefix("cosimo: ")
        assert "the explicit method's limit" in sentence
        assert page.inner_text("#sentence") == f"This state does not start: {sentence}"
        assert (page.evaluate(look), page.inner_text("#numbers")) == ("refused", before)
        assert at(page, "catenary.damping.beta=0.0011")["said"] == ""
        assert page.evaluate(look) == ""
        assert page.locator("#sentence").is_hidden()
        assert at(page, "pantograph.static_force=121")["numbers"]["pantograph.mean"] != pytest.approx(116.009, abs=1e-3)


def with_errors_of_steps(scene):
    """The verified run, whose errors are those of the steps and of rows left out alone, as the page has them and says."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verification, "between", lambda *_: {})
        patch.setattr(verification, "of_parts", lambda *_: {})
        patch.setattr(verification, "_with_mesh", lambda _, verified, *__: verified)
        return verification.run_verified(scene, verify="whole", in_process=True)


@pytest.mark.full
def test_errors_are_those_of_the_command(railway, opened):
    printed = opened(railway).evaluate("shown.errors")
    rows = {row.name: row for row in with_errors_of_steps(load_scene("en50318-2002")).summary}
    shared = printed.keys() & rows.keys()
    assert len(shared) >= 8
    assert {n: printed[n] for n in shared} == pytest.approx({n: rows[n].error for n in shared}, rel=1e-6)


@pytest.mark.full
def test_back_forward_pin_and_keys(small, opened):
    page = opened(small)
    field = page.locator("[id='p-mass.mass']")
    for value in ("2", "3"):
        field.fill(value)
        field.press("Enter")
        page.wait_for_function(JUDGED, timeout=WAIT)
    page.get_by_role("button", name="Pin for comparison").click()
    page.go_back()
    page.wait_for_function(f"state.values['mass.mass'] === 2 && {JUDGED}", timeout=WAIT)
    assert field.input_value() == "2"
    assert "pinned" in page.inner_text("#numbers")
    page.go_forward()
    page.wait_for_function(f"state.values['mass.mass'] === 3 && {JUDGED}", timeout=WAIT)
    slider = page.get_by_label(re.compile("mass.*slider")).first
    slider.focus()
    slider.press("ArrowLeft")
    page.wait_for_function(f"state.values['mass.mass'] < 3 && {JUDGED}", timeout=WAIT)
    page.get_by_role("button", name="Reset", exact=True).click()
    page.wait_for_function(f"location.hash === '' && {JUDGED}", timeout=WAIT)
    unnamed = "[...document.querySelectorAll('input, select, textarea')].filter((e) => !e.labels.length && !e.ariaLabel)"
    assert page.evaluate(f"{unnamed}.length") == 0


@pytest.mark.full
def test_a_state_as_scene_command_and_python(railway, opened, tmp_path):
    page = opened(railway, "#pantograph.static_force=110&off=catenary.dropper_slackening&step=0.002")
    (scene,) = [read_scene(tomllib.loads(page.input_value("#toml")))]
    assert scene.units["pantograph"].parameters["static_force"] == 110
    assert "dropper_slackening" not in scene.units["catenary"].effects
    assert scene.master.step == 0.002
    names = {}
    exec(page.input_value("#python").partition("result =")[0], names)
    changed = names["scene"]
    assert changed.units == scene.units
    at(page, "pantograph.static_force=110&step=0.002")
    command = page.input_value("#command").split()
    assert command[:3] == ["cosimo", "run", "en50318-2002"]
    main_done([*command[1:], "--stop", "0.1", "--no-verify", "--in-process"])


@pytest.mark.full
def test_pages_are_light_dark_and_narrow(small, browser):  # noqa: F811
    context = browser.new_context(offline=True, color_scheme="dark", viewport={"width": 390, "height": 800})
    page = context.new_page()
    page.goto(small.as_uri())
    page.locator("#curve1 .main-svg").first.wait_for(timeout=WAIT)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 25, 31)"
    slider, curve = page.locator("#first input[type=range]").last, page.locator("#curve1")
    page.locator("#numbers dd").first.wait_for(timeout=WAIT)  # nothing grows any more
    slider.scroll_into_view_if_needed()
    box, dragged = curve.bounding_box(), slider.bounding_box()
    assert 0 <= box["y"] < box["y"] + box["height"] <= dragged["y"] < 800  # the curve is in view above what one drags
    context.close()


@pytest.mark.full
def test_a_slider_is_read_in_the_unit_of_the_field(railway, opened):
    """250 km/h is the 69.444444 m/s of the scene; 300 km/h goes into the state in m/s."""
    page = opened(railway)
    field = page.locator("[id='p-pantograph.speed']")
    assert field.input_value() == "250"
    field.fill("300")
    field.press("Enter")
    assert page.evaluate("state.values['pantograph.speed']") == pytest.approx(300.0 / 3.6, rel=1e-11)
    field.fill("250")
    field.press("Enter")
    assert page.evaluate("state.values") == {}
    field.fill("-400")
    assert "km/h" in page.inner_text("[id='p-pantograph.speed-wrong']")


@pytest.mark.full
def test_numbers_are_printed_as_in_reports(small, opened):
    page, chance = opened(small), random.Random(1)
    pairs = [(chance.uniform(-1, 1) * 10 ** chance.randint(-6, 6), 10 ** chance.uniform(-9, 4)) for _ in range(300)]
    pairs += [(116.009, 0.0069), (0.0, 0.1), (5.0, 0.0), (1.23456789e-9, 1e-12), (29.4, 0.14)]
    printed = page.evaluate("(pairs) => pairs.map(([v, e]) => withError(v, e))", pairs)
    assert printed == [
        with_error(*pair).removeprefix("-") if with_error(*pair).startswith("-0 ") else with_error(*pair) for pair in pairs
    ]


@pytest.mark.parametrize(
    ("scene", "options", "words"),
    [
        ("mass-on-spring", {"parameters": {"mass.mas": None}}, "Did you mean 'mass.mass'"),
        ("mass-on-spring", {"parameters": {"mass.mass": (3.0, 2.0)}}, "a range around"),
        ("mass-on-spring", {"effects": ["mass.gravity"]}, "an effect that is on"),
        ("link-split", {}, "iterative"),
        ("en50318-2002-interface-model", {}, "a contact"),
    ],
)
def test_what_no_page_can_hold_is_refused(scene, options, words, tmp_path):
    with pytest.raises(BadInput, match=words):
        explore_page(load_scene(scene), tmp_path / "page.html", **options)
    assert list(tmp_path.iterdir()) == []


def test_modules_of_the_page_are_whole(small):
    text = small.read_text(encoding="utf-8")
    modules = re.findall(r'id="module\d+">([^<]+)<', text)
    assert [gzip.decompress(b64decode(module))[:4] for module in modules] == 2 * [b"\0asm"]  # of two algorithms


DRAG = """async ([name, share]) => {
    const results = document.getElementById("results");
    const slider = document.getElementById(`p-${name}`).parentElement.querySelector("input[type=range]");
    delete results.dataset.answered;
    slider.value = Number(slider.min) + share * (Number(slider.max) - Number(slider.min));
    slider.dispatchEvent(new Event("input"));
    while (!results.dataset.answered) await new Promise(requestAnimationFrame);
}"""
SEEN = """() => {  // largest value of the curve as it is drawn, and as it was computed
    const box = document.getElementById("curve1"), { yaxis } = box._fullLayout;
    const points = box.querySelector(".scatterlayer path.js-line").getAttribute("d").match(/[-0-9.]+,[-0-9.]+/g);
    const drawn = points.map((p) => Number(p.split(",")[1]));
    const name = document.getElementById("signal1").value, largest = Math.max(...shown.columns[name]);
    return [yaxis.p2c(Math.min(...drawn)), largest * shownAs(data.signals.find((s) => s.name === name), largest).factor];
}"""


@pytest.mark.full
def test_a_curve_follows_a_slider_in_its_axes_or_in_wider_ones(small, opened):
    page = opened(small)
    page.locator("#curve1 .main-svg").first.wait_for()
    laid_out = "Plotly.react = ((react) => (...given) => { laidOut += 1; return react(...given); })(Plotly.react); null"
    page.evaluate(f"globalThis.laidOut = 0; {laid_out}")
    for share in (0.3, 0.31, 0.32, 0.9, 0.05, 0.06):
        page.evaluate(DRAG, ["spring.stiffness", share])
        drawn, computed = page.evaluate(SEEN)
        assert drawn == pytest.approx(computed, rel=0.01)
    assert 1 <= page.evaluate("laidOut") < 12  # of twelve curves
