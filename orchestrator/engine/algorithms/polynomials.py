"""The polynomials of inputs over a macro step, from their samples, as kernels."""

from __future__ import annotations

from ....components.core.kernels import kernel
from .records import CONSTANT, JUMPS


@kernel
def extrapolation(samples, v, before, earlier, h1, h2):
    """The polynomial through the last samples, h1 and h2 apart: value, slope, half of the second derivative at the newest, v."""
    if samples < 2:
        return v, 0.0, 0.0
    s, c = (v - before) / h1, 0.0
    if samples > 2:
        c = (s - (before - earlier) / h2) / (h1 + h2)
        s += h1 * c
    return v, s, c


@kernel
def end_of(v, s, c, degree, h):
    """Where a polynomial is after h."""
    if degree == 2:
        return v + h * (s + h * c)
    return v + h * s if degree == 1 else v


@kernel
def _extrapolate(past, link):
    """The polynomial of an input over the coming step, from its samples."""
    if link.held != 0:
        return link.present, 0.0, 0.0
    v, s, c = extrapolation(past.samples, link.present, link.before, link.earlier, past.h1, past.h2)
    return _seen(past, v, s, c, past.samples > 2)


@kernel
def _interpolate_to(past, link, h):
    """The polynomial that ends at the known value, h ahead; where the source does not step, that of its samples goes on."""
    if past.left != 0:
        return _extrapolate(past, link)
    h += past.elapsed
    v, c = link.known if link.held == CONSTANT else link.present, 0.0
    if past.degree == 0:
        return v if link.held == JUMPS else link.known, 0.0, 0.0
    bent = past.degree == 2 and past.samples > 1
    s = 0.0 if link.held != 0 else (link.known - v) / h
    if bent and link.held == 0:
        c = (s - (v - link.before) / past.h1) / (h + past.h1)
        s += -h * c
    return _seen(past, v, s, c, bent)


@kernel
def _seen(past, v, s, c, bent):
    """A polynomial from the present instant instead of from the last sample."""
    e = past.elapsed
    if e == 0.0:
        return v, s, c
    return (v + e * (s + e * c), s + 2.0 * e * c, c) if bent else (v + e * s, s, c)


@kernel
def _degree(unit, past):
    """Of the polynomials that a history gives a unit."""
    degree = past.samples - 1
    if unit.n_extrapolated < unit.links and past.degree > 0 and past.left == 0:
        degree = max(degree, 2 if past.degree == 2 and past.samples > 1 else 1)
    return degree
