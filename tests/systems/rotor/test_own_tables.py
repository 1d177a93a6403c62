"""Supports and disks from tables: closed forms, an independent integration of a run-up, the same numbers without a table."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.disks import DEFAULT_DISKS
from cosimo.components.rotor.modal import critical_speeds, critical_speeds_of, eigenvalues, modes
from cosimo.orchestrator.harness.validation.case import Options, outcome
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.rotor.cases import ross_examples
from cosimo.tests.support import initialized
from scipy.integrate import solve_ivp

pytestmark = pytest.mark.interpreted

HEAD = "position [m],speed [rad/s],kxx [N/m],kxy [N/m],kyx [N/m],kyy [N/m],cxx [N.s/m],cxy [N.s/m],cyx [N.s/m],cyy [N.s/m]\n"
ROWS = "0,100,3e5,1e5,-2e5,5e5,300,20,-40,500\n0,300,5e5,3e5,-4e5,9e5,100,-20,-60,200\n"
DISK = "position [m],mass [kg],Ip [kg.m2],Id [kg.m2]\n"
SPRINGS = "position [m],kxx [N/m],kyy [N/m],cxx [N.s/m],cyy [N.s/m]\n0,1e6,2e6,30,40\n1.5,3e6,4e6,50,60\n"
GIVEN = {
    f"linear_supports.{n}_{axis}[{k}]": v
    for (n, axis), values in {
        ("stiffness", "x"): (1e6, 3e6),
        ("stiffness", "y"): (2e6, 4e6),
        ("damping", "x"): (30.0, 50.0),
        ("damping", "y"): (40.0, 60.0),
    }.items()
    for k, v in enumerate(values, 1)
}


def rotor(effects=("support_table",), **parameters) -> BeamRotor:
    return initialized(BeamRotor(effects, {"element": 0.25} | {n.replace("__", "."): v for n, v in parameters.items()}))


@pytest.mark.known_answers(BeamRotor=("support_table", "disk_table"))
@pytest.mark.parametrize(("speed", "share"), [(100.0, 0.0), (150.0, 0.25), (300.0, 1.0)])
def test_a_mass_on_a_support_that_couples_x_and_y(speed, share):
    """20 kg on a shaft without mass, which turns about the only support: the eigenvalues of two equations, between the rows, too."""
    found = eigenvalues(
        rotor(
            ("disks", "disk_table", "support_table"),
            density=1e-4,
            start_speed=speed,
            support_table__table=HEAD + ROWS,
            disk_table__table=DISK + "0,20,0,0\n",
        ).matrices(),
        speed,
    )
    first, last = (np.array([float(cell) for cell in row.split(",")[2:]]) for row in ROWS.split())
    kxx, kxy, kyx, kyy, cxx, cxy, cyx, cyy = first + share * (last - first)
    system = np.zeros((4, 4))
    system[:2, 2:] = np.eye(2)
    system[2:] = -np.array([[kxx, kxy, cxx, cxy], [kyx, kyy, cyx, cyy]]) / 20.0
    exact = np.linalg.eigvals(system)
    assert max(np.abs(found - value).min() / abs(value) for value in exact) < 1e-6  # the shaft has 4e-10 of the mass
    assert exact.real.max() > 0.0  # kxy and kyx of opposite signs drive it


@pytest.mark.parametrize("effects", [("disks", "gravity"), ("disks", "gyroscopic", "frame_rotation", "internal_damping")])
def test_springs_from_a_table_are_those_without(effects):
    ends = []
    for how in ({"support_table.table": SPRINGS}, GIVEN):
        unit = rotor((*effects, next(iter(how)).partition(".")[0]), **{n.replace(".", "__"): v for n, v in how.items()})
        unit.set("force_x", 30.0)
        for k in range(5):
            unit.step(k * 1e-3, 1e-3)
        ends.append(unit)
    table, numbers = ends
    np.testing.assert_allclose(table.y, numbers.y, rtol=1e-10)
    assert table.energy() == pytest.approx(numbers.energy(), rel=1e-9)
    for a, b in zip(table.matrices(), numbers.matrices(), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-15, atol=1e-15 * np.abs(b).max())


def test_disks_from_a_table_in_any_order_are_those_without():
    rows = [
        f"{z},{d.mass!r},{d.polar_inertia!r},{d.diametral_inertia!r}\n" for z, d in zip((0.5, 1.0), DEFAULT_DISKS, strict=False)
    ]
    plain = rotor(("disks", "gyroscopic", "unbalance", "linear_supports"))
    table = rotor(("disks", "gyroscopic", "unbalance", "linear_supports", "disk_table"), disk_table__table=DISK + "".join(rows))
    turned = rotor(("disks", "gyroscopic", "linear_supports", "disk_table"), disk_table__table=DISK + "".join(reversed(rows)))
    for a, b, c in zip(plain.matrices(), table.matrices(), turned.matrices(), strict=True):
        np.testing.assert_allclose(b, a, rtol=1e-15)
        np.testing.assert_allclose(c, a, rtol=1e-15)
    for unit in (plain, table):
        unit.step(0.0, 1e-3)
    np.testing.assert_allclose(plain.x[:24], table.x[:24], rtol=1e-12, atol=1e-18)


def test_a_run_up_follows_the_rows():
    """Through a row at 1000 rad/s²: an independent integration of the equations between the matrices of the rows."""
    effects = ("disks", "gyroscopic", "unbalance", "support_table", "run_up")
    right = ROWS.replace("0,100,", "1.5,100,").replace("0,300,", "1.5,300,")
    middle = "0,200,2e5,2e5,-2e5,6e5,200,0,0,300\n"
    first, last = ROWS.splitlines(keepends=True)
    given = {"start_speed": 190.0, "run_up__acceleration": 1000.0, "run_up__end_speed": 215.0, "substep": 4e-5, "element": 0.75}
    unit = rotor(effects, support_table__table=HEAD + first + middle + last + right, watched_position=0.0, **given)
    low, row, high = (unit.matrices(v) for v in (100.0, 200.0, 300.0))  # rows; linear between them
    N, inverse = 4 * unit.nodes.size, np.linalg.inv(row.mass)
    node = int(np.abs(unit.nodes - 0.5).argmin())

    def rate(t, z):
        turning = t < 0.025
        speed = 190.0 + 1000.0 * t if turning else 215.0
        gained = 190.0 * t + 500.0 * t * t if turning else 190.0 * 0.025 + 500.0 * 0.025**2 + 215.0 * (t - 0.025)
        near, share, force = low if speed < 200.0 else high, abs(speed - 200.0) / 100.0, np.zeros(N)
        stiffness = row.stiffness + share * (near.stiffness - row.stiffness)
        damping = row.damping + share * (near.damping - row.damping)
        ahead, beside = 1e-3 * speed**2, 1e-3 * 1000.0 * turning
        force[4 * node] = ahead * np.cos(gained) + beside * np.sin(gained)
        force[4 * node + 1] = ahead * np.sin(gained) - beside * np.cos(gained)
        force -= stiffness @ z[:N] + (damping + speed * row.gyroscopic) @ z[N:]
        return np.concatenate((z[N:], inverse @ force))

    start = unit.x[: 2 * N].copy()
    exact = start
    for a, b in ((0.0, 0.01), (0.01, 0.025), (0.025, 0.04)):  # a row, the end of the ramp
        exact = solve_ivp(rate, (a, b), exact, method="DOP853", rtol=1e-9, atol=1e-14).y[:, -1]
    for k in range(40):
        unit.step(k * 1e-3, 1e-3)
    size = np.abs(exact[:N]).max()
    np.testing.assert_allclose(unit.x[:N], exact[:N], rtol=0.0, atol=1e-3 * size)
    held = rotor(effects, support_table__table=HEAD + first + right.splitlines()[0] + "\n", watched_position=0.0, **given)
    for k in range(40):
        held.step(k * 1e-3, 1e-3)
    assert np.abs(held.x[:N] - exact[:N]).max() > 0.05 * size  # supports that stayed as they are at 100 rad/s


def test_critical_speeds_of_supports_that_follow_the_speed():
    table = "position [m],speed [rpm],kxx [MN/m],kyy [MN/m],cxx [N.s/m]\n" + "".join(
        f"{z},0,0.5,0.6,0\n{z},6000,8,9,0\n" for z in (0.0, 1.5)
    )
    unit = rotor(("disks", "gyroscopic", "support_table"), support_table__table=table)
    assert unit.speeds_of_supports() == pytest.approx((0.0, 200.0 * np.pi))
    found = critical_speeds_of(unit.matrices, np.linspace(0.0, 200.0 * np.pi, 31))
    assert found.size >= 4
    for speed in found:
        assert np.abs(modes(unit.matrices(speed), speed).frequency - speed).min() < 1e-6 * speed
    grid = np.linspace(1.0, 200.0 * np.pi, 400)  # no whirl meets its speed elsewhere
    ahead = np.array([modes(unit.matrices(w), w, 6).frequency - w for w in grid])
    assert (np.diff(np.sign(ahead), axis=0) != 0).sum() == found.size
    fixed = rotor(("disks", "gyroscopic", "linear_supports")).matrices()
    same = critical_speeds_of(lambda speed: fixed, np.linspace(0.0, 400.0, 21))
    np.testing.assert_allclose(same, critical_speeds(fixed)[: same.size], rtol=1e-9)
    assert same.size == 4


@pytest.mark.parametrize(
    ("effect", "table", "expected"),
    [
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n", "a row for each support"),
        ("support_table", "position [m],kxx [N/m]\n0,1e6\n", "no column 'cxx'"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n0,1e6,\n", "line 2: got no number of 'cxx'"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n0,1e6,1\n0,2e6,1\n", "line 3: got speed 0 rad/s behind 0 rad/s"),
        ("support_table", "position [m],frequency [rpm],kxx [N/m],cxx [N.s/m]\n0,20,1e6,1\n0,10,2e6,1\n", "speeds that rise"),
        ("support_table", "position [m],speed [rpm],frequency [rpm],kxx [N/m],cxx [N.s/m]\n0,20,1,1e6,1\n", "column 'speed"),
        ("support_table", "position [m],kxx [N],cxx [N.s/m]\n0,1e6,1\n", "N/m"),
        ("support_table", "position [m],kxx,cxx [N.s/m]\n0,1e6,1\n", "a name with its unit"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m],mxx [kg]\n0,1e6,1,1\n", "column 'mxx"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n2,1e6,1\n", "a support at 2 m"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n-0.1,1e6,1\n", "a support at -0.1 m"),
        ("support_table", HEAD + ROWS.replace("0,100,", "0,200,"), "a speed of 100 rad/s"),
        ("disk_table", DISK, "a row for each disk"),
        ("disk_table", DISK + "0.5,10,0.1,\n", "line 2: got a disk at 0.5 m with 10 kg, Ip 0.1 and Id nan"),
        ("disk_table", DISK + "0.5,-10,0.1,0.1\n", "numbers of 0 or more"),
        ("disk_table", DISK + "0.5,0,0,0\n", "a mass or an inertia"),
        ("disk_table", "position [m],mass [kg],m [kg],Ip [kg.m2],Id [kg.m2]\n0,1,1,1,1\n", "2 columns of mass"),
        ("disk_table", "position [m],Ip [kg.m2],Id [kg.m2]\n0,1,1\n", "0 columns of mass"),
        ("disk_table", DISK + "1.6,10,0.1,0.1\n", "a disk at 1.6 m"),
        ("disk_table", DISK + "0.6,10,0.22,0.1\n", "a disk at 0.6 m with a polar inertia.*Are Ip and Id exchanged"),
        ("support_table", "position [m],frequency [Hz],kxx [N/m],cxx [N.s/m]\n0,20,1e6,1\n", "1 Hz or 1 1/s is 60 rpm"),
        ("support_table", "position [m],kxx [N/m],cxx [N.s/m]\n300 mm,1e6,1\n0.3,1e6,1\n", "line 3: .* support at 0.3 m"),
    ],
)
def test_a_table_that_cannot_be_used_is_one_message(effect, table, expected):
    with pytest.raises(BadInput, match=expected):
        rotor(("disks", effect), **{f"{effect}__table": table})


def test_a_run_up_beyond_the_rows_is_refused_where_it_starts():
    with pytest.raises(BadInput, match=r"a speed of 400 rad/s.*Add rows"):
        rotor(("support_table", "run_up"), support_table__table=HEAD + ROWS, run_up__end_speed=400.0)
    unit = rotor(support_table__table=HEAD + ROWS)
    with pytest.raises(BadInput, match="a speed of 301 rad/s"):
        unit.matrices(301.0)
    rotor(support_table__table=HEAD + "0,100,3e5,1e5,-2e5,5e5,300,20,-40,500\n", start_speed=-5000.0)  # one row: any speed


def test_an_unbalance_needs_a_row_of_the_table():
    with pytest.raises(BadInput, match="unbalance at a disk"):
        rotor(("disks", "disk_table", "unbalance"), disk_table__table=DISK + "0.5,10,0.1,0.1\n", **{"unbalance__moment[2]": 1e-3})


@pytest.mark.full
def test_supports_with_another_sign_fail(monkeypatch):
    """Of one coupling: the decays of the rotor on coupled supports show it, and rotors on springs do not."""
    turned = ross_examples.EXAMPLES["journals"].supports.replace("-1.5,8.0", "1.5,8.0")
    monkeypatch.setitem(ross_examples.EXAMPLES, "journals", ross_examples.EXAMPLES["journals"]._replace(supports=turned))
    findings = cases()["ross-examples"].findings(Options(in_process=True))
    assert outcome(findings.rows) == "failed"
    wrong = {".".join(r.reference.measure.split(".")[:2]) for r in findings.rows if not r.inside}
    assert wrong == {"journals.100"}


def test_the_effects_exclude_one_another():
    with pytest.raises(BadInput, match="linear_supports"):
        BeamRotor(("support_table", "linear_supports"))
