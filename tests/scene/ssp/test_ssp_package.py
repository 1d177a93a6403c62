"""Packages that try to reach out of themselves, or are broken: refused with one message, nothing written elsewhere."""

import os
import zipfile
from pathlib import Path

import pytest
from cosimo import BadInput, load_scene
from cosimo.orchestrator.scene.ssp.units_of_measure import between, named
from cosimo.tests.scene.ssp import systems
from cosimo.tests.scene.ssp.systems import component, document, system


def packed(folder, root, **members):
    path = folder / "test.ssp"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("SystemStructure.ssd", document(root))
        for name, content in members.items():
            file.writestr(name.replace("__", "/"), content)
    return path


@pytest.mark.parametrize(
    "source",
    [
        "../adder.fmu",
        "a/../../adder.fmu",
        "{folder}/adder.fmu",
        "file:{folder}/adder.fmu",
        "http://localhost/adder.fmu",
        "//host/adder.fmu",
        "%2e%2e/adder.fmu",
        "..%2Fadder.fmu",
        "c:adder.fmu",
        "a\\..\\adder.fmu",
        ".",
        "%00",
    ],
)
@pytest.mark.parametrize("kind", ["ssd", "ssp"])
def test_no_path_leads_out_of_a_package(folder, source, kind):
    root = system("s", component("a", source=source.format(folder=folder)))
    inner = folder / "inner"
    inner.mkdir()
    path = packed(inner, root) if kind == "ssp" else inner / "test.ssd"
    if kind == "ssd":
        path.write_text(document(root))
        if (
            ".." in source.replace("%2e", ".") and "\\" not in source and "%2F" not in source
        ):  # meant as in a scene: a neighbouring folder
            scene = load_scene(path)
            assert Path(scene.units["a"].fmu).samefile(folder / "adder.fmu")
            assert [f"source {source!r} lies outside the folder" in r for r in scene.remarks if "source" in r] == [True]
            return
    with pytest.raises(BadInput, match="relative path to a file inside the package"):
        load_scene(path)


def test_members_with_evil_names_are_never_written(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))
    members = {"adder.fmu": (folder / "adder.fmu").read_bytes(), "..__..__evil.txt": b"1", "__evil.txt": b"2"}
    path = packed(folder, system("s", component("a")), **members)
    before = {p for p in folder.rglob("*") if "cache" not in p.parts}
    scene = load_scene(path)
    assert {p for p in folder.rglob("*") if "cache" not in p.parts} == before
    found = [p.relative_to(tmp_path / "cache") for p in (tmp_path / "cache").rglob("*") if p.is_file()]
    kept = {("ssp", "adder.fmu", 3), ("ssp", "adder.fmu.seal", 3)}  # the file, and what proves it
    assert {(p.parts[0], p.name, len(p.parts)) for p in found} == kept
    assert scene.kinds["a"].shown == "adder.fmu"  # a reader knows no copies
    (alone,) = load_scene(folder / "adder.fmu").kinds.values()
    assert alone.shown == str(folder / "adder.fmu")
    stamp = os.stat(scene.units["a"].fmu).st_mtime_ns
    for _ in range(3):
        load_scene(path)  # the copy is written once, however often the scene is read
    assert os.stat(scene.units["a"].fmu).st_mtime_ns == stamp


def test_a_changed_fmu_is_another_copy(folder):
    first = load_scene(packed(folder, system("s", component("a")), **{"adder.fmu": (folder / "adder.fmu").read_bytes()}))
    second = load_scene(packed(folder, system("s", component("a")), **{"adder.fmu": (folder / "metres.fmu").read_bytes()}))
    assert first.units["a"].fmu != second.units["a"].fmu
    assert Path(first.units["a"].fmu).read_bytes() == (folder / "adder.fmu").read_bytes()


def test_broken_archives(folder):
    path = packed(folder, system("s", component("a")), **{"adder.fmu": (folder / "adder.fmu").read_bytes()})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(BadInput, match="zip archive"):
        load_scene(path)
    spoilt = bytearray(content)
    spoilt[content.index(b"modelDescription.xml") + 200] ^= 255
    path.write_bytes(bytes(spoilt))
    with pytest.raises(BadInput, match="cannot be unpacked"):
        load_scene(path)
    with pytest.raises(BadInput, match="No such file"):
        load_scene(folder / "none.ssp")
    with pytest.raises(BadInput, match="No such file"):
        load_scene(folder / "none.ssd")
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("other.ssd", "")
    with pytest.raises(BadInput, match=r"'SystemStructure\.ssd'"):
        load_scene(path)


def test_reading_leaves_no_file_open(folder):
    if not Path("/proc/self/fd").is_dir():
        pytest.skip("counts open files where the system lists them")
    path = packed(folder, system("s", component("a")), **{"adder.fmu": (folder / "adder.fmu").read_bytes()})
    load_scene(path)
    before = len(os.listdir("/proc/self/fd"))
    kept = [load_scene(path) for _ in range(20)]
    assert len(os.listdir("/proc/self/fd")) == before
    assert len(kept) == 20


def test_descriptions_that_would_fill_the_memory_are_refused(folder, monkeypatch):
    monkeypatch.setattr("cosimo.orchestrator.scene.ssp.system.LARGEST_TEXT", 100)
    with pytest.raises(BadInput, match="at most 100 bytes"):
        load_scene(packed(folder, system("s", component("a"))))


@pytest.mark.full
def test_files_that_name_one_another_twice_over_and_over_are_refused(folder):
    """25 files of two elements each would be 2^25 systems."""
    twice = '<ssd:Component name="{}" type="application/x-ssp-definition" source="{}.ssd"/>'
    for k in range(25):
        inner = "".join(twice.format(n, k + 1) for n in "xy") if k < 24 else ""
        (folder / f"{k}.ssd").write_text(document(f'<ssd:System name="s"><ssd:Elements>{inner}</ssd:Elements></ssd:System>'))
    with pytest.raises(BadInput, match="more than 10000 elements"):
        load_scene(folder / "0.ssd")


def test_the_helpers_of_these_tests_write_valid_files():
    systems.validated(document(system("s", component("a")), systems.units()))


def test_units_in_brackets_are_what_stands_in_them():
    """As OMSimulator writes them into its .ssv files; a definition of the file comes first."""
    assert between(named("[m]", {}), named("mm", {}), "x") == (1e3, 0.0)
    assert between(named("[m]", {"[m]": named("km", {})}), named("m", {}), "x") == (1e3, 0.0)
    with pytest.raises(BadInput, match=r"'\[abc\]' has no definition"):
        between(named("[abc]", {}), named("m", {}), "x")
