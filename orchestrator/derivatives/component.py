"""Steps of a component that is in no scene, with tangents of its state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...components.core.component import Component
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput, StepFailed
from ...components.core.kernels import COMPILED
from ...fmus.native.machine_code import compile_entries, source_of

ALONE = "a component of kernels, with Numba"


class TangentComponent:
    """An initialized component from where it stands; it stays there itself."""

    def __init__(self, component: Component, width: int):
        """width: directions at once. Raises `BadInput` for what has no derivatives."""
        if not COMPILED or not isinstance(component, KernelComponent):
            raise BadInput(
                f"derivatives of {component.name}", "a component in plain Python" if COMPILED else "no machine code", ALONE
            )
        from ...fmus.derivatives.compiled import Arena, Compiled
        from ...fmus.derivatives.grammar import Unsupported

        self._name, block = component.name, component.block
        assert block is not None
        try:
            code = Compiled([compile_entries(source_of(component))], width)
        except Unsupported as error:
            raise BadInput(f"derivatives of {component.name}", str(error), "instructions that have a derivative") from None
        self._step, self._arena, self._size = code.entry("model_step", 2), Arena(block.cells, width), block.cells
        self._arena.cells[: self._size] = block.memory
        self._cells = np.concatenate([np.zeros(0, dtype=int), *(np.arange(*ends) for ends in block.ranges("x"))])
        self._inputs = block.cell("s", "u") + np.arange(len(component.inputs))

    @property
    def x(self) -> np.ndarray:
        """The state, (n,)."""
        return self._arena.cells[self._cells]

    @property
    def tangents(self) -> np.ndarray:
        """Of the state, (n, width)."""
        return self._arena.tangents[self._cells]

    def seed(self, places: Sequence[int] | np.ndarray, directions: np.ndarray, *, of_inputs: bool = False) -> None:
        """Tangents of places of the state, or of the inputs, (m, d); all others are 0."""
        self._arena.tangents[: self._size] = 0.0
        self._arena.tangents[(self._inputs if of_inputs else self._cells)[places], : directions.shape[1]] = directions

    def hold(self) -> None:
        """The inputs have no tangents from now on."""
        self._arena.tangents[self._inputs] = 0.0

    def step(self, t: float, h: float) -> None:
        """A step of h, s, from t; raises `StepFailed`."""
        if self._step(t, h, *self._arena.given()):
            raise StepFailed(self._name, t, "a step with derivatives has failed", "See what a step alone says")
