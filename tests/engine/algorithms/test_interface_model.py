"""The interface model: closed forms of impacts, an exact piecewise reference, published errors, orders."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.reduced import LAWS, force_in_series, law_force, reduced_step
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms import master_of
from cosimo.orchestrator.engine.algorithms.contact import ContactSimulator, line
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import open_unit
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import slope
from cosimo.tests.support import Linear
from scipy.linalg import expm
from scipy.optimize import brentq


class Body(Linear):
    """A mass on a spring and a damper that gets a force, and tells its acceleration."""

    m = parameter(1.0, "kg", "mass", low=1e-9)
    k = parameter(0.0, "N/m", "spring to the ground")
    c = parameter(0.0, "N.s/m", "damper to the ground")
    v0 = parameter(0.0, "m/s", "velocity at the start")
    force = input_(0.0, "N", "force")
    position = output("m", "position")
    velocity = output("m/s", "velocity")
    acceleration = output("m/s2", "acceleration", feedthrough=("force",))

    def matrices(self):
        p = self.parameters
        A = np.array([[0.0, 1.0], [-p["k"] / p["m"], -p["c"] / p["m"]]])
        B = np.array([[0.0], [1.0 / p["m"]]])
        return A, B, np.vstack((np.eye(2), A[1:])), np.vstack((np.zeros((2, 1)), B[1:])), [0.0, p["v0"]]


class Dashpot(Linear):
    """A point that a force sets in motion without inertia: the end of a long string."""

    Z = parameter(1.0, "N.s/m", "impedance", low=1e-9)
    force = input_(0.0, "N", "force")
    position = output("m", "position")

    def matrices(self):
        return np.zeros((1, 1)), np.array([[1.0 / self.parameters["Z"]]]), np.eye(1), np.zeros((1, 1)), [0.0]


def pair(
    step,
    stop,
    first,
    second,
    law,
    *,
    leader=None,
    acceleration=True,
    algorithm="interface-model",
    degree=0,
    clearance=0.0,
    inertia=None,
    **options,
):
    """Scene of two bodies; first and second: parameters of `Body`; law: settings of the contact."""

    def side(name, m):
        known = {"acceleration": f"{name}.acceleration"} if acceleration else {}
        ends = {part: f"{name}.{part}" for part in ("force", "position", "velocity")}
        return {**ends, **known, "inertia": m}

    masses = inertia or (first["m"], second["m"])
    contact = {"name": "touch", "clearance": clearance, **law, "first": side("a", masses[0]), "second": side("b", masses[1])}
    return read_scene(
        {
            "stop_time": stop,
            "units": {n: {"component": f"{__name__}:Body", "parameters": p} for n, p in (("a", first), ("b", second))},
            "contacts": [contact | ({} if leader is None else {"leader": leader})],
            "master": {"algorithm": algorithm, "step": step, "extrapolation": degree, **options},
        }
    )


# -- the reduced bodies -----------------------------------------------------------------------------------------------------
def test_line_has_impulse_and_first_moment_of_the_force():
    h, n = 0.3, 200_000
    s = (np.arange(n) + 0.5) * h / n
    force = np.exp(-5.0 * s) + s**2
    value, slope = line(force.mean() * h, (force * s).mean() * h, h)
    straight = value + slope * s
    assert straight.mean() == pytest.approx(force.mean(), rel=1e-9)  # the midpoint rule of the sum itself: 1e-11
    assert (straight * s).mean() == pytest.approx((force * s).mean(), rel=1e-9)


def test_series_compliance_of_a_hertzian_contact_by_bisection_of_its_definition():
    law = LAWS.index("hertz")
    for gap in (1e-6, 1e-4, 1e-2):
        force = force_in_series(law, 1e9, 0.2, gap, 0.3, 1e-8)
        residual = law_force(law, 1e9, 0.2, gap - 1e-8 * force, 0.3, 0.0) - force
        assert abs(residual) < 1e-9 * force
    assert force_in_series(LAWS.index("unilateral"), 5e4, 0.0, 1e-3, 0.0, 1e-5) == pytest.approx(50.0 / 1.5, rel=1e-14)


def test_a_mass_against_a_dashpot_is_the_matrix_exponential():
    """m z1'' = -k (z1 - z2) - d (z1' - z2') + r, Z z2' = k (z1 - z2) + d (z1' - z2'), over one step of 1.5 time constants."""
    m, Z, k, d, h, r = 7.2, 487.0, 5e4, 60.0, 0.015, 30.0
    # z2' = (k (z1 - z2) + d z1') / (Z + d); state z1, v1, z2, impulse, 1
    into = np.array([k, d, -k, 0.0, 0.0]) / (Z + d)
    force = np.array([k, d, -k, 0.0, 0.0]) - d * into
    A = np.array([[0, 1, 0, 0, 0], [*(-force[:3] / m), 0, r / m], into, force, np.zeros(5)])
    start = np.array([1e-3, 0.2, 0.0, 0.0, 1.0])
    exact = expm(A * h) @ start
    impulse, _, end = reduced_step(
        h,
        LAWS.index("spring"),
        k,
        d,
        0.0,
        start[0],
        start[1],
        start[2],
        0.0,
        1.0 / m,
        0.0,
        0.0,
        1.0 / Z,
        r,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    )
    assert impulse == pytest.approx(exact[3], rel=1e-6)  # RK4 with 20 micro steps a time constant
    assert end == pytest.approx(force @ exact, rel=1e-6)


