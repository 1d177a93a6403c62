"""Advice before a run: what probing finds is what the units were made of, and the limit is the one that runs have."""

import math

import numpy as np
import pytest
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.judgement import advise, probing
from cosimo.orchestrator.judgement.dry_run import lines
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import Linear, Mass, two_masses


class Dashpot(Linear):
    """Gives way to a force in proportion to it, like a long wire: x' = F/c."""

    c = parameter(50.0, "N.s/m", "damper")
    force = input_(0.0, "N", "force")
    x_out = output("m", "position")

    def matrices(self):
        return np.zeros((1, 1)), np.array([[1.0 / self.parameters["c"]]]), np.eye(1), np.zeros((1, 1)), [0.01]


class Fine(Mass):
    """A mass that counts as many internal steps as its substep asks for."""

    calls = 0
    substep = parameter(1e-3, "s", "internal step")

    def _step(self, t, h):
        internal = math.ceil(h / self.parameters["substep"] * (1.0 - 1e-9))
        self.counts[0] += internal - 1
        Fine.calls += internal
        return super()._step(t, h)


class Between(Linear):
    """A spring between two bodies: pulls them together."""

    k = parameter(300.0, "N/m", "stiffness")
    d = parameter(0.6, "N.s/m", "damping")
    x1 = input_(0.0, "m", "position of the first")
    v1 = input_(0.0, "m/s", "velocity of the first")
    x2 = input_(0.0, "m", "position of the second")
    v2 = input_(0.0, "m/s", "velocity of the second")
    f1 = output("N", "force on the first", feedthrough=("x1", "v1", "x2", "v2"))
    f2 = output("N", "force on the second", feedthrough=("x1", "v1", "x2", "v2"))

    def matrices(self):
        k, d = self.parameters["k"], self.parameters["d"]
        row = np.array([-k, -d, k, d])
        return np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((2, 0)), np.array([row, -row]), np.zeros(0)


class Heavy(Linear):
    """A heat capacity: K of a flow in W."""

    power = input_(0.0, "W", "heat flow into it")
    temperature = output("K", "temperature")

    def matrices(self):
        return np.zeros((1, 1)), np.array([[1.0 / 20.0]]), np.eye(1), np.zeros((1, 1)), [300.0]


class Wall(Linear):
    """A conductance of 5 W/K to a room at 0 K."""

    temperature = input_(0.0, "K", "temperature inside")
    power = output("W", "heat flow", feedthrough=("temperature",))

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[-5.0]]), np.zeros(0)


def component(cls, **parameters):
    name = cls if isinstance(cls, str) else f"cosimo.tests.run.judgement.test_advice:{cls.__name__}"
    return {"component": name} | ({"parameters": parameters} if parameters else {})


def spring(m=2.0, k=100.0, d=2.0, **master):
    return {
        "stop_time": 1.0,
        "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
        "units": {
            "m": component("cosimo.tests.support:Mass", m=m),
            "s": component("cosimo.tests.support:SpringDamper", k=k, d=d),
        },
        "master": {"algorithm": "jacobi", "step": 1e-3} | master,
    }


@pytest.mark.parametrize(("m", "k", "d"), [(2.0, 100.0, 2.0), (0.1, 5e4, 3.0), (50.0, 10.0, 0.0)])
def test_stiffness_damping_and_mass_are_found(m, k, d):
    (contact,) = advise(read_scene(spring(m, k, d))).limits
    assert contact.pair == "m against s"
    assert contact.omega2 == pytest.approx(k / m, rel=1e-6)
    assert contact.damping == pytest.approx(d / m, rel=1e-6, abs=1e-9)
    assert contact.longest[0] == pytest.approx(min(2.0 * d / k, 2.0 * m / d if d else 1.0), rel=1e-5, abs=1e-12)


def test_the_mass_behind_a_force_is_what_answers_it_at_once():
    """a has a spring of its own and b a mass of its own: the contact is kc, cc on the mass of a alone."""
    (contact,) = advise(read_scene(two_masses("gauss-seidel", 1e-2, 1))).limits
    assert contact.pair == "a against b"
    # its own spring bends the answer to a step of a tenth of the macro step by ω² h²/12
    assert contact.omega2 == pytest.approx(100.0, rel=1e-4)
    assert contact.damping == pytest.approx(0.01, rel=1e-4)


def test_a_spring_between_two_bodies_counts_with_their_reduced_mass():
    scene = read_scene(
        {
            "stop_time": 1.0,
            "connections": [
                "s.f1 -> a.force",
                "s.f2 -> b.force",
                "a.x_out -> s.x1",
                "a.v_out -> s.v1",
                "b.x_out -> s.x2",
                "b.v_out -> s.v2",
            ],
            "units": {
                "a": component("cosimo.tests.support:Mass", m=2.0),
                "b": component("cosimo.tests.support:Mass", m=6.0),
                "s": component(Between),
            },
            "master": {"algorithm": "jacobi", "step": 1e-3, "extrapolation": 0},
        }
    )
    (contact,) = advise(scene).limits
    assert contact.pair == "a and b against s"
    assert contact.omega2 == pytest.approx(300.0 * (1.0 / 2.0 + 1.0 / 6.0), rel=1e-6)
    assert contact.damping == pytest.approx(0.6 * (1.0 / 2.0 + 1.0 / 6.0), rel=1e-6)
    assert contact.longest[0] == pytest.approx(2.0 * 0.6 / 300.0, rel=1e-6)


