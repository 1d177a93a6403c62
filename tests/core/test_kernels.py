"""What is compiled into a kernel."""

import sys
from functools import partial

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED, kernel


@partial(kernel, counted=False)
def uncounted_total(row):
    s = 0.0
    for v in row[1:]:
        s += v
    return s


@pytest.mark.skipif(not COMPILED, reason="without Numba nothing is compiled")
def test_a_kernel_that_counts_no_references_neither_keeps_nor_frees_its_arrays():
    row = np.arange(4.0)
    before = sys.getrefcount(row)
    assert [uncounted_total(row) for _ in range(10)] == [6.0] * 10
    assert sys.getrefcount(row) == before
