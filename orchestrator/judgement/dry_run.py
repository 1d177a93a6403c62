"""What `cosimo run --dry-run` shows of a scene: how it is resolved, how long its step may be, and what a run will cost."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isinf
from typing import Any, NamedTuple

from ..engine.coupling import Coupling, Link
from ..engine.coupling.graph import Loop
from ..engine.stepping.adaptive import AdaptiveStepping
from ..engine.stepping.loop import obstacles
from ..scene.scene import Scene
from ..session.open_scene import started
from . import work
from .probing import Advice, PairLimit
from .thresholds import PREFIX_STEPS, PREFIX_WORK, PROBED, WINDOWS_SHARE
from .verification import run

Table = tuple[str, tuple[str, ...], list[tuple[Any, ...]]]

NOTHING_PROBED = Advice((), (), 0, 0.0, 0.0, 0.0)


def not_executed(scene: Scene) -> list[str]:
    """The units whose code is foreign and in no sandbox: looking at a scene does not execute it."""
    return [name for name, unit in scene.units.items() if unit.fmu and unit.isolation != "restricted"]


def why_not_executed(names: list[str]) -> str:
    """Why something of a scene is not known, for the reader."""
    return f"{', '.join(names)} {'is an FMU' if len(names) == 1 else 'are FMUs'}, and looking executes none"


ISOLATION = {"none": "", "process": "in a process of its own", "restricted": "in a sandbox"}

PAIR_COLUMNS = (
    "pair",
    "natural frequency, Hz",
    "damping, of critical",
    "longest step, s: held inputs",
    "linear",
    "quadratic",
    "damping at master.step, of critical",
)


def tables(scene: Scene, coupling: Coupling, advice: Advice) -> Iterator[Table]:
    """(title, columns, rows) of the units, of what connects them, and of what limits the macro step."""
    yield (
        "units",
        ("unit", "what", "effects", "remarks"),
        [
            (
                name,
                unit.signals or unit.component or unit.fmu,
                ", ".join(e for e, why in coupling.interfaces[name].effects.items() if why),
                _remarks(name, scene),
            )
            for name, unit in scene.units.items()
        ]
        + [(contact.name, f"contact, {contact.law}", "", "") for contact in scene.contacts],
    )
    if links := (*coupling.links, *coupling.texts):
        yield (
            "connections",
            ("from", "to", "times", "plus"),
            [(".".join(link.source), ".".join(link.target), *_conversion(link)) for link in links],
        )
    if scene.faults:
        yield (
            "faults",
            ("kind", "of", "from s", "to s", "inputs"),
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
    if advice.limits:
        yield "stability, estimated in closed form", PAIR_COLUMNS, [_row(limit) for limit in advice.limits]


def lines(scene: Scene, coupling: Coupling, advice: Advice, *, in_process: bool = False) -> Iterator[str]:
    """The remarks, one line each; `in_process`: how the run was probed."""
    master = scene.master
    circles = [", ".join(group) for group in coupling.groups if len(group) > 1]
    yield f"units that feed one another: {'; '.join(circles) or 'none'}"
    loops = [step.text for step in coupling.feedthrough_schedule if isinstance(step, Loop)]
    if loops:
        yield f"algebraic loops: {'; '.join(loops)}"
    if master.abilities.sequential:
        yield f"order of stepping: {', '.join(coupling.order(master.order))}"
    if coupling.undriven:
        yield f"inputs at their start values: {', '.join(coupling.undriven)}"
    yield f"recorded: {', '.join(map('.'.join, (*coupling.signals, *coupling.recorded_texts))) or 'nothing'}"
    undeclared = [
        n
        for group in coupling.groups
        if len(group) > 1
        for n in group
        if any(o.feedthrough is None for o in coupling.interfaces[n].outputs.values())
    ]
    if undeclared and master.abilities.rates:
        yield f"no limit of the macro step known for what does not tell which outputs follow inputs: {', '.join(undeclared)}"
    for reason in advice.unknown:
        yield f"no limit of the macro step known for {reason}"
    yield from advice.cut
    if not advice.steps:  # nothing was executed
        return
    whole = advice.steps * advice.seconds
    steps = f"{advice.steps} macro steps of {master.step:g} s" + (" at first" if master.control else "")
    compiling = f" and, in a first run, compiling once ({advice.compiling:.2g} s just now)" if advice.compiling else ""
    yield (
        f"{master.algorithm}: {steps}, {1e6 * advice.seconds:.3g} us each: about {whole:.2g} s for {scene.duration:g} s, "
        f"beside starting{compiling}"
    )
    about = "about" if in_process else "in process, below"
    if not work.allows(advice.steps * advice.work, 2.0):
        yield (
            f"verification: windows of the run with half the macro step, {about} {WINDOWS_SHARE * whole:.2g} s; the whole with "
            f"--verify whole, {2.0 * whole:.2g} s"
        )
    else:
        yield (
            f"verification: the run again with half the steps, {about} {2.0 * whole:.2g} s; where the two differ by much, with a "
            "quarter of them as well"
        )


def _remarks(name: str, scene: Scene) -> str:
    unit = scene.units[name]
    messages = [
        f"steps with every {unit.every}th macro step" if unit.every > 1 else "",
        ISOLATION[unit.isolation],
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


def _row(limit: PairLimit) -> tuple[str, ...]:
    return (
        limit.pair,
        f"{limit.frequency:.3g}" if limit.omega2 else "no spring",
        _share(limit.share),
        *("any" if isinf(h) else f"{h:.3g}" for h in limit.longest),
        _share(limit.left),
    )


def _share(value: float) -> str:
    return {inf: "no oscillation", -inf: "grows"}.get(value) or f"{100.0 * value:.3g} %"


def first_part(scene: Scene, advice: Advice) -> tuple[str, list[str]]:
    """What the first part of a run shows: its errors in words, and warnings; the same judgement as of a whole run.

    A part that is too much work for a dry run is not run.
    """
    step = scene.master.step
    length = min(max(PREFIX_STEPS * step, PROBED * scene.duration), scene.duration)
    if length / step * advice.work > PREFIX_WORK:
        return f"the first {length:.3g} s: not run, as they take about {length / step * advice.seconds:.2g} s", []
    result = run(work.beginning(scene, length), in_process=True)
    verification = result.info["verification"]
    if result.outcome != "done" or not verification["done"]:
        return f"the first {length:.3g} s: {result.outcome}. {result.message or verification['why']}", []
    signals = verification["signals"]
    worst = max(signals, key=lambda name: signals[name]["rms"], default="")
    error = f"up to {100.0 * signals[worst]['rms']:.2g} % of a signal's deviation, of {worst}" if worst else "of no signal"
    return f"the first {length:.3g} s: numerical errors {error}", list(result.info["warnings"])


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
