"""Turbine and averaged converter as two equations of their own: equilibria and eigenvalues, without the components.

Jt w' = T(w, v) - n (k1 n w - k2 w2) w2        J2 w2' = k1 n² w² - k2 n w w2 - T_load
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

DENSITY, RADIUS = 1.225, 1.5  # kg/m³, m: defaults of the turbine
AREA = math.pi * RADIUS**2
K1, K2 = 0.2 / math.pi, 0.10125 / math.pi  # N m s²: of the default converter, 2/pi rho m a b r and 2/pi rho² (m b² + m_y)
LEVER, SLIDER = 20.0, 0.25  # kg, of the default converter
Coefficient = Callable[[float], float]


def farm(ratio: float) -> float:
    """Torque coefficient of the farm windmill."""
    return 0.5 * (1.0 - ratio / 2.4)


def heier(ratio: float) -> float:
    """Torque coefficient of Heier's curve at no pitch, from a tip speed ratio of 0.5 on; no less than 0."""
    held = max(ratio, 0.5)
    inverse = 1.0 / held - 0.035
    return max(0.5176 * (116.0 * inverse - 5.0) * math.exp(-21.0 * inverse) + 0.0068 * held, 0.0) / held


@dataclass(frozen=True)
class Plant:
    """A turbine of a torque coefficient behind a gear and the averaged converter. inertias: turbine, driven shaft, kg m².

    lever: its mass, kg.
    """

    coefficient: Coefficient
    gear: float
    largest_ratio: float  # tip speed ratio up to which equilibria are sought
    inertias: tuple[float, float] = (15.0, 1.0)
    lever: float = LEVER

    @property
    def k1(self) -> float:
        """Torque of a stalled converter over the square of the crank's speed, N m s²."""
        return K1 * self.lever / LEVER

    @property
    def k2(self) -> float:
        """What the driven shaft's speed takes of it, N m s²; the output's slider has a mass, too."""
        return K2 * (self.lever + SLIDER) / (LEVER + SLIDER)

    def turbine_torque(self, speed: float, wind: float) -> float:
        """N.m at a speed of the turbine, rad/s, and a wind, m/s."""
        return 0.5 * DENSITY * AREA * RADIUS * wind**2 * self.coefficient(speed * RADIUS / wind)

    def pump_speed(self, speed: float, load: float) -> float:
        """Speed of the driven shaft, rad/s, at which the converter balances a load in N.m."""
        crank = self.gear * speed
        return (self.k1 * crank**2 - load) / (self.k2 * crank)

    def equilibria(self, wind: float, load: float) -> list[tuple[float, float]]:
        """Speeds of turbine and driven shaft, rad/s, at which both balance while the pump turns, slowest first."""
        low, high = math.sqrt(load / self.k1) / self.gear * (1.0 + 1e-9), self.largest_ratio * wind / RADIUS
        if high <= low:
            return []
        roots = _roots(lambda w: self.turbine_torque(w, wind) * w - load * self.pump_speed(w, load), low, high)
        return [(w, self.pump_speed(w, load)) for w in roots]

    def balanced(self, wind: float, load: float) -> list[float]:
        """Speeds, rad/s, at which a load on the turbine's shaft balances the wind: without a converter."""
        unit = wind / RADIUS
        return _roots(lambda w: self.turbine_torque(w, wind) - load, 0.5 * unit, self.largest_ratio * unit)

    def matrix(self, wind: float, speed: float, pump: float) -> np.ndarray:
        """Derivative of the rates by both speeds, (2, 2), 1/s, at an equilibrium."""
        n, crank = self.gear, self.gear * speed
        slope = self.slope(wind, speed)
        turbine = [slope - n**2 * self.k1 * pump, -n * (self.k1 * crank - 2.0 * self.k2 * pump)]
        driven = [n * (2.0 * self.k1 * crank - self.k2 * pump), -self.k2 * crank]
        return np.array([turbine, driven]) / np.array(self.inertias)[:, None]

    def slope(self, wind: float, speed: float) -> float:
        """Change of the turbine's torque with its speed, N m s/rad."""
        step = 1e-5 * speed
        return (self.turbine_torque(speed + step, wind) - self.turbine_torque(speed - step, wind)) / (2.0 * step)

    def growth(self, wind: float, speed: float, pump: float) -> float:
        """Largest real part of the eigenvalues, 1/s."""
        return float(np.linalg.eigvals(self.matrix(wind, speed, pump)).real.max())

    def determinant(self, wind: float, speed: float, pump: float) -> float:
        """Jt J2 det of the matrix in closed form: k2 w1 (-T') + 2 n² k1² w1² (1 - s)², s = w2 over its largest, w1 k1 / k2."""
        crank = self.gear * speed
        share = pump * self.k2 / (self.k1 * crank)
        return -self.k2 * crank * self.slope(wind, speed) + 2.0 * (self.gear * self.k1 * crank * (1.0 - share)) ** 2


def _roots(function: Callable[[float], float], low: float, high: float, points: int = 500) -> list[float]:
    """Where a function changes its sign between two ends."""
    at = np.linspace(low, high, points)
    values = np.array([function(x) for x in at.tolist()])
    crossed = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    return [float(brentq(function, at[k], at[k + 1], xtol=1e-13)) for k in crossed]
