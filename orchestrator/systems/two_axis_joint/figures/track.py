"""Where the body's axis points, on the unit sphere, and where a chain's tip goes."""

from __future__ import annotations

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import JointRecord, drawn

AXES = ("x", "y", "z")
VIEWS = (  # title, horizontal and vertical axis of the picture with their signs, axis towards the viewer with its sign
    ("from below", (0, 1.0), (1, 1.0), (2, 1.0)),
    ("from the side, along y", (0, 1.0), (2, -1.0), (1, -1.0)),
    ("from the side, along x", (1, 1.0), (2, -1.0), (0, 1.0)),
)
WIDE = 0.5  # of its reach: a tip that goes less far is drawn without it
EDGE = 1.0001  # of the sphere's radius: rounding of its edge


def circle(radius: float) -> Series:
    """The edge of what can be reached."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    return Series("edge", radius * np.cos(turn), radius * np.sin(turn), faint=True)


def sphere_chart(record: JointRecord, begin: float) -> Chart:
    """The axis' track on the unit sphere from three sides; the part on the far side is another line."""
    assert record.pointing is not None
    window, shown = drawn(record, begin)
    kept = record.pointing[:, window]
    panels = []
    for title, (i, along), (j, up), (k, towards) in VIEWS:
        x, y, depth = along * kept[i], up * kept[j], towards * kept[k]
        near, far = (np.where(_widened(here), 1.0, np.nan) for here in (depth >= 0.0, depth < 0.0))
        series = [circle(EDGE), Series("near side", near * x, near * y), Series("far side", far * x, far * y)]
        series += [Series("begin", x[:1], y[:1], "points"), Series("end", x[-1:], y[-1:], "points")]
        signs = ["" if sign > 0.0 else "−" for sign in (along, up)]
        panels.append(Panel(f"{signs[1]}{AXES[j]}, 1", tuple(series), title=title, x_label=f"{signs[0]}{AXES[i]}, 1", equal=True))
    text = "Track of the body's axis on the unit sphere; x and y are horizontal, −z is up." + shown
    return Chart("Track of the axis", "", tuple(panels), text, columns=3, height=300)


def _widened(here: np.ndarray) -> np.ndarray:
    """Samples of a side and the one before each of them: so that the two sides' lines meet."""
    wide = here.copy()
    wide[:-1] |= here[1:]
    return wide


def tip_chart(record: JointRecord, begin: float, who: str = "") -> Chart:
    """Path of a chain's tip in its plane."""
    assert record.tip is not None
    window, shown = drawn(record, begin)
    x, y = record.tip[:, window]
    wide = max(float(np.ptp(x)), float(np.ptp(y))) > WIDE * record.reach > 0.0
    series = [circle(record.reach)] if wide else []
    series += [Series("tip", x, y), Series("begin", x[:1], y[:1], "points"), Series("end", x[-1:], y[-1:], "points")]
    text = "Path of the tip" + ("; pale: as far as it reaches." if wide else ".") + shown
    panel = Panel("y, m", tuple(series), x_label="x, m", equal=True)
    return Chart(f"{who}Path of the tip", "", (panel,), text, columns=2, height=360)
