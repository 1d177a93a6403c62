"""What a master algorithm is: a strategy of the master, which decides in which order units start and are read."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

from ...settings import MasterSettings
from ...settings.algorithms import ALGORITHMS
from ..coupling import Coupling, Link
from .network import Acts, Network

if TYPE_CHECKING:
    from .machine import Machine


class Algorithm:
    """Base of the algorithms. One gives `acts`, the whole of a macro step, or takes its steps in `advance`.

    acts: what a macro step begins with, before outputs follow their inputs; the compiled loop takes many steps of it in one call.
    solves_loops: algebraic loops are solved in the step, not behind it. consistent: inputs that are interpolated end at what the units
    have given when the step is done; else the master looks at them once more.
    """

    acts: Acts = ()
    solves_loops: ClassVar[bool] = False
    consistent: ClassVar[bool] = True

    def __init__(self, network: Network, settings: MasterSettings):
        """Make rows of the program on the nodes of a network."""

    @staticmethod
    def order(coupling: Coupling, units: tuple[str, ...]) -> tuple[str, ...]:
        """The order of the units where the scene gives none; units: as they stand there."""
        return units

    @staticmethod
    def extrapolated(link: Link, ranks: Mapping[str, int], coupling: Coupling) -> bool:
        """Whether the input behind a link is extrapolated; else its polynomial ends at the value in the table of signals.

        ranks: of the units in their order.
        """
        return True

    def advance(self, machine: Machine, t: float, h: float) -> None:
        """The steps of all units from t to t + h, where they are more than `acts`."""

    @property
    def memory(self) -> Any:
        """What the next steps depend on beside records and units: plain numbers, lists and texts, for a file, too."""
        return None

    @memory.setter
    def memory(self, memory: Any) -> None: ...

    def counters(self) -> dict[str, Any]:
        """For run.json."""
        return {}

    def warnings(self, steps: int) -> list[str]:
        """What a user should know of the steps made so far."""
        return []


def class_of(algorithm: str) -> type[Algorithm]:
    """The class of an algorithm."""
    module, _, name = ALGORITHMS[algorithm].place.partition(":")
    algorithm_class: type[Algorithm] = getattr(import_module(f".{module}", __package__), name)
    return algorithm_class
