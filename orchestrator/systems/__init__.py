"""The systems: the one list of them, and scenes, cases and reports for which all of them count.

Adding a system: a folder here with an object `SYSTEM`, and its name in `NAMES`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...components.catalogue import CATALOGUE, component_class
from ...components.core.errors import BadInput, nearest
from ..renamed import OUTPUT
from ..scene import scene as scenes
from ..scene.build import scene_data, snake_case
from ..scene.file_kinds import refuse_other
from ..scene.files import SCENES
from ..units.description import default_experiment

if TYPE_CHECKING:
    from gymnasium.vector import SyncVectorEnv

    from ..harness.compare import Comparison
    from ..harness.environment import Condition, Names, Reward, SceneEnvironment
    from ..harness.summary import SummaryTable
    from ..harness.system import System, Systems
    from ..harness.validation.case import Case, CaseResult
    from ..judgement.verification import Wish
    from ..run.results import Result
    from ..scene.scene import Scene
    from ..session.session import Session

FMU_ALONE = "fmu"  # the unit of a scene that is one FMU
NAMES = ("railway", "bearings", "rotor", "rov", "two_axis_joint", "wind_pump", "friction_drive", "pipe_robot", "wrist")


def _system(name: str) -> System:
    """The object of a system's folder; raises `BadInput` for a name that no folder has."""
    folder = Path(__file__).parent / name
    if not (folder / "__init__.py").is_file():
        folders = [path.parent.name for path in folder.parent.glob("*/__init__.py")]
        raise BadInput(
            f"NAMES in {__file__}", repr(name), f"a folder with __init__.py in {folder.parent}", nearest(name, folders)
        )
    system: System | None = getattr(import_module(f".{name}", __name__), "SYSTEM", None)
    if system is None or system.name != name:
        raise BadInput(f"{folder / '__init__.py'}", f"SYSTEM = {system!r}", f"SYSTEM = System({name!r}, ..., __name__)")
    return system


SYSTEMS: Systems = {name: _system(name) for name in NAMES}


class _Views:
    """`results.Views` that know all systems, and what a scene with limits needs."""

    def with_limits(self, scene: Scene) -> Scene:
        from ..harness.validation.limits_of_run import with_limits

        return with_limits(scene)

    def summary(self, result: Result) -> SummaryTable:
        return summary(result)

    def report(self, result: Result, directory: str | Path) -> Path:
        return write_report(result, directory)

    def plot(self, result: Result, signals: str | Iterable[str] | None, fig: Any) -> Any:
        from ..harness.charts.signals import signal_figure

        return signal_figure(result, signals, fig=fig)


KNOWN_SYSTEMS = scenes.KnownSystems({name: system.keys for name, system in SYSTEMS.items()}, _Views())


