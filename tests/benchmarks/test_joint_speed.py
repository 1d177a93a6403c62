"""Double pendulum and gimbal against SciPy's DOP853 on the same equations in Python, both at an error of 1e-9."""

import math
import time

import numpy as np
import pytest
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from scipy.integrate import solve_ivp

ERROR = 1e-9  # rad, at the end
END = 5.0  # s
REPEATS = 7
LEAST = 10.0  # times faster


def double_pendulum(t, x):
    """Two uniform rods of 1 kg and 1 m that hang; x: both absolute angles and rates."""
    first, second, w1, w2 = x
    difference = first - second
    m11, m22, m12 = 4.0 / 3.0, 1.0 / 3.0, 0.5 * math.cos(difference)
    coupling = 0.5 * math.sin(difference)
    b1 = -coupling * w2 * w2 - 1.5 * 9.81 * math.sin(first)
    b2 = coupling * w1 * w1 - 0.5 * 9.81 * math.sin(second)
    determinant = m11 * m22 - m12 * m12
    return w1, w2, (m22 * b1 - m12 * b2) / determinant, (m11 * b2 - m12 * b1) / determinant


def gimbal(t, x):
    """The governor's body about a vertical outer axis, without torques; x: outer and inner angle and their rates."""
    _, inner, outer_rate, inner_rate = x
    sine, cosine = math.sin(inner), math.cos(inner)
    turning = 0.04 * sine * cosine * outer_rate
    inertia = 0.02 + 0.06 * sine * sine + 0.02 * cosine * cosine
    return outer_rate, inner_rate, -2.0 * turning * inner_rate / inertia, (turning * outer_rate - 2.943 * sine) / 0.06


def chain_component(substep):
    given = {"start_first_angle": 1.2, "start_second_angle": 0.7, "substep": substep}
    return TwoLinkChain(("high_order",), given, preset="equal rods")


def gimbal_component(substep):
    given = {"start_inner_angle": 0.9, "start_outer_rate": 12.0, "substep": substep}
    return GimbalBody(("high_order",), given, preset="governor")


def angles(component):
    """Both angles at the end of one step over the whole time, and the shortest of several times it took, s."""
    seconds = []
    for _ in range(REPEATS):
        component.initialize(0.0)
        start = time.perf_counter()
        component.step(0.0, END)
        seconds.append(time.perf_counter() - start)
    return component.y[:2].copy(), min(seconds)


@pytest.mark.parametrize(("name", "make", "equations", "start"), [
    ("double pendulum", chain_component, double_pendulum, (1.2, 0.7, 0.0, 0.0)),
    ("gimbal", gimbal_component, gimbal, (0.0, 0.9, 12.0, 0.0)),
])  # fmt: skip
def test_ten_times_faster_at_equal_error(name, make, equations, start, told):
    """Each side with the loosest of its settings that reaches the error: substeps in fifths, tolerances in thirds of a decade."""

    def solved(tolerance):
        begin = time.perf_counter()
        found = solve_ivp(equations, (0.0, END), start, method="DOP853", rtol=tolerance, atol=tolerance)
        return found.y[:2, -1], time.perf_counter() - begin

    exact, _ = solved(1e-13)
    tolerance = next(t for t in 10.0 ** -np.arange(8.0, 13.0, 1.0 / 3.0) if np.abs(solved(t)[0] - exact).max() < ERROR)
    theirs = min(solved(tolerance)[1] for _ in range(REPEATS))
    substep = next(s for s in 5e-2 * 0.8 ** np.arange(20) if np.abs(angles(make(s))[0] - exact).max() < ERROR)
    ours = angles(make(substep))[1]
    told("links", f"{name}, {END:g} s to {ERROR:g} rad", cosimo_ms=1e3 * ours, DOP853_ms=1e3 * theirs, ratio=theirs / ours)
    assert theirs / ours >= LEAST
