"""Files made to do harm, or damaged: one message with file and place, limits with their numbers, before memory is taken."""

import io
import json
import random
import subprocess
import sys
import zipfile
from types import SimpleNamespace

import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.orchestrator import loading
from cosimo.orchestrator.engine.coupling.connections import _transformation
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.units_of_measure import Measure, named
from cosimo.orchestrator.units.interface import Signal
from cosimo.orchestrator.units.kinds.fmu import _measures
from cosimo.tests.support import Probe

SCENE = 'units.p.component = "cosimo.tests.support:Probe"\nmaster.step = 0.1\nstop_time = 1.0\n'
DESCRIPTION = """<?xml version="1.0"?><fmiModelDescription fmiVersion="{version}" modelName="m" guid="g" instantiationToken="g">
<CoSimulation modelIdentifier="m"/><ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"""
SCALAR = '<ScalarVariable name="{name}" valueReference="{reference}" causality="output"><Real/></ScalarVariable>'
ARRAY = (
    '<Float64 name="a" valueReference="1" causality="output" start="0"><Dimension start="100000"/>'
    '<Dimension start="100000"/></Float64>'
)


def refused(path, *words: str) -> str:
    """The message of a file that is refused; it names the file and holds the words."""
    with pytest.raises(BadInput) as refusal:
        load_scene(path)
    message = str(refusal.value)
    assert path.stem in message
    assert "\n" not in message
    for word in words:
        assert word in message
    return message


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 5000 + "]" * 5000,
        "x = " + "{a = " * 3000 + "1" + "}" * 3000,
        ".".join(["a"] * 5000) + " = 1",
        "p.length = " + "[" * 150 + "1" + "]" * 150,
    ],
    ids=["lists", "tables", "keys", "parameter"],
)
def test_nesting_has_a_limit(tmp_path, text):
    path = tmp_path / "deep.toml"
    path.write_text(SCENE + text + "\n")
    refused(path, f"at most {loading.DEEPEST} levels")


def test_numbers_of_any_length_and_other_bytes(tmp_path):
    path = tmp_path / "digits.toml"
    path.write_text(SCENE + "x = " + "1" * 5000 + "\n")
    refused(path, "4300 digits")
    path.write_bytes(random.Random(1).randbytes(3000))
    refused(path)


def test_a_byte_order_mark_is_passed_by(tmp_path):
    path = tmp_path / "marked.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SCENE.encode())
    assert load_scene(path).stop_time == 1.0


def test_a_scene_is_not_larger_than_a_scene_needs(tmp_path):
    path = tmp_path / "large.toml"
    path.write_text(SCENE + "#" * loading.MOST_TOML)
    refused(path, f"at most {loading.MOST_TOML} bytes")


def test_includes_have_a_limit(tmp_path):
    for k in range(8):
        inner = "".join(f'units.u{j} = {{ scene = "level{k + 1}.toml" }}\n' for j in range(10))
        unit, *rest = SCENE.splitlines(keepends=True)
        (tmp_path / f"level{k}.toml").write_text((inner if k < 7 else unit) + "".join(rest))
    with pytest.raises(BadInput, match=f"a scene of more than {loading.MOST_FILES} files"):
        load_scene(tmp_path / "level0.toml")


