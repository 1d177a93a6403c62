"""Texts between units: handed over as they are, at the start of each macro step."""

from __future__ import annotations

from collections.abc import Mapping

from ...units import Simulator
from ..coupling import Coupling, Endpoint


class Texts:
    """The connected texts of a scene. Before its source has been initialized a text is the start value of its input."""

    def __init__(self, units: Mapping[str, Simulator], coupling: Coupling):
        self._units = units
        self._values: dict[Endpoint, str] = {}
        self._given: dict[str, list[str]] = {}  # outputs by unit
        self._taken: dict[str, list[Endpoint]] = {}  # sources by the unit they feed
        inputs: dict[str, list[str]] = {}
        for link in coupling.texts:
            self._values.setdefault(link.source, str(coupling.interfaces[link.target[0]].inputs[link.target[1]].start))
            names = self._given.setdefault(link.source[0], [])
            if link.source[1] not in names:
                names.append(link.source[1])
            self._taken.setdefault(link.target[0], []).append(link.source)
            inputs.setdefault(link.target[0], []).append(link.target[1])
        for name, driven in inputs.items():
            units[name].wire_texts(driven)
        self._read = {name: units[name].text_reader(outputs) for name, outputs in self._given.items()}

    def give(self, unit: str) -> None:
        """Hand a unit the texts that it takes."""
        if unit in self._taken:
            self._units[unit].set_texts([self._values[source] for source in self._taken[unit]])

    def read(self, unit: str) -> None:
        """Ask a unit for the texts that it gives."""
        if unit in self._given:
            for name, value in zip(self._given[unit], self._read[unit](), strict=True):
                self._values[unit, name] = value

    def hand_over(self) -> None:
        """All texts, from all that give some to all that take some."""
        for unit in self._given:
            self.read(unit)
        for unit in self._taken:
            self.give(unit)
