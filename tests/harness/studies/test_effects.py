"""Effects of known size: what is measured, what is chosen and why; sets that keep the tolerance and can spare none."""

import csv
import math

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.studies.effects import effects
from cosimo.orchestrator.harness.studies.full_model import effects_on, full_model, with_effects
from cosimo.orchestrator.harness.studies.quantities import TimeHistory, errors, quantities_of
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.uncompiled

WHOLE = 1.0 + 0.5 + 0.02 + 0.008 + 0.007  # slope of the model with all that goes together


def parts(on=(), **more):
    return read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 1e-2},
            "study": {"quantities": ["part.total, end"]},
            "units": {"part": {"component": "cosimo.tests.harness.studies.parts:Parts", "effects": list(on)}},
            **more,
        }
    )


@pytest.fixture(scope="module")
def found():
    return effects(parts(["medium"]), 0.01)


def of(found, effect):
    (finding,) = (f for f in found.findings if f.effect == effect)
    return finding


@pytest.mark.parametrize(("effect", "size"), [("big", 0.5), ("medium", 0.02), ("small", 0.008), ("smaller", 0.007)])
def test_sizes_are_the_known_ones(found, effect, size):
    finding = of(found, effect)
    assert finding.status == "measured"
    assert finding.actual == pytest.approx(size / WHOLE, rel=1e-12)
    assert finding.worst == "part.total, end"
    assert finding.given == (effect == "medium")


def test_the_smallest_set_and_what_breaks_it(found):
    """Small and smaller are each below 1 %, together 0.98 % of 1.535."""
    assert {f.effect for f in found.findings if f.chosen} == {"big", "medium"}
    assert effects_on(found.chosen) == {"part": ("big", "medium")}
    dropped = 0.008 + 0.007
    assert found.least.error == pytest.approx(dropped / WHOLE, rel=1e-12)
    assert of(found, "big").breaking == pytest.approx((dropped + 0.5) / WHOLE, rel=1e-12)
    assert of(found, "medium").breaking == pytest.approx((dropped + 0.02) / WHOLE, rel=1e-12)
    assert found.given.error == pytest.approx((dropped + 0.5) / WHOLE, rel=1e-12)
    assert found.full.error == 0.0


def test_a_tighter_tolerance_keeps_the_larger_of_the_two():
    tight = effects(parts(), 0.005)
    assert {f.effect for f in tight.findings if f.chosen} == {"big", "medium", "small"}
    assert of(tight, "small").breaking > 0.005


def test_what_is_not_in_the_full_model_says_why(found):
    assert of(found, "rival").reason == "excluded by 'medium'"
    assert of(found, "port").reason == "nothing drives its inputs"
    assert of(found, "load").reason == "only where a scene asks for it"
    assert {of(found, e).status for e in ("rival", "port", "load")} == {"left out"}
    assert of(found, "broken").status == "unable"
    assert "the broken one" in of(found, "broken").reason


def test_every_effect_is_there_once_in_the_order_of_its_declaration(found):
    assert [f.effect for f in found.findings] == ["big", "medium", "small", "smaller", "needy", "rival", "port", "load", "broken"]


def test_what_a_study_asks_for_is_in_the_full_model_and_comes_first():
    model = full_model(parts(), ["part.load", "part.rival", "part.port"])
    assert {"load", "rival", "port"} <= set(model.on["part"])
    assert model.left["part", "medium"] == "excluded by 'rival'"
    named = effects(parts(study={"quantities": ["part.total, end"], "effects": ["part.load"]}), 0.01)
    assert of(named, "load").actual == pytest.approx(0.2 / (WHOLE + 0.2), rel=1e-12)


@pytest.mark.parametrize(("name", "near"), [("part.lode", "load"), ("prat.load", "part"), ("load", "part")])
def test_what_is_no_effect_is_refused(name, near):
    with pytest.raises(BadInput, match=near):
        full_model(parts(), [name])


def test_dropping_takes_along_what_cannot_be_without():
    model = full_model(parts())
    assert model.dependents(("part", "big")) == {("part", "big"), ("part", "needy")}
    assert effects_on(model.without({("part", "big"), ("part", "needy")}))["part"] == ("medium", "small", "smaller", "broken")


