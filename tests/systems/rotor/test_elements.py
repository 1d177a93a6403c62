"""Element matrices against their definition as integrals, and shafts against closed forms of beams."""

import math

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.elements import (
    Section,
    circular_section,
    element_mass,
    element_rotary_inertia,
    element_stiffness,
    shear_coefficient,
    solid_disk,
)
from cosimo.components.rotor.modal import modes
from cosimo.components.rotor.model import DOFS, WIDTH, assemble_shaft, dense, most_nodes, place_nodes, turn
from cosimo.tests.slopes import slope

STEEL = (211e9, 81.2e9, 7810.0)


def nodes_of(length: float, fixed: list[float], element: float) -> np.ndarray:
    nodes = np.full(most_nodes(length, element, len(fixed)), np.nan)
    return nodes[: place_nodes(length, np.array([0.0, 0.0, *fixed]), element, nodes)]


def bands_of(section: Section, nodes: np.ndarray) -> np.ndarray:
    """Deflection's and tilting's inertia and stiffness of a bare shaft, (3, N, 15)."""
    bands = np.full((3, DOFS * nodes.size, WIDTH), np.nan)
    assemble_shaft(np.array([[nodes[-1], *section]]), nodes, *bands, np.zeros((4, 4)))
    return bands


def shapes(section: Section, L: float, z: float):
    """Deflection and section rotation of a Timoshenko beam without load between its ends, for unit (w, rotation) at either.

    Solved from the differential equations instead of taken from the element: w = a + b z + c z² + d z³, and the rotation is
    w' less the shear angle, which is V / (kappa G A) with V = -EI w'''.
    """
    shear = 6.0 * section.bending / section.shear  # rotation = b + 2 c z + 3 d z² + shear * d

    def rows(x):
        return [1.0, x, x**2, x**3], [0.0, 1.0, 2.0 * x, 3.0 * x**2 + shear]

    ends = np.array([*rows(0.0), *rows(L)])
    coefficients = np.linalg.inv(ends)
    w, rotation = (np.array(r) @ coefficients for r in rows(z))
    curvature = np.array([0.0, 0.0, 2.0, 6.0 * z]) @ coefficients
    shear_angle = np.array([0.0, 0.0, 0.0, -shear]) @ coefficients
    return w, rotation, curvature, shear_angle


