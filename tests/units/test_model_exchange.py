"""FMUs for model exchange: integration against closed forms, events where they belong, rollback, what is refused.

The FMU complains of every call in a mode that does not allow it, so that each of these tests also holds the order of calls.
"""

import math
import re

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe, open_unit
from cosimo.orchestrator.units.interface import SimulationEnded
from cosimo.orchestrator.units.solvers import METHODS
from cosimo.tests.scene_runs import finished
from cosimo.tests.units.exchange_fmu import CAPABILITIES, exchange_fmu
from scipy.integrate import solve_ivp

G, E = 9.81, 0.7
H = 0.4  # s: the ball is in its first fall
SPREAD = 2.0 * math.sqrt(3.0)  # a state's error in a step: below relative (|x| + nominal), as root mean square of three states


def scene(parameters=None, fmu=None, step=0.1, stop=1.0, **unit) -> dict:
    return {
        "stop_time": stop,
        "units": {"f": {"fmu": fmu or exchange_fmu(), "parameters": parameters or {}, **unit}},
        "master": {"step": step},
    }


def opened(parameters=None, inputs=("u",), outputs=("x",), values=(0.0,), **more):
    """A unit at t = 0 with its initial inputs."""
    unit = open_unit("f", read_scene(scene(parameters, **more)).units["f"], in_process=False)
    unit.wire(list(inputs), list(outputs))
    unit.initialize(0.0, list(values))
    unit.start()
    return unit


@pytest.mark.parametrize("solver", METHODS)
@pytest.mark.parametrize("relative", [1e-4, 1e-8])
def test_a_polynomial_input_is_followed_within_the_step(solver, relative):
    """x' = -2 x + 1 + 2 t + 3 t² has the particular solution 3/4 - t/2 + 3/2 t²; errors of steps add up at the most."""
    unit = opened({"k": 2.0}, solver=solver, tolerance=relative)
    unit.drive([1.0], [2.0], [3.0], H)
    unit.step(0.0, H)
    exact = 0.75 - 0.5 * H + 1.5 * H**2 - 0.75 * math.exp(-2.0 * H)
    assert abs(unit.get()[0] - exact) < unit.work()["solver_steps"] * SPREAD * relative
    assert unit.event is None
    unit.close()


def test_the_input_keeps_the_value_it_has_reached():
    unit = opened({"k": 0.0}, solver="DOP853", tolerance=1e-10)
    unit.drive([1.0], [2.0], None, 1.0)
    unit.step(0.0, 1.0)
    unit.step(1.0, 1.0)
    # 1 + 1 in the first step, 3 in the second; a polynomial of degree 1 is integrated to rounding
    assert unit.get()[0] == pytest.approx(5.0, rel=1e-13)
    unit.close()


def height(t: float, rest: float = 0.0) -> tuple[float, int]:
    """Height of the ball and its bounces until t; slower than `rest` it lies."""
    hit, v = math.sqrt(2.0 / G), E * math.sqrt(2.0 * G)
    if t < hit:
        return 1.0 - G * t * t / 2.0, 0
    bounces = 1
    while v >= rest and t >= hit + 2.0 * v / G:
        hit, v, bounces = hit + 2.0 * v / G, E * v, bounces + 1
    return (v * (t - hit) - G * (t - hit) ** 2 / 2.0 if v >= rest else 0.0), bounces


@pytest.mark.parametrize(("solver", "step"), [("CVode", 0.1), ("CVode", 0.01), ("RK45", 0.1), ("LSODA", 0.1), ("Radau", 0.05)])
def test_a_ball_bounces_when_it_should(solver, step):
    """Four bounces in two seconds; each turns an error of the height into one of the time by 1/v, and v > 1 m/s."""
    relative = 1e-9
    result = finished(read_scene(scene(step=step, stop=2.0, solver=solver, tolerance=relative)))
    counted = result.info.counters.units["f"]
    exact = [height(t)[0] for t in result.time]
    before, after = ([height(t + s)[1] for t in result.time] for s in (-1e-6, 1e-6))
    assert max(before) == 4
    assert all(b <= n <= a for b, n, a in zip(before, result["f.bounces"], after, strict=True))
    assert np.abs(result["f.h"] - exact).max() < 4 * counted["solver_steps"] * SPREAD * relative


@pytest.mark.parametrize("solver", ["CVode", "RK45"])
def test_the_event_is_told_with_its_time(solver):
    unit = opened(inputs=(), values=(), outputs=("h",), solver=solver, tolerance=1e-10)
    unit.step(0.0, 0.4)
    unit.get()
    assert unit.event is None
    unit.step(0.4, 0.4)
    unit.get()
    assert unit.event == pytest.approx(math.sqrt(2.0 / G), abs=1e-9)
    unit.close()


