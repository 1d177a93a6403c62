"""Measured limits of the macro step: closed forms, published schemes, drift and growth that are nobody's fault, refusals."""

import csv
import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.studies.stability import schemes_of, stability
from cosimo.orchestrator.judgement.closed_form import longest_step
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import two_masses

WITHIN = 0.02  # of a closed form


def spring(m=1.0, k=100.0, d=4.0, ground=(0.0, 0.0), stop=30.0, **master):
    """A mass, on a spring and damper to the ground if given, with a spring-damper as another unit."""
    return read_scene(
        {
            "stop_time": stop,
            "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
            "units": {
                "m": {"component": "cosimo.tests.support:Mass", "parameters": {"m": m, "k": ground[0], "c": ground[1]}},
                "s": {"component": "cosimo.tests.support:SpringDamper", "parameters": {"k": k, "d": d}},
            },
            "master": {"algorithm": "jacobi", "step": 0.02} | master,
        }
    )


def limit(scene, algorithm, degree, steps=300):
    (found,) = stability(scene, [(algorithm, degree)], steps=steps).limits
    return found


# ω H of the roots' first leaving the unit circle, by damping ratio and degree, from the characteristic polynomials by computer
# algebra; they are in the docstring of `Jacobi`.
TABLE = {0.05: (0.200000, 0.694174, 1.063371), 0.2: (0.800000, 1.213169, 1.301332), 0.5**0.5: (1.414214, 0.739315, 0.401216)}


@pytest.mark.first(2)
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("share", TABLE)
def test_limits_meet_the_table_of_a_mass_on_a_spring_damper(share, degree):
    found = limit(spring(d=20.0 * share), "jacobi", degree)
    assert found.longest == pytest.approx(TABLE[share][degree] / 10.0, rel=WITHIN)
    assert found.closed == pytest.approx(TABLE[share][degree] / 10.0, rel=1e-4)
    assert found.tried <= 1.006 * found.longest  # the next longer step that was tried grew
    assert "grows" in found.seen


@pytest.mark.full
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_shipped_scene_meets_the_closed_form_over_its_map(degree):
    """At the corners of the map: damping from a twentieth to four fifths of the critical one."""
    scene = load_scene("mass-on-spring")
    table = scene.study.stability
    corners = {name: [min(values), max(values)] for name, values in table.items()}
    found = stability(scene.with_changes({"study.stability": corners}), [("gauss-seidel", degree)], steps=300)
    assert list(found.varied.values()) == ["N/m", "kg"]
    assert len(found.limits) == 4
    for one in found.limits:
        k, m = one.point["spring.stiffness"], one.point["mass.mass"]
        assert one.longest == pytest.approx(longest_step(k / m, 4.0 / m, degree), rel=WITHIN), one.point


@pytest.mark.full
def test_iterated_linear_forces_have_the_limit_of_linear_acceleration():
    """√12 over the frequency, Newmark's; weak damping shifts it by less than a percent."""
    assert limit(spring(d=0.2), "iterative", 1).longest == pytest.approx(math.sqrt(12.0) / 10.0, rel=WITHIN)


def test_iterated_held_forces_have_no_limit():
    found = limit(spring(d=2.0), "iterative", 0)
    assert found.longest == math.inf
    assert found.seen == ""
    assert found.tried == pytest.approx(30.0 / 36.0)  # as long as the run has room for


def test_without_damping_no_held_force_is_stable():
    """|λ|² = 1 + (ω H)²/2: in 1000 steps a thousandth of a period is still seen to grow."""
    found = limit(spring(d=0.0, step=0.1, stop=100.0), "jacobi", 0, steps=1000)
    assert found.longest == found.closed == 0.0
    assert found.tried <= 0.1 / 64.0


@pytest.mark.full
def test_two_masses_have_the_limits_of_their_own_spectral_radius():
    """Case 1 of the LIM benchmark, cut into force and displacement: 14.02 and 37.07 ms, from eigenvalues of the whole."""
    scene = read_scene(two_masses("jacobi", 0.01) | {"stop_time": 40.0})
    for degree, longest in ((1, 14.02e-3), (2, 37.07e-3)):
        assert limit(scene, "jacobi", degree, steps=600).longest == pytest.approx(longest, rel=WITHIN)


