"""Advice before a run: whether its coupling is stable, what is not examined and why, and what a run costs."""

import math

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.components.core.variables import parameter
from cosimo.orchestrator.judgement import advice as advice_of
from cosimo.orchestrator.judgement import advise
from cosimo.orchestrator.judgement.dry_run import lines
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.run.judgement.closed_form import longest_step
from cosimo.tests.support import Mass

of_machine_code = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


class Fine(Mass):
    """A mass that counts as many internal steps as its substep asks for."""

    calls = 0
    substep = parameter(1e-3, "s", "internal step")

    def _step(self, t, h):
        internal = math.ceil(h / self.parameters["substep"] * (1.0 - 1e-9))
        self.counts[0] += internal - 1
        Fine.calls += internal
        return super()._step(t, h)


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


@of_machine_code
def test_the_limit_is_known_at_once_where_the_derivative_of_a_step_is_constant():
    scene = load_scene("mass-on-spring")
    advice = advise(scene, in_process=True)
    assert advice.stability.limit.longest == pytest.approx(longest_step(100.0, 4.0, 1), rel=1e-6)
    assert "longest stable macro step: 0.1213 s" in [*lines(scene, scene.coupling, advice)]
    assert "a disturbance decays by a factor of 2.7 in 99.8 steps" in " ".join(advice.lines())
    assert advice.warnings(scene) == []


@of_machine_code
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"master.step": 0.13}, "stable up to 0.121 s with master.extrapolation = 1"),
        (
            {"spring.damping": 0.0, "master.extrapolation": 0},
            "Change master.extrapolation: with master.extrapolation = 0 no macro step",
        ),
    ],
)
def test_an_unstable_step_is_warned_of(changes, words):
    scene = load_scene("mass-on-spring").with_changes(changes)
    (warning,) = advise(scene, in_process=True).warnings(scene)
    assert "the coupling is unstable: a disturbance grows" in warning
    assert words in warning


@of_machine_code
def test_growth_along_the_run_is_told_with_the_damping_that_the_coupling_takes_away():
    scene = load_scene("lumped-catenary").with_changes({"master.step": 8e-3})
    advice = advise(scene, in_process=True)
    told = " ".join(advice.lines())
    assert advice.stability.limit is None
    assert "mean of the first 5 s" in told
    assert f"damping that the coupling takes away: {advice.stability.growth.lost:.3g} 1/s" in told
    assert advice.stability.growth.lost > 1.0
    too_long = scene.with_changes({"master.step": 0.02})
    (warning,) = advise(too_long, in_process=True).warnings(too_long)
    assert warning.endswith("Reduce the macro step; cosimo stability tells the longest stable one")


@of_machine_code
def test_a_run_of_few_macro_steps_is_not_called_stable():
    """Growth ends at bounds within few steps; what it shows as unstable is."""
    few = load_scene("lumped-catenary").with_changes({"master.step": 5e-3, "stop_time": 0.9})
    assert advise(few, in_process=True).stability.why == "the run has too few macro steps to see growth along it"
    assert advise(few.with_changes({"master.step": 2e-2}), in_process=True).stability.growth.unstable


@of_machine_code
def test_what_grows_by_itself_is_no_fault_of_the_step():
    """A ground that a negative damper drives lets a mass swing up, whatever the step."""
    mass, between = (f"cosimo.tests.derivatives.coupled_masses:{name}" for name in ("Owner", "Between"))
    scene = read_scene(
        {
            "stop_time": 20.0,
            "connections": ["s.force -> m.force", "m.x_out -> s.x1", "m.v_out -> s.v1"],
            "units": {"m": {"component": mass, "parameters": {"c": -0.2, "v0": 1.0}}, "s": {"component": between}},
            "master": {"algorithm": "jacobi", "step": 1e-3, "extrapolation": 2},
        }
    )
    advice = advise(scene)
    assert "grows by a factor of 2.7 in 1.05e+04 steps, as it does with shorter steps" in next(advice.lines())
    assert advice.warnings(scene) == []


@of_machine_code
def test_a_long_run_is_examined_over_its_beginning(monkeypatch):
    scene = load_scene("lumped-catenary")
    work = advise(scene, in_process=True).work * scene.duration / scene.master.step
    monkeypatch.setattr(advice_of, "PREFIX_WORK", 0.2 * advice_of.RUNS * work)
    stability = advise(scene, in_process=True).stability
    assert stability.looked == pytest.approx(0.2 * scene.duration)
    assert stability.growth.duration == stability.looked
    monkeypatch.setattr(advice_of, "PREFIX_WORK", 0.01 * advice_of.RUNS * work)
    assert "too much work" in advise(scene, in_process=True).stability.why


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (spring(), "m (a component in plain Python)" if COMPILED else "no machine code"),
        (spring(algorithm="iterative"), "iterative" if COMPILED else "no machine code"),
    ],
)
def test_what_is_not_examined_is_said_with_the_reason(scene, words):
    scene = read_scene(scene)
    advice = advise(scene)
    (line,) = advice.lines()
    assert line.startswith("stability of the coupling: not examined: ")
    assert words in line
    assert advice.warnings(scene) == []


def test_nothing_is_said_of_units_that_do_not_feed_one_another():
    assert [*advise(load_scene("double-pendulum", {"stop_time": 0.1}), in_process=True).lines()] == []


def test_steps_are_counted_to_the_end_with_the_shorter_last_one():
    advice = advise(read_scene({**spring(), "stop_time": 0.0105}))
    assert advice.steps == 11
    assert advice.seconds > 0.0


def fine(substep: float):
    """Two units of which one takes a macro step in very many internal steps."""
    scene = spring(m=1.0, step=0.1)
    scene["units"]["m"] = component(Fine, m=1.0, substep=substep)
    return read_scene(scene)


def test_a_macro_step_of_millions_of_internal_steps_is_probed_over_a_part_of_it():
    """The work is bounded, and the answer says that and how it was cut."""
    Fine.calls = 0
    advice = advise(fine(1e-9))
    assert Fine.calls < 20 * advice_of.MOST_CALLS
    (text,) = advice.cut
    assert text.startswith("the probe was cut: m takes ")
    assert "about 1e+08 for a whole one" in text
    assert text in [*lines(fine(1e-9), fine(1e-9).coupling, advice)]
    assert advise(fine(1e-3)).cut == ()


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
    texts = [text for text in run(scene, in_process=True).info.warnings if "samples every" in text]
    assert (len(texts) == 1 and texts[0].startswith("controller samples every 0.00")) if warns else not texts