@pytest.mark.parametrize("slenderness", [0.3, 2.0, 50.0])
def test_element_matrices_are_the_integrals_of_their_shapes(slenderness):
    section = circular_section(0.1, 0.04, *STEEL)
    L = slenderness * 0.1
    nodes, weights = np.polynomial.legendre.leggauss(6)  # exact up to degree 11; mass needs 6
    integrals = np.zeros((3, 4, 4))
    for x, weight in zip(0.5 * L * (nodes + 1.0), 0.5 * L * weights, strict=True):
        w, rotation, curvature, shear_angle = shapes(section, L, x)
        integrals[0] += weight * section.mass * np.outer(w, w)
        integrals[1] += weight * section.inertia * np.outer(rotation, rotation)
        integrals[2] += weight * section.bending * np.outer(curvature, curvature)
        integrals[2] += weight * section.shear * np.outer(shear_angle, shear_angle)
    for function, expected in zip((element_mass, element_rotary_inertia, element_stiffness), integrals, strict=True):
        # rounding: the inverse of the end values has a condition of up to 1e6 for the shortest and the longest element
        function(section, L, matrix := np.zeros((4, 4)))
        np.testing.assert_allclose(matrix, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_cowpers_coefficient():
    """Printed values: 0.886 for a solid circle with nu = 0.3, 0.9 in Cowper's table for nu = 0.5; thin tube 2(1+nu)/(4+3nu)."""
    assert shear_coefficient(0.3, 0.0) == pytest.approx(0.886, abs=5e-4)  # three printed digits
    assert shear_coefficient(0.5, 0.0) == pytest.approx(0.9, abs=1e-12)
    assert shear_coefficient(0.3, 1.0) == pytest.approx(2.0 * 1.3 / 4.9, rel=1e-12)


def test_a_disk_of_no_width_has_twice_the_polar_inertia():
    disk = solid_disk(0.3, 0.1, 1e-9, 7810.0)
    assert disk.polar_inertia == pytest.approx(2.0 * disk.diametral_inertia, rel=1e-12)
    cylinder = solid_disk(0.3, 0.0, 0.3 * math.sqrt(3.0) / 2.0, 7810.0)
    # the solid cylinder whose inertias are equal: r²/2 = r²/4 + w²/12, w = sqrt(3) r
    assert cylinder.polar_inertia == pytest.approx(cylinder.diametral_inertia, rel=1e-12)


def test_rigid_motion_costs_nothing_and_has_the_whole_inertia():
    section = circular_section(0.05, 0.0, *STEEL)
    nodes = nodes_of(1.5, [0.4, 1.1], 0.2)
    deflection, rotary, stiffness = map(dense, bands_of(section, nodes))
    move_x, tilt_y, tilt_x = np.zeros((3, 4 * nodes.size))
    move_x[0::4] = 1.0
    tilt_y[0::4], tilt_y[3::4] = nodes, 1.0  # dx/dz = 1
    tilt_x[1::4], tilt_x[2::4] = -nodes, 1.0  # dy/dz = -1
    for motion in (move_x, tilt_y, tilt_x):
        # rounding of sums of terms of size |K| |q|
        assert np.abs(stiffness @ motion).max() <= 1e-12 * np.abs(stiffness).max()
        assert motion @ rotary @ motion == pytest.approx(0.0 if motion is move_x else section.inertia * 1.5, abs=1e-12)
    assert move_x @ deflection @ move_x == pytest.approx(section.mass * 1.5, rel=1e-12)
    for tilt in (tilt_x, tilt_y):
        assert tilt @ deflection @ tilt == pytest.approx(section.mass * 1.5**3 / 3.0, rel=1e-12)


def test_a_quarter_turn_commutes_with_the_shaft():
    bands = bands_of(circular_section(0.05, 0.0, *STEEL), nodes_of(1.0, [], 0.25))
    S = np.kron(np.eye(5), [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0]])
    for band in bands:
        A = dense(band)
        assert np.array_equal(A, A.T)
        turn(band, 1.0, turned := np.full_like(band, np.nan))
        assert np.array_equal(dense(turned), A @ S)
        assert np.array_equal(A @ S, S @ A)


def timoshenko_simply_supported(section: Section, length: float, n: int) -> float:
    """Lowest frequency of the n-th mode of a simply supported Timoshenko beam, rad/s.

    With w ~ sin(n pi z / L), rotation ~ cos(n pi z / L) the two equations of motion give a determinant of second degree in w².
    """
    k = n * math.pi / length
    a = section.mass * section.inertia
    b = section.mass * (section.bending * k**2 + section.shear) + section.inertia * section.shear * k**2
    c = section.shear * k**2 * section.bending * k**2
    return math.sqrt((b - math.sqrt(b * b - 4.0 * a * c)) / (2.0 * a))


def shaft_frequencies(element: float, length: float, diameter: float, count: int, effects=(), **parameters) -> np.ndarray:
    made = BeamRotor(
        effects, {"length": length, "outer_diameter": diameter, "element": element, "watched_position": 0.0, **parameters}
    )
    made.initialize(0.0)
    return modes(made.matrices(), 0.0, count).frequency


PINNED = {
    f"linear_supports.{n}[{k}]": v
    for k, z in ((1, 0.0), (2, 1.0))
    for n, v in (("position", z), ("stiffness_x", 1e14), ("stiffness_y", 1e14))
}


