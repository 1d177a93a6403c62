"""Signals of tables in scenes: jumps at which steps end, units of measure, files, states, packagings, and inputs of FMUs."""

import json
import math
import os
import subprocess
import sys
import zipfile

import cosimo
import fmpy
import numpy as np
import pytest
from cosimo import BadInput
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.engine.stepping.discontinuities import jump_times
from cosimo.orchestrator.run.dependence import depends_on
from cosimo.orchestrator.scene_fmu import build_scene_fmu
from cosimo.tests.commands import exit_code
from cosimo.tests.units.native import native_fmu

NATIVE = pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")
JUMPING = "time,force [kN]\n0,1e-3\n0.515,1e-3\n0.515,-1e-3\n1.5,-1e-3\n1.5,3e-3\n1.5005,3e-3\n1.5005,0\n2,0\n"
IMPULSE = 0.515 - (1.5 - 0.515) + 3.0 * 0.0005  # N s, by hand
ON_GRID = "time,force [N]\n0,1\n0.51,1.5\n0.51,-1\n1.5,-1\n1.5,3\n1.8,3\n2,0\n"


def mass(folder, text, *, step=0.01, stop_time=2.0, master=None, **unit):
    """A mass of 2 kg, free to move, that the column `force` of a table pushes."""
    (folder / "force.csv").write_text(text)
    return cosimo.build_scene(
        {"road": {"signals": "force.csv", **unit}, "mass": cosimo.unit("PlanarLink", mass=2.0, centre=0.0, inertia=1.0)},
        {"road.force": "mass.base_force_x"},
        stop_time=stop_time,
        step=step,
        folder=folder,
        master=master,
    )


def run(scene, **more):
    return cosimo.run(scene, in_process=True, verify="no", **more)


MASTERS = [{"algorithm": a, "extrapolation": k} for a in ("jacobi", "gauss-seidel") for k in (0, 1, 2)]


@pytest.mark.parametrize(
    ("master", "interpolation"),
    [*((m, i) for m in MASTERS for i in ("linear", "hold")), ({"control": {"method": "doubling"}}, "linear")],
    ids=str,
)
def test_jumps_act_at_their_instants_whatever_the_master(tmp_path, master, interpolation):
    """Three jumps between macro steps and at their ends; the force is constant between them, so that its impulse is known."""
    result = run(mass(tmp_path, JUMPING, master=master, interpolation=interpolation))
    assert result["mass.base_velocity_x"][-1] == pytest.approx(IMPULSE / 2.0, abs=1e-13)
    assert set(result["road.force"]) == {1e-3, -1e-3, 3e-3, 0.0}
    for jump in (0.515, 1.5, 1.5005):
        assert jump in result.time


def test_a_row_at_a_jump_has_the_value_behind_it(tmp_path):
    result = run(mass(tmp_path, JUMPING))
    assert result["road.force"][result.time == 0.515].tolist() == [-1e-3]


def test_a_jump_that_a_step_end_meets_needs_no_step_more(tmp_path):
    for interpolation in ("linear", "hold"):
        assert len(run(mass(tmp_path, ON_GRID, interpolation=interpolation)).time) == 201
    assert jump_times(mass(tmp_path, ON_GRID)) == [0.51, 1.5]
    assert jump_times(mass(tmp_path, ON_GRID, interpolation="hold")) == []


def test_held_rows_between_steps_end_steps(tmp_path):
    scene = mass(tmp_path, "time,force [N]\n0,1\n0.333,-2\n0.777,4\n2,0\n", interpolation="hold")
    assert jump_times(scene) == [0.333, 0.777, 2.0]
    exact = (0.333 - 2.0 * (0.777 - 0.333) + 4.0 * (2.0 - 0.777)) / 2.0
    assert run(scene)["mass.base_velocity_x"][-1] == pytest.approx(exact, abs=1e-13)


