"""A scene without [record] records what its figures are judged by: made at random, against the same with everything recorded."""

import random

import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.orchestrator.run.run import run
from cosimo.tests.scene_runs import finished

SECOND, FURTHER = "second_pantograph.", "further_pantographs."


def contact(name, place, index):
    """Connections of a pantograph at the place (a prefix) and index ("" or [k]) of the catenary's contact points."""
    return [
        f"catenary.{place}wire_height{index} -> {name}.wire_height",
        f"catenary.{place}contact_compliance{index} -> {name}.wire_compliance",
        f"{name}.contact_force -> catenary.{place}contact_force{index}",
        f"{name}.contact_position -> catenary.{place}contact_position{index}",
    ]


def made_up(seed):
    """A line with an overlap, where there are two contact wires, or a uniform one, one to three pantographs; no [record]."""
    chance = random.Random(seed)
    count, both = chance.randint(1, 3), chance.random() < 0.7
    line = load_scene("overlap").units["catenary"]
    effects = ["dropper_slackening", "gravity_sag", "damping", *(["line_table", "second_wire"] if both else [])]
    effects += ["second_pantograph"] if count > 1 else []
    effects += ["further_pantographs"] if count > 2 else []
    parameters = {"substep": 2.5e-4, "first_watched_support": 4}
    if both:  # the table has an overlap
        parameters["line_table.table"] = line.parameters["line_table.table"]
    else:
        parameters["spans"] = 8
    units = {"catenary": {"component": "Catenary", "effects": effects, "parameters": parameters}}
    connections, speed = [], chance.uniform(40.0, 75.0)
    begin = 180.0
    for k, (name, place, index) in enumerate((("first", "", ""), ("second", SECOND, ""), ("third", FURTHER, "[1]"))[:count]):
        units[name] = {
            "component": "Pantograph",
            "preset": "EN 50318:2018",
            "effects": ["contact_loss"] + ["second_wire"] * both,
            "parameters": {"speed": speed, "start_position": begin - 30.0 * k, "static_force": chance.uniform(120.0, 160.0)},
        }
        connections += contact(name, place, index)
        if both:
            connections += [
                f"catenary.second_wire.wire_height[{k + 1}] -> {name}.second_wire.wire_height",
                f"catenary.second_wire.contact_compliance[{k + 1}] -> {name}.second_wire.wire_compliance",
                f"{name}.second_wire.contact_force -> catenary.second_wire.contact_force[{k + 1}]",
            ]
    return (
        read_scene(
            {
                "stop_time": round(125.0 / speed, 3),
                "units": units,
                "connections": connections,
                "master": {"algorithm": "gauss-seidel", "step": 1e-3, "extrapolation": 1},
                "analysis": {"system": "railway", "window": [begin + 20.0, begin + 50.0]},
            }
        ),
        count,
        both,
    )


# One to three pantographs on one contact wire or two, each but one pantograph on one wire.
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.full) for seed in (1, 5, 6, 9))])
def test_a_scene_of_ones_own_is_judged_by_the_whole_force(seed):
    scene, count, both = made_up(seed)
    plain = finished(scene)
    every = [f"{unit}.{name}" for unit, interface in scene.coupling.interfaces.items() for name in interface.outputs]
    whole = run(scene.with_changes({"record.signals": every}), in_process=True)
    ours, theirs = ({row.name: row.value for row in result.summary} for result in (plain, whole))
    assert ours == pytest.approx(theirs, nan_ok=True)
    ends = ".both_wires" if both else ""
    assert {name.rpartition(".")[0] for name in ours if name.endswith(".uplift_mm")} >= {"first" + ends}
    headlines = [name for name in ours if name.endswith(f"{ends}.mean") and name.count(".") == 1 + both]
    assert len(headlines) == count
    assert next(iter(ours)) == f"first{ends}.mean"
    for unit in ("first", "second", "third")[:count]:
        force = plain[f"{unit}.contact_force"] + (plain[f"{unit}.second_wire.contact_force"] if both else 0.0)
        position = plain[f"{unit}.contact_position"]
        kept = (position >= 200.0) & (position <= 230.0)
        if kept.any():
            assert ours[f"{unit}{ends}.mean"] == pytest.approx(force[kept].mean(), rel=0.1)


@pytest.mark.full
def test_half_a_collector_is_not_judged():
    scene = load_scene("overlap").with_changes(
        {
            "stop_time": 0.01,
            "record.snapshots": [],
            "record.snapshot_interval": None,
            "analysis.spans": [2, 3],
            "record.signals": [
                "pantograph.contact_force",
                "pantograph.contact_position",
                "pantograph.second_wire.contact_force",
                "catenary.wire_height",
            ],
        }
    )
    with pytest.raises(BadInput, match=r"no catenary.second_wire.wire_height\[1\].* judged as a whole"):
        _ = run(scene, in_process=True).summary