@pytest.mark.parametrize("period", [0.25, 0.1, 0.03])
@pytest.mark.parametrize("bare", [True, False])
def test_events_of_time_are_met_exactly(period, bare):
    """Sums of 0.1 are a rounding off the ticks of the run, which still belong to the instant."""
    result = run(read_scene(scene({"period": period}, exchange_fmu(bare))))
    assert result["f.ticks"].tolist() == [int(t / period + 1e-9) for t in result.time]


@pytest.mark.parametrize("bare", [True, False])
@pytest.mark.parametrize("solver", ["CVode", "RK23", "BDF"])
def test_a_passage_of_an_input_is_located_within_the_step(bare, solver):
    unit = opened(outputs=("passages",), fmu=exchange_fmu(bare), solver=solver)
    unit.drive([0.3], [1.0], None, H)
    unit.step(0.0, H)
    assert unit.get() == [1.0]
    assert unit.event == pytest.approx(0.2, abs=1e-13)
    unit.close()


def test_a_jump_of_an_input_over_a_threshold_between_two_steps_is_an_event():
    unit = opened(outputs=("passages",))
    for k, (value, passages) in enumerate([(0.2, 0), (0.9, 1), (0.8, 1), (0.1, 2)]):
        unit.drive([value], None, None, 0.1)
        unit.step(0.1 * k, 0.1)
        assert unit.get() == [passages]
        assert unit.event is None  # it has not happened inside the step
    unit.close()


def test_inputs_that_change_at_instants_only_are_handed_over_in_event_mode():
    unit = opened({"k": 0.0}, ("u", "reversed"), values=(1.0, 0.0))
    for k, (sign, x) in enumerate([(0.0, 0.1), (1.0, 0.0), (1.0, -0.1), (0.0, 0.0)]):
        unit.drive([1.0, sign], [0.0, 0.0], None, 0.1)
        unit.step(0.1 * k, 0.1)
        assert unit.get()[0] == pytest.approx(x, abs=1e-6)
    assert unit.work()["events"] == 0  # none of state or time
    unit.close()


def test_events_of_completed_steps_are_honoured():
    result = finished(read_scene({**scene({"k": 0.0, "saw": 0.35, "u": 1.0}), "record": {"signals": ["f.x", "f.resets"]}}))
    # x is put back at the end of the first step of the integrator behind 0.35, which is not longer than a macro step
    assert result["f.resets"][-1] in (2, 3)
    assert result["f.x"].max() <= 0.45


def test_an_fmu_that_ends_the_simulation():
    result = finished(read_scene(scene({"end": 0.42})))
    assert re.fullmatch(r"f ended the simulation at t = 0\.4[2-9]\d* s of 1 s", result.message)
    np.testing.assert_allclose(result.time[:-1], [0.0, 0.1, 0.2, 0.3, 0.4])
    assert 0.42 <= result.time[-1] <= 0.5
    assert result["f.h"][-1] == pytest.approx(height(result.time[-1])[0], abs=1e-6)


COUPLED = [
    ("jacobi", {}),
    ("gauss-seidel", {}),
    ("iterative", {"extrapolation": 1}),
    ("jacobi", {"every": 3}),
    ("jacobi", {"isolation": "process"}),
    ("iterative", {"extrapolation": 1, "isolation": "process"}),
    ("jacobi", {"control": {"method": "milne", "relative": 1e-3}}),
    ("gauss-seidel", {"events": ["f.h"]}),
]


@pytest.mark.parametrize("saves", [True, False])
@pytest.mark.parametrize(("algorithm", "more"), COUPLED)
def test_coupled_units_end_where_one_of_them_ends_inside_a_step(algorithm, more, saves):
    """Where states are saved the last step of all is shortened to that instant; else the last row is of the step before."""
    if not saves and (algorithm == "iterative" or "events" in more):
        return  # refused
    unit = {k: v for k, v in more.items() if k in ("every", "isolation")}
    result = finished(
        read_scene(
            {
                "stop_time": 1.0,
                "connections": ["p.time -> f.u", "f.y -> p.length"],
                "units": {
                    "p": {"component": "cosimo.tests.support:Probe"},
                    "f": {
                        "fmu": exchange_fmu(capabilities=CAPABILITIES if saves else ""),
                        **unit,
                        "parameters": {"period": 0.35, "end": 0.35},
                    },
                },
                "master": {"algorithm": algorithm, "step": 0.1, **{k: v for k, v in more.items() if k not in unit}},
                "record": {"signals": ["p.time", "f.h"]},
            }
        )
    )
    assert result.message.startswith("f ended the simulation at t = 0.35 s of 1 s")
    last = 0.35 if saves and "every" not in more else result.time[-1]
    assert (result.time[-1], result["p.time"][-1]) == (pytest.approx(last, abs=2e-7), pytest.approx(last, abs=2e-7))
    assert (f"that of t = {last:.9g} s" in result.message) == (last < 0.35 - 1e-4)
    if "every" in more:
        assert last == 0.5
        assert "the rows behind it hold extrapolated outputs" in result.message
        return
    assert result["f.h"][-1] == pytest.approx(height(last)[0], abs=1e-6)
    assert 0.25 < result.time[-1] <= 0.35 + 2e-7
    assert (np.diff(result.time) > 0.0).all()


