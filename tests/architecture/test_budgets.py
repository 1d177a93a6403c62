"""No folder grows beyond its budget of statements, which stands in docs/development/architecture.md."""

from __future__ import annotations

import pytest
from cosimo.tests.architecture.statements import budgets, counted, statements

SIZES, BUDGETS = counted(), budgets()


def test_every_folder_has_a_budget():
    assert BUDGETS.keys() == SIZES.keys()


@pytest.mark.parametrize("name", BUDGETS)
def test_a_folder_keeps_its_budget(name):
    assert SIZES[name] <= BUDGETS[name], (
        f"{name}: {SIZES[name]} statements; expected at most {BUDGETS[name]}, see docs/development/architecture.md. "
        "Take out what is not called for, or say in the page what is new"
    )


def test_docstrings_and_blank_lines_are_no_statements(tmp_path):
    path = tmp_path / "counted.py"
    path.write_text('"""Text."""\n\nimport os\n\n\ndef f(x):\n    """Text."""\n    if x:\n        return os.sep\n    return ""\n')
    assert statements(path) == 5
