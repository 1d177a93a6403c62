"""The error that a run says of its numbers, against closed forms; and what it says where it cannot know."""

from itertools import product

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.harness.summary import verification_text
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.run import windows, work
from cosimo.orchestrator.run.comparison import (
    Difference,
    SignalError,
    difference,
    differences,
    figure_errors,
    scale_of,
    signal_errors,
)
from cosimo.orchestrator.run.key_results import KeyResults
from cosimo.orchestrator.run.run import run as run_once
from cosimo.orchestrator.run.run_record import VerificationRecord
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import OfTime, exact_two_masses, two_masses

HERE = "cosimo.tests.run.judgement.test_verification"
HALF, TWICE = 0.5, 2.0
SETTINGS = list(product(("jacobi", "gauss-seidel", "iterative"), (0, 1, 2), (2e-3, 5e-3, 1e-2)))


def exact(times):
    """(n, 2) positions and velocities of the first of two masses."""
    return np.array([exact_two_masses(t)[:2] for t in times])


@pytest.mark.parametrize(("algorithm", "degree", "step"), SETTINGS)
def test_the_error_of_every_signal_is_at_least_half_of_the_true_one(algorithm, degree, step):
    result = cosimo.run(read_scene(two_masses(algorithm, step, degree)), in_process=True)
    if result.outcome != "done":  # held inputs make energy
        assert result.outcome == "unstable"
        return
    truth = exact(result.time)
    for k, name in enumerate(("a.x_out", "a.v_out")):
        true = float(np.sqrt(np.mean((result[name] - truth[:, k]) ** 2)) / truth[:, k].std())
        said = result.info.verification.signals[name].rms
        assert said > HALF * true
        assert said < 4.0 * true + 1e-6
        warned = any("macro step is too long" in w for w in result.info.warnings)
        assert warned or true < 0.05 * TWICE


@pytest.mark.parametrize("n", [1, 255, 256, 257, 4501])
def test_sections_are_even_parts_of_a_run(n):
    gap = np.random.default_rng(n).uniform(0.5, 2.0, n)
    own = difference(np.ones(n), 1.0 + gap).sections * scale_of(1.0 + gap)
    expected = [np.sqrt(np.mean(part**2)) if part.size else 0.0 for part in np.array_split(gap, own.size)]
    assert own == pytest.approx(expected, rel=1e-14)


def test_a_figure_has_the_error_of_its_closed_form():
    """Mean contact force under held inputs against the iterated run's, which the pantograph's balance confirms."""
    scene = load_scene("en50318-2002").with_changes({"master.algorithm": "jacobi", "master.extrapolation": 0})
    rough = cosimo.run(scene, in_process=True)
    fine = run_once(
        scene.with_changes({"master.step": 6.25e-5, "master.extrapolation": 2, "record.interval": 1e-3}), in_process=True
    )
    exact_values = {row.name: row.value for row in fine.summary}
    for row in rough.summary:
        assert row.error >= HALF * abs(row.value - exact_values[row.name]) - 1e-9, row.name


def test_two_runs_give_twice_their_difference_and_three_the_sum():
    first = {"x": Difference(0.01, 0.02, np.zeros(8))}
    assert signal_errors(first, None)["x"].rms == pytest.approx(0.02)
    unsure = {"x": Difference(0.04, 0.1, np.zeros(8))}  # of an order that is not known
    assert signal_errors(unsure, None)["x"].rms == pytest.approx(0.12)
    three = signal_errors({"x": Difference(0.04, 0.1, np.zeros(8))}, {"x": Difference(0.01, 0.02, np.zeros(8))})["x"]
    assert (three.rms, three.largest, three.order) == pytest.approx((0.06, 0.14, 2.0))
    assert figure_errors([KeyResults({"a": 1.0}), KeyResults({"a": 1.5})]) == {"a": 1.0}
    assert figure_errors([KeyResults({"a": x}) for x in (1.0, 1.0, 1.25)]) == {"a": 0.5}  # no difference by chance
    assert np.isnan(figure_errors([KeyResults({"a": 1.0}), KeyResults()])["a"])


