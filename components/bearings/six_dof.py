"""Kernels of the deep groove bearing with six degrees of freedom: from motion of the inner ring to force and moment on it.

State: angle of the inner ring, angle of the cage (of ball 0) and, with a pit on a ball, its turn against the cage.
The balls' angles are those of ball 0 and a fixed table: a call costs one sine and cosine for all of them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, STEP_TOO_LONG, hold_inputs, kernel, kernel_tuple
from .contacts import COS, ENERGY, GAP, LOADED, MAX_LOAD, SIN, BallContacts, contact_forces
from .film import CENTRAL_EXPONENT
from .races import TWO_PI, add_faults, wrapped

SPEED = 10  # in u, behind displacement (5) and velocity (5)
SAMPLES = 4  # steps a passage over a defect or a wave should take at least
COARSE, UNSEEN = 0, 1  # rows of what `check_passages` notes
FORCE, LARGEST, NUMBER, INNER_ANGLE, CAGE_ANGLE = 0, 5, 6, 7, 8  # in y; five elements from FORCE on


@kernel_tuple
class Constants(NamedTuple):
    """What the kernels need of the parameters, and their workspace."""

    contacts: BallContacts
    cage_ratio: float
    spin_ratio: float
    largest_load: float  # N, of a ball; beyond it the contacts are no small spots any more
    cosine: np.ndarray  # (Z,), directions of the balls seen from ball 0
    sine: np.ndarray
    balls: np.ndarray  # (Z, 4), workspace; see contacts.py
    sums: np.ndarray  # (8,)
    stiffness: np.ndarray  # (5, 5)
    damping: np.ndarray  # (5, 5)


@kernel_tuple
class Films(NamedTuple):
    """Films of both races: thickness = factor * |speed|^0.67."""

    y: int
    inner: float  # m (s/rad)^0.67
    outer: float


@kernel_tuple
class Levers(NamedTuple):
    """Lever of the moments over that of the tilts."""

    ratio: float


def constants(contacts: BallContacts, cage_ratio: float, spin_ratio: float, largest_load: float) -> Constants:
    """Constants of a bearing; workspace included."""
    n = contacts.balls
    at = TWO_PI * np.arange(n) / n
    return Constants(contacts, cage_ratio, spin_ratio, largest_load, np.cos(at), np.sin(at), np.zeros((n, 4)), np.zeros(8),
                     np.zeros((5, 5)), np.zeros((5, 5)))


@kernel
def place(x, speed, p, e):
    """Directions and gaps of all balls into p.balls."""
    balls = p.balls
    c, s = math.cos(x[1]), math.sin(x[1])
    film_thickness = 0.0
    if e.film is not None:
        film_thickness = (e.film.inner + e.film.outer) * abs(speed) ** CENTRAL_EXPONENT
    for j in range(balls.shape[0]):
        balls[j, COS] = c * p.cosine[j] - s * p.sine[j]
        balls[j, SIN] = s * p.cosine[j] + c * p.sine[j]
        balls[j, GAP] = -film_thickness
    add_faults(balls[:, GAP], None, x, speed, p, e)


@kernel
def present_contacts(u, p, growth):
    """The contacts with the present clearance."""
    k = p.contacts
    if growth is not None:
        return BallContacts(k.balls, k.stiffness, k.distance, k.radial - 0.5 * u[growth.u], k.axial, k.lever)
    return k


@kernel
def roll(h, x, u, p):
    """Turn ring, cage and ball with the integral of the speed's polynomial over a step h."""
    turn = h * (u[0, SPEED] + h * (0.5 * u[1, SPEED] + h * u[2, SPEED] / 3.0))
    x[0] = wrapped(x[0] + turn)
    x[1] = wrapped(x[1] + p.cage_ratio * turn)
    for i in range(2, x.size):
        x[i] = wrapped(x[i] + p.spin_ratio * turn)


