"""A program runs along its straight line, there and back, and refuses to go back before it has arrived."""

import numpy as np
import pytest
from cosimo.components.pipe_robot.program import ExciterProgram

pytestmark = pytest.mark.interpreted

GIVEN = {"start_frequency": 40.0, "end_frequency": 100.0, "start_amplitude": 5.0, "end_amplitude": 5.0, "start_voltage": 20.0,
         "end_voltage": 0.0, "start_time": 1.0, "duration": 4.0, "return_time": 6.0}  # fmt: skip


def test_there_and_back_along_straight_lines():
    program = ExciterProgram(parameters=GIVEN)
    program.initialize(0.0)
    outputs = [program.y.copy()]
    for k in range(24):
        program.step(0.5 * k, 0.5)
        outputs.append(program.y.copy())
    t = np.linspace(0.0, 12.0, 25)
    share = np.interp(t, [1.0, 5.0, 6.0, 10.0], [0.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(outputs, np.stack([40.0 + 60.0 * share, 5.0 + 0.0 * t, 20.0 - 20.0 * share], axis=1), rtol=1e-14)
