"""Numbers beside the diagonals of added mass and drag: Kirchhoff's equations by another solver, rest states by a root finder."""

import re

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import in_python
from cosimo.components.rov.coupling import fill_drag, fill_masses, least_square_power
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.vehicles import AXES
from cosimo.tests.support import initialized
from scipy.integrate import solve_ivp
from scipy.optimize import minimize, root
from scipy.spatial.transform import Rotation

DAMPED = ("linear_drag", "quadratic_drag", "linear_drag_coupling", "quadratic_drag_coupling")
ALL = ("added_mass", "coriolis", "added_mass_coupling", "current", "external", *DAMPED)  # one set: it is compiled once
NO_DRAG = {f"{kind}_drag.{axis}": 0.0 for kind in ("linear", "quadratic") for axis in AXES}
PLACE = {"centre_of_gravity_x": 0.03, "centre_of_gravity_y": -0.02, "centre_of_gravity_z": 0.04}
START = {
    "start_surge": 0.7, "start_sway": -0.4, "start_heave": 0.5, "start_roll_rate": 2.0, "start_pitch_rate": -1.0,
    "start_yaw_rate": 1.5, "start_roll": 0.3, "start_pitch": -0.6, "start_yaw": 2.0,
}  # fmt: skip


def written(effect: str, name: str, values) -> dict[str, float]:
    return {f"{effect}.{name}[{i}]": float(v) for i, v in enumerate(np.ravel(values), 1)}


def masses(matrix: np.ndarray) -> dict[str, float]:
    """Parameters of an added mass, (6, 6)."""
    three = ([0, 0, 1], [1, 2, 2])
    return (
        {f"added_mass.{axis}": float(matrix[i, i]) for i, axis in enumerate(AXES)}
        | written("added_mass_coupling", "force", matrix[:3, :3][three])
        | written("added_mass_coupling", "mixed", matrix[:3, 3:])
        | written("added_mass_coupling", "moment", matrix[3:, 3:][three])
    )


def drag(kind: str, matrix: np.ndarray) -> dict[str, float]:
    """Parameters of a drag, (6, 6)."""
    beside, effect = ~np.eye(3, dtype=bool), f"{kind}_drag_coupling"
    return (
        {f"{kind}_drag.{axis}": float(matrix[i, i]) for i, axis in enumerate(AXES)}
        | written(effect, "force_by_speed", matrix[:3, :3][beside])
        | written(effect, "force_by_rate", matrix[:3, 3:])
        | written(effect, "moment_by_speed", matrix[3:, :3])
        | written(effect, "moment_by_rate", matrix[3:, 3:][beside])
    )


def random_masses(seed: int) -> np.ndarray:
    """A full added mass of the size of the small vehicle's, positive definite."""
    random, scale = np.random.default_rng(seed), np.array([2.0, 3.0, 4.0, 0.3, 0.3, 0.3])
    root_ = random.normal(size=(6, 6)) + 2.0 * np.eye(6)
    return np.outer(scale, scale) * (root_ @ root_.T) / 6.0


