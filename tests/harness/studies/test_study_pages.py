"""Pages of studies in a real browser: every figure is drawn, nothing goes wrong, nothing is asked of any network."""

import re
import shutil
import subprocess
from dataclasses import replace
from math import inf

import pytest
from cosimo.components.core.hard_cases import AtMost, HardCase
from cosimo.orchestrator.harness.report.studies.accuracy import for_accuracy
from cosimo.orchestrator.harness.report.studies.effects import for_effects
from cosimo.orchestrator.harness.report.studies.hard_cases import for_hard_cases
from cosimo.orchestrator.harness.report.studies.stability import for_internal_steps, for_stability
from cosimo.orchestrator.harness.studies.accuracy import OWN, Accuracy, Point, accuracy
from cosimo.orchestrator.harness.studies.component_accuracy import component_accuracy
from cosimo.orchestrator.harness.studies.effects import effects
from cosimo.orchestrator.harness.studies.hard_cases import HardCases, hard_cases, verdicts
from cosimo.orchestrator.harness.studies.internal_steps import internal_steps
from cosimo.orchestrator.harness.studies.stability import stability
from cosimo.orchestrator.systems import load_scene, read_scene

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SHORT = {"stop_time": 0.5}


def accuracy_of_a_scene(folder):
    return for_accuracy(accuracy(load_scene("mass-on-spring").with_changes(SHORT), budget=3.0, repeats=1), folder)


def accuracy_with_failures(folder):
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 4.0, "master.step": 4e-2})
    return for_accuracy(accuracy(scene, budget=3.0, repeats=1), folder)


def accuracy_of_a_component(folder):
    return for_accuracy(component_accuracy("PlanarLink", ("gravity",), stop=0.1, budget=2.0, repeats=1), folder)


def accuracy_without_results(folder):
    points = (Point(OWN, "own", 1e-3, {}, "failed", "at once"), Point("jacobi, held", "coupling", 2e-3, {}, "refused", "never"))
    return for_accuracy(Accuracy("a", "a", points, "by hand", "by hand", {"x, end": 1e-3}, "here", "now"), folder)


def effects_of_a_scene(folder):
    return for_effects(effects(load_scene("mass-on-spring").with_changes(SHORT), 0.01), folder)


def effects_without_which_runs_fail(folder):
    found = effects(load_scene("mass-on-spring").with_changes(SHORT), 0.01)
    failed = [replace(f, actual=inf, reason="left its range") for f in found.findings]
    return for_effects(replace(found, findings=tuple(failed)), folder)


def effects_of_a_scene_without_any(folder):
    scene = {"stop_time": 0.1, "master": {"step": 0.01}, "units": {"water": {"component": "AddedMassForce"}}}
    return for_effects(effects(read_scene(scene), 0.01), folder)


def hard_cases_of_two_components(folder):
    return for_hard_cases(hard_cases(["TowCoupling", "ExciterProgram"]), folder)


def hard_cases_that_fail(folder):
    claims = (AtMost("stretch", 1e-3), AtMost("rear_force", 1.0))
    case = HardCase("What is hard.", claims, name="a case", inputs={"front_position": 0.6})
    return for_hard_cases(HardCases(tuple(verdicts("TowCoupling", case))), folder)


def stability_of_a_map(folder):
    table = {"spring.damping": [1.0, 4.0], "mass.mass": [0.5, 1.0]}
    scene = load_scene("mass-on-spring").with_changes({"study.stability": table})
    return for_stability(stability(scene, [("jacobi", 0), ("jacobi", 1)]), folder)


def stability_over_one_parameter(folder):
    scene = load_scene("mass-on-spring").with_changes({"study.stability": {"spring.damping": [0.0, 1.0, 4.0]}})
    return for_stability(stability(scene, [("jacobi", 0), ("iterative", 0)]), folder)


def stability_without_a_map(folder):
    scene = load_scene("mass-on-spring").with_changes({"study.stability": {}})
    return for_stability(stability(scene, [("jacobi", 0), ("iterative", 0), ("interface-model", 1)]), folder)


def internal_steps_of_a_component(folder):
    return for_internal_steps(internal_steps("PlanarLink"), folder)


PAGES = {  # -> figures that the page must have at least
    accuracy_of_a_scene: 3,
    accuracy_with_failures: 3,
    accuracy_of_a_component: 3,
    accuracy_without_results: 2,
    effects_of_a_scene: 2,
    effects_without_which_runs_fail: 2,
    effects_of_a_scene_without_any: 0,
    hard_cases_of_two_components: 1,
    hard_cases_that_fail: 1,
    stability_of_a_map: 1,
    stability_over_one_parameter: 1,
    stability_without_a_map: 1,
    internal_steps_of_a_component: 1,
}


def opened(path, folder):
    """(DOM, messages of the console, addresses asked for) of a page, all of which is on the screen; no host is found."""
    log = folder.with_name("net.json")
    done = subprocess.run(
        [
            BROWSER,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--window-size=1200,12000",
            f"--user-data-dir={folder}",
            "--enable-logging=stderr",
            "--virtual-time-budget=20000",
            f"--log-net-log={log}",
            "--dump-dom",
            path.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    asked = set(re.findall(r'"url":"(https?://[^"]*)"', log.read_text(encoding="utf-8")))
    asked = {url for url in asked if not re.match(r"https?://[\w.-]*\.google(apis)?\.com/", url)}  # the browser's own
    return done.stdout, re.findall(r"CONSOLE[^\"]*\"(.*)\", source", done.stderr), asked


@pytest.mark.full
@pytest.mark.skipif(BROWSER is None, reason="needs a browser")
@pytest.mark.parametrize("make", PAGES, ids=lambda make: make.__name__)
def test_a_page_opens(make, tmp_path):
    page = make(tmp_path)
    for attempt in range(3):  # where the machine is busy, the browser may be done before its first frame, which draws
        dom, console, asked = opened(page, tmp_path / f"browser{attempt}")
        figures = len(re.findall(r'class="plot[ "]', dom))
        if len(re.findall(r'class="plot-container', dom)) == figures:
            break
    assert figures >= PAGES[make]
    assert len(re.findall(r'class="plot-container', dom)) == figures
    assert console == []
    assert asked == set()


@pytest.mark.skipif(BROWSER is None, reason="needs a browser")
def test_what_is_looked_for_would_be_seen(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text('<html><body><img src="http://example.org/x.png"><script>nothing();</script></body></html>', encoding="utf-8")
    _, console, asked = opened(page, tmp_path / "browser")
    assert any("nothing is not defined" in line for line in console)
    assert asked == {"http://example.org/x.png"}
