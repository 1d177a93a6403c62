"""Machines in motion: places of parts against closed forms, what a page gets of them."""

import json
from base64 import b64decode

import cosimo
import numpy as np
import pytest
from cosimo.orchestrator.harness.charts.blocks import Motion, Moving
from cosimo.orchestrator.harness.charts.motion import box, instants, motion_data, polyline, still_motion
from cosimo.orchestrator.systems import SYSTEMS
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


@pytest.mark.interpreted
@pytest.mark.parametrize("name", full_but(("two-link-manipulator", "rov-station-keeping", "wrist-motion"), SHOWN))
def test_a_system_shows_its_machine(name):
    length, title = SHOWN[name]
    result = shortened(name, length)
    pictures = SYSTEMS[result.scene.analysis.system].motions(result)
    assert title in [picture.title for picture in pictures]
    for picture in pictures:
        assert all(line.points.shape[0] in (1, picture.time.size) for line in picture.lines)
        assert all(np.isfinite(line.points).any() for line in picture.lines)
        x0, x1, y0, y1 = box(picture)
        assert x0 < x1
        assert y0 < y1


@pytest.mark.interpreted
def test_links_end_at_the_recorded_tip():
    result = shortened("two-link-manipulator", 0.4)
    (picture,) = SYSTEMS["two_axis_joint"].motions(result)
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