def test_what_hardly_varies_is_judged_by_its_size():
    assert scale_of(np.array([10.0, 10.0 + 1e-9])) == pytest.approx(10.0 * 1e-3)
    assert scale_of(np.array([-1.0, 1.0])) == 1.0
    assert scale_of(np.array([1e-17, -1e-17]), nominal=3.0) == pytest.approx(3e-6)  # a momentum that is conserved at 0


def test_an_angle_that_begins_anew_is_compared_within_a_turn():
    t = np.linspace(0.0, 10.0, 2001)
    first, second = (8.0 * t + 0.03) % (2.0 * np.pi), (8.0 * t) % (2.0 * np.pi)
    assert difference(first, second).rms > 0.05
    assert difference(first, second, angle=True).rms == pytest.approx(0.03 / second.std(), rel=1e-6)
    assert difference(8.0 * t, 8.0 * t + 4.0 * np.pi, angle=True).rms > 0.5  # whole turns of one that goes on are a difference


def test_a_jump_at_another_instant_is_told_from_a_wrong_history():
    t = np.linspace(0.0, 1.0, 1001)
    jump = difference(np.where(t < 0.5, 0.0, 1.0), np.where(t < 0.501, 0.0, 1.0))
    drift = difference(np.sin(20.0 * t), np.sin(20.1 * t))
    errors = signal_errors({"jump": jump, "drift": drift}, None)
    assert errors["jump"].shifted
    assert not errors["drift"].shifted


class Flag(OfTime):
    """Tells from when on a signal that rises evenly is above a level; what it gives is as old as a step."""

    level = parameter(0.5, "1", "level")
    on = output("1", "1 while the time is above the level, else 0")

    def _outputs(self, t):
        self.y[0] = t > self.parameters["level"]


def test_flags_differ_by_their_share_of_the_time():
    scene = {"stop_time": 1.0, "units": {"f": {"component": f"{HERE}:Flag"}}, "master": {"step": 0.01}}
    first, second = (run_once(read_scene(scene).with_changes({"f.level": level})) for level in (0.5, 0.75))
    compared = differences(first, second)["f.on"]
    assert compared.rms == pytest.approx(0.25, abs=0.01)
    assert compared.largest == 1.0


def test_a_run_that_is_not_verified_says_so():
    scene = read_scene(two_masses("jacobi", 1e-2, 1))
    result = cosimo.run(scene, in_process=True, verify="no")
    assert result.info.verification == VerificationRecord(done=False, why="not asked for")
    with pytest.raises(BadInput, match="auto, whole, full, steps, no"):
        cosimo.run(scene, in_process=True, verify="maybe")


def test_a_verified_run_takes_twice_the_steps_more(monkeypatch):
    steps = []

    def counted(scene, **options):
        result = run_once(scene, **options)
        steps.append(result.info.counters.master["steps"])
        return result

    monkeypatch.setattr(verification, "run", counted)
    cosimo.run(load_scene("mass-on-spring"), in_process=True)
    assert steps[1:] == [2 * steps[0]]


@pytest.mark.first
@pytest.mark.parametrize("step", [4e-3, 1e-3])
def test_windows_show_the_error_of_a_run_that_forgets(step, monkeypatch):
    """Driven forever by the ground, damped within a second: what a window shows is what the whole run has."""
    scene = read_scene(
        {
            "stop_time": 200.0,
            "connections": ["s.force -> m.force", "m.x_out -> s.position"],
            "units": {
                "m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": 40.0, "c": 4.0}},
                "s": {"component": f"{HERE}:Driven"},
            },
            "master": {"algorithm": "jacobi", "step": step, "extrapolation": 0},
        }
    )
    whole = cosimo.run(scene, in_process=True, verify="whole").info.verification
    monkeypatch.setattr(work, "BUDGET", 0.0)
    some = cosimo.run(scene, in_process=True).info.verification
    assert (whole.how, some.how) == ("whole", "windows")
    assert some.figures == {}
    assert some.windows.growing == ()
    factor = 3.0 if whole.signals["m.x_out"].rms > 0.06 else 2.0  # two runs only
    assert some.signals["m.x_out"].rms == pytest.approx(whole.signals["m.x_out"].rms, rel=0.1 + factor - 2.0)


