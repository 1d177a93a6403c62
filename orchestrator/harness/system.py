"""What the harness knows of one system, described in the folder of its name and handed to whatever needs it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from ..settings import AnalysisKeys

if TYPE_CHECKING:
    from ..results import Result
    from .charts.blocks import Block
    from .charts.motion import Kinematics
    from .summary import Summary
    from .validation.case import Case


@dataclass(frozen=True)
class System:
    """A system as the harness sees it. Its folder has scenes/*.toml, cases/ (questions and tables), figures.py or
    figures/, motion.py, fronts/*.csv, summary.py, explore.py.

    package: name of that folder as a package.  keys: what its scenes' [analysis] may say.
    Cases and figures are imported when they are asked for: they need plotting and all of the analysis.
    """

    name: str
    title: str
    package: str
    keys: type[AnalysisKeys] = AnalysisKeys

    @property
    def cases(self) -> tuple[Case, ...]:
        """Validation cases of this system, in the order of their list in the package `cases`."""
        return tuple(replace(case, system=self.name) for case in import_module(".cases", self.package).CASES)

    @property
    def figures(self) -> Callable[..., list[Block]]:
        """Blocks of a report: `figures(result, rows)`, for a run of the system and rows of a reference table, if any."""
        return import_module(".figures", self.package).blocks

    @property
    def motions(self) -> Callable[[Result], list[Kinematics]]:
        """How the machines of a run move: `motions(result)`, none where the folder has no module `motion`."""
        name = f"{self.package}.motion"
        return import_module(name).motions if find_spec(name) else lambda result: []

    @property
    def summary(self) -> Callable[[Result], Summary]:
        """Figures of a run in numbers: `summary(result)`, none where the folder has no module `summary`."""
        name = f"{self.package}.summary"
        return import_module(name).summary if find_spec(name) else lambda result: ()

    @property
    def headline(self) -> tuple[str, ...]:
        """Patterns of the quantities that a run of the system is judged by, as in "*_rms"; none for its first ones."""
        name = f"{self.package}.summary"
        return getattr(import_module(name), "HEADLINE", ()) if find_spec(name) else ()

    @property
    def explore(self) -> Any:
        """What it knows of pages that compute its scenes, see `explore.content.Knowledge`: its module `explore`, None without one."""
        name = f"{self.package}.explore"
        return import_module(name) if find_spec(name) else None


Systems = Mapping[str, System]  # by name
