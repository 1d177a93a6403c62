"""FMUs built and checked, and scenes packed with theirs for other tools."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from ...components.core.errors import BadInput, nearest
from .common import FAILED_CHECK, app, fail, is_scene, print_table, print_written, scene_of, status_spinner, warn
from .completion import components as component_names
from .options import AsJson, Changes, Native, Presets, SceneName, listed, parameters_of, preset_of, refuse, share

if TYPE_CHECKING:
    from ..scene.scene import Scene


@app.command()
def build(
    names: Annotated[
        list[str] | None,
        Argument(
            autocompletion=component_names,
            help="Components or module:Class; with --native also scenes. Default: the whole catalogue.",
        ),
    ] = None,
    output: Annotated[Path, Option("-o", "--output", help="Directory for the FMUs.")] = Path(),
    native: Annotated[
        bool,
        Option("--native", help="Build FMUs that need no Python. Effects and structural parameters are fixed at build time."),
    ] = False,
    target: Annotated[
        str,
        Option(
            help="With --native: platforms, separated by commas: linux64, win64, linux-arm64, macos-arm64, macos-x64 (macOS: built, "
            "never run), wasm32 (with --fmi 3). Default: this machine."
        ),
    ] = "",
    fmi: Annotated[str, Option(help="With --native: FMI version 2, 3 or both. Default: 2.")] = "",
    effects: Annotated[str, Option(help="With --native: effects to switch on, separated by commas.")] = "",
    values: Annotated[
        list[str] | None,
        Option(
            "--set",
            metavar="PARAMETER=VALUE",
            help="With --native: value of a parameter, or start value of an input. May be repeated.",
        ),
    ] = None,
    presets: Presets = None,
    scene: Annotated[str, Option(help="With --native: build units of this scene with their settings and start values.")] = "",
    derivatives: Annotated[
        bool, Option("--derivatives", help="Add the inputs der(v) and der(v,2) of each input v, for masters that extrapolate.")
    ] = False,
    evidence: Annotated[
        bool,
        Option(
            "--evidence",
            help="Measure the error of communication steps and pack it with reference results. Takes some seconds per FMU.",
        ),
    ] = False,
) -> None:
    """Build FMUs. Example: cosimo build Pantograph -o fmus-out

    A table over time, such as measured.csv, becomes an FMU whose outputs are its columns.
    """
    _refuse_one_file(names or [])
    names = [_table_or_name(name) for name in names or []]
    if native:
        _build_native(names or [], output, target, fmi, effects, values, presets, scene, derivatives, evidence)
        return
    from ...components.catalogue import CATALOGUE
    from ..systems.building import OTHERS, pythonfmu

    only_native: dict[str, object] = {"--target": target}
    only_native |= {"--fmi": fmi, "--effects": effects, "--set": values, "--preset": presets, "--scene": scene}
    refuse(only_native, f"no effect without --native: {OTHERS}", "Add --native, or remove it.")
    for name in names or CATALOGUE:
        print(pythonfmu(name, output, derivatives, evidence, status_spinner))


def _table_or_name(name: str) -> str:
    """The component of a table by its file; other names as they are."""
    from ..units.signal_files import SUFFIXES, read_signals

    return read_signals(name, "build").__name__ if Path(name).suffix.lower() in SUFFIXES else name


def _refuse_one_file(names: Iterable[str]) -> None:
    """Raise `BadInput` for two names whose FMUs would be one file, also where the file system does not tell capitals."""
    files: dict[str, str] = {}
    for name in names:
        other = files.setdefault((Path(name).stem if is_scene(name) else name.rpartition(":")[2]).casefold(), name)
        if other != name:
            raise BadInput(
                "build",
                f"{other!r} and {name!r}, whose FMUs would be one file",
                "names that differ in more than capitals",
                "Name one at a time, each with a directory of its own.",
            )


def _build_native(
    names: list[str],
    output: Path,
    target: str,
    fmi: str,
    effects: str,
    values: list[str] | None,
    presets: list[str] | None,
    scene: str,
    derivatives: bool,
    evidence: bool,
) -> None:
    """Build FMUs without Python, of components by their names or of a scene's units, and print their paths."""
    from ...components.catalogue import CATALOGUE
    from ..systems.building import natives

    targets = listed("--target", [target]) if target else []
    versions = listed("--fmi", [fmi]) if fmi else ["2"]
    if unknown := [v for v in versions if v not in ("2", "3")]:
        raise BadInput("--fmi", repr(unknown[0]), "2, 3 or 2,3")
    standards = [int(v) for v in versions]

    def write(what: str | Scene, on: Sequence[str] = (), preset: str = "", unit: str = "", given: Mapping[str, Any] = {}) -> None:
        for path in natives(what, output, targets, standards, on, given, preset, unit, derivatives, evidence, status_spinner):
            print(path)

    works: dict[str, Callable[[], None]] = {}
    if scene:
        if effects or values:
            raise BadInput("build", "--scene excludes --effects and --set: the scene sets both", "", "Remove them.")
        loaded = scene_of(scene, None, presets)
        _refuse_one_file(names or loaded.component_classes)
        works = {unit: partial(write, loaded, unit=unit) for unit in names or loaded.component_classes}
    else:
        scenes = [name for name in names if is_scene(name)]
        if scenes:
            in_vain = {"--effects": effects, "--derivatives": derivatives}
            refuse(in_vain, "no effect with a scene, which sets its effects and holds its inputs over a step")
        for name in scenes:
            write(scene_of(name, values, presets))
        on = listed("--effects", [effects]) if effects else []
        others = [name for name in names if name not in scenes]
        if others or not names:
            given, preset = parameters_of(values), preset_of(presets)
            works = {name: partial(write, name, on, preset, given=given) for name in others or CATALOGUE}
    refused = 0
    for work in works.values():
        try:
            work()
        except BadInput as error:
            if len(works) == 1 or error.where == "build --native":
                raise
            refused += 1
            print(f"refused: {error}")
    if refused:
        raise BadInput(
            "build --native",
            f"{refused} of {len(works)} components that have no native form",
            "components whose steps are kernels",
            "The lines above name what prevents it.",
        )


