"""What `run` and `load_scene` take beside scenes: names, paths, an FMU alone; and modules that lie beside a scene."""

import sys

import pytest
from cosimo import BadInput, build, load_scene, run

MODULE = """
from cosimo import Component, output
from cosimo.components.core.kernels import DONE

class Constant(Component):
    value = output("1", "a number")

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        return DONE

    def _outputs(self, t):
        self.y[0] = {value}
        return DONE
"""
SCENE = 'stop_time = 0.1\n[units]\none = {{ component = "{module}:Constant" }}\n[master]\nstep = 0.05\n'


@pytest.fixture
def path(monkeypatch):
    """Python's path, as before once the test is over."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    known = set(sys.modules)
    yield sys.path
    for name in set(sys.modules) - known:
        del sys.modules[name]


def folder(parent, name, module, value):
    """A folder with a scene and its module."""
    (parent / name).mkdir()
    (parent / name / f"{module}.py").write_text(MODULE.format(value=value))
    (parent / name / "scene.toml").write_text(SCENE.format(module=module))
    return parent / name / "scene.toml"


def test_a_module_beside_its_scene_is_found_and_runs(tmp_path, path):
    result = run(folder(tmp_path, "one", "constant_beside", 3.0), in_process=True, verify="no")
    assert result["one.value"].tolist() == [3.0, 3.0, 3.0]


def test_two_modules_of_one_name_are_refused(tmp_path, path):
    """Python would silently run the first one's code."""
    load_scene(folder(tmp_path, "one", "constant_twice", 1.0))
    with pytest.raises(BadInput, match="not the one beside the scene"):
        load_scene(folder(tmp_path, "two", "constant_twice", 2.0))


def test_a_module_that_hides_one_of_python_is_refused(tmp_path, path):
    with pytest.raises(BadInput, match="module 'json'"):
        load_scene(folder(tmp_path, "one", "json", 1.0))


def test_a_scene_by_its_name_is_run():
    assert run("lumped-catenary", in_process=True, verify="no").outcome == "done"
    with pytest.raises(BadInput, match="'lumped-catenary'"):
        run("lumped-catenry")


def test_an_fmu_is_a_scene_of_it_alone(tmp_path):
    fmu = build("LumpedCatenary", tmp_path)
    scene = load_scene(fmu)
    assert (list(scene.units), scene.stop_time > 0.0, scene.remarks) == (["fmu"], True, ())
    with pytest.raises(BadInput, match=r"no\.fmu"):
        load_scene(tmp_path / "no.fmu")
