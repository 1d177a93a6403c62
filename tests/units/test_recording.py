"""What of an FMU is recorded: scalars and arrays by default, locals by name; a result has a column or is refused."""

import csv

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.engine.coupling.resolve import LONGEST_RECORDED
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import read_scene
from cosimo.tests.scene_runs import finished
from cosimo.tests.units.native import STATE, native_fmu

LOCAL = ('causality="output"', 'causality="local"')


def scene(fmu: str, record: dict | None = None, **more) -> dict:
    return {"stop_time": 1.0, "units": {"f": {"fmu": fmu, **more}}, "master": {"step": 0.1}, "record": record or {}}


def test_arrays_of_fmi_3_are_recorded_as_their_elements():
    result = run(read_scene(scene(native_fmu("state_space", 3))))
    assert list(result.columns) == ["f.y[1]", "f.y[2]", "f.y[3]"]
    np.testing.assert_allclose(result["f.y[2]"], 2.0 * np.exp(result.time), rtol=1e-12)  # x' = x + u, y = x + u from x = 0


def test_long_arrays_are_recorded_in_part_where_there_is_nothing_else():
    """200 outputs that the description gives in the place of three: nothing is run, only resolved."""
    fmu = native_fmu(
        "state_space",
        3,
        "",
        (
            'name="y" valueReference="10" causality="output" variability="continuous" ><Dimension valueReference="3"/>',
            'name="y" valueReference="10" causality="output" variability="continuous" ><Dimension start="200"/>',
        ),
    )
    assert len(read_scene(scene(fmu)).coupling.signals) == LONGEST_RECORDED
    assert len(read_scene(scene(fmu, {"signals": ["f.y"]})).coupling.signals) == 200


@pytest.mark.parametrize("fmi", [2, 3])
def test_locals_are_recorded_by_name(fmi):
    outputs = run(read_scene(scene(native_fmu("van_der_pol", fmi))))
    locals_ = run(read_scene(scene(native_fmu("van_der_pol", fmi, "", LOCAL), {"signals": ["f.x1", "f.x0"]})))
    assert list(locals_.columns) == ["f.x1", "f.x0"]
    for name in ("f.x0", "f.x1"):
        assert locals_[name].tobytes() == outputs[name].tobytes()


@pytest.mark.parametrize("isolation", ["none", "process"])
def test_a_result_without_a_column_is_refused_with_what_can_be_recorded(isolation):
    fmu = native_fmu("van_der_pol", 2, "", LOCAL)
    with pytest.raises(
        BadInput, match=r"scene: record\.signals: got no unit with an output.*recorded by its name: f\.x0, f\.x1\."
    ):
        read_scene(scene(fmu, isolation=isolation))


def test_locals_are_no_ends_of_connections():
    data = scene(native_fmu("van_der_pol", 2, "", LOCAL), {"signals": ["f.x0"]})
    data["units"]["g"] = {"fmu": native_fmu("feedthrough", 2)}
    with pytest.raises(BadInput, match=r"f\.x0, expected an output of f"):
        read_scene({**data, "connections": ["f.x0 -> g.Float64_continuous_input"]})


SAID = 'Grüße, "世界"\nand more'


def speaking(isolation: str = "none", **more) -> dict:
    """A text that goes from one unit to another, at the start of each step, and what comes out there."""
    said = {"fmu": native_fmu("feedthrough", 3, STATE[3]), "parameters": {"String_in": SAID}, "isolation": isolation}
    return {
        "stop_time": 1.0,
        "units": {"a": said, "b": {"fmu": native_fmu("feedthrough", 2, STATE[2])}},
        "connections": ["a.String_out -> b.String_in"],
        "master": {"step": 0.1},
        "record": {"signals": ["b.String_out", "a.Boolean_out", "a.String_out", "b.Enumeration_out"], **more},
    }


@pytest.mark.parametrize("isolation", ["none", "process"])
def test_texts_truth_values_and_enumerations_are_recorded_where_asked(isolation, tmp_path):
    result = run(read_scene(speaking(isolation)))
    assert list(result.columns) == ["a.Boolean_out", "b.Enumeration_out"]  # what figures and statistics are of
    assert (set(result["a.Boolean_out"]), set(result["b.Enumeration_out"])) == ({0.0}, {1.0})
    assert result["b.String_out"].tolist() == result["a.String_out"].tolist() == [SAID] * 11
    with open(result.save(tmp_path) / "result.csv", encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    assert names == ["time", "a.Boolean_out", "b.Enumeration_out", "b.String_out", "a.String_out"]
    assert [row[1:] for row in rows] == [["0.0", "1.0", SAID, SAID]] * 11


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_text_that_changes_is_recorded_with_its_rows(fmi):
    """Every third step, and alone: a result of texts has no column of numbers."""
    data = scene(native_fmu("moody", fmi), {"signals": ["f.words"], "interval": 0.3})
    result = run(read_scene(data))
    assert (list(result.columns), result.time.tolist()) == ([], pytest.approx([0.0, 0.3, 0.6, 0.9, 1.0]))
    assert result["f.words"].tolist() == ["at 0.0", "at 0.3", "at 0.6", "at 0.9", "at 1.0"]


def test_texts_of_a_run_that_is_resumed_are_those_of_the_whole_one(tmp_path):
    loaded = read_scene(speaking())
    whole = run(loaded, checkpoint_every=0.4, checkpoint_to=tmp_path / "half")
    resumed = run(loaded, resume=tmp_path / "half")
    assert resumed["b.String_out"].tolist() == whole["b.String_out"].tolist() == [SAID] * 11


@pytest.mark.parametrize("isolation", ["none", "process"])
@pytest.mark.parametrize("octets", ["00ff00", "", "666F6F"])
def test_binaries_go_from_unit_to_unit_beside_texts_and_are_recorded_as_fmi_writes_them(octets, isolation):
    said = {"fmu": native_fmu("feedthrough", 3), "parameters": {"String_in": SAID, "Binary_in": octets}, "isolation": isolation}
    result = finished(
        read_scene(
            {
                "stop_time": 0.3,
                "units": {"a": said, "b": {"fmu": native_fmu("feedthrough", 3)}},
                "master": {"step": 0.1},
                "connections": ["a.Binary_out -> b.Binary_in", "a.String_out -> b.String_in"],
                "record": {"signals": ["b.Binary_out", "b.String_out", "b.Int8_out"]},
            }
        )
    )
    assert result["b.Binary_out"].tolist() == [octets.lower()] * 4
    assert result["b.String_out"].tolist() == [SAID] * 4


def test_an_empty_list_of_signals_is_refused():
    with pytest.raises(BadInput, match=r"record\.signals: got no signal, expected at least one"):
        read_scene(scene(native_fmu("feedthrough", 3), {"signals": []}))
