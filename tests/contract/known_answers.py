"""Component -> effect -> the test that compares it with a known answer: closed form, balance, published number, another solver.

Each system lists its own in `tests/systems/<system>/known_answers.py`.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

HERE = "tests/contract/test_effect_sizes.py::test_"
OWN = "tests/systems/"


def in_file(file: str, **tests: str) -> dict[str, str]:
    """Effect -> test, of tests of one file below `tests/systems`."""
    return {effect: f"{OWN}{file}::test_{test}" for effect, test in tests.items()}


def here(**tests: str) -> dict[str, str]:
    """Effect -> test, of tests of the contract."""
    return {effect: HERE + test for effect, test in tests.items()}


def known() -> dict[str, dict[str, str]]:
    """Component -> effect -> test, of all systems."""
    found: dict[str, dict[str, str]] = {}
    for path in sorted((Path(__file__).parents[1] / "systems").glob("*/known_answers.py")):
        found |= import_module(f"cosimo.tests.systems.{path.parent.name}.known_answers").KNOWN
    return found
