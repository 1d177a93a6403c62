"""Cases that compare simulations with reference tables, and their outcomes."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .case import Case, CaseResult, Options, to_json

if TYPE_CHECKING:
    from ..system import Systems


def run_cases(cases: Sequence[Case], directory: Path, systems: Systems, *, in_process: bool, progress: bool) -> list[CaseResult]:
    """Run the cases, write `report.html` and `validation.json` to `directory`."""
    from ..report import for_cases

    options = Options(in_process, progress)
    results = []
    for i, case in enumerate(cases, 1):
        if progress and len(cases) > 1:
            print(f"{i} of {len(cases)}: {case.name}", file=sys.stderr, flush=True)
        results.append(CaseResult(case, case.function(options)))
    directory.mkdir(parents=True, exist_ok=True)
    page = for_cases(results, directory, systems)
    results = [replace(r, report=page) for r in results]
    (directory / "validation.json").write_text(to_json(results), encoding="utf-8")
    return results
