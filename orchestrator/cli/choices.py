"""Settings and effects that a run takes from what studies have measured, and the check of such a run by its repetition."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from math import inf

from ..harness.studies import chosen, fronts
from ..harness.studies.accuracy import accuracy
from ..harness.studies.quantities import percent
from ..judgement.record import STEPS
from ..run.results import Result
from ..scene.scene import Scene
from .common import print_table, status_spinner

AddReasons = Callable[[Result], Result]
BUDGET = 20.0  # s of measuring for a run that asks for an accuracy: fewer fine settings than in a study of it


def with_setting_within(scene: Scene, tolerance: float) -> tuple[Scene, AddReasons]:
    """The scene at the quickest setting known to keep the tolerance; measured first where nothing is kept."""
    if (measured := fronts.kept(scene)) is None:
        print(
            f"nothing is known of the accuracy of {scene.name} on this machine: measuring first, for {BUDGET:g} s beside a reference",
            file=sys.stderr,
        )
        with status_spinner() as on_message:
            measured = accuracy(scene, budget=BUDGET, on_message=on_message)
        fronts.keep(scene, measured)
    origin = f"measured on this machine, {fronts.kept_front(scene).file}"
    point = fronts.choose(measured, tolerance)
    reasons = fronts.why(point, measured, tolerance, origin)
    print(
        f"accuracy {percent(tolerance)}: {point.series}, {point.size:.3g}, error {percent(point.error_with_finer)} "
        f"(rms where the signals move; {percent(point.largest)} at its largest); {reasons['reason']}"
    )
    print(f"  from: {origin}")
    return (
        scene.with_changes(point.changes) if point.changes else scene,
        lambda result: replace(result, info=replace(result.info, accuracy=reasons)),
    )


def with_effects_within(scene: Scene, tolerance: float) -> tuple[Scene, AddReasons]:
    """The scene with exactly the effects that it calls for; measured first where nothing is kept."""
    with status_spinner() as on_message:
        choice = chosen.choose(scene, tolerance, on_message)
    names = [f"{unit}.{e}" for unit, on in choice.on.items() for e in on]
    print(f"effects within {percent(tolerance)}: {', '.join(names) or 'none'}; error {percent(choice.error)}")
    print(f"  {'measured now, kept in' if choice.fresh else 'as kept in'} {choice.kept}", file=sys.stderr)
    return choice.applied(scene), lambda result: replace(result, info=choice.with_reasons(result.info, tolerance))


def is_verified(result: Result, tolerance: float) -> bool:
    """Print the errors of the quantities of interest by what makes them, and whether each stays within the tolerance."""
    verification = result.info.verification
    if not verification.done:
        print(f"NOT verified: {verification.why}")
        return False
    numbers = {
        cause: {n: inf if e is None else e for n, e in errors.items()} for cause, errors in verification.quantities.items()
    }
    print_table(
        f"errors of the quantities of {result.scene.name}, each cause by itself",
        ("quantity", *numbers),
        [(name, *(percent(errors[name]) for errors in numbers.values())) for name in numbers[STEPS]],
    )
    if missing := ", ".join(verification.not_refined):
        print(f"NOT verified: {missing} could not be refined")
        return False
    if not_covered := verification.mesh.not_covered:
        print(
            f"NOT verified: the mesh ({', '.join(not_covered)}) is not covered: {'; '.join(dict.fromkeys(not_covered.values()))}"
        )
        return False
    worst = max(error for errors in numbers.values() for error in errors.values())
    within = worst <= tolerance
    print(
        f"verified: {percent(worst)} is within {percent(tolerance)}"
        if within
        else f"NOT verified: {percent(worst)} is more than {percent(tolerance)}"
    )
    return within
