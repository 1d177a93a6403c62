"""What of the line moves, against the whole line: a front by a threshold, a rear by a length; a shorter one says what it costs."""

import warnings

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.moving_window import BEHIND, ENOUGH, FASTEST_NODE, LARGEST, echo, width
from cosimo.components.railway.wires import state_rows
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.scene.shorter_steps import shorter
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.records import passages
from cosimo.tests.short_run import covering, shipped_scenes

PLAIN = {"record.signals": None, "record.interval": None, "record.snapshots": [], "record.snapshot_interval": None}
LONG = {"catenary.spans": 30, "stop_time": 23.0, "analysis": {}}
FRONT = 1e-4  # error of the force for the threshold as it is declared, which changes it in proportion


def of_line(scene, effects=(), **parameters):
    """The scene with more effects and other parameters of its catenary; None where no part of a line may move."""
    name, unit = next(((n, u) for n, u in scene.units.items() if u.component == "Catenary"), (None, None))
    if name is None or unit.parameters.get("method") == "implicit" or "scatter" in unit.effects:  # slack droppers, see `Scatter`
        return None
    changes = {f"{name}.{key.replace('__', '.')}": value for key, value in parameters.items()}
    return scene.with_changes({f"units.{name}.effects": [*unit.effects, *effects], **changes})


def error(scene, other):
    """Of the 20 Hz-filtered contact forces behind the first two fifths, rms over the deviation; the worst of them."""
    whole, near = (run(s.with_changes(PLAIN), in_process=True) for s in (scene, other))
    assert (whole.outcome, near.outcome) == ("done", "done")
    kept, rate = whole.time > 0.4 * whole.end, 1.0 / whole.time[1]
    errors = []
    for name in (n for n in whole.columns if n.endswith("contact_force") and "catenary" not in n):
        x, y = (ButterworthFilter().apply(result[name], rate)[kept] for result in (whole, near))
        if x.std() > 0.0:
            errors.append(float(np.sqrt(np.mean((x - y) ** 2)) / x.std()))
    return max(errors), near


def lines() -> tuple[str, ...]:
    """Scenes with a line of which a part moves, which together have every effect of such lines."""
    railway = {name: scene for name, scene in shipped_scenes().items() if scene_files()[name].parent.parent.name == "railway"}
    cut = {name: scene for name, scene in railway.items() if of_line(scene)}
    return covering(cut, lambda scene: {e for u in scene.units.values() if u.component == "Catenary" for e in u.effects})


@pytest.mark.full
@pytest.mark.parametrize("name", lines())
def test_front_and_rear_keep_the_force_in_scenes_with_every_effect(name):
    scene = load_scene(name)
    whole = of_line(scene, front_threshold=0.0)
    assert error(whole, scene)[0] <= 2.0 * FRONT
    found, near = error(whole, of_line(scene, ["moving_window"]))
    assert found <= ENOUGH
    assert not [w for w in near.info.warnings if "moving_window" in w]


def test_the_front_costs_in_proportion_to_its_threshold_and_the_verification_sees_it():
    scene = load_scene("en50318-2002").with_changes({"stop_time": 3.0, "analysis": {}})
    whole = of_line(scene, front_threshold=0.0)
    errors = [error(whole, of_line(scene, front_threshold=threshold))[0] for threshold in (1e-2, 1e-3, 1e-4)]
    assert errors[2] < FRONT
    assert errors[2] < 0.3 * errors[1] < 0.09 * errors[0]
    assert shorter(scene, 2)["catenary.front_threshold"] == 0.5e-4  # of the run by which errors are found


@pytest.mark.parametrize("effects", [(), ("second_pantograph",)])
def test_nothing_ahead_of_the_front_would_move_by_more_than_the_threshold(effects):
    """Against the whole line, which moves there by less; a contact point that jumps ahead finds a wire that moves."""
    made = [Catenary([*effects, "damping", "dropper_slackening"], {"spans": 20, "front_threshold": t}) for t in (0.0, 1e-3)]
    for catenary in made:
        catenary.set("contact_position", 30.0)
        catenary.initialize(0.0)
        catenary.set("contact_force", 150.0)
    (whole, part), N = made, made[0].mesh.mass.size
    for i in range(1000):
        for catenary in made:
            catenary.u[:2, 0] = 30.0 + 60.0 * i * 1e-3 + (300.0 if i >= 800 else 0.0), 60.0
            catenary.step(i * 1e-3, 1e-3)
        last = int(part.x[-1])
        if i % 100 == 0:
            q, w, _ = state_rows(whole.x, N)
            ahead = slice(2 * last + 2, None)
            assert np.abs(q[ahead]).max() < 2e-3 * LARGEST
            assert np.abs(w[ahead]).max() < 2e-3 * FASTEST_NODE
    assert whole["wire_height"] == pytest.approx(part["wire_height"], abs=1e-3 * LARGEST)
    assert 330.0 + 60.0 < part.mesh.position[last] < 600.0


