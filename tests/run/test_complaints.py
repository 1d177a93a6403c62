"""What users of other masters complain of, each complaint as a test: links lead to the threads."""

import json
import os
import shutil

import fmpy
import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.components.core.kernels import COMPILED
from cosimo.components.core.variables import output, parameter
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.judgement import advise
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.units import open_unit
from cosimo.tests.commands import exit_code
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import orders
from cosimo.tests.support import Linear, exact_two_masses, two_masses
from cosimo.tests.units.exchange_fmu import exchange_fmu
from cosimo.tests.units.native import STATE, native_fmu

KERNELS = "cosimo.tests.derivatives.coupled_masses"
PROBE = {"component": "cosimo.tests.support:Probe"}
BEHIND = {  # a free mass, and what sees its position in mm
    "stop_time": 1.0,
    "connections": ["m.x_out -> p.length"],
    "units": {"m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}}, "p": PROBE},
    "master": {"algorithm": "jacobi", "step": 0.1},
    "record": {"signals": ["m.x_out", "p.profile[1]"]},
}


class Pull(Linear):
    """A force of 3 in units of measure that are those of a force, written otherwise."""

    size = parameter(3.0, "1", "of the force")
    same = output("kg.m/s2", "newtons in base units")
    kilo = output("kN", "kilonewtons")
    length = output("m", "no force")

    def matrices(self):
        return np.zeros((1, 1)), np.zeros((1, 0)), np.ones((3, 1)) * self.parameters["size"], np.zeros((3, 0)), [1.0]


PULL = {"component": "cosimo.tests.run.test_complaints:Pull"}


def toml(path, text: str):
    path.write_text(text)
    return path


def error_at_1_s(**master) -> float:
    scene = two_masses()
    result = run(read_scene({**scene, "master": master}))
    ends = ("a.x_out", "a.v_out", "b.x_out", "b.v_out")
    return float(np.abs(np.array([result[n][-1] for n in ends]) - exact_two_masses(1.0)).max())


def test_inputs_are_not_held_unless_that_is_wished():
    """Wrong results from held inputs: https://github.com/OpenModelica/OMSimulator/issues/18"""
    usual = [error_at_1_s(step=h) for h in (1e-3, 5e-4)]
    held = [error_at_1_s(step=h, extrapolation=0) for h in (1e-3, 5e-4)]
    assert orders(usual)[0] == pytest.approx(2.0, abs=0.15)
    assert usual[0] < 0.1 * held[0]


def test_outputs_follow_inputs_within_the_instant():
    """One macro step of delay: https://github.com/modelon-community/PyFMI/issues/251"""
    fresh = run(read_scene(BEHIND))
    np.testing.assert_allclose(fresh["p.profile[1]"], 1000.0 * fresh["m.x_out"], rtol=1e-14)
    held = {**BEHIND["master"], "extrapolation": 0, "feedthrough": "delayed"}
    stale = run(read_scene({**BEHIND, "master": held}))  # who wants the delay has it
    np.testing.assert_allclose(stale["p.profile[1]"][1:], 1000.0 * stale["m.x_out"][:-1], rtol=1e-14)


def test_an_unstable_setup_is_told_before_the_run_and_by_the_run():
    """A failure far into a run that was an instability of the setup: https://github.com/modelon-community/PyFMI/issues/115"""
    scene = read_scene(
        {
            "stop_time": 2000.0,
            "connections": ["s.force -> m.force", "m.x_out -> s.x1", "m.v_out -> s.v1"],
            "units": {
                "m": {"component": f"{KERNELS}:Owner", "parameters": {"x0": 1.0}},
                "s": {"component": f"{KERNELS}:Between", "parameters": {"cc": 1.0}},
            },
            "master": {"algorithm": "jacobi", "step": 0.1, "extrapolation": 0},
        }
    )
    if COMPILED:
        (warning,) = advise(scene).warnings(scene)
        assert "stable up to 0.02 s" in warning
    result = run(scene)
    assert result.outcome == "unstable"
    assert "has grown to" in result.message
    assert "Reduce the macro step" in result.message


def test_algebraic_loops_are_solved_and_shown(tmp_path, capsys):
    """Loops over FMUs that were not solved: https://github.com/OpenModelica/OMSimulator/issues/808"""
    loop = {
        "stop_time": 0.2,
        "units": {"p": PROBE, "q": PROBE},
        "master": {"step": 0.1},
        "connections": [
            {"source": "p.profile[1]", "target": "q.length", "factor": 0.25, "offset": 3.0},
            {"source": "q.profile[1]", "target": "p.length", "factor": -1.0, "offset": 1.0},
        ],
        "record": {"signals": ["p.profile[1]", "q.profile[1]"]},
    }
    result = run(read_scene(loop))
    p, q = np.linalg.solve([[1.0, 1.0], [-0.25, 1.0]], [1.0, 3.0])  # p = 1 - q, q = p/4 + 3
    np.testing.assert_allclose([result["p.profile[1]"][-1], result["q.profile[1]"][-1]], [p, q], rtol=1e-11)
    scene = toml(
        tmp_path / "loop.toml",
        """
stop_time = 0.2
connections = ["p.profile[1] -> q.length", { source = "q.profile[1]", target = "p.length", factor = 0.5 }]
units = { p = { component = "cosimo.tests.support:Probe" }, q = { component = "cosimo.tests.support:Probe" } }
master = { step = 0.1 }
""",
    )
    assert exit_code("run", scene, "--dry-run") == 0
    assert "algebraic loops: p.profile[1], q.profile[1]" in capsys.readouterr().out


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_restored_fmu_steps_on_as_it_did(fmi):
    """SetFMUstate after which the solver hung: https://github.com/OpenModelica/OpenModelica/issues/12260"""
    unit = open_unit("f", UnitSettings(fmu=native_fmu("van_der_pol", fmi, STATE[fmi])), in_process=False)
    try:
        unit.wire((), ("x0", "x1"))
        unit.initialize(0.0, [])
        unit.start()
        state, ends = unit.save(), set()
        for _ in range(200):
            unit.step(0.0, 0.1)
            ends.add(tuple(unit.get()))
            unit.restore(state)
        assert len(ends) == 1
    finally:
        unit.close()


def test_model_exchange_goes_back_with_the_others_or_the_scene_is_refused():
    """Adaptive steps that did not roll model exchange back: https://github.com/OpenModelica/OMSimulator/issues/603"""
    allowed = 1e-5
    scene = {
        "stop_time": 1.0,
        "connections": ["m.v_out -> f.u"],
        "units": {
            "m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": 100.0}},
            "f": {"fmu": exchange_fmu(), "parameters": {"k": 5.0}, "tolerance": 1e-10},
        },
        "master": {
            "algorithm": "jacobi",
            "step": 0.5,
            "control": {"method": "doubling", "relative": allowed, "absolute": allowed},
        },
    }
    result = finished(read_scene(scene))
    assert result.info.counters.stepping.rejected > 0
    t = result.time  # x' = -5 x + cos 10 t
    exact = (5.0 * np.cos(10.0 * t) + 10.0 * np.sin(10.0 * t) - 5.0 * np.exp(-5.0 * t)) / 125.0
    np.testing.assert_allclose(result["f.x"], exact, atol=allowed * len(t))
    scene["units"]["f"] = {"fmu": exchange_fmu(capabilities="")}
    with pytest.raises(BadInput, match=r"doubling.*; f cannot"):
        read_scene(scene)


