"""How many real parameters of the shipped scenes have exact derivatives: each against differences of runs, over 60 macro steps.

python -m cosimo.tests.campaigns.derivatives --kept FOLDER SCENE ...     # judge scenes, anew, and keep what is found
python -m cosimo.tests.campaigns.derivatives --kept FOLDER > docs/development/derivatives.md    # the page of all that is kept

A scene takes ten seconds to some minutes, so a change is judged by the scenes that it touches.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

from cosimo import load_scene
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.scene.files import scene_files
from cosimo.tests.derivatives.differences import Verdict
from cosimo.tests.derivatives.test_scenes import NUMERICS, STEPS, judged

COUNTED = ("exact", "one-sided, told", "wrong, told", "wrong")
APART = (NUMERICS, "fixed")
HEAD = """# Which parameters have exact derivatives

Made by `python -m cosimo.tests.campaigns.derivatives`. Each real parameter of each shipped scene of kernels was tried over {steps} macro
steps: the derivatives of all recorded signals against central differences at two to ten distances, and against those of either side. The
differences are of runs without derivatives.

- *Exact*: to 1e-5 of each signal, behind what differences resolve. Where a decision stands at its boundary, only if differences
  resolve a twentieth of what counts.
- *One-sided*: the parameter stands at a boundary of the model, such as a contact point on a node of the mesh, or a joint with dry
  friction at rest. The derivative, or that of a run close beside the boundary, holds on one side at least, and is marked so.
- *Refused*: no side agrees. `cosimo gradient` gives the reason instead of a number.
- *Wrong*: a derivative that disagrees and is not marked.

Counted apart: *numerics* (`substep`, `tolerance`, `period` of sampled components), and *fixed* parameters, which have no other value in
their scene (rows of a table that are not in use, the creep of contacts that do not creep).

{summary}

| scene | parameters | exact | one-sided | refused | wrong | numerics | fixed |
|---|---|---|---|---|---|---|---|
"""
ROW = re.compile(r"\| (.+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|")


def row_of(name: str, verdicts: Mapping[str, Verdict]) -> str:
    """The counts of a scene."""
    kinds = Counter(one.kind for one in verdicts.values())
    counts = [sum(kinds[kind] for kind in COUNTED), *(kinds[kind] for kind in (*COUNTED, *APART))]
    return f"| {name} | {' | '.join(map(str, counts))} |"


def named(verdicts: Mapping[str, Verdict], kind: str) -> str:
    """Parameters of a kind, by the reason where there is one; elements of an array together."""
    some = [(one.why, re.sub(r"\[\d+\]$", "[]", n)) for n, one in verdicts.items() if one.kind == kind]
    reasons = {why: ", ".join(dict.fromkeys(n for w, n in some if w == why)) for why, _ in some}
    return "; ".join(f"{why}: {names}" if why else names for why, names in reasons.items())


def page(found: Mapping[str, Mapping[str, Verdict] | str]) -> str:
    """The page of what was found in scenes, or why one has no derivatives."""
    judged_ones = {name: some for name, some in found.items() if not isinstance(some, str)}
    rows = [row_of(name, some) for name, some in judged_ones.items()]
    counts = [[int(n) for n in match.groups()[1:]] for row in rows if (match := ROW.fullmatch(row))]
    total = [sum(column) for column in zip(*counts, strict=True)]
    shares = [f"{100.0 * n / total[0]:.1f} %" for n in total[1:4]]
    summary = (
        f"Of {total[0]} parameters of {len(rows)} scenes, {total[1]} ({shares[0]}) are exact, {total[2]} ({shares[1]}) one-sided, "
        f"{total[3]} ({shares[2]}) refused, {total[4]} wrong."
    )
    lines = [HEAD.format(steps=STEPS, summary=summary) + "\n".join([*rows, f"| all | {' | '.join(map(str, total))} |"])]
    for title, kind in (("One-sided", COUNTED[1]), ("Refused", COUNTED[2]), ("Wrong", COUNTED[3]), ("Fixed", APART[1])):
        some = [f"- {name}: {names}" for name, one in judged_ones.items() if (names := named(one, kind))]
        lines += ["", f"## {title}", "", *some] if some else []
    lines += [
        "",
        "## Scenes without derivatives",
        "",
        *(f"- {name}: {why}" for name, why in found.items() if isinstance(why, str)),
    ]
    if missing := sorted(scene_files().keys() - found.keys()):
        lines += ["", "## Not tried, for they take long", "", ", ".join(missing)]
    return "\n".join(lines)


def find(names: Iterable[str], folder: Path) -> None:
    """Keep what each scene gives; a row to the error stream as it is known."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        try:
            if load_scene(name).faults:  # behind the end of a short run
                raise BadInput(name, "faults", "none")
            verdicts = judged(name)
            found, shown = {n: list(one) for n, one in verdicts.items()}, row_of(name, verdicts)
        except (BadInput, StepFailed) as error:
            found = error.actual if isinstance(error, BadInput) else str(error)
            shown = f"| {name} | {found} |"
        (folder / f"{name}.json").write_text(json.dumps(found))
        print(shown, file=sys.stderr, flush=True)


def kept(folder: Path) -> dict[str, Mapping[str, Verdict] | str]:
    """What scenes gave that are shipped still."""
    found: dict[str, Mapping[str, Verdict] | str] = {}
    for file in sorted(folder.glob("*.json")):
        if file.stem in scene_files():
            some = json.loads(file.read_text())
            found[file.stem] = some if isinstance(some, str) else {n: Verdict(*one) for n, one in some.items()}
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--kept", type=Path, required=True)
    arguments = parser.parse_args()
    if arguments.scenes:
        find(arguments.scenes, arguments.kept)
    else:
        print(page(kept(arguments.kept)))
