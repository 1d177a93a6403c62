"""What `cosimo run --dry-run` shows of a scene: how it is resolved, how long its step may be, and what a run will cost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ..engine.coupling import Coupling, Link
from ..engine.coupling.graph import Loop
from ..engine.stepping.adaptive import AdaptiveStepping
from ..engine.stepping.loop import obstacles
from ..opened.open_scene import started
from ..run import work
from ..run.thresholds import PREFIX_STEPS, PREFIX_WORK, PROBED, WINDOWS_SHARE
from ..scene.scene import Scene
from ..units.kinds import UnitKind
from .advice import Advice, StabilityAdvice
from .verification import run_verified

Table = tuple[str, tuple[str, ...], list[tuple[Any, ...]]]

NOTHING_PROBED = Advice(StabilityAdvice(), 0, 0.0, 0.0, 0.0)


def not_executed(scene: Scene) -> list[str]:
    """The units whose code is foreign and in no sandbox, and those that run once: looking at a scene does not execute them."""
    return [name for name, kind in scene.kinds.items() if (kind.foreign and not kind.sandboxed) or kind.once]


def why_not_executed(names: list[str]) -> str:
    """Why something of a scene is not known, for the reader."""
    return f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} of others, and looking executes none"


def tables(scene: Scene, coupling: Coupling) -> Iterator[Table]:
    """(title, columns, rows) of the units and of what connects them."""
    yield (
        "units",
        ("unit", "component", "effects", "remarks"),
        [
            (name, kind.shown, ", ".join(e for e, why in coupling.interfaces[name].effects.items() if why), _remarks(kind))
            for name, kind in scene.kinds.items()
        ]
        + [(contact.name, f"contact, {contact.law}", "", "") for contact in scene.contacts],
    )
    if links := (*coupling.links, *coupling.texts):
        yield (
            "connections",
            ("from", "to", "factor", "offset"),
            [(".".join(link.source), ".".join(link.target), *_conversion(link)) for link in links],
        )
    if scene.faults:
        yield (
            "faults",
            ("kind", "signal or unit", "from, s", "to, s", "inputs"),
            [
                (
                    fault.kind,
                    fault.signal or fault.unit,
                    fault.begin,
                    "end" if fault.end is None else fault.end,
                    ", ".join(map(".".join, ends)),
                )
                for fault, ends in zip(scene.faults, coupling.faults, strict=True)
            ],
        )


def lines(scene: Scene, coupling: Coupling, advice: Advice, *, in_process: bool = False) -> Iterator[str]:
    """The remarks, one line each; `in_process`: how the run was probed."""
    master = scene.master
    circles = [", ".join(group) for group in coupling.groups if len(group) > 1]
    yield f"coupled in a loop: {'; '.join(circles) or 'none'}"
    loops = [step.text for step in coupling.feedthrough_schedule if isinstance(step, Loop)]
    if loops:
        yield f"algebraic loops: {'; '.join(loops)}"
    if master.abilities.sequential:
        yield f"order of stepping: {', '.join(coupling.order(master.order))}"
    if coupling.undriven:
        yield f"inputs at their start values: {', '.join(coupling.undriven)}"
    yield f"recorded: {', '.join(map('.'.join, (*coupling.signals, *coupling.recorded_texts))) or 'nothing'}"
    yield from advice.lines()
    yield from advice.cut
    if not advice.steps:  # nothing was executed
        return
    whole = advice.steps * advice.seconds
    steps = f"{advice.steps} macro steps of {master.step:g} s" + (" at first" if master.control else "")
    compiling = f"; a first run compiles, {advice.compiling:.2g} s just now" if advice.compiling else ""
    yield (
        f"estimated CPU time of {scene.duration:g} s: {whole:.2g} s ({master.algorithm}, {steps}, {1e6 * advice.seconds:.3g} µs "
        f"each), plus start-up{compiling}"
    )
    about = "about" if in_process else "in process, below"
    if not work.allows(advice.steps * advice.work, 2.0):
        yield (
            f"error estimate: windows of the run with half the macro step, {about} {WINDOWS_SHARE * whole:.2g} s; --verify whole: "
            f"the complete run, {2.0 * whole:.2g} s"
        )
    else:
        yield (
            f"error estimate: a second run with half the steps, {about} {2.0 * whole:.2g} s; if the two differ by much, a third "
            "with a quarter"
        )


def _remarks(kind: UnitKind) -> str:
    unit = kind.settings
    messages = [
        f"steps with every {unit.every}th macro step" if unit.every > 1 else "",
        kind.isolation,
        unit.interface or "",
        unit.solver or "",
    ]
    return ", ".join(filter(None, messages))


def _conversion(link: Link) -> tuple[str, str]:
    """(times, plus) of a link, or the entries of its map."""
    if link.map:
        return ", ".join(f"{value:g}: {becomes:g}" for value, becomes in link.map), ""
    return _number(link.factor, 1.0), _number(link.offset, 0.0)


def _number(value: float, usual: float) -> str:
    return "" if value == usual else f"{value:.6g}"


def first_part(scene: Scene, advice: Advice) -> tuple[str, list[str]]:
    """What the first part of a run shows: its errors in words, and warnings; the same judgement as of a whole run.

    A part that is too much work for a dry run is not run.
    """
    step = scene.master.step
    length = min(max(PREFIX_STEPS * step, PROBED * scene.duration), scene.duration)
    if length / step * advice.work > PREFIX_WORK:
        return f"no trial run of the first {length:.3g} s: it takes about {length / step * advice.seconds:.2g} s", []
    result = run_verified(work.beginning(scene, length), in_process=True)
    verification = result.info.verification
    if result.outcome != "done" or not verification.done:
        return f"trial run of the first {length:.3g} s: {result.message or f'{result.outcome}, {verification.why}'}", []
    signals = verification.signals
    worst = max(signals, key=lambda name: signals[name].rms or 0.0, default="")
    error = (
        f"{100.0 * (signals[worst].rms or 0.0):.2g} % ({worst}, rms, in % of its standard deviation)"
        if worst
        else "none, no signal"
    )
    return f"trial run of the first {length:.3g} s: largest error {error}", list(result.info.warnings)


ADAPTIVE = {"control": "master.control", "events": "master.events"}


class SteppingPath(NamedTuple):
    """Of a scene in process."""

    obstacles: tuple[str, ...]  # settings that put it on the general path; without any, batches of steps are compiled code
    python: tuple[str, ...]  # units that are stepped through Python


def stepping_path(scene: Scene) -> SteppingPath:
    """Opens and initializes the scene's units, in process where they are components; raises what a run of it would."""
    with started(scene) as course:
        reasons = [words for key, words in ADAPTIVE.items() if getattr(scene.master, key)]
        if isinstance(course.stepping, AdaptiveStepping) and not reasons:
            reasons = ["units that may return early from a step"]
        return SteppingPath((*reasons, *dict.fromkeys(obstacles(course.master, course.account))), course.master.machine.in_python)
