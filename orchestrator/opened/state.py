"""What a session saves: states that it holds, and the inputs that were set by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..engine.algorithms.energy import SavedAccount
from ..engine.algorithms.master import Saved
from ..engine.coupling import Endpoint
from ..units import Simulator


class Inputs(dict[Endpoint, Any]):
    """Inputs that were set by hand, by their ends."""

    def state(self) -> list[Any]:
        """For a saved state."""
        return [[*end, value] for end, value in self.items()]

    def set_state(self, state: Sequence[Any]) -> None:
        """Go on from a `state`."""
        self.clear()
        self.update({(unit, name): value for unit, name, value in state})


class State:
    """All that the next steps of a session depend on; bytes(state) holds the same, for a file or another process."""

    def __init__(
        self,
        master: Saved | SavedAccount,
        tick: int,
        stepping: Mapping[str, Any],
        inputs: Sequence[Any],
        units: Sequence[Simulator],
        to_bytes: Callable[[State], bytes] | None = None,
    ):
        """units: which hold parts of it, in the order of the master's.  inputs: of `Inputs`.  to_bytes: None for one that stays here."""
        self.master, self.tick, self.stepping, self.inputs, self.units = master, tick, stepping, inputs, units
        self.released, self._to_bytes = False, to_bytes

    def release(self) -> None:
        """Give back what FMUs hold for it; it cannot be restored any more."""
        if not self.released:
            self.released = True
            saved = self.master.master if isinstance(self.master, SavedAccount) else self.master
            for unit, state in zip(self.units, saved.units, strict=True):
                unit.release(state)

    def __del__(self) -> None:
        self.release()

    def __bytes__(self) -> bytes:
        assert self._to_bytes is not None
        return self._to_bytes(self)
