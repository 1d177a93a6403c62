"""A scene in, a result out."""

from __future__ import annotations

import logging
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from math import isfinite
from pathlib import Path
from signal import SIGINT, Signals
from time import perf_counter, process_time
from typing import Any

from ...components.core.errors import BadInput, StepFailed
from .. import working_directory
from ..engine.algorithms.master import Runaway, Unstable
from ..engine.coupling import Coupling
from ..engine.stepping.adaptive import AdaptiveStepping
from ..engine.stepping.loop import Observer
from ..interrupts import Interrupted
from ..opened.compile_ahead import compile_ahead, wanted_by
from ..opened.open_scene import Course, OpenScene
from ..output import UNFINISHED, locked, not_written
from ..scene.scene import Scene
from ..scene.shorter_steps import Alterations, MadeRun, alterations_inside, note_runs
from ..settings.study import wanted
from ..settings.units import without_home
from ..units.discarded import warnings_of as of_discarded
from ..units.fmu_messages import DEFAULT, described, level_of, warnings_of
from ..units.interface import SimulationEnded
from . import work
from .checkpoint import Checkpoint, Checkpoints, Part, check_wish, read_checkpoint, restore
from .pacing import Pacing
from .progress import Interrupt, Progress, Stop
from .recorders import reading
from .recording import OutputFailed, ResultFiles
from .results import Result
from .rows import Rows
from .run_info import CompileTime, describe_run
from .run_record import Counters, Resumed, RunRecord, RunTiming, SteppingRecord
from .watch import Watch, measures_of
from .windows import Windows, WindowsWish, obstacle

Remedy = Callable[[Scene], str]
END = 1e-3  # of the macro step: a row so near to where a unit has ended the simulation is one of its end


def run(
    scene: Scene,
    *,
    in_process: bool = False,
    native: bool = False,
    progress: bool = False,
    checkpoint_every: float | None = None,
    checkpoint_to: str | Path | None = None,
    resume: str | Path | None = None,
    output: str | Path | None = None,
    real_time: bool = False,
    windows: WindowsWish | None = None,
    remedy: Remedy | None = None,
    fmu_log: str = DEFAULT,
    alterations: Alterations | None = None,
) -> Result:
    """Simulate a scene to its stop_time, once: `judgement.verification.run_verified` repeats it to find the errors of its numbers.

    Components run as FMUs, or in this process with `in_process`: bit-identical results, several times faster. With `native` they
    run as native FMUs, built for the scene where the cache has none, bit-identical as well. A step that fails gives a partial
    result with outcome "failed", Ctrl-C, SIGTERM and SIGHUP one with outcome "stopped" and the signal's name in `info.signal`; raises
    `BadInput` for what cannot start.

    `checkpoint_every`: s of simulated time; the file `checkpoint_to` is written at the first macro step not before each
    multiple of it, and when the run is stopped. `resume`: such a file, from which the run goes on. What it recorded before is in
    the result, and every number is the same as without the interruption; `timing` and messages of foreign FMUs start anew.
    `output`: a directory, into which the result is written as it comes, as with `Result.save`, so that the memory does not grow
    with the run; a result that was there is replaced when this one is whole. Where an FMU ends this process, what there is is
    saved; the exit code is 3 then. Raises `BadInput` where another run writes there.
    `real_time`: no macro step ends before its time on the clock; `info.real_time` says how punctual they were.
    `windows`: what of the run is to be repeated at its end, see `run.windows`.
    `remedy`: what would help the scene if it becomes unstable, for the message.
    `fmu_log`: the level from which on messages of foreign FMUs are kept, in `info.fmu_log` and fmu.log: none, fatal, error,
    discard, warning or info; they are counted whatever it is.
    `alterations`: of the scene; None: those of the validation case that the run is made for.
    """
    scene = (alterations if alterations is not None else alterations_inside()).altered(scene)
    with ExitStack() as stack:
        files = ResultFiles(stack.enter_context(locked(output))) if output is not None else None
        current = Run(
            scene,
            stack,
            in_process=in_process,
            native=native,
            progress=progress,
            files=files,
            real_time=real_time,
            windows=windows,
            remedy=remedy,
            at_once=in_process and not native,
            fmu_log=level_of(fmu_log),
        )
        check_wish(checkpoint_every, checkpoint_to, scene, current.coupling.interfaces)
        past = read_checkpoint(Path(resume), scene) if resume is not None else None
        try:
            current.prepare()
            current.observe(checkpoint_every, checkpoint_to, past)
        except Exception:
            current.interrupted()  # processes that build or hold an FMU get the signal, too, and a library may rename it
            raise
        current.execute(past)
        return current.conclude(past)


