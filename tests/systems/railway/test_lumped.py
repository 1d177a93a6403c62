"""The lumped catenary: statics, forced oscillation, the fit to a distributed one."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.lumped import HARMONICS, LumpedCatenary, fit_span
from cosimo.components.railway.statics import elasticity

pytestmark = pytest.mark.interpreted

FLAT = {f"harmonic[{n + 1}]": 0.0 for n in range(HARMONICS)}


def carried(catenary: LumpedCatenary, speed: float, force: float, seconds: float) -> np.ndarray:
    """Heights per millisecond while a constant force moves along."""
    catenary.set("contact_position", 0.0)
    catenary.set("contact_force", force)
    catenary.initialize(0.0)
    heights = []
    for i in range(round(seconds / 1e-3)):
        column = catenary.input_positions(["contact_position"])[0]
        catenary.u[:, column] = speed * i * 1e-3, speed, 0.0
        catenary.step(i * 1e-3, 1e-3)
        heights.append(catenary["wire_height"])
    return np.array(heights)


@pytest.mark.full
def test_fit_gives_back_the_elasticity_of_the_distributed_catenary():
    distributed = Catenary(["dropper_slackening"], {"spans": 5, "method": "implicit", "first_watched_support": 0})
    distributed.initialize(0.0)
    lumped = LumpedCatenary.from_line(distributed, 120.0)
    x = np.linspace(0.0, 60.0, 61)
    exact = 1.0 / elasticity(distributed.mesh, 120.0 + x, 120.0)
    ratio = []
    for position, k in zip(x, exact, strict=True):
        lumped.set("contact_position", position)
        lumped.set("contact_force", 120.0)
        lumped.initialize(0.0)
        assert lumped["wire_height"] == pytest.approx(120.0 / lumped["wire_stiffness"], rel=1e-12)
        ratio.append(lumped["wire_stiffness"] / k - 1.0)
    # the elasticity has kinks at the droppers, sharpest at the first and the last one, which ten harmonics cannot follow
    assert np.sqrt(np.mean(np.square(ratio))) < 0.03
    assert np.abs(ratio)[20:41].max() < 0.03
    # the defaults of the class are this fit
    assert lumped.parameters["mean_stiffness"] == pytest.approx(LumpedCatenary().parameters["mean_stiffness"], rel=1e-3)


def test_fit_says_what_a_series_cannot_follow():
    """A span with droppers to one side only: the odd part of its stiffness is named, and its own fit is worse for it."""
    even, odd = ((3.0, 6.0, 9.0), (2.0, 4.0, 6.0))
    fits = []
    for within in (even, odd):
        parameters = {f"dropper_position[{i + 1}]": x for i, x in enumerate(within)}
        line = Catenary(
            (), {"spans": 3, "span_length": 12.0, "droppers": 3, "element": 2.0, "first_watched_support": 0} | parameters
        )
        line.initialize(0.0)
        fits.append(fit_span(line, 100.0))
        assert fits[-1].parameters["span_length"] == 12.0
        assert fits[-1].parameters["mass"] == pytest.approx(1.35 * (within[1] - within[0]))
        assert fits[-1].parameters["damping"] == pytest.approx(2.0 * np.sqrt(20e3 * 1.35))
    assert fits[0].asymmetry < 1e-6
    assert fits[1].asymmetry > 0.3
    assert fits[1].rms > fits[0].rms


@pytest.mark.parametrize(("spans", "span", "force"), [(2, None, 100.0), (3, 1, 100.0), (3, 3, 100.0), (3, None, 0.0)])
def test_a_span_that_cannot_be_fitted_is_refused(spans, span, force):
    line = Catenary((), {"spans": spans, "element": 30.0, "first_watched_support": 0})
    line.initialize(0.0)
    with pytest.raises(BadInput, match="expected"):
        LumpedCatenary.from_line(line, force, span)


def test_constant_stiffness_is_a_damped_oscillator():
    """Released from rest: the logarithmic decrement over a period is 2 pi D / sqrt(1 - D²)."""
    catenary = LumpedCatenary(parameters={**FLAT, "mean_stiffness": 3000.0, "mass": 9.0, "damping": 20.0})
    catenary.initialize(0.0)
    catenary.x[0] = 0.01
    omega0, D = np.sqrt(3000.0 / 9.0), 20.0 / (2.0 * np.sqrt(3000.0 * 9.0))
    period = 2.0 * np.pi / (omega0 * np.sqrt(1.0 - D**2))
    catenary.step(0.0, 3.0 * period)
    assert catenary["wire_height"] == pytest.approx(0.01 * np.exp(-3.0 * 2.0 * np.pi * D / np.sqrt(1.0 - D**2)), rel=1e-5)


@pytest.mark.known_answers(LumpedCatenary="inerter")
def test_mass_makes_a_forced_oscillation_that_the_inerter_does_not():
    """A constant force that creeps along follows F / k(x); one at speed does so with the inerter only, exactly."""
    x = 69.4 * 1e-3 * np.arange(1, 3001)
    with_mass = carried(LumpedCatenary(parameters={"mass": 60.0}), 69.4, 120.0, 3.0)
    inerter = LumpedCatenary(["inerter"], {"mass": 60.0})
    with_inerter = carried(inerter, 69.4, 120.0, 3.0)
    p = inerter.arguments[1]
    k = p.mean_stiffness * (1.0 + np.cos(2.0 * np.pi * x[:, None] * np.arange(1, HARMONICS + 1) / 60.0) @ p.harmonic)
    static = 120.0 / k
    assert np.abs(with_inerter - static).max() < 1e-12
    assert np.abs(with_mass - static).max() > 0.25 * np.ptp(static)
    slow = carried(LumpedCatenary(parameters={"mass": 60.0}), 0.5, 120.0, 3.0)
    x = 0.5e-3 * np.arange(1, 3001)
    k_slow = p.mean_stiffness * (1.0 + np.cos(2.0 * np.pi * x[:, None] * np.arange(1, HARMONICS + 1) / 60.0) @ p.harmonic)
    assert np.abs(slow - 120.0 / k_slow).max() < 1e-4
