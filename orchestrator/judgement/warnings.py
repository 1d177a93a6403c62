"""What a user should know of the errors that a repetition has shown: warnings, each with the steps that would help."""

from __future__ import annotations

from math import floor, isfinite, isnan, log10

from ..run.comparison import SURE, SignalError, worst_of
from ..run.run_record import RunRecord
from ..run.thresholds import AIM, LOWEST_ORDER, MOSTLY, WARN
from ..scene.meshes import meshes_of
from ..scene.scene import Scene
from .record import NOT_ASKED, Verification

UNVERIFIED = "not verified, as requested: the errors of the results are not known"
MOST_NAMED = 2  # internal steps that a message names
TRIED = 0.5  # of the steps, in the second run


def not_verified(why: str) -> str:
    """The warning of numbers whose errors are not known."""
    return UNVERIFIED if why == NOT_ASKED else f"not verified: {why or 'cosimo did not repeat the run'}"


def doubts_of(info: RunRecord) -> list[str]:
    """What keeps a run from being a sure result: an end before its end, its warnings, and errors that are not known.

    info: of the result; that of an earlier version has no warning of a run that was not verified.
    """
    if info.outcome != "done":
        return [f"{info.outcome}: {info.message}", *info.warnings]
    warning = not_verified(info.verification.why)
    return [*info.warnings] if info.verification.done or warning in info.warnings else [*info.warnings, warning]


def warnings_of(scene: Scene, verification: Verification) -> list[str]:
    """What a user should know of the errors that were found, or of why none were."""
    if not verification.done:
        return [not_verified(verification.why)]
    parted = [name for name, e in verification.signals.items() if e.parted]
    wrong = {name: e for name, e in verification.signals.items() if e.rms > WARN and not e.parted}
    texts = [f"not confirmed: {verification.why}"] if verification.how == "whole" and verification.why else []
    if parted:
        texts.append(
            f"the motion is chaotic: {_listed(parted)} diverge{'s' if len(parted) == 1 else ''} from the run with "
            "half the steps, while the standard deviations agree. "
            "The time histories are one of many; key results keep their errors"
        )
    if wrong and parted:  # what hangs on a history that has parted is no sign of a step that is too long
        wrong = {name: e for name, e in wrong.items() if not isnan(e.order) and e.order > 0.5}
    shifted = {name: e for name, e in wrong.items() if e.shifted}
    wrong = {name: e for name, e in wrong.items() if not e.shifted}
    of_steps: dict[str, dict[str, SignalError]] = {}
    for name, e in wrong.items():
        of_steps.setdefault(_steps_too_long(verification, name), {})[name] = e
    for steps, of_them in of_steps.items():
        worst = worst_of(of_them)
        others = _listed(sorted(of_them, key=worst.__ne__))
        texts.append(
            f"{steps} too long for {others}. Error of {worst}: {_percent(of_them[worst].rms)} rms, "
            f"{_percent(of_them[worst].largest)} maximum (in % of the standard deviation). "
            f"{suggestion(scene, verification, worst)}"
        )
    if shifted:
        worst = worst_of(shifted)
        others = _listed(sorted(shifted, key=worst.__ne__))
        texts.append(
            f"{others} switch{'es' if len(shifted) == 1 else ''} at other instants with half the steps. Error of {worst}: "
            f"{_percent(shifted[worst].rms)} rms (in % of the standard deviation), nearly all of it in 1 % of the samples. "
            f"{suggestion(scene, verification, worst)}"
        )
    for place in verification.parts:
        worst, change = verification.worst_of_part(place)
        if SURE * change > WARN:
            texts.append(
                f"{place} is too coarse for {worst}: its refinement alone changes this signal by "
                f"{_percent(change)} of the standard deviation (rms). Lower it"
            )
    worst, error = verification.mesh.worst
    if error > WARN:
        meshes = ", ".join(verification.mesh.places)
        finer = ", ".join(f"{name} = {m.value / 2.0 if m.by_length else 2.0 * m.value:g}" for name, m in meshes_of(scene).items())
        texts.append(
            f"the mesh ({meshes}) is too coarse for {worst}. Error, estimated with half as many elements: {_percent(error)} rms (in % of "
            f"the standard deviation). Set {finer} for about half of this error"
        )
    for place, why in verification.not_refined.items():
        texts.append(f"the errors exclude the error due to {place}, which could not be refined: {why}")
    if unseen := verification.unseen:
        worst = max(unseen, key=lambda name: unseen[name])
        others = _listed(sorted(unseen, key=worst.__ne__))
        texts.append(
            f"samples are too far apart for {others}: between two samples, {worst} differs from a straight line by "
            f"{_percent(unseen[worst])} of its standard deviation (rms). Extremes, counts and shares of time may be wrong. "
            f"{_denser(scene)}"
        )
    return texts


def _denser(scene: Scene) -> str:
    """How rows get denser."""
    interval = scene.record.interval
    if interval is not None and interval > scene.master.step:
        return f"Lower record.interval, which is {interval:g} s"
    return f"Shorten master.step, which is {scene.master.step:g} s"


def of_macro_step(verification: Verification, name: str) -> bool:
    """Whether the error of a signal is that of the macro step, as far as is known."""
    return not verification.inside or verification.signals[name].coupling >= MOSTLY


def _of_internal_steps(verification: Verification, name: str) -> bool:
    """Whether the error of a signal is that of the internal steps, as far as is known."""
    return bool(verification.inside) and verification.signals[name].coupling <= 1.0 - MOSTLY


def _steps_too_long(verification: Verification, name: str) -> str:
    """Which steps make the error of a signal."""
    if of_macro_step(verification, name):
        return "the macro step is"
    names = _inner_names(verification)
    return (
        f"the internal steps ({names}) are" if _of_internal_steps(verification, name) else f"the steps (macro step, {names}) are"
    )


def _inner_names(verification: Verification) -> str:
    names = [*verification.inside]
    return ", ".join(names[:MOST_NAMED]) + (", ..." if len(names) > MOST_NAMED else "")


def suggestion(scene: Scene, verification: Verification, name: str) -> str:
    """Steps that would bring the error of a signal below what is aimed at."""
    error = verification.signals[name]
    if error.half <= AIM:
        return f"Set {_settings(scene, verification, name, TRIED)} for {_percent(error.half)}"
    if verification.runs > 2 and not error.order > LOWEST_ORDER:
        trend = "falls slowly" if error.half < error.rms else "does not fall"
        return (
            f"The error {trend} with the steps: with {_settings(scene, verification, name, TRIED)} it is {_percent(error.half)}"
        )
    order = min(error.order, 2.0) if isfinite(error.order) else 1.0
    known, at = (error.half, TRIED) if isfinite(error.half) else (error.rms, 1.0)
    seen = f"(observed order {error.order:.2g})" if isfinite(error.order) else "if the error falls with the step"
    return (
        f"Set {_settings(scene, verification, name, at * (AIM / known) ** (1.0 / order))} for an error of {_percent(AIM)} {seen}"
    )


def _settings(scene: Scene, verification: Verification, name: str, factor: float) -> str:
    """The steps that matter for a signal, a factor shorter; those that were tried as they are, others with one digit."""
    shown = (lambda size: f"{size:.3g}") if factor == TRIED else _rounded_down
    what = "a tolerance of master.control for steps of" if scene.master.control else "master.step ="
    steps = [] if _of_internal_steps(verification, name) else [f"{what} {shown(factor * scene.master.step)} s"]
    if not of_macro_step(verification, name):
        inner = [f"{place} = {shown(factor * size)}" for place, size in verification.inside.items()]
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
