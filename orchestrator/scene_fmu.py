"""A scene as one FMU without Python: the blocks of its units and of its master in one block, and the loop beside their kernels.

The cells of the block: the time, the macro steps taken, the start, the step that was asked for, s; then the block of each unit, and
last that of the master. `fmus/native/runtime/scene.c` calls the same kernels that a run in process calls, so that the numbers are
bit-identical. Addresses in the block are placed when an instance begins (`Place`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..components.core.block import CELL
from ..components.core.contract import KernelComponent
from ..components.core.errors import BadInput
from ..fmus.interface import interface
from ..fmus.native.build import SOURCES, Library, assembled, compiler, pack
from ..fmus.native.instance import Model, Places, image_of, reasons_of
from ..fmus.native.machine_code import Source, compile_entries, source_of
from ..fmus.native.variables import NativeVariable, component_variable, with_sizes
from .engine.algorithms import Master, master_of
from .engine.algorithms.initial_kernels import RUNAWAY
from .engine.algorithms.memory import KERNELS
from .engine.algorithms.node import Node
from .engine.algorithms.records import NOT_CONVERGED
from .open_units import open_units, read_in_every_step
from .scene.scene import Scene
from .units.call_names import FAILED, IN_MEMORY
from .units.component import ComponentSimulator

HEAD = 4  # cells before the first unit
PER_UNIT = 1000  # see scene.h
EXACT = 2**53  # whole numbers up to this are doubles
NO_UNIT = -1  # in the request: no call has failed
REQUEST = (
    "first",
    "last",
    "steps",
    "times",
    "begin",
    "whole",
    "rows",
    "sampled_count",
    "unit",
    "status",
)  # in the order of scene.h
HOST = (
    "This FMU needs no Python. It holds a scene: the components above, and the master algorithm that couples them. "
    "Effects and structural parameters are constants, fixed when it was built; the other parameters can be set before the run. "
    "A communication step is a whole multiple of the macro step, which the default experiment names; inputs are held over it."
)


@dataclass(frozen=True)
class PlacedUnit:
    """A unit of a scene: its first cell in the block, and the number of the layout whose entries it has."""

    name: str
    component: KernelComponent
    node: Node
    first: int
    layout: int


def refuse_what_needs_python(scene: Scene) -> None:
    """`BadInput` for a scene of which something is no kernel, with the names of all that is not."""
    master = scene.master
    reasons = [f"{name} (an FMU)" for name, unit in scene.units.items() if not unit.component]
    reasons += [f"{name} (in a process of its own)" for name, unit in scene.units.items() if unit.isolation != "none"]
    reasons += [f"{contact.name} (a contact)" for contact in scene.contacts]
    reasons += ["step control"] * (master.control is not None) + ["faults"] * bool(scene.faults)
    reasons += ["events of units"] * bool(scene.coupling.events) + ["texts between units"] * bool(scene.coupling.texts)
    reasons += ["the correction of energy"] * bool(master.energy_correction)
    if reasons:
        raise _refusal(scene, ", ".join(reasons))


def _refusal(scene: Scene, actual: str) -> BadInput:
    return BadInput(
        f"build {scene.name} --native",
        actual,
        "a scene of components whose macro step is kernels alone (Jacobi or Gauss-Seidel, no algebraic loop)",
        "Build its units one by one with --scene, or write the scene with cosimo ssp.",
    )


def scene_library(scene: Scene, targets: Iterable[str]) -> Library:
    """Compile a scene for all targets; `BadInput` where something of it is no kernel, or no compiler is found."""
    compilers = {target: compiler(target) for target in targets}
    refuse_what_needs_python(scene)
    with ExitStack() as stack:
        simulators = open_units(scene, stack, True)
        master = master_of(scene, simulators, scene.coupling, read_in_every_step(scene))
        if not master.in_batches:
            raise _refusal(scene, f"the algorithm {scene.master.algorithm!r}, or an algebraic loop")
        units, sources = _placed(scene, master)
        records = master.records
        sources.append(Source(scene.name, "master", records.block, KERNELS, (records.memory,)))
        variables = with_sizes(list(_variables(scene, units)))
        held = _model(scene, master, units)
        step = scene.master.step
        same = {"canHandleVariableCommunicationStepSize": "true"}
        return assembled(
            re.sub(r"\W", "_", scene.name),
            _described(scene),
            variables,
            held,
            [compile_entries(source) for source in sources],
            compilers,
            abilities={
                2: same | {"canInterpolateInputs": "false", "providesDirectionalDerivative": "false"},
                3: same | {"fixedInternalStepSize": repr(step), "providesDirectionalDerivatives": "false"},
            },
            host=HOST,
            sources=(*SOURCES, "scene.c"),
        )


def build_scene_fmu(scene: Scene, directory: Path, targets: Iterable[str], standards: Iterable[int] = (2,)) -> list[Path]:
    """Write directory/<scene>.fmu (FMI 2) and directory/<scene>.fmi3.fmu (FMI 3), as asked for, and return their paths."""
    library = scene_library(scene, targets)
    return [pack(library, directory, fmi, False, scene.name) for fmi in standards]


def _described(scene: Scene) -> SimpleNamespace:
    """What texts and attributes of the FMU come from, with the names that classes of components have."""
    units = "\n".join(
        f"    {name}: {unit.component}" + (f", {', '.join(unit.effects)}" if unit.effects else "")
        for name, unit in scene.units.items()
    )
    arrows = "\n".join(f"    {arrow}" for arrow in scene.arrows)
    master = f"    {scene.master.algorithm}, macro step {scene.master.step:g} s"
    text = f"{scene.title}\n\nUnits:\n{units}\n\nConnections:\n{arrows}\n\nMaster algorithm:\n{master}"
    return SimpleNamespace(
        title=scene.title,
        __doc__=text,
        default_stop=scene.stop_time,
        default_step=scene.master.step,
        variables={},
        ports={},
        start_inputs=None,
        needs_scipy=False,
    )


def _placed(scene: Scene, master: Master) -> tuple[list[PlacedUnit], list[Source]]:
    """The units in the order of the master's records, and what is compiled: the entries of each layout once."""
    units: list[PlacedUnit] = []
    sources: list[Source] = []
    layouts: dict[Any, int] = {}
    first = HEAD
    for node in master.nodes:
        simulator = node.unit
        assert isinstance(simulator, ComponentSimulator)
        component = simulator.component
        if not isinstance(component, KernelComponent):
            raise _refusal(scene, f"{node.unit.name} (a component in plain Python)")
        assert component.block is not None
        component._prepare()
        key = type(component), tuple(component.block.in_order()), component.on
        if key not in layouts:
            layouts[key] = len(sources)
            sources.append(source_of(component, f"layout{len(sources)}"))
        units.append(PlacedUnit(node.unit.name, component, node, first, layouts[key]))
        first += component.block.cells
    return units, sources