def test_windows_show_the_error_of_internal_steps(monkeypatch):
    """Bristles of a robot in its own short steps: half the macro step alone says 2e-6 where half of the internal steps says 3e-3."""
    changes = {
        "master.algorithm": "iterative",
        "master.extrapolation": 1,
        "stop_time": 6.0,
        "record.signals": ["lugre.friction_force"],
    }
    scene = load_scene("pipe-robot-climb").with_changes(changes)
    whole = cosimo.run(scene, in_process=True, verify="whole").info.verification
    monkeypatch.setattr(work, "BUDGET", 0.0)
    some = cosimo.run(scene, in_process=True).info.verification
    assert (whole.how, some.how) == ("whole", "windows")
    assert some.inside == whole.inside != {}
    stated, true = (v.signals["lugre.friction_force"].rms for v in (some, whole))
    assert true > 1e-3
    assert 0.4 * true < stated < 3.0 * true


class Driven(OfTime):
    """A spring of 10 N/m to a ground that moves with 2 rad/s."""

    position = input_(0.0, "m", "position")
    force = output("N", "force", feedthrough=("position",))

    def _outputs(self, t):
        self.y[0] = 10.0 * (np.sin(2.0 * t) - self.u[0, 0])


@pytest.mark.first(2)
@pytest.mark.parametrize("event", [0.003, 0.71, 0.19, 0.5, 0.995])
def test_windows_lie_where_the_signals_bend(event, monkeypatch):
    """At rest but for a knock of 0.1 s somewhere in a run of 200 s: all of its error is there."""
    begin = 200.0 * event - 0.2
    scene = read_scene(
        {
            "stop_time": 200.0,
            "connections": ["s.force -> m.force", "m.x_out -> s.position"],
            "units": {
                "m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": 40.0, "c": 4.0, "v0": 0.0}},
                "s": {"component": f"{HERE}:Knocked", "parameters": {"begin": begin}},
            },
            "master": {"algorithm": "jacobi", "step": 4e-3, "extrapolation": 0},
        }
    )
    whole = cosimo.run(scene, in_process=True, verify="whole").info.verification.signals["m.x_out"]
    monkeypatch.setattr(work, "BUDGET", 0.0)
    some = cosimo.run(scene, in_process=True).info.verification
    assert some.how == "windows"
    assert any(t <= begin <= t + some.windows.length for t in some.windows.begins)
    assert some.windows.growing == ()
    assert 0.5 * whole.rms < some.signals["m.x_out"].rms < 2.0 * whole.rms


class Knocked(OfTime):
    """A spring of 10 N/m to a ground that moves 1 m for 0.1 s."""

    begin = parameter(0.0, "s", "when")
    position = input_(0.0, "m", "position")
    force = output("N", "force", feedthrough=("position",))

    def _outputs(self, t):
        there = 0.0 <= t - self.parameters["begin"] < 0.1
        self.y[0] = 10.0 * (there - self.u[0, 0])


def test_places_of_windows_are_the_ends_and_what_they_do_not_show():
    still = np.zeros((50, 3))
    assert windows.places(still) == [0, 16, 33, 49] or windows.places(still)[0] == 0
    bent = still.copy()
    bent[7, 0] = bent[30, 1] = bent[31, 2] = 1.0
    assert windows.places(bent) == [0, 7, 30, 49]
    assert windows.places(bent[:2]) == [0, 1]
    assert windows.places(bent[:1]) == [0]


