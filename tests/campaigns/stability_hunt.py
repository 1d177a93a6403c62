"""The hunt for runs that are wrong by more than they say: shipped scenes at random settings that a user may choose.

    python -m cosimo.tests.campaigns.stability_hunt -o hunt.jsonl [--runs 3000] [--seed 0] [SCENE ...]
    python -m cosimo.tests.campaigns.stability_hunt -o hunt.jsonl --table      # what the file holds, in Markdown

Each run is drawn at random: a scene, an algorithm, a degree of the inputs, a macro step of 1 to 50 times the scene's own, and one of
the scene's variants: as it is, a stiffness of 3 to 100 times, or three parameters by up to 30 %. It runs to the end of the scene,
verified as `cosimo run --verify steps` does, so that no warning of a mesh hides what steps do. Its true error is that against the own
algorithm of the scene at a quarter of its own steps, inside, too, whose error is measured against an eighth. A further line for each
variant has the error of the scene's meshes, stated and true. The table of a whole hunt is docs/stability-hunt.md. Runs that the file
holds already are not repeated.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ...orchestrator.harness.studies.settings_axes import coupling_changes
from ...orchestrator.judgement.verification import run_verified
from ...orchestrator.run.results import Result
from ...orchestrator.run.run import run as run_once
from ...orchestrator.scene.meshes import meshes_of
from ...orchestrator.scene.scene import Scene, scene_files
from ...orchestrator.scene.shorter_steps import refined
from ...orchestrator.systems import load_scene
from ...orchestrator.units.component import make

ALGORITHMS = ("jacobi", "gauss-seidel", "iterative")
COARSER = (1, 2, 3, 5, 7, 10, 15, 20, 30, 50)  # times the scene's macro step
STIFFER = (3.0, 10.0, 30.0, 100.0)  # times a stiffness
STIFFNESSES = 2  # parameters of a scene, at most
MOVED, MOST, VARIED = 3, 0.3, 3  # parameters that a variant moves by up to this share; such variants of a scene
TRIES = 40  # draws of them, as many do not fit
FINER = (4, 8)  # parts of the scene's own macro step, of the reference and of what the reference is judged by
ENOUGH = 2.0  # a true error of more than so many stated ones is understated
FLOOR = 1e-3  # of a signal's deviation, or of a figure: a smaller error counts as none
OFF, FIGURE_OFF = 0.05, 0.01  # of a signal's deviation; of a figure that is understated, too: the run is missed
FINER_MESH = 3  # times as many elements, with internal steps shorter by its square, as beams need
MESH = "mesh"  # in place of an algorithm: what meshes make of the error
UNCLEAR = 0.25  # of a true error: a reference that is worse tells nothing of it
SETTINGS = {"substep", "tolerance", "element", "sample_time", "spectral_radius"}  # of how a component computes, not of what
TURN = 2.0 * math.pi + 1e-9
STILL = 1e-3  # deviation over size below which a signal is judged by its size
NOTHING = 1e-6  # of a signal's nominal value: a deviation below it is rounding, as of a momentum that is conserved at 0
VERDICTS = ("right", "understated", "said", "missed", "refused", "no reference")
Factors = tuple[tuple[str, float], ...]  # "unit.parameter" and what it is multiplied by


@dataclass(frozen=True)
class Choice:
    """What a run is made of. algorithm `MESH`: the scene's own, judged for its meshes."""

    scene: str
    algorithm: str
    extrapolation: int = 0
    coarser: int = 1
    factors: Factors = ()

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> Choice:
        """Of what JSON has made of a choice."""
        return cls(**{**data, "factors": tuple((name, factor) for name, factor in data["factors"])})

    def __str__(self) -> str:
        moved = "".join(f", {name} x {factor:.3g}" for name, factor in self.factors)
        return (
            f"{self.algorithm}, degree {self.extrapolation}, step x {self.coarser}{moved}"
            if self.algorithm != MESH
            else f"mesh{moved}"
        )


@dataclass(frozen=True)
class Run:
    """One run of the hunt.

    verdict: "right"; "understated", off by more than twice what is stated and 0.1 %; "missed", without a warning: a signal off by more
    than 5 % of its deviation, or a figure understated and off by more than 1 %; "said", by a warning or an outcome other than done;
    "refused"; "no reference".
    true, said: error of the worst signal or figure, as share of its scale, and what the run states of it.  worst: its name.
    """

    choice: dict[str, Any]
    outcome: str
    warned: str
    verdict: str
    true: float = math.nan
    said: float = math.nan
    worst: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Reference:
    """A run with short steps, and one with shorter ones by which it is judged."""

    result: Result
    finer: Result

    @cached_property
    def errors(self) -> dict[str, float]:
        """Error of each signal, as share of its scale, at the times of the reference."""
        return true_errors(self.result, self.finer)


