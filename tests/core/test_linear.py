"""The banded solver against a dense one; a partial factorisation has the bits of a complete one."""

import numpy as np
import pytest
from cosimo.components.core.linear import add_product, banded_product, factor_band, factor_general, solve_band, solve_general
from cosimo.components.core.spectrum import fastest_rate


def random_system(n: int, width: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A positive definite band and its dense matrix."""
    band = np.random.default_rng(seed).normal(size=(n, width))
    band[:, 0] = 2.0 * width + np.abs(band[:, 0])
    dense = np.zeros((n, n))
    for k in range(width):
        dense += np.diag(band[: n - k, k], k) + (np.diag(band[: n - k, k], -k) if k else 0.0)
    return band, dense


@pytest.mark.parametrize("width", [2, 3, 5, 8])
def test_solution_and_product_equal_the_dense_ones(width):
    band, dense = random_system(40, width, width)
    b = np.random.default_rng(1).normal(size=40)
    assert banded_product(band, b) == pytest.approx(dense @ b, rel=1e-12)
    factors, x = band.copy(), b.copy()
    factor_band(factors, 3, 3, 37)  # a window: rows outside take no part
    solve_band(factors, x, 3, 37)
    assert x[3:37] == pytest.approx(np.linalg.solve(dense[3:37, 3:37], b[3:37]), rel=1e-12)
    assert np.array_equal(x[:3], b[:3])
    assert np.array_equal(x[37:], b[37:])


def test_partial_factorisation_has_the_same_bits():
    band, _ = random_system(60, 5, 7)
    factors = band.copy()
    factor_band(factors, 0, 0, 60)
    band[33, 0] += 1.5
    factors[33:] = band[33:]
    factor_band(factors, 0, 33, 60)
    complete = band.copy()
    factor_band(complete, 0, 0, 60)
    assert np.array_equal(factors, complete)


@pytest.mark.parametrize("half_width", [1, 3, 7])
def test_general_solution_and_product_equal_the_dense_ones(half_width):
    n, rng = 30, np.random.default_rng(half_width)
    dense = np.where(np.abs(np.subtract.outer(range(n), range(n))) <= half_width, rng.normal(size=(n, n)), 0.0)
    dense += 4.0 * half_width * np.eye(n)  # no exchange of rows needed
    band = np.zeros((n, 2 * half_width + 1))
    for k in range(-half_width, half_width + 1):
        band[max(0, -k) : n - max(0, k), half_width + k] = np.diag(dense, k)
    x = rng.normal(size=n)
    b = np.ones(n)
    add_product(band, x, b)
    assert b == pytest.approx(1.0 + dense @ x, rel=1e-12)  # rounding of sums of at most 15 terms of either sign
    factor_general(band)
    b -= 1.0
    solve_general(band, b)
    assert b == pytest.approx(x, rel=1e-12)


@pytest.mark.parametrize("damping", [0.0, 19.9, 20.1, 300.0])
def test_fastest_rate_is_the_largest_root(damping):
    """Below and above the critical damping of 20 N.s/m."""
    assert fastest_rate(2.0, damping, 50.0) == pytest.approx(np.abs(np.roots([2.0, damping, 50.0])).max(), rel=1e-12)