@pytest.mark.parametrize("step", ["0", "-0.1", "nan", "inf", "2", "1e-320", "-0"])
def test_impossible_steps_are_refused_at_once(step, tmp_path, capsys):
    """--stepSize=0 that hung or dumped core: https://github.com/OpenModelica/OMSimulator/issues/1622"""
    scene = toml(tmp_path / "s.toml", 'stop_time = 1.0\nunits.p.component = "cosimo.tests.support:Probe"\nmaster.step = 0.1\n')
    assert exit_code("run", scene, "--in-process", "--step", step) == 2
    named = "'--step'" if step in ("nan", "inf") else "master.step"  # no numbers of a time for the option itself
    assert named in capsys.readouterr().err


def test_a_ball_that_bounces_ever_faster_comes_to_an_end(tmp_path, capsys):
    """A bouncing ball that printed errors without end: https://github.com/OpenModelica/OMSimulator/issues/1281"""
    fmu = native_fmu("bouncing_ball", 2, STATE[2])
    scene = toml(tmp_path / "ball.toml", f'stop_time = 5.0\nunits.ball.fmu = "{fmu}"\nmaster.step = 0.01\n')
    assert exit_code("run", scene, "-o", tmp_path / "out") == 0
    assert len(capsys.readouterr().err.splitlines()) <= 1
    last = (tmp_path / "out" / "result.csv").read_text().splitlines()[-1].split(",")
    assert float(last[0]) == 5.0


def test_the_command_line_goes_before_the_file(tmp_path):
    """A step on the command line that was ignored: https://github.com/OpenModelica/OMSimulator/issues/1329"""
    scene = toml(tmp_path / "s.toml", 'stop_time = 1.0\nunits.p.component = "cosimo.tests.support:Probe"\nmaster.step = 0.1\n')
    assert exit_code("run", scene, "--in-process", "-o", tmp_path, "--step", "0.25", "--stop", "2") == 0
    info = json.loads((tmp_path / "run.json").read_text())
    assert (info["settings"]["step"], info["counters"]["master"]["steps"], info["timing"]["simulated"]) == (0.25, 8, 2.0)


