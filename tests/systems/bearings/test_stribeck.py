"""Load zone: Stribeck's number and Sjövall's integrals against quadrature, closed forms, discrete sums and the static solver."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.load_zone import ball_share, load_integrals, stribeck_number
from cosimo.components.bearings.loads import static_loads
from cosimo.components.core.errors import BadInput
from cosimo.tests.systems.bearings.ring_contacts import ball_contacts
from scipy.integrate import quad
from scipy.special import beta


def discrete_sums(balls: int, epsilon: float, first: float = 0.0) -> tuple[float, float]:
    """The same means over `balls` balls, the first of them at `first` rad from the load line."""
    psi = first + 2.0 * math.pi * np.arange(balls) / balls
    share = ball_share(psi, epsilon)
    return float((share * np.cos(psi)).mean()), float(share.mean())


def test_stribeck_number_in_closed_form():
    """Jr(1/2) = (1/2 pi) integral of cos^2.5 over a half circle = B(7/4, 1/2) / (2 pi)."""
    assert stribeck_number() == pytest.approx(2.0 * math.pi / beta(1.75, 0.5), rel=1e-11)
    assert stribeck_number() == pytest.approx(4.3701, abs=5e-5)  # as printed


@pytest.mark.parametrize("epsilon", [0.01, 0.2, 0.5, 0.8, 0.999, 1.0, 1.25, 5.0])
def test_integrals_against_quadrature(epsilon):
    edge = math.acos(max(1.0 - 2.0 * epsilon, -1.0))
    found = load_integrals(epsilon)
    for value, weight in zip(found, (math.cos, lambda psi: 1.0), strict=True):
        expected = quad(lambda psi, w=weight: float(ball_share(np.array(psi), epsilon)) * w(psi), 0.0, edge, epsabs=1e-14)[0]
        assert value == pytest.approx(expected / math.pi, abs=1e-10)  # quad's own estimate


def test_limits():
    """Every ball alike: Ja -> 1, Jr -> 3 / (8 epsilon) (first order of the share, 1.5 cos(psi) / (2 epsilon))."""
    radial, axial = load_integrals(1e5)
    assert axial == pytest.approx(1.0, abs=2e-5)
    assert radial == pytest.approx(3.0 / 8e5, rel=1e-4)


def test_axial_load_that_keeps_half_the_balls_loaded():
    """Fa = Ja / Jr Fr tan(alpha) = 1.216 Fr tan(alpha) at epsilon = 1/2, a number of bearing catalogues."""
    radial, axial = load_integrals(0.5)
    assert axial / radial == pytest.approx(1.216, abs=5e-4)


@pytest.mark.parametrize(
    ("balls", "on_the_line", "midway"),
    [
        (6, 4.4328, 3.464),
        (7, 4.3373, 3.770),
        (8, 4.3457, 3.899),
        (9, 4.3852, 3.969),
        (12, 4.3645, 4.153),
        (16, 4.3681, 4.246),
        (32, 4.3699, 4.339),
        (64, 4.3701, 4.362),
    ],
)
def test_discrete_sums(balls, on_the_line, midway):
    """Z Q_max / Fr with a ball on the load line and with the line between two; independent sums, printed digits."""
    assert 1.0 / discrete_sums(balls, 0.5)[0] == pytest.approx(on_the_line, abs=6e-5)
    half = math.pi / balls
    largest = float(ball_share(np.array(half), 0.5)) / discrete_sums(balls, 0.5, half)[0]
    assert largest == pytest.approx(midway, abs=6e-4)


@pytest.mark.parametrize("clearance", [0.0, 15e-6])
def test_the_static_solver_distributes_a_load_as_the_sums_say(clearance):
    """Rigid rings, plane motion: Z Q_max / Fr and each ball's share follow from epsilon = (1 - c / (2 delta_r)) / 2."""
    geometry = BallGeometry(16, 0.0111, 0.0935)
    contacts = ball_contacts(geometry, 1.1e10, clearance)
    found = static_loads(contacts, np.array([2000.0, 0.0, 0.0, 0.0, 0.0]))
    epsilon = 0.5 * (1.0 - 0.5 * clearance / found.displacement[0])
    psi = 2.0 * np.pi * np.arange(16) / 16
    largest = found.ball_loads.max()
    np.testing.assert_allclose(found.ball_loads, largest * ball_share(psi, epsilon), rtol=1e-7, atol=1e-7 * largest)
    assert largest * 16.0 / 2000.0 == pytest.approx(1.0 / discrete_sums(16, epsilon)[0], rel=1e-7)


def test_many_balls_tend_to_the_integral():
    contacts = ball_contacts(BallGeometry(180, 1e-3, 0.0635), 1e9)
    found = static_loads(contacts, np.array([1000.0, 0.0, 0.0, 0.0, 0.0]))
    # the sums converge with the power 2.5 of the spacing at the edges of the load zone: (2 / 180)^2.5 is 1e-5
    assert found.ball_loads.max() * 180.0 / 1000.0 == pytest.approx(4.3701, rel=2e-5)


@pytest.mark.parametrize("epsilon", [0.0, -1.0, float("nan")])
def test_an_empty_load_zone_is_refused(epsilon):
    with pytest.raises(BadInput):
        load_integrals(epsilon)
