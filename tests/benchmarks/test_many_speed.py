"""What a point of many runs costs beside the steps of its kernels."""

from time import process_time

import pytest
from cosimo import load_scene, run_many
from cosimo.orchestrator.run.run import run

POINTS = 100


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [("mass-on-spring", "spring.stiffness", 100.0), ("en50318-2002", "pantograph.static_force", 115.0)],
)
def test_a_row_costs_little_beside_its_kernels(name, parameter, value, told):
    """CPU time of a table of points in one process over that of one, less the stepping of a run."""
    scene = load_scene(name)

    def seconds(points):
        begin = process_time()
        run_many(scene, {parameter: [value * (1.0 + 1e-3 * k) for k in range(points)]}, threads=1, verify=False)
        return process_time() - begin

    seconds(2)
    stepping = min(run(scene, in_process=True).info.timing.cpu for _ in range(5))
    row = (seconds(POINTS) - seconds(1)) / (POINTS - 1) - stepping
    told.target(f"a row of many runs beside its steps, `{name}`", 1e3 * row, 3.0, "ms")
    assert row < 2.0 * stepping + 0.02
