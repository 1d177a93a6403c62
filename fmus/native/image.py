"""The state after initialization at the parameters of the build, and what of it would be another at other inputs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...components.core.contract import KernelComponent
from ...components.core.kernels import DONE
from .kernel_code import kernel_code, kernel_image
from .machine_code import INITIAL_STATE, Code, Image, compile_entries
from .settable import settable_parameters

SHIFTS = ((1.01, 1e-6), (0.5, -1e-3), (1.0, 0.3), (-1.0, 1.0))  # factor and summand of inputs that are tried
LATER = 0.3712  # s, a start that is tried


def initialized(component: Any, t: float = 0.0) -> Any:
    """The component after initialization, but for what `_start` adds, which is part of the machine code."""
    component._start = lambda t: DONE
    try:
        component.initialize(t)
    finally:
        del component._start
    return component


def compiled_with_image(make: Callable[[], Any]) -> tuple[Any, Code, Image]:
    """(component, machine code, image) of the component that `make` makes, in its configuration and with its start values."""
    if isinstance(component := make(), KernelComponent):
        component.initialize(0.0)
        code = kernel_code(component)
        return component, code, kernel_image(component, code)
    component = initialized(component)
    code = compile_entries(component)
    image = code.block.image()
    left_out = ("x",) if code.start == INITIAL_STATE else ()  # which the FMU computes itself
    bound = {name for name in component.inputs if _matters(make, component, name, left_out)}
    return component, code, Image(image, frozenset(bound), _differs(make, LATER, left_out),
                                  settable_parameters(make, component, code, image, initialized))


def _contents(component: Any, left_out: tuple[str, ...]) -> list[np.ndarray]:
    """All arrays and numbers of an initialized component, but for inputs, outputs, the time and what is left out."""
    arrays: list[np.ndarray] = []
    seen: set[int] = set()

    def add(value: Any) -> None:
        if isinstance(value, np.ndarray):
            if id(value) not in seen:
                seen.add(id(value))
                arrays.append(np.array(value))
        elif isinstance(value, bool | int | float | np.number):
            arrays.append(np.array(value))
        elif isinstance(value, tuple | list):
            for item in value:
                add(item)

    for name, value in vars(component).items():
        if name not in ("t", "u", "y", "inputs", "outputs", "parameters", *left_out):
            add(value)
    return arrays


def _same(first: list[np.ndarray], second: list[np.ndarray]) -> bool:
    return len(first) == len(second) and all(
        a.shape == b.shape and (a.dtype.kind not in "fiub" or np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
        for a, b in zip(first, second, strict=True))


def _matters(make: Callable[[], Any], component: Any, name: str, left_out: tuple[str, ...]) -> bool:
    """Whether the initial state follows from this input.

    A component initialized at another value of it is compared with one that gets the value afterwards; both compute their
    outputs with it, because that may use workspace.
    """
    start = component.u[0, component.inputs.index(name)]
    for factor, summand in SHIFTS:
        value = factor * start + summand
        before, after = make(), initialized(make())
        before.set(name, value)
        after.set(name, value)
        try:
            after.refresh()
        except Exception:
            continue  # a value that the model refuses whenever it comes
        try:
            if not _same(_contents(initialized(before), left_out), _contents(after, left_out)):
                return True
        except Exception:
            return True
    return False


def _differs(make: Callable[[], Any], t: float, left_out: tuple[str, ...]) -> bool:
    """Whether initialization at another time gives another state."""
    at_zero = initialized(make())
    at_zero.t = t
    try:
        at_zero.refresh()
        return not _same(_contents(initialized(make(), t), left_out), _contents(at_zero, left_out))
    except Exception:
        return True
