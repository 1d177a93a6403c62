"""Stability by tangents: limits against closed forms and matrices by hand, growth along a run, and what has no derivatives."""

from __future__ import annotations

import math
from contextlib import ExitStack

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.judgement.growth import EXCESS, Growth, grown_in, growth_along, growth_rate, longest_stable
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.derivatives.coupled_masses import HERE, as_kernels
from cosimo.tests.engine.algorithms.oscillators import TwoMasses, radius
from cosimo.tests.run.judgement.closed_form import longest_step
from scipy.linalg import expm

if COMPILED:
    from cosimo.orchestrator.judgement.stability import CouplingStability

of_machine_code = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def on_spring(damping, **master):
    """1 kg on 100 N/m."""
    changes = {f"master.{key}": value for key, value in master.items()}
    return load_scene("mass-on-spring").with_changes({"stop_time": 10.0, "spring.damping": damping, **changes})


def longest(scene):
    with ExitStack() as stack:
        coupling = CouplingStability(scene, stack)
        return coupling.constant, coupling.longest()


@of_machine_code
@pytest.mark.first(2)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("damping", [0.4, 4.0, 10.0 * 2.0**0.5, 20.0])
def test_a_limit_is_that_of_the_closed_form(algorithm, degree, damping):
    constant, found = longest(on_spring(damping, algorithm=algorithm, extrapolation=degree))
    assert constant
    assert found.longest == pytest.approx(longest_step(100.0, damping, degree), rel=1e-6)
    assert found.longest < found.tried < 1.000001 * found.longest
    assert "grows" in found.seen


@of_machine_code
@pytest.mark.parametrize("damping", [2.0, 20.0])
def test_held_forces_of_the_step_before_have_the_shorter_limit(damping):
    found = longest(on_spring(damping, algorithm="jacobi", extrapolation=0, feedthrough="delayed"))[1]
    assert found.longest == pytest.approx(longest_step(100.0, damping, 0, 1), rel=1e-6)


@of_machine_code
@pytest.mark.full
@pytest.mark.parametrize("split", ["FF", "FD", "DD"])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_two_masses_are_stable_where_the_matrix_by_hand_says_so(split, algorithm, degree):
    """LIM's benchmark with more damping: the largest absolute eigenvalue of the whole step first exceeds 1 at the limit."""
    masses = TwoMasses(cc=1.0, c1=1.0, c2=1.0)

    def scene(h, stop=20.0):
        return masses.scene(split, h, stop, algorithm=algorithm, extrapolation=degree)

    constant, found = longest(read_scene(as_kernels(scene(1e-2))))
    assert constant
    for h in np.geomspace(1e-2 / 60.0, min(found.longest, 0.05), 20)[:-1]:
        assert radius(scene(h)) < 1.0 + 1e-9
    if math.isfinite(found.longest):
        assert radius(scene(1.00001 * found.longest)) > 1.0


def pair(units, connections, **master):
    return read_scene(
        {
            "stop_time": 20.0,
            "connections": connections,
            "units": units,
            "master": {"algorithm": "jacobi", "step": 0.01, "extrapolation": 0} | master,
        }
    )


def mass(m=1.0, **more):
    return {"component": f"{HERE}:Owner", "parameters": {"m": m, "v0": 1.0, **more}}


def between(k, c):
    return {"component": f"{HERE}:Between", "parameters": {"kc": k, "cc": c}}


ON_GROUND = ["s.force -> m.force", "m.x_out -> s.x1", "m.v_out -> s.v1"]


@of_machine_code
def test_bodies_that_drift_apart_are_not_unstable():
    """A spring and damper between two free bodies: the limit is that of the reduced mass."""
    scene = pair(
        {"a": mass(2.0), "b": mass(6.0), "s": between(300.0, 6.0)},
        [
            "s.force -> a.force",
            {"source": "s.force", "target": "b.force", "factor": -1.0},
            *(f"{body}.{end}_out -> s.{end}{k}" for k, body in ((1, "a"), (2, "b")) for end in "xv"),
        ],
    )
    constant, found = longest(scene)
    assert constant
    assert found.longest == pytest.approx(longest_step(300.0 * (1 / 2 + 1 / 6), 6.0 * (1 / 2 + 1 / 6), 0), rel=1e-6)