def test_bodies_that_drift_apart_are_not_unstable():
    """A spring and damper between two free bodies: both keep the push, the limit is that of the reduced mass."""
    joint = "cosimo.tests.run.judgement.test_advice:Between"
    scene = read_scene(
        {
            "stop_time": 20.0,
            "connections": [
                "s.f1 -> a.force",
                "s.f2 -> b.force",
                "a.x_out -> s.x1",
                "a.v_out -> s.v1",
                "b.x_out -> s.x2",
                "b.v_out -> s.v2",
            ],
            "units": {
                "a": {"component": "cosimo.tests.support:Mass", "parameters": {"m": 2.0}},
                "b": {"component": "cosimo.tests.support:Mass", "parameters": {"m": 6.0}},
                "s": {"component": joint, "parameters": {"k": 300.0, "d": 6.0}},
            },
            "master": {"algorithm": "jacobi", "step": 0.01, "extrapolation": 0},
        }
    )
    found = limit(scene, "jacobi", 1)
    inverse = 1.0 / 2.0 + 1.0 / 6.0
    assert found.longest == pytest.approx(longest_step(300.0 * inverse, 6.0 * inverse, 1), rel=WITHIN)


def test_what_grows_by_itself_is_said_and_allowed():
    """A mass that a negative damper drives grows at every step; the coupling is to blame only where it grows much faster."""
    driven = spring(d=0.0, ground=(0.0, -0.2), stop=20.0)
    found = stability(driven, [("jacobi", 2)], steps=600)
    assert "grow by themselves" in found.remarks[0]
    assert 0.02 < found.limits[0].longest < math.inf
    assert stability(spring(), [("jacobi", 2)], steps=200).remarks == ()


def test_a_scheme_that_is_refused_is_in_the_table_with_its_reason():
    scene = spring()
    data = scene.settings()
    data["units"]["s"]["every"] = 2
    found = limit(read_scene(data), "interface-model", 1)
    assert math.isnan(found.longest)
    assert "contacts" in found.seen


def test_every_algorithm_with_every_degree_is_measured_unless_some_are_named():
    assert len(schemes_of(spring())) == 9
    assert schemes_of(spring(), ["iterative"], [1]) == [("iterative", 1)]
    assert ("interface-model", 1) in schemes_of(load_scene("en50318-2002-interface-model"))


@pytest.mark.full
def test_order_control_and_faults_of_a_scene_do_not_stand_in_the_way():
    scene = spring(algorithm="gauss-seidel", order=["s", "m"], control={"method": "milne"})
    found = stability(scene, [("jacobi", 0), ("gauss-seidel", 0)], steps=300)
    assert all(np.isfinite(one.longest) for one in found.limits)
    assert "without step control" in found.remarks[0]


def test_what_has_no_coupling_that_could_grow_is_refused():
    with pytest.raises(BadInput, match="feeds back"):
        stability(load_scene("double-pendulum"))
    with pytest.raises(BadInput, match="at least 32"):
        stability(spring(), steps=10)


def test_the_table_of_a_map(tmp_path):
    scene = spring().with_changes({"study.stability": {"s.d": [1.0, 4.0]}})
    found = stability(scene, [("jacobi", 0), ("jacobi", 1)], steps=100)
    rows = list(csv.reader(found.save(tmp_path).open(encoding="utf-8")))
    assert rows[0] == [
        "s.d, N.s/m",
        "algorithm",
        "extrapolation",
        "longest stable macro step, s",
        "closed form, s",
        "seen",
        "tried, s",
        "macro steps made",
    ]
    assert len(rows) == 1 + 2 * 2
    assert [float(row[0]) for row in rows[1:]] == [1.0, 1.0, 4.0, 4.0]
    assert [float(row[3]) for row in rows[1:]] == [one.longest for one in found.limits]