def test_dampers_and_heat_have_the_limit_of_first_order():
    """x' = -k/c x and C T' = -G T, held: stable up to 2 c/k and 2 C/G."""
    scene = {
        "stop_time": 1.0,
        "connections": ["s.force -> w.force", "w.x_out -> s.position"],
        "units": {"w": component(Dashpot), "s": component("cosimo.tests.support:SpringDamper", k=1e3, d=0.0)},
        "master": {"algorithm": "jacobi", "step": 1e-3},
    }
    (contact,) = advise(read_scene(scene)).limits
    assert (contact.omega2, contact.longest[0]) == (0.0, pytest.approx(2.0 * 50.0 / 1e3, rel=1e-6))
    scene = {
        "stop_time": 100.0,
        "connections": ["w.power -> h.power", "h.temperature -> w.temperature"],
        "units": {"h": component(Heavy), "w": component(Wall)},
        "master": {"algorithm": "jacobi", "step": 0.1},
    }
    (contact,) = advise(read_scene(scene)).limits
    assert (contact.omega2, contact.longest[0]) == (0.0, pytest.approx(2.0 * 20.0 / 5.0, rel=1e-6))
    for factor, grows in ((0.98, False), (1.02, True)):
        step = factor * contact.longest[0]
        held = {"algorithm": "jacobi", "step": step, "extrapolation": 0}
        result = run(read_scene({**scene, "stop_time": 100 * step, "master": held}))
        assert (abs(result["h.temperature"][-1]) > 300.0) == grows


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_limit_is_the_one_that_a_run_has(degree):
    contact = advise(read_scene(spring(m=1.0))).limits[0]
    for factor, grows in ((0.98, False), (1.02, True)):
        step = round(factor * contact.longest[degree], 9)
        result = run(read_scene({**spring(m=1.0, step=step, extrapolation=degree), "stop_time": 600 * step}))
        motion = np.abs(result["m.v_out"])
        assert (motion[-50:].max() > motion[100:150].max()) == grows


def test_a_step_that_is_too_long_is_warned_of_with_the_limit():
    scene = read_scene(spring(m=1.0, k=100.0, d=2.0, step=0.05, extrapolation=0))
    (warning,) = advise(scene).warnings(scene)
    assert "m against s" in warning
    assert "stable up to 0.04 s" in warning
    scene = scene.with_changes({"master.step": 0.03})
    assert advise(scene).warnings(scene) == []


def test_what_cannot_be_told_is_said():
    told = {
        "delayed": spring(feedthrough="delayed", algorithm="gauss-seidel"),
        "rate": {**spring(), "units": {**spring()["units"], "s": {**spring()["units"]["s"], "every": 2}}},
    }
    for word, scene in told.items():
        advice = advise(read_scene(scene))
        assert advice.limits == ()
        assert word in advice.unknown[0]


def test_stale_outputs_have_the_shorter_limit():
    (contact,) = advise(read_scene(spring(m=1.0, feedthrough="delayed"))).limits
    assert contact.longest == pytest.approx((0.0131753, 0.0194849, 0.0200274), rel=1e-4)  # ω = 10 rad/s, D = 0.1


def test_steps_are_counted_to_the_end_with_the_shorter_last_one():
    advice = advise(read_scene({**spring(), "stop_time": 0.0105}))
    assert advice.steps == 11
    assert advice.seconds > 0.0


def test_fmus_tell_what_components_tell():
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 0.1})
    (fmu,), (here,) = advise(scene).limits, advise(scene, in_process=True).limits
    assert fmu.omega2 == here.omega2 > 0.0


def fine(substep: float):
    """Two units of which one takes a macro step in very many internal steps."""
    scene = spring(m=1.0, step=0.1)
    scene["units"]["m"] = component(Fine, m=1.0, substep=substep)
    return read_scene(scene)


def test_a_macro_step_of_millions_of_internal_steps_is_probed_over_a_part_of_it():
    """The limit is the same, the work is bounded, and the answer says that and how it was cut."""
    Fine.calls = 0
    advice = advise(fine(1e-9))
    assert Fine.calls < 20 * probing.MOST_CALLS
    (text,) = advice.cut
    assert text.startswith("the probe was cut: m takes ")
    assert "about 1e+08 for a whole one" in text
    assert text in [*lines(fine(1e-9), fine(1e-9).coupling, advice)]
    assert advice.limits[0].omega2 == pytest.approx(100.0, rel=1e-4)
    whole = advise(fine(1e-3))
    assert whole.cut == ()
    assert whole.limits[0].omega2 == pytest.approx(100.0, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "warns"),
    [
        ({}, False),
        ({"master.step": 1e-3, "start_time": 0.005}, False),
        ({"master.step": 2e-3, "start_time": 0.005}, True),  # steps end at odd milliseconds, samples are at even ones
        ({"master.step": 4e-3}, True),
        ({"master.step": 1.5e-3}, True),
        ({"units.controller.parameters.period": 3e-3}, True),
        ({"master.step": 1e-3, "units.controller.every": 2}, False),
        ({"master.step": 1e-3, "units.controller.every": 4}, True),
        ({"master.control.method": "doubling", "master.control.relative": 1e-3}, True),
    ],
    ids=str,
)
def test_samples_inside_macro_steps_are_warned_of(changes, warns):
    """The controller of `gimbal-scan` samples every 2 ms."""
    scene = load_scene("gimbal-scan", {"stop_time": 0.012, "analysis.transient": 0.0, **changes})
    texts = [text for text in run(scene, in_process=True).info["warnings"] if "samples every" in text]
    assert (len(texts) == 1 and texts[0].startswith("controller samples every 0.00")) if warns else not texts
