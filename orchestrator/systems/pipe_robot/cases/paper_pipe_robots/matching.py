"""Mean speed of a vibrating robot by matching exact pieces: between the instants at which its body stops or breaks loose it is linear.

While the body slips its velocity is that of the common centre less a share of the spring's rate; the spring is an oscillator under a
harmonic and a constant force, and so it is about a body that stands. Each piece is written down in closed form; the instants between
them are roots of these forms. Nothing is integrated in steps, and no harmonic is left out: what the balance of the first harmonic
approximates is exact here, for any ratio of friction.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...robots import GRAVITY, TURN
from .balance import Design

SCANNED = 400  # instants in a period at which signs are compared
MOST, LAST = 800, 10  # periods; those of the mean
SETTLED = 1e-11  # of the speeds' size, change from a period to the next at which a motion is periodic
FORWARDS, STANDS, BACKWARDS = 1, 0, -1


@dataclass(frozen=True)
class Piece:
    """A motion from `begin` on: spring's stretch exp(-a t) (A cos + B sin) + steady + offset, and the velocity of the centre.

    share: mass of the inner body over that of both; 0 where the body stands.
    """

    begin: float
    root: complex
    first: complex
    second: complex
    steady: complex
    frequency: float
    offset: float
    velocity: float
    slope: float
    share: float

    def stretch(self, t: Any) -> Any:
        """Of the spring, m."""
        since = t - self.begin
        free = self.first * np.exp(self.root * since) + self.second * np.exp(self.root.conjugate() * since)
        return free.real + (self.steady * np.exp(1j * self.frequency * t)).imag + self.offset

    def rate(self, t: Any) -> Any:
        """Of the stretch, m/s."""
        since, w = t - self.begin, self.frequency
        free = self.root * self.first * np.exp(self.root * since)
        free = free + self.root.conjugate() * self.second * np.exp(self.root.conjugate() * since)
        return free.real + (1j * w * self.steady * np.exp(1j * w * t)).imag

    def body(self, t: Any) -> Any:
        """Velocity of the body that slips, m/s."""
        return self.velocity + self.slope * (t - self.begin) - self.share * self.rate(t)

    def way(self, t: float) -> float:
        """Of the body since the beginning, m."""
        since = t - self.begin
        moved = self.velocity * since + 0.5 * self.slope * since**2
        return float(moved - self.share * (self.stretch(t) - self.stretch(self.begin)))


def piece(design: Design, mode: int, t: float, stretch: float, rate: float) -> Piece:
    """The motion in a mode from a body that stands at t, or that slips on at the velocity of its mode's beginning, 0."""
    return _piece(design, mode, t, stretch, rate, 0.0)


def _piece(design: Design, mode: int, t: float, stretch: float, rate: float, body: float) -> Piece:
    d, w, whole = design, design.frequency, design.body + design.inner
    if mode == STANDS:
        mass, constant, slope, share = d.inner, -d.inner * GRAVITY * d.sine, 0.0, 0.0
    else:
        outer = d.tow - (d.forward if mode == FORWARDS else -d.backward)
        mass = d.body * d.inner / whole
        constant, slope, share = -mass * outer / d.body, outer / whole - GRAVITY * d.sine, d.inner / whole
    root = -0.5 * d.damping / mass + 1j * cmath.sqrt(d.stiffness / mass - (0.5 * d.damping / mass) ** 2).real
    steady, offset = -d.force / complex(d.stiffness - mass * w * w, d.damping * w), constant / d.stiffness
    forced = steady * cmath.exp(1j * w * t)
    left, left_rate = stretch - forced.imag - offset, rate - (1j * w * forced).imag
    second = (left * root - left_rate) / (root - root.conjugate())
    return Piece(t, root, left - second, second, steady, w, offset, body + share * rate, slope, share)


def load(design: Design, t: Any, stretch: Any, rate: Any) -> Any:
    """Force on a body that stands, N: spring, damper, exciter, weight and tow."""
    shaken = design.stiffness * stretch + design.damping * rate + design.force * np.sin(design.frequency * t)
    return shaken - design.body * GRAVITY * design.sine + design.tow


def loosened(design: Design, force: float) -> int:
    """The mode of a body at rest under a force."""
    return FORWARDS if force > design.forward else BACKWARDS if force < -design.backward else STANDS


def matched_speed(design: Design) -> float:
    """Mean speed, m/s, of the motion that a robot at rest comes to."""
    period = TURN / design.frequency
    t, stretch, rate, body = 0.0, 0.0, 0.0, 0.0
    mode, ways = loosened(design, load(design, 0.0, 0.0, 0.0)), []
    for k in range(MOST):
        end, way = (k + 1) * period, 0.0
        while t < end:
            now = _piece(design, mode, t, stretch, rate, body)
            if mode == STANDS:

                def margin(at: Any, now: Piece = now, mode: int = mode) -> Any:
                    force = load(design, at, now.stretch(at), now.rate(at))
                    return np.minimum(design.forward - force, design.backward + force)
            else:

                def margin(at: Any, now: Piece = now, mode: int = mode) -> Any:
                    return mode * now.body(at)

            until = _first_loss(margin, t, end, period / SCANNED)
            way += now.way(until) if mode != STANDS else 0.0
            t, stretch, rate = until, float(now.stretch(until)), float(now.rate(until))
            body = float(now.body(until)) if mode != STANDS else 0.0
            if until < end:  # it has stopped, or breaks loose
                force, body = float(load(design, t, stretch, rate)), 0.0
                if mode == STANDS:
                    mode = FORWARDS if force > 0.0 and design.forward - force <= design.backward + force else BACKWARDS
                else:
                    mode = loosened(design, force)
        ways.append(way / period)
        recent = np.array(ways[-LAST:])
        if k > 2 * LAST and np.ptp(recent) <= SETTLED * (np.abs(recent).max() + 1e-3):
            break
    return float(np.mean(ways[-LAST:]))


def _first_loss(margin: Any, begin: float, end: float, step: float) -> float:
    """The first instant behind `begin` at which a function falls below zero, or the end."""
    at = np.linspace(begin, end, max(2, math.ceil((end - begin) / step) + 1))
    values = margin(at)
    for j in np.flatnonzero(values[1:] < 0.0):
        low, high = at[j], at[j + 1]
        if j == 0 and not margin(low) > 0.0:  # it begins at zero, and rises first
            inner = np.linspace(low, high, 33)[1:]
            rises = np.flatnonzero(margin(inner) > 0.0)
            if not rises.size:
                return float(np.nextafter(low + 1e-9 * step, high))
            low = inner[rises[0]]
        return float(brentq(margin, low, high, xtol=1e-15, rtol=8.9e-16))
    return end
