"""A scene in the hand: its steps are those of a run, whatever its units are; values, states and refusals."""

import gc
import itertools
import math
import subprocess
import sys

import cosimo
import numpy as np
import pytest
from cosimo import BadInput, StepFailed, load_scene, read_scene
from cosimo.orchestrator.run.run import run
from cosimo.tests.rest import at_rest
from cosimo.tests.support import two_masses
from cosimo.tests.units.exchange_fmu import exchange_fmu
from cosimo.tests.units.foreign_fmu import foreign as foreign_fixture
from cosimo.tests.units.native import STATE, native_fmu
from cosimo.tests.units.test_many_runs import counted_here as counted_here_fixture
from cosimo.tests.units.test_many_runs import held, memory

foreign, counted_here = foreign_fixture, counted_here_fixture
MASS = "cosimo.tests.support:Mass"


def one_mass(**more):
    return read_scene({"stop_time": 1.0, "units": {"mass": {"component": MASS, **more}}, "master": {"step": 0.01}})


def whole(scene, how, chunks):
    """Columns of a session that takes its steps in pieces."""
    with cosimo.open(scene, **how) as sim:
        sim.initialize()
        sim.record()
        for steps in chunks:
            if not sim.done:
                sim.step(steps)
        while not sim.done:
            sim.step()
        return sim.result()


SCENES = {"mass-on-spring": 1.0, "two-link-manipulator": 0.2, "rov-thruster-failed": 31.0, "jaw-crusher": 0.05, "wrist-tool": 0.5}


@pytest.mark.first(2)
@pytest.mark.parametrize("name", SCENES)
def test_steps_in_any_pieces_are_those_of_a_run(name):
    """Batches, a fault, sampled controllers, iterations, loops."""
    scene = load_scene(name).with_changes({"stop_time": SCENES[name], "record.interval": None})
    result = run(scene, in_process=True)
    held_one = whole(scene, {}, (1, 1, 7, 1, 50, 3, 1))
    assert held_one.time.tobytes() == result.time.tobytes()
    assert held_one.columns.keys() == result.columns.keys()
    for signal in result.columns:
        assert held_one[signal].tobytes() == result[signal].tobytes(), signal


def test_step_control_and_events_go_on_where_they_were():
    control = {"master.control": {"method": "doubling", "relative": 1e-4, "absolute": 1e-6}, "stop_time": 0.5}
    scene = read_scene(two_masses("jacobi", 0.01, 1)).with_changes(control)
    result, held_one = run(scene, in_process=True), whole(scene, {}, (1, 3, 1, 10))
    assert result.rows > 20
    assert all(held_one[n].tobytes() == result[n].tobytes() for n in result.columns)


@pytest.mark.full
@pytest.mark.parametrize("how", [{"in_process": False}, {"native": True}], ids=["pythonfmu", "native"])
def test_packagings_have_the_same_bits(how):
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.2})
    here, there = (whole(scene, h, (1, 5)) for h in ({}, how))
    assert all(here[n].tobytes() == there[n].tobytes() for n in here.columns)


def units(kind, foreign):
    """(table of a unit whose output x is the integral of its input u, its names of u and x)."""
    if kind == "FMI 2":
        return {"fmu": native_fmu("integrator", 2, STATE[2])}, "u", "x"
    if kind == "FMI 3":
        return {"fmu": native_fmu("integrator", 3, STATE[3])}, "u", "x"
    if kind == "model exchange":
        return {"fmu": exchange_fmu(), "interface": "model-exchange", "parameters": {"k": 0.0}}, "u", "x"
    if kind == "worker":
        return {"fmu": foreign(), "isolation": "process"}, "u", "x"
    return {"component": MASS, "parameters": {"v0": 0.0}}, "force", "v_out"


