"""Measured fronts of scenes, kept in the user's cache, and the setting that a front advises.

A front belongs to the physics of a scene: its model with the code of its components, its length, its quantities of interest. Coupling
and internal steps are the settings that the front compares; a scene with others has the same front.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput
from ...kept import Kept
from ...run.dependence import depends_on
from ...scene.scene import Scene
from .accuracy import Accuracy, Point
from .quantities import percent


def kept_front(scene: Scene) -> Kept:
    """Where the front of a scene is kept: by its model, length and quantities of interest, whatever its settings."""
    return Kept("fronts", depends_on(scene, of="model"))


def keep(scene: Scene, measured: Accuracy) -> Path:
    """Put a measured front into the user's cache; the place of its file."""
    place = kept_front(scene)
    place.write(measured)
    return place.file


def kept(scene: Scene) -> Accuracy | None:
    """The front of the scene that was measured on this machine, if it was."""
    if (data := kept_front(scene).read()) is None:
        return None
    return Accuracy(**{**data, "points": tuple(Point(**point) for point in data["points"])})


def choose(measured: Accuracy, tolerance: float) -> Point:
    """The setting that is the quickest to keep the error within `tolerance`; raises `BadInput` where none does.

    Where no time could be confirmed, the setting with the least counted work.
    """
    asked = percent(tolerance)
    if tolerance < measured.smallest_known:
        raise BadInput(
            "accuracy",
            asked,
            f"at least {100.0 * measured.smallest_known:.2g} %, the reference's own error",
            f"It is {measured.reference}.",
        )
    front = measured.front() or measured.front("calls")
    if chosen := next((p for p in front if p.error_with_finer <= tolerance), None):
        return chosen
    best = f"the best setting measured has {100.0 * front[-1].error_with_finer:.3g} %" if front else "no setting comes to the end"
    raise BadInput(
        "accuracy",
        asked,
        best,
        "Ask for less, or measure finer settings: cosimo accuracy with a larger --budget, or a scene with a shorter macro step.",
    )


def why(chosen: Point, measured: Accuracy, tolerance: float, origin: str) -> dict[str, Any]:
    """What run.json says of a choice; origin: where the measurement is, in words."""
    others = [p for p in measured.points if p.outcome == "done"]
    return {
        "asked": tolerance,
        "setting": chosen.series,
        "size": chosen.size,
        "changes": dict(chosen.changes),
        "error": chosen.error,
        "error_with_finer": chosen.error_with_finer,
        "seconds": chosen.seconds,
        "measured": len(others),
        "from": origin,
        "reference": measured.reference,
        "shared_with_reference": measured.shares,
        "reference_error": measured.smallest_known,
        "reason": f"the quickest of {len(others)} measured settings whose error, and that of all finer ones of its series, "
        f"stays within {100.0 * tolerance:g} %",
    }