@pytest.mark.parametrize(
    "more",
    [
        {"record": {"signals": ["part.total", "part.needy.seen"]}},
        {"study": {"quantities": ["part.needy.seen, end", "part.total, end"]}},
    ],
)
def test_an_effect_whose_output_is_asked_for_is_required(more):
    found = effects(parts(["big", "needy"], **more), 0.9)
    for effect in ("big", "needy"):
        assert of(found, effect).status == "required"
        assert of(found, effect).chosen
        assert "needy.seen" in of(found, effect).reason


def test_numbers_of_an_effect_go_with_it_and_presets_are_taken_apart():
    scene = load_scene("en50318-2002")
    on = effects_on(scene)
    assert "dropper_slackening" in on["catenary"]
    without = with_effects(scene, on | {"catenary": tuple(e for e in on["catenary"] if e != "dropper_slackening")})
    assert effects_on(without)["catenary"] == tuple(e for e in on["catenary"] if e != "dropper_slackening")
    assert with_effects(scene, on) is scene
    bearing = load_scene("ball-bearing-clearance")
    plain = with_effects(bearing, {"bearing": ()})
    assert not [p for p in plain.units["bearing"].parameters if "." in p]
    assert plain.units["bearing"].preset == "JIS 6306"


def test_a_scene_that_does_not_run_is_refused():
    with pytest.raises(BadInput, match="comes to its end"):
        effects(parts(["broken"]), 0.01)


def test_the_table(found, tmp_path):
    with open(found.save(tmp_path), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [r["effect"] for r in rows] == [f.effect for f in found.findings]
    assert float(rows[1]["actual"]) == of(found, "medium").actual
    assert rows[0]["chosen"] == "yes"
    assert math.isnan(float(rows[-1]["actual"]))


# -- a real one: an underwater vehicle driven ahead and turned -----------------------------------------------------------------
def hull():
    return read_scene(
        {
            "title": "a vehicle that is pushed",
            "stop_time": 4.0,
            "master": {"step": 0.02},
            "study": {"quantities": ["hull.surge, end", "hull.yaw, end", "hull.depth, maximum", "hull.roll, time history"]},
            "units": {
                "hull": {
                    "component": "RovHull",
                    "effects": ["linear_drag"],
                    "parameters": {
                        "substep": 0.02,
                        "start_surge": 0.5,
                        "start_sway": 0.3,
                        "thrust[1]": 8.0,
                        "thrust[2]": 5.0,
                        "thrust[5]": 2.0,
                        **{f"linear_drag.{axis}": 0.05 for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw")},
                    },
                }
            },
        }
    )


@pytest.fixture(scope="module")
def vehicle():
    return effects(hull(), 0.05)


def outcome(scene):
    result = finished(scene)
    return TimeHistory(result.time, result.columns)


def test_the_chosen_scene_keeps_the_tolerance_and_can_spare_none(vehicle):
    """By runs of their own, from the scenes as they would be written."""
    scene, quantities = hull(), quantities_of(hull())
    full = full_model(scene)
    reference = outcome(full.scene)
    assert set(full.on["hull"]) == {"added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring"}
    assert max(errors(quantities, outcome(vehicle.chosen), reference).values()) == vehicle.least.error <= 0.05
    chosen = effects_on(vehicle.chosen)["hull"]
    assert 0 < len(chosen) < 5
    for effect in chosen:
        fewer = with_effects(vehicle.chosen, {"hull": tuple(e for e in chosen if e != effect)})
        error = max(errors(quantities, outcome(fewer), reference).values())
        assert error > 0.05
        assert error == of(vehicle, effect).breaking


def test_drag_has_no_states_and_no_calls_of_its_own(vehicle):
    assert of(vehicle, "linear_drag").states == 0
    assert of(vehicle, "linear_drag").calls == 0


def test_friction_that_sticks_has_states_and_is_one_of_three():
    scene = read_scene(
        {
            "stop_time": 2.0,
            "master": {"step": 5e-3},
            "study": {"quantities": ["body.outer_angle, time history", "body.outer_rate, time history"]},
            "units": {
                "body": {
                    "component": "GimbalBody",
                    "effects": ["gravity", "stick_friction"],
                    "parameters": {"axis_orientation": "horizontal", "start_outer_angle": 0.5, "substep": 5e-3},
                }
            },
        }
    )
    found = effects(scene, 0.02)
    assert of(found, "smoothed_friction").reason == of(found, "lugre_friction").reason == "excluded by 'stick_friction'"
    assert of(found, "stick_friction").states == 2
    assert of(found, "stick_friction").chosen
    assert of(found, "gravity").chosen
    assert of(found, "stops").actual == 0.0  # never reached
    assert not of(found, "stops").chosen
