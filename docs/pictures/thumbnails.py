"""The curves of the gallery, docs/pictures/scenes/NAME.svg: `python docs/pictures/thumbnails.py [SCENE...]`.

Runs the scenes, all of them without a name, and draws one panel of a figure of each report: what the scene is there to show.
It takes some two minutes for all scenes; the pictures are kept, so that the site is built without running them. Lines take their
colours from the page (`.curve-0` to `.curve-4`), letters that of the text.
"""

from __future__ import annotations

import re
import sys
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from cosimo import load_scene, run
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import SYSTEMS

FOLDER = Path(__file__).resolve().parent / "scenes"
WIDTH, HEIGHT = 320, 190  # px
LEFT, RIGHT, TOP, BOTTOM = 8, 312, 26, 160  # px, of the panel
POINTS = 240  # of a line: the least and the greatest value in each of half as many intervals
MOST = 5  # lines
SHOWN = {  # scene -> beginning of the title of the figure that it is there for; without one the first that has lines
    "ball-bearing-clearance": "Orbit",
    "outer-ring-defect": "Envelope",
    "critical-speed": "Shape",
    "damped-chain": "Phase",
    "double-pendulum": "Path",
    "en50318-2002-interface-model": "Amplitude",
    "en50318-2018-ac-simple": "Uplift",
    "en50318-2018-ac-stitched": "Contact force",
    "en50318-2018-dc-simple": "Shape",
    "compound-line": "Contact force",
    "line-as-built": "Lateral",
    "stitched-line": "Shape",
    "two-contact-wires": "Uplift",
    "two-strips": "Amplitude",
    "unequal-spans": "Uplift",
    "friction-drive-creep": "Tractions",
    "friction-drive-slow-feed": "While",
    "friction-drive-step": "Tractions",
    "gimbal-rotor": "Track",
    "gimbal-scan": "Phase",
    "gyroscopic-rotor": "Campbell",
    "jaw-crusher": "Phase",
    "joint-stiction": "exact: Phase",
    "passive-walkers": "Walking",
    "satellite-latch": "Energy",
    "satellite-panel": "Energy",
    "two-link-manipulator": "Path",
    "rotor-bearings-heat": "Heat",
    "rotor-run-up": "Run-up",
    "pipe-robot-climb": "Along",
    "pipe-robot-motor-start": "Against",
    "pipe-robot-resonance": "Against",
    "pipe-robots-in-tow": "In detail",
    "rov-added-mass": "Motion",
    "rov-manoeuvre": "Track",
    "rov-sensors": "Track",
    "rov-station-keeping": "Errors",
    "rov-thruster-failed": "Thrusts",
    "rov-tumbling": "Drift",
    "rov-waves": "Depth",
    "rov-waves-eight-thrusters": "Errors",
    "wind-pump-day": "Against",
    "wind-pump-start": "Water",
    "wrist-motion": "Paths",
    "wrist-tool": "Muscles",
    "wrist-what-if": "Ligaments",
}


def figures(name: str) -> list[tuple[str, dict[str, Any]]]:
    """(title, Plotly figure) of the report of a scene that is run now; of a scene without a system its signals over time."""
    result = run(load_scene(name), in_process=True, verify="no")
    system = result.scene.analysis.system
    if system not in SYSTEMS:
        return [("Signals", result.plot().to_plotly_json())]
    return [(b.title, b.figure) for b in SYSTEMS[system].figures(result, ()) if b.kind == "figure"]


