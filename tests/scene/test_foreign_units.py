"""Units of measure of foreign FMUs: differences, pairs that nothing converts, whole arrays, maps of values."""

import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.orchestrator.cli.common import changes_of
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write as write_ssp
from cosimo.tests.units.native import native_fmu

TAKES, GIVES, FIXED = "Float64_continuous_input", "Float64_continuous_output", "Float64_fixed_parameter"
LENGTH = {2: '<Real unit="m" nominal="5"/>', 3: 'name="Length" unit="m" nominal="5"/>'}  # the declared type of the output
DEGREES = '<Unit name="K"><BaseUnit K="1"/></Unit><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
DEFINED = ("<UnitDefinitions>", f"<UnitDefinitions>{DEGREES}")
DIFFERENCE = ' relativeQuantity="true"'


def giver(fmi, unit, relative):
    """An FMU whose declared type says the unit of its output."""
    return native_fmu("feedthrough", fmi, "", DEFINED, (LENGTH[fmi], LENGTH[fmi].replace('unit="m"', f'unit="{unit}"{relative}')))


def taker(fmi, unit, relative):
    """An FMU whose input says its unit itself."""
    return native_fmu("feedthrough", fmi, "", DEFINED, ('start="0" unit="m"', f'start="0" unit="{unit}"{relative}'))


def scene_of(a, b, connections=(f"a.{GIVES} -> b.{TAKES}",), a_values=None, b_values=None):
    units = {"a": {"fmu": str(a), "parameters": a_values or {}}, "b": {"fmu": str(b), "parameters": b_values or {}}}
    return read_scene({"stop_time": 0.2, "units": units, "connections": list(connections), "master": {"step": 0.1}}, "odd")


def link(*arguments, **more):
    (one,) = scene_of(*arguments, **more).coupling.links
    return one.factor, one.offset


def table(**more):
    return [{"source": f"a.{GIVES}", "target": f"b.{TAKES}", **more}]


@pytest.mark.parametrize("fmi", [2, 3])
def test_differences_are_converted_as_differences(fmi, tmp_path):
    difference, value = giver(fmi, "degC", DIFFERENCE), giver(fmi, "degC", "")
    kelvins, temperature = taker(fmi, "K", DIFFERENCE), taker(fmi, "K", "")
    overruled = native_fmu(
        "feedthrough",
        fmi,
        "",
        DEFINED,
        (LENGTH[fmi], LENGTH[fmi].replace('unit="m"', f'unit="degC"{DIFFERENCE}')),
        ('declaredType="Length"', 'declaredType="Length" relativeQuantity="false"'),
    )
    assert link(difference, kelvins) == (1.0, 0.0)
    assert link(value, temperature) == (1.0, 273.15)
    assert link(overruled, temperature) == (1.0, 273.15)
    for a, b in ((difference, temperature), (value, kelvins), (overruled, kelvins)):
        with pytest.raises(BadInput, match=r"a (difference|value) in 'degC' for a (difference|value) in 'K'.*factor = "):
            link(a, b)
        assert link(a, b, table(factor=2.0)) == (2.0, 0.0)
        assert link(a, b, table(offset=290.0)) == (1.0, 290.0)
        assert link(a, b, table(convert_units=False)) == (1.0, 0.0)
    given = scene_of(difference, kelvins, (), b_values={TAKES: "10 degC"})
    assert given.units["b"].parameters == {TAKES: 10.0}
    for changed in ({f"b.{TAKES}": "7 degC"}, changes_of(given, [f"b.{TAKES}=7 degC"], None)):
        assert given.with_changes(changed).units["b"].parameters == {TAKES: 7.0}
    with pytest.raises(BadInput, match="A temperature and a difference of temperatures would differ"):
        scene_of(difference, temperature, (), b_values={TAKES: "10 degC"})
    result = run(scene_of(difference, kelvins, a_values={FIXED: 10.0}))
    assert result[f"a.{GIVES}"][-1] == result[f"b.{GIVES}"][-1] == 10.0
    again = load_scene(write_ssp(scene_of(difference, kelvins), tmp_path / "odd.ssp"))
    assert [(one.factor, one.offset) for one in again.coupling.links] == [(1.0, 0.0)]


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_factor_of_the_user_settles_any_pair_of_units(fmi, tmp_path):
    for units in (("Nm", "N.m"), ("foo", "K"), ("m", "bar"), ("degC", "s")):
        pair = giver(fmi, units[0], ""), taker(fmi, units[1], "")
        with pytest.raises(BadInput, match="Or give the factor"):
            link(*pair)
        for given, wanted in (({"factor": 1.0}, (1.0, 0.0)), ({"factor": 2.0, "offset": -3.0}, (2.0, -3.0))):
            scene = scene_of(*pair, table(**given))
            again = load_scene(write_ssp(scene, tmp_path / "odd.ssp"))
            for each in (scene, again):
                assert [(one.factor, one.offset) for one in each.coupling.links] == [wanted], units
    assert link(giver(fmi, "degC", ""), taker(fmi, "K", ""), table(factor=2.0)) == (2.0, 2.0 * 273.15)  # what is known stays