@dataclass
class Hunt:
    """Runs of one scene, which share references."""

    scene: Scene
    references: dict[Factors, Reference | str] = field(default_factory=dict)

    @cached_property
    def numbers(self) -> dict[str, float]:
        """Parameters of components that are numbers other than 0 and are used, "unit.parameter"."""
        values = {}
        for name, unit in self.scene.units.items():
            if unit.component:
                component = make(name, unit)
                known = {k: v for k, v in component.parameters.items() if isinstance(v, float) and v and "[" not in k}
                values |= {f"{name}.{key}": known[key] for key in known.keys() - component.unused(known).keys()}
        return dict(sorted(values.items()))

    def variants(self, chance: random.Random) -> list[Factors]:
        """The scene as it is, each of some stiffnesses many times larger, and some parameters at once by up to 30 %."""
        numbers = [n for n in self.numbers if n.rpartition(".")[2] not in SETTINGS]
        stiff = [((name, chance.choice(STIFFER)),) for name in numbers if "stiffness" in name.partition(".")[2]][:STIFFNESSES]
        moved: dict[Factors, None] = {}
        for _ in range(TRIES if numbers else 0):
            names = sorted(chance.sample(numbers, min(MOVED, len(numbers))))
            factors = tuple((name, round(chance.uniform(1.0 - MOST, 1.0 + MOST), 3)) for name in names)
            with suppress(BadInput):  # geometry that does not fit, ranges
                scene = self.scene.with_changes(self._moved(factors))
                for name, unit in scene.units.items():
                    if unit.component:
                        make(name, unit)
                moved[factors] = None
            if len(moved) == VARIED:
                break
        return [(), *stiff, *moved]

    def judged(self, choice: Choice) -> Run:
        """The run of a choice, and whether it is right in what it says."""
        if choice.algorithm == MESH:
            return self.of_mesh(choice)
        since = process_time()
        try:
            result = quietly(run_verified, self.scene.with_changes(self.changes(choice)), verify="steps")
        except BadInput as error:
            return Run(asdict(choice), "refused", str(error), "refused")
        reference = self.reference(choice)
        if isinstance(reference, str):
            return Run(asdict(choice), result.outcome, reference, "no reference")
        return compared(choice, result, reference, process_time() - since)

    def changes(self, choice: Choice) -> dict[str, Any]:
        """Changes of the scene to those of a choice; rows at most at every macro step of the scene's own."""
        return {
            **coupling_changes(self.scene, choice.algorithm, choice.extrapolation),
            **self._moved(choice.factors),
            "master.step": choice.coarser * self.scene.master.step,
        }

    def of_mesh(self, choice: Choice) -> Run:
        """The scene's own settings: the error that its meshes make, stated and true."""
        since = process_time()
        try:
            scene = self.scene.with_changes(self._moved(choice.factors))
            result = quietly(run_verified, scene, verify="whole")
            own = scene.with_changes(refined(scene, FINER_MESH**-2))
            elements = {
                p: m.value / FINER_MESH if m.by_length else int(m.value) * FINER_MESH for p, m in meshes_of(scene).items()
            }
            runs = [quietly(run_once, one) for one in (own, own.with_changes(elements))]
        except BadInput as error:
            return Run(asdict(choice), "refused", str(error), "refused")
        bad = next((r for r in (result, *runs) if r.outcome != "done"), None)
        mesh = result.info.verification.mesh
        if bad is not None or not mesh.places:
            why = bad.message if bad is not None else "; ".join(mesh.not_covered.values())
            return Run(asdict(choice), result.outcome, why, "no reference" if result.outcome == "done" else "said")
        figures = self._figures(*runs, mesh.figures)
        gaps = [(name, true, mesh.signals.get(name) or 0.0, 0.0) for name, true in true_errors(*runs).items()]
        return verdict_of(choice, result.outcome, "; ".join(result.info.warnings), [*gaps, *figures], process_time() - since)

    @staticmethod
    def _figures(result: Result, finer: Result, stated: Mapping[str, float | None]) -> Iterator[tuple[str, float, float, float]]:
        try:
            ours, theirs = ({row.name: row.value for row in r.summary} for r in (result, finer))
        except BadInput:  # such as a window that is longer than the run with moved parameters
            return
        for name, value in ours.items():
            scale = max(abs(value), abs(theirs.get(name, math.nan)))
            if scale > 0.0 and isinstance(error := stated.get(name), float):
                yield f"figure {name}", abs(value - theirs[name]) / scale, error / scale, 0.0

    def _moved(self, factors: Factors) -> dict[str, Any]:
        places = {name: self.scene.split(name) for name, _ in factors}
        return {f"{places[n][0]}.{places[n][1]}": f * self.numbers[n] for n, f in factors}

    def reference(self, choice: Choice) -> Reference | str:
        """The solution of the scene with the parameters of a choice, or why there is none."""
        key = choice.factors
        if key not in self.references:
            own = {**self._moved(choice.factors), "master.control": None, "record.interval": self.scene.master.step}
            try:
                stiff = self.scene.with_changes(self._moved(choice.factors))
                runs = [
                    quietly(
                        run_once, stiff.with_changes({**own, "master.step": stiff.master.step / k, **refined(stiff, 1.0 / k)})
                    )
                    for k in FINER
                ]
                bad = next((r for r in runs if r.outcome != "done"), None)
                self.references[key] = Reference(*runs) if bad is None else f"{bad.outcome}: {bad.message}"
            except BadInput as error:
                self.references[key] = str(error)
        return self.references[key]