@of_machine_code
def test_what_grows_by_itself_is_allowed():
    """A negative damper lets a mass grow with 0.1 1/s at every step: the coupling is to blame where that is half as much more."""
    scene = pair({"m": mass(c=-0.2), "s": between(100.0, 0.0)}, ON_GROUND, extrapolation=2)
    with ExitStack() as stack:
        coupling = CouplingStability(scene, stack)
        assert coupling.growth(1e-3).rate == pytest.approx(0.1, rel=1e-3)
        assert not coupling.growth(1e-3).unstable
        found = coupling.longest()
        assert 0.02 < found.longest < math.inf
        assert coupling.growth(found.tried).rate == pytest.approx(0.15, rel=1e-2)


@of_machine_code
def test_damping_beside_a_slow_mode_is_not_lost():
    """The slow mode decays with k / c = 0.02 1/s: in a short step its eigenvalue is as near to 1 as that of a free body."""
    with ExitStack() as stack:
        growth = CouplingStability(on_spring(4.0, step=1e-3).with_changes({"spring.stiffness": 0.08}), stack).growth(1e-3)
    assert growth.constant
    assert growth.rate == pytest.approx(-0.0201, rel=1e-2)
    assert growth.finer == pytest.approx(growth.rate, rel=1e-3)
    assert growth.lost < 1e-4


@of_machine_code
@pytest.mark.parametrize("step", [1e-3, 5e-3])
def test_what_grows_slowly_by_itself_is_allowed_with_any_step(step):
    """A force of 0.04 N/m away from the place at rest: 1 kg grows with 0.2 1/s."""
    scene = pair(
        {"m": mass(), "s": between(0.04, 0.0)}, [{"source": "s.force", "target": "m.force", "factor": -1.0}, *ON_GROUND[1:]]
    )
    with ExitStack() as stack:
        coupling = CouplingStability(scene.with_changes({"master.step": step}), stack)
        growth = coupling.growth(step)
        assert growth.rate == pytest.approx(0.2, rel=1e-2)
        assert growth.finer == pytest.approx(0.2, rel=1e-2)
        assert coupling.longest().longest > 0.1


@of_machine_code
def test_a_coupling_that_begins_later_is_not_constant(monkeypatch):
    """At the first of three instants no unit acts on another."""
    with ExitStack() as stack:
        coupling = CouplingStability(on_spring(4.0), stack)
        instants, real = coupling._instants, coupling._coupling
        monkeypatch.setattr(
            coupling,
            "_coupling",
            lambda instant: (np.zeros(0, dtype=int), np.zeros((0, 0))) if instant is instants[0] else real(instant),
        )
        assert not coupling.constant


@of_machine_code
@pytest.mark.parametrize("step", [1e-2, 2e-2])
def test_periods_of_controllers_do_not_end_a_search(step):
    """1 kg held by samples: macro steps that are tried have no common period with them."""
    scene = pair(
        {"m": mass(), "s": {"component": "cosimo.tests.run.judgement.sampled_spring:SampledSpring"}},
        ["s.force -> m.force", "m.x_out -> s.x", "m.v_out -> s.v"],
    )
    with ExitStack() as stack:
        coupling = CouplingStability(scene.with_changes({"master.step": step}), stack)
        assert coupling.growth(step).rate < 0.0
        assert coupling.longest().longest > step


@of_machine_code
def test_without_damping_no_held_force_is_stable():
    found = longest(pair({"m": mass(), "s": between(100.0, 0.0)}, ON_GROUND))[1]
    assert found.longest == 0.0
    assert found.tried < 0.01 / 60.0


@of_machine_code
@pytest.mark.parametrize(("step", "unstable"), [(1e-3, False), (5e-3, False), (2e-2, True)])
def test_growth_along_the_run_tells_where_the_derivative_changes(step, unstable):
    """The stiffness of a lumped catenary changes along the span."""
    with ExitStack() as stack:
        coupling = CouplingStability(load_scene("lumped-catenary"), stack)
        growth = coupling.growth(step)
        assert not coupling.constant
        assert growth.unstable == unstable
        assert growth.finer < 0.0


