"""Chains, links and gimbals in motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.charts.blocks import Moving
from ...harness.charts.motion import Kinematics, Picture, Values, polyline, trace
from . import walkers
from .records import axis_direction

if TYPE_CHECKING:
    from ...run.results import Result

LONGEST = 20.0  # s
CORNERS = 33  # of a circle
DEPTH = 0.4  # share of a length towards the viewer that a picture shows, to the left and down
LINK = ("tip_x", "tip_y", "angle")


def motions(result: Result) -> list[Kinematics]:
    """A picture of each chain, gimbal and walker, and one of all single links, whose angles were recorded."""
    pictures, links = [], list[str]()
    for u in recorded_units(result):
        if u.component is None:
            continue
        if u.has("first_angle", "second_angle"):
            pictures.append(_chain(u))
        elif u.has("outer_angle", "inner_angle"):
            pictures.append(_gimbal(u))
        elif u.has(*LINK):
            links.append(u.name)
    if links:
        pictures.append(
            Kinematics(
                "The links in motion",
                lambda values: _links(values, links),
                {f"{name}.{signal}": f"{name}.{signal}" for name in links for signal in LINK},
                {f"{name}.length": f"{name}.length" for name in links},
                caption="Line: path of the last tip.",
                longest=LONGEST,
            )
        )
    return pictures + walkers.motions(result)


def _links(values: Values, links: list[str]) -> Picture:
    """Each link from its tip and its angle; it hangs at angle 0."""
    lines = []
    for k, name in enumerate(links):
        x, y, angle, length = (values[f"{name}.{what}"] for what in (*LINK, "length"))
        begin = x - length * np.sin(angle), y + length * np.cos(angle)
        lines.append(Moving(polyline(begin, (x, y)), ("part", "second")[k % 2], joints=True))
    return Picture([trace(x, y), *lines])


def _chain(u: RecordedUnit) -> Kinematics:
    return Kinematics(
        f"{u.name} in motion",
        _both_links,
        {"first": u.column("first_angle"), "second": u.column("second_angle")},
        {f"{n} length": f"{u.name}.{n}_length" for n in ("first", "second")},
        caption="Pale line: path of the tip.",
        longest=LONGEST,
    )


def _both_links(values: Values) -> Picture:
    """Both links from their angles; they hang at angles 0."""
    a, b, l1, l2 = (values[name] for name in ("first", "second", "first length", "second length"))
    elbow = l1 * np.sin(a), -l1 * np.cos(a)
    tip = elbow[0] + l2 * np.sin(b), elbow[1] - l2 * np.cos(b)
    return Picture(
        [
            trace(*tip),
            Moving(polyline((0.0, 0.0), elbow), "part", joints=True),
            Moving(polyline(elbow, tip), "second", joints=True),
        ]
    )


def _gimbal(u: RecordedUnit) -> Kinematics:
    orientation = str(u.component.get("axis_orientation"))  # type: ignore[union-attr]
    return Kinematics(
        f"{u.name} in motion",
        lambda values: _rings(values, orientation),
        {"outer": u.column("outer_angle"), "inner": u.column("inner_angle")},
        caption="Pale: the outer axis. Dark: the inner axis. Coloured: the disc of the body, its axis of length 1, and the path of that.",
        labels=("1", "1"),
        longest=LONGEST,
    )


def _rings(values: Values, orientation: str) -> Picture:
    """The outer axis, the inner one, the disc of the body and its axis, seen from above at one side; z points down."""
    outer, inner = values["outer"], values["inner"]
    s, c, none = np.sin(outer), np.cos(outer), 0.0 * outer
    pointing = axis_direction(outer, inner, orientation)
    cross = np.array([-s, c, none] if orientation == "vertical" else [none, c, s])  # the inner axis
    third = np.array([pointing[i - 2] * cross[i - 1] - pointing[i - 1] * cross[i - 2] for i in range(3)])
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS)
    disc = [0.6 * (np.cos(p) * cross + np.sin(p) * third) for p in turn]
    fixed = np.array([0.0, 0.0, 1.0] if orientation == "vertical" else [1.0, 0.0, 0.0])
    return Picture(
        [
            Moving(polyline(_seen(-1.2 * fixed), _seen(1.2 * fixed)), "ground"),
            trace(*_seen(pointing)),
            Moving(polyline(_seen(-0.8 * cross), _seen(0.8 * cross)), "part", joints=True),
            Moving(polyline(*(_seen(p) for p in disc)), "load"),
            Moving(polyline((0.0, 0.0), _seen(pointing)), "second"),
        ]
    )


def _seen(v: np.ndarray) -> tuple[Any, Any]:
    """Place in the picture, x to the right, y towards the viewer, z down: (3, k) or (3,)."""
    return v[0] - DEPTH * v[1], -v[2] - DEPTH * v[1]