@pytest.mark.parametrize("kind", ["plain Python", "FMI 2", "FMI 3", "model exchange", "worker"])
def test_an_input_set_between_steps_acts_from_there_on(kind, foreign):
    table, u, x = units(kind, foreign)
    scene = read_scene({"stop_time": 2.0, "units": {"a": table}, "master": {"step": 0.125}})
    with cosimo.open(scene) as sim:
        sim[f"a.{u}"] = 2.0
        sim.initialize()
        begin = sim[f"a.{x}"]
        sim.until(0.5)
        assert sim[f"a.{u}"] == 2.0
        assert sim[f"a.{x}"] == pytest.approx(begin + 1.0, abs=1e-9)
        sim[f"a.{u}"] = -8.0
        sim.until(0.75)
        assert sim[f"a.{x}"] == pytest.approx(begin - 1.0, abs=1e-9)


def test_what_depends_on_an_input_at_once_follows_at_once():
    """Also the units behind it, and what they extrapolate from begins anew."""
    table = {
        "stop_time": 1.0,
        "units": {"spring": {"component": "cosimo.tests.support:SpringDamper"}, "mass": {"component": MASS}},
        "connections": ["spring.force -> mass.force"],
        "master": {"algorithm": "jacobi", "step": 0.01, "extrapolation": 1},
    }
    with cosimo.open(read_scene(table)) as sim:
        sim.initialize()
        sim.step(3)
        sim["spring.position"] = 0.5
        assert sim["spring.force"] == -50.0
        assert sim["mass.force"] == -50.0
        before = sim["mass.v_out"]
        sim.step(2)
        assert sim["mass.v_out"] == pytest.approx(before - 50.0 * 0.02, rel=1e-12)


@pytest.mark.parametrize("kind", ["plain Python", "FMI 2", "FMI 3", "model exchange", "kernels"])
def test_a_state_is_taken_back_and_goes_to_another_session(kind, foreign):
    if kind == "kernels":
        scene, name = load_scene("double-pendulum"), "chain.tip_x"
    else:
        table, _, x = units(kind, foreign)
        scene, name = read_scene({"stop_time": 2.0, "units": {"a": table}, "master": {"step": 0.125}}), f"a.{x}"
    with cosimo.open(scene) as sim, cosimo.open(scene) as other:
        sim.initialize()
        sim.record()
        sim.step(2)
        state = sim.save()
        times = []
        for _ in range(3):  # as often as wanted
            sim.restore(state)
            assert sim.time == 2 * scene.master.step
            sim.step(3)
            reached = sim[name]
            times.append(sim.result().time.tolist())
        assert times[0] == times[1] == times[2]
        assert len(times[0]) == 6
        content = bytes(state)
        assert sim[name] == reached  # asking for bytes moves nothing
        other.restore(content)
        other.step(3)
        assert other[name] == reached


def test_damaged_and_foreign_states_are_refused():
    scene = one_mass()
    with cosimo.open(scene) as sim, cosimo.open(one_mass(parameters={"m": 2.0})) as other:
        sim.initialize()
        content = bytes(state := sim.save())
        for bad in (b"", b"nothing", content[:-30], content.replace(b"master", b"mastre")):
            with pytest.raises(BadInput, match="undamaged"):
                sim.restore(bad)
        with pytest.raises(BadInput, match="of another scene"):
            other.restore(content)
        with pytest.raises(BadInput, match="that this session has saved"):
            other.restore(state)
        sim.close()
    with pytest.raises(BadInput, match="session that is closed"):
        sim.restore(state)


def test_values_by_name():
    with cosimo.open("rov-station-keeping") as sim:
        sim["controller.position_gain"] = gain = 2.0 * sim["controller.position_gain"]
        assert np.array_equal(sim["controller.position_gain"], gain)
        sim.initialize()
        sim.step(10)
        assert isinstance(sim["hull.depth"], float)
        assert isinstance(sim["hull.attitude_valid"], bool)
        assert sim["controller.command"].shape == sim.values(["controller.command"]).shape
        assert sim["controller.command"][0] == sim["controller.command[1]"]
        assert sim.values(["hull.depth", "hull.yaw"]).tolist() == [sim["hull.depth"], sim["hull.yaw"]]
        assert "hull.depth" in sim._repr_html_()
        assert repr(sim) == f"<Session of rov-station-keeping: {', '.join(sim.scene.units)}; at t = {sim.time:.9g} s>"


