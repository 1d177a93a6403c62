"""The moving window is as wide as damping and speed ask for, against the whole line; a narrower one says what it costs."""

import warnings

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.moving_window import AHEAD, ENOUGH, echo, width
from cosimo.orchestrator.harness.analysis.signals import Filter
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.short_run import covering, shipped_scenes

PLAIN = {"record.signals": None, "record.interval": None, "record.snapshots": [], "record.snapshot_interval": None}
LONG = {"catenary.spans": 30, "stop_time": 23.0, "analysis": {}}


def windowed(scene, **window):
    """The scene with a moving window in its catenary; None where it has no line of droppers that is stepped explicitly."""
    name, unit = next(((n, u) for n, u in scene.units.items() if u.component == "Catenary"), (None, None))
    if name is None or unit.parameters.get("method") == "implicit":
        return None
    return scene.with_changes(
        {
            f"units.{name}.effects": [*unit.effects, "moving_window"],
            **{f"{name}.moving_window.{key}": value for key, value in window.items()},
        }
    )


def slowest(scene):
    vehicles = [u.parameters for u in scene.units.values() if "Pantograph" in (u.component or "")]
    return min((p["speed"] for p in vehicles if "speed" in p), default=250.0 / 3.6)


def error(scene, other):
    """Of the 20 Hz-filtered contact forces behind the first two fifths, rms over the deviation; the worst of them."""
    whole, near = (run(s.with_changes(PLAIN), in_process=True) for s in (scene, other))
    assert (whole.outcome, near.outcome) == ("done", "done")
    kept, rate = whole.time > 0.4 * whole.end, 1.0 / whole.time[1]
    errors = []
    for name in (n for n in whole.columns if n.endswith("contact_force") and "catenary" not in n):
        x, y = (Filter().apply(result[name], rate)[kept] for result in (whole, near))
        if x.std() > 0.0:
            errors.append(float(np.sqrt(np.mean((x - y) ** 2)) / x.std()))
    return max(errors), near


def lines() -> tuple[str, ...]:
    """Scenes with a line whose waves a window cuts, which together have every effect of such lines."""
    railway = {name: scene for name, scene in shipped_scenes().items() if scene_files()[name].parent.parent.name == "railway"}
    cut = {name: scene for name, scene in railway.items() if windowed(scene)}
    return covering(cut, lambda scene: {e for u in scene.units.values() if u.component == "Catenary" for e in u.effects})


@pytest.mark.full
@pytest.mark.parametrize("name", lines())
def test_the_chosen_width_keeps_the_force_in_scenes_with_every_effect(name):
    scene = load_scene(name)
    cut = windowed(scene, speed=slowest(scene))
    found, near = error(scene, cut)
    assert found <= ENOUGH
    assert not [w for w in near.info.warnings if "moving_window" in w]


@pytest.mark.full
@pytest.mark.parametrize("speed", [200.0 / 3.6, 250.0 / 3.6])
def test_the_chosen_width_keeps_the_force_on_a_long_line(speed):
    """1.8 km for 23 s: a wave that leaves the window has the time to come back."""
    scene = load_scene("en50318-2002").with_changes(LONG | {"pantograph.speed": speed})
    found, near = error(scene, windowed(scene, speed=speed))
    assert found <= ENOUGH
    wires = near.scene.units["catenary"]
    catenary = Catenary(wires.effects, wires.parameters)
    catenary.initialize(0.0)
    assert 300.0 < catenary.arguments[0].window[AHEAD] < 700.0  # of 1800 m


@pytest.mark.full
def test_a_narrow_window_costs_what_it_says_and_says_so():
    scene = load_scene("en50318-2002").with_changes(LONG)
    found, near = error(scene, windowed(scene, ahead=120.0, behind=120.0))
    (said,) = [w for w in near.info.warnings if "moving_window.ahead" in w]
    assert found > ENOUGH
    assert "0.5 % takes 37" in said
    shown = float(said.split("may cost ")[1].split(" %")[0]) / 100.0
    assert found < shown < 6.0 * found


def test_the_width_grows_with_less_damping_and_at_lower_speed():
    line = {"wave": 121.7, "span": 60.0, "alpha": 0.0, "beta": 1e-3, "speed": 69.4}
    wide = width(**line)
    assert echo(wide, **line) == pytest.approx(ENOUGH)
    assert width(**line | {"beta": 1e-4}) == pytest.approx(10.0 * wide)
    assert width(**line | {"speed": 50.0}) > wide
    assert width(**line | {"beta": 0.0}) == np.inf
    assert width(**line | {"speed": 130.0}) == 60.0


def test_without_damping_the_window_is_the_whole_line_and_a_given_one_warns():
    effects = ("dropper_slackening", "gravity_sag", "moving_window")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        whole = Catenary(effects, {"spans": 4})
        whole.initialize(0.0)
    assert whole.arguments[0].window[AHEAD] == pytest.approx(240.0)
    with pytest.warns(UserWarning, match=r"moving_window.behind = 100 m may cost 50 % .* takes the whole line"):
        Catenary(effects, {"spans": 4, "moving_window.behind": 100.0}).initialize(0.0)