def test_a_run_too_long_to_repeat_names_what_keeps_windows_out(monkeypatch):
    scene = read_scene({**two_masses("jacobi", 1e-2, 1), "faults": [{"kind": "freeze", "signal": "b.force", "begin": 0.5}]})
    assert windows.obstacle(scene) == "faults"
    monkeypatch.setattr(work, "BUDGET", 0.0)
    found = cosimo.run(scene, in_process=True).info.verification
    assert not found.done
    assert "windows of it cannot be repeated with faults" in found.why


@pytest.mark.full
def test_a_chaotic_motion_says_that_its_histories_are_one_of_many():
    result = cosimo.run(load_scene("ball-bearing-clearance"), in_process=True)
    assert any("chaotic" in warning for warning in result.info.warnings)
    assert result.outcome == "done"


def test_a_coupling_that_makes_a_motion_of_its_own_is_unstable():
    """A contact that opens keeps bounded what the steps make grow: no limit is passed, and half the step shows another run."""
    error = SignalError(3.0, 9.0, grown=5.0, late=5.0)
    scene = read_scene(two_masses("jacobi", 1e-2, 1))
    result = run_once(scene, in_process=True)
    judged = verification._judged(result, verification.Verification(True, step=5e-3, runs=2, signals={"a.x_out": error}))
    assert judged.outcome == "unstable"
    assert "5 times that of a run with shorter steps" in judged.message


@pytest.mark.parametrize("substep", [2e-3, 1e-2])
def test_the_error_of_internal_steps_is_in_the_number(substep):
    """A chain alone: no coupling, so that the macro step makes no error at all."""
    changes = {"stop_time": 4.0, "chain.substep": substep}
    scene = load_scene("double-pendulum").with_changes(changes)
    rough = cosimo.run(scene, in_process=True)
    fine = run_once(scene.with_changes({"chain.substep": 1e-4}), in_process=True)
    for name, error in rough.info.verification.signals.items():
        true = np.sqrt(np.mean((rough[name] - fine[name]) ** 2)) / scale_of(fine[name])
        assert error.rms > HALF * true - 1e-9, name
        assert error.rms < 4.0 * true + 1e-6, name
    assert rough.info.verification.inside == {"chain.substep": substep}


def test_internal_steps_of_an_effect_are_halved_too():
    """A winding makes two internal steps in a macro step: half of the macro step alone changed nothing, and the error was told as 0."""
    winding = {"component": "TorqueMotor", "effects": ["inductance"], "parameters": {"voltage": 5.0}}
    scene = read_scene(
        {"stop_time": 2e-3, "units": {"m": winding}, "master": {"step": 4e-4}, "record": {"signals": ["m.current"]}}, "s"
    )
    result = cosimo.run(scene, in_process=True)
    wrong = result["m.current"] - 2.5 * (1.0 - np.exp(-2000.0 * result.time))
    said = result.info.verification.signals["m.current"].rms * result["m.current"].std()
    assert 1e-5 < np.sqrt(np.mean(wrong**2)) <= 2.0 * said


def test_a_warning_names_the_steps_that_make_the_error():
    scene = load_scene("double-pendulum").with_changes({"stop_time": 8.0, "master.step": 0.04, "chain.substep": 1e-2})
    text, *_ = cosimo.run(scene, in_process=True).info.warnings
    assert text.startswith("the internal steps (chain.substep) are too long for")
    assert "chain.substep = " in text
    assert "master.step" not in text
    held = load_scene("en50318-2002").with_changes({"stop_time": 1.0, "master.extrapolation": 0})
    (text, *_) = cosimo.run(held, in_process=True).info.warnings
    assert text.startswith("the macro step is too long for")
    assert "substep" not in text