def curve(title: str, figure: dict[str, Any], titles: list[str]) -> str:
    """The first panel with lines as SVG; `titles` of all figures stand in an attribute, for the filter of the gallery."""
    traces = [t for t in figure["data"] if _is_line(t)]
    panel = (traces[0].get("xaxis", "x"), traces[0].get("yaxis", "y"))
    traces = [t for t in traces if (t.get("xaxis", "x"), t.get("yaxis", "y")) == panel]
    traces = ([t for t in traces if "filtered" in str(t.get("name"))] or traces)[:MOST]
    lines = [_thinned(np.asarray(t["x"], float), np.asarray(t["y"], float)) for t in traces]
    x, y = (
        _range(figure["layout"].get(f"{axis}axis{panel[0][1:]}", {}), [line[k] for line in lines]) for k, axis in enumerate("xy")
    )
    parts = []
    for k, (xs, ys) in enumerate(lines):
        px = LEFT + (RIGHT - LEFT) * (xs - x[0]) / (x[1] - x[0])
        py = BOTTOM - (BOTTOM - TOP) * (ys - y[0]) / (y[1] - y[0])
        shown = (px >= LEFT - 1) & (px <= RIGHT + 1) & (py >= TOP - 1) & (py <= BOTTOM + 1)
        if "lines" not in traces[k].get("mode", "lines"):
            dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(px[shown], py[shown], strict=True))
            parts.append(f'<path class="curve-{k}" d="{dots}" stroke-width="3" stroke-linecap="round"/>')
            continue
        words, pen = [], "M"
        for a, b, there in zip(px, py, shown, strict=True):
            words.append(f"{pen}{a:.1f} {b:.1f}" if there else "")
            pen = "L" if there else "M"
        parts.append(f'<path class="curve-{k}" d="{"".join(words)}"/>')
    labels = [
        figure["layout"].get(f"{axis}axis{panel[k][1:]}", {}).get("title", {}).get("text", "") for k, axis in enumerate("xy")
    ]
    texts = [(LEFT, 16, "start", labels[1] or title, ""), ((LEFT + RIGHT) / 2, 182, "middle", labels[0], "")]
    ends = [(LEFT, 174, "start", x[0]), (RIGHT, 174, "end", x[1]), (RIGHT, 36, "end", y[1]), (RIGHT, 156, "end", y[0])]
    texts += [(a, b, c, f"{d:.3g}", ' class="end"') for a, b, c, d in ends]
    written = "".join(f'<text x="{a:g}" y="{b}" text-anchor="{c}"{e}>{escape(_plain(d))}</text>' for a, b, c, d, e in texts if d)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="curve" role="img" aria-label="{escape(_plain(title), quote=True)}" '
        f'data-figures="{escape("|".join(titles), quote=True)}" viewBox="0 0 {WIDTH} {HEIGHT}" fill="none" stroke="currentColor" '
        f'stroke-width="1.5" stroke-linejoin="round"><path d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}" stroke-width="1" opacity="0.5"/>'
        f'{"".join(parts)}<g fill="currentColor" stroke="none" font-size="11" font-family="sans-serif">{written}</g></svg>\n'
    )


def _is_line(trace: dict[str, Any]) -> bool:
    return (
        trace.get("type", "scatter") in ("scatter", "scattergl")
        and np.size(trace.get("x")) > 2
        and trace.get("visible", True) is True
    )


def _plain(text: str) -> str:
    return re.sub(r"<[^>]*>", " ", text).strip()


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same curve of at most POINTS points, with its extremes; one that goes back and forth loses every so-many-th point."""
    if x.size <= POINTS:
        return x, y
    if np.all(np.diff(x[np.isfinite(x)]) >= 0.0):
        parts = np.array_split(np.arange(x.size), POINTS // 2)
        kept = np.unique(
            [k for part in parts for k in (part[np.nanargmin(_filled(y[part]))], part[np.nanargmax(_filled(y[part]))])]
        )
        return x[kept], y[kept]
    kept = np.linspace(0, x.size - 1, 4 * POINTS).astype(int) if x.size > 4 * POINTS else np.arange(x.size)
    return x[kept], y[kept]


def _filled(values: np.ndarray) -> np.ndarray:
    return values if np.any(np.isfinite(values)) else np.zeros(values.size)


def _range(axis: dict[str, Any], values: list[np.ndarray]) -> tuple[float, float]:
    """The ends of an axis: its own ones, or those of the values."""
    if axis.get("range") and axis.get("type") != "log":
        return float(axis["range"][0]), float(axis["range"][1])
    every = np.concatenate(values)
    every = every[np.isfinite(every)]
    low, high = float(every.min()), float(every.max())
    room = 0.04 * (high - low) or 0.5
    return low - room, high + room


def main(names: list[str]) -> None:
    """Make the pictures of the named scenes, or of all."""
    FOLDER.mkdir(exist_ok=True)
    for name in names or scene_files():
        every = figures(name)
        begin = SHOWN.get(name, "")
        usable = [(t, f) for t, f in every if any(map(_is_line, f["data"]))]
        title, figure = next((pair for pair in usable if pair[0].startswith(begin)), usable[0])
        titles = [re.sub(r" at [\d.]+ (km/h|rpm)$", "", t.rpartition(": ")[2] if ":" in t[:12] else t) for t, _ in every]
        (FOLDER / f"{name}.svg").write_text(curve(title, figure, list(dict.fromkeys(titles))), encoding="utf-8")
        print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
