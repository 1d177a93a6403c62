"""Units that step with every n-th macro step: order of accuracy, who waits for whom, and the end of the run."""

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.engine.algorithms.test_rows import N
from cosimo.tests.scene_runs import finished
from cosimo.tests.short_run import full_but
from cosimo.tests.slopes import slope
from cosimo.tests.support import Integrals, OfTime, exact_two_masses, two_masses

HERE = "cosimo.tests.engine.algorithms.test_multirate"
STATES = [("a", "x_out"), ("a", "v_out"), ("b", "x_out"), ("b", "v_out")]


class Power(OfTime):
    """Gives t^4, which starts so flat that a start without history costs nothing."""

    y = output("m", "t^4")

    def _outputs(self, t):
        self.y[0] = t**4


class Integral(Integrals):
    """Integrates its input exactly, whatever polynomial it is."""

    u_in = input_(0.0, "m", "input")
    x_out = output("m.s", "integral")


def masses(rates: dict, algorithm: str, step: float, degree: int, stop: float = 0.6) -> dict:
    scene = two_masses(algorithm, step, degree) | {"stop_time": stop}
    for unit, every in rates.items():
        scene["units"][unit]["every"] = every
    return scene


def spied_steps(monkeypatch) -> list[tuple[str, float, float]]:
    """A list that will hold the steps of components with Python in their steps: unit, time, length."""
    calls, step = [], Component.step

    def spied(self, t, h):
        calls.append((self.name, t, h))
        return step(self, t, h)

    monkeypatch.setattr(Component, "step", spied)
    return calls


@pytest.mark.parametrize("degree", [0, 1])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("rates", full_but(({"a": 3},), ({"a": 3}, {"b": 3}, {"a": 2, "b": 4}, {"a": 3, "b": 2})), ids=str)
def test_the_order_of_accuracy_is_kept(rates, algorithm, degree):
    """Against the matrix exponential of the whole, as without rates."""
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        result = run(read_scene(masses(rates, algorithm, step, degree)))
        reached = np.array([result[f"{u}.{n}"][-1] for u, n in STATES])
        errors.append(np.abs(reached - exact_two_masses(0.6)).max())
    assert abs(slope(0.5 ** np.arange(len(errors)), errors) - (degree + 1)) < 0.15


@pytest.mark.parametrize("slow", ["source", "sink"])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_order_holds_up_to_quadratic_inputs(degree, algorithm, slow):
    """The integral of t^4 over 1 s is 1/5. Listed first, the sink has to wait all the same where it can."""
    errors = []
    for steps in (48, 96, 192):
        units = {"sink": {"component": f"{HERE}:Integral"}, "source": {"component": f"{HERE}:Power"}}
        units[slow]["every"] = 4
        scene = {
            "stop_time": 1.0,
            "units": units,
            "connections": ["source.y -> sink.u_in"],
            "master": {"algorithm": algorithm, "step": 1.0 / steps, "extrapolation": degree},
        }
        errors.append(abs(run(read_scene(scene))["sink.x_out"][-1] - 0.2))
    assert abs(slope(0.5 ** np.arange(len(errors)), errors) - (degree + 1)) < (0.15 if degree < 2 else 0.5)