def test_chaos_is_told_from_a_drifting_phase():
    """The double pendulum has parted after a twentieth of the run; an oscillator of a wrong frequency drifts apart as the step has it."""
    chaos = cosimo.run(load_scene("double-pendulum").with_changes({"stop_time": 300.0}), in_process=True)
    assert chaos.info.warnings[0].startswith("the motion is chaotic")
    t = np.linspace(0.0, 400.0, 20_001)
    runs = [np.sin((1.0 + 0.32 * h) * t) for h in (1.0, 0.5, 0.25)]
    drift = signal_errors({"x": difference(runs[0], runs[1])}, {"x": difference(runs[1], runs[2])})["x"]
    assert drift.rms > 1.0
    assert not drift.parted


class Refined(OfTime):
    """2 rad/s: `exact`, `value` with an error of its internal steps, `rough` with one of its mesh."""

    substep = parameter(1e-2, "s", "internal step")
    tolerance = parameter(1e-6, "1", "tolerance of nothing", low=5e-7)
    element = parameter(0.0, "m", "length of elements")
    value = output("1", "too large with the internal step")
    exact = output("1", "exact")
    rough = output("1", "too large with the mesh")

    def _outputs(self, t):
        p, sine = self.parameters, np.sin(2.0 * t)
        self.y[:] = sine * (1.0 + 20.0 * p["substep"]), sine, sine * (1.0 + p["element"])


class Late(OfTime):
    """What comes in, a macro step later."""

    given = input_(0.0, "1", "what comes in")
    value = output("1", "what came in")

    def _outputs(self, t):
        self.y[0] = self.u[0, 0]


def refined_scene(**parameters):
    return read_scene(
        {
            "stop_time": 5.0,
            "connections": ["inner.exact -> late.given"],
            "units": {"inner": {"component": f"{HERE}:Refined", "parameters": parameters}, "late": {"component": f"{HERE}:Late"}},
            "master": {"step": 0.05, "extrapolation": 0, "algorithm": "jacobi"},
        }
    )


def test_each_warning_names_the_steps_that_make_its_own_error():
    warnings = cosimo.run(refined_scene(), verify="whole").info.warnings
    assert sorted(text.partition(". ")[0] for text in warnings) == [
        "the internal steps (inner.substep) are too long for inner.value",
        "the macro step is too long for late.value",
    ]
    assert all(("master.step" in text) != ("inner.substep" in text) for text in warnings)


def test_a_refinement_that_is_refused_is_named_and_the_other_errors_are_kept():
    """Tolerance at its lower limit, below which the scene refuses it."""
    plain = cosimo.run(refined_scene(), verify="whole").info.verification
    both = cosimo.run(refined_scene(), verify="full")
    found = both.info.verification
    assert (found.done, found.signals, found.parts) == (True, plain.signals, {})
    assert list(found.not_refined) == ["inner.tolerance"]
    assert "tolerance = 1e-07, expected a value in [5e-07, inf]" in found.not_refined["inner.tolerance"]
    assert "exclude the error due to inner.tolerance" in verification_text(found)
    assert sum("could not be refined" in text for text in both.info.warnings) == 1


def test_components_that_run_as_fmus_are_repeated_in_process():
    scene = load_scene("en50318-2002").with_changes({"stop_time": 0.3})
    here, fmu = (cosimo.run(scene, in_process=in_process).info.verification for in_process in (True, False))
    assert here.signals == fmu.signals


@pytest.mark.parametrize(
    ("changes", "remedy"),
    [
        ({}, ""),
        ({"record.interval": 0.05}, ""),
        ({"record.interval": 0.5}, "Lower record.interval, which is 0.5 s"),
        ({"master.step": 0.25, "mass.start_velocity_x": 0.0}, ""),
    ],
)
def test_rows_too_far_apart_to_show_a_signal_are_a_warning(changes, remedy):
    """An oscillation of 0.6 s: rows half a second apart miss its extremes, whatever the step; what stands still is shown."""
    result = cosimo.run(load_scene("mass-on-spring").with_changes(changes), in_process=True)
    said = [w for w in result.info.warnings if "samples are too far apart" in w]
    assert bool(said) == bool(remedy)
    assert all(remedy in w for w in said)
    assert bool(result.info.verification.unseen) == bool(remedy)
