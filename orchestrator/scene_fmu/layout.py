"""Where everything of a scene lies in the one block of its FMU.

The cells of the block: the time, the macro steps taken, the start, the step that was asked for, s; then the blocks of the units, of
the master, and of the figures where the scene names some.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...components.core.block import CELL, LINE, Block
from ...components.core.contract import KernelComponent
from ...fmus.native.instance import Places, image_of
from ...fmus.native.machine_code import Source, source_of
from ..engine.algorithms import Master
from ..engine.algorithms import running_statistics as running
from ..engine.algorithms.memory import KERNELS, OF_FAULTS
from ..engine.algorithms.node import Node
from ..engine.coupling import Endpoint
from ..scene.scene import Scene
from ..units.call_names import IN_MEMORY
from ..units.component import ComponentSimulator

HEAD = ("time", "steps", "start", "asked")  # cells before the first unit


def in_python(scene: Scene) -> list[str]:
    """What of a scene is no kernel, as its settings say."""
    master = scene.master
    reasons = [f"{name} ({kind.outside})" for name, kind in scene.kinds.items() if kind.outside]
    reasons += [f"{contact.name} (a contact)" for contact in scene.contacts]
    reasons += ["step control"] * (master.control is not None)
    reasons += ["events of units"] * bool(scene.coupling.events) + ["texts between units"] * bool(scene.coupling.texts)
    return reasons + ["the correction of energy"] * bool(master.energy_correction)


def stepped_in_python(scene: Scene, master: Master) -> list[str]:
    """What of an open scene is no kernel."""
    reasons = [] if master.in_batches else [f"the algorithm {scene.master.algorithm!r}, or an algebraic loop"]
    units = [node.unit for node in master.nodes]
    return reasons + [f"{unit.name} (a component in plain Python)" for unit in units if unit.kernels is None]


@dataclass(frozen=True)
class PlacedUnit:
    """A unit of a scene: its first cell in the block, and the number of the layout whose entries it has."""

    name: str
    component: KernelComponent
    node: Node
    first: int
    layout: int

    @property
    def left(self) -> list[tuple[int, int]]:
        """Ranges of its cells that an initialization leaves: inputs, parameters."""
        places = Places(self.component)
        return [(places.u, places.u + self.component.u.size), (places.first_parameter, places.saved)]

    @property
    def settable(self) -> dict[str, int]:
        """Real parameters in use that are not structural, and inputs that nothing drives: "unit.name" -> cell in the block."""
        component, places = self.component, Places(self.component)
        driven = {link.target[1] for link in self.node.links}
        inputs = {name: places.u + k for k, name in enumerate(component.inputs) if name not in driven}
        variables = type(component).variables
        numbers = {n: cell for n, cell in places.settable.items() if isinstance(component.parameters[n], float)}
        unused = component.unused(list(numbers))
        known = {n: c for n, c in (numbers | inputs).items() if n not in unused and not variables[n].structural}
        return {f"{self.name}.{n}": self.first + c for n, c in known.items()}

    @property
    def follows(self) -> list[tuple[int, int]]:
        """Ranges that follow from parameters alone; what is other than 0 in the first cell of the first says that they are there."""
        block, kept = self.component.block, type(self.component).kept
        assert block is not None
        ranges = sorted(ends for name in kept for ends in block.ranges(name))
        return ranges if ranges and ranges[0][0] == block.cell("s", kept[0]) else []


@dataclass(frozen=True)
class Layout:
    """Units in the order of the master's records, the cells where master and figures begin, and what is compiled.

    signals: whose figures are computed; sources: the entries of each layout of units once, of the master, of the figures.
    """

    units: Sequence[PlacedUnit]
    master: Master
    at: int
    figures: Block | None
    figures_at: int
    signals: Sequence[Endpoint]
    sources: Sequence[Source]

    @classmethod
    def of(cls, scene: Scene, master: Master, changes: bool) -> Layout:
        """The layout of a scene whose units are components of kernels; changes: whether faults begin or end, or signals jump."""
        units: list[PlacedUnit] = []
        sources: list[Source] = []
        layouts: dict[Any, int] = {}
        first = len(HEAD)
        for node in master.nodes:
            component = node.unit.kernels
            assert component is not None
            component._prepare()
            assert component.block is not None
            first += -first % LINE  # as the block's own arrays are placed
            key = type(component), tuple(component.block.in_order()), component.on
            if key not in layouts:
                layouts[key] = len(sources)
                sources.append(source_of(component, f"layout{len(sources)}"))
            units.append(PlacedUnit(node.unit.name, component, node, first, layouts[key]))
            first += component.block.cells
        records = master.records
        kernels = KERNELS | (OF_FAULTS if changes else {})
        sources.append(Source(scene.name, "master", records.block, kernels, (records.memory,)))
        signals = tuple(dict.fromkeys(shown.end for shown in scene.coupling.shown.values() if shown.kind))
        block = None
        if signals:
            figures = running.statistics_of(len(signals), scene.counts_from)
            block = Block(figures, (), (), dict.fromkeys(running.KERNELS, ("double %t", "double %h")))
            sources.append(Source(scene.name, "figures", block, running.KERNELS, (block.s,)))
        return cls(units, master, first, block, first + records.block.cells, signals, sources)

    @property
    def cells(self) -> int:
        """Of the whole block."""
        return self.figures_at + (self.figures.cells if self.figures else 0)

    def image(self) -> tuple[np.ndarray, list[tuple[int, int, str]]]:
        """The block before initialization, (cells,) uint64, and the addresses that belong into it, which are 0 there.

        An address is (its cell, the cell that it is the address of, the name of the function that it is the address of instead).
        """
        image = np.zeros(self.cells, dtype=np.uint64)
        for unit in self.units:
            image[unit.first : unit.first + Places(unit.component).cells] = image_of(unit.component).view(np.uint64)
        block = self.master.records.block
        self.master.prepare()
        addresses = self._addresses()
        image[self.at : self.at + block.cells] = block.memory.view(np.uint64)
        if self.figures is not None:
            image[self.figures_at :] = self.figures.memory.view(np.uint64)
        image[[cell for cell, _, _ in addresses]] = 0
        return image, addresses

    def _addresses(self) -> list[tuple[int, int, str]]:
        rows: list[tuple[int, int, str]] = []
        at, place, memory = self.at, self.master.records.place, self.master.records.memory
        for k, unit in enumerate(self.units):
            simulator, component, called = unit.node.unit, unit.component, unit.node.called
            assert component.block is not None
            assert isinstance(simulator, ComponentSimulator)
            memory.units["input_mode"][called], memory.units["row"][called] = IN_MEMORY, component.u.strides[0]
            rows.append((at + place("units", k, "initialize"), 0, f"begin_{k}"))
            rows += [(at + place("units", called, name), 0, f"{name}_{unit.layout}") for name in ("step", "outputs")]
            rows.append((at + place("units", called, "argument"), unit.first, ""))
            inputs, outputs = simulator.addresses
            first_link = int(memory.units["first_link"][called])
            cells = [at + place("links", first_link + i, "at") for i in range(len(inputs))]
            first_output = at + self.master.records.block.cell("s", "outputs_at") + unit.node.place.start
            cells += range(first_output, first_output + len(outputs))
            targets = [unit.first + (address - component.block.address) // CELL for address in (*inputs, *outputs)]
            rows += [(cell, target, "") for cell, target in zip(cells, targets, strict=True)]
        if self.figures is not None:
            first = self.figures_at + self.figures.cell("s", "at")
            rows += [(first + i, self.output(end), "") for i, end in enumerate(self.signals)]
        return rows

    def output(self, end: Endpoint) -> int:
        """The cell of an output."""
        unit = next(unit for unit in self.units if unit.name == end[0])
        assert unit.component.block is not None
        return unit.first + unit.component.block.cell("s", "y") + unit.component.outputs.index(end[1])

    def figure(self, end: Endpoint, kind: str) -> int:
        """The cell of a figure."""
        assert self.figures is not None
        columns = self.figures.s.values.shape[1]
        return self.figures_at + self.figures.cell("s", "values") + columns * self.signals.index(end) + running.COLUMNS[kind]
