"""A mass on a spring as a linear Gaussian system in closed form: the truth of tests, and their independent answers."""

from __future__ import annotations

from dataclasses import dataclass

import cosimo
import numpy as np
from scipy.linalg import expm

MASS, STIFFNESS, DAMPING = 1.0, 100.0, 0.4
KICK, NOISE = 0.5, 5e-3  # m/s per root of s; m
START = np.diag([0.02**2, 1.0])  # of position and velocity
SIGNAL = "mass.base_x"


@dataclass(frozen=True)
class Oscillator:
    """Kicked at the start of each step, measured at every so many steps.

    h: s.  every: steps from measurement to measurement, count: of them.
    """

    h: float = 0.01
    every: int = 5
    count: int = 80
    stiffness: float = STIFFNESS
    damping: float = DAMPING
    kick: float = KICK
    noise: float = NOISE

    @property
    def F(self) -> np.ndarray:
        """Of a step, (2, 2)."""
        return expm(np.array([[0.0, 1.0], [-self.stiffness / MASS, -self.damping / MASS]]) * self.h)

    @property
    def Q(self) -> np.ndarray:
        """Of the kick before a step, (2, 2)."""
        return np.diag([0.0, self.kick**2 * self.h])

    @property
    def times(self) -> np.ndarray:
        """Of the measurements, (n,) s."""
        return self.h * self.every * np.arange(1, self.count + 1)

    def drawn(self, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """(measured (n,), true position and velocity there (n, 2)); the first kick comes behind the first step, as that of a filter."""
        rng = np.random.default_rng(seed)
        z, y, truth = np.sqrt(np.diag(START)) * rng.standard_normal(2), [], []
        for k in range(self.every * self.count):
            if k:
                z = z + np.array([0.0, self.kick * np.sqrt(self.h) * rng.standard_normal()])
            z = self.F @ z
            if (k + 1) % self.every == 0:
                y.append(z[0] + self.noise * rng.standard_normal())
                truth.append(z.copy())
        return np.array(y), np.array(truth)

    def filtered(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """The Kalman filter by hand: (means (n, 2), covariances (n, 2, 2), log-likelihood)."""
        m, P, out, density = np.zeros(2), START.copy(), [], 0.0
        for k in range(self.every * self.count):
            P = P + (self.Q if k else 0.0)
            m, P = self.F @ m, self.F @ P @ self.F.T
            if (k + 1) % self.every == 0:
                S, v = P[0, 0] + self.noise**2, y[k // self.every] - m[0]
                density -= 0.5 * (v * v / S + np.log(2.0 * np.pi * S))
                gain = P[:, 0] / S
                m, P = m + gain * v, P - np.outer(gain, gain) * S
                out.append((m, P))
        means, covariances = (np.array(parts) for parts in zip(*out, strict=True))
        return means, covariances, density

    def stacked(self) -> tuple[np.ndarray, np.ndarray]:
        """Of all states behind the steps, (2 N, 2 N), and which places of them are measured: the joint normal distribution."""
        steps = self.every * self.count
        P, blocks = START.copy(), np.zeros((2 * steps, 2 * steps))
        for k in range(steps):
            P = self.F @ (P + (self.Q if k else 0.0)) @ self.F.T
            for j in range(k, steps):
                block = np.linalg.matrix_power(self.F, j - k) @ P
                blocks[2 * j : 2 * j + 2, 2 * k : 2 * k + 2] = block
                blocks[2 * k : 2 * k + 2, 2 * j : 2 * j + 2] = block.T
        return blocks, 2 * (self.every * np.arange(1, self.count + 1) - 1)

    def scene(self, **changes):
        """The same as a coupled scene."""
        changes = {"spring.damping": self.damping, "spring.stiffness": self.stiffness, "mass.start_velocity_x": 0.0} | changes
        return cosimo.load_scene("mass-on-spring").with_changes({"master.step": self.h, **changes})

    def plan(self, **changes):
        """What a user would say of it: the start is not known, and kicks disturb the velocity."""
        return {
            "measured": [{"signal": SIGNAL, "noise": self.noise}],
            "estimated": {"mass.start_x": {"deviation": "20 mm"}, "mass.start_velocity_x": {"deviation": 1.0}},
            "states": {"mass.base_velocity_x": {"walk": self.kick}},
        } | changes

    def estimate(self, y, scene=None, **changes):
        """By cosimo."""
        given = {"halved": False} | {k: changes.pop(k) for k in ("halved", "say") if k in changes}
        return cosimo.estimate(scene or self.scene(), self.plan(**changes), data={SIGNAL: (self.times, y)}, **given)
