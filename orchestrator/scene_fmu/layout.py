"""Where everything of a scene lies in the one block of its FMU.

The cells of the block: the time, the macro steps taken, the start, the step that was asked for, s; then the blocks of the units, of
the master, and of the figures where the scene names some.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...components.core.block import Block
from ...components.core.contract import KernelComponent
from ...fmus.native.machine_code import Source, source_of
from ..engine.algorithms import Master
from ..engine.algorithms import figures as running
from ..engine.algorithms.memory import KERNELS, OF_FAULTS
from ..engine.algorithms.node import Node
from ..engine.coupling import Endpoint
from ..scene.scene import Scene

HEAD = ("time", "steps", "start", "asked")  # cells before the first unit


@dataclass(frozen=True)
class PlacedUnit:
    """A unit of a scene: its first cell in the block, and the number of the layout whose entries it has."""

    name: str
    component: KernelComponent
    node: Node
    first: int
    layout: int


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
            component: KernelComponent = node.unit.component  # type: ignore[attr-defined]
            component._prepare()
            assert component.block is not None
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
            figures = running.figures_of(len(signals), scene.counts_from)
            block = Block(figures, (), (), dict.fromkeys(running.KERNELS, ("double %t", "double %h")))
            sources.append(Source(scene.name, "figures", block, running.KERNELS, (block.s,)))
        return cls(units, master, first, block, first + records.block.cells, signals, sources)

    @property
    def cells(self) -> int:
        """Of the whole block."""
        return self.figures_at + (self.figures.cells if self.figures else 0)

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
