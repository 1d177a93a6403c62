"""Where the limit of a stable macro step, told by tangents, is that of the runs: each scene at shares of its limit.

python -m cosimo.tests.campaigns.stability_limits --kept FOLDER SCENE ...    # examine scenes, and keep what is found
python -m cosimo.tests.campaigns.stability_limits --kept FOLDER --random 50 SCENE ...    # settings of scenes at random
python -m cosimo.tests.campaigns.stability_limits --kept FOLDER              # the table of all that is kept

Each run is judged by its repetition with half of the steps: its outcome, and the largest error of a signal in deviations of it.
Where no step is unstable, the run with the longest one that was tried is judged.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cosimo import load_scene
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.judgement.advice import coupling_of
from cosimo.orchestrator.judgement.growth import limit_text
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.orchestrator.scene.scene import Scene
from cosimo.tests.campaigns.stability_hunt import ALGORITHMS, Choice, Hunt, quietly

SHARES = 0.8, 1.3, 2.0  # of the limit
FINE = "done", "inaccurate"  # outcomes of runs that are not unstable
SMALL = 0.05  # error, in deviations, of a run that is none the worse for its step
HEAD = f"""| scene | longest step, ms | {" | ".join(f"at {share:g}" for share in SHARES)} | |
|---|---|{"---|" * len(SHARES)}---|"""


def found(scene: Scene) -> dict[str, Any]:
    """Limit of a scene, and of each share of it outcome and error; of the longest step that was tried, if there is none; or `refused`."""
    if all(len(group) == 1 for group in scene.coupling.groups):
        return {"refused": "no unit feeds back to another"}
    try:
        with ExitStack() as stack:
            limit = coupling_of(scene, stack).longest()
    except (BadInput, StepFailed) as error:
        return {"refused": str(error)}
    if math.isnan(limit.longest):
        return {"refused": limit.seen}
    steps = [limit.tried] if math.isinf(limit.longest) else [share * limit.longest for share in SHARES if limit.longest]
    runs: list[tuple[str, float]] = []
    for step in steps:
        try:
            result = quietly(run_verified, scene.with_changes({"master.step": step}), verify="steps")
        except BadInput as error:
            runs.append((f"refused: {error}", math.nan))
            continue
        errors = [one.rms for one in result.info.verification.signals.values() if one.rms is not None]
        runs.append((result.outcome, max(errors, default=math.nan)))
    return {"limit": limit_text(1e3 * limit.longest, 1e3 * limit.tried), "runs": runs}


def at_random(scenes: Sequence[str], number: int, seed: int) -> Iterator[tuple[str, Scene]]:
    """So many settings at random of scenes, and what they are: an algorithm, a degree, and a variant of the hunt for wrong runs."""
    chance = random.Random(seed)
    hunts = {name: Hunt(load_scene(name)) for name in scenes}
    variants = {name: hunt.variants(random.Random(f"{seed} {name}")) for name, hunt in hunts.items()}
    for k in range(number):
        name = chance.choice(scenes)
        choice = Choice(name, chance.choice(ALGORITHMS[:2]), chance.randrange(3), 1, chance.choice(variants[name]))
        yield f"{k:02} {name}, {choice}", hunts[name].scene.with_changes(hunts[name].changes(choice))


def failing(runs: list[tuple[str, float]]) -> str:
    """Whether runs disagree with the limit: one below it that is unstable, or one beyond it that is none the worse."""
    below, *beyond = runs
    if not beyond:
        return f"{below[0]} with the longest step that was tried" if below[0] not in FINE else ""
    if below[0] not in FINE:
        return f"{below[0]} below the limit"
    fine = [share for share, (outcome, error) in zip(SHARES[1:], beyond, strict=True) if outcome == "done" and error < SMALL]
    return f"error below 5 % at {fine[-1]:g} times the limit" if fine else ""


def row(name: str, one: dict[str, Any]) -> str:
    """A line of the table."""
    runs = [f"{outcome.partition(':')[0]}{'' if math.isnan(error) else f', {error:.2g}'}" for outcome, error in one["runs"]]
    runs = runs if len(runs) == len(SHARES) else ["-"] * len(SHARES)
    cells = [name, one["limit"], *runs, failing(one["runs"]) if one["runs"] else ""]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    arguments.kept.mkdir(parents=True, exist_ok=True)
    drawn = at_random(arguments.scenes, arguments.random, arguments.seed) if arguments.random else ()
    for name, scene in drawn or ((name, load_scene(name)) for name in arguments.scenes):
        one = found(scene)
        (arguments.kept / f"{name}.json").write_text(json.dumps(one))
        print(name, one, file=sys.stderr, flush=True)
    if not arguments.scenes:
        known = {file.stem: json.loads(file.read_text()) for file in sorted(arguments.kept.glob("*.json"))}
        print("\n".join([HEAD, *(row(name, one) for name, one in known.items() if "refused" not in one)]))
