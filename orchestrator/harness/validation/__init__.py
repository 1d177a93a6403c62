"""Cases that hold simulations against reference tables, and their outcomes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from ....components.core.errors import BadInput, nearest
from .case import CaseResult, Options, to_json


def validate(
    names: Iterable[str],
    directory: str | Path,
    in_process: bool = False,
    progress: bool = False,
) -> list[CaseResult]:
    """Run cases by name (none: all), write `report.html` and `validation.json` to `directory`.

    Raises `BadInput` for an unknown case before anything runs.
    """
    from ...systems import CASES
    from .. import report

    names = list(names) or list(CASES)
    for name in names:
        if name not in CASES:
            raise BadInput("case", repr(name), "a validation case", nearest(name, CASES))
    options = Options(in_process, progress)
    results = [CaseResult(CASES[n], CASES[n].function(options)) for n in names]
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    page = report.for_cases(results, directory)
    results = [replace(r, report=page) for r in results]
    (directory / "validation.json").write_text(to_json(results), encoding="utf-8")
    return results
