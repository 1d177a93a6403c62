"""What the figures of every system need of a run: samples after the transient, and what was recorded of its units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput
from ...units.component import make

if TYPE_CHECKING:
    from ....components.core.component import Component
    from ...run.results import Result


class RecordedUnit:
    """A unit of a run, its recorded variables by their names, and the units that it is connected with.

    A variable is recorded where the result has a column of it, or of the output that drives it, of which it has the unit of measure.
    """

    def __init__(self, result: Result, name: str):
        self.result, self.name, self.time = result, name, result.time
        self._links = {link.target[1]: link for link in result.scene.coupling.links if link.target[0] == name}
        self._drivers = {variable: link.source for variable, link in self._links.items()}

    def __getitem__(self, variable: str) -> np.ndarray:
        """A recorded variable, (n,); raises `BadInput` where it was not recorded."""
        if not (column := self.column(variable)):
            driver = f" or {self.source(variable)}, which drives it" if variable in self._drivers else ""
            where, missing = f"{self.result.scene.name}: record.signals", f"no {self.name}.{variable}"
            raise BadInput(where, missing, f"{self.name}.{variable}{driver}", "Add it, or leave out [record].")
        values = np.asarray(self.result.columns[column], dtype=float)
        link = None if column == f"{self.name}.{variable}" else self._links[variable]
        if link is None or link.map or (link.factor, link.offset) == (1.0, 0.0):
            return values
        return link.factor * values + link.offset

    def optional(self, variable: str) -> np.ndarray | None:
        """A variable, (n,); None where it was not recorded."""
        return self[variable] if self.column(variable) else None

    def recorded(self, variables: Iterable[str] | Mapping[str, str]) -> dict[str, np.ndarray]:
        """Those of the variables that were recorded, (n,) each, by their names; variables given by other names, by those."""
        names = variables if isinstance(variables, Mapping) else {variable: variable for variable in variables}
        return {name: self[variable] for name, variable in names.items() if self.column(variable)}

    def has(self, *outputs: str) -> bool:
        """Whether the result has columns of all these variables of the unit itself."""
        return all(f"{self.name}.{output}" in self.result.columns for output in outputs)

    def column(self, variable: str) -> str:
        """Name of the column of a variable, its own or that of the output that drives it; "" if neither was recorded."""
        own, driving = f"{self.name}.{variable}", self.source(variable)
        return own if own in self.result.columns else driving if driving in self.result.columns else ""

    def source(self, input_: str) -> str:
        """ "unit.output" that drives an input; "" if nothing does."""
        return ".".join(self._drivers[input_]) if input_ in self._drivers else ""

    def driven_by(self, input_: str) -> RecordedUnit | None:
        """The unit that drives an input; None if nothing does."""
        return RecordedUnit(self.result, self._drivers[input_][0]) if input_ in self._drivers else None

    def driving(self, output: str, input_: str) -> RecordedUnit | None:
        """The first unit whose input of this name the output drives; None if there is none."""
        links, source = self.result.scene.coupling.links, (self.name, output)
        targets = [link.target[0] for link in links if link.source == source and link.target[1] == input_]
        return RecordedUnit(self.result, targets[0]) if targets else None

    @cached_property
    def component(self) -> Component | None:
        """The unit's component with the scene's effects and parameters, not initialized; None for an FMU."""
        scene = self.result.scene
        return make(self.name, scene.units[self.name]) if scene.kinds[self.name].component_class else None


def recorded_units(result: Result, *outputs: str) -> list[RecordedUnit]:
    """The units of a run of which all these outputs were recorded, in the order of the scene; all units for none."""
    units = [RecordedUnit(result, name) for name in result.scene.units]
    return [unit for unit in units if unit.has(*outputs)]
