"""Looking at FMUs of others executes nothing of them; a sandbox is tried before it is trusted."""

import json
import stat
import zipfile

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator import units
from cosimo.orchestrator.units.sandbox import sandboxed
from cosimo.tests.commands import exit_code
from cosimo.tests.units.test_sandbox import needs_bubblewrap

DESCRIPTIONS = {
    2: """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="{g}"><CoSimulation modelIdentifier="m"
  canHandleVariableCommunicationStepSize="true"/><DefaultExperiment stopTime="0.01" stepSize="0.001"/><ModelVariables>
  <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable></ModelVariables><ModelStructure><Outputs>
  <Unknown index="1" dependencies=""/></Outputs><InitialUnknowns><Unknown index="1"/></InitialUnknowns></ModelStructure>
  </fmiModelDescription>""",
    3: """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="{g}"><CoSimulation modelIdentifier="m"/>
  <DefaultExperiment stopTime="0.01" stepSize="0.001"/><ModelVariables><Float64 name="time" valueReference="9"
  causality="independent" variability="continuous"/><Float64 name="y" valueReference="0" causality="output"/></ModelVariables>
  <ModelStructure><Output valueReference="0" dependencies=""/></ModelStructure></fmiModelDescription>""",
}
SSD = """<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="s">
<ssd:System name="s"><ssd:Elements><ssd:Component name="u" type="application/x-fmu-sharedlibrary" source="m.fmu"><ssd:Connectors>
<ssd:Connector name="y" kind="output"/></ssd:Connectors></ssd:Component></ssd:Elements></ssd:System>
<ssd:DefaultExperiment stopTime="0.01"/></ssd:SystemStructureDescription>"""


@pytest.fixture(params=DESCRIPTIONS)
def folder(request, tmp_path, monkeypatch):
    """A folder with an FMU that cannot be executed, because it has no library, and with a scene and an SSD of it."""
    with zipfile.ZipFile(tmp_path / "m.fmu", "w") as file:
        file.writestr("modelDescription.xml", DESCRIPTIONS[request.param])
    (tmp_path / "s.toml").write_text(
        'stop_time = 0.01\nmaster.step = 1e-3\nunits.u.fmu = "m.fmu"\nunits.u.isolation = "process"\n'
    )
    (tmp_path / "s.ssd").write_text(SSD)
    with zipfile.ZipFile(tmp_path / "s.ssp", "w") as file:
        file.writestr("SystemStructure.ssd", SSD.replace("m.fmu", "resources/m.fmu"))
        file.write(tmp_path / "m.fmu", "resources/m.fmu")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["m.fmu", "s.toml", "s.ssd", "s.ssp"])
def test_looking_executes_nothing(name, folder, capsys, monkeypatch):
    monkeypatch.setattr(units, "open_unit", None)
    assert exit_code("show", name) == 0
    assert "looking executes none" in capsys.readouterr().out
    assert exit_code("run", name, "--dry-run", "--step", "1e-3") == 0
    shown = capsys.readouterr()
    assert "left out: the stability of the coupling" in shown.out
    assert "--isolate executes FMUs in a sandbox" in shown.out


@pytest.mark.parametrize("folder", [2], indirect=True)  # each check is a process of a second
def test_a_check_executes_an_fmu_where_it_is_asked_to(folder, capsys):
    exit_code("check", "m.fmu", "--json")
    looked = json.loads(capsys.readouterr().out)
    assert [f["name"] for f in looked["findings"]] == ["model_description"]
    assert "default_experiment" in looked["left_out"]
    assert exit_code("check", "m.fmu", "--execute", "--json") == 1
    executed = json.loads(capsys.readouterr().out)
    assert executed["left_out"] == []
    assert not next(f for f in executed["findings"] if f["name"] == "default_experiment")["ok"]
    assert exit_code("check", "m.fmu", "--execute", "--isolate") == 2


PRETENDED = {
    "no wall": 'while [ "$1" != "--" ]; do shift; done; shift; exec "$@"',
    "an answer of its own": "echo held",
    "nothing": "exit 0",
    "a failure": "echo no user namespaces >&2; exit 1",
}


@pytest.mark.parametrize("how", PRETENDED)
def test_a_program_called_bwrap_is_tried_before_it_is_trusted(how, tmp_path, monkeypatch):
    program = tmp_path / "bwrap"
    program.write_text(f"#!/bin/sh\n{PRETENDED[how]}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(
        BadInput, match="which keeps nothing in: the unit would have user" if how == "no wall" else "cannot start"
    ):
        sandboxed("units.u.isolation", "")


@needs_bubblewrap
def test_the_sandbox_holds():
    assert sandboxed("units.u.isolation", "")[0].endswith("bwrap")


@pytest.mark.full
@needs_bubblewrap
def test_checks_in_the_sandbox(folder, capsys):
    assert exit_code("check", "m.fmu", "--isolate", "--json") == 1
    assert len(json.loads(capsys.readouterr().out)["findings"]) == 8
