"""Behaviour of the whole catenary: superposition, slackening, window, second contact point, outputs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.railway.catenary import PROFILE, Catenary
from cosimo.components.railway.statics import elasticity
from cosimo.components.railway.wires import state_rows

REFERENCE = ("dropper_slackening", "gravity_sag", "damping")


def passage(effects=REFERENCE, seconds=2.0, force=120.0, speed=69.4, **parameters) -> tuple[Catenary, np.ndarray]:
    """A force moving along the wire; returns the catenary and the wire's height at the contact point per millisecond."""
    catenary = Catenary(effects, {"first_watched_support": 1} | parameters)
    catenary.set("contact_position", 30.0)
    catenary.set("contact_force", force)
    catenary.initialize(0.0)
    heights = []
    for i in range(round(seconds / 1e-3)):
        catenary.u[:, 0] = 30.0 + speed * i * 1e-3, speed, 0.0
        # a force with some life in it
        catenary.u[0, 1] = force * (1.0 + 0.5 * np.sin(2.0 * np.pi * 3.0 * i * 1e-3))
        catenary.step(i * 1e-3, 1e-3)
        heights.append(catenary["wire_height"])
    return catenary, np.array(heights)


@pytest.mark.full
def test_explicit_and_implicit_agree():
    """Two integrators and two mass matrices, one answer; the difference falls with the mesh."""
    differences = []
    for element, substep in ((1.0, 1e-3), (0.5, 5e-4)):
        explicit = passage(element=element, substep=substep, spans=4)[1]
        implicit = passage(element=element, substep=substep, spans=4, method="implicit")[1]
        differences.append(np.abs(explicit - implicit).max() / np.ptp(explicit))
    assert differences[1] < 0.01
    assert differences[1] < 0.5 * differences[0]


@pytest.mark.known_answers(Catenary="second_pantograph")
@pytest.mark.full
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_two_forces_superpose_where_droppers_are_bilateral(method):
    """Linear system: response to two contact points = sum of the responses to each."""
    whole = {"front_threshold": 0.0} if method == "explicit" else {}  # a threshold is no linear law

    def displacement(first, second):
        effects = ["damping", *(["second_pantograph"] if second is not None else [])]
        catenary = Catenary(effects, {"spans": 4, "method": method, "first_watched_support": 0, "element": 1.0} | whole)
        catenary.set("contact_position", 150.0)
        if second is not None:
            catenary.set("second_pantograph.contact_position", 50.0)
        catenary.initialize(0.0)
        for i in range(300):
            catenary.u[:, 0] = 150.0 + 60.0 * i * 1e-3, 60.0, 0.0
            catenary.u[0, 1] = first
            if second is not None:
                catenary.u[:, 2] = 50.0 + 60.0 * i * 1e-3, 60.0, 0.0
                catenary.u[0, 3] = second
            catenary.step(i * 1e-3, 1e-3)
        return catenary.x[: catenary.mesh.mass.size].copy()

    both = displacement(100.0, 80.0)
    assert np.abs(displacement(100.0, 0.0) + displacement(0.0, 80.0) - both).max() < 1e-9 * np.abs(both).max()
    assert np.abs(displacement(100.0, None) - displacement(100.0, 0.0)).max() < 1e-9 * np.abs(both).max()