def load_scene(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> Scene:
    """A shipped scene by its name, or a scene file by its path: .toml, .ssd, .ssp or .xml. Faults are one `BadInput`.

    A component of the catalogue, "module:Class" or an FMU is a scene of it alone, over the run and with the step that it declares.
    changes: by name, as of `Scene.with_changes`; settings outside of units, such as {"master.step": 1e-3}, are judged with what the
    file says, and not after it.
    """
    changes = changes or {}
    name = str(name_or_path)
    if name.endswith(".fmu"):
        path = Path(name)
        times, remarks = default_experiment(path, changes)
        data = {"title": path.name, "units": {FMU_ALONE: {"fmu": path.name}}, **times}
        return scenes.read_changed(data, changes, path.stem, path.parent, remarks, KNOWN_SYSTEMS)
    if name in CATALOGUE or (":" in name and not name.endswith(SCENES)):
        cls = component_class(name, "scene")
        data = scene_data({snake_case(cls.__name__): name}, (), cls.default_stop, cls.default_step, {}, {"title": cls.title})
        return scenes.read_changed(data, changes, cls.__name__, systems=KNOWN_SYSTEMS)
    return scenes.load_scene(name_or_path, KNOWN_SYSTEMS, changes)


def read_scene(data: Mapping[str, Any], name: str = "scene", folder: Path | None = None, remarks: Sequence[str] = ()) -> Scene:
    """A scene from plain data, checked down to every connection. Paths of FMUs and of other scenes are relative to `folder`."""
    return scenes.read_scene(data, name, folder, remarks, KNOWN_SYSTEMS)


def build_scene(
    units: Mapping[str, Any],
    connections: Iterable[Any] | Mapping[str, str] = (),
    *,
    stop_time: float,
    step: float,
    name: str = "scene",
    folder: Path | None = None,
    master: Mapping[str, Any] | None = None,
    title: str = "",
    start_time: float = 0.0,
    record: Mapping[str, Any] | None = None,
    interface: Mapping[str, Any] | None = None,
    contacts: Iterable[Mapping[str, Any]] = (),
    faults: Iterable[Mapping[str, Any]] = (),
    limits: Mapping[str, Any] | str | None = None,
    sweep: Mapping[str, Any] | None = None,
    analysis: Mapping[str, Any] | None = None,
    study: Mapping[str, Any] | None = None,
    explore: Mapping[str, Any] | None = None,
) -> Scene:
    """A scene written in Python, checked down to every connection. Faults are one `BadInput`.

    units: by name, of `unit(...)`, or a class, a name of a component or a path.
    connections: "unit.output -> unit.input", or {"unit.output": "unit.input"}.
    stop_time, step: s; step: the macro step.  master: what else its table says, such as {"algorithm": "jacobi"}.
    title, start_time (s), record, interface, contacts, faults, limits, sweep, analysis, study, explore: as in a scene's file.
    """
    tables: dict[str, Any] = {"title": title, "start_time": start_time, "record": record, "interface": interface}
    tables |= {"contacts": list(contacts), "faults": list(faults), "limits": limits, "sweep": sweep, "analysis": analysis}
    tables = {key: value for key, value in {**tables, "study": study, "explore": explore}.items() if value}
    return read_scene(scene_data(units, connections, stop_time, step, master or {}, tables), name, folder)


def read_result(directory: str | Path) -> Result:
    """The result that a run has written into a directory; of one that was killed, its rows up to the last chunk."""
    from ..run.results import Result

    return Result.read(directory, KNOWN_SYSTEMS)


def scene_of(scene: Scene | str | Path) -> Scene:
    """A scene, or what `load_scene` reads by its name or path."""
    return scene if isinstance(scene, scenes.Scene) else load_scene(scene)


def run(
    scene: Scene | str | Path,
    *,
    verify: Wish = "auto",
    in_process: bool = False,
    native: bool = False,
    progress: bool = False,
    checkpoint_every: float | None = None,
    checkpoint_to: str | Path | None = None,
    resume: str | Path | None = None,
    output: str | Path | None = None,
    real_time: bool = False,
    fmu_log: str = "warning",
) -> Result:
    """Simulate a scene, given as such, by its name or by its path, to its stop_time, and find the error of each number.

    verify: as of `judgement.verification.run_verified`: "auto", "whole", "full", "steps" or "no".
    output: a directory for the result, written as it comes.  resume: a file of `checkpoint_to`, which is written every
    `checkpoint_every` s of simulated time.
    real_time: no macro step ends before its time on the clock.  fmu_log: the level from which on messages of foreign FMUs are kept.
    Raises `BadInput` for what cannot start.
    """
    from ..judgement.verification import run_verified

    return run_verified(
        scene_of(scene),
        verify=verify,
        in_process=in_process,
        native=native,
        progress=progress,
        checkpoint_every=checkpoint_every,
        checkpoint_to=checkpoint_to,
        resume=resume,
        output=output,
        real_time=real_time,
        fmu_log=fmu_log,
    )


def open(scene: Scene | str | Path, *, in_process: bool = True, native: bool = False) -> Session:
    """A scene, by itself, its name or its path, to be held: set, stepped, read, saved and taken back. Close it, or use `with`.

    in_process: components run in this process, else as FMUs; native: as native FMUs; bit-identical.
    """
    from ..session.session import Session

    return Session(scene_of(scene), in_process=in_process, native=native)


def gym(
    scene: Scene | str | Path,
    *,
    actions: Names,
    observations: Names,
    reward: Reward,
    terminated: Condition | None = None,
    start: Mapping[str, Any] | None = None,
    steps: int = 1,
    copies: int | None = None,
) -> SceneEnvironment | SyncVectorEnv:
    """A scene as an environment of Gymnasium (`pip install cosimo[gym]`): `reset`, `step`, spaces with limits.

    actions: inputs that nothing drives, {"unit.input": (low, high)}, or a list where they declare limits.  observations: outputs,
    likewise; without limits they may have any value. Behind a name may stand the unit of measure of its numbers, "unit.output [deg]".
    reward: of the arrays (observation, action).  terminated: of an observation, whether the episode ends.  start: parameters that
    each episode begins with, {"unit.parameter": value} or a range (low, high) to draw from.  steps: macro steps of a step.
    copies: so many environments as one vector environment, stepped one after the other. Raises `BadInput`.
    """
    try:
        from gymnasium.vector import SyncVectorEnv
    except ImportError:
        raise BadInput("gym", "no Gymnasium", "an installed gymnasium", "pip install cosimo[gym]") from None
    from ..harness.environment import SceneEnvironment

    read = scene_of(scene)

    def make() -> SceneEnvironment:
        return SceneEnvironment(read, actions, observations, reward, terminated=terminated, start=start, steps=steps)

    if copies is not None and (not isinstance(copies, int) or copies < 1):
        raise BadInput("gym: copies", repr(copies), "a whole number, 1 at least")
    return make() if copies is None else SyncVectorEnv([make] * copies)


def compare(*runs: Result | Scene | str | Path, verify: Wish = "auto", progress: bool = False) -> Comparison:
    """Runs beside the first: changed settings, figures with their errors, signals, and the time that the runs took.

    `runs`: results, directories of results, or scenes, their names and their files, which are run in this process; two or more.
    `comparison.report("out")` writes a page. Raises `BadInput` for what cannot be read, or has nothing in common.
    """
    from ..harness.compare import compared
    from ..run.results import Result

    results, names = [], []
    for one in runs:
        if isinstance(one, str | Path) and Path(one).is_dir():
            one = read_result(one)
        if not isinstance(one, Result):
            one = run(one, in_process=True, verify=verify, progress=progress).unless_stopped()
        names.append(one.directory.name if one.directory is not None else one.scene.name)
        results.append(one)
    return compared(results, names)


@cache
def cases() -> dict[str, Case]:
    """All validation cases by name, system by system."""
    from ..harness.validation.shipped import shipped_cases

    return {case.name: case for s in SYSTEMS.values() for case in shipped_cases(s.package, s.name, load_scene)}


def _case(name: str) -> Case:
    """A shipped case by its name, or the one of a user's file."""
    if name.endswith(".toml"):
        from ..harness.validation.own import read_case

        return read_case(Path(name), load_scene, summary)
    if name not in cases():
        refuse_other(name, "case")
        raise BadInput("case", repr(name), "a validation case or the .toml file of one", nearest(name, cases()))
    return cases()[name]


def papers() -> list[str]:
    """Names of the cases that go through what a paper announces."""
    return [name for name in cases() if name.startswith("paper-")]


@OUTPUT
def validate(
    names: Iterable[str], output: str | Path, in_process: bool = False, progress: bool = False, verify: Wish = "auto"
) -> list[CaseResult]:
    """Run cases by name, write `report.html`, `validation.json` and `validation.csv` to `output`.

    No name: all cases; "papers": those that go through what the papers announce; a path of a .toml file: a case of one's own.
    verify: "auto" finds the errors of all numbers where the counted work of the runs allows to repeat them, "whole" always, "no" never.

    Raises `BadInput` for an unknown case before anything runs.
    """
    from ..harness.validation import run_cases

    names = [n for name in list(names) or cases() for n in (papers() if name == "papers" else [name])]
    return run_cases(
        [_case(name) for name in names], Path(output), SYSTEMS, in_process=in_process, progress=progress, verify=verify
    )


def summary(result: Result) -> SummaryTable:
    """Figures of a run in numbers, as its system has them: EN 50317 statistics, errors, energies ...; none of an unknown system.

    Each has its numerical error where the run was verified.
    Raises `BadInput` where [analysis] asks for what the run does not have.
    """
    from ..harness.summary import SummaryTable, pacing_rows, with_errors

    system = result.scene.analysis.system
    of_system = SYSTEMS[system].summary(result) if system in SYSTEMS and result.time.size > 1 else ()
    numbers = tuple(of_system)
    if result.scene.limits is not None:
        from ..harness.validation.limits_of_run import limit_numbers

        numbers += tuple(limit_numbers(result, of_system))
    return SummaryTable((*with_errors(numbers, result.info.verification), *pacing_rows(result.info.real_time)))


@OUTPUT
def write_report(result: Result, output: str | Path) -> Path:
    """Write `report.html` of a run to the directory `output`: figures of its system, recorded signals, settings; returns its path."""
    from ..harness.report import for_run

    return for_run(result, output, SYSTEMS)


def explore_page(scene: Scene, path: str | Path, **options: Any) -> Path:
    """Write a page that computes the scene in the browser, with the figures of its system; returns its path.

    Options are those of `harness.explore.explore_page`: parameters, effects, jobs, library, say. Raises `BadInput`.
    """
    from ..harness.explore import explore_page as write

    system = SYSTEMS.get(scene.analysis.system)
    if system is None:
        return write(scene, Path(path), **options)
    return write(scene, Path(path), system.explore, moves=system.motions, **options)