# -- impacts of free bodies: the reduced model is the whole truth ----------------------------------------------------------
@pytest.mark.first(2)
@pytest.mark.parametrize("leader", [None, "first", "second"])
@pytest.mark.parametrize("law", [{"law": "unilateral", "stiffness": 1e6}, {"law": "hertz", "stiffness": 1e8}])
def test_elastic_impact_whatever_the_step(law, leader):
    """Velocities of Newton's elastic impact; with one step as long as the whole contact, too."""
    m1, m2, v = 10.0, 1.0, 0.5
    exact = np.array([(m1 - m2) / (m1 + m2) * v, 2.0 * m1 / (m1 + m2) * v])
    for step in (1e-4, 1e-3, 4e-3):
        result = finished(pair(step, 0.02, {"m": m1, "v0": v}, {"m": m2}, law, leader=leader))
        assert result["touch.force"][-1] == 0.0
        velocities = np.array([result["a.velocity"][-1], result["b.velocity"][-1]])
        assert m1 * velocities[0] + m2 * velocities[1] == pytest.approx(m1 * v, rel=1e-12)  # no impulse is lost or made
        np.testing.assert_allclose(velocities, exact, rtol=1e-4)  # a step ends between two micro steps of the lift-off


def test_hertzian_impact_has_the_closed_form():
    """Largest indentation (5 m v² / 4 K)^(2/5), duration 2.9433 times that over v; the kick of a step is an impulse."""
    m, K, v = 1.0, 1e8, 0.4
    reduced = 0.5 * m
    deepest = (1.25 * reduced * v**2 / K) ** 0.4
    result = finished(pair(2e-5, 8e-3, {"m": m, "v0": v}, {"m": m}, {"law": "hertz", "stiffness": K}))
    assert result["touch.indentation"].max() == pytest.approx(deepest, rel=1e-4)
    assert result["touch.force"].max() == pytest.approx(K * deepest**1.5, rel=1e-4)
    assert np.count_nonzero(result["touch.force"] > 0.0) * 2e-5 == pytest.approx(2.9433 * deepest / v, abs=2e-5)


def test_a_step_longer_than_the_period_of_the_contact():
    """Two free masses on a spring: at communication points 7 and a half radians apart they are where they should be."""
    m1, m2, k, v = 10.0, 1.0, 1e6, 0.5
    omega = np.sqrt(k * (1.0 / m1 + 1.0 / m2))
    result = finished(pair(7.5 / omega, 75.0 / omega, {"m": m1, "v0": v}, {"m": m2}, {"law": "spring", "stiffness": k}))
    exact = k * v / omega * np.sin(omega * result.time)
    # RK4's phase error at omega h = 1/20 is 5e-8 a radian; an impulse out of it goes round with the oscillation
    np.testing.assert_allclose(result["touch.force"], exact, atol=2e-4 * np.abs(exact).max())


