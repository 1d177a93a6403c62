"""What a user should know of the errors that a repetition has shown: warnings, each with the steps that would help."""

from __future__ import annotations

from math import floor, isfinite, isnan, log10

from ..scene.scene import Scene
from .comparison import worst_of
from .record import Verification
from .thresholds import AIM, LOWEST_ORDER, MOSTLY, WARN

MOST_NAMED = 2  # internal steps that a message names
TRIED = 0.5  # of the steps, in the second run


def warnings_of(scene: Scene, verification: Verification) -> list[str]:
    """What a user should know of the errors that were found."""
    parted = [name for name, e in verification.signals.items() if e.parted]
    wrong = {name: e for name, e in verification.signals.items() if e.rms > WARN and not e.parted}
    texts = []
    if parted:
        texts.append(
            f"the motion is chaotic: histories of {_listed(parted)} part from those of a run with half the steps, "
            "while their deviations agree. These histories are one of many; figures have their error"
        )
    if wrong and parted:  # what hangs on a history that has parted is no sign of a step that is too long
        wrong = {name: e for name, e in wrong.items() if not isnan(e.order) and e.order > 0.5}
    shifted = {name: e for name, e in wrong.items() if e.shifted}
    wrong = {name: e for name, e in wrong.items() if not e.shifted}
    if wrong:
        worst = worst_of(wrong)
        others = _listed(sorted(wrong, key=worst.__ne__))
        texts.append(
            f"{_steps_too_long(verification)} too long for {others}: the error of {worst} is {_percent(wrong[worst].rms)} of its "
            f"deviation (rms), {_percent(wrong[worst].largest)} at its largest. "
            f"{suggestion(scene, verification, worst)}"
        )
    if shifted:
        worst = worst_of(shifted)
        others = _listed(sorted(shifted, key=worst.__ne__))
        texts.append(
            f"with half the steps, {others} jump{'s' if len(shifted) == 1 else ''} at other instants: the error of "
            f"{worst} is {_percent(shifted[worst].rms)} of its deviation (rms), nearly all of it in 1 % of the rows. "
            f"{suggestion(scene, verification, worst)}"
        )
    if unseen := verification.unseen:
        worst = max(unseen, key=lambda name: unseen[name])
        others = _listed(sorted(unseen, key=worst.__ne__))
        texts.append(
            f"rows are too far apart for {others}: between two, {worst} departs from a straight line by "
            f"{_percent(unseen[worst])} of its deviation (rms), and its extremes, counts and shares of time miss what "
            f"lies there. {_denser(scene)}"
        )
    return texts


def _denser(scene: Scene) -> str:
    """How rows get denser."""
    interval = scene.record.interval
    if interval is not None and interval > scene.master.step:
        return f"Lower record.interval, which is {interval:g} s"
    return f"Shorten master.step, which is {scene.master.step:g} s"


def of_macro_step(verification: Verification) -> bool:
    """Whether the largest error is that of the macro step, as far as is known."""
    return not verification.inside or verification.coupling >= MOSTLY


def _steps_too_long(verification: Verification) -> str:
    """Which steps make the largest error."""
    if of_macro_step(verification):
        return "the macro step is"
    names = _inner_names(verification)
    return (
        f"the internal steps ({names}) are" if verification.coupling <= 1.0 - MOSTLY else f"the steps (macro step, {names}) are"
    )


def _inner_names(verification: Verification) -> str:
    names = [_inner_name(place) for place in verification.inside]
    return ", ".join(names[:MOST_NAMED]) + (", ..." if len(names) > MOST_NAMED else "")


def _inner_name(place: str) -> str:
    return place.removeprefix("units.").replace(".parameters.", ".")


def suggestion(scene: Scene, verification: Verification, name: str) -> str:
    """Steps that would bring the error of a signal below what is aimed at."""
    error = verification.signals[name]
    if error.half <= AIM:
        return f"With {_settings(scene, verification, TRIED)} it is {_percent(error.half)}"
    if verification.runs > 2 and not error.order > LOWEST_ORDER:
        trend = "falls slowly" if error.half < error.rms else "does not fall"
        return f"The error {trend} with the steps: with {_settings(scene, verification, TRIED)} it is {_percent(error.half)}"
    order = min(error.order, 2.0) if isfinite(error.order) else 1.0
    known, at = (error.half, TRIED) if isfinite(error.half) else (error.rms, 1.0)
    seen = f"at the order {error.order:.2g} that three runs show" if isfinite(error.order) else "if the error falls with the step"
    return f"Take {_settings(scene, verification, at * (AIM / known) ** (1.0 / order))} for {_percent(AIM)}, {seen}"


def _settings(scene: Scene, verification: Verification, factor: float) -> str:
    """The steps that matter, a factor shorter; those that were tried as they are, others with one digit."""
    shown = (lambda size: f"{size:.3g}") if factor == TRIED else _rounded_down
    what = "a tolerance of master.control that gives steps of" if scene.master.control else "master.step ="
    steps = (
        [] if verification.inside and verification.coupling <= 1.0 - MOSTLY else [f"{what} {shown(factor * scene.master.step)} s"]
    )
    if not of_macro_step(verification):
        inner = [f"{_inner_name(place)} = {shown(factor * size)}" for place, size in verification.inside.items()]
        steps += inner[:MOST_NAMED] + (["the other substeps in proportion"] if len(inner) > MOST_NAMED else [])
    return " and ".join(filter(None, (", ".join(steps[:-1]), steps[-1])))


def _rounded_down(step: float) -> str:
    """A step with one digit that is not longer."""
    digit = 10.0 ** floor(log10(step))
    return f"{floor(step / digit * (1.0 + 1e-9)) * digit:.1g}"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} other signal{'s' if len(names) > 2 else ''}"


def _percent(share: float) -> str:
    """Of two digits; large ones say no more than that."""
    return f"{100.0 * share:.2g} %" if share < 0.995 else f"{100.0 * share:.0f} %" if share < 100.0 else "more than 10000 %"
