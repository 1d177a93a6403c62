"""Wide ports: one connection of many numbers, or many connections of one."""

import numpy as np
import pytest
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units.interface import ARRAY_THRESHOLD
from cosimo.tests.support import Integrals, OfTime

N = ARRAY_THRESHOLD + 6


class Source(OfTime):
    """Gives many functions of time."""

    wave = output("m", "waves", size=N)

    def _outputs(self, t):
        self.y[:] = np.sin((1.0 + np.arange(N)) * t) * np.logspace(-3, 9, N)


class Sink(Integrals):
    """Integrates many inputs exactly."""

    wave = input_(0.0, "m", "waves", size=N)
    area = output("m.s", "integrals", size=N)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_a_wide_connection_is_many_narrow_ones(algorithm, degree):
    """Split over units with few inputs each, the same signals are bit-identical."""
    here = "cosimo.tests.engine.algorithms.test_rows"
    master = {"algorithm": algorithm, "step": 0.05, "extrapolation": degree}
    wide = run(
        read_scene(
            {
                "stop_time": 1.0,
                "units": {"a": {"component": f"{here}:Source"}, "b": {"component": f"{here}:Sink"}},
                "connections": ["a.wave* -> b.wave*"],
                "master": master,
                "record": {"signals": ["b.area"]},
            }
        )
    )
    halves = {f"b{k}": {"component": f"{here}:Sink"} for k in (0, 1)}
    connections = [f"a.wave[{i}] -> b{i % 2}.wave[{i}]" for i in range(1, N + 1)]
    signals = [f"b{i % 2}.area[{i}]" for i in range(1, N + 1)]
    narrow = run(
        read_scene(
            {
                "stop_time": 1.0,
                "units": {"a": {"component": f"{here}:Source"}, **halves},
                "connections": connections,
                "master": master,
                "record": {"signals": signals},
            }
        )
    )
    assert (wide.outcome, narrow.outcome) == ("done", "done")
    for i in range(1, N + 1):
        np.testing.assert_array_equal(wide[f"b.area[{i}]"], narrow[f"b{i % 2}.area[{i}]"])
