"""Chains, links and gimbals in motion."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.charts.blocks import Motion, Moving
from ...harness.charts.motion import instants, polyline, trace
from ...harness.charts.style import number
from .records import axis_direction

if TYPE_CHECKING:
    from ...results import Result

LONGEST = 20.0  # s
CORNERS = 33  # of a circle
DEPTH = 0.4  # share of a length towards the viewer that a picture shows, to the left and down


def motions(result: Result) -> list[Motion]:
    """A picture of each chain and each gimbal, and one of all single links, whose angles were recorded."""
    rows = instants(result.time, LONGEST)
    pictures, links = [], list[tuple[np.ndarray, ...]]()
    for u in recorded_units(result):
        if u.component is None:
            continue
        if u.has("first_angle", "second_angle"):
            pictures.append(_chain(u, rows))
        elif u.has("outer_angle", "inner_angle"):
            pictures.append(_gimbal(u, rows))
        elif u.has("angle", "tip_x", "tip_y"):
            tip, angle, length = (u["tip_x"][rows], u["tip_y"][rows]), u["angle"][rows], u.component.get("length")
            links.append((tip[0] - length * np.sin(angle), tip[1] + length * np.cos(angle), *tip))
    if links:
        lines = [Moving(polyline((a, b), (c, d)), ("part", "second")[k % 2], joints=True) for k, (a, b, c, d) in enumerate(links)]
        path = trace(*links[-1][2:])
        pictures.append(Motion("The links in motion", result.time[rows], [path, *lines], caption="Line: path of the last tip."))
    if result.time[rows[-1]] < result.time[-1]:
        pictures = [
            replace(p, caption=f"{p.caption} The first {LONGEST:g} s of {number(float(result.time[-1]))} s.") for p in pictures
        ]
    return pictures


def _chain(u: RecordedUnit, rows: np.ndarray) -> Motion:
    """Both links from their angles; they hang at angles 0."""
    (l1, l2), (a, b) = (u.component.get(f"{n}_length") for n in ("first", "second")), (u["first_angle"], u["second_angle"])  # type: ignore[union-attr]
    elbow = l1 * np.sin(a[rows]), -l1 * np.cos(a[rows])
    tip = elbow[0] + l2 * np.sin(b[rows]), elbow[1] - l2 * np.cos(b[rows])
    lines = [
        trace(*tip),
        Moving(polyline((0.0, 0.0), elbow), "part", joints=True),
        Moving(polyline(elbow, tip), "second", joints=True),
    ]
    return Motion(f"{u.name} in motion", u.time[rows], lines, caption="Pale line: path of the tip.")


def _gimbal(u: RecordedUnit, rows: np.ndarray) -> Motion:
    """The outer axis, the inner one, the disc of the body and its axis, seen from above at one side; z points down."""
    outer, inner = u["outer_angle"][rows], u["inner_angle"][rows]
    orientation = str(u.component.get("axis_orientation"))  # type: ignore[union-attr]
    s, c, none = np.sin(outer), np.cos(outer), np.zeros(rows.size)
    pointing = axis_direction(outer, inner, orientation)
    cross = np.array([-s, c, none] if orientation == "vertical" else [none, c, s])  # the inner axis
    third = np.cross(pointing, cross, axis=0)
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS)
    disc = [0.6 * (np.cos(p) * cross + np.sin(p) * third) for p in turn]
    fixed = np.array([0.0, 0.0, 1.0] if orientation == "vertical" else [1.0, 0.0, 0.0])
    lines = [
        Moving(polyline(_seen(-1.2 * fixed), _seen(1.2 * fixed)), "ground"),
        trace(*_seen(pointing)),
        Moving(polyline(_seen(-0.8 * cross), _seen(0.8 * cross)), "part", joints=True),
        Moving(polyline(*(_seen(p) for p in disc)), "load"),
        Moving(polyline((0.0, 0.0), _seen(pointing)), "second"),
    ]
    text = (
        "Pale: the outer axis. Dark: the inner axis. Coloured: the disc of the body, its axis of length 1, and the path of that."
    )
    return Motion(f"{u.name} in motion", u.time[rows], lines, ("1", "1"), text)


def _seen(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place in the picture, x to the right, y towards the viewer, z down: (3, k) or (3,)."""
    return v[0] - DEPTH * v[1], -v[2] - DEPTH * v[1]
