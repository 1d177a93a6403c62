"""The paper of the wind pump: its equations against integrals and differences of another kind."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.curves import CURVES, torque_coefficient
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.plant import K1, K2, Plant, farm, heier
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.stresses import constant_damage, torsion
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.water import BEST, energy
from scipy.integrate import quad, solve_ivp
from scipy.special import gamma, gammaincc


@pytest.mark.parametrize(("name", "curve"), [("farm", farm), ("heier", heier)])
def test_curves_are_those_of_the_turbine(name, curve):
    kernel = getattr(torque_coefficient, "py_func", torque_coefficient)
    for ratio in (0.1, 1.0, 3.0, 8.0, 13.0):
        assert curve(ratio) == pytest.approx(kernel(CURVES.index(name), ratio, 0.0, 0.5, 2.4), abs=1e-14)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_growth_is_that_of_an_integration(which):
    """Three equilibria in one wind; the middle one leaves, and each at the rate of its eigenvalue."""
    plant = Plant(heier, 1.0, 14.0)
    points = plant.equilibria(7.0, 6.0)
    assert len(points) == 3
    at = np.array(points[which])

    def rates(t, x):
        torque = K1 * x[0] ** 2 - K2 * x[0] * x[1]
        return [(plant.turbine_torque(x[0], 7.0) - torque * x[1] / x[0]) / 15.0, torque - 6.0]

    assert np.abs(rates(0.0, at)).max() < 1e-9
    values, vectors = np.linalg.eig(plant.matrix(7.0, *at))
    k = int(values.real.argmax())
    push = 1e-4 * vectors[:, k].real
    span = 20.0
    end = solve_ivp(rates, (0.0, span), at + push, rtol=1e-11, atol=1e-13).y[:, -1] - at
    grown = math.log(float(np.linalg.norm(end) / np.linalg.norm(push))) / span
    assert grown == pytest.approx(plant.growth(7.0, *at), rel=2e-2, abs=1e-4)
    assert (grown > 0.0) == (which == 1)


def test_determinant_in_closed_form():
    plant = Plant(farm, 6.0, 2.4, (8.0, 0.5))
    for wind in (2.0, 4.0, 9.0):
        (at,) = plant.equilibria(wind, 13.2435)
        assert plant.determinant(wind, *at) == pytest.approx(4.0 * np.linalg.det(plant.matrix(wind, *at)), rel=1e-6)


@pytest.mark.parametrize("shape", [1.5, 2.0, 3.0])
def test_energy_of_a_fixed_ratio_is_the_closed_form_with_incomplete_gamma_functions(shape):
    balanced, mean = 0.9, 1.0
    s = balanced / (mean / gamma(1.0 + 1.0 / shape))

    def upper(a):  # a may be negative
        z = s**shape
        return gammaincc(a, z) * gamma(a) if a > 0.0 else quad(lambda t: t ** (a - 1.0) * math.exp(-t), z, np.inf)[0]

    closed = 4.0 * s**2 * (upper(1.0 + 1.0 / shape) - s**2 * upper(1.0 - 1.0 / shape)) / gamma(1.0 + 3.0 / shape)

    def coefficient(v):
        u = (balanced / np.maximum(v, balanced)) ** 2
        return BEST * 4.0 * u * (1.0 - u)

    ideal = energy(lambda v: BEST + 0.0 * v, mean, shape, None)
    assert energy(coefficient, mean, shape, None) / ideal == pytest.approx(closed, rel=2e-5)


def test_torsion_of_a_shaft():
    radius = 0.01
    torque = quad(lambda r: r * 2.0 * math.pi * r**2, 0.0, radius)[0]  # of a stress that is the radius in numbers
    assert torsion(torque, 20.0) == pytest.approx(radius * 1e-6, rel=1e-9)
    assert constant_damage(20.0) / constant_damage(40.0) == pytest.approx(2.0**15)