def skew(v) -> np.ndarray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def fossen_coriolis(M: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """C(nu) of Fossen 2011, theorem 3.2: blocks -S(M11 v + M12 w), -S(M21 v + M22 w)."""
    linear, angular = (part @ nu for part in (M[:3], M[3:]))
    C = np.zeros((6, 6))
    C[:3, 3:] = C[3:, :3] = -skew(linear)
    C[3:, 3:] = -skew(angular)
    return C


def velocity(hull: RovHull) -> np.ndarray:
    return np.array([hull[n] for n in ("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")])


def started(effects, parameters) -> RovHull:
    return initialized(RovHull(effects, parameters))


@pytest.mark.known_answers(RovHull="added_mass_coupling")
def test_a_body_in_a_perfect_fluid_follows_kirchhoff():
    """Against Fossen's matrix C_A integrated by SciPy; energy, impulse and its moment stay, as they do for any inertia."""
    added = random_masses(3)
    hull = started(ALL, NO_DRAG | START | PLACE | masses(added) | {"substep": 1e-3})
    rigid, moved = hull.masses()
    np.testing.assert_allclose(moved, added, rtol=1e-15)
    M = rigid + added

    def rate(t, y):
        nu, q = y[:6], y[6:10]
        turned = Rotation.from_quat(q).apply(nu[:3])
        w, (x, yy, z) = q[3], q[:3]
        p, q_, r = nu[3:]
        dq = 0.5 * np.array([w * p + yy * r - z * q_, w * q_ + z * p - x * r, w * r + x * q_ - yy * p, -x * p - yy * q_ - z * r])
        return np.concatenate((np.linalg.solve(M, -fossen_coriolis(M, nu) @ nu), dq, turned))

    def kept(hull: RovHull) -> np.ndarray:
        turn = Rotation.from_quat([hull[f"quaternion_{n}"] for n in "xyzw"])
        place = np.array([hull[n] for n in ("position_north", "position_east", "depth")])
        P, H = (turn.apply(part) for part in np.split(M @ velocity(hull), 2))
        return np.array([0.5 * velocity(hull) @ M @ velocity(hull), *P, *(H + np.cross(place, P))])

    begin, before = velocity(hull), kept(hull)
    q0 = [hull[f"quaternion_{n}"] for n in "xyzw"]
    exact = solve_ivp(rate, (0.0, 2.0), [*begin, *q0, 0.0, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    hull.step(0.0, 2.0)
    np.testing.assert_allclose(velocity(hull), exact[:6], atol=1e-8)
    assert [hull[n] for n in ("position_north", "position_east", "depth")] == pytest.approx(exact[10:], abs=1e-8)
    np.testing.assert_allclose(kept(hull), before, rtol=1e-9, atol=1e-8)
    assert hull.energy() == pytest.approx(before[0], rel=1e-9)
    assert (
        np.abs(np.linalg.solve(M, added - np.diag(added.diagonal()))).max() > 0.1
    )  # what is beside the diagonal is no small thing


def test_in_a_uniform_current_a_full_added_mass_acts_as_in_still_water():
    """Galileo, with every block of the matrix and the hull turning."""
    flow = np.array([0.4, -0.7, 0.2])
    numbers = NO_DRAG | START | PLACE | masses(random_masses(5)) | {"substep": 1e-3}
    still = started(ALL, numbers)
    turn = Rotation.from_euler("ZYX", [START["start_yaw"], START["start_pitch"], START["start_roll"]])
    drift = dict(zip(("start_surge", "start_sway", "start_heave"), turn.inv().apply(flow), strict=True))
    moved = started(ALL, numbers | {n: numbers[n] + v for n, v in drift.items()})
    for way, v in zip(("north", "east", "down"), flow, strict=True):
        moved[f"current.velocity_{way}"] = v
    for hull in (still, moved):
        hull.step(0.0, 1.0)
    np.testing.assert_allclose(velocity(moved)[3:], velocity(still)[3:], atol=1e-8)
    turn = Rotation.from_quat([still[f"quaternion_{n}"] for n in "xyzw"])
    np.testing.assert_allclose(velocity(moved)[:3], velocity(still)[:3] + turn.inv().apply(flow), atol=1e-8)


@pytest.mark.known_answers(RovHull=("linear_drag_coupling", "quadratic_drag_coupling"))
def test_terminal_speeds_with_drag_between_the_axes():
    """(C(nu) + D) nu + D2 |nu| nu = tau, of a root finder; weight and buoyancy are not there, so that the attitude has no part."""
    random, added = np.random.default_rng(1), random_masses(4)
    scale = np.array([4.0, 6.0, 5.0, 0.5, 0.5, 0.5]) ** 0.5
    D = np.outer(scale, scale) * (np.eye(6) + 0.15 * random.normal(size=(6, 6)))
    scale = np.array([18.0, 22.0, 37.0, 1.5, 1.5, 1.5])
    D2 = np.outer(scale ** (1.0 / 3.0), scale ** (2.0 / 3.0)) * (np.eye(6) + 0.05 * random.normal(size=(6, 6)))
    tau = np.array([10.0, -6.0, 4.0, 0.3, -0.2, 0.4])
    hull = started(ALL, PLACE | masses(added) | drag("linear", D) | drag("quadratic", D2))
    for name, value in zip([n for n in hull.inputs if n.startswith("external.")], tau, strict=True):
        hull[name] = value
    hull.step(0.0, 60.0)
    M = sum(hull.masses())
    rest = lambda nu: (fossen_coriolis(M, nu) + D) @ nu + D2 @ (np.abs(nu) * nu) - tau  # noqa: E731
    found = root(rest, velocity(hull) + 0.02, tol=1e-13)
    assert found.success
    np.testing.assert_allclose(velocity(hull), found.x, rtol=1e-9, atol=1e-10)
    without = root(lambda nu: D.diagonal() * nu + D2.diagonal() * np.abs(nu) * nu - tau, velocity(hull))
    assert np.abs(without.x - found.x).max() > 0.05


def test_numbers_stand_where_their_names_say():
    """Each number alone, into the matrices that the kernels use."""
    values = RovHull.effects["added_mass_coupling"].Values(np.arange(1.0, 4.0), np.arange(1.0, 10.0), np.arange(5.0, 8.0))
    m = np.zeros((6, 6))
    in_python(fill_masses)(values, m)
    assert (m == m.T).all()
    assert not m.diagonal().any()
    assert [m[0, 1], m[0, 2], m[1, 2], m[0, 3], m[1, 5], m[2, 4], m[3, 4], m[3, 5], m[4, 5]] == [1, 2, 3, 1, 6, 8, 5, 6, 7]
    six, nine = np.arange(1.0, 7.0), np.arange(1.0, 10.0)
    in_python(fill_drag)(RovHull.effects["linear_drag_coupling"].Values(six, nine, 10.0 * nine, 10.0 * six), m)
    assert [m[0, 1], m[1, 0], m[2, 1], m[0, 5], m[2, 3], m[3, 0], m[5, 1], m[3, 4], m[5, 4]] == [1, 3, 6, 3, 7, 10, 80, 10, 60]


@pytest.mark.parametrize(
    ("effects", "numbers", "words"),
    [
        (ALL, {"added_mass.surge": 4.0, "added_mass.sway": 9.0, "added_mass_coupling.force[1]": 6.01}, "negative kinetic"),
        (ALL, {"added_mass.roll": 0.0, "added_mass_coupling.mixed[1]": 1e-3}, "axis 4"),
        (ALL, {"linear_drag.surge": 4.0, "linear_drag.sway": 9.0, "linear_drag_coupling.force_by_speed[1]": -12.1}, "drive"),
        (ALL, {"quadratic_drag_coupling.force_by_rate[2]": 40.0}, r"W from the water at \(.*m/s"),
    ],
)
def test_water_that_would_give_energy_is_refused(effects, numbers, words):
    with pytest.raises(BadInput, match=words) as refused:
        started(effects, numbers)
    if "W from" in words:  # the velocity that it names is one
        numbers_told = [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", str(refused.value).split("velocity")[0])]
        power, nu = numbers_told[-7], np.array(numbers_told[-6:])
        D2 = np.diag([18.18, 21.66, 36.99, 1.55, 1.55, 1.55])
        D2[0, 4] = 40.0
        assert -nu @ D2 @ (np.abs(nu) * nu) == pytest.approx(power, rel=1e-3)


def test_a_boundary_of_the_added_mass_is_taken():
    started(ALL, {"added_mass.surge": 4.0, "added_mass.sway": 9.0, "added_mass_coupling.force[1]": 5.99})
    started(ALL, {"linear_drag.surge": 4.0, "linear_drag.sway": 9.0, "linear_drag_coupling.force_by_speed[1]": -11.9})


def test_the_least_power_is_that_of_a_global_search():
    """Of random matrices near the edge between giving and taking: no local minimum is mistaken for the least."""
    random = np.random.default_rng(2)
    search, A, room, v = in_python(least_square_power), np.zeros((6, 6)), np.zeros((2, 6)), np.zeros(6)

    def power(nu, m):
        nu = nu / np.linalg.norm(nu)
        return nu @ m @ (np.abs(nu) * nu)

    for _ in range(4):
        beside = 0.35 * random.normal(size=(6, 6)) * (1.0 - np.eye(6))
        m = np.eye(6) + beside
        found = search(np.ones(6), beside, A, room, v)
        best = min(minimize(power, random.normal(size=6), args=(m,)).fun for _ in range(15))
        assert found == pytest.approx(best, abs=1e-5)


def test_the_work_class_vehicle_has_its_eight_thrusters():
    """Symmetric to its middle plane, in balance ahead, and all six axes can be had; in water it rises a little."""
    hull = RovHull(preset="Berg 2012, SF 30k")
    hull.initialize(0.0)
    T = hull.arguments[0].thrusters
    assert np.linalg.matrix_rank(T) == 6
    np.testing.assert_allclose(T[:, 4:6].sum(axis=1)[[1, 2, 3, 5]], 0.0, atol=1e-15)
    np.testing.assert_allclose(T[:, :4].sum(axis=1)[[0, 1, 3, 4, 5]], 0.0, atol=1e-12)
    assert T[2, :4] == pytest.approx([-np.sin(np.radians(74.53))] * 4)  # they lift
    assert 0.0 < hull["restoring.buoyancy"] - hull["restoring.weight"] < 0.02 * hull["restoring.weight"]
