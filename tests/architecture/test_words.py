"""Identifiers are the field's words: names that were replaced, and names that say nothing of a value, stay out."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# former name: the one to use. Banned in the whole of the orchestrator.
FORMER = {
    "settle": "resolve_coupling",
    "settling": "resolve",
    "Settled": "InitializationResult",
    "Guided": "AdaptiveStepping",
    "Stretched": "Stepping",
    "march": "run_steps",
    "Patient": "BatchObserver",
    "BatchStepping": "Stepping",
    "GUESSED": "EXTRAPOLATED",
    "looseness": "inverse_mass",
    "yielding": "mobility",
    "ComponentUnit": "ComponentSimulator",
    "FmuUnit": "FmuSimulator",
    "WorkerUnit": "WorkerSimulator",
    "idle": "needs",
    "Misses": "ExtrapolationError",
    "Chain": "StronglyConnectedGroup",
    "told_late": "why_it_grows",
    "Now": "LoopState",
    "Plan": "LoopLayout",
    "Row": "PortValues",
    "WIDE": "ARRAY_THRESHOLD",
    "KEPT": "CACHED_CALLS",
    "prove": "check_step_repeatable",
    "opened": "open_scene",
    "passes": "feedthrough_schedule",
    "jumps": "is_discrete",
    "is_led": "interpolates",
}
ALLOWED = {  # other things of the same name
    "orchestrator/harness": {"Row", "WIDE"},  # a row of a validation table; a wide axis
    "orchestrator/systems": {"Row", "Chain", "WIDE", "KEPT", "settle", "jumps"},  # kinematic chains, tables, transients
    "orchestrator/scene": {"opened"},  # archives
    "orchestrator/units": {"settle"},  # discrete states of a foreign model
}
MEANINGLESS = {"found", "made", "told", "said", "heard", "settled", "came", "things"}
FORMER_OF_COMPONENTS = {
    "settle": "kernel_arguments",
    "asked_only": "explicit_only",
    "RK4_REACH": "RK4_STABILITY_RADIUS",
    "ROUNDING": "a name of what is rounded",
}
CLEAN = ("components", "fmus", "orchestrator")  # where no name may be one of these


@cache
def identifiers(path: Path) -> frozenset[str]:
    """Every name that a module defines, assigns, imports or takes as an argument, and its own name."""
    return frozenset((path.stem, *_defined(path)))


def _defined(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.Name(id=name, ctx=ast.Store()):
                yield name
            case ast.Attribute(attr=name, ctx=ast.Store()) | ast.arg(arg=name) | ast.keyword(arg=str(name)):
                yield name
            case ast.alias(name=name, asname=other):
                yield other or name.rpartition(".")[2]


def offences(place: str, banned: set[str]) -> set[str]:
    """`file: name` of banned names below a place of the tree."""
    root = ROOT / place
    files = [root] if root.is_file() else sorted(root.rglob("*.py"))
    assert files, f"{place} does not exist"
    return {
        f"{path.relative_to(ROOT)}: {name}"
        for path in files
        for name in identifiers(path)
        if name.removeprefix("_") in banned - _allowed(path)
    }


def _allowed(path: Path) -> set[str]:
    return next((names for place, names in ALLOWED.items() if path.is_relative_to(ROOT / place)), set())


def test_former_names_do_not_return():
    assert offences("orchestrator", set(FORMER)) == set()
    assert offences("components", set(FORMER_OF_COMPONENTS)) == set()


@pytest.mark.parametrize("place", CLEAN)
def test_a_name_says_what_its_value_is(place):
    assert offences(place, MEANINGLESS) == set()


def test_names_are_seen_wherever_they_are_written(tmp_path):
    path = tmp_path / "module.py"
    path.write_text("import a.settle\ndef idle(told, *, made=1):\n    self.found, came = f(said=2)\nfor things in x: pass\n")
    assert {"settle", "idle", "told", "made", "found", "came", "said", "things"} <= identifiers(path)


PHRASES = {  # of this house, that a stranger does not know: the field's
    r"same bits": "bit-identical",
    r"held against (a table|its|the|published)": "compared with",
    r"told once": "exchanged once per step",
    r"without measure": "infinite",
    r"comes? to stand": "converge",
    r"without a word": "silently",
    r"said in vain": "ignored",
    r"processor time": "CPU time",
    r"on the way there": "in the transient",
    r"less than none": "what the value means",
}


def test_phrases_of_the_house_do_not_return():
    texts = [
        *(path for place in CLEAN for ending in ("py", "toml", "html", "csv") for path in (ROOT / place).rglob(f"*.{ending}")),
        *(path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts),
        ROOT / "README.md",
        ROOT / "CHANGELOG.md",
    ]
    used = [
        f"{path.relative_to(ROOT)}: {match[0]!r}, say {plain!r}"
        for path in texts
        for phrase, plain in PHRASES.items()
        for match in re.finditer(phrase, path.read_text(encoding="utf-8"), re.IGNORECASE)
    ]
    assert used == []
