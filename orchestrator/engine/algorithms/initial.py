"""How the groups of a master come to consistent initial values, see `initial_kernels`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ....components.core.errors import StepFailed
from .memory import Records
from .network import Network
from .node import Node
from .records import ABOUT_ZERO, NOT_CONVERGED


@dataclass(frozen=True)
class InitializationResult:
    """How a group came to its initial values; `residual`: relative change in the last sweep."""

    units: tuple[str, ...]
    sweeps: int
    secants: int
    residual: float


class Groups:
    """The groups of a network, each in the order of a sweep, and what their initialization has come to.

    layout: of each the places of its nodes, and of each output its cell, whether a sweep depends on it, and the least value that a
    change is compared with. records: set once they are laid out.
    """

    records: Records

    def __init__(self, network: Network):
        self._network = network
        groups = [sorted((network.node_of[name] for name in names), key=self._direct_share) for names in network.coupling.groups]
        self._names = [tuple(node.unit.name for node in group) for group in groups]
        self._ends = {cell: end for end, cell in network.cells.items()}
        self.layout = [([network.nodes.index(node) for node in group], self._answers(group)) for group in groups]

    def _answers(self, group: Sequence[Node]) -> list[tuple[int, bool, float]]:
        network, names = self._network, {node.unit.name for node in group}
        ends = {cell: end for end, cell in network.cells.items() if end[0] in names and end in network.handed_over}
        given: set[int] = set()
        needed: set[int] = set()  # cells that a sweep reads before it writes them: it depends on no others
        for node in group:
            needed |= set(node.sources) - given
            given |= {cell for cell, end in ends.items() if end[0] == node.unit.name}
        interfaces = network.coupling.interfaces
        return [
            (cell, cell in needed, ABOUT_ZERO * interfaces[u].outputs[n].nominal)
            for cell, (u, n) in ends.items()
            if not network.is_idle((u, n))
        ]

    def _direct_share(self, node: Node) -> float:
        """Share of a unit's signals that depend on its inputs directly.

        Units where it is small go first in a sweep: what they give stands already, and may be what others cannot start
        without, such as the place of a contact.
        """
        outputs = self._network.coupling.interfaces[node.unit.name].outputs
        direct = [outputs[n].feedthrough != () for u, n in self._network.handed_over if u == node.unit.name]
        return sum(direct) / max(len(direct), 1)

    def prepare(self) -> None:
        """Put what units go by that are initialized before their sources into the table of signals."""
        signals, interfaces = self.records.memory.signals, self._network.coupling.interfaces
        for node in self._network.nodes:  # a source that has not been initialized stands at the start of the input it feeds
            for link, k in zip(node.links, node.sources, strict=True):
                start = float(interfaces[link.target[0]].inputs[link.target[1]].start) if link.factor or link.map else 0.0
                if link.factor:
                    signals[k] = (start - link.offset) / link.factor
                elif link.map:
                    signals[k] = next((value for value, becomes in link.map if becomes == start), link.map[0][0])

    @property
    def results(self) -> list[InitializationResult]:
        """Of the groups that have been swept."""
        rows = zip(self._names, self.records.memory.groups, strict=True)
        return [
            InitializationResult(names, int(row["sweeps"]), int(row["secants"]), float(row["residual"]))
            for names, row in rows
            if row["sweeps"]
        ]

    def check(self, t: float, check: Callable[[float], None]) -> None:
        """Raises `StepFailed` where the last initialization has failed; `check` raises for outputs that are no numbers."""
        check(t)
        if self.records.answer("unit") == NOT_CONVERGED:
            raise self._not_converged(self.records.answer("row"), t)

    def _not_converged(self, k: int, t: float) -> StepFailed:
        row, names = self.records.memory.groups[k], self._names[k]
        unit, name = self._ends[int(row["worst"])]
        returned = (
            ", and what goes round comes back as it went: they have no common equilibrium, or many" if row["parallel"] else ""
        )
        return StepFailed(
            unit,
            t,
            f"the initial values of {', '.join(names)} did not converge in {row['sweeps']} sweeps "
            f"and {row['secants']} quasi-Newton steps; {name} still changes by {row['residual']:.2g} of its value{returned}",
            "Give parameters closer to a common equilibrium",
        )