def archive(members: dict[str, bytes]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return content.getvalue()


def test_damaged_and_swollen_packages(tmp_path):
    path, swollen = tmp_path / "damaged.ssp", tmp_path / "swollen.ssp"
    whole = bytearray(archive({"SystemStructure.ssd": b"<a>" + random.Random(2).randbytes(500).hex().encode() * 20}))
    whole[60:90] = random.Random(3).randbytes(30)
    path.write_bytes(whole)
    refused(path, "cannot be unpacked")
    swollen.write_bytes(archive({"SystemStructure.ssd": b" " * (loading.RATIO_FROM + 1)}))
    refused(swollen, f"at most {loading.RATIO} times as many")


@pytest.mark.parametrize(
    ("version", "variables", "words"),
    [
        ("2.0", SCALAR.format(name="y", reference=2**40), ["valueReference", str(loading.MOST_REFERENCE)]),
        ("2.0", SCALAR.format(name="y", reference=-1), ["valueReference", str(loading.MOST_REFERENCE)]),
        ("2.0", SCALAR.format(name="y", reference="abc"), ["an FMU"]),
        ("3.0", ARRAY, [f"at most {loading.MOST_ELEMENTS}"]),
        ("2.0", "<x valueReference=''/>" * (loading.MOST_VARIABLES + 1), [f"at most {loading.MOST_VARIABLES}"]),
        ("2.0", "<!DOCTYPE m [<!ENTITY a 'b'>]>", ["plain XML"]),
    ],
    ids=["beyond 32 bits", "negative", "no number", "array", "variables", "entities"],
)
def test_model_descriptions_have_limits(tmp_path, version, variables, words):
    text = DESCRIPTION.format(version=version, variables=variables).encode()
    (tmp_path / "m.fmu").write_bytes(archive({"modelDescription.xml": text}))
    path = tmp_path / "hostile.toml"
    path.write_text('units.p.fmu = "m.fmu"\nmaster.step = 0.1\nstop_time = 1.0\n')
    refused(path, *words)


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"modelDescription.xml": b"<a/>"}, ["whose modelDescription.xml is <a>, expected <fmiModelDescription>"]),
        ({"sources/m.c": b"", "sources/m.c/": b""}, ["'sources/m.c' is a file and a folder"]),
        ({"sources/m.c": b"", "sources/m.c/n.h": b""}, ["'sources/m.c' is a file and a folder"]),
    ],
    ids=["another element", "folder", "file below a file"],
)
def test_an_archive_that_is_no_fmu(tmp_path, members, words):
    text = DESCRIPTION.format(version="2.0", variables=SCALAR.format(name="y", reference=1)).encode()
    (tmp_path / "m.fmu").write_bytes(archive({"modelDescription.xml": text} | members))
    path = tmp_path / "hostile.toml"
    path.write_text('units.p.fmu = "m.fmu"\nmaster.step = 0.1\nstop_time = 1.0\n')
    with pytest.raises(BadInput) as refusal:
        load_scene(path)
    assert all(word in str(refusal.value) for word in words), refusal.value


def test_an_fmu_that_swells_is_refused_before_it_is_unpacked(tmp_path):
    text = DESCRIPTION.format(version="2.0", variables=SCALAR.format(name="y", reference=1)).encode()
    (tmp_path / "m.fmu").write_bytes(archive({"modelDescription.xml": text, "resources/x": b"\0" * (loading.RATIO_FROM + 1)}))
    path = tmp_path / "hostile.toml"
    path.write_text('units.p.fmu = "m.fmu"\nmaster.step = 0.1\nstop_time = 1.0\n')
    refused(path, f"at most {loading.RATIO} times as many")


@pytest.mark.parametrize("unit", ["m" + "9" * 400, "kN" + "9" * 5000, "km300.km300"])
def test_a_unit_of_measure_with_a_power_beyond_all_numbers_is_one_that_nobody_knows(unit):
    """Seen by the campaign, in an FMU's unit definitions: a traceback."""
    assert _measures(SimpleNamespace(unitDefinitions=[SimpleNamespace(name=unit, baseUnit=None)])) == {}
    assert named(unit, {}) == Measure(unit, None)
    with pytest.raises(BadInput, match=r"connections: got units? "):
        _transformation("a.y -> b.u", Signal("y", unit), Signal("u", "m"), "connections")


class Faulty(Probe):
    """A user's component with a mistake in it."""

    def _step(self, t, h):
        if t > 0.45:
            self.lenght += 1  # no such attribute
        return super()._step(t, h)


def test_a_component_of_a_user_that_raises_ends_the_run_with_its_name(tmp_path):
    scene = read_scene({"stop_time": 1.0, "units": {"mine": {"component": f"{__name__}:Faulty"}}, "master": {"step": 0.1}})
    result = run(scene, output=tmp_path / "out")
    assert result.outcome == "failed"
    assert result.message.startswith("mine failed at t = 0.5 s: its component has raised AttributeError: ")
    assert result.time.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]
    info = json.loads((tmp_path / "out" / "run.json").read_text())
    assert "Traceback" in info["traceback"]
    assert "self.lenght += 1" in info["traceback"]


def test_on_the_command_line_it_is_a_failed_run(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f'units.mine.component = "{__name__}:Faulty"\nmaster.step = 0.1\nstop_time = 1.0\n')
    done = subprocess.run(
        [sys.executable, "-m", "cosimo.orchestrator.cli", "run", str(path), "-o", str(tmp_path / "out")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 3, done.stderr
    assert "Traceback" not in done.stderr
    assert "its component has raised AttributeError" in done.stderr
    assert len((tmp_path / "out" / "result.csv").read_text().splitlines()) == 1 + 6
