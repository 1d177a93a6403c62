"""Kernels in plain Python: for numbers that are needed a few times, outside of runs, and do not pay for the compiler."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def in_python(kernel: Any) -> Callable[..., Any]:
    """The function that a kernel is made of."""
    return getattr(kernel, "py_func", kernel)
