"""Mean speed of a vibrating robot by balance of its first harmonic, in closed form: what the design chart draws.

The body's velocity is taken as V + b cos(w t). Over a period the momentum must balance, which fixes the share tau of the period
in which it slips forwards; the friction, a square wave, has the first harmonic R1 against the velocity; amplitude b follows
from the two-mass system with both forces, and V from the instants at which the velocity changes its sign.
Own derivation. It is of first order in eps = R1 / (m1 w b), the share of friction in the body's acceleration.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

from ...robots import BACKWARD, BODY, DAMPING, FORWARD, GRAVITY, INNER, STIFFNESS


@dataclass(frozen=True)
class Design:
    """A robot, its exciter and its pipe: kg, N/m, N.s/m, N, rad/s, N, N, sine of the slope, N (positive forwards)."""

    stiffness: float = STIFFNESS
    damping: float = DAMPING
    force: float = 20.0
    frequency: float = 60.0
    forward: float = FORWARD
    backward: float = BACKWARD
    sine: float = 0.0
    tow: float = 0.0
    body: float = BODY
    inner: float = INNER

    @property
    def resonance(self) -> float:
        """Of the inner mass against the free body, rad/s."""
        return math.sqrt(self.stiffness * (1.0 / self.body + 1.0 / self.inner))

    @property
    def load(self) -> float:
        """What weight and tow pull backwards, N."""
        return (self.body + self.inner) * GRAVITY * self.sine - self.tow

    @property
    def forward_share(self) -> float:
        """tau: share of the period in forward slip, by the balance of momentum; below 0 or above 1 there is none."""
        return (self.backward - self.load) / (self.forward + self.backward)

    def at(self, **changes: float) -> Design:
        """The design with some values changed; ratio: frequency over the resonance."""
        ratio = changes.pop("ratio", None)
        changed = replace(self, **changes)
        return changed if ratio is None else replace(changed, frequency=ratio * changed.resonance)

    def parameters(self) -> dict[str, float]:
        """Of the component `PipeRobot` with harmonic force, tow and route."""
        return {"stiffness": self.stiffness, "damping": self.damping, "harmonic_force.amplitude": self.force,
                "harmonic_force.frequency": self.frequency, "forward_friction": self.forward, "backward_friction": self.backward,
                "route.slope": math.asin(self.sine), "tow.force": self.tow, "body_mass": self.body,
                "inner_mass": self.inner}  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """speed: mean, m/s; amplitude: b, m/s; epsilon: R1 / (m1 w b), how good the balance is. NaN where it has no solution."""

    speed: float
    amplitude: float
    epsilon: float

    @property
    def error(self) -> float:
        """What the balance may differ from the motion, m/s: half of epsilon of the speed, and 1 % of the amplitude."""
        return 0.5 * self.epsilon * abs(self.speed) + 0.01 * self.amplitude


def balance(design: Design) -> Answer:
    """The balance of the first harmonic."""
    w, tau = design.frequency, design.forward_share
    if not 0.0 < tau < 1.0:
        return Answer(math.nan, math.nan, math.nan)
    spring = complex(design.stiffness, design.damping * w)
    free, inner = spring - design.body * w * w, spring - design.inner * w * w
    determinant = free * inner - spring * spring
    own = 1j * w * inner / determinant  # body's velocity over a force on it
    pair = 1j * w * (inner - spring) / determinant  # over the exciter's force on body and inner mass
    friction = 2.0 / math.pi * (design.forward + design.backward) * math.sin(math.pi * tau)
    # |b + own R1| = |pair F0|
    root = (abs(pair) * design.force) ** 2 - (friction * own.imag) ** 2
    b = -friction * own.real + math.sqrt(root) if root >= 0.0 else math.nan
    if not b > 0.0:
        return Answer(math.nan, math.nan, math.nan)
    return Answer(-b * math.cos(math.pi * tau), b, friction / (design.body * w * b))


def breakaway(design: Design) -> float:
    """Amplitude of the force at which a body that stands on the level begins to slip forwards, N.

    The inner mass moves alone, and spring, damper and exciter together act on the body with m2 w² X2.
    """
    w2 = design.inner * design.frequency**2
    return design.forward * abs(cmath.rect(design.stiffness - w2, 0.0) + 1j * design.damping * design.frequency) / w2
