"""`cosimo show`: what a component or a scene consists of, and where Python is in its steps."""

import json

import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import COMPILED, DONE, hold_inputs
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.judgement.dry_run import stepping_path
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.commands import exit_code

compiled = pytest.mark.skipif(not COMPILED, reason="without Numba every step is Python")


class Half(Component):
    """Plain Python."""

    title = "halved"
    share = parameter(0.5, "1", "factor", low=0.0, high=1.0)
    amount = input_(1.0, "m", "a length")
    result = output("m", "half as much")

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        hold_inputs(self.u, h)
        self._outputs(t + h)
        return DONE

    def _outputs(self, t):
        self.y[0] = self.u[0, 0] * self.parameters["share"]


def shown(capsys, *arguments):
    """What `cosimo show ... --json` prints."""
    assert exit_code("show", *arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


@compiled
def test_a_component(capsys):
    found = shown(capsys, "PlanarLink", "--effects", "gravity")
    rows = {row["name"]: row for row in found["variables"]}
    assert rows["mass"] == {
        "name": "mass",
        "is": "parameter",
        "unit": "kg",
        "default": 1.0,
        "limits": ">= 1e-12",
        "text": "mass of the link",
        "as in": [],
    }
    assert rows["tip_force_x"]["is"] == "input"
    effects = {row["name"]: row for row in found["effects"]}
    assert effects["gravity"]["on"]
    assert effects["gravity"]["adds"] == ["parameter acceleration"]
    assert not effects["pinned"]["on"]
    assert effects["pinned"]["adds"] == ["output reaction_x", "output reaction_y"]
    assert found["step"] == "compiled"
    assert found["states"] == 6
    assert effects["pinned"]["states"] == -4  # a pin leaves a single angle and its rate
    assert "mass-on-spring" in [row["name"] for row in found["scenes"]]
    assert found["hard_cases"]


@pytest.mark.full
def test_a_case_and_a_scene_that_has_its_name(capsys, tmp_path):
    rows = shown(capsys, "iso16281")["reference"]
    assert {"quantity", "low", "high", "provenance", "source"} <= rows[0].keys()
    both = shown(capsys, "en50318-2018-ac-simple", "-o", str(tmp_path))
    assert both["units"]
    assert both["reference"]
    assert (tmp_path / "en50318-2018-ac-simple.svg").read_text().startswith("<svg ")


def test_time_that_effects_add(capsys):
    costs = {row["name"]: row["step"] for row in shown(capsys, f"{__name__}:Half", "--time")["effects"]}
    assert costs == {}
    costs = {row["name"]: row["step"] for row in shown(capsys, "TorqueMotor", "--time")["effects"]}
    assert set(costs) == {"inductance", "saturation"}
    assert all("µs" in words or words == "less than the scatter" for words in costs.values())


@pytest.mark.parametrize(
    "arguments",
    [("mass-on-spring", "--time"), ("mass-on-spring", "--preset", "a"), ("iso16281", "--preset", "a"), ("iso16281", "-o", "x")],
)
def test_options_without_effect_are_refused(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert exit_code("show", *arguments) == 2


def test_a_component_in_plain_python_says_so(capsys):
    found = shown(capsys, f"{__name__}:Half")
    assert found["step"] == "Python"
    assert [row["name"] for row in found["variables"] if row["is"] == "output"] == ["result"]


def test_a_scene(capsys):
    found = shown(capsys, "mass-on-spring")
    assert [unit["what"] for unit in found["units"]] == ["PlanarLink", "CompliantJoint"]
    assert {"from": "mass.base_x", "to": "spring.second_x", "times": 1.0, "plus": 0.0} in found["connections"]
    assert {"setting": "step", "value": 0.005} in found["master"]


BOND = {"master.bonds": ["spring.second_force_x * mass.base_velocity_x"]}


@compiled
@pytest.mark.parametrize(("changes", "obstacle"), [
    ({}, ""), ({"master.algorithm": "jacobi"}, ""), (BOND, ""), ({"units.spring.every": 2}, ""),
    ({"master.algorithm": "iterative"}, "master.algorithm"),
    ({**BOND, "master.energy_correction": True}, "master.energy_correction"),
    ({"master.control": {"method": "milne", "relative": 1e-4}}, "master.control"),
    ({"master.events": ["mass.base_x"]}, "master.events"),
])  # fmt: skip
def test_the_setting_that_puts_a_scene_on_the_general_path(changes, obstacle):
    path = stepping_path(load_scene("mass-on-spring").with_changes({"stop_time": 0.1, **changes}))
    assert path.python == ()
    assert bool(path.obstacles) == bool(obstacle)
    assert any(words.startswith(obstacle) for words in path.obstacles) or not obstacle, path.obstacles


@compiled
def test_a_unit_in_a_process_of_its_own_is_stepped_through_python():
    path = stepping_path(load_scene("mass-on-spring").with_changes({"stop_time": 0.1, "units.spring.isolation": "process"}))
    assert (path.obstacles, path.python) == ((), ("spring",))


@compiled
def test_python_in_the_steps_of_a_unit():
    data = load_scene("mass-on-spring").model_dump(exclude_unset=True)
    data["units"] = {**data["units"], "other": {"component": f"{__name__}:Half"}}
    path = stepping_path(read_scene(data))
    assert path.obstacles == ()
    assert path.python == ("other",)


@pytest.mark.parametrize(("name", "words"), [("PlanarLynk", "Did you mean 'PlanarLink'"), ("mass-on-sprin", "mass-on-spring")])
def test_an_unknown_name_is_one_message(name, words, capsys):
    assert exit_code("show", name) == 2
    assert words in capsys.readouterr().err
