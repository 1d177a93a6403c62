"""Friction of oil against the equations written in the units of their sources, and a steady state against SciPy."""

import math

import numpy as np
import pytest
from cosimo import load_scene
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.temperatures import BearingTemperatures
from cosimo.orchestrator.run.run import run as run_scene
from scipy.optimize import brentq


def viscosity(kelvin: float, cold: float = 68.0, hot: float = 8.7) -> float:
    """mm²/s: the straight line of lg lg(nu + 0.7) over lg T."""
    slope = np.polyfit(np.log10([313.15, 373.15]), np.log10(np.log10([cold + 0.7, hot + 0.7])), 1)
    return float(10.0**10.0 ** np.polyval(slope, math.log10(kelvin)) - 0.7)


def torque(load: float, speed: float, kelvin: float) -> float:
    """N.m, by way of rpm, mm and N.mm; f_0 = 2, f_1 = 3e-4."""
    rpm, diameter = abs(speed) * 30.0 / math.pi, 53.5
    return 1e-3 * (1e-7 * 2.0 * max(viscosity(kelvin) * rpm, 2000.0) ** (2.0 / 3.0) * diameter**3 + 3e-4 * load * diameter)


def resultant(bearing: DeepGrooveBearing) -> float:
    """N."""
    return math.hypot(*(bearing[f"force_{axis}"] for axis in "xyz"))


@pytest.mark.interpreted
@pytest.mark.known_answers(DeepGrooveBearing="oil_friction")
@pytest.mark.parametrize("speed", [-300.0, 0.5, 300.0])
@pytest.mark.parametrize("kelvin", [253.15, 313.15, 393.15])
def test_the_torque_is_that_of_the_equations(speed, kelvin):
    bearing = DeepGrooveBearing(
        ["friction", "oil_friction"], {"displacement_y": -2e-5, "speed": speed, "oil_friction.temperature": kelvin}
    )
    bearing.initialize(0.0)
    expected = torque(resultant(bearing), speed, kelvin)
    assert bearing["friction.torque"] == pytest.approx(-math.copysign(expected, speed), rel=1e-12)
    assert bearing["friction.power"] == pytest.approx(expected * abs(speed), rel=1e-12)
    assert bearing["oil_friction.viscosity"] == pytest.approx(1e-6 * viscosity(kelvin), rel=1e-12)


def test_heat_and_friction_come_to_rest_together():
    scene = load_scene("bearing-oil-heat").with_changes({"stop_time": 20000.0})
    result = run_scene(scene, in_process=True)
    heat, loads = BearingTemperatures(), []
    for first in np.linspace(0.0, 2.0 * math.pi / 9.0, 50, endpoint=False):  # balls pass; their heat is that of the mean
        bearing = DeepGrooveBearing((), {"displacement_y": -2e-5, "first_ball": first}, preset="6207-like")
        bearing.initialize(0.0)
        loads.append(resultant(bearing))
    load = float(np.mean(loads))
    conductances = [heat.get("shaft_conductance"), 2.0 * 0.2, 2.0 * 0.2, heat.get("ambient_conductance")]

    def rest(power: float) -> np.ndarray:  # K, of inner ring, balls, outer ring
        shaft, inner, outer, ambient = conductances
        matrix = [[shaft + inner, -inner, 0.0], [-inner, inner + outer, -outer], [0.0, -outer, outer + ambient]]
        return 293.15 + np.linalg.solve(matrix, power * np.array([0.25, 0.5, 0.25]))

    speed = 314.1592653589793
    balls = brentq(lambda kelvin: rest(torque(load, speed, kelvin) * speed)[1] - kelvin, 293.15, 500.0, xtol=1e-10)
    ends = [result[f"heat.{part}_temperature"][-1] for part in ("inner", "ball", "outer")]
    assert ends == pytest.approx(rest(torque(load, speed, balls) * speed), rel=1e-5)
