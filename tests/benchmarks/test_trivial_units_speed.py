"""Steps of trivial components in process: what the master itself costs.

Run with `pytest -n 0 tests/benchmarks --write-page`. Masters of others: test_masters_speed.py.
"""

import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.stateless import StatelessComponent, stateless_kernels
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene

TURNS = 5


@kernel
def halve(t, s, p, e):
    s.y[0] = 0.5 * s.u[0, 0]
    return DONE


class KernelGain(StatelessComponent):
    """Half of its input."""

    title = "gain"
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "half of it")
    kernels = stateless_kernels(__name__, halve)


class Gain(Component):
    """Half of its input, by Python in its step."""

    title = "gain"
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "half of it")

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        self.y[0] = 0.5 * self.u[0, 0]
        return DONE

    def _outputs(self, t):
        self.y[0] = 0.5 * self.u[0, 0]


@pytest.mark.parametrize("record", [{"signals": ["a.y_out"], "interval": 20.0}, {}], ids=["one row", "all rows"])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("name", "steps", "least"), [("Gain", 20_000, 500_000), ("KernelGain", 200_000, 5_000_000)])
def test_steps_of_trivial_units_a_second(name, steps, least, algorithm, degree, record, told):
    """Two of them, by CPU time of stepping; the longer run is that in which what happens once a run does not count."""
    gain = {"component": f"cosimo.tests.benchmarks.test_trivial_units_speed:{name}"}
    scene = read_scene(
        {
            "stop_time": 1e-3 * steps,
            "connections": ["a.y_out -> b.u_in", "b.y_out -> a.u_in"],
            "units": {"a": gain, "b": gain},
            "record": record,
            "master": {"algorithm": algorithm, "step": 1e-3, "extrapolation": degree},
        }
    )
    rate = 2 * steps / min(run(scene, in_process=True).info.timing.cpu for _ in range(TURNS))
    told(
        "trivial units",
        f"`{name}`, {algorithm}, {'all rows' if not record else 'one row'}",
        **{f"degree {degree}": f"{rate:.3g}"},
    )
    assert rate > least
