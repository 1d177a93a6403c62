"""The new measures of the paper's case against independent answers."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems.railway.cases.paper_pantograph import lumped, table
from cosimo.orchestrator.systems.railway.cases.paper_pantograph.lumped import SPAN, STIFFNESS, impedance, relative_deviation

pytestmark = pytest.mark.interpreted


@pytest.mark.parametrize(("speed", "z"), [(250.0, complex(-1102, 931)), (300.0, complex(-1669, 1345))])
def test_the_impedance_is_that_of_another_program(speed, z):
    assert impedance(speed).real == pytest.approx(z.real, abs=1.0)
    assert impedance(speed).imag == pytest.approx(z.imag, abs=1.0)


@pytest.mark.parametrize(("speed", "value"), [(160.0, 0.174), (200.0, 0.285), (250.0, 0.510), (300.0, 0.840), (350.0, 1.070)])
def test_the_first_order_is_that_of_another_program(speed, value):
    assert relative_deviation(speed) == pytest.approx(value, abs=6e-4)


def test_the_closed_form_solves_the_equations_of_motion():
    """Head, frame, contact spring and what is left of the wire as a linear system at one frequency, term by term."""
    speed, a, mean = 250.0, 1.0, 1.0
    w = 2.0 * math.pi * speed / 3.6 / SPAN
    k1, c1, k2, c2, kc, m, c = 4200.0, 10.0, 50.0, 90.0, 50e3, 0.1, 2.0
    s = 1j * w
    # unknowns: heights of head, frame and wire; the stiffness' swing acts on the mean height of the wire, mean / k0
    A = np.array(
        [
            [7.2 * s * s + k1 + c1 * s + kc, -(k1 + c1 * s), -kc],
            [-(k1 + c1 * s), 15.0 * s * s + (c1 + c2) * s + k1 + k2, 0.0],
            [-kc, 0.0, m * s * s + c * s + STIFFNESS + kc],
        ]
    )
    head, _, wire = np.linalg.solve(A, np.array([0.0, 0.0, -a * mean]))
    assert abs(kc * (head - wire)) / math.sqrt(2.0) == pytest.approx(relative_deviation(speed, whole=True), rel=1e-12)


def test_variants_are_the_ones_of_the_predictions():
    assert table.VARIANTS["softer, dropper term 0.15"][1][table.DROPPER - 1] == 0.15
    assert lumped.SPEEDS == (160.0, 200.0, 250.0, 300.0, 350.0)
