"""Ball loads and statics against another formulation, closed forms, a published solver, and two common mistakes of the field."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.contacts import ENERGY, LOAD, LOADED, BallContacts, contact_forces, place_balls
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.hertz import effective_modulus
from cosimo.components.bearings.loads import static_loads
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE, OUT_OF_RANGE
from cosimo.tests.systems.bearings.ring_contacts import ball_contacts

pytestmark = pytest.mark.interpreted

STEEL = effective_modulus(2.1e11, 0.3, 2.1e11, 0.3)
ISO = BallGeometry(7, 11.5e-3, 43.5e-3, 0.52, 0.53)  # the example of the public ISO/TS 16281 code
BALANCED = 1e-8  # of the load; the solver ends at 1e-10


def iso_forces(q, geometry, stiffness, clearance, first=0.0):
    """Force and moment that displace the inner ring by q, as ISO/TS 16281 writes them, for tilts about two axes.

    In its terms (ri, re, A, phi, alpha), z counted from the middle between both shoulders. One thing is not as there: the
    moment has the lever of the tilts, not half the pitch diameter.
    """
    d, dm = geometry.ball_diameter, geometry.pitch_diameter
    ri, re = geometry.inner_conformity * d, geometry.outer_conformity * d
    A = ri + re - d
    radial0 = A - 0.5 * clearance  # A times the cosine of the free contact angle
    R = 0.5 * dm + (ri - 0.5 * d) * radial0 / A
    phi = first + 2.0 * np.pi * np.arange(geometry.balls) / geometry.balls
    axial = q[2] + R * (q[3] * np.sin(phi) - q[4] * np.cos(phi))
    radial = radial0 + q[0] * np.cos(phi) + q[1] * np.sin(phi)
    delta = np.maximum(np.hypot(axial, radial) - A, 0.0)
    alpha = np.arctan2(axial, radial)
    Q = stiffness * delta**1.5
    along = Q * np.sin(alpha)
    return (
        np.array(
            [
                (Q * np.cos(alpha) * np.cos(phi)).sum(),
                (Q * np.cos(alpha) * np.sin(phi)).sum(),
                along.sum(),
                R * (along * np.sin(phi)).sum(),
                -R * (along * np.cos(phi)).sum(),
            ]
        ),
        Q,
        alpha,
    )


def evaluate(q, contacts, first=0.0, damper=None, velocity=None):
    """(force and moment (5,), sums (8,), stiffness, damping, balls) of the kernel."""
    balls, sums, k, c = place_balls(contacts.balls, first), np.zeros(8), np.zeros((5, 5)), np.zeros((5, 5))
    status = contact_forces(np.asarray(q), contacts, balls, sums, k, velocity, damper, c if damper is not None else None, None)
    assert status == DONE
    return sums[:5].copy(), sums, k, c, balls


def random_states(count=40):
    """(contacts, geometry, clearance, q) with some balls loaded."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        geometry = BallGeometry(int(rng.integers(3, 16)), 0.011, 0.055, *rng.uniform(0.51, 0.54, 2))
        clearance = float(rng.choice([0.0, -1e-5, 2e-5]))
        q = rng.normal(size=5) * np.array([3e-5, 3e-5, 1e-4, 2e-3, 2e-3])
        yield ball_contacts(geometry, 1.1e10, clearance), geometry, clearance, q


