"""Ligaments of the wrist: lengths by the law of cosines, isometry, springs, reciprocity, unit and effect, cuts, rigid ones."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.wrist.kinematics import DEFAULT_AXES, DISTAL_TILT, OPENSIM_HALF, PROXIMAL_TILT, ROW_OFFSET, RULES, Axes
from cosimo.components.wrist.ligament_springs import (
    LIGAMENTS,
    SLACK,
    attachments,
    bundle_pull,
    end_of_bone,
    end_of_hand,
    lengths,
    spring_tension,
)
from cosimo.components.wrist.ligaments import LigamentBundle
from cosimo.components.wrist.wrist import Wrist
from cosimo.components.wrist.wrist_equations import wrist_derivatives
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

AXES = DEFAULT_AXES._replace(offset=ROW_OFFSET)
HALF = Axes(OPENSIM_HALF, 0.0, 0.0, ROW_OFFSET)
# along the axis, distances of the first and the second end from it, share of the angle: of each ligament, m
SHAPES = {
    "lunate_radius": (0.0, 12e-3, 3e-3, 0.7),
    "trapezium_scaphoid": (0.0, 8e-3, 3e-3, 1.0),
    "scapho_lunate": (5e-3, 6e-3, 3e-3, 0.3),
    "luno_triquetral": (6e-3, 6e-3, 3e-3, 0.15),
    "radio_triquetral": (18e-3, 14e-3, 3e-3, 0.85),
}
ISOMETRIC = {f"constraint.off_axis[{j}]": 0.0 for j in range(1, 6)}
TAUT = {"prestrain": 0.05, "toe": 0.02}


def bundle(**parameters) -> LigamentBundle:
    return initialized(LigamentBundle((), parameters))


def wrist(parameters=None, effects=("morphology", "constraint")) -> Wrist:
    return initialized(Wrist(effects, parameters or {}))


def ligaments(**parameters):
    return bundle(**parameters).arguments[0].ligaments


# -- lengths ---------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", LIGAMENTS)
@pytest.mark.parametrize("angle", [-0.8, -0.1, 0.0, 0.5])
def test_length_is_by_the_law_of_cosines(name, angle):
    along, far, beside, share = SHAPES[name]
    j = LIGAMENTS.index(name)
    expected = math.sqrt(along**2 + far**2 + beside**2 - 2.0 * far * beside * math.cos(share * angle))
    q = (0.3, angle) if name == "trapezium_scaphoid" else (angle, 0.3)  # each length depends on one angle only
    length, *slopes = lengths(*q, AXES, ligaments())[j]
    assert length == pytest.approx(expected, rel=1e-14)
    slope = far * beside * share * math.sin(share * angle) / expected
    assert slopes == pytest.approx([0.0, slope] if name == "trapezium_scaphoid" else [slope, 0.0], abs=1e-17)


@pytest.mark.parametrize("axes", [AXES, HALF, Axes(RULES, 0.1, 0.9, 0.015)])
def test_ends_and_lengths_have_their_derivatives(axes):
    """Also about other axes than those to which the ends were given, and with equal shares: lengths depend on both angles."""
    q, d, there = (0.4, -0.3), 1e-6, ligaments()
    for i, step in enumerate(d * np.eye(2)):
        after, before = (lengths(*(q + sign * step), axes, there)[:, 0] for sign in (1.0, -1.0))
        assert lengths(*q, axes, there)[:, 1 + i] == pytest.approx((after - before) / (2.0 * d), abs=1e-11)
        for end in (
            lambda q: end_of_bone(q[0], q[1], 0.7, axes, (0.01, -0.02, 0.03)),
            lambda q: end_of_hand(q[0], q[1], axes, (0.01, 0.02, 0.03)),
        ):
            difference = (np.array(end(q + step)[0]) - end(q - step)[0]) / (2.0 * d)
            assert end(q)[1 + i] == pytest.approx(difference, abs=1e-10)


def test_ends_on_the_axis_make_isometric_ligaments():
    made = ligaments(**{f"off_axis[{j}]": 0.0 for j in range(1, 6)})
    rest = lengths(0.0, 0.0, AXES, made)[:, 0]
    for q in ((0.9, -0.4), (-0.7, 0.8), (0.5, 0.9)):
        assert lengths(*q, AXES, made)[:, 0] == pytest.approx(rest, rel=1e-14)
    moved = lengths(0.3, 0.3, Axes(RULES, PROXIMAL_TILT + 0.1, DISTAL_TILT + 0.1, ROW_OFFSET), made)[:, 0]
    assert abs(moved[1] / rest[1] - 1.0) > 1e-3  # trapezium-scaphoid and radio-triquetral are not, about an axis that was moved
    assert abs(moved[4] / rest[4] - 1.0) > 1e-3
    assert moved[0] == pytest.approx(rest[0], rel=1e-14)  # the lunate's end is the axis' centre


def test_ends_lie_where_they_are_said_to():
    for row, name in zip(attachments(np.full(5, 3e-3)), LIGAMENTS, strict=True):
        along, far, beside, _ = SHAPES[name]
        assert np.linalg.norm(row[3:] - row[:3]) == pytest.approx(math.hypot(along, far - beside), rel=1e-12)


# -- springs ----------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("toe", [0.0, 0.03])
def test_tension_is_toe_linear_and_its_energy_is_its_integral(toe):
    strains = np.linspace(-0.02, 0.1, 2401)
    tension, energy = np.array([spring_tension(s, toe) for s in strains]).T
    assert (tension[strains <= 0.0] == 0.0).all()
    if toe:
        assert tension[np.searchsorted(strains, 0.015)] == pytest.approx(0.015**2 / 0.06, rel=1e-9)
    assert tension[-1] == pytest.approx(0.1 - 0.5 * toe, rel=1e-12)
    middle = np.array([spring_tension(s, toe)[0] for s in 0.5 * (strains[1:] + strains[:-1])])
    simpson = np.cumsum((tension[1:] + tension[:-1] + 4.0 * middle) / 6.0 * np.diff(strains))
    assert energy[1:] == pytest.approx(simpson, abs=1e-10)


@pytest.mark.parametrize("prestrain", [-0.2, 0.0, 0.05])
def test_prestrain_is_the_strain_at_rest(prestrain):
    made = bundle(prestrain=prestrain, toe=0.0)
    assert [made[f"strain[{j}]"] for j in range(1, 6)] == pytest.approx([prestrain] * 5, abs=1e-15)
    slack = made.arguments[0].ligaments[:, SLACK]
    assert [made[f"tension[{j}]"] for j in range(1, 6)] == pytest.approx(5e4 * slack * max(prestrain, 0.0), abs=1e-9)


def test_tension_grows_with_the_rate_and_never_pushes():
    made = bundle(damping=0.2, **TAUT)
    for rate in (2.0, -2.0, -2000.0):
        made.set("proximal_angle", 0.3)
        made.set("proximal_rate", 0.0)
        made.refresh()
        still, slack = made["tension[1]"], made.arguments[0].ligaments[0, SLACK]
        made.set("proximal_rate", rate)
        made.refresh()
        slope = lengths(0.3, 0.0, AXES, made.arguments[0].ligaments)[0, 1]
        assert made["tension[1]"] == pytest.approx(still * max(0.0, 1.0 + 0.2 * slope * rate / slack), rel=1e-12)
        assert made["dissipation"] >= 0.0


@pytest.mark.parametrize("axes", [AXES, HALF])
@pytest.mark.parametrize("q", [(0.3, -0.2), (-0.6, 0.5), (0.1, 0.7)])
def test_torques_are_the_slopes_of_one_energy_and_stiffness_is_reciprocal(axes, q):
    there, d = ligaments(**TAUT), 1e-5

    def torques(q):
        return np.array(bundle_pull(q[0], q[1], 0.0, 0.0, axes, there)[:2])

    def energy(q):
        return bundle_pull(q[0], q[1], 0.0, 0.0, axes, there)[2]

    slopes = [(energy(q + step) - energy(q - step)) / (2.0 * d) for step in d * np.eye(2)]
    assert torques(q) == pytest.approx(-np.array(slopes), abs=1e-8)
    stiffness = np.array([(torques(q + step) - torques(q - step)) / (2.0 * d) for step in d * np.eye(2)])
    assert stiffness[0, 1] == pytest.approx(stiffness[1, 0], abs=1e-8)
    if axes.model == OPENSIM_HALF:
        assert abs(stiffness[0, 1]) > 1e-3  # rules: each ligament depends on one angle, and the two do not couple


def test_one_cut_takes_away_that_one():
    whole = bundle(**TAUT, proximal_angle=0.4, distal_angle=-0.3)
    for j, name in enumerate(LIGAMENTS):
        cut = bundle(**TAUT, proximal_angle=0.4, distal_angle=-0.3, cut=j + 1)
        _, first, second = lengths(0.4, -0.3, AXES, whole.arguments[0].ligaments)[j]
        tension = whole[f"tension[{j + 1}]"]
        assert tension > 0.0, name
        assert cut[f"tension[{j + 1}]"] == 0.0
        assert cut[f"strain[{j + 1}]"] == whole[f"strain[{j + 1}]"]
        assert cut["proximal_torque"] == pytest.approx(whole["proximal_torque"] + tension * first, abs=1e-12)
        assert cut["distal_torque"] == pytest.approx(whole["distal_torque"] + tension * second, abs=1e-12)


@pytest.mark.parametrize("model", ["rules", "opensim_half"])
def test_the_unit_pulls_as_the_effect_does(model):
    """The same acceleration of the wrist, with the effect and with the torques of the unit."""
    state = {"start_proximal_angle": 0.4, "start_distal_angle": -0.3, "start_proximal_rate": 2.0, "coupling_model": model}
    inside = wrist({**state, "constraint.prestrain": 0.05, "constraint.damping": 0.1})
    outside = wrist(state, ("morphology",))
    unit = bundle(prestrain=0.05, damping=0.1, coupling_model=model)
    for name in ("proximal_angle", "distal_angle", "proximal_rate", "distal_rate"):
        unit.set(name, outside[name])
    unit.refresh()
    outside.set("proximal_torque", unit["proximal_torque"])
    outside.set("distal_torque", unit["distal_torque"])
    assert inside.energy() == pytest.approx(outside.energy() + unit["stored_energy"], rel=1e-14)
    rates = np.zeros((2, 4))
    for made, dx in zip((inside, outside), rates, strict=True):
        wrist_derivatives(0.0, made.x, made.u[0], dx, *made.arguments)
    assert rates[0] == pytest.approx(rates[1], rel=1e-12)


# -- rigid ------------------------------------------------------------------------------------------------------------------
def test_rigid_isometric_ligaments_change_nothing():
    """Five conditions on two angles, all of them kept at every angle; the lengths stay, and the wrist moves as without."""
    start = {"start_proximal_angle": 0.5, "start_distal_angle": -0.4}
    held, free = wrist({**start, **ISOMETRIC, "constraint.kind": "rigid"}), wrist(start, ("morphology",))
    for k in range(30):
        for made in (held, free):
            made.step(0.01 * k, 0.01)
        assert max(abs(held[f"constraint.strain[{j}]"]) for j in range(1, 6)) < 1e-14
    assert (held.x == free.x).all()
    assert abs(held.x).max() > 0.01


@pytest.mark.known_answers(Wrist="constraint")
@pytest.mark.parametrize(("free", "inertia"), [("proximal", 0.45 * 0.07**2 + 1e-3 + 1e-5), ("distal", 0.45 * 0.05**2 + 1e-3)])
def test_a_held_row_leaves_an_oscillator_of_one_degree_of_freedom(free, inertia):
    """Period 2 pi sqrt(I / k): a stiffness equal in all directions is k about every axis across the hand."""
    isometric = {k: v for k, v in ISOMETRIC.items() if ("[2]" in k) != (free == "proximal")}
    made = wrist(
        {**isometric, "constraint.kind": "rigid", "proximal_damping": 0.0, "distal_damping": 0.0, f"start_{free}_rate": 1e-4}
    )
    quarter = 0.5 * math.pi * math.sqrt(inertia / 1.0)
    made.step(0.0, quarter)
    assert made[f"{free}_rate"] == pytest.approx(0.0, abs=1e-10)
    assert made[f"{free}_angle"] == pytest.approx(1e-4 * math.sqrt(inertia / 1.0), rel=1e-6)
    assert made["distal_angle" if free == "proximal" else "proximal_angle"] == 0.0


def test_the_reaction_bears_what_the_held_row_is_given():
    made = wrist({**{k: v for k, v in ISOMETRIC.items() if "[2]" not in k}, "constraint.kind": "rigid"})
    made.set("distal_torque", 0.3)
    made.refresh()
    assert made["constraint.distal_reaction"] == pytest.approx(-0.3, rel=1e-14)
    assert made["constraint.proximal_reaction"] == 0.0
    made.set("proximal_torque", 0.2)  # accelerates the proximal row, and the distal one would stay behind
    made.refresh()
    m11, m12 = 0.45 * 0.07**2 + 1e-3 + 1e-5, (0.45 * 0.07 * 0.05 + 1e-3) * math.cos(PROXIMAL_TILT + DISTAL_TILT)
    assert made["constraint.distal_reaction"] == pytest.approx(-0.3 + 0.2 * m12 / m11, rel=1e-12)


def test_the_reaction_of_a_held_proximal_row():
    """The distal row turns alone about the axis that stands: m22 q2'' = its torque, and m12 q2'' comes on the other axis."""
    made = wrist({**{k: v for k, v in ISOMETRIC.items() if "[2]" in k}, "constraint.kind": "rigid"})
    made.set("proximal_torque", 0.2)
    made.set("distal_torque", 0.3)
    made.refresh()
    m22, m12 = 0.45 * 0.05**2 + 1e-3, (0.45 * 0.07 * 0.05 + 1e-3) * math.cos(PROXIMAL_TILT + DISTAL_TILT)
    assert made["constraint.proximal_reaction"] == pytest.approx(-0.2 + 0.3 * m12 / m22, rel=1e-12)
    assert made["constraint.distal_reaction"] == 0.0


def test_a_rigid_ligament_about_a_moved_axis_holds_its_row():
    """Isometric about the axis it was made for; about one that is moved the trapezium-scaphoid pair holds the distal row."""
    parameters = {**ISOMETRIC, "constraint.kind": "rigid", "morphology.distal_tilt": DISTAL_TILT + 0.1}
    made = wrist({**parameters, "start_proximal_rate": 1.0})
    made.step(0.0, 0.1)
    assert made["distal_angle"] == 0.0
    assert made["proximal_angle"] != 0.0
    with pytest.raises(BadInput, match=r"hold both rows \(trapezium-scaphoid, scapho-lunate, luno-triquetral, radio"):
        wrist({**parameters, "morphology.proximal_tilt": PROXIMAL_TILT + 0.1})
