"""A scene in, a result out."""

from __future__ import annotations

import platform
import warnings
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from ..components.core.errors import StepFailed
from .advice.limits import remedy
from .checkpoint import Checkpoints, Part, check_wish, read_checkpoint, restore
from .engine.algorithms import Master, master_of
from .engine.algorithms.energy import EnergyAccount, metered
from .engine.algorithms.master import Runaway
from .engine.coupling import Coupling, resolve_coupling
from .engine.stepping.adaptive import AdaptiveStepping, clock_for, stepping_of
from .engine.stepping.faults import Faults, LosableUnit, edges
from .engine.stepping.instability import InstabilityMonitor
from .engine.stepping.loop import Observer
from .engine.stepping.observers import ExtrapolationError, Interrupt, Progress, Recorder, reading
from .open_all import open_units
from .results import Result, Snapshot
from .scene.scene import Scene
from .units import Unit
from .units.component import ComponentUnit

TOO_FAR = 1.0  # of an input's spread: the mean would have been the better guess
PACKAGES = ("cosimo", "numpy", "scipy", "numba", "fmpy", "pythonfmu")


def run(scene: Scene, *, in_process: bool = False, progress: bool = False, checkpoint_every: float | None = None,
        checkpoint_to: str | Path | None = None, resume: str | Path | None = None) -> Result:
    """Simulate a scene from 0 to its stop_time.

    Components run as FMUs, or in this process with `in_process`: the same results to the last bit, several times faster.
    A step that fails and Ctrl-C give a partial result with outcome "failed"; raises `BadInput` for what cannot start.

    `checkpoint_every`: s of simulated time; the file `checkpoint_to` is written at the first macro step not before each
    multiple of it, and by Ctrl-C. `resume`: such a file, from which the run goes on. What it recorded before is in the result,
    and every number is the same as without the interruption; counters of the units and `timing` begin anew.
    """
    begin = perf_counter()
    coupling, record, settings = resolve_coupling(scene), scene.record, scene.master
    check_wish(checkpoint_every, checkpoint_to, scene, coupling.interfaces)
    past = read_checkpoint(Path(resume), scene) if resume is not None else None
    intervals = [record.interval, record.snapshot_interval]
    clock = clock_for(scene, coupling, *filter(None, intervals), *edges(scene.faults))
    end = clock.ticks(scene.stop_time)
    every, snapshot_every = (clock.ticks(i) if i else 1 for i in intervals)  # every macro step ends at a tick of its own
    with ExitStack() as stack:
        units = open_units(scene, stack, in_process)
        # components of the catalogue are under test; whether a user's own keep their state where it belongs is seen here
        own = [u for n, u in units.items() if isinstance(u, ComponentUnit) and ":" in scene.units[n].component]
        losable = {fault.unit: LosableUnit(units[fault.unit]) for fault in scene.faults if fault.kind == "lost"}
        units.update(losable)  # type: ignore[arg-type]  # what they do not change is the unit's own
        meters = metered(units, coupling)
        units |= meters
        each = record.interval is None or (record.interval == settings.step and settings.control is None)
        watched = coupling.signals if each else ()
        master = master_of(scene, units, coupling, (*watched, *coupling.events))
        account = EnergyAccount(master, coupling, meters, correction=settings.energy_correction) if meters else None
        # what the master reads in every step anyway is kept as a whole; picking columns can wait to the end of the run
        ends = tuple(master.positions) if watched else coupling.signals
        signals = Recorder(master.sample if watched else reading(units, ends), len(ends), every, end, of_master=bool(watched))
        arrays = {f"{unit}.{array}": Recorder(units[unit].reader(names), len(names), snapshot_every, end)
                  for (unit, array), names in coupling.snapshots.items()}
        errors = ExtrapolationError(master.nodes)
        caught_warnings = stack.enter_context(warnings.catch_warnings(record=True))
        warnings.simplefilter("always", UserWarning)  # what components have to say, in FMUs too: they share this interpreter
        faults = Faults(scene.faults, coupling, master, losable, clock)
        loop = stepping_of(scene, coupling, master, account, clock, faults.stops())
        parts: dict[str, Part] = {"signals": signals, "misses": errors, "faults": faults, "stepping": loop}
        parts |= {f"snapshots of {name}": recorder for name, recorder in arrays.items()}
        interrupt, checkpoints = stack.enter_context(Interrupt(loop.halt)), None
        observers: list[Observer] = [signals, *arrays.values(), errors, interrupt]
        if any(len(group) > 1 for group in coupling.groups):
            steps = int(scene.stop_time / settings.step)
            observers.append(InstabilityMonitor(master, steps, partial(_remedy, scene, master), account))
        if checkpoint_every is not None and checkpoint_to is not None:
            checkpoints = Checkpoints(Path(checkpoint_to), checkpoint_every, scene, master, loop, parts)
            observers.append(checkpoints)
        if progress:
            observers.append(stack.enter_context(Progress(scene.title or scene.name, scene.stop_time, past.t if past else 0.0)))
        started, cpu, outcome, message = perf_counter(), process_time(), "failed", ""
        try:
            faults.before_start()
            (account or master).initialize(0.0)
            repeats = settings.algorithm == "iterative" or isinstance(loop, AdaptiveStepping)
            if repeats or past is not None or checkpoints is not None:
                for unit in own:
                    unit.check_step_repeatable(clock.seconds(loop.stride))
            if past is not None:
                restore(past, master, loop, parts)
            if checkpoints is not None:
                checkpoints.resumed(clock.seconds(loop.tick))
            started, cpu = perf_counter(), process_time()
            loop.run(observers)
            outcome = "done"
        except Runaway as error:
            message = f"{error}. {_remedy(scene, master)}"
        except StepFailed as error:
            message = str(error)
        except KeyboardInterrupt:
            message = f"interrupted at t = {clock.seconds(loop.tick):.9g} s"
            if checkpoints is not None and interrupt.taken:
                checkpoints.write()
                message += f". resume = {str(checkpoints.path)!r} goes on from there"
        timing = {"simulated": clock.seconds(loop.tick), "start": started - begin, "run": perf_counter() - started,
                  "cpu": process_time() - cpu}
        info = _info(scene, coupling, units, master) | {"outcome": outcome, "message": message, "timing": timing}
        relative_errors = errors.relative
        messages = [*scene.remarks, *dict.fromkeys(str(w.message) for w in caught_warnings), *master.warnings(), *loop.warnings()]
        messages += [*(account.warnings() if account else ()), *_warnings(relative_errors, master.delayed_feedthrough)]
        info |= {"input_misses": relative_errors, "warnings": messages}
        info |= {"energy": account.report()} if account else {}
        info |= {"checkpoints": checkpoints.report()} if checkpoints else {}
        info |= {"resumed": {"at": past.t}} if past else {}
        info["counters"] |= {"stepping": loop.report()} if isinstance(loop, AdaptiveStepping) else {}
    columns = dict(zip(ends, signals.values.T, strict=True))
    return Result(
        scene, signals.time, {f"{u}.{n}": columns[u, n].copy() for u, n in coupling.signals},
        {name: Snapshot(recorder.time, recorder.values) for name, recorder in arrays.items()},
        {f"{u}.{n}": coupling.interfaces[u].outputs[n].unit for u, n in coupling.signals},
        info, outcome, message,
    )


