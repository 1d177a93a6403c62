"""Errors of meshes from a coarser one: against closed forms, whatever the declaration, and said wherever a run is."""

import json
import re

import cosimo
import numpy as np
import pytest
from cosimo.components.core.component import Effect
from cosimo.components.core.variables import SEED, integer, output, parameter
from cosimo.orchestrator.harness.report import trust
from cosimo.orchestrator.harness.summary import verification_text
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.run import work
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import OfTime

HERE = "cosimo.tests.run.judgement.test_mesh"


class Chance(Effect):
    """A number of random parts, and their seed."""

    parts = integer(8, "random parts", mesh="random")
    seed = integer(1, "of these", structural=SEED)


class ByLength(OfTime):
    """sin 2 t (1 + h^order), whose error is h^order / (1 + h^order) of the deviation."""

    chance = Chance
    element = parameter(0.1, "m", "longest element", low=0.01, high=0.6, mesh="shorter")
    order = parameter(1.0, "1", "order of the error")
    value = output("1", "too large with the mesh")
    exact = output("1", "exact")

    def _h(self):
        return self.get("element")

    def _outputs(self, t):
        self.y[:] = np.sin(2.0 * t) * (1.0 + self._h() ** self.get("order")), np.sin(2.0 * t)


class ByNumber(ByLength):
    """The same, of n elements."""

    element = None
    segments = integer(10, "elements", low=2, mesh="more")

    def _h(self):
        return 1.0 / self.get("segments")


class Fixed(ByLength):
    """A mesh whose nodes do not depend on it."""

    def _h(self):
        return 0.1


def scene(component="ByLength", **parameters):
    unit = {"component": f"{HERE}:{component}", "parameters": parameters}
    return read_scene({"stop_time": 5.0, "units": {"a": unit}, "master": {"step": 0.05}})


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path))
    return tmp_path / "meshes"


@pytest.mark.parametrize(
    ("component", "parameters", "name"),
    [
        ("ByLength", {}, "a.element"),
        ("ByLength", {"element": 0.02}, "a.element"),
        ("ByNumber", {}, "a.segments"),
        ("ByNumber", {"segments": 25}, "a.segments"),
    ],
)
@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_the_error_is_never_below_the_true_one_and_at_low_orders_near_it(component, parameters, name, order):
    run = cosimo.run(scene(component, order=order, **parameters))
    found = run.info.verification
    h = parameters.get("element", 0.1) if component == "ByLength" else 1.0 / parameters.get("segments", 10)
    true = h**order / (1.0 + h**order)
    assert found.mesh.places == (name,)
    assert found.signals["a.exact"].rms < 1e-12
    assert 0.99 * true < found.signals["a.value"].rms < (1.3 if order <= 1.0 else 20.0) * true
    assert any(name in text for text in run.info.warnings) == (found.signals["a.value"].rms > 0.05)


def test_a_second_run_of_a_scene_pays_nothing_and_a_changed_or_damaged_one_is_measured_anew(cache, monkeypatch):
    runs = []
    once = verification.run
    monkeypatch.setattr(verification, "run", lambda s, **more: runs.append(s) or once(s, **more))

    def made(**parameters):
        runs.clear()
        found = cosimo.run(scene(**parameters), in_process=True).info.verification
        return len(runs), found.signals, found.mesh.kept

    first, second, third = made(), made(), made(element=0.2)
    assert first[1] == second[1] != third[1]
    assert (first[2], second[2], third[2]) == (False, True, False)
    assert first[0] - second[0] == 2
    other = scene().with_changes({"analysis.transient": 1.0})  # whose figures are others
    assert not cosimo.run(other, in_process=True).info.verification.mesh.kept
    for file in cache.iterdir():
        file.write_bytes(file.read_bytes()[:-1] + b" ")
    assert made() == first
    runs.clear()
    assert not cosimo.run(scene(), in_process=True, verify="steps").info.verification.mesh.places
    assert len(runs) == second[0]


@pytest.mark.parametrize(
    ("component", "parameters", "why"),
    [
        ("ByLength", {"element": 0.4}, "can be coarser"),
        ("ByNumber", {"segments": 3}, "can be coarser"),
        ("Fixed", {}, "the same nodes"),
    ],
)
def test_a_mesh_that_is_not_covered_is_named_with_the_reason(component, parameters, why):
    run = cosimo.run(scene(component, **parameters))
    ((name, said),) = run.info.verification.mesh.not_covered.items()
    assert why in said
    for text in (verification_text(run.info.verification), str(trust.blocks(run)[0])):
        assert f"The errors exclude the mesh ({name}): " in text
        assert why in text


def test_what_no_repetition_covers_is_named(monkeypatch):
    with_chance = scene().with_changes({"units.a.effects": ["chance"]})
    run = cosimo.run(with_chance)
    said = verification_text(run.info.verification)
    assert "the number of random parts, of which each number has others (a.chance.parts)" in said
    assert "a seed (a.chance.seed)" in said
    assert re.search(r"The errors include the mesh \(.+\), estimated with half as many elements: .+ % of ", said)
    assert "modelling errors" in said
    json.dumps(run.info.to_json())
    monkeypatch.setattr(work, "BUDGET", 0.0)
    monkeypatch.setattr(verification, "_over_windows", lambda _: pytest.fail("no windows"))
    long = verification.verified_result(run, "whole", in_process=True).info.verification
    assert long.mesh.places == ("a.element",)
