"""What the short run takes of long lists: the rest is marked `full`."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class

ONE_A_SYSTEM = tuple({component_class(name).system: name for name in CATALOGUE}.values())


def full_but(kept: Collection[Any], cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test: all but the kept ones only in the complete run. A case is a value, or a tuple of values."""
    return [case if case in kept else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.full)
            for case in cases]