def test_the_missing_mode_is_the_one_that_is_named():
    """A message that named the wrong missing mode: https://github.com/OpenModelica/OMSimulator/issues/1314"""
    for fmu, wanted, has in (
        (exchange_fmu(), "co-simulation", "model exchange"),
        (native_fmu("dahlquist", 2), "model-exchange", "co-simulation"),
    ):
        with pytest.raises(BadInput) as caught:
            read_scene({"stop_time": 1.0, "units": {"f": {"fmu": fmu, "interface": wanted}}, "master": {"step": 0.1}})
        assert f"'{wanted}'" in str(caught.value)
        assert f"It is for {has} only" in str(caught.value)


def test_unknown_signals_come_with_the_near_ones():
    """ "Unknown signal" and no word of those there are: https://github.com/OpenModelica/OMSimulator/issues/1222"""
    for connection, near in (
        ("m.x_ou -> p.length", "'x_out'"),
        ("m.x_out -> p.lenght", "'length'"),
        ("n.x_out -> p.length", "m, p"),
        ("p.profile[4] -> m.force", "'profile[3]'"),
    ):
        with pytest.raises(BadInput) as caught:
            read_scene({**BEHIND, "connections": [connection]})
        assert near in str(caught.value)


def test_units_of_measure_are_converted_and_equal_ones_are_equal():
    """Conversion wished for since 2020, and equal units called a mismatch:

    https://github.com/open-simulation-platform/libcosim/issues/519, https://github.com/OpenModelica/OMSimulator/issues/942,
    https://github.com/OpenModelica/OMSimulator/issues/1428
    """
    scene = {"stop_time": 1.0, "units": {"f": PULL, "m": {"component": "cosimo.tests.support:Mass"}}, "master": {"step": 0.1}}
    for name, factor in (("same", 1.0), ("kilo", 1000.0)):
        (link,) = resolve_coupling(read_scene({**scene, "connections": [f"f.{name} -> m.force"]})).links
        assert (link.factor, link.offset) == (factor, 0.0)
    with pytest.raises(BadInput, match="'m' for 'N'"):
        read_scene({**scene, "connections": ["f.length -> m.force"]})


def test_two_fmus_are_connected_by_a_few_lines(tmp_path):
    """No example of two connected FMUs, and a system that ran to zeros:

    https://github.com/CATIA-Systems/FMPy/issues/793, https://github.com/modelon-community/PyFMI/issues/231,
    https://github.com/CATIA-Systems/FMPy/issues/704
    """
    source, follower = native_fmu("van_der_pol", 2), native_fmu("feedthrough", 3)
    scene = toml(
        tmp_path / "two.toml",
        f"""
stop_time = 1.0
connections = ["oscillator.x0 -> follower.Float64_continuous_input"]
[units]
oscillator.fmu = "{source}"
follower.fmu = "{follower}"
[master]
step = 0.01
[record]
signals = ["oscillator.x0", "follower.Float64_continuous_output"]
""",
    )
    assert exit_code("run", scene, "-o", tmp_path / "out") == 0
    table = np.loadtxt(tmp_path / "out" / "result.csv", delimiter=",", skiprows=1)
    assert table.shape == (101, 3)
    assert np.abs(table[:, 1]).min() > 1.0
    np.testing.assert_array_equal(table[:, 1], table[:, 2])


def test_repeated_runs_read_an_fmu_once(monkeypatch, tmp_path):
    """Time of repeated runs that went into reading the same file again:

    https://github.com/CATIA-Systems/FMPy/issues/504, https://github.com/CATIA-Systems/FMPy/issues/727
    """
    read, read_model_description = [], fmpy.read_model_description

    def noted(path, **options):
        read.append(path)
        return read_model_description(path, **options)

    monkeypatch.setattr(fmpy, "read_model_description", noted)
    fmu = str(shutil.copy(native_fmu("dahlquist", 2), tmp_path / "once.fmu"))
    for _ in range(5):
        finished(read_scene({"stop_time": 1.0, "units": {"f": {"fmu": fmu}}, "master": {"step": 0.1}}))
    assert len(read) == 1


def test_instances_leave_no_open_files():
    """Crashes after a thousand instances: https://github.com/CATIA-Systems/FMPy/issues/608, and /issues/110"""
    scene = read_scene({"stop_time": 0.2, "units": {"f": {"fmu": native_fmu("dahlquist", 2)}}, "master": {"step": 0.1}})
    run(scene)
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(30):
        run(scene)
    assert len(os.listdir("/proc/self/fd")) <= before


