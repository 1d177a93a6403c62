"""A machine in motion: drawn from signals and parameters, in a report from a run, in a page that computes from formulas."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..analysis.records import RecordedUnit
from .blocks import Motion, Moving
from .formulas import Program, symbol
from .style import number

if TYPE_CHECKING:
    from ...run.results import Result

FEWEST, MOST = 120, 600  # instants of a motion
A_SECOND = 30.0  # instants, of a motion that is neither short nor long
GHOSTS = 5  # instants of a still picture
WIDTH, HEIGHT = 760.0, 360.0  # px of a still picture
ROOM = 0.06  # of the picture's size, about the machine
WIDTHS = {"ground": 1.5, "part": 3.0, "second": 3.0, "load": 1.5, "trace": 1.0}
Values = Mapping[str, Any]


class Picture(NamedTuple):
    """Lines of a machine, and numbers for its caption."""

    lines: Sequence[Moving]
    numbers: Sequence[Any] = ()


@dataclass(frozen=True)
class Kinematics:
    """How the picture of a machine follows from its signals and parameters, at each instant.

    draw: from values by their names, (k,) each at k instants, of an array (k, m); arrays of formulas give formulas.
    signals: name -> column of a run, or what only this run has, (n,).  parameters: name -> "unit.parameter".
    snapshots: name -> snapshots of an array, at whose instants the machine is shown.
    caption: with {0}, {1} ... for the numbers of the picture.  labels, equal: as of `Motion`.
    begin: the first instant that is shown, s, from the values of the whole run.  longest: s that are shown.
    fewest: instants.
    """

    title: str
    draw: Callable[[Values], Picture]
    signals: Mapping[str, str | np.ndarray]
    parameters: Mapping[str, str] = field(default_factory=dict)
    snapshots: Mapping[str, str] = field(default_factory=dict)
    caption: str = ""
    labels: tuple[str, str] = ("m", "m")
    equal: bool = True
    begin: Callable[[Values], Any] | None = None
    longest: float = np.inf
    fewest: int = FEWEST

    def motion(self, result: Result) -> Motion:
        """The machine in a run."""
        time = next((result.snapshots[name].time for name in self.snapshots.values()), result.time)
        whole: dict[str, Any] = {name: result.columns[s] if isinstance(s, str) else s for name, s in self.signals.items()}
        whole |= {"time": result.time} | {name: _parameter(result, of) for name, of in self.parameters.items()}
        begin = float(self.begin(whole)) if self.begin else -np.inf
        rows = instants(time, self.longest, begin, self.fewest)
        values: dict[str, Any] = {name: result.snapshots[of].values[rows] for name, of in self.snapshots.items()}
        values |= {
            name: np.interp(time[rows], result.time, v) if self.snapshots else v[rows]
            for name, v in whole.items()
            if name not in self.parameters
        }
        picture = self.draw(whole | values)
        caption = self.caption.format(*(number(float(n)) for n in picture.numbers))
        if self.longest < result.time[-1]:
            caption += f" The first {self.longest:g} s of {number(float(result.time[-1]))} s."
        return Motion(self.title, time[rows], picture.lines, self.labels, caption.strip(), self.equal)

    def formulas(self, result: Result, changeable: Collection[str]) -> dict[str, Any] | None:
        """The machine as data of a page, whose parameters are `changeable`; None where it needs what only this run has."""
        if not all(isinstance(s, str) for s in self.signals.values()):
            return None
        values: dict[str, Any] = {name: symbol("signal", s) for name, s in self.signals.items() if isinstance(s, str)}
        values["time"] = symbol("signal", "time")
        for name, of in self.parameters.items():
            values[name] = symbol("parameter", of) if of in changeable else _parameter(result, of)
        for name, of in self.snapshots.items():
            elements = range(1, result.snapshots[of].values.shape[1] + 1)
            values[name] = np.stack([symbol("signal", f"{of}[{k}]") for k in elements], axis=1)
        program, picture = Program(), self.draw(values)
        lines = [
            {"look": line.look, "joints": line.joints, "points": program.places(line.points.ravel())} for line in picture.lines
        ]
        return {
            "title": self.title,
            "caption": self.caption,
            "numbers": program.places(np.asarray(n).item() for n in picture.numbers),
            "begin": None if self.begin is None else program.place(np.asarray(self.begin(values)).item()),
            "longest": None if np.isinf(self.longest) else self.longest,
            "fewest": self.fewest,
            "most": MOST,
            "a_second": A_SECOND,
            "room": ROOM,
            "equal": self.equal,
            "snapshots": list(self.snapshots.values()),
            "lines": lines,
            "steps": program.steps,
        }


def _parameter(result: Result, name: str) -> float:
    unit, rest = result.scene.split(name)
    component = RecordedUnit(result, unit).component
    assert component is not None, f"{name} is of an FMU"
    return float(component.get(rest))


def instants(time: np.ndarray, longest: float = np.inf, begin: float = -np.inf, fewest: int = FEWEST) -> np.ndarray:
    """Rows of a run that its motion shows, (k,), evenly over the time (n,) from `begin` on, over as many s as are shown at most."""
    first = min(int(np.searchsorted(time, begin)), time.size - 1)
    shown = time[first : np.searchsorted(time, time[first] + longest, side="right")]
    span = float(shown[-1] - shown[0])
    count = int(np.clip(A_SECOND * span, fewest, MOST))
    rows = np.searchsorted(shown, np.linspace(shown[0], shown[-1], count))
    return first + np.unique(np.minimum(rows, shown.size - 1))


def polyline(*corners: tuple[Any, Any]) -> np.ndarray:
    """Points (k, m, 2) of a line from its m corners, (x, y), (k,) each or numbers."""
    arrays = np.broadcast_arrays(*(np.atleast_1d(c) for corner in corners for c in corner))
    return np.stack([np.stack(arrays[k : k + 2], axis=-1) for k in range(0, len(arrays), 2)], axis=1)


def box(motion: Motion) -> list[float]:
    """Least and largest x, least and largest y of all lines, with room about them."""
    points = np.concatenate([line.points.reshape(-1, 2) for line in motion.lines])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    room = ROOM * np.maximum(high - low, 0.1 * (high - low).max() or 1.0)
    return [float(low[0] - room[0]), float(high[0] + room[0]), float(low[1] - room[1]), float(high[1] + room[1])]


def motion_data(motion: Motion) -> dict[str, Any]:
    """What the page's script gets: numbers as bytes of 32-bit numbers."""
    return {
        "time": _packed(motion.time),
        "box": box(motion),
        "equal": motion.equal,
        "labels": list(motion.labels),
        "lines": [
            {"look": line.look, "joints": line.joints, "corners": line.points.shape[1], "points": _packed(line.points)}
            for line in motion.lines
        ],
    }