@pytest.mark.known_answers(Catenary="further_pantographs")
@pytest.mark.interpreted
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_contact_points_may_change_places(method):
    """Four forces: which of the inputs carries which one changes no bit, of the wires or of what comes out for each."""
    points = {150.0: 100.0, 50.0: 80.0, 110.0: 60.0, 200.0: 90.0}  # m: N, more than four nodes apart

    def run(order):
        effects = [*REFERENCE, "second_pantograph", "further_pantographs"]
        catenary = Catenary(effects, {"spans": 4, "method": method, "element": 2.0, "further_pantographs.count": 2})
        inputs = ["", "second_pantograph.", "further_pantographs.", "further_pantographs."]
        suffix = ["", "", "[1]", "[2]"]
        for where, end, position in zip(inputs, suffix, order, strict=True):
            catenary.set(f"{where}contact_position{end}", position)
            catenary.set(f"{where}contact_force{end}", 0.5 * points[position])
        catenary.initialize(0.0)
        for i in range(50):
            for where, end, position in zip(inputs, suffix, order, strict=True):
                columns = catenary.input_positions([f"{where}contact_position{end}", f"{where}contact_force{end}"])
                catenary.u[:2, columns[0]] = position + 60.0 * i * 1e-3, 60.0
                catenary.u[0, columns[1]] = points[position]
            catenary.step(i * 1e-3, 1e-3)
        names = [f"{w}{{}}{s}" for w, s in zip(inputs, suffix, strict=True)]
        outputs = [[catenary[n.format(o)] for o in ("wire_height", "wire_velocity", "contact_compliance")] for n in names]
        rows = state_rows(catenary.x, catenary.mesh.mass.size)
        return np.concatenate(rows), dict(zip(order, outputs, strict=True))

    state, outputs = run([150.0, 50.0, 110.0, 200.0])
    for order in ([200.0, 110.0, 50.0, 150.0], [50.0, 150.0, 200.0, 110.0]):
        other, again = run(order)
        assert np.array_equal(state, other)
        assert outputs == again


@pytest.mark.full
def test_a_slack_dropper_softens_the_wire():
    """Off its droppers the wire meets less stiffness than bilateral droppers would give it; on them nothing changes."""
    catenary = Catenary(REFERENCE, {"spans": 4})
    catenary.initialize(0.0)
    slack, bilateral = (elasticity(catenary.mesh, [150.0], 400.0, unilateral)[0] for unilateral in (True, False))
    assert slack > 1.05 * bilateral
    light = [passage(effects=e, force=5.0, spans=4)[1] for e in (REFERENCE, REFERENCE[1:])]
    assert np.array_equal(*light)  # no dropper slackens under 5 N: the effect changes no bit


NARROW = {"moving_window.behind": 180.0}


@pytest.mark.known_answers(Catenary="moving_window")
@pytest.mark.full
def test_window_follows_the_contact_and_forgets_the_rest():
    full, height = passage(spans=10, seconds=3.0)
    with pytest.warns(UserWarning, match="moving_window.behind = 180 m may cost"):
        windowed, near = passage((*REFERENCE, "moving_window"), spans=10, seconds=3.0, **NARROW)
    assert np.abs(near - height).max() < 0.02 * np.ptp(height)
    N, position = windowed.mesh.mass.size, windowed.mesh.position
    outside = np.repeat(position < 30.0 + 69.4 * 3.0 - 185.0, 2)
    for row in state_rows(windowed.x, N):
        assert not row[outside].any()
    assert np.abs(full.x[:N][outside]).max() > 1e-4  # the full model still swings there


@pytest.mark.full
@pytest.mark.parametrize(("first", "second"), [(350.0, 250.0), (250.0, 350.0)])
def test_window_spans_both_contact_points(first, second):
    """Its ends follow the foremost and the rearmost one, whichever input that is."""

    def height(effects):
        catenary = Catenary([*REFERENCE, "second_pantograph", *effects], {"spans": 12} | (NARROW if effects else {}))
        catenary.set("contact_position", first)
        catenary.set("second_pantograph.contact_position", second)
        catenary.set("contact_force", 120.0)
        catenary.set("second_pantograph.contact_force", 90.0)
        catenary.initialize(0.0)
        found = []
        for i in range(1500):
            catenary.u[:2, 0] = first + 69.4 * i * 1e-3, 69.4
            catenary.u[:2, 2] = second + 69.4 * i * 1e-3, 69.4
            catenary.step(i * 1e-3, 1e-3)
            found.append((catenary["wire_height"], catenary["second_pantograph.wire_height"]))
        return np.array(found)

    full = height([])
    with pytest.warns(UserWarning, match="moving_window"):
        windowed = height(["moving_window"])
    assert np.abs(windowed - full).max() < 0.02 * np.ptp(full)  # what the edges do not send back within 1.5 s


