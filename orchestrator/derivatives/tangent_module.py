"""A run of a scene with tangents as a library without Python: the derivatives of all that it holds by one number of its start.

`fmus/native/runtime/slope.c` starts and steps it, with what of `scene.c` starts and steps the scene itself. It begins with the block of
such an instance, where parameters have their values: its cells are the same.
"""

from __future__ import annotations

from ...components.core.errors import BadInput
from ...fmus.derivatives.grammar import Unsupported
from ...fmus.derivatives.tangents import derivative_of
from ...fmus.native.build import compiler, linked
from ...fmus.native.machine_code import tangents_of
from ..engine.algorithms.initial_kernels import SWEEPS
from ..engine.algorithms.records import ABOUT_ZERO, STALLED
from ..engine.stepping.discontinuities import jump_times
from ..scene.scene import Scene
from ..scene_fmu import laid_out
from ..scene_fmu.layout import Layout
from ..scene_fmu.tables import code_of
from .tangent_block import STANDS
from .tangent_code import texts_of_master, texts_of_units

SOURCES = ("slope.c", "scene.c")


def tangent_module(scene: Scene, target: str) -> tuple[bytes, dict[str, int]]:
    """The library for a target, and the numbers that a derivative can be taken by, "unit.name" -> cell.

    Raises `BadInput` for a scene that has no derivatives.
    """
    command, where = compiler(target), f"derivatives of {scene.name}"
    if scene.faults or jump_times(scene):
        raise BadInput(where, "faults, or signals that jump", "a scene without")
    with laid_out(scene) as (layout, _):
        try:
            codes = [tangents_of(text, target) for text in texts_of_units(layout)]
            codes += [tangents_of(text, target, ties=False) for text in texts_of_master(layout)]
        except Unsupported as error:
            raise BadInput(where, str(error), "instructions that have a derivative") from None
        binary = linked("slope", target, command, _tables(scene, layout), codes, SOURCES)
        return binary, {name: cell for unit in layout.units for name, cell in unit.settable.items()}


def _tables(scene: Scene, layout: Layout) -> str:
    """The tables of slope.c, and those of scene.c, but that derivatives stand where a scene has functions."""
    _, addresses = layout.image()
    functions = dict.fromkeys(function for _, _, function in addresses if function)
    named = [(cell, target, function and f"(Entry)d_{function}") for cell, target, function in addresses]
    nothing = "void scene_sample(double t, int64_t *cells) { (void)t; (void)cells; }"
    records = layout.master.records
    groups, answers, links = records.memory.groups, records.memory.answers, records.memory.links
    circular = (groups["last"] - groups["first"] > 1).any()
    first = layout.at + records.block.cell("s", "signals")
    changes = [layout.at + records.place("links", k, "change") for k in range(links.size)]
    compared = [(first + int(a["cell"]), float(a["least"])) for a in answers] if circular else []
    return "\n".join(
        [
            '#include "slope.h"',
            code_of(scene, layout, {}, named, map(_declared, functions), [nothing]),
            f"const uint32_t slope_changes[] = {{{', '.join(map(str, changes or [0]))}}};",
            f"const Compared slope_compared[] = {{{', '.join(f'{{{c}, {least!r}}}' for c, least in compared or [(0, 0.0)])}}};",
            f"const uint32_t slope_cells = {layout.cells}, slope_sweeps = {SWEEPS};",
            f"const uint32_t slope_change_count = {len(changes)}, slope_compared_count = {len(compared)};",
            f"const double slope_stands = {STANDS!r}, slope_about_zero = {ABOUT_ZERO!r}, slope_stalled = {STALLED!r};",
        ]
    )


def _declared(function: str) -> str:
    symbol = derivative_of(f"@{function}")[1:]
    return f"int32_t d_{function}(double, double, double, double, void *, int64_t, int64_t, int64_t) __asm__({symbol});"
