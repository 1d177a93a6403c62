"""Pages of scenes of several systems: their figures at random states against those of runs in process."""

import json
import random
from math import isfinite

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, explore_page, load_scene
from cosimo.tests.fmus.native.web_assembly import needs_node
from cosimo.tests.harness.explore.test_explore_page import at, opened, with_errors_of_steps  # noqa: F401
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401

pytestmark = needs_node
STATES = 3  # of each scene
DRAWN = """(k) => {
    const { time, lines } = motionOf(data.machines[k], shown, (name) => state.values[name] ?? parameters[name].value);
    return { time: [...time], lines: lines.map((line) => [...line.points]) };
}"""
# scene -> (what is varied, changes that make the motion one that does not follow the last digits, figures of the summary at least)
SCENES = {
    "mass-on-spring": (("spring.stiffness", "spring.damping", "mass.mass"), {}, 0),
    "ball-bearing-clearance": (
        ("bearing.mass", "bearing.damping", "bearing.contact_stiffness"),
        {"bearing.clearance.radial_clearance": 2e-6, "stop_time": 1.5},
        6,
    ),
    "rov-station-keeping": (("current.speed", "current.gust.amplitude", "hull.mass"), {}, 4),
    "wind-pump-gusts": (("converter.lever_mass", "converter.crank_radius", "wind.gusts.amplitude"), {}, 4),
    "friction-drive-step": (("wheels.normal_force", "wheels.friction", "controller.feed_gain"), {}, 4),
    "pipe-robot-resonance": (("straight.stiffness", "straight.damping", "stiffening.stiffness"), {}, 6),
    "wrist-motion": (("wrist.flexion_stiffness", "wrist.deviation_stiffness", "wrist.hand_mass"), {}, 6),
    "passive-walkers": (("compass.hip_mass", "compass.leg_mass"), {"stop_time": 4.0}, 4),
    "gimbal-scan": (("body.gravity.distance", "outer_motor.resistance"), {}, 4),
}


@pytest.mark.full
@pytest.mark.parametrize("name", SCENES)
def test_figures_at_random_states(name, opened, tmp_path):  # noqa: F811
    varied, changes, least = SCENES[name]
    scene = load_scene(name).with_changes({**changes, "record.interval": None})
    page = opened(explore_page(scene, tmp_path / "page.html", parameters=dict.fromkeys(varied), effects=()))
    assert_errors_are_those_of_the_command(page, scene)
    usual, chance = {p["name"]: p["value"] for p in page.evaluate("data.parameters")}, random.Random(name)
    for _ in range(STATES):
        values = {n: float(f"{chance.uniform(0.85, 1.15) * usual[n]:.5g}") for n in varied}
        degree = chance.choice([int(d) for d in page.evaluate("Object.keys(data.variants[0].extrapolations)")])
        settings = {f"{u}.{p}": v for n, v in values.items() for u, p in [scene.split(n)]}
        fragment = "&".join(f"{n}={json.dumps(v)}" for n, v in values.items())
        if degree != scene.master.extrapolation:
            settings["master.extrapolation"] = degree
            fragment += f"&extrapolation={degree}"
        result, compared = run(scene.with_changes(settings), in_process=True), 0
        here = at(page, fragment)
        assert here["said"] == ""
        expected = {row.name: row.value for row in result.summary if isfinite(row.value)}
        expected |= {
            f"{n}, {word}": pick(x) for n, x in result.columns.items() for word, pick in (("maximum", max), ("minimum", min))
        }
        for quantity, number in here["numbers"].items():
            if quantity in expected:
                assert number == pytest.approx(expected[quantity], rel=1e-6, abs=1e-9), (fragment, quantity)
                compared += quantity in {row.name for row in result.summary}
        assert compared >= least
    assert_machines_move_alike(page, result)


def assert_errors_are_those_of_the_command(page, scene):
    """The ± of a figure that both have."""
    printed, known = page.evaluate("({ errors: shown.errors, numbers: shown.numbers })"), 0
    for row in with_errors_of_steps(scene).summary:
        if row.name in printed["errors"] and row.error is not None and isfinite(row.error):
            error, numbers = printed["errors"][row.name], (row.name, printed["numbers"][row.name], row.value)
            least = row.error - 1e-2 * row.error - 1e-6 * abs(row.value)
            # the page judges by fewer signals and may be unsure of the order where the command is not: twice the error at most
            assert least <= error <= 2.02 * row.error + 1e-6 * abs(row.value), numbers
            known += 1
    return known


def assert_machines_move_alike(page, result):
    """What the page draws of its last state, against what a report draws of the same run."""
    system = SYSTEMS.get(result.scene.analysis.system)
    machines = system.motions(result) if system else []
    assert page.evaluate("data.machines.length") == len(machines)
    for k, machine in enumerate(machines):
        expected = machine.motion(result)
        drawn = page.evaluate(DRAWN, k)
        assert drawn["time"] == pytest.approx(expected.time, abs=1e-9)
        for points, line in zip(drawn["lines"], expected.lines, strict=True):
            points, size = np.array(points).reshape(-1, *line.points.shape[1:]), np.ptp(line.points) or 1.0
            np.testing.assert_allclose(points, np.broadcast_to(line.points, points.shape), atol=1e-5 * size)