def test_a_period_that_is_no_multiple_of_the_step(tmp_path):
    """A saw tooth of 0.7 s in steps of 0.01 s, and of 0.0333 s in which nothing ends."""
    text = "time [ms],force [N]\n0,0\n333.3,3\n"
    scene = mass(tmp_path, text, outside="repeat")
    assert len(jump_times(scene)) == 6
    whole, rest = 6, 2.0 - 6 * 0.3333
    exact = (whole * 0.5 * 3.0 * 0.3333 + 0.5 * 9.000900090009 * rest**2) / 2.0
    assert run(scene)["mass.base_velocity_x"][-1] == pytest.approx(exact, rel=1e-9)


def test_a_table_that_ends_during_the_run_is_held_there_where_that_is_asked_for(tmp_path):
    text = "time,force [N]\n0,1\n1.005,1\n"
    scene = mass(tmp_path, text, outside="hold")
    assert run(scene)["mass.base_velocity_x"][-1] == pytest.approx(1.0, abs=1e-13)
    with pytest.raises(BadInput, match=r"units\.road: got a run from 0 to 2 s, expected a run within force\.csv, 0 to 1\.005 s"):
        mass(tmp_path, text)
    with pytest.raises(BadInput, match=r"force\.csv, -1 to 1\.005 s") as raised:
        mass(tmp_path, "time,force\n0,1\n2.005,1\n", start=-1.0)
    assert 'outside = "hold"' in str(raised.value)


def test_start_shifts_and_may_be_written_with_its_unit(tmp_path):
    text = "time,force [N]\n0,1\n1,1\n1,0\n120,0\n"
    for start, pushed in ((-0.25, 0.75), ("-500 ms", 0.5)):
        scene = mass(tmp_path, text, start=start)
        assert run(scene)["mass.base_velocity_x"][-1] == pytest.approx(pushed / 2.0, abs=1e-13)
    later = scene.with_changes({"units.road.parameters.start": -1.0})
    assert run(later)["mass.base_velocity_x"][-1] == 0.0


def test_a_step_that_misses_rows_says_how_much(tmp_path):
    t = np.arange(0.0, 2.0005, 0.001)
    for frequency, warned in ((1.0, False), (10.0, True)):
        text = "time,force [N]\n" + "".join(f"{a!r},{math.sin(2 * math.pi * frequency * a)!r}\n" for a in t.tolist())
        scene = mass(tmp_path, text, step=0.02)
        warnings = [w for w in run(scene).info.warnings if "rows in a macro step" in w]
        assert bool(warned) == bool(warnings)
        chord = np.interp(t, t[::20], np.sin(2 * np.pi * frequency * t[::20])) - np.sin(2 * np.pi * frequency * t)
        missed = 100.0 * np.sqrt(np.mean(chord**2)) / np.std(np.sin(2 * np.pi * frequency * t))
        assert warned == (missed > 1.0)
        if warned:
            assert "20 rows in a macro step of 0.02 s" in warnings[0]
            assert f"miss {missed:.2g} % of the deviation of force" in warnings[0]


def test_columns_are_converted_to_the_units_of_inputs(tmp_path):
    (tmp_path / "a.csv").write_text("time;place [mm];speed [km/h];plain\n0;1,5;36;7\n2;1,5;36;7\n")
    scene = cosimo.build_scene(
        {"road": cosimo.unit("a.csv"), "joint": "CompliantJoint"},
        {"road.place": "joint.first_x", "road.speed": "joint.first_velocity_x", "road.plain": "joint.first_y"},
        stop_time=0.1,
        step=0.01,
        folder=tmp_path,
    )
    factors = {link.source[1]: link.factor for link in scene.coupling.links}
    assert factors == {"place": 1e-3, "speed": pytest.approx(1.0 / 3.6), "plain": 1.0}
    with pytest.raises(BadInput, match="'km/h' for 'm'"):
        cosimo.build_scene(
            {"road": cosimo.unit("a.csv"), "joint": "CompliantJoint"},
            {"road.speed": "joint.first_x"},
            stop_time=0.1,
            step=0.01,
            folder=tmp_path,
        )


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"component": "Wind"}, "component and signals exclude each other"),
        ({"fmu": "a.fmu"}, "fmu and signals exclude each other"),
        ({"isolation": "process"}, "isolation: 'process' has no effect for a table of signals, only for a component or an FMU"),
        ({"every": 2}, "every: no effect for a table of signals, only for a component or an FMU"),
        ({"tolerance": 1e-6}, "tolerance: no effect for a table of signals, only for an FMU given by its path"),
        ({"interpolation": "cubic"}, "'cubic', expected one of linear, hold, pchip"),
        ({"parameters": {"begin": 1.0}}, "variable 'begin'"),
        ({"signals": "none.csv"}, r"units\.road\.signals: .*none\.csv"),
    ],
)
def test_what_a_unit_of_signals_cannot_be(tmp_path, keys, words):
    with pytest.raises(BadInput, match=words):
        mass(tmp_path, ON_GRID, **keys)


