"""What the library of a scene holds beside compiled kernels: the block before initialization, and tables of C.

`fmus/native/runtime/scene.c` calls the same kernels that a run in process calls, so that the numbers are bit-identical. Addresses in
the block are placed when an instance begins (`Place`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import inf

import numpy as np

from ...components.core.errors import BadInput
from ...fmus.native.instance import Model, Places, reasons_of
from ..engine.algorithms.initial_kernels import RUNAWAY
from ..engine.algorithms.memory import OF_FAULTS
from ..engine.algorithms.records import NOT_CONVERGED
from ..engine.stepping.discontinuities import between_steps, jump_times
from ..engine.stepping.faults import acts_from_start, changes_of
from ..scene.scene import Scene
from ..units.call_names import FAILED
from .layout import HEAD, Layout, PlacedUnit

PER_UNIT = 1000  # statuses of unit k: PER_UNIT * (k + 1) + its own
STATUSES = {"not_a_multiple": 1, "grown": 2, "not_converged": 3}  # of the model
EXACT = 2**53  # whole numbers up to this are doubles
NO_UNIT = -1  # in the request: no call has failed
REQUEST = (
    "first",
    "last",
    "steps",
    "times",
    "whole",
    "updated",
    "rows",
    "sampled_count",
    "unit",
    "status",
)  # what scene.c writes


# macro steps taken -> what happens behind them: faults that begin or end, and which of both; nothing of these where signals jump
Changes = Mapping[int, Sequence[tuple[int, int]]]


def fault_changes(scene: Scene) -> Changes:
    """When faults begin and end; `BadInput` for an instant at which no macro step ends."""
    step, start = Fraction(repr(scene.master.step)), Fraction(repr(scene.start_time))
    for i, fault in enumerate(scene.faults, 1):
        for key, time in (("begin", fault.begin), ("end", fault.end)):
            if time is not None and time > scene.start_time and (Fraction(repr(time)) - start) % step:
                raise BadInput(
                    f"build {scene.name} --native: faults[{i}].{key}",
                    f"{time!r} s",
                    f"a whole multiple of the macro step, {step!s} s{' behind the start' if start else ''}",
                )
    early = [i for i, fault in enumerate(scene.faults) if acts_from_start(fault, scene.start_time)]
    changes = changes_of(scene.faults, early, lambda time: int((Fraction(repr(time)) - start) / step))
    times = jump_times(scene, inf)
    repeated = [name for name, kind in scene.kinds.items() if kind.repeats]
    if times and repeated:
        where = f"build {scene.name} --native: units.{repeated[0]}"
        raise BadInput(where, "signals that jump, beside a table without end", "tables that are not repeated, or do not jump")
    if between := between_steps(scene, times):
        where, expected = f"build {scene.name} --native", f"whole multiples of the macro step, {scene.master.step!r} s"
        raise BadInput(where, f"signals that jump at {between[0]:.9g} s", expected, "Change the step, or the table.")
    return changes | {round((t - scene.start_time) / scene.master.step): () for t in times} | changes


def model_of(scene: Scene, layout: Layout, changes: Changes) -> Model:
    """The block before initialization, and the tables of scene.c; changes: by faults."""
    units = layout.units
    layout.master.records.memory.units["stop"] = np.inf  # the host says where it ends
    image, addresses = layout.image()
    given: list[tuple[int, int]] = []
    multiple = f"a step of %.9g s, expected a whole multiple of {scene.master.step!r} s, the macro step of the scene"
    reasons: list[tuple[int, str, Sequence[int]]] = [
        (STATUSES["not_a_multiple"], multiple, (HEAD.index("asked"),)),
        (STATUSES["grown"], "an output has grown without bound. Reduce the macro step, or take another master algorithm", ()),
        (
            STATUSES["not_converged"],
            "the initial values of units that feed one another did not converge. Give parameters closer to a common equilibrium",
            (),
        ),
    ]
    for k, unit in enumerate(units):
        component = unit.component
        given += [(unit.first + first, unit.first + end) for first, end in unit.left]
        for status, text, cells in reasons_of(component):
            reasons.append((PER_UNIT * (k + 1) + status, f"{unit.name}: {text}", [unit.first + cell for cell in cells]))
    code = code_of(scene, layout, changes, addresses, _entries(units), _sample(layout))
    return Model(image, reasons, given, image.size, untouched=STATUSES["not_a_multiple"], code=code)


def code_of(
    scene: Scene,
    layout: Layout,
    changes: Changes,
    addresses: Iterable[tuple[int, int, str]],
    entries: Iterable[str],
    sample: Iterable[str],
) -> str:
    """The tables of scene.c, in C.

    addresses: as of `Layout.image`.  entries: the functions among them.  sample: what happens behind each macro step.
    """
    master, at = layout.master, layout.at
    block, memory = master.records.block, master.records.memory
    places = [f"{{{cell}, {target}, {function or 0}}}" for cell, target, function in addresses]
    times = [at + master.records.place("units", k, "time") for k in range(memory.units.size)]
    step = Fraction(repr(scene.master.step))
    written = step.as_integer_ratio() if max(step.as_integer_ratio()) < EXACT else (0, 0)
    rows = {f"{name}_rows": master.rows(name) for name in ("step", "push", "follow", "jump")}
    nothing = at + master.records.place("request", 0, "updated")  # which is 0 at a change
    changed = [
        f"{{{steps}, {cell}, {change}}}"
        for steps, several in sorted(changes.items())
        for cell, change in [(at + master.records.place("faults", fault, "change"), change) for fault, change in several]
        or [(nothing, 0)]
    ]
    numbers = {
        "place_count": len(places),
        "change_count": len(changed),
        "time_count": len(times),
        "master": at,
        "signals": at + block.cell("s", "signals"),
        "inverse": at + block.cell("s", "inverse"),
        "signal_count": memory.inverse.size,
        **{name: cell for cell, name in enumerate(HEAD)},
        **{f"request_{name}": at + master.records.place("request", 0, name) for name in REQUEST},
    }
    statuses = STATUSES | {"per_unit": PER_UNIT}
    lines = ",\n".join(places)
    return "\n".join(
        [
            '#include "scene.h"',
            *entries,
            f"const Place scene_places[] = {{\n{lines}\n}};",
            f"const uint32_t scene_times[] = {{{', '.join(map(str, times))}}};",
            *(f"const uint32_t scene_{name}[2] = {{{first}, {last}}};" for name, (first, last) in rows.items()),
            "const uint32_t " + ", ".join(f"scene_{name} = {value}" for name, value in numbers.items()) + ";",
            "const int32_t " + ", ".join(f"scene_{name} = {value}" for name, value in statuses.items()) + ";",
            f"double scene_length = {scene.master.step.hex()};",
            f"int64_t scene_numerator = {written[0]}, scene_denominator = {written[1]};",
            f"const int64_t scene_failed = {FAILED}, scene_none = {NO_UNIT}, scene_no_values = {NOT_CONVERGED};",
            f"const double scene_growth = {RUNAWAY!r};",
            f"const Change scene_changes[] = {{{', '.join(changed or ['{0, 0, 0}'])}}};",
            *_at_change(bool(changes)),
            *sample,
        ]
    )


def _at_change(changes: bool) -> Iterator[str]:
    """What lets faults begin and end and signals jump, where the scene has such changes."""
    for name in OF_FAULTS:
        if changes:
            yield f"int32_t master_{name}(double t, double h, int64_t block);"
        yield f"int32_t (*const scene_{name})(double, double, int64_t) = {f'master_{name}' if changes else '0'};"


def _sample(layout: Layout) -> Iterator[str]:
    """What happens behind each macro step and at the start: figures take their samples."""
    taken = ""
    if layout.figures is not None:
        yield "int32_t figures_take_figures(double t, double h, int64_t block);"
        taken = f"figures_take_figures(t, 0.0, (int64_t)(intptr_t)(cells + {layout.figures_at})); "
    yield f"void scene_sample(double t, int64_t *cells) {{ (void)t; (void)cells; {taken}}}"


def _entries(units: Sequence[PlacedUnit]) -> Iterator[str]:
    """Functions of one signature around the compiled entries of each layout, and what initializes each unit."""
    for layout in range(max(unit.layout for unit in units) + 1):
        yield f"int32_t layout{layout}_initialize(double t, int64_t block);"
        yield f"int32_t layout{layout}_step(double t, double h, int64_t block);"
        yield f"int32_t layout{layout}_outputs(double t, int64_t block);"
        yield (
            f"static int32_t step_{layout}(double t, double h, void *b) "
            f"{{ return layout{layout}_step(t, h, (int64_t)(intptr_t)b); }}"
        )
        yield (
            f"static int32_t outputs_{layout}(double t, double h, void *b) "
            f"{{ (void)h; return layout{layout}_outputs(t, (int64_t)(intptr_t)b); }}"
        )
    for k, unit in enumerate(units):
        left, follows = unit.left, unit.follows
        for name, ranges in (("left", left), ("follows", follows)):
            yield f"static const uint32_t {name}_{k}[][2] = {{{', '.join(f'{{{a}, {b}}}' for a, b in ranges or [(0, 0)])}}};"
        numbers = unit.first, Places(unit.component).cells, *left[0], len(left), len(follows)
        functions = f"layout{unit.layout}_initialize, layout{unit.layout}_outputs"
        yield f"static const Unit unit_{k} = {{{', '.join(map(str, numbers))}, left_{k}, follows_{k}, {functions}}};"
        yield f"static int32_t begin_{k}(double t, double h, void *b) {{ (void)h; return scene_begin(t, b, &unit_{k}); }}"
