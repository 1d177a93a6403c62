"""The paper of the two links: the ratio at which modes decouple, deployment and linkage in other ways."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems.two_axis_joint.cases.paper_two_links.applications import PANELS, jaw_pose, turned_hub
from cosimo.orchestrator.systems.two_axis_joint.cases.paper_two_links.special_case import CHAINS, decoupling, matrices, modes
from scipy.integrate import solve_ivp
from scipy.linalg import expm


@pytest.mark.parametrize("name", CHAINS)
def test_dampers_of_the_special_case_are_rayleighs_with_a_negative_share_of_the_mass(name):
    mass, stiffness = matrices(name)
    d2 = 0.3
    d1 = decoupling(mass, stiffness) * d2
    damping = np.array([[d1 + d2, -d2], [-d2, d2]])
    mu = -d2 / mass[0, 1]
    nu = (damping[1, 1] - mu * mass[1, 1]) / stiffness[1, 1]
    np.testing.assert_allclose(damping, mu * mass + nu * stiffness, rtol=1e-12, atol=1e-12)
    _, shapes = modes(name)
    assert abs((shapes.T @ damping @ shapes)[0, 1]) < 1e-12
    np.testing.assert_allclose(shapes.T @ mass @ shapes, np.eye(2), atol=1e-12)


def test_another_ratio_couples_the_modes():
    mass, _ = matrices("equal rods")
    _, shapes = modes("equal rods")
    coupled = shapes.T @ np.array([[2.0, -1.0], [-1.0, 1.0]]) @ shapes  # ratio 1 instead of 4/3
    assert abs(coupled[0, 1]) > 0.1
    assert mass[0, 1] == 0.5


def test_undamped_panel_is_the_cosine_of_its_spring_and_friction():
    panel = PANELS["panel"]
    w, rest = math.sqrt(panel.stiffness / panel.inertia), math.pi - panel.friction / panel.stiffness
    time, rate = panel.at_stop()
    assert time == pytest.approx(math.acos(1.0 - 0.5 * math.pi / rest) / w, rel=1e-9)
    assert rate == pytest.approx(rest * w * math.sin(w * time), rel=1e-9)


def test_damped_panel_is_the_matrix_exponential():
    panel = PANELS["damped wing"]
    matrix = np.array([[0.0, 1.0], [-panel.stiffness / panel.inertia, -panel.damping / panel.inertia]])
    rest = math.pi - panel.friction / panel.stiffness
    time, rate = panel.at_stop()
    assert expm(matrix * time) @ [-rest, 0.0] == pytest.approx([0.5 * math.pi - rest, rate], rel=1e-7)


def test_a_free_hub_turns_as_the_momentum_of_two_bodies_says():
    """Positions of both bodies about their common centre, stepped by the hinge's rate alone."""
    hub, panel, inertia, own, arm, centre = 100.0, 5.0, 10.0, 5.0 * 0.64 / 12.0, 0.5, 0.4

    def rate(t, x):  # hinge's angle is pi - t, its rate -1; the hub's rate makes the angular momentum zero
        relative = math.pi - t

        def momentum(w):
            a, b = np.array([0.0, -1.0]), np.array([math.sin(relative), -math.cos(relative)])  # hub at angle 0
            between = arm * a + centre * b
            va, vb = arm * w * np.array([1.0, 0.0]), centre * (w - 1.0) * np.array([math.cos(relative), math.sin(relative)])
            moved = va + vb
            series = hub * panel / (hub + panel)
            return inertia * w + own * (w - 1.0) + series * (between[0] * moved[1] - between[1] * moved[0])

        slope = momentum(1.0) - momentum(0.0)
        return [-momentum(0.0) / slope]

    turned = solve_ivp(rate, (0.0, 0.5 * math.pi), [0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert turned_hub(5.0, 0.8, 100.0, 10.0, 0.5) == pytest.approx(turned, rel=1e-8)


def test_the_crushers_linkage_closes():
    for angle in np.linspace(0.0, 6.0, 13):
        swing, x, y = jaw_pose(float(angle))
        assert math.hypot(x + 0.45, y + 0.815) == pytest.approx(0.455)
        base = 0.012 * math.sin(angle), -0.012 * math.cos(angle)
        assert (x, y) == pytest.approx((base[0] + 1.085 * math.sin(swing), base[1] - 1.085 * math.cos(swing)))
