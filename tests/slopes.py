"""Orders of convergence, as measured."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def slope(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Order of errors (n,) over sizes of steps or elements (n,): the slope of a line through their logarithms."""
    return float(np.polyfit(np.log(np.asarray(sizes)), np.log(np.asarray(errors)), 1)[0])


def orders(errors: Sequence[float]) -> np.ndarray:
    """Orders (n - 1,) between neighbours of errors (n,) whose steps halve from one to the next."""
    return np.log2(np.divide(errors[:-1], errors[1:]))
