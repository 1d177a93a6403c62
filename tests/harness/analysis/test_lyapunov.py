"""Lyapunov exponents against systems whose exponents are known."""

import math

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.components.core.contract import KernelComponent, Kernels
from cosimo.components.core.kernels import COMPILED, DONE, kernel
from cosimo.components.core.variables import output
from cosimo.orchestrator.harness.analysis.lyapunov import lyapunov_spectrum
from cosimo.tests.derivatives.coupled_masses import Owner
from cosimo.tests.support import Mass

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
PART = 5e-3  # of a step of `Lorenz`


@kernel
def start_lorenz(t, s, p, e):
    s.x[0], s.x[1], s.x[2] = 1.0, 2.0, 20.0
    return DONE


@kernel
def slopes(x, y, z):
    return 10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z


@kernel
def step_lorenz(t, h, s, p, e):
    n = round(h / PART)
    d = h / n
    for _ in range(n):
        x, y, z = s.x[0], s.x[1], s.x[2]
        a1, b1, c1 = slopes(x, y, z)
        a2, b2, c2 = slopes(x + 0.5 * d * a1, y + 0.5 * d * b1, z + 0.5 * d * c1)
        a3, b3, c3 = slopes(x + 0.5 * d * a2, y + 0.5 * d * b2, z + 0.5 * d * c2)
        a4, b4, c4 = slopes(x + d * a3, y + d * b3, z + d * c3)
        s.x[0] += d / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        s.x[1] += d / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
        s.x[2] += d / 6.0 * (c1 + 2.0 * (c2 + c3) + c4)
    return DONE


@kernel
def show(t, s, p, e):
    s.y[0] = s.x[0]
    return DONE


class Lorenz(KernelComponent):
    """x' = 10 (y - x), y' = x (28 - z) - y, z' = x y - 8/3 z, by RK4 in steps of 5 ms."""

    out = output("1", "x")
    kernels = Kernels(start_lorenz, step_lorenz, show)

    def shapes(self):
        return {"x": 3}


@kernel
def start_cat(t, s, p, e):
    s.x[0], s.x[1] = 0.1, 0.2
    return DONE


@kernel
def step_cat(t, h, s, p, e):
    x, y = 2.0 * s.x[0] + s.x[1], s.x[0] + s.x[1]
    s.x[0], s.x[1] = x - math.floor(x), y - math.floor(y)
    return DONE


class CatMap(KernelComponent):
    """(x, y) -> (2 x + y, x + y) on the torus, once per unit of time: exponents ln((3 ± sqrt 5) / 2)."""

    out = output("1", "x")
    kernels = Kernels(start_cat, step_cat, show)

    def shapes(self):
        return {"x": 2}


def test_a_linear_system_has_the_real_parts_of_its_eigenvalues():
    mass = Owner(parameters={"m": 2.0, "k": 3.0, "c": 10.0})
    mass.initialize(0.0)
    found = lyapunov_spectrum(mass, (0, 1), (1.0, 1.0), interval=0.05, intervals=400, transient=200)
    expected = np.sort(np.roots([2.0, 10.0, 3.0]).real)[::-1]
    # directions have converged after the transient (e^-46)
    np.testing.assert_allclose(found.exponents, expected, rtol=1e-10)
    assert found.sum == pytest.approx(-10.0 / 2.0, rel=1e-11)


def test_an_underdamped_system_shares_the_sum_equally():
    mass = Owner(parameters={"m": 1.0, "k": 100.0, "c": 0.4})
    mass.initialize(0.0)
    found = lyapunov_spectrum(mass, (0, 1), (1.0, 10.0), interval=0.1, intervals=1000)
    np.testing.assert_allclose(found.exponents, -0.2, atol=0.01)  # a bounded swing of ln(1.02) around it, over 100 s
    assert found.history.shape == (1000, 2)
    assert found.time[-1] == pytest.approx(100.0)


def test_lorenz():
    """The sum is -(10 + 1 + 8/3) exactly, one exponent is zero, the largest is 0.9056 (literature; here over 60 units)."""
    lorenz = Lorenz()
    lorenz.initialize(0.0)
    found = lyapunov_spectrum(lorenz, (0, 1, 2), (10.0, 10.0, 10.0), interval=0.1, intervals=600, transient=100)
    assert found.sum == pytest.approx(-41.0 / 3.0, rel=1e-4)  # RK4 at 5 ms
    assert found.largest == pytest.approx(0.9056, abs=0.1)  # fluctuation of the mean over 60 units
    assert found.exponents[1] == pytest.approx(0.0, abs=0.05)


def test_a_map_by_hand():
    """Tangents know nothing of the edge of the torus."""
    cat = CatMap()
    cat.initialize(0.0)
    found = lyapunov_spectrum(cat, (0, 1), (1.0, 1.0), interval=1.0, intervals=200, transient=20)
    expected = math.log((3.0 + math.sqrt(5.0)) / 2.0)
    np.testing.assert_allclose(found.exponents, (expected, -expected), rtol=1e-12)


def test_the_component_stays_where_it_is():
    mass = Owner()
    mass.initialize(0.0)
    before = mass.save()
    lyapunov_spectrum(mass, (0, 1), (1.0, 1.0), interval=0.1, intervals=20)
    assert mass.save() == before


def test_a_component_in_plain_python_has_no_tangents():
    mass = Mass()
    mass.initialize(0.0)
    with pytest.raises(BadInput, match="plain Python"):
        lyapunov_spectrum(mass, (0, 1), (1.0, 1.0), interval=0.1, intervals=3)