def test_keys_of_tables_are_refused_elsewhere(tmp_path):
    with pytest.raises(BadInput, match="outside: 'hold' has no effect for a component, only for a table of signals"):
        cosimo.build_scene({"wind": {"component": "Wind", "outside": "hold"}}, stop_time=1.0, step=0.1)


# -- files -----------------------------------------------------------------------------------------------------------------------
def test_a_scene_is_written_and_included_with_its_table(tmp_path):
    scene = mass(tmp_path, ON_GRID, interpolation="hold")
    path = cosimo.write_scene(scene, tmp_path / "deep" / "scene.toml")
    assert "Signals_" not in path.read_text()
    again = cosimo.load_scene(path)
    assert again.settings() == scene.settings()
    assert depends_on(again) == depends_on(scene)
    (tmp_path / "part.toml").write_text('[units.road]\nsignals = "force.csv"\noutside = "repeat"\nstart = "10 ms"\n')
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "whole.toml").write_text(
        'stop_time = 1.0\n[units.sub]\nscene = "../part.toml"\n[master]\nstep = 0.01\n'
    )
    whole = cosimo.load_scene(tmp_path / "below" / "whole.toml")
    assert whole.units["sub.road"].parameters == {"outside": "repeat", "start": 0.01}
    assert run(whole).outcome == "done"


def test_contents_count_for_the_same_scene_and_the_path_does_not(tmp_path):
    one = mass(tmp_path, ON_GRID)
    (tmp_path / "other").mkdir()
    assert depends_on(mass(tmp_path / "other", ON_GRID)) == depends_on(one)
    assert depends_on(mass(tmp_path, ON_GRID.replace("1.8,3", "1.8,2"))) != depends_on(one)


def test_a_checkpoint_goes_on_bit_identical_and_not_with_another_table(tmp_path):
    scene, checkpoint = mass(tmp_path, JUMPING, interpolation="pchip"), tmp_path / "checkpoint"
    whole = run(scene, checkpoint_every=0.9, checkpoint_to=checkpoint)
    rest = run(scene, resume=checkpoint)
    np.testing.assert_array_equal(rest["mass.base_x"][-20:], whole["mass.base_x"][-20:])
    other = mass(tmp_path, JUMPING.replace("1.5005,0\n", "1.5005,1e-9\n"), interpolation="pchip")
    with pytest.raises(BadInput, match="of another scene or other settings"):
        run(other, resume=checkpoint)


def test_results_are_read_where_the_table_is_gone(tmp_path):
    scene = mass(tmp_path, ON_GRID)
    run(scene).save(tmp_path / "out")
    kept = json.loads((tmp_path / "out" / "run.json").read_text())["scene"]["units"]["road"]
    assert kept["component"].startswith("Signals_")
    os.remove(tmp_path / "force.csv")
    code = (
        "import cosimo, sys; r = cosimo.read_result(sys.argv[1]); r.to_xarray(); r.report(sys.argv[1] + '/again');"
        "print(r['road.force'][-1], r.scene.units['road'].signals)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "out")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0.0 ")


# -- sessions ---------------------------------------------------------------------------------------------------------------------
def test_a_session_steps_through_jumps_and_goes_back(tmp_path):
    scene = mass(tmp_path, JUMPING, stop_time=1.9)
    whole = run(scene)
    with cosimo.open(scene) as sim:
        sim.initialize()
        sim.until(0.5)
        state = sim.save()
        for _ in range(2):
            sim.restore(state)
            sim.until(1.9)
            assert sim["mass.base_velocity_x"] == whole["mass.base_velocity_x"][-1]
        sim.reset()
        sim["road.start"] = -0.015
        assert sim["road.start"] == -0.015


