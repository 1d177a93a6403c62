"""FMUs written in C: scalars of all types and arrays, connected, recorded and set from a scene."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe, open_unit
from cosimo.tests.scene_runs import finished
from cosimo.tests.units.native import EVENTS, MODELS, SMALL, STATE, native_fmu, started
from fmpy import read_model_description
from scipy.linalg import expm

RANGES = {
    name: (0 if name[0] == "U" else -(2 ** (int(name.strip("UInt")) - 1)), 2 ** (int(name.strip("UInt")) - (name[0] != "U")) - 1)
    for name in SMALL
}
VERSIONS = [(2, ""), (3, ""), (3, EVENTS)]  # with event mode discrete inputs must not be set outside it: the FMU would complain


def described(model, fmi=3, flags="", **parameters):
    return describe("f", UnitSettings(fmu=native_fmu(model, fmi, flags), parameters=parameters))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_fmus_of_these_tests_are_valid(model, fmi):
    if (model, fmi) != ("state_space", 2):  # FMI 2 has no arrays
        read_model_description(native_fmu(model, fmi, STATE[fmi]), validate=True)


@pytest.mark.parametrize(("fmi", "flags"), VERSIONS)
def test_every_type_goes_in_and_comes_out(fmi, flags):
    interface = described("feedthrough", fmi, flags)
    inputs = [n for n, s in interface.inputs.items() if not s.is_text]
    outputs = [interface_output for n in inputs for interface_output in (n.replace("input", "output").replace("_in", "_out"),)]
    if fmi == 3:
        assert len(inputs) == 4 + len(SMALL) + 1  # three reals, truth value, enumeration: one more than in the list below
    unit = started("feedthrough", fmi, flags, tuple(inputs), tuple(outputs))
    special = {
        "Float64_continuous_input": 0.1,
        "Float64_discrete_input": -1e300,
        "Float32_continuous_input": 0.5,
        "Boolean_in": 1.0,
        "Enumeration_in": 7.0,
    }
    for end in (0, 1):  # lowest and highest value of each type; 64 bits as far as floats are exact
        wanted = [special.get(n) or float(max(min(RANGES[n[:-3]][end], 2**53), -(2**53))) for n in inputs]
        unit.drive(wanted, None, None, 0.1)
        unit.step(0.1 * end, 0.1)
        assert unit.get() == wanted
    unit.close()


@pytest.mark.parametrize(("fmi", "flags"), VERSIONS)
def test_texts_go_in_and_come_out(fmi, flags):
    unit = started("feedthrough", fmi, flags)
    unit.wire_texts(["String_in"])
    texts = unit.text_reader(["String_out"])
    assert texts() == ["Set me!"]
    unit.set_texts(["Grüße, 世界"])
    unit.step(0.0, 0.1)
    assert texts() == ["Grüße, 世界"]
    unit.close()


def test_kinds_units_starts_and_dependencies_are_known():
    interface = described("feedthrough")
    kinds = {n: s.kind for n, s in interface.inputs.items()}
    assert kinds["Float32_continuous_input"] == "real"
    assert {kinds[f"{n}_in"] for n in SMALL} == {"integer"}
    assert (kinds["Boolean_in"], kinds["String_in"], kinds["Enumeration_in"]) == ("boolean", "string", "enumeration")
    assert [n for n, s in interface.inputs.items() if not s.discrete] == ["Float64_continuous_input", "Float32_continuous_input"]
    assert interface.inputs["String_in"].start == "Set me!"
    length = interface.outputs["Float64_continuous_output"]
    assert (length.unit, length.nominal, length.feedthrough) == ("m", 5.0, ("Float64_continuous_input",))  # unit of its type


def test_units_that_only_the_fmu_knows_are_converted_by_its_definition():
    """Cubits of 0.4572 m, and one whose definition is another one; without a definition only equal names fit."""
    cubit = '<Unit name="cubit"><BaseUnit m="1" factor="{}"/></Unit></UnitDefinitions>'

    def fmu(length: str) -> dict:
        change = (
            (' unit="m" nominal="5"', ' unit="cubit"'),
            ("</UnitDefinitions>", cubit.format(length) if length else "</UnitDefinitions>"),
        )
        return {"fmu": native_fmu("feedthrough", 3, "", *change), "parameters": {"Float64_fixed_parameter": 3.0}}

    arrow = "a.Float64_continuous_output -> b.Float64_continuous_input"  # cubits for metres
    metres = run(read_scene(scene(arrow, a=fmu("0.4572"), b=fmu("0.4572"))))
    assert metres["b.Float64_continuous_output"][-1] == pytest.approx(3.0 * 0.4572 + 3.0, rel=1e-15)
    with pytest.raises(BadInput, match="unit 'cubit', expected known units of measure"):
        read_scene(scene(arrow, a=fmu(""), b=fmu("")))
    with pytest.raises(BadInput, match="'cubit' for 'm', expected units of the same quantity"):
        read_scene(scene(arrow, a=fmu('1" kg="1'), b=fmu("0.4572")))


def test_a_polynomial_input_is_held_at_its_mean_in_both_lengths_of_reals():
    names = ("Float64_continuous_input", "Float32_continuous_input", "Int8_in")
    unit = started("feedthrough", 3, "", names, ("Float64_continuous_output", "Float32_continuous_output", "Int8_out"))
    unit.drive([1.0, 2.0, 3.0], [1.0, 2.0, 0.0], [3.0, 6.0, 0.0], 1.0)
    unit.step(0.0, 1.0)
    assert unit.get() == [2.5, 5.0, 3.0]  # the integral of 1 + s + 3 s² over [0, 1], and its double
    unit.close()


@pytest.mark.parametrize("value", [128.0, -129.0, 0.5, float("nan"), float("inf")])
def test_a_number_that_a_type_cannot_hold_ends_the_run_with_its_name(value):
    unit = started("feedthrough", 3, "", ("Int8_in",))
    with pytest.raises(StepFailed, match=r"input Int8_in cannot be .*whole numbers from -128 to 127"):
        unit.drive([value], None, None, 0.1)
    unit.close()


def test_whole_numbers_that_floats_cannot_tell_apart_are_refused():
    unit = started("feedthrough", 3, "", (), ("Int64_out",), Int64_in=-(2**53))
    assert unit.get() == [-(2.0**53)]
    unit.close()
    unit = started("feedthrough", 3, "", (), ("Int64_out",), Int64_in=2**53 + 1)
    with pytest.raises(StepFailed, match=r"Int64_out is 9007199254740993"):
        unit.get()
    unit.close()


@pytest.mark.parametrize(
    ("parameters", "named"),
    [
        ({"Int8_in": 128}, ["Int8_in = 128", "[-128, 127]"]),
        ({"UInt16_in": -1}, ["[0, 65535]"]),
        ({"Int32_in": 1.0}, ["Int32"]),
        ({"Float32_continuous_input": 1e39}, ["finite"]),
        ({"Boolean_in": 1}, ["Boolean"]),
        ({"String_in": 1}, ["String"]),
        ({"Enumeration_in": "tow"}, ["'tow'", "'two'"]),
        ({"Enumeration_in": 3}, ["one (1), two (2), far (7)"]),
        ({"Binary_in": "0"}, ["Binary_in = '0'", "hexadecimal"]),
        ({"UInt64_in": -1}, ["[0, 18446744073709551615]"]),
    ],
)
def test_bad_values_of_parameters_name_what_the_type_holds(parameters, named):
    with pytest.raises(BadInput) as caught:
        described("feedthrough", **parameters)
    assert [part for part in named if part not in str(caught.value)] == []


def test_members_of_an_enumeration_are_set_by_name():
    for fmi in (2, 3):
        unit = started("feedthrough", fmi, "", (), ("Enumeration_out",), Enumeration_in="far")
        assert unit.get() == [7.0]
        assert unit.parameters()["Enumeration_in"] == 7
        unit.close()


def test_parameters_keep_all_64_bits():
    for value in (2**63 - 1, -(2**63)):
        unit = open_unit("f", UnitSettings(fmu=native_fmu("feedthrough", 3), parameters={"Int64_in": value}), in_process=False)
        assert unit.parameters()["Int64_in"] == value
        unit.close()


def test_parameters_that_nobody_sets_are_told_by_their_start_values():
    for fmi in (2, 3):
        unit = started("feedthrough", fmi, "", (), ("Float64_continuous_output",), Float64_tunable_parameter=2.0)
        assert unit.parameters() == {"Float64_fixed_parameter": 0.0, "Float64_tunable_parameter": 2.0}
        unit.close()


def scene(*connections: str, **units) -> dict:
    return {"stop_time": 1.0, "connections": connections, "units": units, "master": {"algorithm": "jacobi", "step": 0.1}}


def test_kinds_are_connected_through_a_run_of_two_versions_of_fmi():
    """A counter of FMI 3 through an FMU of FMI 2 and back to one of FMI 3, each a step of 0.1 s later."""
    loaded = read_scene(
        {
            "stop_time": 3.0,
            "connections": [
                "stair.counter -> two.Int32_in",
                "two.Int32_out -> three.Float64_discrete_input",
                "two.String_out -> three.String_in",
                "two.Enumeration_out -> three.Enumeration_in",
            ],
            "units": {
                "stair": {"fmu": native_fmu("stair", 3, EVENTS)},
                "two": {"fmu": native_fmu("feedthrough", 2), "parameters": {"String_in": "hello", "Enumeration_in": "two"}},
                "three": {"fmu": native_fmu("feedthrough", 3, EVENTS)},
            },
            "master": {"algorithm": "jacobi", "step": 0.1},
        }
    )
    result = finished(loaded)
    exact = np.floor(result.time + 1e-9) + 1.0
    np.testing.assert_array_equal(result["stair.counter"], exact)
    np.testing.assert_array_equal(result["three.Float64_discrete_output"], exact)  # outputs follow within the instant
    assert set(result["three.Enumeration_out"]) == {2.0}


@pytest.mark.parametrize(
    ("connection", "named"),
    [
        ("a.Float64_continuous_output -> b.Binary_in", "a real output for a binary input"),
        ("a.String_out -> b.Binary_in", "a string output for a binary input"),
        ("a.Float64_continuous_output -> b.Int32_in", "a real output for an integer input"),
        ("a.String_out -> b.Int32_in", "a string output for an integer input"),
    ],
)
def test_connections_of_kinds_that_do_not_fit_are_refused(connection, named):
    unit = {"fmu": native_fmu("feedthrough", 3)}
    with pytest.raises(BadInput, match=named):
        read_scene(scene(connection, a=unit, b=unit))


# Arrays

MATRICES = {
    "A": [[0.0, 1.0], [-4.0, -0.5]],
    "B": [[0.0, 1.0, 0.0], [2.0, 0.0, 0.0]],
    "C": [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 0.0]],
    "D": [[0.0, 0.0, 1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
    "x0": [1.0, 0.5],
}
SIZES = {"m": 3, "n": 2, "r": 4}


def flat(name, array):
    array = np.array(array)
    return {f"{name}[{','.join(str(i + 1) for i in index)}]": float(v) for index, v in np.ndenumerate(array)}


def sized(flags="", inputs=("u[1]", "u[2]", "u[3]")):
    values = {k: v for name, array in MATRICES.items() for k, v in flat(name, array).items()}
    return started("state_space", 3, flags, inputs, None, **SIZES, **values, **flat("u", [0.5, 0.25, 0.125]))


def test_arrays_become_their_elements():
    interface = described("state_space")
    assert list(interface.inputs) == ["u[1]", "u[2]", "u[3]"]
    assert [s.start for s in interface.inputs.values()] == [1.0, 2.0, 3.0]
    assert interface.outputs["y[2]"].feedthrough == ("u[1]", "u[2]", "u[3]")
    assert list(described("state_space", r=1, **flat("C", [[1.0] * 3]), **flat("D", [[1.0] * 3])).outputs) == ["y[1]"]


def test_resized_arrays_and_matrices_give_the_exact_motion():
    unit, h = sized(), 0.3
    A, B, C, D, x = (np.array(MATRICES[n]) for n in ("A", "B", "C", "D", "x0"))
    for k, u in enumerate(([1.0, 2.0, 3.0], [0.5, -1.0, 4.0])):
        unit.drive(u, None, None, h)
        unit.step(k * h, h)
        whole = expm(h * np.block([[A, B], [np.zeros((3, 5))]]))
        x = whole[:2, :2] @ x + whole[:2, 2:] @ u
        np.testing.assert_allclose(unit.get(), C @ x + D @ u, rtol=1e-13, atol=1e-14)
    unit.close()


def test_a_driven_element_leaves_the_others_of_its_array_as_they_are():
    unit = sized(inputs=("u[2]",))
    unit.update([7.0])
    np.testing.assert_allclose(unit.get(), np.array(MATRICES["C"]) @ [1.0, 0.5] + np.array(MATRICES["D"]) @ [0.5, 7.0, 0.125])
    unit.close()


def test_elements_of_an_array_may_be_read_in_any_order():
    unit = sized()
    assert unit.reader(["y[4]", "y[1]"])() == [unit.get()[3], unit.get()[0]]
    unit.close()


def test_one_element_of_an_array_can_be_set():
    unit = started("state_space", 3, **{"A[2,2]": -3.0, "x0[2]": 1.0})
    h = 0.125
    unit.step(0.0, h)
    x = np.array([np.exp(h) - 1.0, np.exp(-3.0 * h) + 2.0 / 3.0 * (1.0 - np.exp(-3.0 * h)), 3.0 * (np.exp(h) - 1.0)])
    np.testing.assert_allclose(unit.get(), x + np.array([1.0, 2.0, 3.0]), rtol=1e-14)
    unit.close()


def test_nested_lists_of_a_scene_are_matrices():
    loaded = read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 0.1},
            "units": {"f": {"fmu": native_fmu("state_space", 3), "parameters": {**SIZES, **MATRICES, "u": [0.0, 0.0, 0.0]}}},
            "record": {"signals": ["f.y"]},
        }
    )
    result = run(loaded)
    assert list(result.columns) == [f"f.y[{k}]" for k in (1, 2, 3, 4)]
    end = np.array(MATRICES["C"]) @ expm(np.array(MATRICES["A"])) @ MATRICES["x0"]
    np.testing.assert_allclose([result[f"f.y[{k}]"][-1] for k in (1, 2, 3, 4)], end, rtol=1e-12)


def test_a_resized_array_without_values_is_refused():
    with pytest.raises(BadInput, match=r"no value for 'A\[1,1\]'"):
        open_unit("f", UnitSettings(fmu=native_fmu("state_space", 3), parameters={"n": 2, "A[2,2]": 1.0}), in_process=False)


def test_sizes_an_fmu_cannot_have_are_bad_input():
    with pytest.raises(BadInput, match="whole number of elements"):
        described("state_space", n=1.5)