def test_a_slow_unit_with_known_inputs_is_as_good_as_its_own_steps():
    """Inputs that others have reached already are no guess: the sink's error is that of the trapezoidal rule over 4 steps."""
    steps = 40
    scene = {
        "stop_time": 1.0,
        "connections": ["source.y -> sink.u_in"],
        "units": {"source": {"component": f"{HERE}:Power"}, "sink": {"component": f"{HERE}:Integral", "every": 4}},
        "master": {"algorithm": "gauss-seidel", "step": 1.0 / steps, "extrapolation": 1},
    }
    nodes = np.linspace(0.0, 1.0, steps // 4 + 1)
    assert run(read_scene(scene))["sink.x_out"][-1] == pytest.approx(np.trapezoid(nodes**4, nodes), rel=1e-13)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_it_steps_when_the_others_are_there_and_holds_its_outputs_until_then(algorithm, monkeypatch):
    """Calls of 10 macro steps with every = 4: at the 4th, at the 8th, and over the two that are left at the end."""
    calls = spied_steps(monkeypatch)
    result = run(read_scene(masses({"b": 4}, algorithm, 0.01, 1, stop=0.1)))
    calls = [(name, round(t, 9), round(t + h, 9)) for name, t, h in calls]
    slow = [(begin, end) for name, begin, end in calls if name == "b"]
    assert slow == [(0.0, 0.04), (0.04, 0.08), (0.08, 0.1)]
    for k, call in enumerate(calls):
        if call[0] == "b":
            reached = max(end for name, _, end in calls[: k + 2] if name == "a")  # the other steps in the same macro step
            assert call[2] <= reached
    x = result["b.x_out"]
    assert len(set(x[0:4])) == len(set(x[4:8])) == len(set(x[8:10])) == 1
    assert len(set(x)) == 4
    assert result.info.counters.units["b"]["steps"] == 3
    assert result.info.counters.units["a"]["steps"] == 10


@pytest.mark.parametrize(("start", "stop"), [(-10.0, -9.9), (-0.1, 0.0)])
def test_the_last_steps_are_taken_where_a_run_ends_before_zero_or_there(start, stop):
    scene = masses({"b": 4}, "jacobi", 0.01, 1, stop=stop) | {"start_time": start}
    assert run(read_scene(scene)).info.counters.units["b"]["steps"] == 3


SHIFT = {"signal": "a.force", "kind": "offset", "value": 1.0, "begin": 1.005}


@pytest.mark.parametrize(("faults", "uneven"), [([], []), ([SHIFT], [0.06, 0.01])])
def test_its_steps_are_whole_multiples_of_the_macro_step(faults, uneven, monkeypatch):
    """To the last bit at any time. Where a fault begins between two macro steps, four take the time of three: 7 are 0.06 s."""
    calls = spied_steps(monkeypatch)
    run(read_scene(masses({"b": 7}, "jacobi", 0.01, 1, stop=2.8) | {"faults": faults}), in_process=True)
    lengths = {h for name, _, h in calls if name == "b"}
    assert 7 * 0.01 in lengths
    assert len(lengths) == 1 + len(uneven)
    assert all(any(abs(h - other) < 1e-12 for h in lengths) for other in uneven)


def test_recording_more_rarely_than_every_step_shows_the_same_values():
    """Held outputs come from the table of signals or from the unit: the same."""
    scene = masses({"a": 3}, "jacobi", 0.01, 1, stop=0.12)
    each = run(read_scene(scene))
    rarely = run(read_scene({**scene, "record": {"interval": 0.02}}))
    for name in each.columns:
        np.testing.assert_array_equal(each[name][::2], rarely[name])


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_a_run_goes_on_from_between_two_steps_of_a_slow_unit_to_the_same_bits(algorithm, tmp_path):
    scene = read_scene(masses({"a": 3, "b": 4}, algorithm, 0.01, 2, stop=0.5))
    whole = run(scene)
    run(scene, checkpoint_every=0.17, checkpoint_to=tmp_path / "file")  # the last one at 0.34 s, after 34 macro steps
    resumed = run(scene, resume=tmp_path / "file")
    assert resumed.info.resumed.at == pytest.approx(0.34)
    for name in whole.columns:
        assert resumed[name].tobytes() == whole[name].tobytes()


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("begin", [0.02, 0.04, 0.18])
def test_an_input_that_jumps_between_two_steps_of_a_slow_unit(begin, degree):
    """A constant that jumps from 0 to 3: the slow unit gets the jump somewhere in its step, and forgets what was before it."""
    scene = {
        "stop_time": 0.4,
        "connections": ["p.y -> i.u_in"],
        "master": {"algorithm": "jacobi", "step": 0.02, "extrapolation": degree},
        "units": {"p": {"component": f"{HERE}:Power"}, "i": {"component": f"{HERE}:Integral", "every": 4}},
        "faults": [
            {"kind": "override", "signal": "i.u_in", "begin": 0.0, "end": begin, "value": 0.0},
            {"kind": "override", "signal": "i.u_in", "begin": begin, "value": 3.0},
        ],
    }
    result = finished(read_scene(scene))
    each = np.diff(result["i.x_out"][::4]) / (3.0 * 0.08)  # in steps of the slow unit, as shares of what 3 gives
    jump = int(begin / 0.08)
    np.testing.assert_allclose(each[:jump], 0.0, atol=1e-12)
    assert 0.0 <= each[jump] <= 1.0 + 1e-12
    np.testing.assert_allclose(each[jump + 1 :], 1.0, rtol=1e-12)


@pytest.mark.parametrize("degree", [1, 2])
def test_wide_connections_of_a_slow_unit_are_many_narrow_ones(degree):
    parts, where = 2, "cosimo.tests.engine.algorithms.test_rows"
    base = {"stop_time": 1.0, "master": {"algorithm": "gauss-seidel", "step": 0.05, "extrapolation": degree}}
    source = {"component": f"{where}:Source", "every": 3}
    wide = run(
        read_scene(
            {
                **base,
                "units": {"a": source, "b": {"component": f"{where}:Sink"}},
                "connections": ["a.wave* -> b.wave*"],
                "record": {"signals": ["b.area"]},
            }
        )
    )
    narrow = run(
        read_scene(
            {
                **base,
                "units": {"a": source, **{f"b{k}": {"component": f"{where}:Sink"} for k in range(parts)}},
                "connections": [f"a.wave[{i}] -> b{i % parts}.wave[{i}]" for i in range(1, N + 1)],
                "record": {"signals": [f"b{i % parts}.area[{i}]" for i in range(1, N + 1)]},
            }
        )
    )
    for i in range(1, N + 1):
        np.testing.assert_array_equal(wide[f"b.area[{i}]"], narrow[f"b{i % parts}.area[{i}]"])


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"algorithm": "iterative"}, ["units.b.every", "iterative"]),
        ({"control": {"method": "milne"}}, ["units.b.every", "master.control"]),
        ({"events": ["a.x_out"]}, ["units.b.every", "master.events"]),
        ({"step": 0.2}, ["units.b.every", "8", "steps of the run, 5"]),
    ],
)
def test_where_no_unit_can_have_a_rate_of_its_own(change, named):
    scene = masses({"b": 8}, "jacobi", 0.01, 1, stop=1.0)
    scene["master"] |= change
    with pytest.raises(BadInput) as caught:
        read_scene(scene)
    for part in named:
        assert part in str(caught.value)