def _variables(scene: Scene, units: Sequence[PlacedUnit]) -> Iterator[NativeVariable]:
    """Parameters, inputs that nothing drives, and recorded outputs, as `unit.variable`."""
    driven = {link.target for link in scene.coupling.links}
    recorded = set(scene.coupling.signals)
    for unit in sorted(units, key=lambda unit: list(scene.units).index(unit.name)):
        component_class: Any = type(unit.component)
        places = Places(unit.component)
        for scalar in interface(component_class):
            variable = component_variable(scalar, unit.component, places)
            end = unit.name, scalar.name
            left_out = variable.role in ("ABSENT", "DERIVATIVE") or end in driven
            if left_out or (variable.role == "OUTPUT" and end not in recorded):
                continue
            renamed = replace(variable.scalar, name=f"{unit.name}.{scalar.name}", feedthrough=())
            yield replace(variable, scalar=renamed, cell=variable.cell + unit.first)


def _model(scene: Scene, master: Master, units: Sequence[PlacedUnit]) -> Model:
    """The block before initialization, and the tables of scene.c."""
    at, block, memory = units[-1].first + units[-1].component.block.cells, master.records.block, master.records.memory  # type: ignore[union-attr]
    image = np.zeros(at + block.cells, dtype=np.uint64)
    given: list[tuple[int, int]] = []
    reasons: list[tuple[int, str, Sequence[int]]] = [
        (1, f"a step of %.9g s; expected a whole multiple of {scene.master.step!r} s, the macro step of the scene", (3,)),
        (2, "an output has grown without bound. Reduce the macro step, or take another master algorithm", ()),
        (
            3,
            "the initial values of units that feed one another did not converge. Give parameters closer to a common equilibrium",
            (),
        ),
    ]
    for k, unit in enumerate(units):
        component, places = unit.component, Places(unit.component)
        image[unit.first : unit.first + places.cells] = image_of(component).view(np.uint64)
        u = unit.first + places.u
        given += [(u, u + component.u.size), (unit.first + places.first_parameter, unit.first + places.saved)]
        for status, text, cells in reasons_of(component):
            reasons.append((PER_UNIT * (k + 1) + status, f"{unit.name}: {text}", [unit.first + cell for cell in cells]))
    master.prepare_initial_signals()
    memory.units["stop"] = np.inf  # the host says where it ends
    places_text, cleared = _places(master, units, at)
    image[at:] = block.memory.view(np.uint64)
    image[cleared] = 0
    request = [at + master.records.place("request", 0, name) for name in REQUEST]
    times = [at + master.records.place("units", k, "time") for k in range(memory.units.size)]
    step = Fraction(repr(scene.master.step))
    written = step.as_integer_ratio() if max(step.as_integer_ratio()) < EXACT else (0, 0)
    numbers = {
        "place_count": len(cleared),
        "time_count": len(times),
        "master": at,
        "signals": at + block.cell("s", "signals"),
        "inverse": at + block.cell("s", "inverse"),
        "signal_count": memory.inverse.size,
    }
    rows = {name: master.rows(which) for name, which in (("step_rows", "step"), ("push_rows", "push"))}
    code = "\n".join(
        [
            '#include "scene.h"',
            *_entries(units),
            f"const Place scene_places[] = {{\n{places_text}\n}};",
            f"const uint32_t scene_times[] = {{{', '.join(map(str, times))}}};",
            f"const uint32_t scene_request[FIELDS] = {{{', '.join(map(str, request))}}};",
            *(f"const uint32_t scene_{name}[2] = {{{first}, {last}}};" for name, (first, last) in rows.items()),
            "const uint32_t " + ", ".join(f"scene_{name} = {value}" for name, value in numbers.items()) + ";",
            f"const double scene_length = {scene.master.step.hex()};",
            f"const int64_t scene_numerator = {written[0]}, scene_denominator = {written[1]};",
            f"const int64_t scene_failed = {FAILED}, scene_none = {NO_UNIT}, scene_no_values = {NOT_CONVERGED};",
            f"const double scene_growth = {RUNAWAY!r};",
        ]
    )
    return Model(image, reasons, given, image.size, code=code)


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
        places, component, block = Places(unit.component), unit.component, unit.component.block
        assert block is not None
        left = [(places.u, places.u + component.u.size), (places.first_parameter, places.saved)]
        follows = sorted(ends for name in type(component).kept for ends in block.ranges(name))
        if follows and follows[0][0] != block.cell("s", type(component).kept[0]):
            follows = []  # the cell that says so has to be the first
        for name, ranges in (("left", left), ("follows", follows)):
            yield f"static const uint32_t {name}_{k}[][2] = {{{', '.join(f'{{{a}, {b}}}' for a, b in ranges or [(0, 0)])}}};"
        numbers = unit.first, places.cells, *left[0], len(left), len(follows)
        functions = f"layout{unit.layout}_initialize, layout{unit.layout}_outputs"
        yield f"static const Unit unit_{k} = {{{', '.join(map(str, numbers))}, left_{k}, follows_{k}, {functions}}};"
        yield f"static int32_t begin_{k}(double t, double h, void *b) {{ (void)h; return scene_begin(t, b, &unit_{k}); }}"


