"""The signatures of the public functions: their choices are written out, results go to `output`, and Python can what commands can."""

from __future__ import annotations

import inspect

import cosimo
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli import fmus

FUNCTIONS = [name for name in cosimo.__all__ if inspect.isfunction(getattr(cosimo, name))]
OF_COMPONENTS = {  # names that a component's own variables, kernels and parameters have
    *("bind", "unit", "ode_kernels", "event_kernels", "smooth_kernels"),
    *("parameter", "integer", "input_", "output", "count", "flag"),  # fields of a `Variable`
}
IN_PYTHON = {"names": "what", "values": "parameters", "presets": "preset", "scene": "unit"}  # of an option of `cosimo build`
TO_OUTPUT = ("build", "design", "fit", "run_many", "sensitivity", "sweep", "uncertainty", "validate", "write_report")


def parameters(name):
    return inspect.signature(getattr(cosimo, name)).parameters


def test_choices_are_written_out():
    open_ended = {n for n in FUNCTIONS if any(p.kind is p.VAR_KEYWORD for p in parameters(n).values())}
    assert open_ended == OF_COMPONENTS


def test_results_go_to_output():
    assert [n for n in FUNCTIONS if "directory" in parameters(n) and n != "read_result"] == []  # which reads one
    assert [n for n in TO_OUTPUT if "output" not in parameters(n)] == []


@pytest.mark.parametrize("name", TO_OUTPUT)
def test_the_earlier_name_is_told_the_new_one(name):
    with pytest.raises(BadInput, match=rf"cosimo.{name}: got directory = .*, expected output = "):
        getattr(cosimo, name)("mass-on-spring", directory="out")


@pytest.mark.parametrize("name", ["save", "report"])
def test_a_result_goes_to_output_too(name, tmp_path):
    result = cosimo.run(cosimo.load_scene("mass-on-spring").with_changes({"stop_time": 0.01}), in_process=True)
    with pytest.raises(BadInput, match=rf"cosimo.Result.{name}: got directory = .*, expected output = "):
        getattr(result, name)(directory=tmp_path)
    assert getattr(result, name)(output=tmp_path).exists()


def test_python_builds_what_the_command_builds():
    options = inspect.signature(fmus.build).parameters
    assert {IN_PYTHON.get(option, option) for option in options} == set(parameters("build"))


def test_a_scene_and_a_unit_of_it_are_refused_without_native(tmp_path):
    with pytest.raises(BadInput, match="A scene is an FMU with native alone"):
        cosimo.build("mass-on-spring", tmp_path)
    with pytest.raises(BadInput, match="build: unit: no effect without native"):
        cosimo.build("mass-on-spring", tmp_path, unit="spring")
    with pytest.raises(BadInput, match="Did you mean 'spring'"):
        cosimo.build("mass-on-spring", tmp_path, native=True, unit="sprng")
    with pytest.raises(BadInput, match="a scene, which sets its own"):
        cosimo.build("mass-on-spring", tmp_path, native=True, parameters={"mass": 2.0})


def test_a_class_is_built_with_its_evidence(tmp_path):
    path = cosimo.build(cosimo.component_class("PlanarLink"), str(tmp_path), evidence=True)
    assert path == tmp_path / "PlanarLink.fmu"
    assert path.stat().st_size > 10_000


@pytest.mark.full
def test_a_unit_of_a_scene_is_built_as_the_command_builds_it(tmp_path):
    pytest.importorskip("ziglang")
    path = cosimo.build("mass-on-spring", tmp_path / "python", native=True, unit="spring", fmi=3)
    fmus.build(["spring"], output=tmp_path / "command", native=True, fmi="3", scene="mass-on-spring")
    assert path.name == "spring.fmi3.fmu"
    assert path.read_bytes() == (tmp_path / "command" / path.name).read_bytes()