def test_forces_are_those_of_the_standard():
    for contacts, geometry, clearance, q in random_states():
        expected, Q, _ = iso_forces(q, geometry, 1.1e10, clearance, 0.3)
        force, sums, _, _, balls = evaluate(q, contacts, 0.3)
        assert Q.any()
        # delta is a difference of lengths of 4e-4 m: 1e-19 of 1e-6 at worst, some 1e-12 of the forces
        np.testing.assert_allclose(-force, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
        np.testing.assert_allclose(balls[:, LOAD], Q, rtol=1e-9, atol=1e-9 * Q.max())
        assert sums[LOADED] == np.count_nonzero(Q)


def test_forces_are_the_slope_of_the_potential_and_the_stiffness_is_symmetric():
    """F = -dV/dq with V the elastic energy: only with one lever for tilts and moments."""
    for contacts, _, _, q in random_states():
        force, _, k, _, _ = evaluate(q, contacts)
        assert (k == k.T).all()
        steps = 1e-8 * np.array([1.0, 1.0, 1.0, 30.0, 30.0])  # 10 nm at the balls
        slopes, tangent = np.zeros(5), np.zeros((5, 5))
        for i, h in enumerate(steps):
            ahead, behind = (evaluate(q + s * h * np.eye(5)[i], contacts) for s in (1.0, -1.0))
            slopes[i] = (ahead[1][ENERGY] - behind[1][ENERGY]) / (2.0 * h)
            tangent[:, i] = -(ahead[0] - behind[0]) / (2.0 * h)
        # Central difference over 1e-8 m of delta^2.5 with delta near 1e-5: (h/delta)², 1e-6; of delta^1.5 where a ball just
        # touches: sqrt(h / delta), 3 % of that ball's share.
        np.testing.assert_allclose(-force, slopes, rtol=1e-4, atol=1e-5 * np.abs(slopes).max())
        scale = np.sqrt(np.outer(np.diag(k), np.diag(k)))
        assert (np.abs(tangent - k) <= 0.02 * scale).all()
        assert np.median(np.abs(tangent - k) / scale) < 1e-5
        assert np.linalg.eigvalsh(k / scale).min() > -1e-12  # the potential is convex


def test_the_potential_is_convex():
    """What the solver rests on: on a line between any two displacements the energy lies below its chord."""
    rng = np.random.default_rng(9)
    for contacts, _, _, q in random_states(20):
        other = q + rng.normal(size=5) * np.array([5e-5, 5e-5, 2e-4, 4e-3, 4e-3])
        a, middle, b = (evaluate(q + s * (other - q), contacts)[1][ENERGY] for s in (0.0, 0.5, 1.0))
        assert middle <= 0.5 * (a + b) * (1.0 + 1e-12) + 1e-18


@pytest.mark.parametrize(
    ("clearance", "forces", "coordinate", "published"),
    [(0.0, (1000.0, 0, 0, 0, 0), 0, 15.1101), (0.0, (0, 0, 1000.0, 0, 0), 2, 133.5381), (10e-6, (1000.0, 0, 0, 0, 0), 0, 21.223)],
)
def test_displacements_of_a_commercial_solver(clearance, forces, coordinate, published):
    """MASTA's displacements as the public ISO/TS 16281 code quotes them; six digits, five of the last."""
    found = static_loads(ball_contacts(ISO, ISO.stiffness(STEEL), clearance), np.array(forces))
    assert found.status == DONE
    assert 1e6 * found.displacement[coordinate] == pytest.approx(published, rel=2e-5)


def test_equilibria_balance_in_the_other_formulation():
    """Random loads with all five components; residual from `iso_forces`."""
    rng = np.random.default_rng(11)
    loads = np.array([800.0, 800.0, 500.0, 3.0, 3.0])
    for contacts, geometry, clearance, _ in random_states(30):
        if geometry.balls < 5:
            continue
        forces = rng.normal(size=5) * loads
        found = static_loads(contacts, forces, first_ball=0.3)
        expected, Q, alpha = iso_forces(found.displacement, geometry, 1.1e10, clearance, 0.3)
        assert found.status == DONE
        np.testing.assert_allclose(expected, forces, rtol=0.0, atol=BALANCED * np.abs(forces).max())
        np.testing.assert_allclose(found.ball_loads, Q, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(found.contact_angles, alpha, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("degrees", [15.0, 25.0, 40.0])
def test_axial_load_on_an_angular_contact_bearing(degrees):
    """Every ball carries Fa / (Z sin(alpha)) at one angle, which grows with the load from the free one."""
    geometry = BallGeometry(16, 0.0127, 0.07, 0.52, 0.52, math.radians(degrees))
    contacts = ball_contacts(geometry, 1.2e10)
    angles = []
    for force in (1e-3, 1.0, 1000.0):
        found = static_loads(contacts, np.array([0.0, 0.0, force, 0.0, 0.0]))
        expected = force / (16.0 * np.sin(found.contact_angles))
        np.testing.assert_allclose(found.ball_loads, expected, rtol=1e-7)
        angles.append(found.contact_angles[0])
    assert angles[0] == pytest.approx(math.radians(degrees), abs=1e-4)  # delta / A of 1 mN
    assert angles[0] < angles[1] < angles[2]


def test_axial_load_without_contact_angle_and_clearance():
    """tan(phi) = z/A, delta = sqrt(A² + z²) - A: the stiffness at z = 0 is zero, the force grows with the fourth power."""
    contacts = ball_contacts(ISO, ISO.stiffness(STEEL))
    A = contacts.distance
    for force in (1e-6, 1e-2, 100.0):
        found = static_loads(contacts, np.array([0.0, 0.0, force, 0.0, 0.0]))
        assert found.status == DONE
        z = found.displacement[2]
        delta = z * z / (math.sqrt(A * A + z * z) + A)  # the difference without its cancellation
        carried = 7.0 * contacts.stiffness * delta**1.5 * z / math.hypot(A, z)
        assert carried == pytest.approx(force, rel=1e-6, abs=2e-10)  # the solver's NO_FORCE
    small, ten_times = (static_loads(contacts, np.array([0.0, 0.0, f, 0.0, 0.0])).displacement[2] for f in (1e-6, 1e-2))
    assert ten_times / small == pytest.approx(10.0, rel=1e-3)  # 10^4 in force


def test_one_ball_carries_a_load_along_its_line():
    contacts = ball_contacts(BallGeometry(8, 0.0119, 0.052), 1.334e10, 40e-6)
    found = static_loads(contacts, np.array([196.0, 0.0, 0.0, 0.0, 0.0]))
    assert found.status == DONE
    assert found.displacement[0] == pytest.approx(20e-6 + (196.0 / 1.334e10) ** (2.0 / 3.0), rel=1e-9)
    np.testing.assert_allclose(found.ball_loads, [196.0, *[0.0] * 7], rtol=1e-9)
    _, _, k, _, _ = evaluate(found.displacement, contacts)
    assert k[1, 1] == 0.0  # nothing holds it across


def test_no_load():
    """With clearance: the middle. With preload: the middle, and every ball carries K (e/2)^1.5, e the diametral interference."""
    for clearance, each in ((20e-6, 0.0), (0.0, 0.0), (-10e-6, 1.1e10 * 5e-6**1.5)):
        found = static_loads(ball_contacts(BallGeometry(9, 0.0111, 0.0535), 1.1e10, clearance), np.zeros(5))
        assert found.status == DONE
        np.testing.assert_allclose(found.displacement, 0.0, atol=1e-18)
        np.testing.assert_allclose(found.ball_loads, each, rtol=1e-9)  # delta is a difference of 4e-4 m


@pytest.mark.parametrize("balls", [3, 4, 9])
@pytest.mark.parametrize("force", [1e-6, 1e-3, 1.0, 1e3])
def test_radial_loads_of_any_size_with_clearance(balls, force):
    contacts = ball_contacts(BallGeometry(balls, 0.0111, 0.0535), 1.1e10, 20e-6)
    for angle in np.linspace(0.0, 2.0 * np.pi / balls, 7):
        load = force * np.array([math.cos(angle), math.sin(angle), 0.0, 0.0, 0.0])
        found = static_loads(contacts, load)
        assert found.status == DONE
        carried = -evaluate(found.displacement, contacts)[0]
        np.testing.assert_allclose(carried[:2], load[:2], rtol=0.0, atol=BALANCED * force + 2e-10)


def test_equilibria_of_random_bearings_are_found():
    """5 to 24 balls of 2 to 32 mm, contact angles of 0 to 40 degrees, preload to clearance, loads over four decades."""
    rng = np.random.default_rng(1)
    for _ in range(300):
        balls, d = int(rng.integers(5, 25)), 10.0 ** rng.uniform(-2.7, -1.5)
        angle = float(rng.choice([0.0, rng.uniform(0.0, 0.7)]))
        geometry = BallGeometry(balls, d, d * max(3.0, 0.45 * balls), *rng.uniform(0.51, 0.54, 2), angle)
        contacts = ball_contacts(geometry, 1e10, float(rng.choice([0.0, -1e-5, 1e-5, 4e-5])))
        largest = 1e10 * (0.05 * contacts.distance) ** 1.5
        forces = largest * 10.0 ** rng.uniform(-4.0, 0.0) * rng.normal(size=5) * rng.choice([0.0, 1.0, 1e-3], size=5)
        forces[3:] *= contacts.lever
        found = static_loads(contacts, forces)
        assert found.status == DONE
        carried = -evaluate(found.displacement, contacts)[0]
        room = BALANCED * (np.abs(forces).max() + found.ball_loads.sum()) + 2e-10  # the solver's NO_FORCE
        np.testing.assert_allclose(carried[:3], forces[:3], rtol=0.0, atol=room)


def test_coordinates_that_are_held_stay_and_the_others_balance():
    contacts = ball_contacts(ISO, ISO.stiffness(STEEL), 10e-6)
    forces = np.array([300.0, -1000.0, 200.0, 5.0, 5.0])
    found = static_loads(contacts, forces, first_ball=0.2, held=("x", "tilt_x", "tilt_y"))
    assert found.displacement[0] == found.displacement[3] == found.displacement[4] == 0.0
    carried = -evaluate(found.displacement, contacts, 0.2)[0]
    np.testing.assert_allclose(carried[1:3], forces[1:3], rtol=BALANCED)


def test_a_gap_at_every_ball_is_clearance():
    """5 um at each ball are 10 um of diametral clearance, up to the change of the groove centres' distance."""
    forces = np.array([500.0, -800.0, 0.0, 0.0, 0.0])
    K = ISO.stiffness(STEEL)
    a = static_loads(ball_contacts(ISO, K, 10e-6), forces)
    b = static_loads(ball_contacts(ISO, K), forces, gap=5e-6)
    np.testing.assert_allclose(a.displacement[:2], b.displacement[:2], rtol=1e-9)


def test_mistake_three_diametral_or_radial_clearance():
    """A bearing with 20 um of diametral clearance lets its ring move by 10 um to either side: 20 um from stop to stop."""
    contacts = ball_contacts(BallGeometry(8, 0.0119, 0.052), 1.334e10, 20e-6)
    right, left = (static_loads(contacts, np.array([f, 0.0, 0.0, 0.0, 0.0])).displacement[0] for f in (1e-6, -1e-6))
    assert right - left == pytest.approx(20e-6, rel=1e-4)  # 1 uN presses 0.2 pm


def test_mistake_four_sign_of_the_load_axis():
    """A weight pulls the shaft down, the ball below carries it, the bearing pushes up; a ball stands at -90 degrees."""
    contacts = ball_contacts(BallGeometry(8, 0.0119, 0.052), 1.334e10, 10e-6)
    found = static_loads(contacts, np.array([0.0, -196.0, 0.0, 0.0, 0.0]))
    assert found.displacement[1] < -5e-6
    assert np.argmax(found.ball_loads) == 6  # 6 * 45 degrees
    force, _, _, _, _ = evaluate(found.displacement, contacts)
    assert force[1] == pytest.approx(196.0, rel=BALANCED)


def test_signs_of_tilts_and_moments():
    """A ring turned by tilt_x > 0 is moved towards +z above the shaft: the balls there push it back towards -z."""
    contacts = ball_contacts(BallGeometry(9, 0.0111, 0.0535), 1.1e10)
    force, _, _, _, _ = evaluate([0.0, 0.0, 0.0, 5e-3, 0.0], contacts)
    assert force[3] < 0.0
    assert abs(force[4]) < 1e-9 * abs(force[3]) + 1e-9
    found = static_loads(contacts, np.array([0.0, 0.0, 0.0, 2.0, 0.0]))
    assert found.displacement[3] > 0.0


@pytest.mark.known_answers(DeepGrooveBearing="damping")
def test_dampers_take_power_and_let_go_before_they_pull():
    contacts = ball_contacts(BallGeometry(9, 0.0111, 0.0535), 1.1e10, -4e-6)
    rng = np.random.default_rng(3)
    factor = 2.5e-5
    for _ in range(20):
        q = rng.normal(size=5) * np.array([5e-6, 5e-6, 3e-5, 5e-4, 5e-4])
        v = rng.normal(size=5) * np.array([1e-3, 1e-3, 1e-3, 0.03, 0.03])
        still, _, k, _, _ = evaluate(q, contacts)
        moving, _, _, c, _ = evaluate(q, contacts, damper=factor, velocity=v)
        np.testing.assert_allclose(moving - still, -c @ v, rtol=1e-9, atol=1e-9 * np.abs(moving - still).max())  # linear in v
        assert (c == c.T).all()
        assert -(moving - still) @ v > 0.0
        # factor * k less the part of turning directions, Q / distance against 1.5 K sqrt(delta): delta / (1.5 distance)
        assert np.abs(c[:2, :2] - factor * k[:2, :2]).max() <= 0.1 * factor * k[0, 0]
    released, _, _, c, balls = evaluate(np.zeros(5), contacts, damper=factor, velocity=np.array([-1.0, 0.0, 0.0, 0.0, 0.0]))
    assert (balls[:, LOAD] >= 0.0).all()
    assert balls[0, LOAD] == 0.0  # the ring flees from the ball at +x faster than it can follow
    assert released[0] > 0.0


def test_a_ring_beyond_its_grooves_is_out_of_range():
    contacts = ball_contacts(ISO, 1e10)
    q, sums = np.array([contacts.distance * 1.01, 0, 0, 0, 0]), np.zeros(8)
    balls = place_balls(8)  # one of them at 180 degrees
    assert contact_forces(q, contacts, balls, sums, None, None, None, None, None) == OUT_OF_RANGE


def test_a_load_that_no_groove_holds_is_reported():
    """1 MN on balls that start to leave the grooves at a tenth of it: no equilibrium, and no endless search."""
    found = static_loads(ball_contacts(ISO, 1e10), np.array([1e6, 0.0, 0.0, 0.0, 0.0]))
    assert found.status != DONE


@pytest.mark.parametrize(
    "call",
    [
        lambda c: static_loads(c, np.array([np.nan, 0, 0, 0, 0])),
        lambda c: static_loads(c, np.zeros(4)),
        lambda c: static_loads(c, np.zeros(5), held=("w",)),
        lambda c: static_loads(BallContacts(2, *c[1:]), np.zeros(5)),
    ],
)
def test_what_cannot_be_solved_is_refused(call):
    with pytest.raises(BadInput):
        call(ball_contacts(ISO, 1e10))