@pytest.mark.parametrize("leader", [None, "first", "second"])
def test_a_mass_that_lands_on_the_end_of_a_string(leader):
    """m x'' = -F, Z w' = F, F = k (x - w): a damped oscillation, exact with steps of one and a half radians."""
    m, Z, k, v = 7.2, 487.0, 5e4, 0.3
    result = finished(
        read_scene(
            {
                "stop_time": 0.09,
                "units": {
                    "a": {"component": f"{__name__}:Body", "parameters": {"m": m, "v0": v}},
                    "w": {"component": f"{__name__}:Dashpot", "parameters": {"Z": Z}},
                },
                "contacts": [
                    {
                        "name": "touch",
                        "law": "spring",
                        "stiffness": k,
                        **({"leader": leader} if leader else {}),
                        "first": {"force": "a.force", "position": "a.position", "velocity": "a.velocity", "inertia": m},
                        "second": {"force": "w.force", "position": "w.position", "impedance": Z},
                    }
                ],
                "master": {"algorithm": "interface-model", "step": 0.018},
            }
        )
    )
    A = np.array([[0.0, 1.0, 0.0], [-k / m, 0.0, k / m], [k / Z, 0.0, -k / Z]])
    exact = np.array([k * (z[0] - z[2]) for z in (expm(A * t) @ [0.0, v, 0.0] for t in result.time)])
    np.testing.assert_allclose(result["touch.force"], exact, atol=1e-5 * np.abs(exact).max())  # 30 micro steps a step


# -- bodies with springs of their own --------------------------------------------------------------------------------------
def states(k1, k2, kc, cc):
    return np.array([[0, 1, 0, 0], [-k1 - kc, -cc, kc, cc], [0, 0, 0, 1], [kc, cc, -k2 - kc, -cc]])


def error(step, damping, degree, leader, *, acceleration=True, inertia=None):
    """Largest error of the four states at t = 1; masses of 1 kg, springs of 10 and 1000 N/m, coupling spring of 100 N/m."""
    first, second = {"m": 1.0, "k": 10.0, "v0": 100.0}, {"m": 1.0, "k": 1000.0, "v0": -100.0}
    law = {"law": "spring", "stiffness": 100.0, "damping": damping}
    result = finished(
        pair(step, 1.0, first, second, law, leader=leader, acceleration=acceleration, degree=degree, inertia=inertia)
    )
    reached = [result[n][-1] for n in ("a.position", "a.velocity", "b.position", "b.velocity")]
    return np.abs(reached - expm(states(10.0, 1000.0, 100.0, damping)) @ [0.0, 100.0, 0.0, -100.0]).max()


@pytest.mark.first(2)
@pytest.mark.parametrize("leader", [None, "second"])
@pytest.mark.parametrize("degree", [0, 1])
@pytest.mark.parametrize("acceleration", [True, False])
def test_order_of_the_two_mass_oscillator(acceleration, degree, leader):
    """At least extrapolation + 2: an error of the other forces reaches the contact's force by one integration or two."""
    errors = [error(step, 0.01, degree, leader, acceleration=acceleration) for step in (2.5e-3, 1.25e-3, 6.25e-4)]
    assert slope([4.0, 2.0, 1.0], errors) > degree + 2 - 0.15
    # Jacobi with linear inputs, force against force: 0.1349 at the second step (LIM oscillator, own program)
    assert errors[1] < 0.1349 / 200.0


def test_a_wrong_inertia_costs_accuracy_not_convergence():
    right, wrong = (
        [error(step, 0.01, 1, None, acceleration=False, inertia=inertia) for step in (5e-3, 2.5e-3, 1.25e-3)]
        for inertia in (None, (3.0, 0.5))
    )
    assert slope([4.0, 2.0, 1.0], wrong) > 2.85
    assert wrong[-1] < 3.0 * right[-1]


# Relative l2 error of the contact force of a 10 kg body (1e3 N/m, 20 N s/m) that hits one of 1 kg (1e5 N/m, 50 N s/m) with
# 0.5 m/s, contact of 1e6 N/m over 20 ms: an independent program with 40 micro steps, against Radau.
PUBLISHED = {
    (200.0, 1e-3): 0.0112,
    (200.0, 5e-4): 0.0019,
    (200.0, 2.5e-4): 4.7e-4,
    (200.0, 1e-4): 5.8e-5,
    (0.0, 1e-3): 0.0190,
    (0.0, 1e-4): 1.5e-5,
}
HEAVY, LIGHT = {"m": 10.0, "k": 1e3, "c": 20.0, "v0": 0.5}, {"m": 1.0, "k": 1e5, "c": 50.0}


