"""Derivatives of coupled runs by every real parameter of scenes of kernels, against differences of runs."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack

import numpy as np
import pytest
from cosimo.components.core.errors import StepFailed
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.units.kinds.kind import NUMERICAL
from cosimo.tests.derivatives.differences import verdict
from cosimo.tests.derivatives.test_tangent_run import short

if COMPILED:
    from cosimo.orchestrator.derivatives.tangent_run import TangentScene

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STEPS = 60
SCENES = "ball-bearing-clearance", "outer-ring-defect", "lumped-catenary", "pipe-robot-level", "wrist-motion"


def judged(name: str) -> dict[str, str]:
    """Of each real parameter of a scene what differences say, over a short run; raises `BadInput` for a scene that is refused."""
    kinds = {}
    with ExitStack() as stack:
        scene = TangentScene(short(name, STEPS), stack)
        names = [n for n in scene.parameters() if n.rpartition(".")[2] not in {*NUMERICAL, "period"}]
        rows, numbers = scene.run(names), scene._image.view(np.float64)
        base = rows.values.ravel()
        for k, parameter in enumerate(names):
            cell, value = scene._place_of(parameter), scene.value(parameter)

            def at(way: float, cell: int = cell, value: float = value) -> np.ndarray | None:
                numbers[cell] = value + way
                try:
                    return scene.run([]).values.ravel()
                except StepFailed:
                    return None
                finally:
                    numbers[cell] = value

            size = abs(value) or 1e-3
            kinds[parameter] = verdict(rows.tangents[:, :, k].ravel(), base, at, size, bool(rows.at_tie[k])).kind
    return kinds


@pytest.mark.parametrize("name", ["mass-on-spring", *(pytest.param(n, marks=pytest.mark.full) for n in SCENES)])
def test_derivatives_by_every_parameter_are_exact_or_told_to_be_at_a_tie(name):
    kinds = judged(name)
    print(name, dict(Counter(kinds.values())))
    assert [n for n, kind in kinds.items() if kind == "wrong"] == []