@pytest.mark.parametrize("solver", ["CVode", "RK45"])
def test_equations_that_cannot_be_evaluated_fail_the_step(solver):
    """x = t, and no derivatives for x > 0.42."""
    result = run(read_scene(scene({"k": 0.0, "u": 1.0, "limit": 0.42}, solver=solver)))
    assert result.outcome == "failed"
    assert f"{solver} cannot go on" in result.message
    assert result.time[-1] == 0.4


def test_too_many_events_fail_the_step():
    result = run(read_scene(scene({"period": 5e-6}, exchange_fmu(bare=True))))
    assert "f failed at t = 0.05 s: more than 10000 events in one step" in result.message


def test_discrete_states_that_do_not_converge_fail_the_run():
    result = run(read_scene(scene({"k": -1.0})))
    assert result.message.startswith("f failed at t = 0 s: the discrete states do not converge in 100 iterations")


@pytest.mark.parametrize("solver", ["CVode", "BDF", "RK45", "Radau", "LSODA"])
def test_rollback_and_packed_states(solver):
    """Also across bounces and time events; a state that is only saved changes nothing. What follows a state that is taken back
    is the same to the last bit each time; where the integrator has forgotten its past by then, it is what it was within the
    tolerance."""

    def start():
        return opened({"period": 0.3}, ("u", "reversed"), ("x", "h", "v", "ticks", "passages"), (0.0, 0.0), solver=solver)

    def stepped(unit, k):
        unit.drive([0.1 * k, k % 2], [1.0, 0.0], None, 0.1)
        unit.step(0.1 * k, 0.1)
        return unit.get()

    multistep = solver in ("CVode", "BDF")
    plain, saving, other = start(), start(), start()
    expected = [stepped(plain, k) for k in range(12)]
    states = []
    for k in range(12):
        states.append(saving.save())
        assert stepped(saving, k) == expected[k]
    for k in (11, 4, 0):
        saving.restore(states[k])
        again = [stepped(saving, j) for j in range(k, 12)]
        np.testing.assert_allclose(again, expected[k:], atol=1e-6 if multistep else 0.0, rtol=0.0)
        saving.restore(states[k])
        assert [stepped(saving, j) for j in range(k, 12)] == again
    saving.restore(states[5])
    packed = saving.pack(saving.save())
    there = [stepped(saving, j) for j in range(5, 12)]
    other.restore(other.unpack(packed))
    assert [stepped(other, j) for j in range(5, 12)] == there
    for unit in (plain, saving, other):
        unit.close()


def test_a_run_goes_on_from_a_file_as_the_run_that_wrote_it():
    """Packing a state makes a multistep integrator begin anew, in the run that goes on without the file, too."""

    def stepped(unit, k):
        unit.step(0.1 * k, 0.1)
        return unit.get()

    here, there = opened({"mu": 1.0}, (), ("h", "v"), ()), opened({"mu": 1.0}, (), ("h", "v"), ())
    for k in range(6):
        stepped(here, k)
    there.restore(there.unpack(here.pack(here.save())))
    assert [stepped(there, k) for k in range(6, 12)] == [stepped(here, k) for k in range(6, 12)]
    here.close()
    there.close()


# Accuracy by default, against solutions of other methods