def exact_impact(damping, samples):
    """Force at equally spaced samples up to 20 ms: exponentials of the parts with and without contact, joined at the roots."""

    def system(k, d):
        return np.array([[0, 1, 0, 0], [-1e2 - k / 10, -2 - d / 10, k / 10, d / 10], [0, 0, 0, 1], [k, d, -1e5 - k, -50 - d]])

    systems = {True: system(1e6, damping), False: system(0.0, 0.0)}

    def gap(z):
        return z[0] - z[2]

    def pressed(z):
        return 1e6 * gap(z) + damping * (z[1] - z[3])

    n = 20_000
    d = 0.02 / n
    over = {on: expm(A * d) for on, A in systems.items()}
    z, on, force = np.array([0.0, 0.5, 0.0, 0.0]), True, []
    for _ in range(n + 1):
        force.append(pressed(z) if on else 0.0)
        ahead = over[on] @ z
        if (pressed(ahead) < 0.0) if on else (gap(ahead) > 0.0 and pressed(ahead) > 0.0):
            crossed = pressed if on or gap(z) >= 0.0 else gap
            root = brentq(lambda s, z=z, on=on, crossed=crossed: crossed(expm(systems[on] * s) @ z), 0.0, d, xtol=1e-16)
            z, on = expm(systems[on] * root) @ z, not on
            ahead = expm(systems[on] * (d - root)) @ z
        z = ahead
    return np.array(force)[:: n // (samples - 1)]


@pytest.mark.parametrize("damping", [200.0, 0.0])
def test_errors_of_a_stiff_impact(damping):
    errors, explicit = {}, {}
    for step in (1e-3, 5e-4, 2.5e-4, 1e-4):
        law = {"law": "unilateral", "stiffness": 1e6, "damping": damping}
        results = [
            finished(pair(step, 0.02, HEAVY, LIGHT, law, **way))
            for way in ({}, {"leader": "second"}, {"algorithm": "jacobi", "degree": 1})
        ]
        exact = exact_impact(damping, results[0].time.size)
        held, led, jacobi = (np.linalg.norm(r["touch.force"] - exact) / np.linalg.norm(exact) for r in results)
        assert {n: r["steps"] for n, r in results[0].info.counters.units.items()} == dict.fromkeys(
            ("a", "b", "touch"), round(0.02 / step)
        )
        errors[step], explicit[step] = held, jacobi
        assert led < 1.1 * held
        assert held < jacobi / 20.0
        if (damping, step) in PUBLISHED:  # its micro steps, and so the impulse at the edges of the contact, are others
            assert held == pytest.approx(PUBLISHED[damping, step], rel=0.2)
    assert slope(list(errors), list(errors.values())) > 2.0


# -- state, control, faults ------------------------------------------------------------------------------------------------
def test_a_repeated_step_and_one_from_bytes_are_the_same_to_the_last_bit():
    scene = pair(1e-3, 0.02, HEAVY, LIGHT, {"law": "unilateral", "stiffness": 1e6}, leader="second", acceleration=False, degree=2)
    units = {name: open_unit(name, settings, in_process=True) for name, settings in scene.units.items()}
    units["touch"] = contact = ContactSimulator(scene.contacts[0], 2)
    master = master_of(scene, units, resolve_coupling(scene), [("touch", "force")])
    master.initialize(0.0)
    for k in range(5):
        master.step(k * 1e-3, 1e-3)
    saved = master.save()
    packed = contact.pack(contact.save())
    master.step(5e-3, 1e-3)
    once = list(master.signals)
    for state in (saved, saved):
        master.restore(state)
        contact.restore(contact.unpack(packed))
        master.step(5e-3, 1e-3)
        assert list(master.signals) == once


def test_step_doubling_controls_the_step():
    law = {"law": "unilateral", "stiffness": 1e6, "damping": 200.0}
    control = {"method": "doubling", "relative": 1e-4, "absolute": 1e-6, "min_step": 1e-5}
    result = finished(pair(1e-4, 0.02, HEAVY, LIGHT, law, degree=1, control=control))
    assert np.ptp(np.diff(result.time)) > 0.0
    exact = exact_impact(200.0, 20_001)
    found = np.interp(result.time, np.linspace(0.0, 0.02, 20_001), exact)
    assert np.linalg.norm(result["touch.force"] - found) < 0.01 * np.linalg.norm(found)


def test_a_run_resumed_from_a_checkpoint_is_the_same_to_the_last_bit(tmp_path):
    scene = pair(
        1e-3,
        0.02,
        HEAVY,
        LIGHT,
        {"law": "unilateral", "stiffness": 1e6, "damping": 200.0},
        leader="second",
        acceleration=False,
        degree=1,
    )
    whole = finished(scene)
    run(scene, in_process=True, checkpoint_every=7e-3, checkpoint_to=tmp_path / "half")
    resumed = run(scene, in_process=True, resume=tmp_path / "half")
    assert resumed.time.tobytes() == whole.time.tobytes()
    assert all(resumed[column].tobytes() == whole[column].tobytes() for column in whole.columns)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "iterative"])
