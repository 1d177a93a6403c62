"""Stroboscopic points of the logistic map, whose periods are known."""

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import output, parameter
from cosimo.orchestrator.harness.analysis.sections import distinct, stroboscopic_points
from cosimo.tests.support import initialized


class Logistic(Component):
    """x -> r x (1 - x), once per unit of time."""

    r = parameter(3.2, "1", "growth")
    level = output("1", "x")

    def _initialize(self, t: float) -> int:
        self.x = np.array([0.3])
        return DONE

    def _step(self, t: float, h: float) -> int:
        for _ in range(round(h)):
            self.x[0] *= self["r"] * (1.0 - self.x[0])
        self._outputs(t)
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[0] = self.x[0]


def points_of(growth: float, period: float, points: int, transient: int) -> np.ndarray:
    return stroboscopic_points(initialized(Logistic(parameters={"r": growth})), period, points, ("level",), transient=transient)


def test_periods_of_the_logistic_map():
    found = [points_of(r, 1.0, 120, 2000) for r in (2.9, 3.2, 3.5, 3.83, 3.9)]
    assert [distinct(p, 1e-8) for p in found] == [1, 2, 4, 3, 120]
    assert found[0][0, 0] == pytest.approx(1.0 - 1.0 / 2.9, rel=1e-12)  # the fixed point
    pair = (4.2 + np.array([-1.0, 1.0]) * np.sqrt(4.2 * 0.2)) / 6.4  # (r + 1 ± sqrt((r + 1)(r - 3))) / (2 r)
    np.testing.assert_allclose(np.unique(found[1].round(12)), pair, rtol=1e-11)


def test_looked_at_twice_as_seldom_a_period_of_two_is_one_place():
    made = Logistic()
    made.initialize(0.0)
    points = stroboscopic_points(made, 2.0, 20, ("level",), transient=500)
    assert distinct(points, 1e-8) == 1
    assert made.t == 2.0 * 520
