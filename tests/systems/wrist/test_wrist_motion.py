"""Motion of the wrist: matrix exponential, Lagrange's equations written again, energy, virtual work, equilibria, order."""

import math

import numpy as np
import pytest
from cosimo.components.wrist.kinematics import DISTAL_TILT, PROXIMAL_TILT, ROW_OFFSET, small_angle_matrix
from cosimo.components.wrist.wrist import Wrist
from cosimo.components.wrist.wrist_equations import gyroscopic, hand_of, mass_matrix, wrist_derivatives, wrist_pose
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from scipy.linalg import expm
from scipy.optimize import minimize

pytestmark = pytest.mark.interpreted

FREE = {"proximal_damping": 0.0, "distal_damping": 0.0}
QUIET = {"proximal_damping": 0.2, "distal_damping": 0.2, "substep": 4e-3}
NO_LIGAMENTS = {f"constraint.stiffness[{j}]": 0.0 for j in range(1, 6)}
ALL = ("morphology", "constraint", "interaction", "load")
TIGHT = {
    "interaction.flexion_upper": 0.2,
    "interaction.deviation_upper": 0.1,
    "interaction.contact_lower": -0.1,
    "interaction.contact_stiffness": 120.0,
    "constraint.damping": 0.05,
    "constraint.prestrain": 0.03,
    "load.gravity_y": 3.0,
    "load.gravity_z": -2.0,
}
MASS, DISTANCE, TRANSVERSE, AXIAL, ROW = 0.45, 0.07, 1e-3, 4e-4, 1e-5


def wrist(effects=(), parameters=None, inputs=None) -> Wrist:
    return initialized(Wrist(effects, parameters or {}), inputs)


def turn(axis: np.ndarray, angle: complex) -> np.ndarray:
    """Rotation matrix; of a complex angle, too, for derivatives without rounding."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def bodies(q, half: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(rotation of the proximal row, rotation of the hand, centre of mass of the hand)."""
    if half:
        row = turn(np.array([0.0, 0.0, 1.0]), 0.5 * q[0]) @ turn(np.array([1.0, 0.0, 0.0]), 0.5 * q[1])
        hand = row @ row
    else:
        row = turn(np.array([math.sin(PROXIMAL_TILT), 0.0, math.cos(PROXIMAL_TILT)]), q[0])
        hand = row @ turn(np.array([-math.sin(DISTAL_TILT), 0.0, math.cos(DISTAL_TILT)]), q[1])
    return row, hand, row[:, 1] * ROW_OFFSET + hand[:, 1] * (DISTANCE - ROW_OFFSET)


def lagrange_mass(q: np.ndarray, half: bool) -> np.ndarray:
    """Mass matrix from the derivatives of places and rotations by complex steps."""
    M, columns = np.zeros((2, 2)), []
    for i in range(2):
        step = np.array(q, dtype=complex)
        step[i] += 1e-30j
        row, hand, centre = ((part.imag / 1e-30) for part in bodies(step, half))
        still_row, still_hand, _ = bodies(q, half)
        spin = [np.array([s[2, 1], s[0, 2], s[1, 0]]) for s in (row @ still_row.T, hand @ still_hand.T)]
        columns.append((centre, *spin))
    _, hand, _ = bodies(q, half)
    inertia = hand @ np.diag([TRANSVERSE, AXIAL, TRANSVERSE]) @ hand.T
    for i, (v, row, w) in enumerate(columns):
        for j, (v2, row2, w2) in enumerate(columns):
            M[i, j] = MASS * v @ v2 + w @ inertia @ w2 + ROW * row @ row2
    return M


