"""Derivatives of coupled runs by every real parameter of scenes of kernels, against differences of runs."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.scene.names import numerical_of
from cosimo.tests.derivatives.differences import Verdict, verdict
from cosimo.tests.derivatives.test_tangent_run import columns, short

if COMPILED:
    from cosimo.orchestrator.derivatives.tangent_block import TangentBlock
    from cosimo.orchestrator.derivatives.tangent_run import beside, tangent_run

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STEPS = 60
SIZES_OF_ZERO = 1e-3, 1.0
NUMERICS = "numerics"  # a parameter that sets the numerical error alone, or when samples are taken
SCENES = "ball-bearing-clearance", "outer-ring-defect", "lumped-catenary", "pipe-robot-level", "wrist-motion"


def judged(name: str) -> dict[str, Verdict]:
    """Of each real parameter of a scene what differences say, over a short run; raises `BadInput` for a scene that is refused."""
    scene = short(name, STEPS)
    with ExitStack() as stack, cosimo.open(scene) as session:
        block = TangentBlock(scene, stack)
        numerical = numerical_of(scene, block.parameters())
        names = [n for n in block.parameters() if n not in numerical]

        def numbers(parameter: str, value: float) -> np.ndarray | None:
            """The recorded signals of a run without tangents, (n, S); None where it cannot run."""
            session.reset()
            try:
                session[parameter] = value
                session.initialize()
                session.record()
                session.until(scene.stop_time)
                return columns(session.result())
            except (BadInput, StepFailed):
                return None

        verdicts = dict.fromkeys(numerical, Verdict(NUMERICS, 0.0))
        rows = tangent_run(block, names)
        places = [block.signals.index(end) for end in scene.coupling.signals]
        for k, parameter in enumerate(names):
            value = block.value(parameter)

            def at(way: float, parameter: str = parameter, value: float = value) -> np.ndarray | None:
                return numbers(parameter, value + way)

            def aside(way: float, parameter: str = parameter) -> np.ndarray | None:
                try:
                    return beside(block, parameter, way).tangents[:, places, 0]
                except StepFailed:
                    return None

            exact, told = rows.tangents[:, places, k], bool(rows.at_tie[k])
            sizes = [abs(value)] if value else SIZES_OF_ZERO
            verdicts[parameter] = verdict(exact, numbers(parameter, value), at, sizes, told, aside)
            at(0.0)  # the next parameter finds this one as it was
    return verdicts


@pytest.mark.parametrize("name", ["mass-on-spring", *(pytest.param(n, marks=pytest.mark.full) for n in SCENES)])
def test_derivatives_by_every_parameter_are_exact_or_told_to_be_at_a_tie(name):
    verdicts = judged(name)
    print(name, dict(Counter(one.kind for one in verdicts.values())))
    assert [n for n, one in verdicts.items() if one.kind == "wrong"] == []
