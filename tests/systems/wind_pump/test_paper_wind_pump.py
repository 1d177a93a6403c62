"""The paper of the wind pump: its equations against integrals and differences of another kind."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.curves import CURVES, torque_coefficient
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.plant import K1, K2, Plant, farm, heier
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.sizes import GEARS, best_gear, crossings, gain
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


@pytest.mark.parametrize("gear", [2.9455, 8.487])
def test_the_gears_at_which_the_converter_begins_to_win_and_to_lose(gear):
    """Equilibria in closed form: T(w) w = T_L w2 is a cubic in the turbine's speed; Rayleigh's integral by quadrature."""
    load, mean, area = 13.2435, 4.0, math.pi * 1.5**2
    stalled = math.sqrt(load / K1) / gear  # rad/s of the turbine, below which the pump stands

    def coefficient(v):
        blow = 0.5 * 1.225 * area * 1.5 * v**2 * 0.5
        pump = load * K1 * gear / K2  # load times w2 = pump w - other / w
        other = load**2 / (K2 * gear)
        roots = np.roots([-blow * 1.5 / (2.4 * v), blow - pump, 0.0, other])
        speed = max((r.real for r in roots if abs(r.imag) < 1e-9 and r.real > stalled), default=stalled)
        return (pump * speed - other / speed) / (0.5 * 1.225 * area * v**3)

    def energy(share):
        scale = 2.0 * mean / math.sqrt(math.pi)
        density = lambda v: 2.0 * v / scale**2 * math.exp(-((v / scale) ** 2))  # noqa: E731
        below = quad(lambda v: density(v) * v**3 * share(v), 1e-3, 2.0 * mean, limit=400, points=[1.5 * stalled / 2.4])[0]
        return below + math.exp(-((2.0 * mean / scale) ** 2)) * (2.0 * mean) ** 3 * share(2.0 * mean)

    best = max(energy(lambda v, b=b: BEST * 4.0 * (u := min(b / v, 1.0) ** 2) * (1.0 - u)) for b in np.linspace(3.2, 4.6, 29))
    assert energy(coefficient) / best == pytest.approx(1.0, abs=3e-3)


def test_crossings_of_a_gain():
    assert crossings(np.array([0.0, 0.9, 1.1, 2.0, 1.1, 0.9])) == pytest.approx((math.sqrt(2.8 * 3.2), math.sqrt(8.0 * 9.0)))
    assert all(map(math.isnan, crossings(np.full(len(GEARS), 2.0))))


def test_the_best_gear_of_a_site_is_a_maximum_and_beats_the_best_fixed_ratio():
    """By the equilibria: gears beside it give less; the default gear at 4 m/s is one that wins, gear 2 one that loses."""
    best = best_gear(4.0, 20.0)
    top = gain(best, 20.0, 4.0)
    assert top > max(gain(0.9 * best, 20.0, 4.0), gain(1.1 * best, 20.0, 4.0))
    assert top > gain(6.0, 20.0, 4.0) > 1.2
    assert gain(2.0, 20.0, 4.0) < 0.6


@pytest.mark.parametrize("lever", [10.0, 40.0])
def test_a_lever_changes_both_constants_of_the_converter(lever):
    """2 / pi rho m a b r and 2 / pi rho² (m b² + m_y), of the defaults: rho 0.05, r 0.05 m, a 2, b 1, m_y 0.25 kg."""
    plant = Plant(farm, 6.0, 2.4, lever=lever)
    assert plant.k1 == pytest.approx(2.0 / math.pi * 0.05 * lever * 2.0 * 0.05, rel=1e-12)
    assert plant.k2 == pytest.approx(2.0 / math.pi * 0.05**2 * (lever + 0.25), rel=1e-12)
