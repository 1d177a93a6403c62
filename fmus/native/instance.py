"""Where the variables of a component lie in the block of a native FMU, and what an instance begins with.

An instance computes its initial state itself, from inputs and parameters that can be set; structural parameters have the values
of the build.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...components.core.block import ENTRIES
from ...components.core.contract import KernelComponent, filled
from ...components.core.errors import StepFailed, refusal_text
from ...components.core.kernels import REASONS


@dataclass(frozen=True)
class Model:
    """What a library holds beside its functions.

    image: (cells,) uint64, the block before initialization.  reasons: (status, format, cells of the numbers in it).
    given: ranges of cells that the host sets.  saved: cells of a state, from the first on; all of them where `whole`.
    parameters: range of those that the rest follows from.  row: cells from an input to its derivative, 0 where there are none.
    untouched: status of a step that is refused before anything changes; 0: there is none.
    code: further C, with the functions that fill in addresses and remove them where the block holds some.
    """

    image: np.ndarray
    reasons: Sequence[tuple[int, str, Sequence[int]]]
    given: Sequence[tuple[int, int]]
    saved: int
    parameters: tuple[int, int] = (0, 0)
    row: int = 0
    untouched: int = 0
    code: str = "void model_place(int64_t block) { (void)block; }\nvoid model_forget(uint64_t *cells) { (void)cells; }"

    @property
    def whole(self) -> bool:
        """Whether a state is the whole block."""
        return self.saved == self.image.size


def model_of(component: KernelComponent, at: Places) -> Model:
    """What the library of a component holds."""
    parameters = at.first_parameter, at.saved
    given = ((at.u, at.u + component.u.size), parameters)
    return Model(image_of(component).view("uint64"), reasons_of(component), given, at.saved, parameters, len(component.inputs))


class Places:
    """Cells of what an FMU knows of; variables: cell and factor of inputs, their derivatives, and outputs, by name."""

    def __init__(self, component: KernelComponent):
        block, variables = component.block, type(component).variables
        assert block is not None
        self.u, self.y = block.cell("s", "u"), block.cell("s", "y")
        self.cells, self.saved, self.first_parameter = block.cells, block.saved, block.parameters_at
        n = len(component.inputs)
        self.variables = {name: (self.y + i, 1.0) for i, name in enumerate(component.outputs)}
        for row, (form, factor) in enumerate((("{}", 1.0), ("der({})", 1.0), ("der({},2)", 0.5))):
            self.variables |= {form.format(name): (self.u + row * n + i, factor) for i, name in enumerate(component.inputs)}
        self.settable = {name: component.cell_of(name) for name in component.parameters if not variables[name].structural}


def image_of(component: KernelComponent) -> np.ndarray:
    """The block before initialization, (cells,): start values of inputs, parameters, and tables that the layout gives."""
    block = component._prepare()
    block.begin_anew()
    cells = block.memory.copy()
    cells[block.addresses_at : block.addresses_at + len(ENTRIES)] = 0.0
    cells[block.cell("s", "y") : block.cell("s", "x")] = 0.0
    return cells


def reasons_of(component: KernelComponent) -> list[tuple[int, str, list[int]]]:
    """(status, format of a message, cells of the numbers in it) of all that the entries may return."""
    rows: list[tuple[int, str, list[int]]] = []
    component.left_range = str  # type: ignore[method-assign] # the values of a run are not known at its build
    for status in REASONS:
        try:
            component._check(status)
        except StepFailed as failure:
            text = failure.reason + (f". {failure.remedy}" if failure.remedy else "")
            rows.append((status, text.replace("%", "%%"), []))
    del component.left_range
    return rows + _refusals_of(component)


def _refusals_of(component: KernelComponent) -> list[tuple[int, str, list[int]]]:
    """(status, format of a message, cells of the numbers in it) of what `initialize` refuses."""
    block = component.block
    assert block is not None
    rows = []
    for status, refusal in type(component).refusals.items():
        cells: list[int] = []

        def value(name: str, cells: list[int] = cells) -> str:
            variable = type(component).variables.get(name)
            if isinstance(text := getattr(component, name, None), str):
                return text.replace("%", "%%")
            if variable is not None and variable.structural:
                return str(component.parameters[name]).replace("%", "%%")
            if variable is None:
                array, _, index = name.partition("[")
                cells.append(block.cell("s", array) + int(index.rstrip("]") or 0))
            elif name in component.inputs:
                cells.append(block.cell("s", "u") + component.inputs.index(name))
            elif name in component.parameters:
                cells.append(component.cell_of(name))
            else:
                raise KeyError(name)
            return "%.6g"

        actual, expected, remedy = (text.replace("%", "%%") for text in refusal)
        try:
            text = filled(refusal_text(actual, expected, remedy), value)
        except KeyError:  # it names what belongs to an effect that is off
            continue
        rows.append((status, text, cells))
    return rows
