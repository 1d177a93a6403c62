"""How a small push of the coupling grows along a run: tangents of the exchanged signals, with macro steps of any length."""

from __future__ import annotations

from contextlib import ExitStack
from math import inf
from typing import NamedTuple

import numpy as np

from ..scene.scene import Scene
from .coupled_step import SAMPLES
from .tangent_run import CHUNK, TangentScene


class Instant(NamedTuple):
    """Where a scene stands: the time, s, and all its cells."""

    t: float
    cells: np.ndarray


class PushedScene(TangentScene):
    """A scene that goes on from any instant it was at, with macro steps of any length and the tangent of one push."""

    def __init__(self, scene: Scene, stack: ExitStack):
        """At the start of the scene; `stack` closes the units. Raises `BadInput` for what has no derivatives, `StepFailed`."""
        super().__init__(scene, stack, width=1)
        self.start()
        self.end_at(inf)
        self.t, self._own = scene.start_time, slice(self.layout.cells)
        self._still = self._arena.tangents[self._own].copy()  # the addresses of derivatives
        interfaces, memory = scene.coupling.interfaces, self.master.records.memory
        self._nominal = np.array([interfaces[unit].outputs[name].nominal for unit, name in self.signals])
        seeds: list[int] = []
        sizes: list[float] = []
        for node in self.master.nodes:
            for k, link in enumerate(node.links, start=int(memory.units["first_link"][node.called])):
                fields = SAMPLES[: int(memory.pasts["degree"][memory.links["past"][k]]) + 1]
                seeds += (self._cell("links", k, field) for field in fields)
                sizes += len(fields) * [interfaces[link.target[0]].inputs[link.target[1]].nominal]
        self._seeds, self._push = seeds, np.array(sizes) * np.random.default_rng(0).standard_normal(len(sizes))

    def save(self) -> Instant:
        """Where it stands."""
        return Instant(self.t, self._arena.cells[self._own].copy())

    def restore(self, instant: Instant) -> None:
        """Back to an instant; tangents are 0."""
        self.t, self._arena.cells[self._own] = instant
        self._arena.tangents[self._own] = self._still

    def push(self) -> None:
        """Add tangents to all samples that inputs follow from, of the sizes of the inputs' nominal values."""
        self._arena.tangents[self._seeds, 0] += self._push

    def advance(self, h: float, n: int) -> np.ndarray:
        """n macro steps of h, s; how large the tangents of the signals are behind each, over their nominal values, (n,).

        Raises `StepFailed`.
        """
        sizes = []
        for done in range(0, n, CHUNK):
            steps = min(CHUNK, n - done)
            rows = self._arena.tangents[self.take_steps(self.t + h * np.arange(steps), h), 0]
            with np.errstate(over="ignore", invalid="ignore"):
                sizes.append(np.linalg.norm(rows.reshape(steps, -1) / self._nominal, axis=1))
            self.t += steps * h
        return np.concatenate(sizes)
