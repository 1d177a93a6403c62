"""What a dotted name means: the same in changes, on the command line, in plans and in sessions."""

import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.components.core.variables import parameter
from cosimo.orchestrator.cli.common import changes_of
from cosimo.orchestrator.scene.names import Place, measure_of, place_of, variable_of
from cosimo.orchestrator.session.session import Session
from cosimo.tests.support import Probe

RAILWAY = load_scene("en50318-2002")
TRAVEL = "cosimo.tests.scene.test_names:Travel"
BOTH = {"a": {"component": "Pantograph", "effects": ["bump_stops"]}, "a.bump_stops": {"component": TRAVEL}}


class Travel(Probe):
    """A unit with the name of an effect of the unit before it."""

    travel = parameter(0.1, "m", "of the same name as that of the effect")


NESTED = read_scene({"stop_time": 1.0, "units": BOTH, "master": {"step": 0.1}}, "nested")


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("stop_time", Place(("stop_time",))),
        ("master.step", Place(("master", "step"))),
        ("master.control.relative", Place(("master", "control", "relative"))),
        ("analysis.transient", Place(("analysis", "transient"))),
        ("pantograph.static_force", Place(("units", "pantograph", "parameters", "static_force"), "pantograph", "static_force")),
        ("catenary.damping.alpha", Place(("units", "catenary", "parameters", "damping.alpha"), "catenary", "damping.alpha")),
        ("catenary.effects.steady_arm", Place(("units", "catenary", "effects"), "catenary", effect="steady_arm")),
        ("units.catenary.preset", Place(("units", "catenary", "preset"), "catenary")),
        ("units.catenary", Place(("units", "catenary"), "catenary")),
    ],
)
def test_a_name_has_one_place(name, place):
    assert place_of(RAILWAY, name) == place


def test_the_place_in_the_file_is_a_name_too():
    assert place_of(RAILWAY, "units.pantograph.parameters.speed") == place_of(RAILWAY, "pantograph.speed")
    assert RAILWAY.with_changes({"units.pantograph.parameters.speed": 50.0}) == RAILWAY.with_changes({"pantograph.speed": 50.0})


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("pantograf.speed", "'pantograph'"),
        ("mastr.step", "'master'"),
        ("pantograph", "unit.parameter"),
        ("units.pantograph.presett", "'preset'"),
        ("units.pantograph.preset.a", "a setting of the unit"),
        ("catenary.effects.steady_arn", "'steady_arm'"),
    ],
)
def test_a_name_that_is_none_is_one_message(name, named):
    with pytest.raises(BadInput, match=named):
        place_of(RAILWAY, name)


def test_an_effect_is_switched_by_its_name_everywhere():
    off = RAILWAY.with_changes(changes_of(RAILWAY, ["catenary.effects.dropper_slackening=false"], None))
    assert "dropper_slackening" not in off.units["catenary"].effects
    assert (
        off.with_changes({"catenary.effects.dropper_slackening": True})
        .coupling.interfaces["catenary"]
        .effects["dropper_slackening"]
    )
    for value in (0, "no"):
        with pytest.raises(BadInput, match="true or false"):
            RAILWAY.with_changes({"catenary.effects.dropper_slackening": value})


def test_an_effect_that_goes_takes_its_numbers_with_it():
    scene = RAILWAY.with_changes({"pantograph.effects.bump_stops": True, "pantograph.bump_stops.travel": 0.04})
    gone = scene.with_changes({"pantograph.effects.bump_stops": False})
    assert gone.units["pantograph"] == RAILWAY.units["pantograph"]


def test_an_effect_that_comes_takes_the_place_of_the_scenes_numbers():
    """Of those that it replaces, with their tolerances; one that is given beside it is refused."""
    pump = {
        "component": "CentrifugalPump",
        "parameters": {"best_flow": 1.3e-3, "density": 998.0},
        "tolerances": {"best_flow": "1 %"},
    }
    scene = read_scene({"units": {"pump": pump}, "stop_time": 1.0, "master": {"step": 0.1}})
    changed = scene.with_changes({"pump.effects.curve_table": True})
    assert changed.units["pump"].parameters == {"density": 998.0}
    assert not changed.units["pump"].tolerances
    with pytest.raises(BadInput, match="the effect 'curve_table' takes its place"):
        scene.with_changes({"pump.effects.curve_table": True, "pump.best_flow": 1e-3})


def test_an_effect_of_a_preset_stays():
    scene = load_scene("damped-chain")
    unit, effect = next(
        (name, e) for name, i in scene.coupling.interfaces.items() for e, why in i.effects.items() if why.startswith("preset")
    )
    with pytest.raises(BadInput, match="part of preset"):
        scene.with_changes({f"{unit}.effects.{effect}": False})


def test_a_component_takes_the_place_of_another():
    other = NESTED.with_changes({"units.a.bump_stops.component": "cosimo.tests.support:Probe"})
    assert (other.units["a.bump_stops"].component, other.units["a.bump_stops"].fmu) == ("cosimo.tests.support:Probe", "")


def test_a_name_that_two_units_have_is_refused():
    for ask in (lambda: place_of(NESTED, "a.bump_stops.travel"), lambda: variable_of(NESTED, "a.bump_stops.travel", "here")):
        with pytest.raises(
            BadInput, match=r"'units\.a\.parameters\.bump_stops\.travel' or 'units\.a\.bump_stops\.parameters\.travel'"
        ):
            ask()
    inner = place_of(NESTED, "units.a.bump_stops.parameters.travel")
    outer = place_of(NESTED, "units.a.parameters.bump_stops.travel")
    assert [(p.unit, p.parameter) for p in (inner, outer)] == [("a.bump_stops", "travel"), ("a", "bump_stops.travel")]
    assert place_of(NESTED, "a.bump_stops.length").unit == "a.bump_stops"


def test_units_of_measure_of_names():
    assert [measure_of(RAILWAY, n) for n in ("stop_time", "pantograph.speed", "pantograph.effects.bump_stops")] == [
        "s",
        "m/s",
        "",
    ]


def test_a_session_takes_the_names_of_a_change():
    with Session(RAILWAY) as sim:
        sim["pantograph.static_force"] = "130 N"
        assert sim.scene.with_changes({}) == RAILWAY.with_changes({"pantograph.static_force": 130.0})
        with pytest.raises(BadInput, match="'pantograph'"):
            sim["pantograf.static_force"]


def test_a_scene_is_loaded_with_changes_by_their_names():
    changes = {"stop_time": 0.5, "spring.stiffness": 50.0, "units.mass.every": 2}
    assert load_scene("mass-on-spring", changes) == load_scene("mass-on-spring").with_changes(changes)
    alone = {"stop_time": 0.5, "planar_link.mass": 2.0}
    assert load_scene("PlanarLink", alone) == load_scene("PlanarLink").with_changes(alone)


def test_a_component_takes_the_place_of_a_table():
    scene = load_scene("wind-pump-record")
    for changes in ({"units.wind.component": "Wind", "units.wind.parameters": {}}, {"units.wind": {"component": "Wind"}}):
        wind = scene.with_changes(changes).units["wind"]
        assert (wind.component, wind.signals, wind.interpolation) == ("Wind", "", None)