def test_quantities_are_converted():
    with cosimo.open("en50318-2002") as sim:
        sim["pantograph.speed"] = "180 km/h"
        sim["pantograph.static_force"] = "0.13 kN"
        assert sim["pantograph.speed"] == pytest.approx(50.0, rel=1e-15)
        sim.initialize()
        assert sim["pantograph.static_force"] == 130.0
    with cosimo.open(one_mass()) as sim:
        sim.initialize()
        sim["mass.force"] = "2 kN"
        assert sim["mass.force"] == 2000.0
        with pytest.raises(BadInput, match="'2 kg'"):
            sim["mass.force"] = "2 kg"


def test_reset_begins_anew_with_what_was_set():
    with cosimo.open("double-pendulum") as sim:
        sim["chain.start_first_angle"] = 0.3
        ways = []
        for start in (0.3, 0.3, 0.4):
            sim["chain.start_first_angle"] = start
            sim.initialize()
            sim["chain.first_torque"] = 1.0
            sim.step(20)
            ways.append(sim["chain.tip_x"])
            sim.reset()
        assert ways[0] == ways[1] != ways[2]
        sim.initialize()
        assert sim["chain.first_torque"] == 0.0
    scene = load_scene("double-pendulum").with_changes({"chain.start_first_angle": 0.4})
    with cosimo.open(scene) as sim:
        sim.initialize()
        sim["chain.first_torque"] = 1.0
        sim.step(20)
        assert sim["chain.tip_x"] == ways[2]


def test_a_seed_gives_another_sea():
    with cosimo.open("rov-waves") as sim:
        seen = []
        for seed in (1, 2, 1):
            sim.reset(seed=seed)
            sim.initialize()
            sim.step(50)
            seen.append(sim["hull.depth"])
        assert seen[0] == seen[2] != seen[1]


def test_a_step_that_fails_leaves_what_was_there():
    scene = one_mass()
    table = scene.settings() | {"units": {"probe": {"component": "cosimo.tests.support:Probe", "parameters": {"fail_at": 0.055}}}}
    with cosimo.open(read_scene(table)) as sim:
        sim.initialize()
        sim.record()
        sim.step(3)
        state = sim.save()
        with pytest.raises(StepFailed):
            sim.step(10)
        with pytest.raises(BadInput, match="after a step that failed"):
            sim.step()
        failed = sim.result()
        assert (failed.outcome, failed.end) == ("failed", pytest.approx(0.05))
        assert "failed" in repr(sim)
        sim.restore(state)
        sim.step()
        assert sim.time == pytest.approx(0.04)


SETTING = "session of scene: mass"
REFUSED = [  # (what is done before and after the start, words of the message)
    (lambda sim: sim["moss.m"], "'moss', expected a unit of the scene. Did you mean 'mass'?"),
    (lambda sim: sim["mass.forse"], "'mass.forse', expected a parameter, an input or an output of mass. Did you mean 'force'?"),
    (lambda sim: sim.__setitem__("mass.x_out", 1.0), "It is an output"),
    (lambda sim: sim.__setitem__("mass.force", math.nan), "nan, expected a finite number in N"),
    (lambda sim: sim.__setitem__("mass.force", "much"), "'much', expected a finite number in N"),
    (lambda sim: sim.until(5.0), ""),
    (lambda sim: sim.step(0), ""),
    (lambda sim: sim.result(), "records nothing"),
]
ONLY_BEFORE = [
    (lambda sim: sim.step(), "step() before the start, expected a call of initialize()"),
    (lambda sim: sim["mass.x_out"], "before the start"),
    (lambda sim: sim.values(["mass.x_out"]), "before the start"),
    (lambda sim: sim.save(), "before the start"),
    (lambda sim: sim.record(), "before the start"),
    (lambda sim: sim.__setitem__("mass.m", -1.0), "m = -1.0"),
]
ONLY_BEHIND = [
    (lambda sim: sim.__setitem__("mass.m", 2.0), "expected a parameter that is set before initialize(). reset() goes back"),
    (lambda sim: sim.initialize(), "initialize() of a scene that runs"),
    (lambda sim: sim.step(0), "0, expected a whole number of macro steps, 1 at least"),
    (lambda sim: sim.step(True), "True, expected a whole number"),
    (lambda sim: sim.until(5.0), "5 s, expected a time from 0 s, which is reached, to stop_time = 1 s"),
    (lambda sim: sim.values(["mass.m"]), "'mass.m', expected an output that is a number"),
]