# -- the equations ----------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(Wrist="morphology")
@pytest.mark.parametrize("model", ["rules", "opensim_half"])
@pytest.mark.parametrize("q", [(0.0, 0.0), (0.5, -0.4), (-0.8, 0.6)])
def test_inertia_is_lagranges(model, q):
    """M, and h = sum (dM_ij/dq_k - dM_jk/dq_i / 2) q_j' q_k' by differences of M."""
    made = wrist(("morphology",), {"coupling_model": model})
    half, q, rates, d = model == "opensim_half", np.array(q), np.array([2.0, -3.0]), 1e-5
    _, p, e = made.arguments
    hand = hand_of(p, e)
    at = wrist_pose(np.r_[q, rates], hand, e.morphology)
    m11, m12, m22 = mass_matrix(at, hand)
    assert np.array([[m11, m12], [m12, m22]]) == pytest.approx(lagrange_mass(q, half), rel=1e-12, abs=1e-16)
    slopes = [(lagrange_mass(q + d * way, half) - lagrange_mass(q - d * way, half)) / (2.0 * d) for way in np.eye(2)]
    along = sum(rate * slope for rate, slope in zip(rates, slopes, strict=True)) @ rates
    expected = along - 0.5 * np.array([rates @ slope @ rates for slope in slopes])
    assert gyroscopic(at, *rates, hand) == pytest.approx(expected, abs=1e-10)  # of 0.02 N.m


@pytest.mark.parametrize("model", ["rules", "opensim_half"])
def test_without_effects_it_is_the_matrix_exponential(model):
    """M q'' + D q' + A^T K A q = A^T tau + torques, started with angles and rates, under constant torques."""
    K = np.array([[2.0, 0.7], [0.7, 3.0]])
    made = wrist(
        (),
        {
            "coupling_model": model,
            "flexion_stiffness": 2.0,
            "deviation_stiffness": 3.0,
            "coupling_stiffness": 0.7,
            "proximal_damping": 0.03,
            "distal_damping": 0.01,
            "start_proximal_angle": 0.2,
            "start_distal_rate": -1.0,
        },
        {"tau_flexion": 0.4, "tau_deviation": -0.2, "proximal_torque": 0.1, "distal_torque": 0.3},
    )
    A = small_angle_matrix(made.axes())
    across = MASS * DISTANCE**2 + TRANSVERSE  # about any axis across the hand; A's columns are the rows' axes in (z, x)
    M = across * A.T @ A + ROW * (np.diag([1.0, 0.0]) if model == "rules" else 0.25 * np.eye(2))
    q0 = np.linalg.solve(A.T @ K @ A, A.T @ [0.4, -0.2] + [0.1, 0.3])
    D = np.diag([0.03, 0.01])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, A.T @ K @ A), -np.linalg.solve(M, D)]])
    for t in (0.1, 0.5):
        made.initialize(0.0)
        made.step(0.0, t)
        expected = expm(system * t) @ (np.array([0.2, 0.0, 0.0, -1.0]) - np.r_[q0, 0.0, 0.0]) + np.r_[q0, 0.0, 0.0]
        assert made.x == pytest.approx(expected, abs=2e-7)  # RK4: (w h)^5 / 120 a step with w = 40 rad/s, over 0.5 s of 1 rad
        assert [made["flexion"], made["deviation"]] == pytest.approx(A @ expected[:2], abs=2e-7)
        assert made["roll"] == 0.0


def test_error_falls_with_the_fourth_power_of_the_substep():
    def end(substep: float) -> np.ndarray:
        made = wrist(("morphology",), {"start_proximal_angle": 0.6, "start_distal_rate": 8.0, "substep": substep})
        made.step(0.0, 0.2)
        return made.x.copy()

    reference = end(1e-4)
    errors = [np.abs(end(h) - reference).max() for h in (8e-3, 4e-3, 2e-3)]
    assert orders(errors) == pytest.approx([4.0, 4.0], abs=0.25)


