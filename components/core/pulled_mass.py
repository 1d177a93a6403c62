"""A mass of 1 kg that a spring pulls over a surface: the motion by which laws of dry friction are compared.

The spring's end moves at a constant speed from t = 0 on; the mass rests until the spring overcomes the static friction, slides,
and rests again. With bristles (LuGre) the numbers are those of Canudas de Wit and others (IEEE TAC 40, 1995, 419-425), as we
recall them; with a rigid contact friction jumps from static to kinetic, and the motion between is known in closed form.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .events import ROWS, rk4_events
from .friction import lugre_force, lugre_rate, stick_friction, stick_guard, stick_switch
from .integrators import SUBSTEP
from .kernels import DONE, bind, kernel, kernel_tuple

PULL, SPRING = 0.1, 2.0  # m/s, N/m
SAMPLE = 1e-3  # s


@kernel_tuple
class Pulled(NamedTuple):
    """A mass of 1 kg that a spring pulls: its friction, and the longest step, s."""

    kinetic: float
    static: float
    stribeck: float
    stiffness: float
    damping: float
    viscous: float
    substep: float


@kernel_tuple
class Motion(NamedTuple):
    """Arrays that a step of the mass changes, as the template of a step needs them."""

    u: np.ndarray  # (3, 0)
    y: np.ndarray  # (2,) way and velocity
    x: np.ndarray  # (3,) way, velocity, deflection of the bristles or mode
    counts: np.ndarray
    limits: np.ndarray
    work: np.ndarray
    guards: np.ndarray


LUGRE = Pulled(1.0, 1.5, 1e-3, 1e5, math.sqrt(1e5), 0.4, 2e-5)
IDEAL = Pulled(1.0, 1.5, 1.0, 0.0, 0.0, 0.0, 1e-3)  # rigid contact, a jump of friction, nothing viscous


@kernel
def spring_force(t, x):
    """Force of the spring whose other end moves, N; x: way and velocity of the mass first."""
    return SPRING * (PULL * t - x[0])


@kernel
def pulled_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (way, velocity, deflection of the bristles or mode)."""
    pull = spring_force(t, x)
    dx[0] = x[1]
    if p.stiffness > 0.0:
        dx[2] = lugre_rate(x[1], x[2], p.stiffness, p.kinetic, p.static, p.stribeck, 1.0 / p.substep)
        dx[1] = pull - lugre_force(x[1], x[2], dx[2], p.stiffness, p.damping, p.viscous)
    else:
        dx[1], dx[2] = pull - stick_friction(x[2], pull, p.kinetic), 0.0


@kernel
def pulled_guards(t, x, u, g, s, p, e):
    """Guard: positive while the mode of the rigid contact lasts; bristles have none."""
    g[0] = 1.0 if p.stiffness > 0.0 else stick_guard(x[2], x[1], spring_force(t, x), p.static)


@kernel
def pulled_switch(which, t, x, u, s, p, e):
    """The mass comes to rest or breaks loose."""
    x[1] = 0.0
    x[2] = stick_switch(x[2], spring_force(t, x), p.static)


@kernel
def pulled_outputs(t, s, p, e):
    """Way and velocity."""
    s.y[0], s.y[1] = s.x[0], s.x[1]
    return DONE


pulled_step = bind(rk4_events, __name__, derivatives=pulled_derivatives, guards=pulled_guards, switch=pulled_switch,
                   outputs=pulled_outputs)  # fmt: skip


def pulled(p: Pulled, end: float) -> np.ndarray:
    """Time, way and velocity at the samples of a mass that starts at rest, (n, 3)."""
    s = Motion(u=np.zeros((3, 0)), y=np.zeros(2), x=np.zeros(3), counts=np.zeros(3, dtype=np.int64), limits=np.zeros(2),
               work=np.zeros((ROWS, 3)), guards=np.zeros(1))  # fmt: skip
    s.limits[SUBSTEP] = p.substep
    rows = [(0.0, 0.0, 0.0)]
    for k in range(round(end / SAMPLE)):
        pulled_step(k * SAMPLE, SAMPLE, s, p, None)
        rows.append(((k + 1) * SAMPLE, *s.y))
    return np.array(rows)
