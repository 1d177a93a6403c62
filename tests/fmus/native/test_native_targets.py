"""Libraries for other machines: where they lie in an FMU, and that their machine code keeps the operations of the kernels."""

import re
import struct
import zipfile
from dataclasses import replace
from importlib.util import find_spec

import pytest
from cosimo.fmus.native.build import initialized, library, own_target, pack
from cosimo.fmus.native.machine_code import TARGETS, _machine, _optimize, compile_entries, source_of
from cosimo.tests.fmus.native.support import compiled, maker

NAME = "ServoMotor"
FUSED = re.compile(r"^\t(fn?m(?:add|sub)|fml[as])\t", re.M)
PAIRED = """
define double @model_f(double %x, double %y) {
 %p = fmul contract double %x, %y
 %s = fadd contract double %p, %y
 ret double %s
}
"""
pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="runs on Linux")


@pytest.mark.parametrize(("fmi", "targets", "folders"), [
    (2, ["linux64", "win64"], {"linux64": "linux64", "win64": "win64"}),
    (2, ["linux-arm64", "win64"], {"aarch64-linux": "linux-arm64", "linux64": "linux-arm64", "win64": "win64"}),
    (2, ["linux-arm64", "linux64"], {"aarch64-linux": "linux-arm64", "linux64": "linux64"}),
    (3, ["linux-arm64", "linux64"], {"aarch64-linux": "linux-arm64", "x86_64-linux": "linux64"}),
    (3, ["linux-arm64"], {"aarch64-linux": "linux-arm64"}),
    (2, ["macos-arm64"], {"aarch64-darwin": "macos-arm64", "darwin64": "macos-arm64"}),
    (2, ["macos-arm64", "macos-x64"], {"aarch64-darwin": "macos-arm64", "darwin64": "macos-x64"}),
    (3, ["macos-arm64", "macos-x64", "wasm32"],
     {"aarch64-darwin": "macos-arm64", "x86_64-darwin": "macos-x64", "wasm32-unknown": "wasm32"}),
])  # fmt: skip
def test_each_library_lies_where_hosts_look_for_it(fmi, targets, folders, tmp_path):
    found = replace(compiled(NAME), binaries={target: target.encode() for target in targets})
    with zipfile.ZipFile(pack(found, tmp_path, fmi)) as file:
        members = {m.split("/")[1]: (m, file.read(m).decode()) for m in file.namelist() if m.startswith("binaries/")}
    assert {folder: content for folder, (_, content) in members.items()} == folders
    assert {member for member, _ in members.values()} == {f"binaries/{f}/{NAME}{TARGETS[t].suffix}" for f, t in folders.items()}


def assembly(text, target):
    import llvmlite.binding as llvm

    module = llvm.parse_assembly(text)
    machine = _machine(TARGETS[target])
    _optimize(module, TARGETS[target], machine)
    return machine.emit_assembly(module)


@pytest.mark.parametrize("name", [NAME, *(pytest.param(n, marks=pytest.mark.full) for n in ("RovHull", "Catenary", "BeamRotor"))])
def test_products_and_sums_are_not_fused_for_arm(name):
    """A fused product has other last digits; the instruction is there where code allows it."""
    _machine(TARGETS["linux-arm64"])
    assert FUSED.search(assembly(PAIRED, "linux-arm64"))
    made = assembly(compile_entries(source_of(initialized(maker(name)()))), "linux-arm64")
    assert "\tfmul\t" in made
    assert FUSED.findall(made) == []


@pytest.mark.full
@pytest.mark.skipif(find_spec("ziglang") is None, reason="needs the compiler of the extra `native`")
def test_a_library_for_arm_is_small_and_reproducible(linked_anew):
    first, second = (library(NAME, maker(NAME), ["linux-arm64"]) for _ in range(2))
    content = first.binaries["linux-arm64"]
    assert content == second.binaries["linux-arm64"]
    assert content[:6] == b"\x7fELF\x02\x01"  # 64 bits, little-endian
    assert int.from_bytes(content[18:20], "little") == 183  # AArch64
    assert len(content) < 1_000_000
    needed = set(re.findall(rb"[\w.+-]+\.so[.\d]*", content)) - {f"{NAME}.so".encode()}
    assert needed <= {b"libc.so.6", b"libm.so.6", b"ld-linux-aarch64.so.1"}, needed
    assert first.token == compiled(NAME).token  # one model for all targets


@pytest.mark.full
@pytest.mark.skipif(find_spec("ziglang") is None, reason="needs the compiler of the extra `native`")
@pytest.mark.parametrize(("target", "processor"), [("macos-arm64", 0x0100000C), ("macos-x64", 0x01000007)])
def test_a_library_for_macos_is_built_and_called_never_run(target, processor, tmp_path, linked_anew):
    first, second = (library(NAME, maker(NAME), [target]) for _ in range(2))
    content = first.binaries[target]
    assert content == second.binaries[target]
    assert content[:8] == struct.pack("<2I", 0xFEEDFACF, processor)
    assert set(re.findall(rb"/[\w/.]+\.dylib", content)) == {b"/usr/lib/libSystem.B.dylib"}
    with zipfile.ZipFile(pack(first, tmp_path, 3)) as file:
        assert "built and never run" in file.read("documentation/index.html").decode()