# -- energy and work ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("effects", "parameters"),
    [
        ((), {}),
        (("morphology",), {"coupling_model": "opensim_half"}),
        (
            ("morphology", "constraint"),
            {"coupling_model": "opensim_half", "constraint.damping": 0.05, "constraint.prestrain": 0.03},
        ),
        (ALL, TIGHT),
    ],
    ids=["linear", "half", "half with ligaments", "all"],
)
def test_energy_changes_by_the_power_of_ports_and_losses(effects, parameters):
    """dE/dt along the equations, by differences, at random states: in contact, with taut ligaments, under all loads."""
    random = np.random.default_rng(7)
    made = wrist(effects, parameters)
    for _ in range(20):
        x = np.r_[random.uniform(-0.6, 0.6, 2), random.uniform(-3.0, 3.0, 2)]
        for name in made.inputs:
            made.set(name, random.uniform(-2.0, 2.0))
        made.x[:] = x
        rate, _ = energy_rate(made, wrist_derivatives)
        made.refresh()
        ports = {
            "tau_flexion": "flexion_rate",
            "tau_deviation": "deviation_rate",
            "proximal_torque": "proximal_rate",
            "distal_torque": "distal_rate",
        }
        for name in made.inputs:
            if "load." in name:
                ports[name] = name.replace("tip_force", "tip_velocity") if "tip" in name else name + "_rate"
        power = sum(made[effort] * made[flow] for effort, flow in ports.items())
        assert made["dissipation"] >= 0.0
        # differences: 1e-6² of the third derivative, and 1e-16 of some J over 2e-6 s
        assert rate == pytest.approx(power - made["dissipation"], rel=1e-6, abs=1e-7)


def test_energy_is_counted_from_the_hand_at_rest_and_its_height_against_gravity():
    """By the place of its centre of mass, of the two rotations composed; slack ligaments hold nothing at rest."""
    assert wrist(ALL).energy() == pytest.approx(0.0, abs=1e-15)
    pull = {"load.gravity_x": -4.0, "load.gravity_y": 3.0, "load.gravity_z": -2.0, "flexion_stiffness": 0.0,
            "deviation_stiffness": 0.0}  # fmt: skip
    made = wrist(ALL, {**pull, **NO_LIGAMENTS, "start_proximal_angle": 0.4, "start_distal_angle": -0.3})
    moved = bodies((0.4, -0.3), half=False)[2] - [0.0, DISTANCE, 0.0]
    assert made.energy() == pytest.approx(-MASS * moved @ [-4.0, 3.0, -2.0], rel=1e-12)


@pytest.mark.first
@pytest.mark.parametrize("effects", [("morphology",), ALL], ids=["rows", "all"])
def test_without_damping_energy_stays(effects):
    made = wrist(effects, {**FREE, "start_proximal_angle": 0.4, "start_distal_angle": -0.3, "start_distal_rate": 5.0})
    before = made.energy()
    made.step(0.0, 1.5)
    assert made.energy() == pytest.approx(before, rel=1e-7)  # RK4 at w h = 0.04 loses (w h)^6 / 72 a step, 1500 times


def test_with_damping_energy_only_falls():
    made = wrist(ALL, {"start_proximal_angle": 0.6, "start_distal_angle": -0.5, "load.gravity_x": 0.0})
    course = [made.energy()]
    for k in range(60):
        made.step(0.01 * k, 0.01)
        course.append(made.energy())
    assert (np.diff(course) < 0.0).all()


def test_places_and_excursions_have_their_rates():
    made = wrist(
        ALL, {"start_proximal_angle": 0.4, "start_distal_angle": -0.3, "start_proximal_rate": 2.0, "start_distal_rate": -1.5}
    )
    x, d = made.x.copy(), 1e-6

    def there(sign, names):
        made.x[:2] = x[:2] + sign * d * x[2:]
        made.refresh()
        return np.array([made[n] for n in names])

    for places, rates in (
        (("load.tip_x", "load.tip_y", "load.tip_z"), [f"load.tip_velocity_{axis}" for axis in "xyz"]),
        (("flexion", "deviation"), ("flexion_rate", "deviation_rate")),
    ):
        difference = (there(1.0, places) - there(-1.0, places)) / (2.0 * d)
        assert there(0.0, rates) == pytest.approx(difference, abs=1e-9)
    arms = made["load.flexion_arm[3]"], made["load.deviation_arm[3]"]
    assert made["load.extensor_radial_rate"] == pytest.approx(arms[0] * made["flexion_rate"] + arms[1] * made["deviation_rate"])


