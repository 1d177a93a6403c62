"""States of an FMU: saved in its own memory, restored, and as bytes for a file."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from typing import Any

from .inputs import WARNING, Functions

# what FMI 2 and 3 call the same functions
NAMES = {False: ("GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializedFMUstateSize", "SerializeFMUstate",
                 "DeSerializeFMUstate"),
         True: ("GetFMUState", "SetFMUState", "FreeFMUState", "SerializedFMUStateSize", "SerializeFMUState",
                "DeserializeFMUState")}


class State:
    """A state of the FMU, in its own memory, and the event it had announced (s)."""

    def __init__(self, next_event: float):
        self.handle, self.next_event = ctypes.c_void_p(), next_event
        self.place = ctypes.addressof(self.handle)


class States:
    """All states that are kept of one instance."""

    def __init__(self, fmi3: bool, instance: Any, functions: Functions, failed: Callable[[int], None]):
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        types = ((pointer,), (pointer,), (pointer,), (pointer, pointer), (pointer, pointer, size), (pointer, size, pointer))
        self._instance, self._failed = instance, failed
        self._get, self._set, self._free, self._size, self._serialize, self._deserialize = (
            functions(name, *t) for name, t in zip(NAMES[fmi3], types, strict=True))
        self._kept: dict[int, State] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def _check(self, status: int) -> None:
        if status > WARNING:
            self._failed(status)

    def save(self, next_event: float, reuse: State | None) -> State:
        """The present state, in the memory of an older one if it may be overwritten."""
        state = reuse or State(next_event)
        state.next_event = next_event
        self._kept[state.place] = state
        self._check(self._get(self._instance, state.place))
        return state

    def restore(self, state: State) -> None:
        """Back to a state; it can be restored again."""
        self._check(self._set(self._instance, state.handle))

    def release(self, state: State) -> None:
        """Give its memory back."""
        del self._kept[state.place]
        self._check(self._free(self._instance, state.place))

    def pack(self, state: State) -> bytes:
        """The FMU's own bytes behind the announced event."""
        size = ctypes.c_size_t()
        self._check(self._size(self._instance, state.handle, ctypes.addressof(size)))
        buffer = (ctypes.c_char * size.value)()
        self._check(self._serialize(self._instance, state.handle, ctypes.addressof(buffer), size.value))
        return struct.pack("<d", state.next_event) + buffer.raw

    def unpack(self, packed: bytes) -> State:
        """The state of `pack`, in the FMU's memory."""
        state = State(*struct.unpack("<d", packed[:8]))
        buffer = (ctypes.c_char * (len(packed) - 8)).from_buffer_copy(packed, 8)
        self._check(self._deserialize(self._instance, ctypes.addressof(buffer), len(packed) - 8, state.place))
        self._kept[state.place] = state
        return state

    def close(self) -> None:
        """Free all of them."""
        for state in self._kept.values():
            self._free(self._instance, state.place)
        self._kept.clear()
