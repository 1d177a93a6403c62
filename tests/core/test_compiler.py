"""References to arrays are counted where a kernel makes or gives back arrays, and nowhere else."""

import gc
import sys

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED, kernel

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")


@kernel
def total(row):
    s = 0.0
    for v in row[1:]:
        s += v
    return s


@kernel
def made(n):
    row = np.zeros(n)
    row[0] = 2.0
    return row


@kernel
def total_made(n):
    return 1.0 + made(n).sum()


@kernel
def ends(row):
    return row[:1], row[1:]


@kernel
def total_of_ends(row):
    first, others = ends(row)
    return total(first) + total(others) + first[0]


def test_a_kernel_that_makes_no_array_counts_nothing():
    row = np.arange(4.0)
    before = sys.getrefcount(row)
    assert [total(row) for _ in range(10)] == [6.0] * 10
    assert sys.getrefcount(row) == before
    (compiled,) = total.overloads.values()
    assert not compiled.target_context.enable_nrt


def test_kernels_that_make_arrays_run_from_kernels_and_from_python():
    assert total_made(3) == 3.0
    assert made(3).tolist() == [2.0, 0.0, 0.0]
    with pytest.raises(Exception, match="no_such_function"):
        kernel(lambda x: np.no_such_function(x))(1.0)


def test_views_of_an_array_keep_it_and_are_seen_by_kernels():
    row = np.arange(3.0)
    assert total_of_ends(row) == 2.0
    first, others = ends(row)
    row[:] += 1.0
    del row
    gc.collect()
    assert first.tolist() == [1.0]
    assert others.tolist() == [2.0, 3.0]