def _packed(values: np.ndarray) -> str:
    return b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")


def still_motion(motion: Motion) -> str:
    """An SVG element with some instants over one another, the last ones darker: for pages whose scripts do not run."""
    x0, x1, y0, y1 = box(motion)
    sx, sy = WIDTH / (x1 - x0), HEIGHT / (y1 - y0)
    if motion.equal:
        sx = sy = min(sx, sy)
    middle = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    rows = np.linspace(0, motion.time.size - 1, GHOSTS).round().astype(int)
    parts = []
    for line in motion.lines:
        moves = line.points.shape[0] > 1
        for place, row in enumerate(rows if moves and line.look != "trace" else rows[:1]):
            corners = line.points[:, 0] if line.look == "trace" else line.points[row if moves else 0]
            known = corners[np.isfinite(corners).all(axis=1)]
            x, y = 0.5 * WIDTH + sx * (known[:, 0] - middle[0]), 0.5 * HEIGHT - sy * (known[:, 1] - middle[1])
            path = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
            opacity = 0.35 if line.look in ("ground", "trace") else 0.2 + 0.8 * (place + 1) / rows.size
            style = f'fill="none" stroke="currentColor" stroke-width="{WIDTHS[line.look]}" stroke-opacity="{opacity:.2f}"'
            parts.append(f'<polyline points="{path}" {style}/>')
    label = escape(
        f"{motion.title}: {rows.size} instants from {number(float(motion.time[0]))} to {number(float(motion.time[-1]))} s"
    )
    size = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%"'
    return f'<svg role="img" aria-label="{label}" {size} xmlns="http://www.w3.org/2000/svg">{"".join(parts)}</svg>'


def trace(x: np.ndarray, y: np.ndarray) -> Moving:
    """The path of a point, (k,) each, drawn as far as it has come."""
    return Moving(polyline((x, y)), "trace")
