"""A shaft of sections from a table: against the exact solution of the continuous shaft, which has no elements."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rotor.beam import BeamRotor
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from scipy.linalg import eigh, expm
from scipy.optimize import brentq

pytestmark = pytest.mark.interpreted

STIFF = 2e7  # N/m, of the springs at both ends
SUPPORTS = {f"linear_supports.{n}[{k}]": STIFF for n in ("stiffness_x", "stiffness_y") for k in (1, 2)}
SUPPORTS |= {"linear_supports.position[1]": 0.0, "linear_supports.position[2]": 1.3}
E, G, RHO = 211e9, 81.2e9, 7810.0
SECTIONS = ((0.3, 0.05, 0.0, E, G, RHO), (0.6, 0.09, 0.04, 70e9, 26e9, 2700.0), (0.4, 0.06, 0.0, E, G, RHO))
TABLE = (
    "length [mm];outer_diameter [mm];inner_diameter [mm];youngs_modulus [GPa];shear_modulus [GPa];density [kg/m3]\n"
    "300;50;0;;;\n600;90;40;70;26;2700\n400;60;0;;;\n"
)


def rotor(table: str, element: float = 0.1, effects=("linear_supports",), **parameters) -> BeamRotor:
    return initialized(BeamRotor(["shaft_table", *effects], {"shaft_table.table": table, "element": element, **parameters}))


def properties(row) -> tuple[float, float, float, float]:
    """EI, kappa G A with Cowper's coefficient as his paper has it, rho A and rho I of a circular section."""
    _, outer, inner, young, shear, density = row
    area, second = np.pi / 4.0 * (outer**2 - inner**2), np.pi / 64.0 * (outer**4 - inner**4)
    nu, m = young / (2.0 * shear) - 1.0, inner / outer
    kappa = 6.0 * (1.0 + nu) * (1.0 + m * m) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + m * m) ** 2 + (20.0 + 12.0 * nu) * m * m)
    return young * second, kappa * shear * area, density * area, density * second


def determinant(omega: float) -> float:
    """Of the continuous Timoshenko shaft on two springs: 0 at a natural frequency, rad/s. State: w, rotation, moment, shear force."""
    through = np.eye(4)
    for row in SECTIONS:
        bending, shear, mass, inertia = properties(row)
        along = np.zeros((4, 4))
        along[0, 1], along[0, 3], along[1, 2] = 1.0, 1.0 / shear, 1.0 / bending
        along[2, 1], along[2, 3], along[3, 0] = -inertia * omega**2, -1.0, -mass * omega**2
        through = expm(along * row[0]) @ through
    starts = np.array([[1.0, 0.0, 0.0, STIFF], [0.0, 1.0, 0.0, 0.0]]).T  # V = k w and no moment at the left end
    end = through @ starts
    return float(np.linalg.det(np.array([end[2], end[3] + STIFF * end[0]])))


def exact(count: int) -> np.ndarray:
    """The first natural frequencies, rad/s."""
    grid = np.linspace(50.0, 2.5e4, 4000)
    values = np.array([determinant(w) for w in grid])
    k = np.flatnonzero(values[:-1] * values[1:] < 0.0)[:count]
    return np.array([brentq(determinant, grid[i], grid[i + 1], xtol=1e-9) for i in k])


def frequencies(element: float) -> np.ndarray:
    """Of one plane of the rotor's matrices, rad/s, rising."""
    matrices = rotor(TABLE, element, **SUPPORTS).matrices()
    return np.sqrt(np.abs(eigh(matrices.stiffness, matrices.mass, eigvals_only=True)))[::2]


@pytest.mark.known_answers(BeamRotor="shaft_table")
def test_a_shaft_of_three_sections_has_the_frequencies_of_the_continuous_one():
    wanted = exact(4)
    errors = [np.abs(frequencies(element)[:4] / wanted - 1.0) for element in (0.1, 0.05, 0.025)]
    assert errors[-1].max() < 2e-4
    for k in range(4):
        assert slope((0.1, 0.05, 0.025), [e[k] for e in errors]) > 1.9


def test_its_static_deflection_is_exact():
    """Elements whose shapes are those of a shaft without load between the nodes: any mesh gives the exact compliance."""
    sideways = BeamRotor(
        ["shaft_table", "linear_supports"], {"shaft_table.table": TABLE, "element": 0.6, "watched_position": 0.5, **SUPPORTS}
    )
    sideways.set("force_x", 1000.0)
    sideways.initialize(0.0)
    left = 1000.0 * (1.3 - 0.5) / 1.3
    ends = np.cumsum([row[0] for row in SECTIONS])

    def energy(upper: float, force: float, from_left: bool) -> float:
        """Twice the elastic energy per force between an end and the load: bending and shear, each section by itself."""
        total = 0.0
        for start, end, row in zip((0.0, *ends[:-1]), ends, SECTIONS, strict=True):
            a, b = (start, end) if from_left else (1.3 - end, 1.3 - start)
            a, b = min(a, upper), min(b, upper)
            bending, shear, _, _ = properties(row)
            total += force**2 * ((b**3 - a**3) / (3.0 * bending) + (b - a) / shear)
        return total

    right = 1000.0 - left
    work = energy(0.5, left, True) + energy(0.8, right, False) + (left**2 + right**2) / STIFF
    assert sideways["displacement_x"] == pytest.approx(work / 1000.0, rel=1e-11)


def test_a_uniform_shaft_cut_in_three_is_the_uniform_shaft():
    parts = "length [mm];outer_diameter [mm]\n500;50\n250;50\n750;50\n"
    effects, given = ("gyroscopic", "disks", "linear_supports"), {"element": 0.25}
    cut, whole = rotor(parts, 0.25, effects), BeamRotor(effects, given)
    whole.initialize(0.0)
    for a, b in zip(cut.matrices(), whole.matrices(), strict=True):
        assert a == pytest.approx(b, rel=1e-14, abs=1e-12 * max(np.abs(b).max(), 1e-300))


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("length [mm];outer_diameter [mm]\n", "a row for each section"),
        ("length [mm];outer_diameter [mm]\n500;50\n0;50\n", "line 3: got a section 0 m long"),
        ("length [mm];outer_diameter [mm];inner_diameter [mm]\n500;50;50\n", "and a wall"),
        ("length [mm];outer_diameter [mm]\n500;\n", "a section 0.5 m long, 0 m within and nan m without"),
        ("length [mm];outer_diameter [mm];density [kg/m3]\n500;50;-1\n", "a modulus or a density of 0 or less"),
        ("length [mm];diameter [mm]\n500;50\n", "column 'diameter "),
        ("length;outer_diameter [mm]\n500;50\n", "a name with its unit"),
        ("length [mm];outer_diameter [mm];youngs_modulus [GPa]\n500;50;500\n", "Poisson's ratio"),
        (
            "length [mm];outer_diameter [mm];youngs_modulus [GPa]\n500;50;70\n",
            "Poisson's ratio -0.56.*Give both moduli",
        ),  # aluminium
        ("length [mm];outer_diameter [mm];youngs_modulus [GPa]\n500;50;170\n", "Poisson's ratio 0.046.*Give both"),  # cast iron
    ],
)
def test_a_table_of_sections_that_cannot_be_used_is_one_message(table, expected):
    with pytest.raises(BadInput, match=expected):
        rotor(table, effects=())