def _places(master: Master, units: Sequence[PlacedUnit], at: int) -> tuple[str, list[int]]:
    """The rows of the table of addresses in scene.c, and the cells that they fill."""
    rows: list[tuple[int, int, str]] = []
    place, memory = master.records.place, master.records.memory
    for k, unit in enumerate(units):
        simulator, component, called = unit.node.unit, unit.component, unit.node.called
        assert component.block is not None
        assert isinstance(simulator, ComponentSimulator)
        memory.units["input_mode"][called], memory.units["row"][called] = IN_MEMORY, component.u.strides[0]
        rows.append((at + place("units", k, "initialize"), 0, f"begin_{k}"))
        rows += [(at + place("units", called, name), 0, f"{name}_{unit.layout}") for name in ("step", "outputs")]
        rows.append((at + place("units", called, "argument"), unit.first, "0"))
        inputs, outputs = simulator.addresses
        first_link = int(memory.units["first_link"][called])
        for i, address in enumerate(inputs):
            rows.append(
                (at + place("links", first_link + i, "at"), unit.first + (address - component.block.address) // CELL, "0")
            )
        for i, address in enumerate(outputs, unit.node.place.start):
            cell = at + master.records.block.cell("s", "outputs_at") + i
            rows.append((cell, unit.first + (address - component.block.address) // CELL, "0"))
    text = ",\n".join(f"{{{cell}, {target}, {function}}}" for cell, target, function in rows)
    return text, [cell for cell, _, _ in rows]
