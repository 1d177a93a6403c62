"""FMUs get the parameters that a scene gives them, also where they take values back on the way to the first step."""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe
from cosimo.tests.units.native import native_fmu, started


def scene(fmi: int, **parameters) -> dict:
    return {
        "stop_time": 0.1,
        "master": {"step": 0.1},
        "units": {"f": {"fmu": native_fmu("resetting", fmi), "parameters": parameters}},
    }


@pytest.mark.parametrize("fmi", [2, 3])
def test_values_survive_resets_before_and_in_the_initialization(fmi):
    unit = started("resetting", fmi, early=2.0, late=3.0, limited=10.0, whole=5, choice=True, text="given")
    assert unit.get() == [2.0 + 3.0 + 10.0 + 5.0 + 1.0]
    assert unit.parameters()["late"] == 3.0
    unit.close()


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"never": 2.5}, r"never = 2\.5, which the FMU has as 1\.0"),
        ({"early": 2.0, "limited": 11}, r"limited = 11, which the FMU has as 10\.0"),
    ],
)
@pytest.mark.parametrize("isolation", ["none", "process"])
def test_a_value_that_the_fmu_does_not_keep_is_refused_with_both_numbers(fmi, given, message, isolation):
    data = scene(fmi, **given)
    data["units"]["f"]["isolation"] = isolation
    with pytest.raises(BadInput, match=rf"units\.f\.parameters: got {message} in initialization mode, expected a value that"):
        run(read_scene(data))


@pytest.mark.parametrize("fmi", [2, 3])
def test_reals_that_are_kept_in_single_precision_are_kept(fmi):
    """0.1 is no number of 32 bits; what is read back is one of FMI 3's type, and a value nearby of FMI 2 is no loss."""
    unit = started(
        "feedthrough",
        fmi,
        "",
        (),
        ("Float64_continuous_output",),
        **({"Float32_continuous_input": 0.1} if fmi == 3 else {"Float64_fixed_parameter": 0.1}),
    )
    unit.close()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"x0": 2.0}, r"x0 = 2\.0, expected values of an array of shape \(3\)\. Write x0 = \[\.\.\.\], a list, or .*'x0\[1\]'"),
        ({"x0[4]": 2.0}, r"x0\[4\] = 2\.0, expected values of an array of shape \(3\)"),
        ({"x0": [1.0, 2.0]}, r"x0 = a list of shape \(2\), expected values of an array of shape \(3\)\. Write x0 = "),
        ({"x0": [1.0, 2.0, 3.0, 4.0]}, r"x0 = a list of shape \(4\), expected values of an array of shape \(3\)"),
        ({"A": [1.0, 2.0]}, r"A = a list of shape \(2\), expected .*\(3, 3\)\. Write A = \[\.\.\.\], a list of lists"),
        ({"A": [[1.0, 2.0], [3.0, 4.0]]}, r"A = a list of shape \(2, 2\), expected values of an array of shape \(3, 3\)"),
        ({"A": [[1.0, 2.0, 3.0], [4.0, 5.0], [6.0]]}, r"A = a list with rows of different lengths, expected .*\(3, 3\)"),
        ({"n": 2, "x0": [1.0, 2.0, 3.0]}, r"x0 = a list of shape \(3\), expected values of an array of shape \(2\)"),
    ],
)
def test_arrays_of_another_shape_are_refused_with_theirs(given, message):
    with pytest.raises(BadInput, match=message):
        describe("f", UnitSettings(fmu=native_fmu("state_space", 3), parameters=given))


@pytest.mark.parametrize("parts", [("x0", [1.0, 2.0]), ("x0", [])])
def test_a_list_of_another_shape_is_refused_wherever_it_is_given(parts, tmp_path):
    """In the scene itself, in a change of a scene, and in a scene that is a subsystem of another one."""
    name, values = parts
    unit = {"fmu": native_fmu("state_space", 3)}
    plain = {"stop_time": 0.1, "master": {"step": 0.1}, "units": {"f": unit}}
    message = r"units\.(s\.)?f\.parameters.*: got (x0 = a list of shape \(2\), expected .* \(3\)|an empty list, expected values)"
    with pytest.raises(BadInput, match=message):
        read_scene({**plain, "units": {"f": {**unit, "parameters": {name: values}}}})
    with pytest.raises(BadInput, match=message):
        read_scene(plain).with_changes({f"f.{name}": values})
    (tmp_path / "inner.toml").write_text(f"[units.f]\nfmu = '{unit['fmu']}'\nparameters.{name} = {values}\n")
    with pytest.raises(BadInput, match=message.replace("units", "(inner: )?units")):
        read_scene({**plain, "units": {"s": {"scene": str(tmp_path / "inner.toml")}}})


def test_a_list_sets_all_elements_of_an_array():
    unit = started("state_space", 3, "", (), None, x0=[1.0, 2.0, 3.0])
    assert unit.get() == [2.0, 4.0, 6.0]  # y = x + u, u = 1, 2, 3
    assert unit.parameters()["x0[3]"] == 3.0
    unit.close()