@pytest.mark.interpreted
def test_a_contact_point_does_not_go_back_to_where_the_window_has_left():
    """The wire there does not move any more; a little back, within the window, it may go."""
    catenary = Catenary((*REFERENCE, "moving_window"), {"spans": 4, "moving_window.behind": 20.0})
    catenary.set("contact_position", 30.0)
    catenary.initialize(0.0)
    for position in (30.0, 90.0, 75.0):
        catenary.u[:, 0] = position, 0.0, 0.0
        catenary.step(0.0, 1e-3)
    catenary.u[0, 0] = 60.0
    with pytest.raises(StepFailed, match=r"60 m .* expected from \d+\.?\d* to .* does not go back"):
        catenary.step(0.0, 1e-3)


@pytest.mark.known_answers(Catenary="wire_profile")
def test_profile_is_the_height_at_its_positions():
    catenary, _ = passage((*REFERENCE, "wire_profile"), spans=6)
    middle = catenary[f"wire_profile.height[{PROFILE // 2 + 1}]"]
    assert middle == pytest.approx(catenary["wire_height"], rel=1e-13)
    at = catenary["contact_position"]
    profile = [catenary[f"wire_profile.height[{k + 1}]"] for k in range(PROFILE)]
    for k in (0, 40, 90):
        catenary.set("contact_position", at + k - PROFILE // 2)
        catenary.refresh()
        assert profile[k] == pytest.approx(catenary["wire_height"], rel=1e-13)  # fewer numbers are divided by others


@pytest.mark.known_answers(Catenary="line_profile")
@pytest.mark.interpreted
def test_profile_of_what_the_wire_hangs_from():
    """Tensions where the droppers are, 0 above a force that lifts the wire off one, and the messenger's own displacement."""
    catenary = Catenary([*REFERENCE, "wire_profile", "line_profile"], {"spans": 3, "first_watched_support": 1, "element": 1.0})
    catenary.set("contact_position", 90.0)  # below the middle dropper of the second span
    catenary.set("contact_force", 400.0)
    catenary.initialize(0.0)
    mesh, N = catenary.mesh, catenary.mesh.mass.size
    tension = np.array([catenary[f"line_profile.dropper_tension[{k + 1}]"] for k in range(PROFILE)])
    exact = np.full(PROFILE, -1.0)
    for node, low, high, stiffness, preload in zip(
        mesh.dropper, mesh.lower, mesh.upper, mesh.dropper_stiffness, mesh.preload, strict=True
    ):
        cell = int(np.floor(mesh.position[node] - 30.0 + 0.5))
        if 0 <= cell < PROFILE:
            exact[cell] = max(preload + stiffness * (catenary.x[high] - catenary.x[low]), 0.0)
    assert tension == pytest.approx(exact, rel=1e-12)
    assert tension[PROFILE // 2] == 0.0
    assert (tension > 0.0).sum() >= 10
    uplift = [catenary[f"line_profile.messenger_uplift[{k + 1}]"] for k in range(PROFILE)]
    assert uplift == pytest.approx(np.interp(30.0 + np.arange(PROFILE), mesh.position, catenary.x[1:N:2]), abs=1e-15)


@pytest.mark.interpreted
def test_uplift_outputs_belong_to_the_watched_supports():
    catenary = Catenary(["damping"], {"spans": 4, "first_watched_support": 1, "method": "implicit"})
    catenary.set("contact_position", 120.0)
    catenary.set("contact_force", 100.0)
    catenary.initialize(0.0)
    uplift = [catenary[f"support_uplift[{k + 1}]"] for k in range(5)]
    assert np.argmax(uplift) == 1  # support 2 is at 120 m
    assert uplift[3] == 0.0  # the fixed end of the wire
    assert uplift[4] == 0.0


@pytest.mark.parametrize("line", [{"spans": 3}, {"line_table.table": "[[sections]]\nspans = [50, 60, 50]"}])
def test_supports_beyond_the_end_are_not_watched(line):
    effects = ["line_table"] if "spans" not in line else []
    Catenary(effects, line | {"first_watched_support": 3}).refuse_unused(["first_watched_support"])
    with pytest.raises(BadInput, match=r"first_watched_support = 7.*the last support of the line is number 3"):
        Catenary(effects, line | {"first_watched_support": 7}).initialize(0.0)


def test_wire_velocity_is_the_rate_of_the_height_at_a_fixed_point():
    catenary, _ = passage(spans=4)
    catenary.set("contact_position", 110.0)  # a point that swings freely
    catenary.set("contact_force", 0.0)
    catenary.refresh()
    before, rate_before, h = catenary["wire_height"], catenary["wire_velocity"], 1e-3
    catenary.step(2.0, h)
    mean = 0.5 * (rate_before + catenary["wire_velocity"])
    assert abs(mean) > 1e-3
    assert (catenary["wire_height"] - before) / h == pytest.approx(mean, rel=0.02)  # trapezoid of a wave a few steps long


@pytest.mark.first
@pytest.mark.parametrize("beta", [1e-3, 0.0])
@pytest.mark.parametrize("element", [0.25, 0.5, 1.0])
def test_stable_step_is_the_limit(element, beta):
    """At the limit the free wire decays or keeps its energy; 15 % above it blows up (the estimate errs to the safe side)."""
    effects = ["damping"] if beta else []
    values = {"spans": 2, "element": element, "substep": 1e-5, "first_watched_support": 0}
    values |= {"damping.beta": beta} if beta else {}

    def growth(factor):
        catenary = Catenary(effects, values)
        limit = catenary.stable_step()
        catenary.set("contact_force", 50.0)
        catenary.initialize(0.0)
        s, p, e = catenary.arguments
        catenary.arguments = (s, catenary.block.write(("p",), p._replace(substep=1.0)), e)  # past the check at the start
        catenary.set("contact_force", 0.0)
        start = catenary.energy()
        try:
            for _ in range(3000):
                catenary.step(0.0, factor * limit)
        except StepFailed:
            return np.inf
        with np.errstate(over="ignore"):  # what has blown up may be beyond the largest number
            return catenary.energy() / start

    assert growth(1.0) < 1.1
    assert growth(1.18) > 2.0


@pytest.mark.full
def test_slack_droppers_cost_the_implicit_method_few_factorisations():
    """Work, not seconds: one solve a step and a new factorisation only where a dropper changes state."""
    catenary, _ = passage(method="implicit", spans=6)
    work = catenary.work
    assert work["steps"] == 2000
    assert work["solves"] <= work["steps"] + 3 * work["factorizations"]
    assert work["factorizations"] < 0.05 * work["steps"]


ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of a process is read as Linux gives it")
def test_sixty_spans_fit_in_400_megabytes():
    source = """
import json, re
from cosimo.components.railway.catenary import Catenary
c = Catenary(["dropper_slackening", "gravity_sag", "damping", "wire_profile"], {"spans": 60, "first_watched_support": 30})
c.set("contact_force", 120.0)
c.initialize(0.0)
for k in range(200):
    c.step(k * 1e-3, 1e-3)
peak = re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())  # getrusage would count the parent's memory
print(json.dumps([c["wire_height"], c["static_residual"], int(peak[1]) / 1024]))
"""
    done = subprocess.run(
        [sys.executable, "-c", source], capture_output=True, text=True, check=True, cwd=ROOT, env={**os.environ}
    )
    height, residual, megabytes = json.loads(done.stdout)
    assert 0.01 < height < 0.2  # m; 120 N over 1.2 to 4.7 N/mm
    assert residual < 1e-10
    assert megabytes < 400.0