@pytest.mark.parametrize("step", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("capabilities", ["", CAPABILITIES])
def test_van_der_pol_is_within_1e_5_by_default(step, capabilities):
    """Of a solution of order 8 with a tolerance of 1e-12; restarts of CVode at every macro step cost 5e-3 at 0.01 s."""
    result = run(read_scene(scene({"mu": 1.0}, exchange_fmu(capabilities=capabilities), step=step, stop=20.0)))
    exact = solve_ivp(
        lambda _, x: [x[1], (1.0 - x[0] ** 2) * x[1] - x[0]],
        (0.0, 20.0),
        [2.0, 0.0],
        "DOP853",
        t_eval=result.time,
        rtol=1e-12,
        atol=1e-12,
    )
    assert result.outcome == "done", result.message
    assert np.abs([result["f.h"], result["f.v"]] - exact.y).max() < 1e-5


@pytest.mark.parametrize("step", [0.01, 0.1])
@pytest.mark.parametrize("capabilities", ["", CAPABILITIES])
def test_a_bouncing_ball_is_within_1e_5_by_default_to_its_rest(step, capabilities):
    result = finished(read_scene(scene({"rest": 0.1}, exchange_fmu(capabilities=capabilities), step=step, stop=3.0)))
    exact = [height(t, rest=0.1)[0] for t in result.time]
    assert np.abs(result["f.h"] - exact).max() < 1e-5
    grid = np.arange(round(3.0 / step) + 1) * step
    assert np.abs(result.time[:, None] - grid).min(axis=0).max() < 1e-15  # events add rows and take none away


@pytest.mark.parametrize("solver", ["CVode", "BDF", "LSODA"])
def test_an_integrator_goes_on_where_inputs_go_on_and_begins_anew_where_they_jump(solver):
    """Evaluations of the equations: a restart of a multistep method costs several steps of low order."""
    calls = []
    for slope in (1.0, 0.0):  # the polynomial meets the next value, or leaves a jump of 0.1
        unit = opened({"rest": 10.0}, tolerance=1e-8, solver=solver)  # the ball lies from its first bounce on
        for k in range(50):
            unit.drive([0.1 * k], [slope], None, 0.1)
            unit.step(0.1 * k, 0.1)
            unit.get()
        calls.append(unit.work()["derivative_calls"])
        unit.close()
    assert 2 * calls[0] < calls[1], calls


def test_without_saved_states_the_fmu_is_told_to_forget_and_with_them_not():
    """The FMU refuses a state older than what it was told to forget; the first step here has forgotten nothing yet."""
    unit = opened()
    unit.step(0.0, 0.1)
    state = unit.save()
    unit.step(0.1, 0.1)
    unit.restore(state)
    unit.release(state)
    unit.close()


def test_derivatives_of_the_outputs():
    unit = opened(outputs=("x", "y"))
    assert unit.jacobian().tolist() == [[0.0], [1.0]]
    unit.close()


def test_capabilities_come_from_the_interface_that_is_used():
    found = describe("f", read_scene(scene()).units["f"])
    assert (found.saves_state, found.packs_state, found.gives_jacobian, found.may_return_early) == (True,) * 4
    assert (found.input_degree, found.variable_step, found.fixed_step) == (2, True, 0.0)
    assert found.outputs["y"].feedthrough == ("u",)
    poor = describe("f", read_scene(scene(fmu=exchange_fmu(capabilities=""))).units["f"])
    assert (poor.saves_state, poor.packs_state, poor.gives_jacobian) == (False,) * 3


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ({"solver": "RK54"}, r"units\.f\.solver: got 'RK54', expected a method of integration. Did you mean 'RK45'"),
        ({"interface": "co-simulation"}, r"units\.f\.interface: got 'co-simulation'.*It is for model exchange only"),
        ({"tolerance": -1.0}, r"units\.f\.tolerance"),
    ],
)
def test_options_that_do_not_fit_are_refused(unit, said):
    with pytest.raises(BadInput, match=said):
        read_scene(scene(**unit))


def test_a_coupled_run_and_its_isolated_twin():
    """u = t, interpolated: x = t - 1 + exp(-t) within the tolerance; in a worker process the same to the last bit."""
    data = scene(tolerance=1e-8)
    data["units"] = {"p": {"component": "cosimo.tests.support:Probe"}, **data["units"]}
    data["connections"] = ["p.time -> f.u"]
    here = run(read_scene(data))
    data["units"]["f"]["isolation"] = "process"
    there = run(read_scene(data))
    assert (here.outcome, there.outcome) == ("done", "done"), there.message
    bound = here.info.counters.units["f"]["solver_steps"] * SPREAD * 1e-8
    assert np.abs(here["f.x"] - (here.time - 1.0 + np.exp(-here.time))).max() < bound
    assert here["f.x"].tobytes() == there["f.x"].tobytes()
    assert here.info.units["f"].kind == "FMU for model exchange with CVode"


def test_a_step_after_a_failure_is_not_possible_but_the_unit_can_be_closed():
    unit = opened({"end": 0.05})
    with pytest.raises(SimulationEnded, match="ended the simulation"):
        unit.step(0.0, 0.1)
    unit.close()
