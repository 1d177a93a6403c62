"""The hunt for runs that are wrong without a warning: every shipped scene with coarser steps and stiffer parts.

    python -m cosimo.tests.harness.stability_hunt -o hunt.jsonl [SCENE ...]
    python -m cosimo.tests.harness.stability_hunt -o hunt.jsonl --table      # what the file holds, in Markdown

A run that ends "done" and warns of nothing has to be within 10 % of a run with a finer step, in the quantities of interest of
its scene; one at the shipped settings has to warn of nothing. The table of a whole hunt is docs/stability-hunt.md. Runs that the
file holds already are not repeated.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Collection, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ...orchestrator.harness.studies.quantities import Quantity, TimeHistory, quantities_of, recording
from ...orchestrator.results import Result
from ...orchestrator.run import run
from ...orchestrator.scene.scene import Scene, scene_files
from ...orchestrator.systems import load_scene

COARSER = (1, 2, 5, 10, 20, 50)  # times the scene's macro step
STIFFER = (10.0, 100.0)  # times a stiffness
FINER = 4  # part of the macro step of the run that a run is compared with
STEPS = 1500  # of the scene's own, at most: growth shows in fewer
STIFFNESSES = 2  # parameters of a scene, at most
TRANSIENT = 0.5  # of the shortened run, at most; a longer transient counts as part of it
ENOUGH = 0.1  # error of a quantity of interest


@dataclass(frozen=True)
class Found:
    """One run of the hunt.

    verdict: "right"; "said", by a warning or an outcome other than done; "missed"; "false alarm"; "refused"; "no reference".
    """

    scene: str
    change: str
    outcome: str
    warned: str
    error: float
    worst: str
    verdict: str
    seconds: float


def stiffnesses(scene: Scene) -> list[tuple[str, float]]:
    """(unit.parameter, value) of what is called a stiffness and is not 0, in the order of the units."""
    from ...orchestrator.units import open_unit

    names = []
    for name, unit in scene.units.items():
        if not unit.component:
            continue
        opened = open_unit(name, unit, in_process=True)
        names += [(f"{name}.{key}", float(value)) for key, value in opened.parameters().items()
                  if "stiffness" in key and "[" not in key and isinstance(value, int | float) and value]
        opened.close()
    return names[:STIFFNESSES]


def short(scene: Scene, steps: int = STEPS) -> Scene:
    """The scene over at most so many of its own steps, every step recorded, without faults."""
    stop = min(scene.stop_time, steps * scene.master.step)
    transient = scene.analysis.transient if scene.analysis.transient <= TRANSIENT * stop else 0.0
    return recording(scene.with_changes({"stop_time": stop, "record.interval": None, "record.snapshots": (),
                                         "record.snapshot_interval": None, "analysis.transient": transient, "faults": ()}))


def variants(scene: Scene) -> Iterator[tuple[str, dict[str, Any], bool]]:
    """(name, changes, whether these are the shipped settings) of all runs of a scene."""
    for factor in COARSER:
        if factor * scene.master.step * 3 <= scene.stop_time:
            yield f"step x {factor}", {"master.step": factor * scene.master.step}, factor == 1
    for name, value in stiffnesses(scene):
        unit, parameter = scene.split(name)
        for factor in STIFFER:
            yield f"{name} x {factor:g}", {f"units.{unit}.parameters.{parameter}": factor * value}, False


def hunt(scene: Scene, known: Collection[str] = (), steps: int = STEPS) -> Iterator[Found]:
    """All runs of a scene but the changes that are `known`; coarser steps are compared with the finer step's run.

    Alarms at the shipped settings are those of the whole scene as it is. What is missed is compared with a step half as long as
    the reference's: a motion that no step gets twice, as chaos is, has no reference.
    """
    whole, scene = scene, short(scene, steps)
    references: dict[str, Result | str] = {}
    for name, changes, shipped in variants(scene):
        if name in known:
            continue
        since = process_time()
        kept = {key: value for key, value in changes.items() if key != "master.step"}
        finer = kept | {"master.step": scene.master.step / FINER}
        if str(kept) not in references:
            references[str(kept)] = _run(scene, finer)
        reference, result = references[str(kept)], _run(scene, changes)
        found = _judged(scene, name, _run(whole, {}) if shipped else result, result, reference, shipped)
        if found.verdict == "missed" and not shipped:
            finest = _run(scene, kept | {"master.step": 0.5 * finer["master.step"]})
            again = _judged(scene, name, reference, reference, finest, False)
            found = replace(found, verdict="missed" if again.error <= ENOUGH else "no reference")
        yield replace(found, seconds=process_time() - since)


def _run(scene: Scene, changes: dict[str, Any]) -> Result | str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return run(scene.with_changes(changes), in_process=True).unless_stopped()
    except BadInput as error:
        return str(error)


def _judged(scene: Scene, name: str, judging: Result | str, result: Result | str, reference: Result | str, shipped: bool
            ) -> Found:
    """What a run says of itself is taken from `judging`, and its error from `result`."""
    if isinstance(result, str) or isinstance(judging, str):
        return Found(scene.name, name, "refused", f"{result}", math.nan, "", "refused", 0.0)
    warned = "; ".join([*judging.info["warnings"], *([judging.message] if judging.message else [])])
    error, worst = math.nan, ""
    if not isinstance(reference, str) and reference.outcome == "done" and result.outcome == "done":
        found = {q.name: error_of(q, result, reference) for q in judged(scene, reference)}
        worst = max(found, key=lambda key: found[key], default="")
        error = found.get(worst, 0.0)
    if warned or judging.outcome != "done":
        verdict = "false alarm" if shipped else "said"
    else:
        verdict = "right" if error <= ENOUGH else "missed" if math.isfinite(error) else "no reference"
    return Found(scene.name, name, judging.outcome, warned, error, worst, verdict, 0.0)


def judged(scene: Scene, reference: Result) -> list[Quantity]:
    """Its quantities of interest; where it names none, history and maximum of what it records, but for flags and modes.

    Those have whole numbers only. When a part sticks that hardly moves depends on the last digit, while its motion and forces
    do not.
    """
    return [q for q in quantities_of(scene)
            if scene.study.quantities or (reference.columns[q.signal] != np.rint(reference.columns[q.signal])).any()]


def error_of(quantity: Quantity, result: Result, reference: Result) -> float:
    """Error of a quantity against a run with a finer step, both at the instants of the run that is judged.

    That is what the macro step does to the solution; how densely it samples it is the business of `resolution`, which a run
    judges as well. An energy that is conserved has the error of the solution for a range, so energies are compared with the
    larger of range and magnitude, as an energy drift is.
    """
    x, y = result.columns[quantity.signal], reference.columns[quantity.signal]
    y = np.interp(result.time, reference.time, y)  # whose instants are among its own
    ours, theirs = (TimeHistory(result.time, {quantity.signal: values}) for values in (x, y))
    with np.errstate(all="ignore"):
        error = quantity.error(ours, theirs)
        if quantity.unit == "J":
            scale = quantity.scale(theirs)
            error *= scale / max(scale, float(np.abs(y).max()))
    return error


def table(runs: list[Found]) -> str:
    """Counts by scene, and every run that is wrong without a warning, in Markdown."""
    kinds = ("right", "said", "missed", "false alarm", "no reference", "refused")
    lines = ["| scene | runs | right | warned or unstable | of these within 10 % | missed | false alarms | no reference "
             "| refused |",
             "|---|---|---|---|---|---|---|---|---|"]
    for scene in [*dict.fromkeys(one.scene for one in runs), "all"]:
        mine = [one for one in runs if scene in (one.scene, "all")]
        counts = {kind: sum(one.verdict == kind for one in mine) for kind in kinds}
        cautious = sum(one.verdict == "said" and one.error <= ENOUGH for one in mine)
        cells = (len(mine), counts["right"], counts["said"], cautious, *(counts[kind] for kind in kinds[2:]))
        lines.append(f"| {scene} | {' | '.join(map(str, cells))} |")
    lines += ["", "| missed | change | error | quantity |", "|---|---|---|---|"]
    lines += [f"| {one.scene} | {one.change} | {100.0 * one.error:.0f} % | {one.worst} |"
              for one in runs if one.verdict == "missed"]
    return "\n".join(lines)


def main() -> None:
    """Hunt through the scenes and write one line of JSON for each run, as it comes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("-o", "--output", type=Path, default=Path("hunt.jsonl"))
    parser.add_argument("--steps", type=int, default=STEPS, help="of the scene's own, at most")
    parser.add_argument("--table", action="store_true", help="no runs: print what the file holds")
    given = parser.parse_args()
    lines = given.output.read_text(encoding="utf-8").splitlines() if given.output.exists() else []
    runs = [Found(**json.loads(line)) for line in lines]
    if given.table:
        print(table(sorted(runs, key=lambda one: one.scene)))
        return
    with given.output.open("a", encoding="utf-8") as file:
        for name in given.scenes or sorted(scene_files()):
            known = {one.change for one in runs if one.scene == name}
            for found in hunt(load_scene(name), known, given.steps):
                file.write(json.dumps(asdict(found)) + "\n")
                file.flush()
                print(f"{found.scene:30} {found.change:40} {found.outcome:9} {found.verdict:12} {100 * found.error:8.3g} % "
                      f"{found.worst[:50]}", flush=True)


if __name__ == "__main__":
    main()
