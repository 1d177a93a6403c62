"""Settings and effects that a run takes from what studies have measured. Nothing is printed here: the command does that."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ...components.core.errors import BadInput
from .common import listed, share

if TYPE_CHECKING:
    from ..harness.studies.chosen import Choice
    from ..scene.scene import Scene

AUTO = "auto"
TOLERANCE = "1%"


class ChosenSetting(NamedTuple):
    """A scene at a setting from its front. reasons: what run.json holds of the choice."""

    scene: Scene
    reasons: dict[str, Any]
    messages: tuple[str, ...]


class ChosenEffects(NamedTuple):
    """A scene with exactly the effects that it calls for, and why."""

    scene: Scene
    choice: Choice
    messages: tuple[str, ...]


def setting_within(
    scene: Scene, tolerance: float, on_message: Callable[[str], None], announce: Callable[[str], None]
) -> ChosenSetting:
    """The scene at the quickest setting known to keep the tolerance; measured first, announced, where nothing valid is known."""
    from ..harness.studies.accuracy import accuracy as measure
    from ..harness.studies.fronts import choose, keep, known, why
    from ..harness.studies.quantities import percent

    front = known(scene)
    if front is None or front.stale:
        reason = front.stale if front else f"nothing is known of the accuracy of {scene.name} with these settings"
        announce(f"{reason}: measuring first")
        keep(scene, measure(scene, on_message=on_message))
        front = known(scene)
        assert front is not None
    point = choose(scene, front.measured, tolerance)
    reasons = why(point, front, tolerance)
    messages = (
        f"accuracy {percent(tolerance)}: {point.series}, {point.size:.3g}, error {percent(point.error_with_finer)} "
        f"(rms where the signals move; {percent(point.largest)} at its largest); "
        f"{reasons['reason']}",
        f"  from: {front.origin}",
    )
    return ChosenSetting(scene.with_changes(point.changes) if point.changes else scene, reasons, messages)


def effects_within(scene: Scene, tolerance: float, on_message: Callable[[str], None]) -> ChosenEffects:
    """The scene with exactly the effects that it calls for; measured first where nothing is kept."""
    from ..harness.studies.chosen import choose
    from ..harness.studies.quantities import percent

    choice = choose(scene, tolerance, on_message)
    names = [f"{unit}.{e}" for unit, on in choice.on.items() for e in on]
    messages = (
        f"effects within {percent(tolerance)}: {', '.join(names) or 'none'}; error {percent(choice.error)}",
        f"  {'measured now, kept in' if choice.fresh else 'as kept in'} {choice.kept}",
    )
    return ChosenEffects(choice.applied(scene), choice, messages)


def tolerance_of_effects(effects: Sequence[str] | None, tolerance: str | None) -> float | None:
    """The share within which effects are to be chosen; None where they are not. Raises `BadInput` for half of it."""
    auto = AUTO in (listed("--effects", effects) if effects else ())
    if not auto:
        if tolerance is not None:
            raise BadInput("--tolerance", repr(tolerance), "none without --effects auto; it would have no effect", "Remove it.")
        return None
    if list(effects or ()) != [AUTO]:
        raise BadInput("--effects", repr(",".join(effects or ())), "auto alone", "What else there is, it finds.")
    return share("--tolerance", tolerance or TOLERANCE)