@pytest.mark.parametrize("step", [0.1, 0.3, 0.7, 1.0 / 3.0, 0.999])
@pytest.mark.parametrize("control", [None, {"method": "milne", "max_step": 0.2}])
def test_no_step_is_longer_than_allowed_or_passes_the_end(step, control):
    """A largest step that was ignored, a small one that became the largest, and an end that was passed:

    https://github.com/INTO-CPS-Association/maestro/issues/13, /issues/3 and /pull/294
    """
    master = {"algorithm": "jacobi", "step": min(step, 0.2) if control else step} | ({"control": control} if control else {})
    result = run(read_scene({**BEHIND, "master": master}))
    assert result.time[-1] == 1.0
    assert np.diff(result.time).max() <= (0.2 if control else step) * (1.0 + 1e-12)
    assert (np.diff(result.time) > 0.0).all()
    if control:
        with pytest.raises(BadInput, match=r"master\.step"):
            read_scene({**BEHIND, "master": {**master, "step": 0.3}})


def test_options_without_effect_are_refused():
    """A step of a solver that the chosen kind of FMU does not have: https://github.com/CATIA-Systems/FMPy/issues/111"""
    fmu = {"fmu": native_fmu("dahlquist", 2)}
    for unit, named in (({**fmu, "solver": "CVode"}, "solver"), ({**PROBE, "tolerance": 1e-6}, "tolerance")):
        with pytest.raises(BadInput, match=named):
            read_scene({"stop_time": 1.0, "units": {"f": unit}, "master": {"step": 0.1}})
    with pytest.raises(BadInput, match="time_limit"):  # when it runs: --isolate gives it a process
        run(read_scene({"stop_time": 1.0, "units": {"f": {**PROBE, "time_limit": 1.0}}, "master": {"step": 0.1}}))
    for master in ({"order": ["m", "p"]}, {"iteration": {}}, {"energy_correction": True}):
        with pytest.raises(BadInput, match=next(iter(master))):
            read_scene({**BEHIND, "master": {**BEHIND["master"], **master}})


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_a_slow_unit_is_never_ahead_of_time(algorithm):
    """Several rates, and values from ahead of time: https://github.com/open-simulation-platform/libcosim/issues/175, /pull/179"""
    scene = {
        **BEHIND,
        "units": {**BEHIND["units"], "p": {**PROBE, "every": 3}},
        "record": {"signals": ["p.time"]},
        "master": {"algorithm": algorithm, "step": 0.05},
    }
    result = run(read_scene(scene))
    own = np.floor(np.round(result.time / 0.15, 9)) * 0.15
    own[-1] = 1.0  # its last step is cut by the end of the run
    np.testing.assert_allclose(result["p.time"], own, atol=1e-12)


def test_a_run_of_fmus_goes_on_from_a_file_to_the_same_bits(tmp_path):
    """Restart of real FMUs, with all that they and the master keep:

    https://github.com/open-simulation-platform/libcosim/pull/785, https://github.com/open-simulation-platform/libcosim/pull/777
    """
    scene = read_scene(
        {
            "stop_time": 0.2,
            "master": {"step": 2e-3, "extrapolation": 2},
            "connections": ["pantograph.contact_force -> wire.force", "wire.x_out -> pantograph.wire_height"],
            "units": {
                "pantograph": {"component": "Pantograph"},
                "wire": {"component": "cosimo.tests.support:Mass", "parameters": {"m": 40.0, "k": 4000.0, "c": 150.0, "v0": 0.2}},
            },
        }
    )
    whole = run(scene, checkpoint_every=0.15, checkpoint_to=tmp_path / "checkpoint")
    resumed = run(scene, resume=tmp_path / "checkpoint")
    assert (whole.outcome, resumed.info.resumed.at) == ("done", pytest.approx(0.15, abs=2e-3))
    for name in whole.columns:
        assert whole[name].tobytes() == resumed[name].tobytes(), name


def test_a_step_that_an_fmu_needs_is_named():
    """Units should tell the step that they need: https://github.com/modelica/fmi-standard/issues/350"""
    fmu = native_fmu("stair", 3, 'canHandleVariableCommunicationStepSize="false" fixedInternalStepSize="0.2"')
    scene = {"stop_time": 2.0, "units": {"stair": {"fmu": fmu}}, "master": {"step": 0.25}}
    with pytest.raises(BadInput) as caught:
        read_scene(scene)
    assert [word for word in ("master.step", "stair", "0.2 s") if word not in str(caught.value)] == []
    read_scene({**scene, "master": {"step": 0.4}})


def test_the_order_of_units_is_irrelevant_to_jacobi():
    """And so is that of connections."""
    scene = two_masses("jacobi", 1e-2, 2)
    turned = {**scene, "units": dict(reversed(scene["units"].items())), "connections": scene["connections"][::-1]}
    first, second = run(read_scene(scene)), run(read_scene(turned))
    for name in first.columns:
        assert first[name].tobytes() == second[name].tobytes(), name