def test_a_rate_changes_what_a_scene_gives():
    plain, slow = (run(read_scene(masses(rates, "jacobi", 7e-3, 1))) for rates in ({}, {"b": 4}))
    assert plain["a.x_out"].tobytes() != slow["a.x_out"].tobytes()
    assert np.all(slow["b.x_out"][1:4] == slow["b.x_out"][0])


@pytest.mark.parametrize("slow", ["catenary", "pantograph"])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_fmus_with_rates_of_their_own_give_the_bits_of_components(algorithm, slow):
    """The railway pair, which takes a fault in the middle of a step of the slow unit."""
    fault = {"signal": "pantograph.contact_position", "kind": "offset", "value": 0.5, "begin": 0.0573}
    scene = load_scene("lumped-catenary").with_changes(
        {"stop_time": 0.1505, "master.algorithm": algorithm, f"units.{slow}.every": 4, "faults": [fault]}
    )
    fmus, here = run(scene), run(scene, in_process=True)
    assert (fmus.outcome, here.outcome) == ("done", "done"), fmus.message
    assert fmus.time.tobytes() == here.time.tobytes()
    for name in here.columns:
        assert fmus[name].tobytes() == here[name].tobytes(), name
    sound = run(scene.with_changes({"faults": []}), in_process=True)
    before, after = (np.isin(sound.time, here.time) & part for part in (sound.time < 0.05, sound.time > 0.1))
    contact = "pantograph.contact_force"
    assert (sound[contact][before] == here[contact][np.isin(here.time, sound.time[before])]).all()
    assert (sound[contact][after] != here[contact][np.isin(here.time, sound.time[after])]).any()