@pytest.mark.parametrize(
    ("diameter", "counts", "order"),
    [
        (0.005, (4, 8, 16), 4.0),  # m; cubic deflections, next to no shear
        (0.1, (16, 32, 64), 2.0),  # the shear angle is constant in an element
    ],
)
def test_simply_supported_beam_and_its_order_of_convergence(diameter, counts, order):
    section = circular_section(diameter, 0.0, *STEEL)
    exact = np.array([timoshenko_simply_supported(section, 1.0, n) for n in (1, 2, 3)])
    errors = []
    for n in counts:
        found = shaft_frequencies(1.0 / n, 1.0, diameter, 6, ["linear_supports"], **PINNED)[::2]
        errors.append(np.abs(found / exact - 1.0))
    assert errors[-1].max() < 2e-4
    slopes = [slope(1.0 / np.array(counts), of_mode) for of_mode in np.transpose(errors)]
    np.testing.assert_allclose(slopes, order, atol=0.2)  # the third mode has 4 elements for three half waves


def test_shear_and_rotary_inertia_matter_in_a_thick_shaft():
    section = circular_section(0.1, 0.0, *STEEL)
    exact = np.array([timoshenko_simply_supported(section, 1.0, n) for n in (1, 2, 3)])
    euler = (np.array([1, 2, 3]) * math.pi) ** 2 * math.sqrt(section.bending / section.mass)
    assert (euler / exact - 1.0 > [0.01, 0.04, 0.09]).all()  # the simpler theory is far off


def test_free_slender_shaft_is_an_euler_bernoulli_beam():
    """cos x cosh x = 1 at 4.730, 7.853, 10.996; two thousandths of slenderness leave (pi n r / L)² of shear, below 1e-4."""
    section = circular_section(0.004, 0.0, *STEEL)
    found = shaft_frequencies(0.05, 2.0, 0.004, 10)
    exact = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671]) ** 2 / 4.0
    exact *= math.sqrt(section.bending / section.mass)
    bending = found[found > 1e-3 * exact[0]]
    np.testing.assert_allclose(bending[:6:2], exact, rtol=1e-4)


@pytest.mark.known_answers(BeamRotor="disks")
def test_disk_in_the_middle_of_a_light_shaft_is_the_jeffcott_rotor():
    """k = 48 EI / L³ with the shear added in series, L / (4 kappa G A)."""
    section = circular_section(0.03, 0.0, 211e9, 81.2e9, 1e-3)
    stiffness = 1.0 / (1.0 / (48.0 * section.bending) + 0.25 / section.shear)
    disk = {f"disks.{n}[{k}]": 0.0 for n in ("mass", "polar_inertia", "diametral_inertia") for k in (1, 2)}
    found = shaft_frequencies(
        0.5,
        1.0,
        0.03,
        2,
        ["disks", "linear_supports"],
        density=1e-3,
        **{**PINNED, **disk, "disks.mass[1]": 20.0, "disks.position[1]": 0.5},
    )
    # the shaft's own mass, 7e-7 kg, and the supports, 1e14 N/m, are below 1e-7 of it
    np.testing.assert_allclose(found, math.sqrt(stiffness / 20.0), rtol=1e-6)


def test_nodes_stand_at_every_given_place():
    nodes = nodes_of(1.5, [0.5, 0.5 + 1e-9, 1.2], 0.25)
    assert nodes.size == 8  # 2, 3 and 2 elements
    assert {0.0, 0.5, 1.2, 1.5} <= set(np.round(nodes, 9))
    assert np.diff(nodes).max() <= 0.25 * (1.0 + 1e-6)


def test_there_is_room_for_the_nodes_of_any_places():
    rng = np.random.default_rng(2)
    for _ in range(300):
        length, fixed = rng.uniform(0.1, 3.0), int(rng.integers(0, 9))
        element = length / rng.uniform(0.3, 40.0)
        nodes = nodes_of(length, (length * rng.uniform(size=fixed)).tolist(), element)
        assert nodes[0] == 0.0
        assert nodes[-1] == length
        assert (np.diff(nodes) > 0.0).all()
        assert nodes.size <= most_nodes(length, element, fixed) - 1