@kernel
def check_passages(t, h, u, features, noted):
    """Refuses a step in which a defect, or half a wave, could pass unseen; notes the first one that sees too little of it.

    features: (k, 2) extent, rad, and turn of the feature under a ball per turn of the inner ring.  noted: (2, 4) the feature, the
    passages in the step, its length, s, and its beginning, s; feature -1 where there was none.
    The bearing has no internal step that could be capped: between two macro steps it does not know where the rotor is.
    """
    now, slope, half = u[0, SPEED], u[1, SPEED], u[2, SPEED]
    fastest = max(abs(now), abs(now + h * (slope + h * half)))
    if half != 0.0:
        vertex = -0.5 * slope / half
        if 0.0 < vertex < h:
            fastest = max(fastest, abs(now + 0.5 * slope * vertex))
    turn = h * fastest
    for k in range(features.shape[0]):
        passed = turn * features[k, 1] / features[k, 0]
        row = UNSEEN if passed > 1.0 else COARSE
        if passed > 1.0 or (passed * SAMPLES > 1.0 and noted[COARSE, 0] < 0.0):
            noted[row, 0], noted[row, 1], noted[row, 2], noted[row, 3] = k, passed, h, t
        if passed > 1.0:
            return STEP_TOO_LONG
    return DONE


@kernel
def advance(h, x, u, y, p, e):
    """Roll on by h, hold the inputs at their ends, and compute the outputs there; u: (3, m)."""
    roll(h, x, u, p)
    hold_inputs(u, h)
    return bearing_outputs(x, u[0], y, p, e)


@kernel
def bearing_outputs(x, u, y, p, e):
    """All outputs from the angles x and the inputs u (m,).

    Returns DONE, OUT_OF_RANGE for a ring beyond the grooves or a ball beyond its largest load, or NOT_FINITE.
    """
    speed = u[SPEED]
    place(x, speed, p, e)
    contacts = present_contacts(u, p, e.thermal_growth)
    if e.linearisation is not None and e.damping is not None:
        status = contact_forces(u[:5], contacts, p.balls, p.sums, p.stiffness, u[5:10], e.damping.factor, p.damping)
    elif e.linearisation is not None:
        status = contact_forces(u[:5], contacts, p.balls, p.sums, p.stiffness, None, None, None)
    elif e.damping is not None:
        status = contact_forces(u[:5], contacts, p.balls, p.sums, None, u[5:10], e.damping.factor, None)
    else:
        status = contact_forces(u[:5], contacts, p.balls, p.sums, None, None, None, None)
    if status != DONE:
        return status
    if p.sums[MAX_LOAD] > p.largest_load:
        return OUT_OF_RANGE
    if e.published_levers is not None:
        p.sums[3] *= e.published_levers.ratio
        p.sums[4] *= e.published_levers.ratio
    for i in range(5):
        y[FORCE + i] = p.sums[i]
    y[LARGEST], y[NUMBER], y[INNER_ANGLE], y[CAGE_ANGLE] = p.sums[MAX_LOAD], p.sums[LOADED], x[0], x[1]
    if e.film is not None:
        thickness = abs(speed) ** CENTRAL_EXPONENT
        y[e.film.y], y[e.film.y + 1] = e.film.inner * thickness, e.film.outer * thickness
    if e.linearisation is not None:
        linearise(u, y, p, e.published_levers, e.linearisation)
    if e.friction is not None:
        load = math.sqrt(p.sums[0] ** 2 + p.sums[1] ** 2 + p.sums[2] ** 2)
        torque = 0.5 * e.friction.coefficient * e.friction.bore_diameter * load
        y[e.friction.y] = -torque if speed > 0.0 else torque if speed < 0.0 else 0.0
        y[e.friction.y + 1] = torque * abs(speed)
    for i in range(y.size):
        if not math.isfinite(y[i]):
            return NOT_FINITE
    return DONE


@kernel
def linearise(u, y, p, levers, linear):
    """The bearing as F = force - stiffness q - damping q' near the present motion: force, stiffness, damping into y."""
    first = linear.y + 5
    if p.sums[LOADED] < 1.5:
        p.stiffness[0, 0] += linear.idle_stiffness
        p.stiffness[1, 1] += linear.idle_stiffness
    for i in range(5):
        share = 1.0
        if levers is not None and i > 2:
            share = levers.ratio
        force = p.sums[i]
        for j in range(5):
            k, c = share * p.stiffness[i, j], share * p.damping[i, j]
            force += k * u[j] + c * u[5 + j]
            y[first + 5 * i + j] = k
            y[first + 25 + 5 * i + j] = c
        y[linear.y + i] = force


@kernel
def elastic_energy(x, u, p, e):
    """Energy of the contacts, J."""
    place(x, u[SPEED], p, e)
    contact_forces(u[:5], present_contacts(u, p, e.thermal_growth), p.balls, p.sums, None, None, None, None)
    return p.sums[ENERGY]