def test_equilibrium_beyond_the_front_is_kept_to_rounding():
    catenary = Catenary(["damping", "gravity_sag"], {"spans": 10, "front_threshold": 1e-2})
    catenary.set("contact_position", 100.0)
    catenary.set("contact_force", 120.0)
    catenary.initialize(0.0)
    start = catenary.x[: catenary.mesh.mass.size].copy()
    assert catenary.mesh.position[int(catenary.x[-1])] < 300.0
    for i in range(500):
        catenary.step(i * 1e-3, 1e-3)
    assert np.abs(catenary.x[: start.size] - start).max() < 1e-12


@pytest.mark.full
@pytest.mark.parametrize("speed", [200.0 / 3.6, 250.0 / 3.6])
def test_the_chosen_length_keeps_the_force_on_a_long_line(speed):
    """1.8 km for 23 s: a wave that leaves the rear has the time to come back."""
    scene = load_scene("en50318-2002").with_changes(LONG | {"pantograph.speed": speed})
    found, near = error(of_line(scene, front_threshold=0.0), of_line(scene, ["moving_window"]))
    assert found <= ENOUGH
    rear = near["catenary.moving_window.rear"]
    behind = near["pantograph.contact_position"][-1] - rear[-1]
    assert 300.0 < behind < 700.0  # of 1800 m
    assert (np.diff(rear) >= 0.0).all()


@pytest.mark.full
def test_a_short_length_costs_what_it_says_and_says_so():
    scene = load_scene("en50318-2002").with_changes(LONG)
    found, near = error(of_line(scene, front_threshold=0.0), of_line(scene, ["moving_window"], moving_window__behind=120.0))
    (said,) = [w for w in near.info.warnings if "moving_window.behind" in w]
    assert found > ENOUGH
    assert "0.5 % takes 37" in said
    shown = float(said.split("may cost ")[1].split(" %")[0]) / 100.0
    assert found < shown < 6.0 * found


def test_a_support_behind_the_rear_is_not_followed():
    """Its uplift ends where it is left behind, in statistics and picture, instead of being 0 for the rest of the run."""
    scene = load_scene("en50318-2002").with_changes({"stop_time": 5.0})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = run(of_line(scene, ["moving_window"], moving_window__behind=60.0, first_watched_support=2), in_process=True)
    whole = run(of_line(scene, first_watched_support=2), in_process=True)
    ours, theirs = (passages(r)[0] for r in (result, whole))
    rear = result["catenary.moving_window.rear"]
    left = [x for x in ours.supports if x < rear[-1]]
    assert len(left) >= 2
    for x, uplift, full in zip(ours.supports, ours.record.uplifts, theirs.record.uplifts, strict=True):
        np.testing.assert_array_equal(np.isnan(uplift), rear > x)
        assert np.nanmax(uplift) == pytest.approx(full.max(), rel=0.05)
    statistics = ours.record.statistics((240.0, 360.0))
    assert np.isfinite(statistics.uplift).all()


def test_the_length_grows_with_less_damping_and_at_lower_speed():
    line = {"wave": 121.7, "span": 60.0, "alpha": 0.0, "beta": 1e-3, "speed": 69.4}
    wide = width(**line)
    assert echo(wide, **line) == pytest.approx(ENOUGH)
    assert width(**line | {"beta": 1e-4}) == pytest.approx(10.0 * wide)
    assert width(**line | {"speed": 50.0}) > wide
    assert width(**line | {"beta": 0.0}) == np.inf
    assert width(**line | {"speed": 130.0}) == 60.0


def test_the_length_follows_the_speed_of_the_slowest_contact_point():
    effects = ("dropper_slackening", "gravity_sag", "damping", "second_pantograph", "moving_window")
    catenary = Catenary(effects, {"spans": 12})
    catenary.set("second_pantograph.contact_position", 90.0)
    catenary.initialize(0.0)
    for i in range(3):
        catenary.u[:2, 0] = 30.0 + 70.0 * i * 1e-3, 70.0
        catenary.u[:2, 2] = 90.0 + 50.0 * i * 1e-3, 50.0
        catenary.step(i * 1e-3, 1e-3)
    wave, span = np.sqrt(16e3 / 1.07), 60.0
    assert catenary.arguments[0].window[BEHIND] == pytest.approx(width(wave, span, 0.0, 1e-3, 50.0), rel=1e-6)
    catenary.u[1] = 0.0
    for i in range(2):  # it stands: no damping is certain, all moves
        catenary.step(i * 1e-3, 1e-3)
    assert catenary.arguments[0].window[BEHIND] == np.inf


def test_without_damping_all_behind_moves_and_a_given_length_warns():
    effects = ("dropper_slackening", "gravity_sag", "moving_window")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Catenary(effects, {"spans": 4}).initialize(0.0)
    with pytest.warns(UserWarning, match=r"moving_window.behind = 100 m may cost 50 % .* takes the whole line"):
        Catenary(effects, {"spans": 4, "moving_window.behind": 100.0}).initialize(0.0)


@pytest.mark.parametrize(("name", "remedy"), [("ahead", "front_threshold"), ("speed", "follows the speed of the run")])
def test_keys_of_earlier_versions_are_refused_with_what_takes_their_place(name, remedy):
    with pytest.raises(BadInput, match=rf"moving_window.{name}.*Leave it out: .*{remedy}"):
        Catenary(("moving_window",), {f"moving_window.{name}": 100.0})