def _remedy(scene: Scene, master: Master) -> str:
    """What would help a run that became unstable."""
    return master.delayed_feedthrough or remedy(scene)


def _warnings(errors: Mapping[str, float], late: str) -> list[str]:
    """What a user should know of a run; `late`: what the master knows to be behind it."""
    worst = max(errors, key=errors.__getitem__, default="")
    if not worst or errors[worst] < TOO_FAR:
        return []
    return [f"the values extrapolated for input {worst} were wrong by {100.0 * errors[worst]:.0f} % of its spread (rms): "
            + (late or "the macro step is too long for this coupling. Reduce master.step, or raise master.extrapolation")]


_version = cache(version)  # it parses a file each time, which for a short run takes longer than the run


def _info(scene: Scene, coupling: Coupling, units: Mapping[str, Unit], master: Master) -> dict[str, Any]:
    """What run.json holds beside outcome and timing."""
    interfaces = coupling.interfaces
    driven = {link.target[0] for link in coupling.links}
    undeclared = [n for n, i in interfaces.items() if any(s.feedthrough is None for s in i.outputs.values())]
    return {
        "scene": {"name": scene.name, **scene.model_dump(mode="json")},
        "units": {n: {"kind": unit.kind, "title": interfaces[n].title, "parameters": unit.parameters()}
                  for n, unit in units.items()},
        "effects": {n: {"on": {e: why for e, why in i.effects.items() if why},
                        "off": {e: "not named in the scene" for e, why in i.effects.items() if not why}}
                    for n, i in interfaces.items()},
        "settings": {
            **scene.master.model_dump(mode="json"),
            "undriven_inputs": list(coupling.undriven),
            "held_at_mean": sorted(n for n in driven if interfaces[n].input_degree < scene.master.extrapolation),
            "undeclared_dependencies": undeclared,
        },
        "counters": {
            "master": master.counters(),
            "units": {n: unit.work() for n, unit in units.items()},
        },
        "initial_values": [asdict(group) for group in master.initialization],
        "versions": {"python": platform.python_version(), **{p: _version(p) for p in PACKAGES}},
    }