# -- packagings ------------------------------------------------------------------------------------------------------------------
@NATIVE
@pytest.mark.parametrize("unit", [{}, {"interpolation": "hold"}, {"interpolation": "pchip", "outside": "hold"}], ids=str)
def test_the_fmu_of_a_scene_is_bit_identical(tmp_path, unit):
    scene = mass(tmp_path, ON_GRID, **unit)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    result = run(scene)
    recorded = fmpy.simulate_fmu(str(path), stop_time=2.0, step_size=0.01, output_interval=0.01)
    for name in ("road.force", "mass.base_x", "mass.base_velocity_x"):
        np.testing.assert_array_equal(recorded[name], result[name])


@NATIVE
def test_jumps_between_steps_are_refused_in_the_fmu_of_a_scene(tmp_path):
    with pytest.raises(BadInput, match=r"signals that jump at 0\.515 s, expected whole multiples of the macro step"):
        build_scene_fmu(mass(tmp_path, JUMPING), tmp_path, [own_target()])
    with pytest.raises(BadInput, match="beside a table without end"):
        build_scene_fmu(mass(tmp_path, "time,force\n0,0\n0.5,1\n", outside="repeat"), tmp_path, [own_target()])


def test_native_fmus_of_components_leave_the_table_where_it_is(tmp_path):
    """So do FMUs of pythonfmu: the master lets jumps happen, for which FMI has no call."""
    scene = mass(tmp_path, JUMPING)
    whole = run(scene)
    result = cosimo.run(scene, verify="no")
    assert result.info.units["road"].kind == "in process"
    assert result.info.units["mass"].kind == "FMU"
    np.testing.assert_array_equal(result["mass.base_x"], whole["mass.base_x"])


@pytest.mark.parametrize("native", [False, pytest.param(True, marks=NATIVE)])
def test_a_table_is_an_fmu_of_its_own(tmp_path, native, capsys):
    (tmp_path / "road.csv").write_text("time [ms];height [mm];counts [counts]\n0;0;5\n1000;1,5;5\n1000;7;6\n2000;8;6\n")
    assert exit_code(*["build", str(tmp_path / "road.csv"), "-o", str(tmp_path), *(["--native"] if native else [])]) == 0
    description = fmpy.read_model_description(str(tmp_path / "road.fmu"))
    assert {v.name: v.unit for v in description.modelVariables if v.causality == "output"} == {"height": "mm", "counts": "counts"}
    recorded = fmpy.simulate_fmu(str(tmp_path / "road.fmu"), output_interval=0.25)
    assert recorded["time"][-1] == 2.0
    assert recorded["height"][[0, 3, 4, 5, 8]].tolist() == [0.0, 1.125, 7.0, 7.25, 8.0]  # at a jump the value behind it
    one = (tmp_path / "road.fmu").read_bytes()
    assert exit_code(*["build", str(tmp_path / "road.csv"), "-o", str(tmp_path), *(["--native"] if native else [])]) == 0
    assert (tmp_path / "road.fmu").read_bytes() == one


def test_a_package_has_the_table_as_an_fmu(tmp_path):
    cosimo.write_scene(mass(tmp_path, ON_GRID), tmp_path / "scene.toml")
    assert exit_code(*["ssp", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "scene.ssp"), "--force"]) == 0
    assert "resources/force.fmu" in zipfile.ZipFile(tmp_path / "scene.ssp").namelist()
    result = cosimo.run(tmp_path / "scene.ssp", verify="no")
    assert result["road.force"][result.time == 0.5].tolist() == pytest.approx([1.0 + 0.5 * 0.5 / 0.51])


# -- inputs ----------------------------------------------------------------------------------------------------------------------
INPUT = "time,base_force_x [kN],base_torqe,remark\n0.5,1e-3,0,1\n1.5,1e-3,0,2\n"


