"""Form finding: heights of all wires at rest, dropper lengths and preloads, reactions of the supports.

Strings between nodes carry their weight in parabolas, whose nodes a network of straight strings with half of the weight at either
end gives exactly: so the network has nodes at supports, droppers and clamps alone, and no mesh error. Wires are taken as strings:
bending stiffness changes heights within centimetres of a clamp only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.banded import banded_product, factor_band, solve_band
from ...core.errors import BadInput
from .from_table import lay_out
from .layout import GRAVITY, Layout
from .table import Line

RIGID_CLAMP = 1e10  # N/m
PASSES = 4  # masses depend on the lengths, which depend on them: an error of 1 mm leaves 1e-8 m after two


@dataclass(frozen=True)
class Form:
    """A line at rest. droppers: (d,) each; supports: (k,) rows of messenger supports; heights: (n, lanes) at `position`, NaN."""

    layout: Layout
    position: np.ndarray  # (n,) m
    height: np.ndarray  # (n, lanes) m above the level of the model, NaN where there is no wire
    length: np.ndarray  # (d,) m, under load
    cut_length: np.ndarray  # (d,) m, without load
    preload: np.ndarray  # (d,) N, at the lower end
    support: np.ndarray  # (k,) m
    reaction: np.ndarray  # (k,) N, upwards on the messenger
    rest_height: np.ndarray  # (k,) m, of the unloaded support spring
    contact_force: np.ndarray  # (c,) N, upwards on a contact wire that is held at a support; its rows are those of `held`
    held: np.ndarray  # (c, 2) position m, lane


def find_form(line: Line, p: Any) -> Form:
    """Form of a line; p: parameters of `Catenary`."""
    lengths = None
    for _ in range(PASSES):
        form = form_of(lay_out(line, p, None, lengths))
        lengths = form.length
        if np.any(lengths <= 0.0):
            k = int(np.argmin(lengths))
            raise BadInput("line", f"the dropper at {form.layout.droppers.position[k]:g} m would be {lengths[k]:.3g} m long",
                           "a messenger above the contact wire", "Raise the system height, or the tension of the messenger.")
    return form


def formed_layout(line: Line, p: Any, bending: Any) -> Layout:
    """Layout of a line with the masses and stiffnesses that follow from the lengths of its droppers.

    p: parameters of `Catenary`; bending: its effect or None.
    """
    return lay_out(line, p, bending, find_form(line, p).length)


def form_of(layout: Layout) -> Form:
    """Form of a layout: the contact wires hang as their clamps are placed, the others as these load them."""
    x = layout.places
    n, W, d, h = x.size, layout.lanes, layout.droppers, layout.holds
    at = lambda positions: np.searchsorted(x, np.asarray(positions) - 1e-6)  # noqa: E731
    on, hold = at(d.position), at(h.position)
    weight, tension = np.zeros((n, W)), np.zeros((n, W))
    height = np.full((n, W), np.nan)
    fixed = np.ones((n, W), dtype=bool)
    ties: list[tuple[int, int]] = []
    for wire in layout.wires:
        a, b = at([wire.start, wire.end])
        lane, L = wire.lane, np.diff(x[a : b + 1])
        T = np.full(b - a, wire.tension)
        for change in wire.tension_changes:
            T[slice(*(at([change.start, change.end]) - a))] += change.value
        tension[a:b, lane] = T
        own = GRAVITY * wire.mass * L
        middle = 0.5 * (x[a:b] + x[a + 1 : b + 1])
        for part in wire.masses:
            own = np.where((middle > part.start) & (middle < part.end), part.value * own, own)
        weight[a:b, lane] += 0.5 * own
        weight[a + 1 : b + 1, lane] += 0.5 * own
        fixed[a + 1 : b, lane] = False
        if wire.clamped_to is None:
            height[[a, b], lane] = wire.heights
        else:
            fixed[[a, b], lane] = False
            ties += [(W * i + lane, W * i + wire.clamped_to) for i in (a, b)]
    np.add.at(weight, (on, d.lower), GRAVITY * d.mass_below)
    np.add.at(weight, (on, d.upper), GRAVITY * d.mass_above)
    np.subtract.at(weight, (hold, h.lane), h.lift)
    placed = fixed.copy()
    placed[on, d.lower] = True
    height[on, d.lower] = d.height
    rigid = ~np.isnan(h.height)
    placed[hold[rigid], h.lane[rigid]] = True
    height[hold[rigid], h.lane[rigid]] = h.height[rigid]

    over = 1.0 / np.diff(x)
    stiffness = np.zeros((W * n, W + 1))
    for lane in range(W):
        k = tension[:-1, lane] * over
        stiffness[lane : W * (n - 1) : W, 0] += k
        stiffness[lane + W :: W, 0] += k
        stiffness[lane : W * (n - 1) : W, W] -= k
    loads = -weight
    for lane in layout.contact_lanes:
        _solve(stiffness, loads, height, placed, [lane], W, [])
    preload = _unbalanced(stiffness, weight, height)[on, d.lower]
    np.subtract.at(loads, (on, d.upper), preload)
    others = [lane for lane in range(W) if lane not in layout.contact_lanes]
    _solve(stiffness, loads, height, placed, others, W, ties)
    lacking = _unbalanced(stiffness, -loads, height)
    clamp_pull = np.zeros(W * n)
    for one, other in ties:  # what the stitch pulls on its clamps is the messenger's load
        clamp_pull[other] += lacking.ravel()[one]
    upward = lacking + clamp_pull.reshape(n, W)
    messenger = ~np.isin(h.lane, layout.contact_lanes)
    reaction = upward[hold[messenger], h.lane[messenger]]
    held = ~messenger & rigid
    length = height[on, d.upper] - height[on, d.lower]
    with np.errstate(divide="ignore"):
        rest = h.height[messenger] + np.where(h.stiffness[messenger] > 0.0, reaction / h.stiffness[messenger], np.inf)
    return Form(layout, x, height, length, length - preload / d.stiffness, preload, h.position[messenger], reaction, rest,
                upward[hold[held], h.lane[held]], np.column_stack((h.position[held], h.lane[held])))


def _solve(stiffness: np.ndarray, loads: np.ndarray, height: np.ndarray, placed: np.ndarray, lanes: list[int], W: int,
           ties: list[tuple[int, int]]) -> None:
    """Heights of what is not placed in some lanes, in place."""
    n = height.shape[0]
    free = np.zeros((n, W), dtype=bool)
    free[:, lanes] = ~placed[:, lanes]
    known = np.where(free | np.isnan(height), 0.0, height).ravel()
    b = loads.ravel() - banded_product(stiffness, known)
    band = stiffness.copy()
    for one, other in ties:
        band[one, 0] += RIGID_CLAMP
        band[other, 0] += RIGID_CLAMP
        band[min(one, other), abs(one - other)] -= RIGID_CLAMP
    bound = ~free.ravel()
    b[bound] = 0.0
    band[bound] = 0.0
    band[bound, 0] = 1.0
    for offset in range(1, W + 1):
        band[:-offset, offset][bound[offset:]] = 0.0
    factor_band(band, 0, 0, W * n)
    solve_band(band, b, 0, W * n)
    height.ravel()[free.ravel()] = b[free.ravel()]


def _unbalanced(stiffness: np.ndarray, weight: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Force that holds each node besides its wires, (n, lanes) N, upwards."""
    z = np.where(np.isnan(height), 0.0, height)
    return weight + banded_product(stiffness, z.ravel()).reshape(weight.shape)
