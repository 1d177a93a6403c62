"""Settings and effects that a run takes from what studies have measured, and the check of such a run by a finer one."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace

from ..harness.studies import chosen, fronts
from ..harness.studies.accuracy import accuracy
from ..harness.studies.quantities import percent
from ..results import Result
from ..scene.scene import Scene
from .common import print_table, status_spinner

AddReasons = Callable[[Result], Result]


def with_setting_within(scene: Scene, tolerance: float) -> tuple[Scene, AddReasons]:
    """The scene at the quickest setting known to keep the tolerance; measured first where nothing valid is known."""
    with status_spinner() as on_message:
        front = fronts.known(scene)
        if front is None or front.stale:
            reason = front.stale if front else f"nothing is known of the accuracy of {scene.name} with these settings"
            print(f"{reason}: measuring first", file=sys.stderr)
            fronts.keep(scene, accuracy(scene, on_message=on_message))
            front = fronts.known(scene)
            assert front is not None
        point = fronts.choose(scene, front.measured, tolerance)
    reasons = fronts.why(point, front, tolerance)
    print(
        f"accuracy {percent(tolerance)}: {point.series}, {point.size:.3g}, error {percent(point.error_with_finer)} "
        f"(rms where the signals move; {percent(point.largest)} at its largest); {reasons['reason']}"
    )
    print(f"  from: {front.origin}")
    return (
        scene.with_changes(point.changes) if point.changes else scene,
        lambda result: replace(result, info={**result.info, "accuracy": reasons}),
    )


def with_effects_within(scene: Scene, tolerance: float) -> tuple[Scene, AddReasons]:
    """The scene with exactly the effects that it calls for; measured first where nothing is kept."""
    with status_spinner() as on_message:
        choice = chosen.choose(scene, tolerance, on_message)
    names = [f"{unit}.{e}" for unit, on in choice.on.items() for e in on]
    print(f"effects within {percent(tolerance)}: {', '.join(names) or 'none'}; error {percent(choice.error)}")
    print(f"  {'measured now, kept in' if choice.fresh else 'as kept in'} {choice.kept}", file=sys.stderr)
    return choice.applied(scene), lambda result: replace(result, info=choice.with_reasons(result.info, tolerance))


def is_verified(scene: Scene, tolerance: float) -> bool:
    """Print how far a finer run differs, quantity by quantity, and whether all stay within the tolerance."""
    differences = fronts.verify(scene)
    print_table(
        "against half the macro step and half the internal steps",
        ("quantity", "difference"),
        [(name, percent(value)) for name, value in differences.items()],
    )
    worst = max(differences.values())
    within = worst <= tolerance
    print(
        f"verified: {percent(worst)} is within {percent(tolerance)}"
        if within
        else f"NOT verified: {percent(worst)} is more than {percent(tolerance)}"
    )
    return within
