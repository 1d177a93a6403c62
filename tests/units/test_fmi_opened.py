"""FMUs that cannot be opened, or not twice, are refused before a run; what is opened calls the library no more than it must."""

import os
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe, open_unit
from cosimo.tests.units.native import native_fmu, started


def changed(model: str, fmi: int, old: str, new: str) -> UnitSettings:
    return UnitSettings(fmu=native_fmu(model, fmi, "", (old, new)))


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_library_that_refuses_to_start_is_bad_input_with_its_log(fmi):
    with pytest.raises(BadInput, match=r"(?s)units\.f: .* cannot be started.*log: wrong instantiation token"):
        open_unit("f", changed("dahlquist", fmi, "{native}", "{another}"), in_process=False)


def test_a_broken_library_leaves_the_working_directory_alone(tmp_path):
    path = tmp_path / "broken.fmu"
    with zipfile.ZipFile(native_fmu("dahlquist", 2)) as whole, zipfile.ZipFile(path, "w") as broken:
        for name in whole.namelist():
            broken.writestr(name, b"no library" if name.endswith(".so") else whole.read(name))
    here = os.getcwd()
    with pytest.raises(BadInput, match="cannot be started"):
        open_unit("f", UnitSettings(fmu=str(path)), in_process=False)
    assert os.getcwd() == here


def test_a_file_that_cannot_be_unpacked_is_bad_input_and_leaves_no_folder(tmp_path, monkeypatch):
    path = tmp_path / "damaged.fmu"
    content = bytearray(Path(native_fmu("dahlquist", 2)).read_bytes())
    with zipfile.ZipFile(native_fmu("dahlquist", 2)) as whole:
        library = next(i for i in whole.infolist() if i.filename.endswith(".so"))
    content[library.header_offset + 1000] ^= 0xFF
    path.write_bytes(content)
    before = read_scene({"stop_time": 1.0, "units": {"f": {"fmu": str(path)}}, "master": {"step": 0.1}})
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    with pytest.raises(BadInput, match=r"units\.f: .* cannot be unpacked: Bad CRC-32"):
        run(before)
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
    fresh = tmp_path / "fresh.fmu"  # one that no other test has unpacked
    fresh.write_bytes(Path(native_fmu("dahlquist", 2)).read_bytes())
    with pytest.raises(BadInput, match=r"cannot be unpacked: .*it unpacks to \d+ bytes"):
        open_unit("f", UnitSettings(fmu=str(fresh)), in_process=False)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('start="1"', 'start="one"', "start = 'one' of 'h'"),
        ('nominal="5"', 'nominal="x"', "nominal = 'x' of 'Length'"),
        ('min="0.5"', 'min="0,5"', "min = '0,5' of 'e'"),
    ],
)
def test_numbers_that_are_none_in_a_description_are_told_with_their_variable(old, new, named):
    with pytest.raises(BadInput, match=named):
        describe("f", changed("bouncing_ball", 3, old, new))


def test_fmus_that_allow_one_instance_get_one():
    settings = UnitSettings(fmu=native_fmu("dahlquist", 3, 'canBeInstantiatedOnlyOncePerProcess="true"'))
    first = open_unit("a", settings, in_process=False)
    with pytest.raises(BadInput, match=r"units\.b: got a second instance of .*isolation = \"process\""):
        open_unit("b", settings, in_process=False)
    first.close()
    open_unit("b", settings, in_process=False).close()


def test_scheduled_execution_and_clocks_to_tick_are_refused():
    with pytest.raises(BadInput, match="for scheduled execution only"):
        describe("f", changed("dahlquist", 3, "<CoSimulation ", "<ScheduledExecution "))
    clock = '<Clock name="tick" valueReference="99" causality="input" intervalVariability="constant" intervalDecimal="0.1"/>'
    with pytest.raises(BadInput, match="the clock 'tick', which its importer has to tick"):
        describe("f", changed("dahlquist", 3, "</ModelVariables>", clock + "</ModelVariables>"))
    asleep = clock.replace('intervalVariability="constant" intervalDecimal="0.1"', 'intervalVariability="triggered"')
    unit = changed("dahlquist", 3, "</ModelVariables>", asleep + "</ModelVariables>")
    data = {"stop_time": 0.2, "units": {"f": {"fmu": unit.fmu}}, "master": {"step": 0.1}}
    assert any("f: clock tick" in w for w in run(read_scene(data)).info.warnings)


def test_an_fmu_without_a_binary_for_this_platform_is_bad_input(tmp_path):
    path = tmp_path / "sources.fmu"
    with zipfile.ZipFile(native_fmu("dahlquist", 3)) as whole, zipfile.ZipFile(path, "w") as bare:
        bare.writestr("modelDescription.xml", whole.read("modelDescription.xml"))
    with pytest.raises(BadInput, match="with no library, expected a library for"):
        open_unit("f", UnitSettings(fmu=str(path)), in_process=False)


def test_a_step_of_an_fmu_of_fmi_3_calls_the_library_once_for_each_of_set_step_get():
    """Counted by the profiler: no Python function but the unit's own three and the C calls."""
    unit, calls = started("feedthrough", 3, "", ("Float64_continuous_input",), ("Float64_continuous_output",)), []
    sys.setprofile(lambda frame, event, _: calls.append(frame.f_code.co_name) if event == "call" else None)
    unit.drive([1.0], None, None, 0.1)
    unit.step(0.0, 0.1)
    unit.get()
    sys.setprofile(None)
    unit.close()
    assert calls == ["drive", "step", "read"]
