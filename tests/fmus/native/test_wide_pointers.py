"""Text for 64-bit machines on one with pointers of 32 bits: structures in memory keep their layout, or the text is refused."""

import re
import subprocess
import sys
from importlib.util import find_spec

import pytest
from cosimo.fmus.native.machine_code import TARGETS, object_code
from cosimo.fmus.native.wide_pointers import PointerInMemory, widened
from cosimo.tests.fmus.native.web_assembly import NODE

# what is left of a tuple of arrays that is indexed in a loop: offsets in bytes beside a structure, a copy of its length
ON_THE_STACK = """
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
define double @f(i64 %first, i64 %second, i64 %k) noinline {
 %beside = alloca [2 x double], align 8
 %pair = alloca { { ptr, i64 }, { ptr, i64 } }, align 8
 %copy = alloca [2 x { ptr, i64 }], align 8
 store volatile double 1.0e3, ptr %beside, align 8
 %one = inttoptr i64 %first to ptr
 %two = inttoptr i64 %second to ptr
 store ptr %one, ptr %pair, align 8
 %there = getelementptr inbounds i8, ptr %pair, i64 16
 store ptr %two, ptr %there, align 8
 %size = getelementptr inbounds { { ptr, i64 }, { ptr, i64 } }, ptr %pair, i64 0, i32 1, i32 1
 store volatile i64 7, ptr %size, align 8
 call void @llvm.memcpy.p0.p0.i64(ptr %copy, ptr %pair, i64 32, i1 false)
 %place = getelementptr inbounds { ptr, i64 }, ptr %copy, i64 %k
 %taken = load ptr, ptr %place, align 8
 %value = load double, ptr %taken, align 8
 %kept = load volatile double, ptr %beside, align 8
 %last = getelementptr inbounds i8, ptr %copy, i64 24
 %seven = load i64, ptr %last, align 8
 %number = sitofp i64 %seven to double
 %sum = fadd double %value, %kept
 %all = fadd double %sum, %number
 ret double %all
}
@cells = global [2 x double] [double 0.5, double 0.25]
define double @g(i32 %k) {
 %a = ptrtoint ptr @cells to i64
 %b = add i64 %a, 8
 %w = sext i32 %k to i64
 %r = call double @f(i64 %a, i64 %b, i64 %w)
 ret double %r
}
"""


@pytest.mark.skipif(not NODE or find_spec("ziglang") is None, reason="needs Node and the compiler of the extra `native`")
def test_offsets_and_lengths_of_64_bits_fit_what_is_allocated(tmp_path):
    (tmp_path / "code.o").write_bytes(*object_code(ON_THE_STACK, "wasm32"))
    command = [sys.executable, "-m", "ziglang", "cc", "-target", TARGETS["wasm32"].zig, "-nostdlib", "-Wl,--no-entry,--export=g"]
    subprocess.run([*command, "code.o", "-o", "code.wasm"], cwd=tmp_path, check=True)
    script = (
        "const m = new WebAssembly.Module(require('fs').readFileSync('code.wasm'));"
        "const x = new WebAssembly.Instance(m).exports; console.log(x.g(0), x.g(1));"
    )
    done = subprocess.run([NODE, "-e", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1007.5", "1007.25"]


def test_no_pointer_is_left_in_memory():
    kinds = re.findall(
        r"(?:alloca|load|getelementptr|store)(?: inbounds| volatile)* (\{.*\}|\[.*?\]|\w+)[, ]", widened(ON_THE_STACK)
    )
    assert len(kinds) == 15
    assert not any("ptr" in kind for kind in kinds), kinds


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("%a = alloca ptr, i64 %n, align 8", "%a = alloca i64, i64 %n, align 8"),
        ("%a = load ptr, ptr %p, align 8, !nonnull !0", '%"wide 0" = load i64, ptr %p, align 8\n%a = inttoptr i64 %"wide 0" to ptr'),
        (
            "  %a = load <2 x ptr>, ptr %p, align 8",
            '  %"wide 0" = load <2 x i64>, ptr %p, align 8\n  %a = inttoptr <2 x i64> %"wide 0" to <2 x ptr>',
        ),
        (
            "store ptr getelementptr inbounds (i8, ptr @x, i64 8), ptr %p, align 8",
            '%"wide 0" = ptrtoint ptr getelementptr inbounds (i8, ptr @x, i64 8) to i64\nstore i64 %"wide 0", ptr %p, align 8',
        ),
        ("%a = getelementptr inbounds nuw [2 x ptr], ptr %p, i64 %k", "%a = getelementptr inbounds nuw [2 x i64], ptr %p, i64 %k"),
        ("store i8 %x, ptr getelementptr (ptr, ptr @y, i64 1), align 8", "store i8 %x, ptr getelementptr (i64, ptr @y, i64 1), align 8"),
        ("%a = load { double, i64 }, ptr %p, align 8", "%a = load { double, i64 }, ptr %p, align 8"),
        ("%a = call double @f(ptr %p)", "%a = call double @f(ptr %p)"),
    ],
)  # fmt: skip
def test_each_instruction(text, expected):
    assert widened(text) == expected + "\n"


@pytest.mark.parametrize(
    "text",
    [
        "%a = load { ptr, i64 }, ptr %p, align 8",
        "store [2 x ptr] %a, ptr %p, align 8",
        "call void @f(ptr byval({ ptr, i64 }) %p)",
        "%a = call <4 x ptr> @llvm.masked.load.v4p0.p0(ptr %p, <4 x i1> %m, <4 x ptr> poison)",
        "%pair = type { ptr, i64 }",
        "@table = internal constant [2 x ptr] [ptr @f, ptr @g]\n%a = getelementptr i8, ptr @table, i64 8",
        "@table = internal constant [2 x ptr] [ptr @f, ptr @g]\n%a = load i64, ptr @table, align 8",
        "@table = internal global [2 x ptr] zeroinitializer\nstore double %x, ptr @table, align 8",
    ],
)
def test_what_is_not_known_is_refused(text):
    with pytest.raises(PointerInMemory):
        widened(text)


def test_the_address_of_an_exception_may_be_handed_back():
    text = "@error = internal constant { ptr, i32 } { ptr @f, i32 1 }\nstore ptr @error, ptr %raised, align 8\n"
    assert 'ptrtoint ptr @error to i64\nstore i64 %"wide 1", ptr %raised' in widened(text)