@pytest.mark.parametrize("started", [False, True])
def test_refusals_are_one_message_and_lose_nothing(started):
    with cosimo.open(one_mass()) as sim:
        if started:
            sim.initialize()
        for act, words in [*REFUSED, *(ONLY_BEHIND if started else ONLY_BEFORE)]:
            with pytest.raises(BadInput) as caught:
                act(sim)
            assert words in str(caught.value)
        if not started:
            sim.initialize()
        sim.until(1.0)
        assert sim["mass.x_out"] == pytest.approx(1.0)
        with pytest.raises(BadInput, match="a step behind stop_time = 1 s"):
            sim.step()
    with pytest.raises(BadInput, match="closed"):
        sim.step()


def test_an_input_that_something_drives_is_refused():
    with cosimo.open("mass-on-spring") as sim, pytest.raises(BadInput, match="It is connected to spring"):
        sim["mass.base_force_x"] = 1.0


@pytest.mark.parametrize("kind", ["kernels", "FMI 2"])
def test_a_thousand_sessions_leave_nothing(kind, foreign):
    scene = load_scene("mass-on-spring")
    if kind == "FMI 2":
        table, _, _ = units(kind, foreign)
        scene = read_scene({"stop_time": 2.0, "units": {"a": table}, "master": {"step": 0.125}})
    scene.coupling  # noqa: B018 - resolved once

    def some(n):
        for _ in range(n):
            with cosimo.open(scene) as sim:
                sim.initialize()
                sim.step(3)
                sim.restore(sim.save())

    some(100)
    before, resident = at_rest(held), [memory()]
    for _ in range(4):
        some(250)
        resident.append(memory())
    assert at_rest(held, before) == before
    assert min(b - a for a, b in itertools.pairwise(resident)) < 250 * 1000  # memory comes in large pieces, now and then


def test_a_step_takes_one_call_of_the_loop(monkeypatch):
    """Between steps nothing is asked of the units, and no batch is laid out."""
    with cosimo.open("mass-on-spring") as sim:
        sim.initialize()
        sim.step()
        calls = []
        master = sim._master
        monkeypatch.setattr(type(master), "take_steps", lambda *_: calls.append("batch"))
        original = type(master.records).take_rows
        monkeypatch.setattr(type(master.records), "take_rows", lambda *a: (calls.append("loop"), original(*a)))
        for _ in range(10):
            sim.step()
        assert calls == ["loop"] * 10


def test_sessions_in_two_processes_agree(tmp_path):
    """What bytes hold is enough: another process goes on with the same bits."""
    scene = load_scene("rov-station-keeping").with_changes({"stop_time": 4.0})
    with cosimo.open(scene) as sim:
        sim.initialize()
        sim.until(1.0)
        (tmp_path / "state").write_bytes(bytes(sim.save()))
        sim.until(1.5)
        here = sim.values(["hull.depth", "hull.yaw"]).tolist()
    code = (
        "import cosimo, pathlib, sys\n"
        "scene = cosimo.load_scene('rov-station-keeping').with_changes({'stop_time': 4.0})\n"
        "with cosimo.open(scene) as sim:\n"
        "    sim.restore(pathlib.Path(sys.argv[1]).read_bytes())\n"
        "    sim.until(1.5)\n"
        "    print(sim.values(['hull.depth', 'hull.yaw']).tolist())\n"
    )
    there = subprocess.run([sys.executable, "-c", code, str(tmp_path / "state")], capture_output=True, text=True, check=True)
    assert there.stdout.strip() == str(here)


def test_fmus_hold_no_states_that_nobody_has(foreign):
    table, _, _ = units("FMI 2", foreign)
    with cosimo.open(read_scene({"stop_time": 2.0, "units": {"a": table}, "master": {"step": 0.125}})) as sim:
        sim.initialize()
        unit = sim._units["a"]
        for _ in range(20):
            state = sim.save()
        gc.collect()
        assert np.count_nonzero([one() is not None for one in sim._open_scene.states]) == 1
        state.release()
        with pytest.raises(BadInput, match="a state of units that were closed"):
            sim.restore(state)
        assert unit is sim._units["a"]


