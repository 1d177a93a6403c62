"""What the cells of a tangent block are: whose, and their names."""

from __future__ import annotations

import numpy as np

from .tangent_block import TangentBlock


def states(block: TangentBlock) -> np.ndarray:
    """Cells of the states of all units, (n,)."""
    units = [unit for unit in block.layout.units if unit.component.x.size]
    ranges = [(unit.first, ends) for unit in units for ends in unit.component.block.ranges("x")]  # type: ignore[union-attr]
    return np.array([first + k for first, ends in ranges for k in range(*ends)], dtype=np.intp)


def owners(block: TangentBlock, cells: np.ndarray) -> np.ndarray:
    """Of each cell the place of its unit in the layout, or -1 for the master, (n,)."""
    firsts = [unit.first for unit in block.layout.units]
    return np.where(cells >= block.layout.at, -1, np.searchsorted(firsts, cells, side="right") - 1)


def cell_name(block: TangentBlock, cell: int) -> str:
    """Of a cell: "unit.x[3]", "unit.input (before)", "unit.output (held)"."""
    layout, records = block.layout, block.master.records
    k = int(owners(block, np.array([cell]))[0])
    if k >= 0:
        unit = layout.units[k]
        return f"{unit.name}.{unit.component.block.name(cell - unit.first)}"  # type: ignore[union-attr]
    memory = records.memory
    fields = memory.links.dtype.names
    assert fields is not None
    for node in block.master.nodes:
        for first in {int(memory.units["first_link"][one]) for one in (node.index, node.called)}:
            place, field = divmod(cell - block.cell("links", first, "at"), memory.links.dtype.itemsize // 8)
            if 0 <= place < len(node.links):
                return f"{'.'.join(node.links[place].target)} ({fields[field]})"
    signal = cell - int(block.table[0])
    if 0 <= signal < len(block.signals):
        return f"{'.'.join(block.signals[signal])} (held)"
    return f"coupling.{records.block.name(cell - layout.at)}"