def quietly(run: Any, scene: Scene, **how: Any) -> Result:
    """A run in process, whose warnings are read from its result."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return run(scene, in_process=True, **how)


def true_errors(result: Result, finer: Result) -> dict[str, float]:
    """Error of every recorded number (rms, as share of its deviation) against a run with shorter steps, at times of the first.

    A signal that stands still is judged by its size, one that is rounding and no more by its nominal value. What has whole
    numbers only, as flags and modes have, and a text is judged by the share of time in which it differs. Own code, for what it
    judges must not share its mistakes.
    """
    errors = {}
    interfaces = result.scene.coupling.interfaces
    nominal = {f"{unit}.{name}": signal.nominal for unit, i in interfaces.items() for name, signal in i.outputs.items()}
    for name in (*result.columns, *result.texts):
        x, y = result[name], finer[name]
        rows = np.clip(np.searchsorted(finer.time, result.time + 1e-9 * finer.time[-1], side="right") - 1, 0, None)
        if name in result.texts or (np.array_equal(x, np.rint(x)) and np.array_equal(y, np.rint(y))):
            errors[name] = float((x != y[rows]).mean())
            continue
        y_here = np.interp(result.time, finer.time, y)
        y_here[finer.time[rows] == result.time] = y[rows][finer.time[rows] == result.time]
        both = np.isfinite(x) & np.isfinite(y_here)
        size = float(np.sqrt((y_here[both] ** 2).mean())) if both.any() else 0.0
        scale = max(float(y_here[both].std()) if both.any() else 0.0, STILL * size, NOTHING * nominal[name])
        gap = (x - y_here)[both]
        if result.measures.get(name) == "rad" and np.ptp(y) <= TURN and np.abs(np.diff(y)).max(initial=0.0) > 0.5 * TURN:
            gap = (gap + 0.5 * TURN) % TURN - 0.5 * TURN  # it begins anew after each turn
        rms = float(np.sqrt((gap**2).mean())) if both.any() else 0.0
        errors[name] = rms / scale
    return errors


def compared(choice: Choice, result: Result, reference: Reference, seconds: float) -> Run:
    """What a run says, compared with its reference."""
    info = result.info
    warned = "; ".join([*info.warnings, *([result.message] if result.message else [])])
    if result.outcome != "done":
        return Run(asdict(choice), result.outcome, warned, "said", seconds=seconds)
    if not info.verification.done:
        return Run(asdict(choice), result.outcome, info.verification.why, "said", seconds=seconds)
    gaps = [
        (name, true, info.verification.signals[name].rms or 0.0, reference.errors[name])
        for name, true in true_errors(result, reference.result).items()
        if name in info.verification.signals
    ]
    gaps += list(figures(result, reference))
    return verdict_of(choice, result.outcome, warned, gaps, seconds)


def verdict_of(choice: Choice, outcome: str, warned: str, gaps: list[tuple[str, float, float, float]], seconds: float) -> Run:
    """The verdict on a run that is done, from the name, the true and the stated error of each number, and the reference's own."""
    clear = [(name, true - own, said) for name, true, said, own in gaps if own <= UNCLEAR * true or true < FLOOR]
    if not clear:
        return Run(asdict(choice), outcome, warned, "said" if warned else "no reference", seconds=seconds)
    off = [one for one in clear if _is_off(*one)]
    worst = max(off or clear, key=lambda one: one[1] / max(one[2], FLOOR / ENOUGH))
    understated = worst[1] > ENOUGH * worst[2] + FLOOR
    verdict = "said" if warned else "missed" if off else "understated" if understated else "right"
    return Run(asdict(choice), outcome, warned, verdict, worst[1], worst[2], worst[0], seconds)


def _is_off(name: str, true: float, said: float) -> bool:
    return true > max(ENOUGH * said, FIGURE_OFF) if name.startswith("figure ") else true > OFF