@of_machine_code
@pytest.mark.full
@pytest.mark.parametrize(
    ("algorithm", "degree", "stable", "unstable"),
    [
        ("jacobi", 0, 13e-3, 18e-3),
        ("jacobi", 1, 10e-3, 12e-3),
        ("jacobi", 2, 7.5e-3, 9.5e-3),
        ("gauss-seidel", 0, 11e-3, 18e-3),
        ("gauss-seidel", 1, 12e-3, 14e-3),
        ("gauss-seidel", 2, 9e-3, 11e-3),
    ],
)
def test_limits_of_pantograph_and_catenary(algorithm, degree, stable, unstable):
    """Exponents of whole runs cross zero at 15.1, 11.0, 8.6 and 13.0, 13.3, 10.1 ms; with held inputs there is no sharp edge."""
    scene = load_scene("en50318-2002").with_changes({"master.algorithm": algorithm, "master.extrapolation": degree})
    with ExitStack() as stack:
        coupling = CouplingStability(scene, stack)
        assert not coupling.growth(stable).unstable
        assert coupling.growth(unstable).unstable
        assert coupling.growth(8.0 * unstable).unstable  # though a quarter of it is too long, too


def nutation(h):
    """Growth, 1/s, of a rigid gyroscope whose moments are extrapolated through two samples, each step solved exactly.

    Inertia 0.22 kg.m2, spin 9 kg.m2/s, weight 8 kg at 0.15 m, as of the scene; both directions as one complex number.
    """
    free = np.zeros((4, 4), dtype=complex)  # angle, rate, moment, its slope
    free[0, 1], free[1, 0], free[1, 2], free[2, 3] = 1.0, -8.0 * 9.80665 * 0.15 / 0.22, 1.0 / 0.22, 1.0
    motion = expm(free * h)
    extrapolated = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1], [0, 0, -1 / h, 1 / h]])  # of angle, rate, two moments
    behind = motion @ extrapolated
    step = np.array([behind[0], behind[1], [0, 0, 0, 1], 9.0j * behind[1]])
    return math.log(np.abs(np.linalg.eigvals(step)).max()) / h


@of_machine_code
@pytest.mark.full
@pytest.mark.parametrize(("step", "unstable"), [(5e-3, False), (8e-3, True), (1e-2, True)])
def test_what_grows_slowly_is_not_hidden_by_what_decays(step, unstable):
    """A gyroscope whose nutation has no damping; a push of its bearings, which decays with 3 1/s, is all that a stretch shows of it."""
    with ExitStack() as stack:
        growth = CouplingStability(load_scene("gimbal-rotor"), stack).growth(step)
    assert growth.rate == pytest.approx(nutation(step), rel=0.25)
    assert growth.unstable == unstable


@of_machine_code
@pytest.mark.full
def test_growth_of_a_push_that_oscillates_is_no_chance():
    """Robots that stick and slip, excited at 105 ms: each stretch of a step of 153.8 ms ends elsewhere in the oscillation.

    A push decays as it does with a quarter of the step, within a factor of e^0.5 over the run.
    """
    with ExitStack() as stack:
        growth = CouplingStability(load_scene("pipe-robot-climb"), stack).growth(0.1538)
    assert abs(growth.rate - growth.finer) * growth.duration < 0.5
    assert not growth.unstable


@of_machine_code
def test_what_held_inputs_let_grow_is_seen_where_contact_is_lost():
    """The run with 24 ms is unstable; new pushes decay in most stretches, in which the pantograph flies."""
    scene = load_scene("lumped-catenary").with_changes({"master.extrapolation": 0})
    with ExitStack() as stack:
        coupling = CouplingStability(scene, stack)
        assert coupling.growth(0.024).unstable
        assert not coupling.growth(0.010).unstable


@of_machine_code
def test_where_disturbances_grow_by_themselves_no_limit_is_told():
    """A stiff rope between two robots lets a push grow by e^40 in 10 s with any step: the motion is chaotic."""
    scene = load_scene("pipe-robots-in-tow").with_changes(
        {"rope.stiffness": 5000.0, "master.algorithm": "jacobi", "stop_time": 3.0}
    )
    with ExitStack() as stack:
        coupling = CouplingStability(scene, stack)
        growth, found = coupling.growth(1e-3), coupling.longest()
    assert 3.0 < growth.finer < 6.0
    assert math.isnan(found.longest)
    assert found.seen == growth.untold != ""