@pytest.mark.parametrize("fmi", [2, 3])
def test_ranges_of_declared_types_and_of_whole_numbers_hold(fmi):
    typed = native_fmu(
        "feedthrough",
        fmi,
        "",
        (LENGTH[fmi], LENGTH[fmi].replace("nominal", 'min="-1" max="2" nominal')),
        ('start="0" unit="m"', 'start="0" declaredType="Length"'),
    )
    cases = [(TAKES, typed, 3.0)]
    if fmi == 3:
        cases.append(("UInt8_in", native_fmu("feedthrough", 3, "", ('name="UInt8_in"', 'name="UInt8_in" max="7"')), 8))
    for name, fmu, value in cases:
        scene_of(fmu, fmu, (), {name: value - 1})
        with pytest.raises(BadInput, match="a value in"):
            scene_of(fmu, fmu, (), {name: value})


def test_whole_arrays_are_connected_by_their_name(tmp_path):
    fmu = native_fmu("state_space", 3)

    def arrays(m, connection="a.y -> b.u"):
        values = {"A": [[0.0] * 3] * 3, "B": [[0.0] * 3] * 3, "C": [[0.0] * 3] * 3, "D": [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]}
        b = {"m": m, "B": [[0.0] * m] * 3, "D": [[1.0] * m] * 3, "u": [0.0] * m} if m != 3 else values
        return scene_of(fmu, fmu, [connection], {**values, "u": [4.0, 5.0, 6.0]}, {k: v for k, v in b.items() if k != "u"})

    scene = arrays(3)
    wanted = [(("a", f"y[{k}]"), ("b", f"u[{k}]")) for k in (1, 2, 3)]
    for each in (scene, load_scene(write_ssp(scene, tmp_path / "odd.ssp"))):
        assert [(one.source, one.target) for one in each.coupling.links] == wanted
    assert [float(run(scene)[f"b.y[{k}]"][-1]) for k in (1, 2, 3)] == [4.0, 5.0, 6.0]
    assert [one.target for one in arrays(3, "a.y[2] -> b.u[3]").coupling.links] == [("b", "u[3]")]
    scaled = scene_of(fmu, fmu, [{"source": "a.y", "target": "b.u", "factor": 2.0}])
    assert [one.factor for one in scaled.coupling.links] == [2.0] * 3
    for arguments, named in (
        ((2,), r"a.y of shape \(3\) for b.u of shape \(2\)"),
        ((3, "a.y -> b.u[1]"), r"a.y of shape \(3\) for b.u\[1\] of shape \(\)"),
        ((3, "a.y[1] -> b.u"), r"a.y\[1\] of shape \(\) for b.u of shape \(3\)"),
    ):
        with pytest.raises(BadInput, match=named):
            arrays(*arguments)


@pytest.mark.parametrize("fmi", [2, 3])
def test_maps_of_values_are_computed_and_written(fmi, tmp_path):
    fmu, whole = native_fmu("feedthrough", fmi), "Int32"
    cases = [
        ("Boolean", {"true": False, "false": True}, True, 0.0),
        (whole, {"3": -40, "-7": 2, "0": 1}, -7, 2.0),
        ("Enumeration", {"one": "far", "two": "one", "far": "two"}, "far", 2.0),
    ]
    for kind, entries, given, wanted in cases:
        connection = {"source": f"a.{kind}_out", "target": f"b.{kind}_in", "map": entries}
        scene = scene_of(fmu, fmu, [connection], {f"{kind}_in": given})
        path = write_ssp(scene, tmp_path / "odd.ssp")
        again = load_scene(path)
        assert again.coupling.links == scene.coupling.links
        for each in (scene, again):
            assert run(each)[f"b.{kind}_out"][-1] == wanted
    for kind, entries, named in (
        ("Boolean", {"true": False}, "no entry for false"),
        ("Enumeration", {"one": "far"}, "no entry for two, far"),
        ("Enumeration", {"one": "fra"}, "Did you mean 'far'"),
        (whole, {"x": 1}, "a whole number"),
        ("Float64_continuous", {"1": 1}, "a map from a real output"),
    ):
        ends = [f"{kind}{e}" for e in (("_output", "_input") if "Float" in kind else ("_out", "_in"))]
        with pytest.raises(BadInput, match=named):
            scene_of(fmu, fmu, [{"source": f"a.{ends[0]}", "target": f"b.{ends[1]}", "map": entries}])
    absent = scene_of(fmu, fmu, [{"source": f"a.{whole}_out", "target": f"b.{whole}_in", "map": {"1": 1}}], {f"{whole}_in": 5})
    result = run(absent)
    assert result.outcome == "failed"
    for part in ("b failed", "Int32_in cannot be nan", "an entry for every value"):
        assert part in result.message
