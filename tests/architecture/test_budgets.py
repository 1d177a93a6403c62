"""No folder grows beyond its budget of statements, which stands in docs/development/architecture.md."""

from __future__ import annotations

import pytest
from cosimo.tests.architecture.statements import budgets, counted, statements

BUDGETS = budgets()


def test_every_folder_has_a_budget():
    assert BUDGETS.keys() == counted().keys()


@pytest.mark.parametrize("name", BUDGETS)
def test_a_folder_keeps_its_budget(name):
    size = counted()[name]
    assert size <= BUDGETS[name], (
        f"{name}: {size} statements; expected at most {BUDGETS[name]}, see docs/development/architecture.md. "
        "Take out what is not called for, or say in the page what is new"
    )


def test_docstrings_and_blank_lines_are_no_statements(tmp_path):
    path = tmp_path / "counted.py"
    path.write_text('"""Text."""\n\nimport os\n\n\ndef f(x):\n    """Text."""\n    if x:\n        return os.sep\n    return ""\n')
    assert statements(path) == 5
