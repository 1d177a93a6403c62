"""Python as an entry for compiled code: what a unit is that has no machine code of its own."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

from ...components.core.block import ENTRY
from ...components.core.kernels import DONE, RAISED


class Callback:
    """A function of t and h as function and argument of an entry. Keeps what it has raised."""

    argument = 0
    error: BaseException | None = None

    def __init__(self, python: Callable[[float, float], None]):
        def call(t: float, h: float, _: int | None) -> int:
            try:
                python(t, h)
            except BaseException as error:  # none may pass through compiled code
                self.error = error
                return RAISED
            return DONE

        self._call = ENTRY(call)
        self.function = ctypes.cast(self._call, ctypes.c_void_p).value or 0

    def raise_error(self) -> None:
        """What it has kept, once."""
        if (error := self.error) is not None:
            self.error = None
            raise error
