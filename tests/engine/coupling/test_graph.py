"""Strongly connected groups of a graph."""

import numpy as np
from cosimo.orchestrator.engine.coupling.graph import _strong
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

POINTS = 12


@given(
    st.integers(1, POINTS).flatmap(
        lambda n: st.tuples(st.just(n), st.sets(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)), max_size=3 * n))
    )
)
def test_groups_are_those_that_scipy_finds(graph):
    n, pairs = graph
    rows, columns = np.array(sorted(pairs), dtype=int).reshape(-1, 2).T
    expected = connected_components(coo_array((np.ones(len(pairs)), (rows, columns)), shape=(n, n)), connection="strong")[1]
    found = np.array(_strong(n, pairs))
    assert ((found[:, None] == found) == (expected[:, None] == expected)).all()


def test_a_long_chain_is_no_recursion():
    assert len(set(_strong(5000, [(k, k + 1) for k in range(4999)]))) == 5000
    assert len(set(_strong(5000, [(k, (k + 1) % 5000) for k in range(5000)]))) == 1