def test_other_algorithms_have_the_law_too(algorithm):
    law = {"law": "unilateral", "stiffness": 1e6, "damping": 200.0}
    result = finished(pair(2e-5, 0.02, HEAVY, LIGHT, law, algorithm=algorithm, degree=1))
    exact = exact_impact(200.0, result.time.size)
    assert np.linalg.norm(result["touch.force"] - exact) < 1e-2 * np.linalg.norm(exact)


def test_a_fault_on_a_contact_force_reaches_the_body():
    scene = pair(1e-3, 0.02, {"m": 10.0, "v0": 0.5}, {"m": 1.0}, {"law": "unilateral", "stiffness": 1e6})
    lost = scene.with_changes({"faults": [{"signal": "b.force", "kind": "override", "value": 0.0}]})
    result = finished(lost)
    assert result["b.velocity"][-1] == 0.0
    assert result["a.velocity"][-1] < 0.5


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("leader",), "third", "leader"),
        (("law",), "herz", "hertz"),
        (("first", "inertia"), None, "neither inertia nor impedance"),
        (("first", "impedance"), 5.0, "both inertia and impedance"),
        (("first", "velocity"), None, "velocity"),
        (("first", "force"), "b.force", "driven a second time"),
        (("first", "force"), "a.fource", "'force'"),
        (("second", "position"), "b.positon", "'position'"),
        (("second", "position"), "c.position", "unit 'c'"),
        (("first", "clearance"), 1.0, "unknown key 'clearance'"),
        (("name",), "a", "a name that no unit"),
        (("stiffness",), -1.0, "greater than 0"),
    ],
)
def test_contacts_that_cannot_be(place, value, words):
    data = pair(1e-3, 0.02, HEAVY, LIGHT, {"law": "unilateral", "stiffness": 1e6, "damping": 1.0}).settings()
    contact = dict(data["contacts"][0])
    contact["first"], contact["second"] = dict(contact["first"]), dict(contact["second"])
    table = contact if len(place) == 1 else contact[place[0]]
    table[place[-1]] = value
    if value is None:
        del table[place[-1]]
        table.pop("acceleration", None)
    with pytest.raises(BadInput, match=words):
        read_scene({**data, "contacts": [contact]})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contacts": []}, "without contacts"),
        ({"master.feedthrough": "delayed"}, "feedthrough"),
        ({"master.control": {"method": "milne"}}, "milne"),
        ({"master.bonds": ["a.velocity * touch.force"]}, "bonds"),
    ],
)
def test_options_that_do_not_go_with_contacts_in_the_master(changes, words):
    scene = pair(1e-3, 0.02, HEAVY, LIGHT, {"law": "unilateral", "stiffness": 1e6})
    with pytest.raises(BadInput, match=words):
        scene.with_changes(changes)


def test_a_unit_leads_everywhere_or_nowhere():
    side = {part: f"{{}}.{part}" for part in ("force", "position", "velocity")}

    def contact(name, first, second):
        sides = {
            label: {part: text.format(unit) for part, text in side.items()} | {"inertia": 1.0}
            for label, unit in (("first", first), ("second", second))
        }
        return {"name": name, "law": "spring", "stiffness": 1e4, "leader": "first", **sides}

    units = {n: {"component": f"{__name__}:Body"} for n in "abc"}
    data = {
        "stop_time": 1.0,
        "units": units,
        "master": {"algorithm": "interface-model", "step": 1e-3},
        "contacts": [contact("x", "a", "b"), contact("y", "b", "c")],
    }
    with pytest.raises(BadInput, match=r"b.*second time|lead in all"):
        read_scene(data)
