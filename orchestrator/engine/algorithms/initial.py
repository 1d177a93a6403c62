"""How the groups of a master come to consistent initial values, see `initial_kernels`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ....components.core.errors import StepFailed
from ..coupling import Endpoint
from .memory import Records
from .records import NOT_CONVERGED


@dataclass(frozen=True)
class InitializationResult:
    """How a group came to its initial values; `residual`: relative change in the last sweep."""

    units: tuple[str, ...]
    sweeps: int
    secants: int
    residual: float


class Groups:
    """The groups of a master, by name, and what their initialization has come to."""

    def __init__(self, names: Sequence[Sequence[str]], records: Records, ends: Mapping[int, Endpoint]):
        """names: of the simulators of each group in the order of a sweep; ends: outputs by cell of the table."""
        self._names, self._records, self._ends = [tuple(group) for group in names], records, ends

    @property
    def results(self) -> list[InitializationResult]:
        """Of the groups that have been swept."""
        rows = zip(self._names, self._records.memory.groups, strict=True)
        return [
            InitializationResult(names, int(row["sweeps"]), int(row["secants"]), float(row["residual"]))
            for names, row in rows
            if row["sweeps"]
        ]

    def check(self, t: float, check: Callable[[float], None]) -> None:
        """Raises `StepFailed` where the last initialization has failed; `check` raises for outputs that are no numbers."""
        check(t)
        if self._records.answer("unit") == NOT_CONVERGED:
            raise self._not_converged(self._records.answer("row"), t)

    def _not_converged(self, k: int, t: float) -> StepFailed:
        row, names = self._records.memory.groups[k], self._names[k]
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
