"""FMUs written in C do what the Reference FMUs do: events, early return, rollback, strict communication points, failures."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe, open_unit
from cosimo.tests.scene_runs import finished
from cosimo.tests.units.native import EVENTS, STATE, native_fmu, started
from scipy.integrate import solve_ivp

ONE_LENGTH = 'canHandleVariableCommunicationStepSize="false"'
VERSIONS = [(2, ""), (3, ""), (3, EVENTS)]
G, E, H0, LIES = 9.81, 0.7, 1.0, 0.1  # m/s², restitution, m, m/s: the ball lies when it leaves slower


def scene(model: str, fmi: int = 3, flags: str = "", step: float = 0.1, stop: float = 1.0, **parameters) -> dict:
    return {
        "stop_time": stop,
        "units": {"f": {"fmu": native_fmu(model, fmi, flags), "parameters": parameters}},
        "master": {"step": step},
    }


def bounces() -> list[tuple[float, float]]:
    """(time, speed upwards behind it) of every bounce of the ball."""
    t, v = math.sqrt(2.0 * H0 / G), E * math.sqrt(2.0 * G * H0)
    found = [(t, v)]
    while v >= LIES:
        t, v = t + 2.0 * v / G, E * v
        found.append((t, v))
    return found


def ball(t: float) -> tuple[float, float]:
    """Height and speed at t."""
    behind = [b for b in bounces() if b[0] <= t]
    if not behind:
        return H0 - 0.5 * G * t * t, -G * t
    at, v = behind[-1]
    return (0.0, 0.0) if v < LIES else (v * (t - at) - 0.5 * G * (t - at) ** 2, v - G * (t - at))


@pytest.mark.parametrize(("fmi", "flags"), VERSIONS)
def test_a_bouncing_ball_bounces_whoever_handles_its_events(fmi, flags):
    result = finished(read_scene(scene("bouncing_ball", fmi, flags, step=0.05, stop=3.0)))
    exact = np.array([ball(t) for t in result.time])
    np.testing.assert_allclose(result["f.h"], exact[:, 0], atol=1e-13)
    np.testing.assert_allclose(result["f.v"], exact[:, 1], atol=1e-12)


def test_the_first_event_inside_a_step_is_told():
    unit, step, told = started("bouncing_ball", 3, EVENTS), 0.05, {}
    for k in range(60):
        unit.step(step * k, step)
        told[k] = unit.event
    unit.close()
    for k, event in told.items():
        inside = [t for t, _ in bounces() if step * k < t <= step * (k + 1)]
        assert event == (pytest.approx(inside[0], abs=1e-13) if inside else None)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_with_rollback_all_units_meet_at_the_events_of_one(algorithm):
    flags = f"{EVENTS} {STATE[3]}"
    result = run(
        read_scene(
            {
                "stop_time": 3.0,
                "connections": ["ball.h -> other.Float64_continuous_input"],
                "units": {
                    "ball": {"fmu": native_fmu("bouncing_ball", 3, flags)},
                    "other": {"fmu": native_fmu("feedthrough", 3, flags)},
                },
                "master": {"algorithm": algorithm, "step": 0.05},
            }
        )
    )
    grid = np.arange(61) * 0.05
    assert np.abs(result.time[:, None] - grid).min(axis=0).max() < 1e-15  # every time of the grid has its row
    late = [min(t for t in result.time if t >= at) - at for at, _ in bounces()]
    assert max(late) < 1e-6 * 0.05  # a tick of the clock
    np.testing.assert_allclose(result["ball.h"], [ball(t)[0] for t in result.time], atol=1e-13)
    np.testing.assert_array_equal(result["other.Float64_continuous_output"], result["ball.h"])


def test_without_event_mode_an_early_return_is_told_and_the_step_goes_on():
    unit = started("moody", 3, 'mightReturnEarlyFromDoStep="true"', (), ("now",), early_at=0.25)
    seen = []
    for k in range(4):
        unit.step(0.1 * k, 0.1)
        seen.append((unit.event, unit.get()))
    unit.close()
    assert [event for event, _ in seen] == [None, None, 0.25, None]
    assert [now for _, (now,) in seen] == [0.1 * k + 0.1 for k in range(4)]


@pytest.mark.parametrize(("fmi", "flags"), VERSIONS)
def test_a_stair_is_climbed_where_it_announces_its_steps(fmi, flags):
    """Steps of 0.4 s meet every other stair only inside of a step: the FMU is stepped to it where it announces it."""
    result = run(read_scene(scene("stair", fmi, flags, step=0.4, stop=8.0)))
    np.testing.assert_array_equal(result["f.counter"], [1 + math.floor(t + 1e-9) for t in result.time])


@pytest.mark.parametrize("isolation", ["none", "process"])
def test_an_fmu_that_ends_the_simulation_is_no_failure(isolation):
    """The stair ends at the end of a step, 10 s, the other one inside a step; either leaves a row at its end."""
    stair = scene("stair", 3, EVENTS, step=0.5, stop=20.0)
    stair["units"]["f"]["isolation"] = isolation
    result = run(read_scene(stair))
    assert (result.outcome, result.message) == ("done", "f ended the simulation at t = 10 s of 20 s")
    assert (result.time[-1], result["f.counter"][-1]) == (10.0, 11.0)
    np.testing.assert_array_equal(result.time, np.arange(21) * 0.5)
    for fmi, end in ((2, 0.35), (3, 0.4)):  # the one of FMI 3 completes its step
        inside = scene("moody", fmi, end_at=0.35)
        inside["units"]["f"]["isolation"] = isolation
        result = run(read_scene(inside))
        assert (result.outcome, result.message) == ("done", f"f ended the simulation at t = {end} s of 1 s")
        np.testing.assert_allclose(result.time, [0.0, 0.1, 0.2, 0.3, end])
        assert result["f.now"][-1] == end


@pytest.mark.parametrize("flags", [EVENTS, f"{EVENTS} {STATE[3]}"])
def test_units_that_are_coupled_end_with_the_one_that_ends(flags):
    result = run(
        read_scene(
            {
                "stop_time": 20.0,
                "connections": ["stair.counter -> other.Int32_in"],
                "master": {"algorithm": "jacobi", "step": 0.5},
                "units": {"stair": {"fmu": native_fmu("stair", 3, flags)}, "other": {"fmu": native_fmu("feedthrough", 3, flags)}},
            }
        )
    )
    assert (result.outcome, result.message) == ("done", "stair ended the simulation at t = 10 s of 20 s")
    assert (result.time[-1], result["other.Int32_out"][-1]) == (10.0, 11.0)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("fmi", "flags"), [(2, ""), (3, ""), (3, EVENTS), (3, f"{EVENTS} {STATE[3]}")])
@pytest.mark.parametrize("end", [0.35, 0.4])
def test_all_units_have_a_row_where_one_ends_inside_or_at_the_end_of_a_step(algorithm, fmi, flags, end):
    """Compiled steps of FMI 2 as well. Without states to go back to, units may already have passed an end inside of a step."""
    record = {"signals": ["f.now", "first.Float64_continuous_output", "last.Float64_continuous_output"]}
    other = {"fmu": native_fmu("feedthrough", fmi, flags)}
    result = run(
        read_scene(
            {
                "stop_time": 1.0,
                "master": {"algorithm": algorithm, "step": 0.1},
                "record": record,
                "connections": ["f.now -> first.Float64_continuous_input", "f.now -> last.Float64_continuous_input"],
                "units": {
                    "first": other,
                    "f": {"fmu": native_fmu("moody", fmi, flags), "parameters": {"end_at": end}},
                    "last": other,
                },
            }
        )
    )
    stays = (fmi, flags) == (3, "")  # it completes the step
    ended, last = (0.4, 0.4) if stays else (end, 0.3 if end == 0.35 and STATE[3] not in flags else end)
    assert (result.outcome, result.time[-1]) == ("done", last)
    more = f"; the last row, of all units at the same time, is that of t = {last} s" if last < ended else ""
    assert result.message == f"f ended the simulation at t = {ended} s of 1 s{more}"
    assert [result[name][-1] for name in record["signals"]] == pytest.approx([last] * 3, abs=1e-15)


def test_discrete_states_that_never_converge_fail():
    with pytest.raises(StepFailed, match="the discrete states do not converge in 100 iterations"):
        started("moody", 3, EVENTS, restless=True)


def test_a_step_that_is_completed_in_part_tells_how_far():
    result = run(read_scene(scene("moody", 2, ONE_LENGTH, discard_at=0.35)))
    assert result.outcome == "failed"
    assert "f failed at t = 0.3 s: the FMU discarded the call and got to 0.35 s; no shorter step was tried" in result.message
    assert "A macro step of at most 0.05 s may help" in result.message
    assert result.time[-1] == pytest.approx(0.3)


@pytest.mark.parametrize("fmi", [2, 3])
def test_after_a_failed_step_an_earlier_state_goes_on(fmi):
    unit = started("moody", fmi, f"{STATE[fmi]} {ONE_LENGTH}", (), ("now",), discard_at=0.35)
    unit.step(0.0, 0.3)
    state = unit.save()
    for _ in range(2):
        with pytest.raises(StepFailed, match="got to"):
            unit.step(0.3, 0.1)
        unit.restore(state)
    unit.step(0.3, 0.04)
    assert unit.get() == [0.3 + 0.04]
    unit.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_tolerance_of_a_scene_is_handed_over(fmi):
    for given, told in ((None, -1.0), (1e-5, 1e-5)):  # the FMU's sign for none
        result = run(
            read_scene(
                {
                    "stop_time": 0.1,
                    "master": {"step": 0.1},
                    "units": {"f": {"fmu": native_fmu("moody", fmi), **({} if given is None else {"tolerance": given})}},
                }
            )
        )
        assert result["f.tolerance"][-1] == told


def test_a_step_that_goes_on_in_the_background_is_waited_for():
    result = finished(read_scene(scene("moody", 2, 'canRunAsynchronuously="true"', pause=1.0)))
    np.testing.assert_allclose(result["f.now"], result.time, rtol=1e-15)


@pytest.mark.parametrize("fmi", [2, 3])
def test_communication_points_are_those_of_the_clock(fmi):
    """The FMU refuses a point that is off by 1e-15 of itself, a few roundings; a sum of 1e4 steps of 0.1 s is off by 1.6e-13."""
    result = finished(read_scene(scene("dahlquist", fmi, step=0.1, stop=1000.0)))
    np.testing.assert_allclose(result["f.x"][:50], 0.9 ** np.arange(50), rtol=1e-14)  # Euler's method with its 0.1 s
    unit = started("dahlquist", fmi)
    with pytest.raises(StepFailed, match="log: not the present communication point"):
        unit.step(0.1, 0.1)
    unit.close()


def test_steps_are_multiples_of_a_fixed_internal_step():
    flags = 'fixedInternalStepSize="0.1"'
    assert describe("f", UnitSettings(fmu=native_fmu("dahlquist", 3, flags))).fixed_step == 0.1
    assert run(read_scene(scene("dahlquist", 3, flags, step=0.3, stop=1.0))).outcome == "done"
    with pytest.raises(BadInput, match=r"master\.step: got 0\.25 s, expected a multiple of 0\.1 s, .* of f"):
        read_scene(scene("dahlquist", 3, flags, step=0.25))
    with pytest.raises(BadInput, match=r"stop_time: got 1\.05 s, expected a multiple of 0\.1 s"):
        read_scene(scene("dahlquist", 3, flags, step=0.1, stop=1.05))


@pytest.mark.parametrize("fmi", [2, 3])
def test_van_der_pol_follows_the_equation(fmi):
    result = run(read_scene(scene("van_der_pol", fmi, step=0.01, stop=10.0, mu=2.0)))
    exact = solve_ivp(
        lambda _, x: [x[1], 2.0 * (1.0 - x[0] ** 2) * x[1] - x[0]],
        (0.0, 10.0),
        [2.0, 0.0],
        "DOP853",
        t_eval=result.time,
        rtol=1e-12,
        atol=1e-12,
    )
    np.testing.assert_allclose([result["f.x0"], result["f.x1"]], exact.y, atol=1e-9)


@pytest.mark.parametrize("fmi", [2, 3])
def test_resources_are_found(fmi):
    unit = started("resource", fmi)
    assert unit.get() == [ord("a")]
    unit.close()


# Inputs inside a step

ASKED = 'providesIntermediateUpdate="true"'
INPUT = ('name="u" valueReference="1"', 'name="u" valueReference="1" intermediateUpdate="true"')


@pytest.mark.parametrize("asked", [True, False])
def test_inputs_follow_their_polynomials_where_the_fmu_asks_for_them(asked):
    """u = a + b s + c s² in steps of h: the integral is exact either way, the second one only if u is given inside."""
    settings = UnitSettings(fmu=native_fmu("integrator", 3, ASKED, *[INPUT] * asked))
    assert describe("f", settings).input_degree == (2 if asked else 0)
    unit, h, (a, b, c) = open_unit("f", settings, in_process=False), 0.5, (1.0, 2.0, 3.0)
    unit.wire(["u"], ["x", "z"])
    unit.initialize(0.0, [a])
    unit.start()
    x = z = 0.0
    for k in range(3):
        unit.drive([a], [b], [c], h)
        unit.step(k * h, h)
        z += h * x + (a / 2.0 + b * h / 6.0 + c * h**2 / 12.0 if asked else a / 2.0 + b * h / 4.0 + c * h**2 / 6.0) * h**2
        x += (a + b * h / 2.0 + c * h**2 / 3.0) * h
        np.testing.assert_allclose(unit.get(), [x, z], rtol=1e-14)
    unit.drive([7.0], None, None, h)  # held: what was given for the last step is over
    unit.step(3 * h, h)
    assert unit.get()[0] == pytest.approx(x + 7.0 * h, rel=1e-14)
    unit.close()


# States

MODELS = [
    ("bouncing_ball", 2, ""),
    ("bouncing_ball", 3, ""),
    ("bouncing_ball", 3, EVENTS),
    ("dahlquist", 2, ""),
    ("stair", 3, EVENTS),
    ("van_der_pol", 2, ""),
    ("van_der_pol", 3, ""),
    ("state_space", 3, ""),
]


def walk(unit, first: int, steps: int) -> list:
    seen = []
    for k in range(first, first + steps):
        unit.drive([0.5 * k] * len(unit._input_names), [1.0] * len(unit._input_names), None, 0.3)
        unit.step(0.3 * k, 0.3)
        seen.append((unit.event, *unit.get()))
    return seen


@pytest.mark.parametrize(("model", "fmi", "flags"), MODELS)
def test_a_restored_fmu_repeats_its_steps_to_the_last_bit(model, fmi, flags):
    unit = started(model, fmi, f"{flags} {STATE[fmi]}", ("u[1]", "u[3]") if model == "state_space" else ())
    walk(unit, 0, 3)
    state = unit.save()
    once = walk(unit, 3, 5)
    unit.restore(state)
    assert walk(unit, 3, 5) == once
    assert len(set(once)) > 1
    unit.restore(state)
    again = unit.save(state)  # its memory may be used again
    assert walk(unit, 3, 5) == once
    unit.restore(again)
    assert walk(unit, 3, 5) == once
    unit.release(again)
    unit.close()


@pytest.mark.parametrize(("model", "fmi", "flags"), MODELS)
def test_a_packed_state_goes_on_in_another_instance_to_the_last_bit(model, fmi, flags):
    inputs = ("u[1]", "u[3]") if model == "state_space" else ()
    unit = started(model, fmi, f"{flags} {STATE[fmi]}", inputs)
    walk(unit, 0, 3)
    packed = unit.pack(unit.save())
    once = walk(unit, 3, 5)
    unit.close()
    other = started(model, fmi, f"{flags} {STATE[fmi]}", inputs)
    other.restore(other.unpack(packed))
    assert walk(other, 3, 5) == once
    other.close()


def test_held_inputs_belong_to_a_state():
    unit = started("feedthrough", 3, f"{EVENTS} {STATE[3]}", ("Int32_in",), ("Int32_out",))
    unit.wire_texts(["String_in"])
    texts = unit.text_reader(["String_out"])
    unit.update([1.0])
    unit.set_texts(["one"])
    state = unit.save()
    unit.update([2.0])
    unit.set_texts(["two"])
    unit.restore(state)
    assert (unit.get(), texts()) == ([1.0], ["one"])
    unit.update([2.0])  # as before: it must reach the FMU again
    unit.set_texts(["two"])
    assert (unit.get(), texts()) == ([2.0], ["two"])
    unit.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_is_told_whether_its_past_may_come_back(fmi):
    """It refuses a state from before a step whose call said that no such state would come; that of FMI 2 may go back by itself."""
    unit = started("dahlquist", fmi, f"{STATE[fmi]} {ONE_LENGTH}")
    state = unit.save()
    packed = unit.pack(state)
    for _ in range(2):
        unit.step(0.0, 0.1)
        unit.step(0.1, 0.1)
        unit.restore(state)
    unit.release(state)
    unit.step(0.0, 0.1)  # nothing is kept
    unit.step(0.1, 0.1)
    with pytest.raises(StepFailed, match="log: a state that was given up"):
        unit.restore(unit.unpack(packed))
    unit.close()


def test_what_an_fmu_cannot_is_known_before_the_run():
    plain, able = (describe("f", UnitSettings(fmu=native_fmu("dahlquist", 3, flags))) for flags in ("", STATE[3]))
    assert (plain.saves_state, plain.packs_state) == (False, False)
    assert (able.saves_state, able.packs_state) == (True, True)
    with pytest.raises(BadInput, match=r"master\.control\.method: got 'doubling'.*save their state; .*f"):
        read_scene(
            {
                **scene("feedthrough"),
                "connections": ["f.Float64_continuous_output -> g.Float64_continuous_input"],
                "units": {n: {"fmu": native_fmu("feedthrough", 3)} for n in "fg"},
                "master": {"step": 0.1, "control": {"method": "doubling"}},
            }
        )


@pytest.mark.parametrize("fmi", [2, 3])
def test_directional_derivatives_make_the_jacobian(fmi):
    flag = 'providesDirectionalDerivative="true"' if fmi == 2 else 'providesDirectionalDerivatives="true"'
    inputs = ("Int32_in", "Float64_continuous_input", *(("Float32_continuous_input",) if fmi == 3 else ()))
    outputs = ("Float64_continuous_output", "Int32_out", *(("Float32_continuous_output",) if fmi == 3 else ()))
    assert describe("f", UnitSettings(fmu=native_fmu("feedthrough", fmi, flag))).gives_jacobian
    unit = started("feedthrough", fmi, flag, inputs, outputs)
    np.testing.assert_array_equal(unit.jacobian(), np.array([[0, 1, 0], [0, 0, 0], [0, 0, 1]])[: len(outputs), : len(inputs)])
    unit.close()


def test_derivatives_of_arrays():
    unit = started("state_space", 3, "", ("u[3]", "u[1]"), ("y[2]", "y[1]", "y[3]"), **{"D[2,3]": 5.0, "D[1,3]": -2.0})
    np.testing.assert_array_equal(unit.jacobian(), [[5.0, 0.0], [-2.0, 1.0], [1.0, 0.0]])
    unit.close()


# What cannot start
