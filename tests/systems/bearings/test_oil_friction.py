"""Friction of oil against the equations written in the units of their sources, and a steady state against SciPy."""

import math
import warnings

import numpy as np
import pytest
from cosimo import BadInput, StepFailed, load_scene
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


SKF = ("friction", "oil_friction", "skf_friction")
B6205 = {"friction.bore_diameter": 0.025, "skf_friction.outside_diameter": 0.052, "skf_friction.static_rating": 7800.0}


def catalogue(radial: float, axial: float, speed: float, kelvin: float) -> float:
    """N.m by SKF's catalogue, in its units: 6205, d = 25, D = 52, C_0 = 7.8 kN, low oil bath of mineral oil."""
    d, outside, n, nu = 25.0, 52.0, abs(speed) * 30.0 / math.pi, viscosity(kelvin)
    dm = 38.5
    if axial == 0.0:
        g_rr, g_sl = 3.9e-7 * dm**1.96 * radial**0.54, 3.23e-3 * dm**-0.26 * radial ** (5 / 3)
    else:
        alpha = np.deg2rad(24.6 * (axial / 7800.0) ** 0.24)
        g_rr = 3.9e-7 * dm**1.96 * (radial + 1.7 * axial / np.sin(alpha)) ** 0.54
        g_sl = 3.23e-3 * dm**-0.145 * np.cbrt(radial**5 + 36.5 * dm**1.5 / np.sin(alpha) * axial**4)
    ish = 1.0 / (1.0 + 1.84e-9 * (n * dm) ** 1.28 * nu**0.64)
    rs = 1.0 / np.exp(3e-8 * nu * n * (d + outside) * np.sqrt(3.1 / (2.0 * (outside - d))))
    bl = 1.0 / np.exp(2.6e-8 * (n * nu) ** 1.4 * dm)
    return 1e-3 * (ish * rs * g_rr * (nu * n) ** 0.6 + g_sl * (0.15 * bl + 0.05 * (1.0 - bl)))


@pytest.mark.interpreted
@pytest.mark.known_answers(DeepGrooveBearing="skf_friction")
@pytest.mark.parametrize("speed", [-300.0, 0.5, 1500.0])
@pytest.mark.parametrize(("axial", "kelvin"), [(0.0, 313.15), (8e-5, 353.15)])
def test_the_torque_is_that_of_the_catalogue(speed, axial, kelvin):
    given = {"displacement_y": -2e-5, "displacement_z": axial, "speed": speed, "oil_friction.temperature": kelvin}
    bearing = DeepGrooveBearing(SKF, B6205 | given, preset="6205")
    bearing.initialize(0.0)
    radial, along = math.hypot(bearing["force_x"], bearing["force_y"]), abs(bearing["force_z"])
    assert (along > 100.0) == (axial > 0.0)
    expected = catalogue(radial, along, speed, kelvin)
    assert bearing["friction.torque"] == pytest.approx(-math.copysign(expected, speed), rel=1e-12)
    assert bearing["friction.power"] == pytest.approx(expected * abs(speed), rel=1e-12)


def stepped(**given: float) -> list[str]:
    """What two steps of a 6205 at 3000 rpm have to say."""
    given = {name.replace("__", "."): value for name, value in given.items()}
    bearing = DeepGrooveBearing(SKF, B6205 | {"speed": 100.0 * math.pi} | given, preset="6205")
    bearing.initialize(0.0)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for k in range(2):
            bearing.step(k * 1e-4, 1e-4)
    return [str(w.message) for w in told]


@pytest.mark.interpreted
def test_loads_against_the_catalogues_advice_are_told_once():
    least = 0.025e3 * (0.068 * 3000.0) ** (2 / 3) * 0.385**2  # N, by hand: k_r = 0.025, 68 mm²/s, 3000 rpm, dm = 38.5 mm
    assert least == pytest.approx(128.4, abs=0.1)
    (light,) = stepped(displacement_y=-1e-6)
    assert f"SKF advises {least:.4g} N or more" in light
    assert stepped(displacement_y=-1e-6, skf_friction__minimum_factor=0.0) == []
    assert stepped(displacement_y=-1e-5) == []
    (axial,) = stepped(displacement_z=1.3e-4, skf_friction__static_rating=2000.0)
    assert "SKF advises at most 1000 N" in axial
    assert stepped(displacement_z=1.3e-4, skf_friction__static_rating=2000.0, skf_friction__axial_share=3.0) == []


@pytest.mark.interpreted
def test_an_axial_load_beyond_the_catalogues_angle_and_rings_of_another_bearing_are_refused():
    with pytest.raises(StepFailed, match=r"below 222 C_0.*Give the static rating in N"):
        stepped(displacement_z=1.3e-4, skf_friction__static_rating=7.8)
    with pytest.raises(BadInput, match=r"rings inside and outside of balls of 0\.00794 m"):
        stepped(friction__bore_diameter=0.035)


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
