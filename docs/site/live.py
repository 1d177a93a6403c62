"""Scenes that compute in the pages of their systems. `COSIMO_DOCS_LIVE`: "all" (default), "off", or the name of one scene.

Without zig (extra `native`), which compiles them, there are none.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

FOLDER = "_static/live"  # in the built site
LIBRARY = "../plotly.min.js"  # the site's own, from there


@dataclass(frozen=True)
class Live:
    """A scene at the beginning of a page: its question, and parameters with the ends of their sliders."""

    page: str
    scene: str
    question: str
    vary: dict[str, tuple[float, float]]


SCENES = (
    Live(
        "systems/railway",
        "en50318-2002",
        "What do speed and static force do to the contact force, and from which macro step are the numbers no good?",
        {
            "pantograph.speed": (40.0, 90.0),
            "pantograph.static_force": (60.0, 180.0),
            "catenary.contact_wire_tension": (12e3, 27e3),
        },
    ),
    Live(
        "systems/bearings",
        "ball-bearing-clearance",
        "At which clearance does the motion stop repeating itself?",
        {"bearing.clearance.radial_clearance": (0.0, 40e-6), "bearing.mass": (5.0, 60.0), "bearing.damping": (50.0, 800.0)},
    ),
    Live(
        "systems/rov",
        "rov-station-keeping",
        "How strong may the current and its gust be, until six thrusters no longer hold the vehicle?",
        {"current.speed": (0.0, 1.5), "current.gust.amplitude": (0.0, 1.5), "hull.mass": (9.0, 16.0)},
    ),
    Live(
        "systems/two_axis_joint",
        "mass-on-spring",
        "From which stiffness on is the coupling unstable? Take a longer macro step, too.",
        {"spring.stiffness": (25.0, 1600.0), "spring.damping": (0.0, 40.0), "mass.mass": (0.25, 4.0)},
    ),
    Live(
        "systems/wind_pump",
        "wind-pump-gusts",
        "Which lever pumps most in a gust, and what does the shaft bear?",
        {"converter.lever_mass": (10.0, 120.0), "converter.crank_radius": (0.01, 0.04), "wind.gusts.amplitude": (0.0, 15.0)},
    ),
    Live(
        "systems/friction_drive",
        "friction-drive-step",
        "From which normal force do the wheels slip?",
        {"wheels.normal_force": (4.0, 40.0), "wheels.friction": (0.1, 0.8), "controller.feed_gain": (5.0, 60.0)},
    ),
    Live(
        "systems/pipe_robot",
        "pipe-robot-resonance",
        "Where is the resonance, and what does a spring do that stiffens?",
        {"straight.stiffness": (500.0, 6000.0), "straight.damping": (1.0, 20.0), "program.start_amplitude": (5.0, 40.0)},
    ),
    Live(
        "systems/wrist",
        "wrist-motion",
        "How do both rows share the motion of the hand?",
        {"wrist.flexion_stiffness": (0.2, 4.0), "wrist.deviation_stiffness": (0.2, 4.0), "wrist.hand_mass": (0.2, 1.0)},
    ),
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
            place = f"{up}{FOLDER}/{live.scene}.html"
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
        explore_page(cosimo.load_scene(live.scene), out / FOLDER / f"{live.scene}.html", parameters=live.vary, library=LIBRARY)
