"""Saved states of a session: held by it, or as bytes for another one of the same scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...components.core.errors import BadInput
from ...fmus.versions import version
from ..checkpoint import digest
from ..engine.algorithms.master import Saved
from ..scene.scene import Scene
from ..units import Simulator
from ..verified_file import DamagedFile, verified_bytes, verified_content

FORMAT = "cosimo session 1"


class State:
    """All that the next steps of a session depend on; bytes(state) holds the same, for a file or another process."""

    def __init__(
        self,
        master: Saved,
        tick: int,
        stepping: Mapping[str, Any],
        inputs: Mapping[tuple[str, str], Any],
        units: Sequence[Simulator],
        to_bytes: Callable[[State], bytes],
    ):
        """units: which hold parts of it, in the order of the master's.  inputs: set by hand."""
        self.master, self.tick, self.stepping, self.inputs, self.units = master, tick, stepping, inputs, units
        self.released, self._to_bytes = False, to_bytes

    def release(self) -> None:
        """Give back what FMUs hold for it; it cannot be restored any more."""
        if not self.released:
            self.released = True
            for unit, state in zip(self.units, self.master.units, strict=True):
                unit.release(state)

    def __del__(self) -> None:
        self.release()

    def __bytes__(self) -> bytes:
        return self._to_bytes(self)


def packed(scene: Scene, state: Mapping[str, Any]) -> bytes:
    """A state as bytes that say which scene it belongs to, with a digest that shows damage."""
    return verified_bytes({"format": FORMAT, "version": version("cosimo"), "scene": digest(scene), **state})


def unpacked(content: bytes, scene: Scene, where: str) -> Mapping[str, Any]:
    """What `packed` was given; raises `BadInput` for bytes that are damaged, or of another scene or version."""
    try:
        state = verified_content(content)
    except (DamagedFile, ValueError):
        raise BadInput(where, f"{len(content)} bytes", "bytes of a state that a session has saved, undamaged") from None
    if not isinstance(state, Mapping) or state.get("format") != FORMAT or state["version"] != version("cosimo"):
        raise BadInput(where, f"{len(content)} bytes", f"a state that a session of cosimo {version('cosimo')} has saved")
    if state["scene"] != digest(scene):
        raise BadInput(where, "a state of another scene, or of other parameters", f"one of {scene.name} as it is now")
    return state