@of_machine_code
@pytest.mark.parametrize("step", [0.02, 0.05, 0.1])
def test_a_push_along_the_run_grows_as_the_eigenvalue_says(step):
    scene = on_spring(4.0).with_changes({"stop_time": 60.0})
    with ExitStack() as stack:
        exact, followed = CouplingStability(scene, stack), CouplingStability(scene, stack)
        followed.__dict__["_map"] = None
        assert followed.growth(step).rate == pytest.approx(exact.growth(step).rate, rel=0.02)


@of_machine_code
@pytest.mark.parametrize("changes", [{"master.algorithm": "iterative"}, {"units.mass.isolation": "process"}])
def test_what_has_no_derivatives_is_refused(changes):
    with pytest.raises(BadInput, match=r"iterative|process"):
        longest(on_spring(4.0).with_changes(changes))


@pytest.mark.parametrize(
    ("rate", "finer", "constant", "unstable"),
    [
        (-0.1, -5.0, False, False),
        (0.1, -2.0 * EXCESS, False, True),
        (0.1, 0.2 - EXCESS, False, False),
        (0.1, -0.1, True, True),
        (1.0, 0.9, True, False),
        (math.inf, 1.0, False, True),
    ],
)
def test_what_is_called_unstable(rate, finer, constant, unstable):
    """In a run of 1 s."""
    assert Growth(0.01, 1.0, rate, finer, constant).unstable == unstable


def test_a_rate_is_that_of_an_exponential():
    t = 0.01 * np.arange(200)
    assert growth_rate(np.exp(-3.0 * t), 0.01) == pytest.approx(-3.0)
    assert growth_rate(np.exp(np.minimum(1e3 * t, 700.0)), 0.01) == pytest.approx(1e3)  # up to the largest numbers
    assert growth_rate(np.where(t < 1.0, 1.0, 0.0), 0.01) == -math.inf
    assert growth_rate(np.full(200, math.inf), 0.01) == math.inf


def test_growth_along_stretches_leaves_out_where_in_an_oscillation_they_end():
    """0.3 1/s with a size that beats by a factor of 19; within stretches, one by one, it is 0.3 1/s off by up to 4.7 1/s."""
    h, n = 0.01, 100
    sizes = np.exp(0.3 * h * np.arange(12 * n + 1)) * (1.0 + 0.9 * np.cos(2.0 * math.pi * 0.74 * h * np.arange(12 * n + 1)))
    parts = [sizes[k + 1 : k + n + 1] / sizes[k] for k in range(0, 12 * n, n)]
    assert growth_along([grown_in(part, h, new=False) for part in parts], n * h) == pytest.approx(0.3, abs=0.1)
    assert max(abs(growth_rate(part, h) - 0.3) for part in parts) > 4.0


def test_growth_along_stretches_where_units_stick_or_numbers_end():
    grown = [grown_in(np.exp(0.1 * np.arange(1, 11)), 0.1, new=False), grown_in(np.zeros(10), 0.1, new=True)]
    assert growth_along(grown, 1.0) == pytest.approx(1.0)
    assert growth_along(grown[1:], 1.0) == -math.inf
    assert growth_along([*grown, grown_in(np.full(10, math.inf), 0.1, new=True)], 1.0) == math.inf


@pytest.mark.parametrize(
    ("first", "least", "most"), [(0.01, 0.001, 10.0), (5.0, 0.001, 10.0), (0.99, 0.98, 1.0), (1.1, 0.9, 1.2)]
)
def test_a_limit_is_found_from_either_side(first, least, most):
    found = longest_stable(lambda h: "grows" if h > 0.95 else "", first, least, most, 1.0001)
    if least > 0.95:
        assert found == (0.0, found.seen, least)
    else:
        assert found.longest == pytest.approx(0.95, rel=1e-4)
        assert 0.95 < found.tried <= 1.0001 * found.longest


def test_no_limit_between_the_steps_that_may_be_tried():
    assert longest_stable(lambda h: "", 1.0, 0.1, 10.0, 1.01) == (math.inf, "", 10.0)
    assert longest_stable(lambda h: "grows", 1.0, 0.1, 10.0, 1.01) == (0.0, "at 0.1 s: grows", 0.1)