@app.command()
def check(
    fmu: Annotated[str, Argument(help="An FMU file, or a component or module:Class, for which cosimo builds the FMU.")],
    isolate: Annotated[
        bool, Option("--isolate", help="Execute the FMU file, in the sandbox of bubblewrap, for the checks that need it.")
    ] = False,
    execute: Annotated[
        bool, Option("--execute", help="Execute the FMU file with your rights. Use it for trusted FMUs only.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Check an FMU against FMI, and the results that it promises. Example: cosimo check Pantograph.fmu --execute

    Of an FMU file the model description alone is checked unless --isolate or --execute is given: all else executes its code.
    """
    from ...components.catalogue import CATALOGUE
    from ...fmus.build import built
    from ...fmus.check import check as check_fmu
    from ...fmus.check_worker import CHECKS
    from ..scene.file_kinds import refuse_other
    from ..units.checked import walled_check

    if isolate and execute:
        raise BadInput("check", "--execute and --isolate exclude each other", "", "Remove one.")
    path = Path(fmu)
    if fmu not in CATALOGUE:
        refuse_other(path, "FMU")
    if not path.is_file():
        if fmu not in CATALOGUE and (":" not in fmu or path.suffix):
            raise BadInput("check", repr(fmu), "an FMU file, a component or module:Class", nearest(fmu, CATALOGUE))
        path, execute = built(fmu), not isolate
    findings = walled_check(path) if isolate else check_fmu(path, execute=execute)
    left_out = [] if isolate or execute else [name for name in CHECKS if name not in {f.name for f in findings}]
    if as_json:
        records = [{"name": f.name, "ok": f.ok, "detail": f.detail} for f in findings]
        print(json.dumps({"fmu": fmu, "findings": records, "left_out": left_out}, indent=2))
    else:
        print_table(fmu, ("check", "ok", "detail"), [(f.name, "yes" if f.ok else "NO", f.detail) for f in findings])
        if left_out and zipfile.is_zipfile(path):
            print(
                f"left out, because they execute the FMU: {', '.join(left_out)}. --isolate makes them in a sandbox, --execute with "
                "your rights"
            )
    if not all(f.ok for f in findings):
        raise SystemExit(FAILED_CHECK)


@app.command()
def ssp(
    scene: SceneName,
    output: Annotated[Path | None, Option("-o", "--output", help="File for the package. Default: the scene's name.")] = None,
    values: Changes = None,
    presets: Presets = None,
    step: Annotated[float | None, Option(help="Macro step of the package for other masters, in s.")] = None,
    tolerance: Annotated[
        str,
        Option(
            help="Largest difference of other masters from the scene, as a share of the range of each quantity, or of the standard "
            "deviation if the quantity is low-pass filtered."
        ),
    ] = "5%",
    native: Native = False,
    force: Annotated[bool, Option("--force", help="Write the package regardless of the differences of other masters.")] = False,
) -> None:
    """Pack a scene with its FMUs for other tools (SSP 1.0). Example: cosimo ssp mass-on-spring --step 0.0025 -o mass.ssp

    Other masters exchange values once per step with held inputs. A run shows the values that they will compute; where that is
    farther from the scene than the tolerance, nothing is written (exit code 1) unless --force is given.
    """
    from ..opened.native import initial_inputs, with_native_fmus
    from ..scene.ssp.write import check as check_package
    from ..scene.ssp.write import write

    loaded = scene_of(scene, values, presets)
    packed = loaded if step is None else loaded.with_changes({"master.step": step})
    warn(loaded.remarks)
    path = output or Path(f"{loaded.name}.ssp")
    limit = share("--tolerance", tolerance)
    check_package(packed, path)
    if not _close_enough(loaded, step, limit) and not force:
        raise fail(
            f"{path} is not written: other masters would be farther than {100.0 * limit:g} % from the scene. "
            "--force writes it all the same",
            FAILED_CHECK,
        )
    starts = initial_inputs(packed) if packed.connections else None
    if native:
        with status_spinner("building native FMUs"):
            packed = with_native_fmus(packed)
    print_written([write(packed, path, starts)])


def _close_enough(scene: Scene, step: float | None, limit: float) -> bool:
    """Print the results of other masters beside the scene's own; whether they are within the limit."""
    from ..harness.other_masters import OtherMasters

    if not scene.connections:
        return True  # each unit alone: no master matters
    with status_spinner("running the scene as other masters step it"):
        masters = OtherMasters(scene)
        comparison = masters.compare(step)
    print_table(
        f"held inputs, exchanged once per step of {comparison.step:g} s",
        ("quantity", "unit", "this scene", "other masters", "difference / scale"),
        [(row.quantity.name, row.quantity.unit, row.here, row.there, row.difference) for row in comparison.rows],
    )
    if comparison.failure:
        warn([f"other masters will not reach the end: {comparison.failure}"])
    if comparison.difference <= limit:
        return True
    with status_spinner("looking for a step that keeps the tolerance"):
        better = masters.step_within(limit)
    if better is not None and better.step < comparison.step:
        print(f"With --step {better.step:g} other masters are within {100.0 * better.difference:.2g} %.")
    else:
        print("No macro step that was tried brings them within the tolerance.")
    return False