def corrected():
    """A scene whose energy the master corrects: the next steps depend on the account."""
    return load_scene("pipe-robots-in-tow").with_changes({"stop_time": 0.5, "master.energy_correction": True})


def test_the_account_of_energy_is_part_of_a_state():
    scene = corrected()
    name = "front.velocity"
    with cosimo.open(scene) as sim, cosimo.open(scene) as other:
        sim.initialize()
        sim.step(10)
        state = sim.save()
        content = bytes(state)
        sim.step(20)
        reached = sim[name]
        sim.restore(state)
        sim.step(20)
        assert sim[name] == reached
        other.restore(content)
        other.step(20)
        assert other[name] == reached


def test_bytes_of_an_older_state_drop_no_rows():
    with cosimo.open("mass-on-spring") as sim:
        sim.initialize()
        sim.record()
        sim.step(5)
        state = sim.save()
        sim.step(10)
        bytes(state)
        assert sim.result().rows == 16


def test_values_are_refused_where_there_are_none():
    """Also by a session that has given them before."""
    table = one_mass().settings() | {
        "units": {"probe": {"component": "cosimo.tests.support:Probe", "parameters": {"fail_at": 0.055}}}
    }
    with cosimo.open(read_scene(table)) as sim:
        sim.initialize()
        sim.values(["probe.time"])
        sim.reset()
        with pytest.raises(BadInput, match="before the start"):
            sim.values(["probe.time"])
        sim.initialize()
        sim.values(["probe.time"])
        with pytest.raises(StepFailed):
            sim.step(10)
        with pytest.raises(BadInput, match="after a step that failed"):
            sim.values(["probe.time"])


@pytest.mark.parametrize("name", ["wind-pump-gusts", "friction-drive-step"])
def test_reset_leaves_nothing_of_a_run_in_units_that_feed_one_another(name):
    with cosimo.open(name) as sim:
        ways = []
        for _ in range(3):
            sim.initialize()
            sim.record()
            sim.step(20)
            result = sim.result()
            ways.append({n: column.tolist() for n, column in result.columns.items()})
            sim.reset()
        assert ways[0] == ways[1] == ways[2]


def test_values_of_kernels_are_not_those_of_before_a_reset():
    with cosimo.open("mass-on-spring") as sim:
        sim.initialize()
        sim.values(["mass.base_x"])
        sim.reset()
        with pytest.raises(BadInput, match="before the start"):
            sim.values(["mass.base_x"])


def test_a_result_says_what_a_run_would_and_that_it_is_not_verified():
    result = whole(load_scene("mass-on-spring").with_changes({"stop_time": 0.1}), {}, (5,))
    assert result.info.verification.done is False
    assert any("errors of the results are not known" in text for text in result.info.warnings)
    fast = load_scene("en50318-2002").with_changes({"pantograph.speed": 160.0, "stop_time": 0.1})
    assert any("160 km/h or 160 m/s" in text for text in whole(fast, {}, (5,)).info.warnings)


@pytest.mark.full
def test_a_state_of_another_packaging_is_refused():
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.1})
    with cosimo.open(scene) as sim, cosimo.open(scene, in_process=False) as other:
        sim.initialize()
        with pytest.raises(BadInput, match="the same kind"):
            other.restore(bytes(sim.save()))


def test_an_fmu_that_ends_the_simulation_ends_the_scene():
    scene = read_scene(
        {"stop_time": 2.0, "units": {"a": {"fmu": exchange_fmu(), "parameters": {"end": 0.5}}}, "master": {"step": 0.125}}
    )
    with cosimo.open(scene) as sim:
        sim.initialize()
        sim.record()
        sim.until(2.0)
        assert sim.done
        assert sim.time == pytest.approx(0.5, abs=1e-3)
        assert math.isfinite(sim["a.x"])
        assert (sim.result().outcome, "ended the simulation" in sim.result().message) == ("done", True)
        with pytest.raises(BadInput, match="ended the simulation"):
            sim.step()
        sim.reset()
        sim.initialize()
        sim.step()
        assert not sim.done
