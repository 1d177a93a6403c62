"""FMUs that carry their evidence: what is measured, how it is written, and its replay by cosimo check, in FMUs of any maker."""

import zipfile
from functools import partial
from itertools import pairwise
from pathlib import Path

import fmpy
import numpy as np
import pytest
from cosimo import BadInput, component_class, load_scene
from cosimo.fmus.build import build
from cosimo.fmus.evidence import FOLDER, MANIFEST, Evidence, Step, experiments
from cosimo.fmus.evidence_check import replayed
from cosimo.fmus.native.build import build_native, own_target
from cosimo.orchestrator.harness.evidence import component_evidence, largest_within, scene_evidence
from cosimo.orchestrator.scene_fmu import build_scene_fmu

pytestmark = pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")
MAKE = partial(component_class("PlanarLink"), (), {})


@pytest.fixture(scope="module")
def link(tmp_path_factory):
    """FMUs of a component with its evidence, FMI 2 and 3, and the evidence."""
    evidence = component_evidence(MAKE)
    folder = tmp_path_factory.mktemp("link")
    return build_native("PlanarLink", MAKE, folder, [own_target()], (2, 3), evidence=evidence), evidence


def changed(path: Path, to: Path, files):
    """A copy of an FMU with other content of some files, None for none; files by their names in the folder of the evidence."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(to, "w") as target:
        for member in source.namelist():
            name = member.removeprefix(f"{FOLDER}/")
            content = files.get(name, source.read(member))
            if content is not None:
                target.writestr(member, content)
    return str(to)


def test_a_component_says_what_a_communication_step_costs(link):
    """Held inputs are of first order: half the step, half the error. The default experiment takes the longest step below 1 %."""
    _, evidence = link
    errors = [step.error for step in evidence.steps]
    assert [a / b for a, b in pairwise(errors)] == pytest.approx([2.0] * (len(errors) - 1), rel=0.2)
    assert evidence.step == max(step.length for step in evidence.steps if step.error < 0.01)
    assert evidence.inputs.keys() == set(MAKE().inputs)


def test_its_fmus_replay_it_exactly(link):
    files, evidence = link
    for path in files:
        ok, text = replayed(str(path))
        assert ok, text
        assert "of their" not in text
        description = fmpy.read_model_description(str(path))
        assert float(description.defaultExperiment.stepSize) == evidence.step
        assert "Error at a step of" in description.description
    assert "11 of 11 signals" in replayed(str(files[0]))[1]


def test_its_fmu_in_python_replays_it_exactly(link, tmp_path):
    path = build("PlanarLink", tmp_path, evidence=link[1])
    ok, text = replayed(str(path))
    assert ok, text
    assert "11 of 11 signals" in text
    assert "Error at a step of" in fmpy.read_model_description(str(path)).description


def test_a_result_that_does_not_hold_is_named(link, tmp_path):
    (path, _), evidence = link
    wrong = {**evidence.outputs, "base_x": evidence.outputs["base_x"] + 1e-3}
    table = Evidence(**{**vars(evidence), "outputs": wrong}).members(False)[f"{FOLDER}/reference.csv"]
    ok, text = replayed(changed(path, tmp_path / "wrong.fmu", {"reference.csv": table}))
    assert not ok
    assert "beyond: base_x by 0.001" in text


def test_a_result_alone_is_that_of_the_default_experiment(link, tmp_path):
    """As Reference FMUs have it: no experiment, no tolerance, no inputs."""
    manifest = b"""<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref">
    <Related type="text/csv" source="out.csv" role="result"/><Related source="gone.exp" role="experiment"/></fmiReferences>"""
    with zipfile.ZipFile(link[0][0]) as file:
        members = {name: None for name in file.namelist() if name.startswith(FOLDER)}
    files = {name.removeprefix(f"{FOLDER}/"): None for name in members} | {"fmi-ls-manifest.xml": manifest}
    path = changed(link[0][0], tmp_path / "alone.fmu", files)
    with zipfile.ZipFile(path, "a") as file:
        file.writestr(f"{FOLDER}/out.csv", "time,base_x,text,none\n0,0,a,1\n0.1,0,b,1\n")
    ok, text = replayed(path)
    assert ok
    assert "1 of 1 signals at 2 instants within 1 % of their ranges (no tolerance is given)" in text
    assert "not in the FMU: none" in text
    assert "no numbers: text" in text
    assert "gone.exp (experiment) is not in the FMU" in text


def test_a_component_whose_outputs_stand_still_has_none():
    with pytest.raises(BadInput, match="outputs that stand still or count"):
        component_evidence(partial(component_class("PipeRobot"), (), {}))


def test_an_fmu_without_evidence_has_no_fault(tmp_path):
    (path,) = build_native("PlanarLink", MAKE, tmp_path, [own_target()])
    assert replayed(str(path)) == (True, "not offered")


def test_the_older_form_of_experiments_is_read():
    """Times stand at the experiment; sources are relative to the file that names them, and none outside of the FMU is opened."""
    files = {
        MANIFEST: b"""<fmiReferences><Related type="application/x-ma-ls-experiments" source="sub/a.exp" role="experiment"/>
            <Related type="text/csv" source="https://example.org/r.csv" role="result"/>
            <Related type="text/csv" source="../../../r.csv" role="result"/></fmiReferences>""",
        f"{FOLDER}/sub/a.exp": b"""<Experiments name="a"><Experiment name="one" startTime="0.5" stopTime="2" stepSize="0.1">
            <Parameters source="p.ssv"/><References source="../r%201.csv"/></Experiment><Experiment name="two"/>
            <Experiment name="three"><Linearization/><References source="../r%201.csv"/></Experiment>
            <Experiment name="four"><References source="../r%201.csv" type="application/hdf5"/></Experiment></Experiments>""",
        f"{FOLDER}/sub/p.ssv": b"",
        f"{FOLDER}/r 1.csv": b"",
    }
    (one,), left = experiments(files)
    assert (one.start, one.stop, one.step) == (0.5, 2.0, 0.1)
    assert (one.reference, one.parameters) == (f"{FOLDER}/r 1.csv", f"{FOLDER}/sub/p.ssv")
    assert len(left) == 5
    assert "experiment 'three' has Linearization, which is not replayed" in left
    assert "experiment 'four' has application/hdf5, which is not replayed" in left
    assert "experiment 'two' has no reference results" in left


def test_a_step_counts_only_with_all_shorter_ones():
    steps = [Step(0.4, 0.005, 1.0), Step(0.2, 0.02, 1.0), Step(0.1, 0.009, 1.0)]
    assert largest_within(steps) == 0.1
    assert largest_within(steps[:2]) is None


def test_a_scene_says_what_its_macro_step_costs(tmp_path):
    """Linear forces: the limit of the closed form is 0.1213 s. The replay in FMI 2 and 3 is that of the run in process."""
    scene = load_scene("mass-on-spring").with_changes({"interface.outputs": {"place": "mass.base_x"}})
    evidence = scene_evidence(scene)
    errors = [step.error for step in evidence.steps]
    assert errors == sorted(errors, reverse=True)
    assert evidence.step == scene.master.step
    assert float(evidence.stable.split()[-2]) == pytest.approx(0.1213, rel=0.01)
    assert "place" in evidence.outputs
    for path in build_scene_fmu(scene, tmp_path, [own_target()], (2, 3), evidence):
        ok, text = replayed(str(path))
        assert ok, text
        recorded = fmpy.simulate_fmu(str(path), stop_time=evidence.stop, output_interval=evidence.time[1], output=["place"])
        assert np.abs(recorded["place"] - evidence.outputs["place"]).max() < 1e-12