class Run:
    """One run of a scene, from `prepare` over `observe` and `execute` to `conclude`; `stack` closes what it opens."""

    def __init__(
        self,
        scene: Scene,
        stack: ExitStack,
        *,
        in_process: bool,
        native: bool,
        progress: bool,
        files: ResultFiles | None = None,
        real_time: bool = False,
        windows: WindowsWish | None = None,
        remedy: Remedy | None = None,
        fmu_log: str = DEFAULT,
        again: OpenScene | None = None,
        stop: Stop | None = None,
        at_once: bool = False,
    ):
        """again: the scene, opened before.  stop: what may end the run from another thread. A run with it leaves alone what all
        threads share: signals, the list of warnings, the working directory.  at_once: a signal raises `Interrupted` before the
        first step; else it waits for the units, which may be in code that would take it for a failure of its own."""
        self._wish, self._remedy, self._open_scene, self._stop, self._fmu_log = windows, remedy, again, stop, fmu_log
        self.windows: Windows | None = None
        self.scene, self.stack, self.in_process, self.native, self.progress = scene, stack, in_process, native, progress
        self.files = files
        self._interrupt = stop or stack.enter_context(Interrupt(at_once=at_once))
        self.pacing = Pacing() if real_time else None
        self.started = perf_counter()
        self._folder, self._moved = working_directory.current() if stop is None else "", False
        stack.callback(self._return)
        self.compiling = CompileTime(announce=progress)
        if stop is None:
            stack.enter_context(self.compiling)
        self.coupling: Coupling = scene.coupling
        self.outcome, self.message, self.log = "failed", "", ""
        self.checkpoints: Checkpoints | None = None
        self._earlier: Mapping[str, Any] = {}  # counters and warnings of before the checkpoint that the run goes on from
        self._begun: Counters | None = None

    def prepare(self) -> None:
        """Open the units and build master, faults and stepping on them."""
        scene, stack = self.scene, self.stack
        if (open_scene := self._open_scene) is None:
            native = {}
            if self.native:
                from ..opened.native import native_fmus  # which loads a compiler

                native = native_fmus(scene)
            open_scene = OpenScene(scene, stack, self.in_process, self._rescue, native)
        self.clock, self.units, self.master = open_scene.clock, open_scene.units, open_scene.master
        if self._stop is None:
            compile_ahead(wanted_by(scene, self.units, self.master), self.progress)
        # components of the catalogue are under test; whether a user's own keep their state where it belongs is seen here
        self._own = [u for n, kind in scene.kinds.items() if (u := self.units[n]).component is not None and not kind.of_catalogue]
        # warnings of components, in FMUs too: they share this interpreter
        self._caught_warnings = []
        if self._stop is None:
            self._caught_warnings = stack.enter_context(warnings.catch_warnings(record=True))
            warnings.simplefilter("always", UserWarning)
        self.course = Course(open_scene)
        self.account, self.stepping = self.course.account, self.course.stepping

    def observe(self, checkpoint_every: float | None, checkpoint_to: str | Path | None, past: Checkpoint | None) -> None:
        """Put on the steps all that watches them: recorders, the monitor of instability, checkpoints, progress, signals."""
        scene, coupling, stack = self.scene, self.coupling, self.stack
        self._ends = tuple(self.master.positions)
        arrays = self.files.snapshots if self.files else lambda name, elements: Rows(elements)
        self.watch = Watch(self.course, table=self._table(past), arrays=arrays, beside=past.folder if past else None)
        if isinstance(self._interrupt, Interrupt):
            self._interrupt.halt = self.stepping.halt
        self.observers: list[Observer] = [*self.watch.recorders]
        if self.files is not None:
            self.files.watch(self.watch.recorders)
            self.observers.append(self.files)
        if self._wish is not None and not obstacle(scene):
            angles = {
                f"{unit}.{name}"
                for unit, interface in coupling.interfaces.items()
                for name, signal in interface.outputs.items()
                if signal.unit == "rad"
            }
            self.windows = Windows(self.course, self._ends, int(scene.duration / scene.master.step), angles)
            self.observers.append(self.windows)
        if self.watch.monitor is not None:
            self.observers.append(self.watch.monitor)
        self.observers.append(self._interrupt)  # behind all that has to have seen an instant that a checkpoint is of
        if checkpoint_every is not None and checkpoint_to is not None:
            self.checkpoints = Checkpoints(Path(checkpoint_to), checkpoint_every, self.course, self.parts())
            self.observers.append(self.checkpoints)
        if self.progress:
            since = past.t if past else scene.start_time
            self.observers.append(stack.enter_context(Progress(scene.title or scene.name, scene.stop_time, since)))
        if self.pacing is not None:
            self.observers.append(stack.enter_context(self.pacing))

    def _table(self, past: Checkpoint | None) -> Rows | None:
        """Where the rows of the recorded signals go; None: in memory."""
        if self.files is None:
            return None
        names, texts = ([f"{u}.{n}" for u, n in ends] for ends in (self.coupling.signals, self.coupling.recorded_texts))
        info = RunRecord(scene=self.scene.info(), outcome="running", message="the run has not ended")
        try:
            return self.files.open(names, texts, measures_of(self.coupling), info, resumed=past is not None)
        except OSError as error:
            raise not_written(self.files.directory, error) from None

    def parts(self) -> dict[str, Part]:
        """All that has a state beside the scene, for checkpoints."""
        parts: dict[str, Part | None] = {"signals": self.watch.signals, "run": self}
        parts |= {"monitor": self.watch.monitor, "windows": self.windows}
        parts |= {f"snapshots of {name}": recorder for name, recorder in self.watch.arrays.items()}
        return {name: part for name, part in parts.items() if part is not None}

    def state(self) -> dict[str, Any]:
        """What was counted and said so far, for a checkpoint."""
        counters, no_numbers = self._counters(), [[*end, t] for end, t in self.master.no_numbers.items()]
        return {"master": counters.master, "units": counters.units, "warnings": self._unit_warnings(), "no_numbers": no_numbers}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`, behind the initialization."""
        self._earlier, self._begun = state, self._counters()
        for unit, name, t in state["no_numbers"]:
            self.master.look_away((unit, name), t)

    def _counters(self) -> Counters:
        """Of the whole run."""
        counters = Counters(master=self.master.counters(), units={n: unit.work() for n, unit in self.units.items()})
        return work.joined(counters, self._earlier, self._begun) if self._begun is not None else counters

    def _unit_warnings(self) -> list[str]:
        """Warnings of units, in this process and before the checkpoint."""
        return list(dict.fromkeys([*self._earlier.get("warnings", ()), *(str(w.message) for w in self._caught_warnings)]))

    def execute(self, past: Checkpoint | None) -> None:
        """Initialize, go on from a checkpoint where there is one, and step to the end; keeps why it did not get there."""
        self._mark()
        self._interrupt.at_once = False
        try:
            self._interrupt(0, 0.0)  # one that came while units were started
            self._start(past)
            self._mark()
            self.stepping.run(self.observers)
            if self.watch.monitor is not None:
                self.watch.monitor.close(self._now)
            self._check_figures()
            self.outcome = "done"
        except Runaway as error:
            self.outcome = "unstable" if isinstance(error, Unstable) else "failed"
            helps = self.master.feedthrough.why_it_grows or (self._remedy and self._remedy(self.scene)) or "Reduce the macro step"
            self.message = f"{error}. {helps}"
        except SimulationEnded as error:
            self._end_early(error)
        except (StepFailed, OutputFailed) as error:
            self.message = str(error)
        except MemoryError:
            self.message = f"out of memory at t = {self._now:.9g} s"
        except BadInput:
            self.interrupted()
            raise
        except Exception as error:
            if not (unit := self._raiser(error)):
                raise
            self.message = f"{unit} failed at t = {self._now:.9g} s: its component has raised {type(error).__name__}: {error}"
            self.log = without_home(traceback.format_exc())
            logging.getLogger("cosimo").error("%s", self.message, exc_info=True)
        except SystemExit as error:
            self.message = f"a unit has called sys.exit({error.code!r})"
        except KeyboardInterrupt:
            self._stopped()
            if self.checkpoints is not None and self._interrupt.taken and self.stepping.tick:
                self.checkpoints.write()
                self.message += f". resume = {str(self.checkpoints.path)!r} goes on from there"
        if self.outcome in ("done", "failed") and self._interrupt.wanted:  # in the last step, or a unit took it for its own
            self._stopped()
        self._until = perf_counter(), process_time()
        self._return()

    def interrupted(self) -> None:
        """Raises `Interrupted` where a signal has come that waits."""
        if isinstance(self._interrupt, Interrupt) and self._interrupt.wanted:
            raise Interrupted(self._interrupt.wanted) from None

    def _stopped(self) -> None:
        wanted = self._interrupt.wanted
        self.outcome, self._signal = "stopped", wanted if isinstance(wanted, Signals) else SIGINT
        self.message = f"stopped by {self._signal.name} at t = {self._now:.9g} s"

    def _check_figures(self) -> None:
        """Raises `StepFailed` where a quantity of interest is of an output that was no number."""
        wished = {wanted(text).signal for text in self.scene.study.quantities}
        for (unit, name), t in self.master.no_numbers.items():
            if f"{unit}.{name}" in wished:
                raise StepFailed(unit, t, f"output {name}, of which study.quantities asks a figure, was no number")

    def _raiser(self, error: BaseException) -> str:
        """The unit in whose own code an exception was raised: a component that is none of the catalogue; "" for ours."""
        own = {id(unit.component): unit.name for unit in self._own}
        frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
        return next((own[id(it)] for frame in reversed(frames) if id(it := frame.f_locals.get("self")) in own), "")

    def _rescue(self, message: str) -> None:
        """This process is ending inside of a unit's call: save what there is."""
        self.message, self._until = message, (perf_counter(), process_time())
        if self.files is not None and hasattr(self, "observers"):
            self.stepping.rescue(self.observers)
            print(f"cosimo: partial result in {self.conclude(None).directory}", file=sys.stderr)

    def _end_early(self, end: SimulationEnded) -> None:
        """A unit has ended the simulation: that is no failure. The last row is of its end, or of the last step of all units."""
        self.outcome, self.message = "done", f"{end} of {self.scene.stop_time:.9g} s"
        rewinds = self.stepping.rewinds
        if len(self.units) == 1 or rewinds:
            t = self._now if rewinds else end.time
            self.watch.signals.close(t, reading(self.units, self._ends))
            for recorder in self.watch.arrays.values():
                recorder.close(t)
        last, near = self.watch.signals.last, END * self.scene.master.step
        if isfinite(last) and last < end.time - near:
            self.message += f"; the last row, of all units at the same time, is that of t = {last:.9g} s"
        if last > end.time + near:  # it steps with every n-th macro step
            self.message += "; the rows behind it hold extrapolated outputs of this unit"

    def conclude(self, past: Checkpoint | None) -> Result:
        """The result, with all that run.json says of the run."""
        coupling = self.coupling
        try:
            for recorder in self.watch.recorders if self.files is None else ():
                recorder.flush()
            if self.files is not None:
                self.files.flush()
        except OutputFailed as error:
            self.outcome, self.message = "failed", str(error)
        info = describe_run(self.scene, coupling, self.units, self.master, self.outcome, self.message)
        logs, counters = {name: unit.log_messages() for name, unit in self.units.items()}, self._counted()
        info = replace(
            info,
            warnings=(*self._warnings(), *of_discarded(counters.units), *warnings_of(logs)),
            counters=counters,
            timing=self._timing(),
            traceback=self.log,
            signal=self._signal.name if self.outcome == "stopped" else "",
            missed=self.watch.monitor.missed() if self.watch.monitor is not None else None,
            energy=self.account.report() if self.account else {},
            real_time=self.pacing.report() if self.pacing else None,
            checkpoints=self.checkpoints.report() if self.checkpoints else None,
            resumed=Resumed(at=past.t) if past else None,
            fmu_log=described(logs, self._fmu_log),
        )
        note_runs([MadeRun(self.scene, info.counters.work)])
        if self.outcome == "done" and self._wish is not None:
            self._interrupt.at_once = True
            try:
                if info.counters.work is not None and self._wish.needed(info.counters.work):
                    self._answer(self._wish)
            except (KeyboardInterrupt, Exception):
                if not self._interrupt.wanted:
                    raise
                self._stopped()
                self.message += ", while windows of the run were repeated; the run itself is whole"
                info = replace(info, outcome=self.outcome, message=self.message, signal=self._signal.name)
            self._interrupt.at_once = False
        directory = None
        if self.files is not None:
            try:
                self.files.finish(info)
                directory = self.files.directory.resolve()
            except OutputFailed as error:
                self.outcome, self.message = "failed", f"{error}; what was written is in its folder {UNFINISHED!r}"
                info = replace(info, outcome=self.outcome, message=self.message)
        return self.watch.result(self.scene, info, directory)

    def _counted(self) -> Counters:
        """The counters with those of the steps, and with the work of a run whose units are those of a repetition."""
        stepping = SteppingRecord(**self.stepping.report()) if isinstance(self.stepping, AdaptiveStepping) else None
        counters = replace(self._counters(), stepping=stepping)
        if not work.as_repeated(self.scene, self.in_process):
            return counters
        compiled = stepping is None and (self.account or self.master).in_batches
        return replace(counters, work=work.counted(self.units, counters, compiled=compiled))

    @property
    def _now(self) -> float:
        """Simulated time, s."""
        return self.clock.time(self.stepping.tick)

    def _start(self, past: Checkpoint | None) -> None:
        self.course.start()
        repeats = self.scene.master.abilities.rollback or isinstance(self.stepping, AdaptiveStepping)
        if repeats or past is not None or self.checkpoints is not None:
            for unit in self._own:
                unit.check_step_repeatable(self.clock.seconds(self.stepping.stride))
        if past is not None:
            restore(past, self.course, self.parts())
        if self.checkpoints is not None:
            self.checkpoints.resumed(self._now)

    def _return(self) -> None:
        """To the working directory of the start: units of this process can change it, and results would go elsewhere."""
        if self._folder and working_directory.current() != self._folder:
            os.chdir(self._folder)
            self._moved = True

    def _mark(self) -> None:
        """What comes from here on is stepping, until this is called again."""
        self._since, self._cpu, self._compiled = perf_counter(), process_time(), self.compiling.spent

    def _timing(self) -> RunTiming:
        start, run, cpu = self._since - self.started, self._until[0] - self._since, self._until[1] - self._cpu
        (real, used), (whole, whole_used) = self._compiled, self.compiling.spent
        return RunTiming(
            simulated=self.clock.seconds(self.stepping.tick),
            start=max(start - real, 0.0),
            compile=whole,
            run=max(run - (whole - real), 0.0),
            cpu=max(cpu - (whole_used - used), 0.0),
        )

    def _answer(self, wish: WindowsWish) -> None:
        """Repeat windows of the run; units and account move: call it last."""
        if self.windows is not None:
            with working_directory.of_its_own(
                any(kind.foreign for kind in self.scene.kinds.values())
            ):  # the run's own files stay
                self.windows.answer(wish, self.watch.signals.table.chunks())
        else:
            wish.why = f"windows of it cannot be repeated with {obstacle(self.scene)}"

    def _warnings(self) -> list[str]:
        """What a user should know."""
        texts = self.watch.warnings(self.scene, self._unit_warnings())
        texts += ["a unit has changed the working directory of this process, which was set back"] if self._moved else []
        return texts + ([self.message] if self.outcome == "done" and self.message else [])
