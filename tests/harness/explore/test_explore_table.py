"""The table [explore] of a scene: what it offers in a page, in which units of measure, and what is refused."""

import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.orchestrator.harness.explore import content
from cosimo.orchestrator.harness.explore.modules import MOST_EFFECTS, algorithms, switches, without
from cosimo.orchestrator.scene.scene import scene_text
from cosimo.orchestrator.scene_fmu import scene_block
from cosimo.tests.fmus.native.web_assembly import needs_node


def scene(**table):
    return read_scene(load_scene("mass-on-spring").settings() | {"explore": table}, "mass-on-spring")


@pytest.fixture
def no_modules(monkeypatch):
    """Without the compiler's time: one library for all variants."""
    from cosimo.orchestrator.harness.explore import modules

    compiled = modules.scene_library(load_scene("mass-on-spring"), ["wasm32"], ("live.c",))
    monkeypatch.setattr(modules, "scene_library", lambda *given: compiled)
    monkeypatch.setattr(modules, "tangent_module", lambda *given: (b"", {}))


@needs_node
def test_a_page_offers_what_the_table_says(no_modules):
    offered = content.content_of(
        scene(
            parameters={"spring": {"stiffness": {"from": "0.05 N/mm", "to": 800}, "damping": {}}},
            algorithms=["jacobi"],
            presets={"stiff": {"spring.stiffness": "0.4 N/mm", "master.extrapolation": 0, "master.algorithm": "jacobi"}},
        ),
        None,
    ).data
    assert offered["first"] == ["spring.stiffness", "spring.damping"]
    ranges = {p["name"]: (p["from"], p["to"]) for p in offered["parameters"]}
    assert ranges["spring.stiffness"] == pytest.approx((50.0, 800.0))
    assert ranges["spring.damping"] == (2.0, 6.0)
    assert offered["algorithms"] == ["gauss-seidel", "jacobi"]
    (preset,) = offered["presets"]
    assert preset == {
        "name": "stiff",
        "values": {"spring.stiffness": pytest.approx(400.0)},
        "extrapolation": 0,
        "algorithm": "jacobi",
    }
    assert "explore" not in offered["settings"]
    with pytest.raises(BadInput, match=r"mass-on-spring: explore.presets.p.*Did you mean 'mass.mass'"):
        content.content_of(scene(presets={"p": {"mass.mas": 1.0}}), None, parameters={})
    for table, words in (
        ({"parameters": {"mass.mass": {"from": 0.5, "to": "2 m"}}}, "explore.parameters.mass.mass.*2 m"),
        ({"parameters": {"mass.mass": {"from": -1.0, "to": 2.0}}}, "explore.parameters.mass.mass.*-1.0"),
        ({"parameters": {}, "presets": {"p": {"master.step": 3e-3}}}, "explore.presets.p.master.step.*one that the page offers"),
        ({"parameters": {}, "presets": {"p": {"mass.effects.pinned": False}}}, "an effect that the page offers"),
        ({"parameters": {}, "algorithms": ["iterative"]}, "no iterations"),
        ({"parameters": {}, "effects": ["mass.pinned"]}, "an effect that is on"),
    ):
        with pytest.raises(BadInput, match=words):
            content.content_of(scene(**table), None)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"parameters": {"mass.mass": [0.5, 2.0]}}, "from = least value, to = largest value"),
        ({"parameters": {"mass.mass": {"from": 0.5}}}, "from = least value, to = largest value"),
        ({"algorithms": ["gauss"]}, "algorithms"),
        ({"sliders": {}}, "sliders"),
    ],
)
def test_what_no_table_says(table, words):
    with pytest.raises(BadInput, match=words):
        scene(**table)


def test_a_scene_is_written_with_its_table():
    import tomllib

    shipped = load_scene("en50318-2002")
    again = read_scene(tomllib.loads(scene_text(shipped.settings())), "again")
    assert again.explore == shipped.explore
    assert again.explore.parameters["pantograph.speed"] == {"from": "240 km/h", "to": "330 km/h"}


def test_the_other_algorithm_is_offered_where_few_modules_become_of_it():
    coupled, alone = load_scene("mass-on-spring"), load_scene("ball-bearing-clearance")
    assert algorithms(coupled, None, 2) == ["gauss-seidel", "jacobi"]
    assert algorithms(coupled, None, 4) == ["gauss-seidel"]
    assert algorithms(alone, None, 1) == [alone.master.algorithm]


def test_degrees_of_extrapolation_are_numbers_of_the_block():
    coupled = load_scene("mass-on-spring")
    blocks = [scene_block(coupled.with_changes({"master.extrapolation": degree})) for degree in (0, 1, 2)]
    assert len({block.code for block in blocks}) == 1
    assert len({block.image.tobytes() for block in blocks}) == 3


@pytest.mark.full
def test_effects_without_which_the_scene_runs_become_switches():
    bearing = load_scene("ball-bearing-clearance").with_changes({"stop_time": 0.02, "analysis.transient": 0.0})
    said = []
    assert switches(bearing, None, said.append) == ["bearing.clearance"]
    assert said == ["running the scene without bearing.clearance"]
    assert bearing.with_changes(without(bearing, ["bearing.clearance"])).units["bearing"].effects == ()
    with pytest.raises(BadInput, match=f"at most {MOST_EFFECTS}"):
        switches(
            load_scene("en50318-2002"), [f"catenary.{e}" for e in load_scene("en50318-2002").units["catenary"].effects], print
        )