def figures(result: Result, reference: Reference) -> Iterator[tuple[str, float, float, float]]:
    """(name, true error, stated error, the reference's own) of the figures of the summary whose error is stated, as shares."""
    try:
        ours, theirs, finest = ({row.name: row for row in r.summary} for r in (result, reference.result, reference.finer))
    except BadInput:
        return
    for name, row in ours.items():
        if name in theirs and name in finest and math.isfinite(row.error):
            value, other = theirs[name].value, finest[name].value
            scale = max(abs(value), abs(row.value))
            if scale > 0.0 and math.isfinite(value - other):
                yield f"figure {name}", abs(row.value - value) / scale, row.error / scale, abs(value - other) / scale


def choices(scenes: Iterable[str], runs: int, seed: int) -> dict[str, list[Choice]]:
    """So many choices at random, by scene; the same for the same seed."""
    chance = random.Random(seed)
    names = list(scenes)
    loaded = {name: load_scene(name) for name in names}
    variants = {name: Hunt(scene).variants(random.Random(f"{seed} {name}")) for name, scene in loaded.items()}
    chosen = {n: dict.fromkeys(Choice(n, MESH, factors=f) for f in of_mesh(loaded[n], those)) for n, those in variants.items()}
    while sum(map(len, chosen.values())) < runs:
        name = chance.choice(names)
        scene = loaded[name]
        coarser = chance.choice([k for k in COARSER if 4 * k * scene.master.step <= scene.stop_time])
        linked = bool(scene.coupling.links)  # without a connection, there is nothing to extrapolate
        algorithm, degree = chance.choice(ALGORITHMS if linked else ALGORITHMS[:1]), chance.choice((0, 1, 2)) if linked else 0
        chosen[name][Choice(name, algorithm, degree, coarser, chance.choice(variants[name]))] = None
    return {name: list(those) for name, those in chosen.items()}


def of_mesh(scene: Scene, variants: list[Factors]) -> list[Factors]:
    """The variants of a scene with meshes for which these are judged: all but stiffnesses; none of a scene without a mesh."""
    return [v for v in variants if not v or max(f for _, f in v) <= 1.0 + MOST] if meshes_of(scene) else []


def table(runs: list[Run]) -> str:
    """Counts by scene, with the least of stated over true error of meshes, and every run that is wrong by more than it says."""
    lines = [f"| scene | runs | {' | '.join(VERDICTS)} | mesh: true, stated |", "|---" * (len(VERDICTS) + 3) + "|"]
    for scene in [*dict.fromkeys(one.choice["scene"] for one in runs), "all"]:
        mine = [one for one in runs if scene in (one.choice["scene"], "all")]
        counts = (sum(one.verdict == verdict for one in mine) for verdict in VERDICTS)
        meshes = [one for one in mine if one.choice["algorithm"] == MESH and math.isfinite(one.true)]
        least = min(meshes, key=lambda one: one.said / max(one.true, FLOOR), default=None)
        mesh = f"{least.true:.2%}, {least.said:.2%}" if least and scene != "all" else ""
        lines.append(f"| {scene} | {len(mine)} | {' | '.join(map(str, counts))} | {mesh} |")
    for verdict in ("missed", "understated"):
        lines += ["", f"| {verdict} | settings | worst | true error | stated |", "|---|---|---|---|---|"]
        lines += [
            f"| {one.choice['scene']} | {Choice.read(one.choice)} | {one.worst} | {one.true:.2%} | {one.said:.2%} |"
            for one in runs
            if one.verdict == verdict
        ]
    return "\n".join(lines)


def main() -> None:
    """Hunt through the scenes and write one line of JSON for each run, as it comes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="only their runs, of those that are drawn of all scenes")
    parser.add_argument("-o", "--output", type=Path, default=Path("hunt.jsonl"))
    parser.add_argument("--runs", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--table", action="store_true", help="no runs: print what the file holds")
    given = parser.parse_args()
    lines = given.output.read_text(encoding="utf-8").splitlines() if given.output.exists() else []
    runs = [Run(**json.loads(line)) for line in lines]
    if given.table:
        print(table(sorted(runs, key=lambda one: one.choice["scene"])))
        return
    known = {Choice.read(one.choice) for one in runs}
    with given.output.open("a", encoding="utf-8") as file:
        drawn = choices(sorted(scene_files()), given.runs, given.seed)
        for name, chosen in ((name, drawn[name]) for name in given.scenes or drawn):
            hunt = Hunt(load_scene(name))
            for choice in chosen:
                if choice in known:
                    continue
                found = hunt.judged(choice)
                file.write(json.dumps(asdict(found)) + "\n")
                file.flush()
                print(
                    f"{name:30} {choice!s:70} {found.verdict:12} {100 * found.true:8.3g} % stated {100 * found.said:8.3g} % "
                    f"{found.worst[:50]}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
