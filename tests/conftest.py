"""Which tests share a worker: those of one file, or of one component of the contract, so that its kernels are compiled once."""

from __future__ import annotations

from pathlib import Path

import pytest

CONTRACT = Path(__file__).parent / "contract"


@pytest.hookimpl(tryfirst=True)  # before the plug-in reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The group of every test, for `--dist loadgroup`."""
    for item in items:
        item.add_marker(pytest.mark.xdist_group(_component(item) or item.nodeid.partition("::")[0]))


def _component(item: pytest.Item) -> str:
    """Component of a contract test, "" of others."""
    params = getattr(getattr(item, "callspec", None), "params", {})
    component = params.get("component") or getattr(params.get("configuration"), "component", "")
    return component if item.path.is_relative_to(CONTRACT) else ""
