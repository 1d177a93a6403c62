"""The paper of the wrist: critical loads, roll and strains in other ways."""

import math

import numpy as np
import pytest
from cosimo.components.wrist.kinematics import forward, inverse
from cosimo.components.wrist.ligament_springs import COUNT, attachments
from cosimo.components.wrist.linkage import Linkage, position
from cosimo.orchestrator.systems.wrist.cases.paper_wrist.constraints import _strains, widest_in_closed_form
from cosimo.orchestrator.systems.wrist.cases.paper_wrist.four_bars import arcs, rocker_angle
from cosimo.orchestrator.systems.wrist.cases.paper_wrist.load import FIRST, SECOND, column, wrist_load
from cosimo.orchestrator.systems.wrist.cases.paper_wrist.postures import DEVIATIONS, FLEXIONS, STANDARD, TILTS, _rotation, axes
from scipy.spatial.transform import Rotation


def potential(load: float, q: np.ndarray) -> float:
    """Energy of the wrist with 1 N.m/rad under a load along the forearm that keeps its direction, J."""
    at = axes(STANDARD)
    n_p = np.array([math.sin(at.proximal_tilt), 0.0, math.cos(at.proximal_tilt)])
    n_d = np.array([-math.sin(at.distal_tilt), 0.0, math.cos(at.distal_tilt)])
    row = Rotation.from_rotvec(q[0] * n_p)
    hand = row * Rotation.from_rotvec(q[1] * n_d)
    tip = row.apply([0.0, FIRST, 0.0]) + hand.apply([0.0, SECOND, 0.0])
    flexion, deviation, _ = forward(float(q[0]), float(q[1]), at)
    return 0.5 * (flexion**2 + deviation**2) + load * float(tip[1])


@pytest.mark.parametrize(("share", "stable"), [(0.98, True), (1.02, False)])
def test_the_wrists_load_is_where_its_energy_is_no_longer_least_at_rest(share, stable):
    load = share * wrist_load(1.0)
    h = 1e-3
    hessian = np.array(
        [
            [
                (
                    potential(load, h * (a + b))
                    - potential(load, h * (a - b))
                    - potential(load, h * (b - a))
                    + potential(load, -h * (a + b))
                )
                / (4.0 * h * h)
                for b in np.eye(2)
            ]
            for a in np.eye(2)
        ]
    )
    assert (np.linalg.eigvalsh(hessian).min() > 0.0) == stable


def test_the_column_gives_way_where_its_stiffness_is_singular():
    for k1, k2 in ((1.0, 1.0), (8.59, 8.59), (2.0, 0.5)):
        load = column(k1, k2)
        stiffness = np.array([[k1 + k2 - load * FIRST, -k2], [-k2, k2 - load * SECOND]])
        assert np.linalg.eigvalsh(stiffness)[0] == pytest.approx(0.0, abs=1e-9)
        assert np.linalg.eigvalsh(stiffness)[1] > 0.0


def test_the_angle_of_the_hands_whole_rotation():
    for angles in ((0.4, -0.3, 0.1), (1.0, 0.2, -0.1), (-0.8, -0.4, 0.05)):
        whole = Rotation.from_euler("ZXY", angles).magnitude()
        assert _rotation(*angles) == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("name", TILTS)
def test_shares_of_the_rows_are_the_closed_forms(name):
    first, second = np.radians(TILTS[name])
    small = 1e-4
    q1, _, _ = inverse(small, 0.0, axes(name))
    assert q1 * math.cos(first) / small == pytest.approx(math.cos(first) * math.sin(second) / math.sin(first + second), rel=1e-6)
    q1, _, _ = inverse(0.0, small, axes(name))
    assert q1 * math.cos(first) / small == pytest.approx(math.cos(first) * math.cos(second) / math.sin(first + second), rel=1e-6)


def test_pairs_with_an_end_on_the_axis_do_not_stretch_at_all():
    assert np.abs(_strains(attachments(np.zeros(COUNT)))).max() < 1e-12
    near = _strains(attachments(np.full(COUNT, 1e-3)))
    assert 0.01 < near.max() < 0.05  # the page's statement on attachments within a millimetre


def test_ends_that_keep_a_ligament_isometric_are_those_of_the_closed_form():
    """With that distance from the axis the law of cosines gives 5 % at the largest angle."""
    r = widest_in_closed_form()
    most = max(abs(inverse(f, d, axes(STANDARD))[0]) for f in FLEXIONS.tolist() for d in DEVIATIONS.tolist())
    lever, angle = 12e-3, 0.7 * most
    length = math.sqrt(lever**2 + r**2 - 2.0 * lever * r * math.cos(angle))
    assert length / (lever - r) == pytest.approx(1.05, rel=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_spherical_four_bar_of_short_arcs_is_the_planar_one(sign):
    lengths = np.array([0.055, 0.020, 0.050, 0.040])  # ground, crank, coupler, rocker
    planar = Linkage(0.020, 0.050, 0.040, 0.055, sign, 0.0, 0.0)
    for angle in (0.3, 1.5, 3.0, 5.0):
        off = rocker_angle(angle, -sign, *(1e-2 * lengths)) - position(angle, planar)[0]
        assert math.remainder(off, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", TILTS)
def test_the_rows_in_one_plane_are_the_closed_forms_of_their_four_bars(name):
    """Of other tilts, too, and by the tangents, which the general linkage does not use."""
    at = axes(name)
    e = math.tan(at.proximal_tilt + at.distal_tilt)
    s, c = math.sin(at.proximal_tilt), math.cos(at.proximal_tilt)
    for f, d in ((0.9, 0.0), (-0.4, 0.0), (0.0, 0.3), (0.0, -0.4)):
        q1 = inverse(f, d, at)[0]
        plane = int(d != 0.0)
        below = c + e * s * math.cos(q1) if plane else e * c * math.cos(q1) - s
        assert math.atan(math.sin(q1) * e / below) == pytest.approx(f + d, abs=1e-12)
        crank, sign = (q1 + math.pi, -1.0) if plane else (q1, 1.0)
        assert rocker_angle(crank, sign, *arcs(plane, at)) == pytest.approx(0.5 * math.pi + f + d, abs=1e-12)
