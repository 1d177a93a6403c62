"""Machines in motion: places of parts against closed forms, what a page gets of them."""

import json
from base64 import b64decode
from dataclasses import replace
from importlib import resources

import cosimo
import numpy as np
import pytest
from cosimo.orchestrator.harness.charts.blocks import Motion, Moving
from cosimo.orchestrator.harness.charts.motion import box, instants, motion_data, polyline, still_motion
from cosimo.orchestrator.systems import SYSTEMS
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401
from cosimo.tests.short_run import full_but

# scene -> its length, s, and what is shown
SHOWN = {
    "two-link-manipulator": (0.4, "arm in motion"),
    "gimbal-scan": (0.2, "body in motion"),
    "rov-station-keeping": (0.4, "hull in motion"),
    "wrist-motion": (0.1, "wrist in motion"),
    "rotor-run-up": (0.02, "rotor: orbits"),
    "en50318-2002": (0.6, "The pantograph under the wire"),
}


def shortened(name, length):
    scene = cosimo.load_scene(name).with_changes({"stop_time": length, "analysis.transient": 0.0})
    return cosimo.run(scene, in_process=True, verify="no")


def moving(result):
    return [machine.motion(result) for machine in SYSTEMS[result.scene.analysis.system].motions(result)]


@pytest.mark.interpreted
@pytest.mark.parametrize("name", full_but(("two-link-manipulator", "rov-station-keeping", "wrist-motion"), SHOWN))
def test_a_system_shows_its_machine(name):
    length, title = SHOWN[name]
    result = shortened(name, length)
    pictures = moving(result)
    assert title in [picture.title for picture in pictures]
    for picture in pictures:
        assert all(line.points.shape[0] in (1, picture.time.size) for line in picture.lines)
        assert all(np.isfinite(line.points).any() for line in picture.lines)
        x0, x1, y0, y1 = box(picture)
        assert x0 < x1
        assert y0 < y1


IN_A_PAGE = """([machine, run]) => {
    const floats = (columns) => Object.fromEntries(Object.entries(columns).map(([name, x]) => [name, Float64Array.from(x)]));
    const pictures = { ...run.pictures, columns: floats(run.pictures.columns) };
    const motion = motionOf(machine, { ...run, columns: floats(run.columns), pictures }, (name) => run.parameters[name]);
    const numbers = (line) => ({ ...line, points: [...line.points].map(String) }); // NaN is no JSON
    return motion && { ...motion, time: [...motion.time], lines: motion.lines.map(numbers) };
}"""


def in_a_page(browser, machine, result, step, every=1):  # noqa: F811
    """The motion that a page draws from formulas, with the columns of a run in place of those of its module."""
    scene = result.scene
    numbers = {f"{u}.{p}": v for u, unit in result.info.units.items() for p, v in unit.parameters.items()}
    numbers = {name: v for name, v in numbers.items() if isinstance(v, float) and "[" not in name}
    data = machine.formulas(result, numbers)
    columns = {
        name: np.asarray(x, dtype=float).tolist() for name, x in result.columns.items() if name.partition(".")[0] in scene.units
    }
    pictures = {f"{n}[{k + 1}]": result.snapshots[n].values[:, k].tolist()
                for n in data["snapshots"] for k in range(result.snapshots[n].values.shape[1])}  # fmt: skip
    run = {"columns": columns, "count": result.time.size, "step": step, "parameters": numbers,
           "pictures": {"every": every, "columns": pictures}}  # fmt: skip
    page = browser.new_page()
    source = resources.files("cosimo.orchestrator.harness.explore").joinpath("kinematics.js").read_text(encoding="utf-8")
    page.evaluate(f"{source}; Object.assign(window, {{ motionOf }})")
    motion = page.evaluate(IN_A_PAGE, [data, run])
    page.close()
    return motion


# scene -> length, s, and changes: every kind of picture that a system makes
FORMULAS = {
    "two-link-manipulator": (0.4, {}),
    "gimbal-scan": (0.2, {}),
    "rov-station-keeping": (1.0, {}),
    "wrist-motion": (0.1, {}),
    "rotor-run-up": (0.02, {}),
    "en50318-2002": (0.6, {"record.snapshot_interval": 0.004}),
    "en50318-2018-dc-simple": (0.4, {"record.snapshot_interval": 0.004}),
}


