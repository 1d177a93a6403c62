"""Scenes that compute in the pages of their systems. `COSIMO_DOCS_LIVE`: "all" (default), "off", or the name of one scene.

Without zig (extra `native`), which compiles them, there are none.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

FOLDER = "_static/live"  # in the built site
LIBRARY = "../plotly.min.js"  # the site's own, from there


@dataclass(frozen=True)
class Live:
    """A scene in a page: its question, what is changed of it, whether it has sliders. What its page offers, the scene says."""

    page: str
    scene: str
    question: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    sliders: bool = True

    @property
    def file(self) -> str:
        """Name of its page."""
        return f"{self.scene if self.sliders else self.page}.html"


SCENES = (
    Live(
        "index",
        "en50318-2002",
        "Three promises, three controls. What accuracy costs in time: take another macro step. Hard cases stay stable, or the page says "
        "that they do not: hold the inputs, step longer. Only the effects wanted: switch one off, and see what a step takes.",
        sliders=False,
    ),
    Live(
        "systems/railway",
        "en50318-2002",
        "What moves the smallest contact force most, from which macro step are the numbers no good, and what do slackening droppers "
        "change?",
    ),
    Live("systems/bearings", "ball-bearing-clearance", "At which clearance does the motion stop repeating itself?"),
    Live(
        "systems/rotor",
        "rotor-run-up",
        "How large does the motion become at the critical speed, and what do damping and clearance do about it? Run up four times as fast "
        "as in the scene.",
        {
            "stop_time": 1.0,
            "rotor.run_up.acceleration": 800.0,  # rad/s2
            "rotor.element": 0.1,  # m
            "record.snapshots": (),
            "record.snapshot_interval": None,
        },
    ),
    Live(
        "systems/rov",
        "rov-station-keeping",
        "How strong may the current and its gust be, until six thrusters no longer hold the vehicle?",
    ),
    Live(
        "systems/two_axis_joint",
        "mass-on-spring",
        "From which stiffness on is the coupling unstable? Take a longer macro step, too.",
    ),
    Live("systems/wind_pump", "wind-pump-gusts", "Which lever pumps most in a gust, and what does the shaft bear?"),
    Live("systems/friction_drive", "friction-drive-step", "From which normal force do the wheels slip?"),
    Live("systems/pipe_robot", "pipe-robot-resonance", "Where is the resonance, and what does a spring do that stiffens?"),
    Live("systems/wrist", "wrist-motion", "How do both rows share the motion of the hand?"),
)


def wanted() -> list[Live]:
    """The scenes that this build makes."""
    choice = os.environ.get("COSIMO_DOCS_LIVE", "all") if find_spec("ziglang") is not None else "off"
    return [live for live in SCENES if choice in ("all", live.scene)]


def frame(page: str) -> str:
    """What a page begins with; "" for a page without a live scene."""
    up = "../" * page.count("/")
    for live in wanted():
        if live.page == page:
            place = f"{up}{FOLDER}/{live.file}"
            return (
                f'```{{raw}} html\n<p class="live-question">{live.question} <a href="{place}">In a page of its own</a></p>\n'
                f'<iframe class="live" src="{place}" loading="lazy" title="Live scene: {live.question}"></iframe>\n```\n'
            )
    return ""


def build(out: Path) -> None:
    """The pages of the live scenes, into the built site."""
    import cosimo
    from cosimo.orchestrator.systems import explore_page

    for live in wanted():
        scene = cosimo.load_scene(live.scene).with_changes(live.changes)
        explore_page(scene, out / FOLDER / live.file, parameters=None if live.sliders else {}, library=LIBRARY)
