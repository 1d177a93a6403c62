"""Lyapunov exponents against systems whose exponents are known."""

import math

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import output
from cosimo.orchestrator.harness.analysis.lyapunov import lyapunov_spectrum
from cosimo.tests.support import Mass


class Lorenz(Component):
    """x' = 10 (y - x), y' = x (28 - z) - y, z' = x y - 8/3 z, by RK4 in steps of 5 ms."""

    z = output("1", "z")

    def _initialize(self, t: float) -> int:
        self.x = np.array([1.0, 2.0, 20.0])
        return DONE

    def _step(self, t: float, h: float) -> int:
        def f(x):
            return np.array([10.0 * (x[1] - x[0]), x[0] * (28.0 - x[2]) - x[1], x[0] * x[1] - 8.0 / 3.0 * x[2]])

        n = round(h / 5e-3)
        d = h / n
        for _ in range(n):
            k1 = f(self.x)
            k2 = f(self.x + 0.5 * d * k1)
            k3 = f(self.x + 0.5 * d * k2)
            k4 = f(self.x + d * k3)
            self.x += d / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[0] = self.x[2]


class CatMap(Component):
    """(x, y) -> (2 x + y, x + y) once per unit of time, lifted from the torus: exponents ln((3 ± sqrt 5) / 2)."""

    def _initialize(self, t: float) -> int:
        self.x = np.array([0.1, 0.2])
        return DONE

    def _step(self, t: float, h: float) -> int:
        self.x[:] = (2.0 * self.x[0] + self.x[1]) % 1.0, (self.x[0] + self.x[1]) % 1.0
        return DONE

    def _outputs(self, t: float) -> None:
        """There are none."""


def test_a_linear_system_has_the_real_parts_of_its_eigenvalues():
    mass = Mass(parameters={"m": 2.0, "k": 3.0, "c": 10.0})
    mass.initialize(0.0)
    found = lyapunov_spectrum(mass, (0, 1), (1.0, 1.0), interval=0.05, intervals=400, transient=200)
    expected = np.sort(np.roots([2.0, 10.0, 3.0]).real)[::-1]
    # differences of an exact step have rounding 1e-10; directions have converged after the transient (e^-46)
    np.testing.assert_allclose(found.exponents, expected, rtol=1e-6)
    assert found.sum == pytest.approx(-10.0 / 2.0, rel=1e-8)


def test_an_underdamped_system_shares_the_sum_equally():
    mass = Mass(parameters={"m": 1.0, "k": 100.0, "c": 0.4})
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
    """Perturbations that would cross the edge of the torus jump; with these numbers none does."""
    cat = CatMap()
    cat.initialize(0.0)
    found = lyapunov_spectrum(cat, (0, 1), (1.0, 1.0), interval=1.0, intervals=12, transient=6)
    expected = math.log((3.0 + math.sqrt(5.0)) / 2.0)
    np.testing.assert_allclose(found.exponents, (expected, -expected), rtol=1e-3)  # directions converge as e^(-2*0.96*6)


def test_the_component_is_left_at_the_end_of_the_run():
    mass, other = Mass(), Mass()
    for each in (mass, other):
        each.initialize(0.0)
    lyapunov_spectrum(mass, (0, 1), (1.0, 1.0), interval=0.1, intervals=20)
    for k in range(20):
        other.step(k * 0.1, 0.1)
    assert mass.save() == other.save()
