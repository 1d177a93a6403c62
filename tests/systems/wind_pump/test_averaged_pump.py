"""The pump in the mean over a turn is the mean of the pump that pulsates, for every action, rod and friction."""

import numpy as np
import pytest
from cosimo.components.wind_pump.piston_pump import PistonPump

pytestmark = pytest.mark.full

SPEED, SAMPLES = 2.0 * np.pi, 4000
OUTPUTS = ("torque", "flow", "hydraulic_power")


@pytest.mark.known_answers(PistonPump="averaged")
@pytest.mark.parametrize(
    "parameters", [{}, {"action": "double"}, {"action": "double", "rod_diameter": 0.03}, {"seal_friction.force": 300.0}]
)
def test_mean_of_a_turn(parameters):
    effects = ["leakage", *(["seal_friction"] if "seal_friction.force" in parameters else [])]
    given = {"head": 17.0, "speed": SPEED, **parameters}
    pulsating, mean = PistonPump(effects, given), PistonPump([*effects, "averaged"], given)
    pulsating.initialize(0.0)
    mean.initialize(0.0)
    total = np.zeros(3)
    for k in range(SAMPLES):
        pulsating.step(k / SAMPLES, 1.0 / SAMPLES)
        total += [pulsating[n] for n in OUTPUTS]
    # trapezoids over whole periods of a function with kinks: (2 pi / samples)² / 12
    assert total / SAMPLES == pytest.approx([mean[n] for n in OUTPUTS], rel=1e-6)


def test_seals_and_water_are_all_the_mean_pump_takes():
    """Energy of a turn: weight of the water times the head, and the force of the seals along four times the crank's radius."""
    pump = PistonPump(["seal_friction", "averaged"], {"head": 20.0, "speed": SPEED, "seal_friction.force": 100.0})
    pump.initialize(0.0)
    water = 0.25 * np.pi * 0.06**2 * 0.15 * 1000.0 * 9.81 * 20.0
    assert 2.0 * np.pi * pump["torque"] == pytest.approx(water + 100.0 * 2.0 * 0.15, rel=1e-12)
