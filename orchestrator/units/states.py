"""States of an FMU: saved in its own memory, restored, and as bytes for a file."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

from ..verified_file import packed, unpacked
from .inputs import WARNING, Functions

# what FMI 2 and 3 call the same functions
NAMES = {
    False: ("GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
    True: ("GetFMUState", "SetFMUState", "FreeFMUState", "SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"),
}


class FmuState:
    """A state of the FMU, in its own memory, and what the unit knows beside it: plain numbers and texts."""

    def __init__(self) -> None:
        self.handle = ctypes.c_void_p()
        self.place = ctypes.addressof(self.handle)
        self.beside: Any = None


class States:
    """All states that are kept of one instance."""

    def __init__(self, fmi3: bool, instance: Any, functions: Functions, failed: Callable[[int], None]):
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        types = ((pointer,), (pointer,), (pointer,), (pointer, pointer), (pointer, pointer, size), (pointer, size, pointer))
        self._instance, self._failed = instance, failed
        self._get, self._set, self._free, self._size, self._serialize, self._deserialize = (
            functions(name, *t) for name, t in zip(NAMES[fmi3], types, strict=True)
        )
        self._kept: dict[int, FmuState] = {}
        self.none = True  # no state that could be restored is kept: what DoStep wants to know in every step

    def _check(self, status: int) -> None:
        if status > WARNING:
            self._failed(status)

    def save(self, beside: Any, reuse: FmuState | None) -> FmuState:
        """The present state, in the memory of an older one if it may be overwritten."""
        state = reuse or FmuState()
        state.beside = beside
        self._kept[state.place], self.none = state, False
        self._check(self._get(self._instance, state.place))
        return state

    def of_steps(self) -> FmuState | None:
        """For `note`: one that is kept as long as the FMU is; None where it only says that it saves states."""
        state = FmuState()
        if self._get(self._instance, state.place) > WARNING:
            return None
        self._kept[state.place], self.none = state, False
        return state

    def note(self, state: FmuState) -> None:
        """The state where a step begins."""
        self._check(self._get(self._instance, state.place))

    def restore(self, state: FmuState) -> None:
        """Back to a state; it can be restored again."""
        self._check(self._set(self._instance, state.handle))

    def release(self, state: FmuState) -> None:
        """Give its memory back."""
        del self._kept[state.place]
        self.none = not self._kept
        self._check(self._free(self._instance, state.place))

    def pack(self, state: FmuState) -> bytes:
        """What the unit knows, and the FMU's own bytes."""
        size = ctypes.c_size_t()
        self._check(self._size(self._instance, state.handle, ctypes.addressof(size)))
        buffer = (ctypes.c_char * size.value)()
        self._check(self._serialize(self._instance, state.handle, ctypes.addressof(buffer), size.value))
        return packed([state.beside, buffer.raw])

    def unpack(self, content: bytes) -> FmuState:
        """The state of `pack`, in the FMU's memory."""
        state = FmuState()
        state.beside, own = unpacked(content)
        buffer = (ctypes.c_char * len(own)).from_buffer_copy(own)
        self._check(self._deserialize(self._instance, ctypes.addressof(buffer), len(buffer), state.place))
        self._kept[state.place], self.none = state, False
        return state

    def close(self) -> None:
        """Free all of them."""
        for state in self._kept.values():
            self._free(self._instance, state.place)
        self._kept.clear()
