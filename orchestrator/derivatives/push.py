"""How a small push of the coupling grows along a run: tangents of the exchanged signals, with macro steps of any length."""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np

from ..scene.scene import Scene
from .tangent_block import Instant, TangentBlock


class PushedScene:
    """A scene that goes on from any instant it was at, with macro steps of any length and the tangent of one push.

    block: of one direction, at first at the start of the scene.
    """

    def __init__(self, scene: Scene, stack: ExitStack):
        """`stack` closes the units. Raises `BadInput` for what has no derivatives, `StepFailed` where the scene does not start."""
        self.block = block = TangentBlock(scene, stack, width=1)
        block.start()
        interfaces, memory = scene.coupling.interfaces, block.master.records.memory
        self._nominal = np.array([interfaces[unit].outputs[name].nominal for unit, name in block.signals])
        seeds: list[int] = []
        sizes: list[float] = []
        for node in block.master.nodes:
            for k, link in enumerate(node.links, start=int(memory.units["first_link"][node.called])):
                samples = block.samples(k)
                seeds += samples
                sizes += len(samples) * [interfaces[link.target[0]].inputs[link.target[1]].nominal]
        self._seeds, self._push = seeds, np.array(sizes) * np.random.default_rng(0).standard_normal(len(sizes))

    def back(self, instant: Instant, h: float) -> None:
        """To an instant, without tangents; macro steps of h, s, from there on."""
        self.block.restore(instant)
        self.block.seed()
        self.block.pace(h)

    def push(self, along: np.ndarray | None = None, new: float = 1.0) -> None:
        """Add tangents along a direction of all cells, (n,), and `new` times those of the samples that inputs follow from.

        The latter are of the sizes of the inputs' nominal values; without a direction they are all.
        """
        if along is not None:
            self.block.tangents[:, 0] += along
        self.block.tangents[self._seeds, 0] += self._push if along is None else new * self._push

    def direction(self, size: float) -> np.ndarray | None:
        """What a push has become, (n,), over its `size`; None where nothing is left, or too much."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            along = (self.block.tangents[:, 0] - self.block.still[:, 0]) / size
        return along if np.isfinite(along).all() else None

    def sizes(self, steps: int) -> np.ndarray:
        """Of the tangents of the signals behind each of some macro steps, over their nominal values, (n,); raises `StepFailed`."""
        with np.errstate(over="ignore", invalid="ignore"):
            return np.concatenate([np.linalg.norm(by[:, :, 0] / self._nominal, axis=1) for _, by in self.block.rows(steps)])