# -- equilibria ----------------------------------------------------------------------------------------------------------------
def test_rest_under_a_torque_is_by_the_stiffness_whatever_the_rows_do():
    """J^T (tau - K e) = 0. Soft direction of the preset: 26.6 degrees from flexion to the ulnar side, 0.15 N.m a degree."""
    soft = np.array([math.cos(math.radians(26.6)), -math.sin(math.radians(26.6))])
    for direction, per_degree in ((soft, 0.15), (np.array([-soft[1], soft[0]]), 0.40)):
        made = Wrist(("morphology",), {**QUIET, "proximal_damping": 0.3}, preset="cadaver")
        made.initialize(0.0)
        made.set("tau_flexion", 2.0 * direction[0])
        made.set("tau_deviation", 2.0 * direction[1])
        made.step(0.0, 5.0)
        expected = math.radians(2.0 / per_degree) * direction
        assert [made["flexion"], made["deviation"]] == pytest.approx(expected, abs=1e-4)  # the preset has five digits


def test_a_hanging_hand_rests_where_its_energy_is_least():
    made = wrist(ALL, {**QUIET, **NO_LIGAMENTS}, {"load.tip_force_z": 0.8})
    made.step(0.0, 5.0)

    def potential(q):
        _, hand, centre = bodies(q, half=False)
        y = hand[:, 1]
        flexion, deviation = math.atan2(-y[0], y[1]), math.asin(y[2])
        tip = centre + y * (0.1 - DISTANCE)
        return 0.5 * (flexion**2 + deviation**2) + MASS * 9.81 * centre[0] - 0.8 * tip[2]

    least = minimize(potential, [0.1, 0.1], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-16})
    assert made.x[:2] == pytest.approx(least.x, abs=1e-6)
    assert made["flexion"] > 0.2  # the palm faces down


def test_rows_move_as_the_rule_says_under_torques():
    """The signs in the dynamic model: the motions of the inverse kinematics are those that torques on the hand produce."""
    for name, value, signs in (
        ("tau_deviation", 0.3, (1, -1)),
        ("tau_deviation", -0.3, (-1, 1)),
        ("tau_flexion", 0.5, (1, 1)),
        ("tau_flexion", -0.5, (-1, -1)),
    ):
        made = wrist(("morphology",), QUIET, {name: value})
        made.step(0.0, 2.0)
        assert [np.sign(made["proximal_flexion"]), np.sign(made["distal_flexion"])] == list(signs)
        assert abs(made["roll"]) < math.radians(5.0)
    assert made["proximal_flexion"] == math.cos(PROXIMAL_TILT) * made["proximal_angle"]
    assert made["distal_flexion"] == math.cos(DISTAL_TILT) * made["distal_angle"]
    half = wrist(("morphology",), {"coupling_model": "opensim_half", "start_proximal_angle": 0.4, "start_distal_angle": -0.3})
    assert (half["proximal_flexion"], half["distal_flexion"]) == (0.2, 0.2)


@pytest.mark.known_answers(Wrist="load")
def test_a_force_of_a_tendon_is_a_torque_by_its_arms():
    pulled = wrist(ALL, {**NO_LIGAMENTS, "load.gravity_x": 0.0}, {"load.flexor_ulnar": 20.0})
    turned = wrist(("morphology",), {}, {"tau_flexion": 0.016 * 20.0, "tau_deviation": -0.016 * 20.0})
    for made in (pulled, turned):
        made.step(0.0, 0.3)
    assert pulled.x == pytest.approx(turned.x, abs=1e-13)