@pytest.mark.full
@pytest.mark.parametrize("name", FORMULAS)
def test_a_page_draws_from_formulas_what_a_report_draws_from_numbers(name, browser):  # noqa: F811
    length, changes = FORMULAS[name]
    scene = cosimo.load_scene(name).with_changes(
        {"stop_time": length, "analysis.transient": 0.0, "record.interval": None} | changes
    )
    result = cosimo.run(scene, in_process=True, verify="no")
    step = scene.master.step
    for machine in SYSTEMS[scene.analysis.system].motions(result):
        expected = machine.motion(result)
        drawn = in_a_page(
            browser, machine, result, step, round(scene.record.snapshot_interval / step) if machine.snapshots else 1
        )
        np.testing.assert_allclose(drawn["time"], expected.time, atol=1e-9)
        x0, x1, y0, y1 = box(expected)
        np.testing.assert_allclose(drawn["box"], [x0, x1, y0, y1], atol=1e-6 * max(x1 - x0, y1 - y0))
        assert [line["look"] for line in drawn["lines"]] == [line.look for line in expected.lines]
        for line, numbers in zip(drawn["lines"], expected.lines, strict=True):
            points = np.array(line["points"], dtype=float).reshape(-1, *numbers.points.shape[1:])
            np.testing.assert_allclose(points, np.broadcast_to(numbers.points, points.shape), atol=1e-6 * max(x1 - x0, y1 - y0))


@pytest.mark.full
def test_a_page_has_no_picture_of_what_it_does_not_know(browser):  # noqa: F811
    result = shortened("two-link-manipulator", 0.1)
    (machine,) = SYSTEMS["two_axis_joint"].motions(result)
    without = {name: x for name, x in result.columns.items() if name != machine.signals["second"]}
    assert in_a_page(browser, machine, replace(result, columns=without), 1e-3) is None  # of an effect that is off
    alone = replace(machine, signals=machine.signals | {"second": result[machine.signals["second"]]})
    assert alone.formulas(result, {}) is None


@pytest.mark.interpreted
def test_links_end_at_the_recorded_tip():
    result = shortened("two-link-manipulator", 0.4)
    (picture,) = moving(result)
    rows = instants(result.time)
    path, first, second = (line.points for line in picture.lines)
    unit = next(n.removesuffix(".tip_x") for n in result.columns if n.endswith(".tip_x"))
    tip = np.stack([result[f"{unit}.tip_x"][rows], result[f"{unit}.tip_y"][rows]], axis=-1)
    np.testing.assert_allclose(second[:, 1], tip, atol=1e-12)
    np.testing.assert_allclose(path[:, 0], tip, atol=1e-12)
    np.testing.assert_array_equal(first[:, 1], second[:, 0])
    lengths = np.linalg.norm(first[:, 1] - first[:, 0], axis=1)
    np.testing.assert_allclose(lengths, lengths[0])


def test_a_page_gets_the_numbers_as_they_are():
    time = np.linspace(0.0, 1.0, 5)
    motion = Motion("A bar", time, [Moving(polyline((0.0, 0.0), (time, 2.0 * time)))])
    data = json.loads(json.dumps(motion_data(motion)))
    points = np.frombuffer(b64decode(data["lines"][0]["points"]), dtype="<f4").reshape(5, 2, 2)
    np.testing.assert_array_equal(points[:, 1], np.stack([time, 2.0 * time], axis=-1))
    assert data["lines"][0]["corners"] == 2
    assert still_motion(motion).count("<polyline") == 5


def test_a_long_motion_shows_its_beginning():
    time = np.arange(0.0, 100.0, 1e-3)
    assert time[instants(time)[-1]] == time[-1]
    assert time[instants(time, 20.0)[-1]] == pytest.approx(20.0)
    assert instants(np.array([0.0, 1.0])).tolist() == [0, 1]
