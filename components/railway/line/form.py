"""Form finding: heights of all wires at rest, dropper lengths and preloads, reactions of the supports.

Strings between nodes carry their weight in parabolas, whose nodes a network of straight strings with half of the weight at either
end gives exactly: so the network has nodes at supports, droppers and clamps alone, and no mesh error. Wires are taken as strings:
bending stiffness changes heights within centimetres of a clamp only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.banded import banded_product, factor_band, solve_band
from ...core.errors import BadInput
from .from_table import lay_out
from .layout import GRAVITY, Droppers, Layout
from .table import Line

RIGID_CLAMP = 1e10  # N/m
AGREED_LENGTH, AGREED_FORCE = 1e-4, 0.1  # m, N: what a table says of a dropper besides, in the digits of a drawing
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
    form = _hung(lay_out(line, p, None))
    for _ in range(PASSES - 1):
        layout = lay_out(line, p, None, form.length)
        if _as_heavy(layout.droppers, form.layout.droppers):
            break
        form = _hung(layout)
    d = form.layout.droppers
    for name, tolerance, given, actual in (
            ("length", AGREED_LENGTH, d.length, form.length), ("cut length", AGREED_LENGTH, d.cut_length, form.cut_length),
            ("preload", AGREED_FORCE, d.preload, form.preload)):
        wrong = np.abs(given - actual) > tolerance  # not where nothing is given
        if np.any(wrong):
            k = int(np.argmax(np.where(wrong, np.abs(given - actual), 0.0)))
            raise BadInput("line", f"a {name} of {given[k]:.6g} of the dropper at {d.position[k]:g} m",
                           f"{actual[k]:.6g}, which follows from the rest of the line",
                           "Leave it out; or leave out the height, so that the cut length rules.")
    return form


def _hung(layout: Layout) -> Form:
    """`form_of` with droppers of positive length, or `BadInput`."""
    form = form_of(layout)
    if np.any(form.length <= 0.0):
        k = int(np.argmin(form.length))
        raise BadInput("line", f"the dropper at {layout.droppers.position[k]:g} m would be {form.length[k]:.3g} m long",
                       "a messenger above the contact wire", "Raise the system height, or the tension of the messenger.")
    return form


def _as_heavy(one: Droppers, other: Droppers) -> bool:
    """Whether masses and stiffnesses, all that depends on the lengths of droppers, are the same."""
    return all(np.array_equal(getattr(one, n), getattr(other, n)) for n in ("stiffness", "mass_below", "mass_above"))


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
    if np.isnan(d.height).any():
        d = replace(d, height=_heights_of_cut_lengths(stiffness, loads, height, placed, d, on, ties))
        layout = replace(layout, droppers=d)
    height[on, d.lower] = d.height
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


def _heights_of_cut_lengths(stiffness: np.ndarray, loads: np.ndarray, height: np.ndarray, placed: np.ndarray, d: Droppers,
                            on: np.ndarray, ties: list[tuple[int, int]]) -> np.ndarray:
    """Heights of the contact wire's clamps, (d,) m, where some droppers have a cut length and no height.

    Such a dropper pulls with N = k (L - L0), so that all wires are solved together, node by node. One with a height is cut so
    that its clamp is there: what the contact wire lacks at that place is a load of the wire above.
    """
    n, W = height.shape
    left, here, right, b = *np.zeros((3, n, W, W)), loads.copy()
    lanes = np.arange(W)
    here[:, lanes, lanes] = stiffness[:, 0].reshape(n, W)
    right[:-1, lanes, lanes] = stiffness[:-W, W].reshape(n - 1, W)
    left[1:, lanes, lanes] = right[:-1, lanes, lanes]
    fixed = placed.copy()
    for node, low, up, k, length, z in zip(on, d.lower, d.upper, d.stiffness, d.cut_length, d.height, strict=True):
        if np.isnan(z):
            here[node, [low, up], [low, up]] += k
            here[node, [low, up], [up, low]] -= k
            b[node, low] -= k * length
            b[node, up] += k * length
            fixed[node, low] = False
        else:
            for block in (left, here, right):
                block[node, up] += block[node, low]
            b[node, up] += loads[node, low]
            height[node, low] = z
    for one, other in ties:
        node, pair = one // W, [one % W, other % W]
        here[node, pair, pair] += RIGID_CLAMP
        here[node, pair, pair[::-1]] -= RIGID_CLAMP
    left[fixed], right[fixed], here[fixed] = 0.0, 0.0, np.eye(W)[np.nonzero(fixed)[1]]
    b[fixed] = np.nan_to_num(height[fixed])
    for i in range(1, n):  # block elimination
        factor = left[i] @ np.linalg.inv(here[i - 1])
        here[i] -= factor @ right[i - 1]
        b[i] -= factor @ b[i - 1]
    for i in reversed(range(n)):
        b[i] = np.linalg.solve(here[i], b[i] - (right[i] @ b[i + 1] if i < n - 1 else 0.0))
    return np.where(np.isnan(d.height), b[on, d.lower], d.height)


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
