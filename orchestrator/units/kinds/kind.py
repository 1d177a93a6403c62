"""The base of the kinds of units: what the rest of the tree may ask of one, with the answers of most."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from ....components.core.component import Component
from ....components.core.folders import cache_root

if TYPE_CHECKING:
    from ...settings import UnitSettings
    from ..interface import Interface, Simulator, Span

NUMERICAL = {  # real parameters by which nothing has a derivative
    "substep": "it sets the numerical error alone",
    "tolerance": "it sets the numerical error alone",
    "front_threshold": "it sets the numerical error alone",
}
ISOLATION = {"none": "", "process": "in a process of its own", "restricted": "in a sandbox"}


class UnitKind(ABC):
    """A unit as a scene has it, which is not started. where: of the unit, for messages.

    key: of the entry that says what it is.  is_file: whether the value of the key is a path.  suffixes: of what is recognised as
    this kind by its name; None: all that no other kind takes.
    foreign: whether its code is another's, which may write files and end the process, and is not executed to look at a scene.
    of_catalogue: whether its code is a component of cosimo, which tests know to keep all of its state.
    has_native_form: whether it can be built as a native FMU.
    component_class: of its component; None: none is known.
    code: names of components whose code its results depend on.
    once: why a run with it cannot be repeated, in words; "": it can.
    """

    key: ClassVar[str]
    is_file: ClassVar[bool] = False
    suffixes: ClassVar[tuple[str, ...] | None] = ()
    foreign: ClassVar[bool] = False
    has_native_form: ClassVar[bool] = False
    of_catalogue: bool = False
    component_class: type[Component] | None = None
    code: tuple[str, ...] = ()
    once: ClassVar[str] = ""

    def __init__(self, settings: UnitSettings, where: str):
        self.settings, self.where = settings, where

    # -- what it is ----------------------------------------------------------------------------------------------------
    @property
    def value(self) -> str:
        """Name or path, as a scene has it."""
        return str(getattr(self.settings, self.key))

    @property
    def label(self) -> str:
        """A short name, for drawings."""
        return Path(self.value).name

    @property
    def shown(self) -> str:
        """`value` for a reader: of a copy in the cache, such as of an FMU in a package, the name alone."""
        return self.label if self.is_file and Path(self.value).is_relative_to(cache_root()) else self.value

    @property
    def file(self) -> str:
        """Path of its file; "" without one."""
        return self.value if self.is_file else ""

    @property
    def isolation(self) -> str:
        """Where it runs, in words; "" in the process of the run."""
        return ISOLATION[self.settings.isolation]

    @property
    def in_worker(self) -> bool:
        """Whether it runs in a worker process."""
        return bool(self.isolation)

    @property
    def sandboxed(self) -> bool:
        """Whether it runs there within walls."""
        return self.settings.isolation == "restricted"

    @property
    def outside(self) -> str:
        """Why a run of components alone cannot hold it, in words; "": it can."""
        return self.isolation

    # -- how it is opened ------------------------------------------------------------------------------------------------
    @abstractmethod
    def describe(self, name: str) -> Interface:
        """Names, units of measure and capabilities, without starting it; raises `BadInput` for settings that do not fit."""

    @abstractmethod
    def open(self, name: str, in_process: bool, span: Span) -> Simulator:
        """The unit, started in this process. in_process: components as they are, no FMUs of them; span: what FMUs are told of the run."""

    def opened_as(self, in_process: bool) -> str:
        """What `open` gives, in a word."""
        return "FMU"

    # -- what it declares ------------------------------------------------------------------------------------------------
    @property
    @abstractmethod
    def variables(self) -> Mapping[str, Any]:
        """All variables by name, each with `unit`, `kind` and `start`."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Those of the variables that are parameters, by name; others may be among them that say so by their `causality`."""
        return self.variables

    def parameter_names(self) -> set[str] | None:
        """Names that parameters reported by a worker process may have; None where the code that reports them is ours."""
        return None

    @abstractmethod
    def number_of(self, parameter: str, text: str) -> Any:
        """The number of a parameter written with its unit, "250 km/h"; the text where it is one. Raises `BadInput`."""

    def numerical(self, parameter: str) -> str:
        """Why nothing has a derivative by a parameter that sets the numerics; "" for others."""
        return NUMERICAL.get(parameter.rpartition(".")[2], "")  # of an effect, too

    # -- scenes --------------------------------------------------------------------------------------------------------
    def prepared(self, entry: Mapping[str, Any]) -> Mapping[str, Any]:
        """The entry with what is made of it when a scene is read; raises `BadInput`."""
        return entry

    def contents(self, entry: dict[str, Any]) -> dict[str, Any]:
        """What results depend on of its settings as JSON, files by their contents. Raises `OSError`."""
        return {key: value for key, value in entry.items() if key != "signals"}  # a component has the table's digest in its name

    def whole_path(self) -> dict[str, str]:
        """The change of its settings by which it is found from other working directories, too; none where there is no need."""
        return {f"{self.where}.{self.key}": os.path.abspath(self.value)} if self.is_file and not os.path.isabs(self.value) else {}

    def made_ready(self) -> UnitKind:
        """The unit as it can be opened on this machine; raises `BadInput` where it cannot."""
        return self

    @abstractmethod
    def fmu_file(self) -> Path:
        """An FMU that stands for it in other tools, built where it is a component."""

    @abstractmethod
    def fmu_values(self, name: str) -> dict[str, Any]:
        """Start values for this FMU: effects that are on, and values that differ from its defaults."""

    # -- tables over time ------------------------------------------------------------------------------------------------
    holds: bool = False  # whether outputs are discrete, as they jump from one held value to the next
    repeats: bool = False  # whether outputs go on for ever

    def jump_times(self, begin: float, end: float) -> list[float]:
        """Instants behind `begin` and up to `end`, s, at which outputs jump by themselves."""
        return []

    def missed(self, step: float) -> str:
        """A warning where macro steps of a length, s, miss something of its outputs; "" where not."""
        return ""

    def refuse_run(self, begin: float, end: float, scene: str) -> None:
        """Raise `BadInput` for a run, s, that it cannot be part of."""
        return None