def test_an_fmu_alone_runs_with_a_table_over_its_time(tmp_path, capsys):
    (tmp_path / "data.csv").write_text(INPUT)
    fmu = str(cosimo.build("PlanarLink", tmp_path))
    assert exit_code(*["run", fmu, "--input", str(tmp_path / "data.csv"), "--no-verify", "-o", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    assert "data.csv: no input for column 'base_torqe' (Did you mean 'base_torque'" in told
    assert "'remark'; no column for fmu.base_force_y, fmu.base_torque, fmu.tip_force_x" in told
    result = cosimo.read_result(tmp_path / "out")
    assert (result.time[0], result.time[-1]) == (0.5, 1.5)
    alone = cosimo.load_scene("PlanarLink").with_input(tmp_path / "data.csv", whole=True)
    assert run(alone)["planar_link.base_x"][-1] == pytest.approx(result["fmu.base_x"][-1], rel=1e-12)


def test_a_table_without_any_input_names_the_nearest(tmp_path, capsys):
    (tmp_path / "data.csv").write_text("time,bas_torque\n0,1\n1,1\n")
    assert exit_code(*["run", "PlanarLink", "--input", str(tmp_path / "data.csv")]) == 2
    assert "columns bas_torque, expected a column with the name of an open input: base_force_x" in (
        told := capsys.readouterr().err
    )
    assert "Did you mean 'base_torque'" in told


def test_open_inputs_of_a_scene_are_joined_by_short_and_by_whole_names(tmp_path):
    (tmp_path / "data.csv").write_text("time,mass.base_torque,base_force_y,first_x\n0,1,2,3\n2,1,2,3\n")
    scene = cosimo.load_scene("mass-on-spring", {"stop_time": 2.0}).with_input(tmp_path / "data.csv")
    joined = {link.target: link.source for link in scene.coupling.links if link.source[0] == "input"}
    assert joined == {
        ("mass", "base_torque"): ("input", "mass.base_torque"),
        ("mass", "base_force_y"): ("input", "base_force_y"),
        ("spring", "first_x"): ("input", "first_x"),
    }
    assert run(scene).outcome == "done"


def test_a_table_comes_first_in_a_given_order_of_units(tmp_path):
    (tmp_path / "data.csv").write_text("time,mass.base_torque\n0,1\n2,1\n")
    units = list(cosimo.load_scene("mass-on-spring").units)
    ordered = cosimo.load_scene("mass-on-spring", {"stop_time": 0.5, "master.order": units[::-1]})
    scene = ordered.with_input(tmp_path / "data.csv")
    assert list(scene.settings()["master"]["order"]) == ["input", *units[::-1]]
    assert run(scene).outcome == "done"


def test_a_new_scene_with_a_table_runs_as_it_is(tmp_path, capsys):
    (tmp_path / "data.csv").write_text(INPUT)
    file = tmp_path / "scene.toml"
    assert exit_code(*["new", "scene", str(file), "PlanarLink", "--input", str(tmp_path / "data.csv")]) == 0
    assert 'signals = "data.csv"' in file.read_text()
    scene = cosimo.load_scene(file)
    assert (scene.start_time, scene.stop_time, len(scene.connections)) == (0.5, 1.5, 1)
    assert run(scene).outcome == "done"
    assert exit_code(*["new", "scene", str(tmp_path / "b.toml"), "--from", "mass-on-spring", "--input", str(file)]) == 2


def test_a_table_beside_the_working_directory_is_found_by_repetitions_of_a_scene_with_fmus(tmp_path, monkeypatch):
    """They have a working directory of their own, where a relative path leads nowhere."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "force.csv").write_text(ON_GRID)
    scene = cosimo.build_scene(
        {
            "road": "force.csv",
            "mass": cosimo.unit("PlanarLink", mass=2.0, centre=0.0, inertia=1.0),
            "f": native_fmu("dahlquist", 2),
        },
        {"road.force": "mass.base_force_x"},
        stop_time=1.0,
        step=0.01,
    )
    result = cosimo.run(scene, in_process=True, verify="whole")
    assert result.info.verification.done, result.info.verification.why
