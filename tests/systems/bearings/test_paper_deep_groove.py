"""The paper of the deep groove bearing: its measures against closed forms and an independent equilibrium."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems.bearings.cases.paper_deep_groove import clearance, defects, shaft, waviness
from scipy.optimize import brentq, root


def test_frequencies_without_clearance_are_the_closed_form_of_many_balls():
    """K_0 and K_2 of a load zone cos^(1/2) over half the circumference; the deflection from the mean of cos^2.5."""
    balls = 40
    theta = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 20001)
    width = theta[1] - theta[0]
    deflection = (2.0 * math.pi / (balls * (np.cos(theta) ** 2.5).sum() * width)) ** (2.0 / 3.0)
    stiffness = 1.5 * balls / (2.0 * math.pi) * math.sqrt(deflection) * np.sqrt(np.maximum(np.cos(theta), 0.0)) * width
    along, across = shaft.over_a_pitch(0.0, balls, angles=3).mean(axis=0)
    assert along == pytest.approx(math.sqrt((stiffness * np.cos(theta) ** 2).sum()), rel=2e-3)
    assert across == pytest.approx(math.sqrt((stiffness * np.sin(theta) ** 2).sum()), rel=5e-3)
    assert along / across == pytest.approx(math.sqrt(1.5), rel=5e-3)


@pytest.mark.parametrize("gap", [-1.0, 1.0])
def test_linearisation_is_that_of_an_equilibrium_by_another_solver(gap):
    at = 0.13
    theta = at + 2.0 * math.pi * np.arange(9) / 9

    def loads(q):
        delta = np.maximum(q[0] * np.cos(theta) + q[1] * np.sin(theta) - gap, 0.0)
        return delta, [(delta**1.5 * np.cos(theta)).sum() - 1.0, (delta**1.5 * np.sin(theta)).sum()]

    solution = root(lambda q: loads(q)[1], [max(gap, 0.0) + 0.8, 0.01], tol=1e-13)
    assert solution.success
    delta = loads(solution.x)[0]
    along, across = (1.5 * (np.sqrt(delta) * f(theta) ** 2).sum() for f in (np.cos, np.sin))
    K = shaft.stiffness(gap, at) / (shaft.STIFFNESS * math.sqrt(shaft.LENGTH))
    assert [K[1, 1], K[0, 0]] == pytest.approx([along, across], rel=1e-6)


def test_two_balls_carry_by_statics_alone():
    along, across = clearance.two_balls(9)
    assert (along, across) == pytest.approx((1.4214, 0.5134), abs=1e-4)  # the numbers of the table
    pitch = 2.0 * math.pi / 9
    a = 0.3 * pitch
    gap, deep = 10.0, np.cbrt(np.array([math.sin(0.7 * pitch), math.sin(a)]) / math.sin(pitch)) ** 2
    middle = np.linalg.solve([[math.cos(-a), math.sin(-a)], [math.cos(0.7 * pitch), math.sin(0.7 * pitch)]], gap + deep)
    K = shaft.stiffness(gap, -a) / (shaft.STIFFNESS * math.sqrt(shaft.LENGTH))
    expected = 1.5 * (np.sqrt(deep) * np.cos([a, 0.7 * pitch]) ** 2).sum()
    assert K[1, 1] == pytest.approx(expected, rel=1e-6)
    assert middle @ [1.0, 0.0] > gap


def test_amplitudes_of_the_table_are_those_of_the_load_zone():
    """K_n of cos^(1/2): the closed form of the waves, computed here by quadrature."""
    theta = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 40001)
    zone = np.sqrt(np.maximum(np.cos(theta), 0.0))
    K = [(2.0 if n else 1.0) * (zone * np.cos(n * theta)).sum() for n in range(7)]
    for order in (2, 3, 4):
        along = abs(K[order - 1] + K[order + 1]) / (2.0 * K[0] + K[2])
        across = abs(K[order - 1] - K[order + 1]) / (2.0 * K[0] - K[2])
        assert waviness.ALONG_ACROSS["along"][order] == pytest.approx(along, abs=2e-4)
        assert waviness.ALONG_ACROSS["across"][order] == pytest.approx(across, abs=2e-4)


def test_clearness_of_a_line_in_noise():
    f = np.arange(4000) * defects.BIN
    a = np.ones(4000)
    a[400] = 100.0
    assert defects.clearness(f, a, 400 * defects.BIN) == pytest.approx(40.0, abs=0.5)


def test_lines_of_the_pits_are_kinematics():
    ratio = 9.525 / 46.0
    rows = {r.measure: r for r in load_table("paper-deep-groove").rows}
    for race, sign in (("outer", -1.0), ("inner", 1.0)):
        row = rows[f"{race}.line"]
        assert row.low < 4.5 * (1.0 + sign * ratio) < row.high


def test_axial_preload_is_in_equilibrium():
    given = shaft.scene(0.1, 1e-4, 1.0, gravity=0.0, axial=200.0).units["bearing"].parameters
    model = shaft.bearing(diametral_clearance=given["diametral_clearance"])
    model.initialize(0.0)
    contacts = model.arguments[0].contacts
    angle = lambda z: math.atan2(z, contacts.radial)  # noqa: E731

    def axial(z):
        delta = max(math.hypot(contacts.radial, contacts.axial + z) - contacts.distance, 0.0)
        return 9 * contacts.stiffness * delta**1.5 * math.sin(angle(contacts.axial + z)) - 200.0

    assert given["displacement_z"] == pytest.approx(brentq(axial, 1e-7, 1e-3), rel=1e-6)
