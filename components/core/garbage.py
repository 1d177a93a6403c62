"""How often Python looks for garbage: seldom where much is made and little of it is garbage."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

OBJECTS = 500_000  # made and not freed between two looks; some 50 MB


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Python looks for garbage seldom: a quarter of the start of a command, a tenth of what the compiler takes."""
    before = gc.get_threshold()
    if before[0]:  # 0: Python looks for none
        gc.set_threshold(max(before[0], OBJECTS), 20, 50)
    try:
        yield
    finally:
        gc.set_threshold(*before)
