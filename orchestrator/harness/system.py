"""What the harness knows of one system, described in the folder of its name and handed to whatever needs it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

from ..settings import AnalysisKeys

if TYPE_CHECKING:
    from ..run.results import Result
    from .charts.blocks import Block
    from .charts.motion import Kinematics
    from .summary import Summary


@dataclass(frozen=True)
class System:
    """A system as the harness sees it. Its folder has scenes/*.toml, and any of cases/ (TOML, rows as CSV, what is measured), figures.py or
    figures/, motion.py, summary.py, explore.py.

    package: name of that folder as a package.  keys: what its scenes' [analysis] may say.
    Figures are imported when they are asked for: they need plotting and all of the analysis.
    """

    name: str
    title: str
    package: str
    keys: type[AnalysisKeys] = AnalysisKeys

    def module(self, name: str) -> ModuleType | None:
        """The module or package of that name in its folder, None where there is none."""
        module = f"{self.package}.{name}"
        return import_module(module) if find_spec(module) else None

    @property
    def figures(self) -> Callable[..., list[Block]]:
        """Blocks of a report: `figures(result, rows)`, for a run of the system and rows of a reference table, if any."""
        return m.blocks if (m := self.module("figures")) else lambda result, rows=(): []

    @property
    def motions(self) -> Callable[[Result], list[Kinematics]]:
        """How the machines of a run move: `motions(result)`."""
        return m.motions if (m := self.module("motion")) else lambda result: []

    @property
    def summary(self) -> Callable[[Result], Summary]:
        """Figures of a run in numbers: `summary(result)`."""
        return m.summary if (m := self.module("summary")) else lambda result: ()

    @property
    def headline(self) -> tuple[str, ...]:
        """Patterns of the quantities that a run of the system is judged by, as in "*_rms"; none for its first ones."""
        return getattr(self.module("summary"), "HEADLINE", ())

    @property
    def inputs(self) -> tuple[str, ...]:
        """Patterns of the parameters that a reader of a run looks for first; none for those that its scene gives."""
        return getattr(self.module("summary"), "INPUTS", ())

    @property
    def explore(self) -> Any:
        """What it knows of pages that compute its scenes, see `explore.content.Knowledge`: its module `explore`, None without one."""
        return self.module("explore")


Systems = Mapping[str, System]  # by name
