"""Where an opened scene stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..engine.algorithms import Master
from ..engine.algorithms.master import Saved
from ..scene.scene import Scene


class State:
    """All that the next steps of a session depend on: where the scene stands is its parameters and this.

    bytes(state) holds the same, for a file or another process.
    """

    def __init__(
        self,
        scene: Scene,
        master: Master,
        saved: Saved,
        tick: int,
        stepping: Mapping[str, Any],
        inputs: Sequence[Any],
        to_bytes: Callable[[State], bytes] | None = None,
    ):
        """scene: with the parameters.  master: whose units hold parts of it.  inputs: set by hand, [unit, name, value] of each.

        to_bytes: None for one that stays here.
        """
        self.scene, self.master, self.saved, self.tick = scene, master, saved, tick
        self.stepping, self.inputs = stepping, inputs
        self.released, self._to_bytes = False, to_bytes

    def release(self) -> None:
        """Give back what FMUs hold for it; it cannot be restored any more."""
        if not self.released:
            self.released = True
            self.master.release(self.saved)

    def __del__(self) -> None:
        self.release()

    def __bytes__(self) -> bytes:
        assert self._to_bytes is not None
        return self._to_bytes(self)
