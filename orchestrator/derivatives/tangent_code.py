"""Machine code of a tangent block: derivatives of the entries of its units and of the master's program, and what calls them by address."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...components.core.block import CELL
from ...fmus.derivatives.compiled import Compiled
from ...fmus.native.machine_code import compile_apart, compile_entries
from ..scene_fmu.layout import Layout, PlacedUnit


def compiled(layout: Layout, width: int) -> Compiled:
    """Of a block with such a layout, in `width` directions at once; raises `Unsupported`."""
    return Compiled(texts_of_units(layout), width, without_ties=texts_of_master(layout))


def texts_of_master(layout: Layout) -> list[str]:
    """What the master calls, in LLVM's language, for derivatives without ties: it looks whether numbers stand; that is no kink."""
    return [text for source in layout.sources if source.prefix == "master" for text in compile_apart(source)]


def texts_of_units(layout: Layout) -> Iterator[str]:
    """What is called of units, in LLVM's language."""
    for number, source in enumerate(layout.sources):
        if source.prefix not in ("master", "figures"):
            begins = (_begin(k, unit, layout.cells) for k, unit in enumerate(layout.units) if unit.layout == number)
            yield "\n".join([compile_entries(source), *_adapters(number), *begins])


def _adapters(layout: int) -> Iterator[str]:
    """Functions of one signature around the entries of a layout, which the master calls by address."""
    for entry, times in (("step", "double %t, double %h"), ("outputs", "double %t")):
        yield f"""define i32 @{entry}_{layout}(double %t, double %h, ptr %block) {{
  %address = ptrtoint ptr %block to i64
  %status = call i32 @layout{layout}_{entry}({times}, i64 %address)
  ret i32 %status
}}"""


def _begin(k: int, unit: PlacedUnit, image: int) -> str:
    """What initializes a unit anew, with its present inputs and parameters: else it begins with what stands `image` cells further on."""
    u, inputs = unit.left[0][0], unit.component.u
    size = unit.component.block.cells  # type: ignore[union-attr]
    kept = sorted([*unit.left, *unit.follows])
    starts, ends = [0, *(end for _, end in kept)], [*(first for first, _ in kept), size]
    names = iter(range(10**6))

    def copies(ranges: Sequence[tuple[int, int]]) -> str:
        lines = []
        for first, end in ranges:
            if end > first:
                to, source = f"%to.{next(names)}", f"%from.{next(names)}"
                lines += [
                    f"  {to} = getelementptr i64, ptr %block, i64 {first}",
                    f"  {source} = getelementptr i64, ptr %block, i64 {image + first}",
                    f"  call void @llvm.memcpy.p0.p0.i64(ptr {to}, ptr {source}, i64 {CELL * (end - first)}, i1 false)",
                ]
        return "\n".join(lines)

    flag = unit.follows[0][0] if unit.follows else 0
    slopes = inputs.size - inputs.size // 3
    return f"""define i32 @begin_{k}(double %t, double %h, ptr %block) {{
entry:
{copies(list(zip(starts, ends, strict=True)))}
  %flag.at = getelementptr double, ptr %block, i64 {flag}
  %flag = load double, ptr %flag.at, align 8
  %known = fcmp une double %flag, 0.000000e+00
  br i1 %known, label %ready, label %anew
anew:
{copies(unit.follows)}
  br label %ready
ready:
  %slopes = getelementptr double, ptr %block, i64 {u + inputs.size // 3}
  call void @llvm.memset.p0.i64(ptr %slopes, i8 0, i64 {CELL * slopes}, i1 false)
  store double %t, ptr %block, align 8
  %address = ptrtoint ptr %block to i64
  %failed = call i32 @layout{unit.layout}_initialize(double %t, i64 %address)
  %fine = icmp eq i32 %failed, 0
  br i1 %fine, label %go, label %end
go:
  %status = call i32 @layout{unit.layout}_outputs(double %t, i64 %address)
  ret i32 %status
end:
  ret i32 %failed
}}"""
