"""Which parameters an instance of a native FMU can be given, and the cells that they go into.

Initialization in Python computes what the kernels get, and is not part of the FMU. A parameter that it hands on unchanged, to
cells of the block and to nothing else, can be written there before the run; any other one is a constant of the build. Which is
which is tried at build: the component is initialized at other values, near and far within the limits, alone and together with the
others that can be set, and its block compared with the one in which the values were written. A parameter that the limit of the
substep follows from is a constant as well: the runtime could not refuse a step that it makes unstable.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from typing import Any

import numpy as np

from .machine_code import INITIAL_STATE, Code

FAR = 1e3  # factor
NEAR = ((1.25, 0.0), (0.5, 0.0), (2.0, 0.0), (-1.0, 0.0), (1.0, 0.1), (1.0, 1.0), (FAR, 0.0), (1.0 / FAR, 0.0))


def settable_parameters(make: Callable[[], Any], component: Any, code: Code, cells: np.ndarray,
                        initialize: Callable[[Any], Any]) -> dict[str, tuple[int, ...]]:
    """Cells by parameter. `cells`: the block at the parameters of the build; `initialize`: as the image's was."""
    trial = _Trial(make, component, code, cells, initialize)
    places: dict[str, tuple[int, ...]] = {}
    together: dict[str, float] = {}
    for name in code.block.parameters:
        values = list(_values(component, name))
        own = trial.cells_of(name, values[0]) if len(values) > 1 else ()
        if not own or not all(trial.agrees({name: value}, {name: own}) for value in values):
            continue
        if all(trial.agrees({**together, name: value}, {**places, name: own}) for value in values[:2]):
            places[name], together[name] = own, values[0]
    return places


def _values(component: Any, name: str) -> Iterator[float]:
    """Values of a parameter that are tried: near the present one, far from it, and its limits."""
    variable, start = type(component).variables[name], component.parameters[name]
    tried = {start}
    for value in (*(factor * start + summand for factor, summand in NEAR), variable.low, variable.high):
        if value not in tried and isfinite(value) and variable.low <= value <= variable.high:
            tried.add(value)
            yield value


class _Trial:
    """Initializations with other parameters, compared with a block into which these were written."""

    def __init__(self, make: Callable[[], Any], component: Any, code: Code, cells: np.ndarray,
                 initialize: Callable[[Any], Any]):
        self._make, self._component, self._block, self._initialize = make, component, code.block, initialize
        self._cells, self._limit = cells, component.stable_step()
        self._compared = np.ones(cells.size, dtype=bool)
        block = code.block
        computed = [(block.y, component.y.size), *([(block.x, component.x.size)] if code.start == INITIAL_STATE else [])]
        for first, size in computed:
            self._compared[first : first + size] = False

    def _block_at(self, values: Mapping[str, float]) -> np.ndarray | None:
        """The block at other parameters; None where they are refused, or change the limit of the substep."""
        other = self._make()
        try:
            for name, value in values.items():
                other.set(name, value)
            self._initialize(other)
            if other.stable_step() != self._limit:
                return None
            return self._block.image(self._block.counterparts(other))
        except Exception:  # whatever initialization raises at values that it does not take
            return None

    def cells_of(self, name: str, value: float) -> tuple[int, ...]:
        """Cells that change with a parameter, its own apart; none where one of them does not hold it."""
        cells = self._block_at({name: value})
        if cells is None:
            return ()
        changed = self._compared & (cells.view(np.int64) != self._cells.view(np.int64))
        changed[self._block.parameters[name]] = False
        own = np.array([value, self._component.parameters[name]]).view(np.int64)
        holds = (cells.view(np.int64) == own[0]) & (self._cells.view(np.int64) == own[1])
        return tuple(np.flatnonzero(changed).tolist()) if changed.any() and holds[changed].all() else ()

    def agrees(self, values: Mapping[str, float], places: Mapping[str, tuple[int, ...]]) -> bool:
        """Whether initialization at these parameters gives the block of the build with the values written into their places."""
        cells = self._block_at(values)
        if cells is None:
            return False
        written = self._cells.copy()
        for name, value in values.items():
            written[[self._block.parameters[name], *places[name]]] = value
        return bool((written.view(np.int64) == cells.view(np.int64))[self._compared].all())

