"""The hunt for runs that are wrong without a warning: every shipped scene with coarser steps and stiffer parts.

    python -m cosimo.tests.harness.stability_hunt -o hunt.jsonl [SCENE ...]
    python -m cosimo.tests.harness.stability_hunt -o hunt.jsonl --table      # what the file holds, in Markdown

A run that ends "done" and warns of nothing has to be within 10 % of a run with a finer step, in the quantities of interest of
its scene; one at the shipped settings has to warn of nothing. The table of a whole hunt is docs/stability-hunt.md.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ...orchestrator.harness.studies.quantities import TimeHistory, errors, quantities_of, recording
from ...orchestrator.results import Result
from ...orchestrator.run import run
from ...orchestrator.scene.scene import Scene, scene_files
from ...orchestrator.systems import load_scene

COARSER = (1, 2, 5, 10, 20, 50)  # times the scene's macro step
STIFFER = (10.0, 100.0)  # times a stiffness
FINER = 2  # part of the macro step of the run that a run is compared with
STEPS = 1500  # of the scene's own, at most: growth shows in fewer
STIFFNESSES = 2  # parameters of a scene, at most
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


def short(scene: Scene) -> Scene:
    """The scene over at most `STEPS` of its own steps, every step recorded, without faults."""
    stop = min(scene.stop_time, STEPS * scene.master.step)
    return recording(scene.with_changes({"stop_time": stop, "record.interval": None, "record.snapshots": (),
                                         "record.snapshot_interval": None, "faults": ()}))


def variants(scene: Scene) -> Iterator[tuple[str, dict[str, Any], bool]]:
    """(name, changes, whether these are the shipped settings) of all runs of a scene."""
    for factor in COARSER:
        if factor * scene.master.step * 3 <= scene.stop_time:
            yield f"step x {factor}", {"master.step": factor * scene.master.step}, factor == 1
    for name, value in stiffnesses(scene):
        unit, parameter = scene.split(name)
        for factor in STIFFER:
            yield f"{name} x {factor:g}", {f"units.{unit}.parameters.{parameter}": factor * value}, False


def hunt(scene: Scene) -> Iterator[Found]:
    """All runs of a scene; the comparison of the coarser steps is one with the finer step at the shipped settings."""
    scene = short(scene)
    references: dict[str, Result | str] = {}
    for name, changes, shipped in variants(scene):
        since = process_time()
        kept = {key: value for key, value in changes.items() if key != "master.step"}
        finer = kept | {"master.step": scene.master.step / FINER}
        if str(kept) not in references:
            references[str(kept)] = _run(scene, finer)
        reference, result = references[str(kept)], _run(scene, changes)
        yield _judged(scene, name, shipped, result, reference, process_time() - since)


def _run(scene: Scene, changes: dict[str, Any]) -> Result | str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return run(scene.with_changes(changes), in_process=True)
    except BadInput as error:
        return str(error)


def _judged(scene: Scene, name: str, shipped: bool, result: Result | str, reference: Result | str, seconds: float) -> Found:
    if isinstance(result, str):
        return Found(scene.name, name, "refused", result, math.nan, "", "refused", seconds)
    warned = "; ".join([*result.info["warnings"], *([result.message] if result.message else [])])
    error, worst = math.nan, ""
    if not isinstance(reference, str) and reference.outcome == "done" and result.outcome == "done":
        with np.errstate(all="ignore"):
            found = errors(quantities_of(scene), TimeHistory(result.time, result.columns),
                           TimeHistory(reference.time, reference.columns))
        worst = max(found, key=lambda key: found[key])
        error = found[worst]
    if warned or result.outcome != "done":
        verdict = "false alarm" if shipped else "said"
    else:
        verdict = "right" if error <= ENOUGH else "missed" if math.isfinite(error) else "no reference"
    return Found(scene.name, name, result.outcome, warned, error, worst, verdict, seconds)


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
    parser.add_argument("--table", action="store_true", help="no runs: print what the file holds")
    given = parser.parse_args()
    if given.table:
        print(table([Found(**json.loads(line)) for line in given.output.read_text(encoding="utf-8").splitlines()]))
        return
    with given.output.open("a", encoding="utf-8") as file:
        for name in given.scenes or sorted(scene_files()):
            for found in hunt(load_scene(name)):
                file.write(json.dumps(asdict(found)) + "\n")
                file.flush()
                print(f"{found.scene:30} {found.change:40} {found.outcome:9} {found.verdict:12} {100 * found.error:8.3g} % "
                      f"{found.worst[:50]}", flush=True)


if __name__ == "__main__":
    main()
