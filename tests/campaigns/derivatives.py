"""How many real parameters of the shipped scenes have exact derivatives: each against differences of runs, over 60 macro steps.

python -m cosimo.tests.campaigns.derivatives [SCENE ...]      # rows of the table in docs/derivatives.md, in Markdown
"""

from __future__ import annotations

import sys
from collections import Counter

from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.scene.files import scene_files
from cosimo.tests.derivatives.test_scenes import judged

KINDS = ("exact", "one-sided, told", "wrong, told", "wrong")


def row_of(name: str) -> str:
    """The counts of a scene, or why it has no derivatives."""
    try:
        kinds = Counter(judged(name).values())
    except (BadInput, StepFailed) as error:
        return f"| {name} | {error} |"
    return f"| {name} | {sum(kinds.values())} | {' | '.join(str(kinds[kind]) for kind in KINDS)} |"


if __name__ == "__main__":
    for scene in sys.argv[1:] or sorted(scene_files()):
        print(row_of(scene), flush=True)
