"""Where the limit of a stable macro step, told by tangents, is that of the runs: each scene at shares of its limit.

python -m cosimo.tests.campaigns.stability_limits --kept FOLDER SCENE ...    # examine scenes, and keep what is found
python -m cosimo.tests.campaigns.stability_limits --kept FOLDER              # the table of all that is kept

Each run is judged by its repetition with half of the steps: its outcome, and the largest error of a signal in deviations of it.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cosimo import load_scene
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.judgement.advice import coupling_of
from cosimo.orchestrator.judgement.growth import limit_text
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.tests.campaigns.stability_hunt import quietly

SHARES = 0.8, 1.3, 2.0  # of the limit
SMALL = 0.05  # error, in deviations, of a run that is none the worse for its step
HEAD = f"""| scene | longest step, ms | {" | ".join(f"at {share:g}" for share in SHARES)} | |
|---|---|{"---|" * len(SHARES)}---|"""


def found(name: str) -> dict[str, Any]:
    """Limit of a scene, and of each share outcome and error; or `refused`."""
    scene = load_scene(name)
    if all(len(group) == 1 for group in scene.coupling.groups):
        return {"refused": "no unit feeds back to another"}
    try:
        with ExitStack() as stack:
            limit = coupling_of(scene, stack).longest()
    except (BadInput, StepFailed) as error:
        return {"refused": str(error)}
    if math.isnan(limit.longest):
        return {"refused": limit.seen}
    runs: list[tuple[str, float]] = []
    for share in SHARES if 0.0 < limit.longest < math.inf else ():
        try:
            result = quietly(run_verified, scene.with_changes({"master.step": share * limit.longest}), verify="steps")
        except BadInput as error:
            runs.append((f"refused: {error}", math.nan))
            continue
        errors = [one.rms for one in result.info.verification.signals.values() if one.rms is not None]
        runs.append((result.outcome, max(errors, default=math.nan)))
    return {"limit": limit_text(1e3 * limit.longest, 1e3 * limit.tried), "runs": runs}


def failing(runs: list[tuple[str, float]]) -> str:
    """Whether runs disagree with the limit: one below it that is unstable, or one beyond it that is none the worse."""
    below, *beyond = runs
    if below[0] not in ("done", "inaccurate"):
        return f"{below[0]} below the limit"
    fine = [share for share, (outcome, error) in zip(SHARES[1:], beyond, strict=True) if outcome == "done" and error < SMALL]
    return f"error below 5 % at {fine[-1]:g} times the limit" if fine else ""


def row(name: str, one: dict[str, Any]) -> str:
    """A line of the table."""
    runs = [f"{outcome.partition(':')[0]}{'' if math.isnan(error) else f', {error:.2g}'}" for outcome, error in one["runs"]]
    cells = [name, one["limit"], *(runs or ["-"] * len(SHARES)), failing(one["runs"]) if runs else ""]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--kept", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.kept.mkdir(parents=True, exist_ok=True)
    for name in arguments.scenes:
        one = found(name)
        (arguments.kept / f"{name}.json").write_text(json.dumps(one))
        print(name, one, file=sys.stderr, flush=True)
    if not arguments.scenes:
        known = {file.stem: json.loads(file.read_text()) for file in sorted(arguments.kept.glob("*.json"))}
        print("\n".join([HEAD, *(row(name, one) for name, one in known.items() if "refused" not in one)]))
