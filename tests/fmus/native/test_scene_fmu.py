"""A scene as one FMU without Python: bit-identical to its run in process, with parameters, states and refusals of its own."""

import subprocess
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.fmus.native.build import compiler, own_target
from cosimo.fmus.native.machine_code import TARGETS, object_code
from cosimo.orchestrator.harness.validation.reference import compare, load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene_fmu import build_scene_fmu, scene_library
from cosimo.orchestrator.scene_fmu.variables import open_ports
from cosimo.orchestrator.systems.railway.cases.en50318_2002 import SPEEDS, condition
from cosimo.orchestrator.systems.railway.runs import at_speed, numbers
from cosimo.tests.commands import exit_code
from fmpy.fmi2 import FMU2Slave

pytestmark = pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")

STEPS = 200
SCENES = [
    "mass-on-spring",
    *(
        pytest.param(name, marks=pytest.mark.full)
        for name in ("en50318-2002", "gimbal-rotor", "rov-station-keeping", "wind-pump-gusts", "rotor-bearings-heat")
    ),
]


def short(scene, steps, changes=()):
    """The scene over so many macro steps, each of them recorded."""
    step = scene.master.step
    return scene.with_changes({**dict(changes), "stop_time": steps * step, "record.interval": None})


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Files of both versions of FMI by scene, each built once."""
    folder, files = tmp_path_factory.mktemp("scenes"), {}

    def of(name):
        if name not in files:
            files[name] = build_scene_fmu(load_scene(name), folder, [own_target()], (2, 3))
        return files[name]

    return of


def outputs_of(path, steps, h, **more):
    """What FMPy records in each step of length h; counts and flags as the numbers that a run has of them."""
    recorded = fmpy.simulate_fmu(str(path), stop_time=steps * h, step_size=h, output_interval=h, **more)
    return recorded.astype([(name, float) for name in recorded.dtype.names])


@pytest.mark.parametrize("name", SCENES)
def test_bit_identical_to_the_run_in_process(name, built):
    scene = load_scene(name)
    reference = run(short(scene, STEPS), in_process=True)
    for path in built(name):
        recorded = outputs_of(path, STEPS, scene.master.step)
        common = [n for n in recorded.dtype.names if n in reference.columns]
        assert len(common) > 2
        for column in common:
            assert recorded[column].tobytes() == np.asarray(reference[column]).tobytes(), (path.name, column)


@pytest.mark.full
@pytest.mark.skipif(own_target() != "linux64", reason="the host is a program for Linux")
@pytest.mark.parametrize("name", ["mass-on-spring", "en50318-2002"])
def test_a_host_in_c_with_an_empty_environment(name, built, tmp_path):
    """It loads the library by itself, finds neither Python nor a variable of the environment, and gets the same bits."""
    scene, path, program = load_scene(name), built(name)[0], tmp_path / "host"
    subprocess.run([*compiler("linux64"), "-w", "-o", program, Path(__file__).parents[1] / "host.c", "-ldl"], check=True)
    described = fmpy.read_model_description(str(path))
    library = Path(fmpy.extract(str(path), tmp_path / "fmu"), "binaries", "linux64", f"{described.modelName}.so")
    references = {v.name: str(v.valueReference) for v in described.modelVariables if v.causality == "output"}
    arguments = [library, described.guid, "", "log", "1", str(STEPS), repr(scene.master.step), *references.values()]
    done = subprocess.run([program, *arguments], env={}, cwd="/", capture_output=True, text=True, check=True)
    rows = np.array([[float.fromhex(value) for value in line.split()] for line in done.stdout.splitlines()])
    reference = run(short(scene, STEPS), in_process=True)
    for k, column in enumerate(references):
        assert rows[:, k].tobytes() == np.asarray(reference[column]).tobytes(), column


@pytest.mark.full
@pytest.mark.skipif(own_target() not in ("linux64", "win64"), reason="other targets have one form")
def test_both_forms_of_the_code_give_the_same_bits(built, tmp_path, monkeypatch):
    """An FMU has its code twice, for processors with AVX and for all others."""
    scene, narrow = load_scene("en50318-2002"), replace(TARGETS[own_target()], wide="")
    monkeypatch.setitem(TARGETS, own_target(), narrow)
    object_code.cache_clear()
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    object_code.cache_clear()
    recorded = [outputs_of(file, STEPS, scene.master.step) for file in (path, built("en50318-2002")[0])]
    assert recorded[0].tobytes() == recorded[1].tobytes()


def test_a_step_of_the_host_is_several_macro_steps(built):
    scene = load_scene("mass-on-spring")
    reference = run(short(scene, STEPS), in_process=True)
    recorded = outputs_of(built("mass-on-spring")[0], STEPS // 10, 10 * scene.master.step)
    assert recorded["mass.base_x"].tobytes() == np.asarray(reference["mass.base_x"])[::10].tobytes()


@pytest.mark.first
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_units_with_rates_of_their_own(algorithm, tmp_path):
    """Between the steps of a unit others take what its polynomials say."""
    changes = {"units.spring.every": 3, "master.algorithm": algorithm, "master.step": 1e-3, "master.extrapolation": 2}
    scene = load_scene("mass-on-spring").with_changes(changes)
    reference = run(short(scene, STEPS), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    recorded = outputs_of(path, STEPS - 2, 1e-3)
    assert recorded["mass.base_x"].tobytes() == np.asarray(reference["mass.base_x"])[: STEPS - 1].tobytes()


FAULTS = {
    "override and offset": [
        {"signal": "mass.base_x", "kind": "override", "value": 0.05, "begin": 0.1, "end": 0.3},
        {"signal": "spring.second_x", "kind": "offset", "value": 0.02, "begin": 0.2, "end": 0.5},
    ],
    "from the start": [
        {"signal": "spring.second_x", "kind": "drop", "end": 0.15},
        {"signal": "mass.base_velocity_x", "kind": "freeze"},
    ],
    "lost": [{"unit": "spring", "kind": "lost", "begin": 0.25}],
}


@pytest.mark.parametrize(
    ("name", "every"),
    [
        ("override and offset", 1),
        pytest.param("from the start", 1, marks=pytest.mark.full),
        pytest.param("lost", 1, marks=pytest.mark.full),
        pytest.param("lost", 3, marks=pytest.mark.full),
    ],
)
def test_faults_are_those_of_the_run_in_process(name, every, tmp_path):
    """Also where a unit that steps with every third macro step is lost."""
    scene = load_scene("mass-on-spring").with_changes({"faults": FAULTS[name], "units.spring.every": every})
    reference = run(short(scene, STEPS), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    recorded = outputs_of(path, STEPS - STEPS % every, scene.master.step)
    for column in ("mass.base_x", "spring.second_force_x"):
        assert recorded[column].tobytes() == np.asarray(reference[column])[: len(recorded)].tobytes(), column


@pytest.mark.full
def test_a_thruster_fails_in_the_fmu_as_in_process(tmp_path):
    scene = load_scene("rov-thruster-failed")
    steps = round(35.0 / scene.master.step)
    reference = run(short(scene, steps), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    recorded = outputs_of(path, steps, scene.master.step)
    for column in (n for n in recorded.dtype.names if n in reference.columns):
        assert recorded[column].tobytes() == np.asarray(reference[column]).tobytes(), column


@pytest.mark.first(2)
@pytest.mark.parametrize("changes", [{"master.extrapolation": 0}, {"master.algorithm": "jacobi"}])
def test_settings_of_the_master(changes, tmp_path):
    scene = load_scene("mass-on-spring").with_changes(changes)
    reference = run(short(scene, STEPS), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    recorded = outputs_of(path, STEPS, scene.master.step)
    assert recorded["mass.base_x"].tobytes() == np.asarray(reference["mass.base_x"]).tobytes()


def test_a_step_of_many_digits_keeps_its_time(tmp_path):
    """Steps times numerator leave what 64 bits hold; what follows the time must not jump: two seconds of a third of a millisecond."""
    h = 1e-3 / 3.0
    scene = load_scene("mass-on-spring").with_changes({"master.step": h})
    reference = run(short(scene, 6000), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    recorded = outputs_of(path, 60, 100 * h)
    assert recorded["mass.base_x"] == pytest.approx(np.asarray(reference["mass.base_x"])[::100], abs=1e-12)


INTERFACE = {
    "inputs": {"force": "mass.base_torque"},
    "outputs": {
        "x": "mass.base_x",
        "average": "mass.base_x, mean",
        "spread": "mass.base_x, standard deviation",
        "least": "mass.base_x, minimum",
        "most": "mass.base_x, maximum",
    },
}


def test_names_and_figures_of_the_interface(tmp_path):
    """Figures are those of the recorded signal behind the transient; before it those of the present value."""
    scene = load_scene("mass-on-spring").with_changes({"interface": INTERFACE, "analysis.transient": 0.05})
    reference = run(short(scene, STEPS), in_process=True)
    x, counts = np.asarray(reference["mass.base_x"]), reference.time >= 0.05 * (1.0 - 1e-12)
    files = build_scene_fmu(scene, tmp_path, [own_target()], (2, 3))
    for path in files:
        names = {v.name: v.causality for v in fmpy.read_model_description(str(path)).modelVariables}
        assert names["force"] == "input"
        assert not {"mass.base_x", "mass.base_torque"} & names.keys()
        recorded = outputs_of(path, STEPS, scene.master.step)
        assert recorded["x"].tobytes() == x.tobytes()
        first = recorded["average"][~counts]
        assert first.tobytes() == x[~counts].tobytes()
        kept = x[counts]
        last = {name: recorded[name][-1] for name in ("average", "spread", "least", "most")}
        expected = {"average": kept.mean(), "spread": kept.std(), "least": kept.min(), "most": kept.max()}
        assert last == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"inputs": {"x": "mass.base_force_x"}}, "that no connection drives; spring.second_force_x drives this one"),
        ({"inputs": {"x": "mass.base_x"}}, "expected an input of mass"),
        ({"outputs": {"x": "mass.base_w"}}, "expected an output of mass"),
        ({"outputs": {"x": "mass.base_x, mean below 5 Hz"}}, "needs the whole signal"),
        ({"outputs": {"x": "mass.base_x, end"}}, "needs the whole signal"),
        ({"outputs": {"a.b": "mass.base_x"}}, "a name of letters"),
        ({"outputs": {"time": "mass.base_x"}}, "another name"),
        ({"inputs": {"x": "mass.base_torque", "y": "mass.base_torque"}}, "one name for each input"),
        ({"inputs": {"x": "mass.base_torque"}, "outputs": {"x": "mass.base_x"}}, "names that are unique"),
    ],
)
def test_what_an_interface_cannot_be(table, message):
    with pytest.raises(BadInput, match=message):
        load_scene("mass-on-spring").with_changes({"interface": table})


def test_ports_that_stay_open_are_terminals():
    scene = read_scene(
        {
            "stop_time": 1.0,
            "units": {"left": {"component": "DeepGrooveBearing"}},
            "master": {"step": 1e-4},
            "interface": {"inputs": {"sideways": "left.displacement_x"}},
        }
    )
    ports = open_ports(scene)
    assert ports["left.shaft"][:2] == ("sideways", "left.displacement_y")
    assert open_ports(load_scene("rotor-bearings-heat")) == {}


@pytest.mark.full
def test_sixteen_rows_of_en50318_from_the_outputs_of_its_fmu(built):
    """Both speeds of the table with one FMU, whose speed is set from outside, in FMPy with a step of 1 ms."""
    rows = []
    for speed in SPEEDS:
        scene = at_speed(load_scene("en50318-2002"), speed)
        given = {"pantograph.speed": scene.units["pantograph"].parameters["speed"]}
        steps = round(scene.stop_time / scene.master.step)
        recorded = outputs_of(built("en50318-2002")[0], steps, scene.master.step, start_values=given)
        columns = {name: recorded[name] for name in recorded.dtype.names if name != "time"}
        result = replace(run(scene, in_process=True), time=recorded["time"], columns=columns)  # what else there is, describes it
        rows += compare(load_table("en50318-2002").under(condition(speed)), numbers(result))
    assert len(rows) == 16
    assert [row for row in rows if not row.inside] == []


def test_options_that_a_scene_ignores_are_refused(capsys):
    for option in (["--effects", "gravity"], ["--derivatives"]):
        assert exit_code("build", "mass-on-spring", "--native", *option) == 2
        assert option[0] in capsys.readouterr().err


def test_parameters_act_as_those_of_the_scene(built):
    scene = load_scene("mass-on-spring")
    stiffness = 3.0 * scene.units["spring"].parameters["stiffness"]
    reference = run(short(scene, STEPS, {"spring.stiffness": stiffness}), in_process=True)
    given = {"spring.stiffness": stiffness}
    recorded = outputs_of(built("mass-on-spring")[0], STEPS, scene.master.step, start_values=given)
    assert recorded["mass.base_x"].tobytes() == np.asarray(reference["mass.base_x"]).tobytes()


@pytest.mark.full
def test_force_tension_and_speed_of_en50318_set_from_outside(built):
    """The equilibrium of the wires and the initial contact follow in the FMU, with the bits of the scene that says so itself."""
    given = {"pantograph.static_force": 90.0, "catenary.contact_wire_tension": 22e3, "pantograph.speed": 60.0}
    scene = load_scene("en50318-2002")
    changes = {f"{unit}.{name}": v for key, v in given.items() for unit, name in [key.split(".")]}
    reference = run(short(scene, STEPS, changes), in_process=True)
    for path in built("en50318-2002"):
        recorded = outputs_of(path, STEPS, scene.master.step, start_values=given)
        for column in ("pantograph.contact_force", "catenary.wire_height"):
            assert recorded[column].tobytes() == np.asarray(reference[column]).tobytes(), column


@pytest.fixture
def instances(built):
    """Two initialized instances of one FMU, and what describes it."""
    path = built("mass-on-spring")[0]
    described, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    made = []
    for name in ("one", "two"):
        instance = FMU2Slave(
            guid=described.guid, unzipDirectory=folder, modelIdentifier=described.coSimulation.modelIdentifier, instanceName=name
        )
        instance.instantiate()
        instance.setupExperiment(startTime=0.0)
        instance.enterInitializationMode()
        instance.exitInitializationMode()
        made.append(instance)
    yield made, {v.name: v.valueReference for v in described.modelVariables}
    for instance in made:
        instance.terminate()
        instance.freeInstance()


def test_a_state_is_taken_back_and_goes_to_another_instance(instances):
    (one, two), references = instances
    h, wanted = load_scene("mass-on-spring").master.step, [references["mass.base_x"], references["spring.second_force_x"]]

    def steps(instance, first):
        for k in range(first, first + 20):
            instance.doStep(k * h, h)
        return instance.getReal(wanted)

    steps(one, 0)
    state = one.getFMUstate()
    data = one.serializeFMUstate(state)
    steps(two, 0)
    same = two.getFMUstate()
    assert two.serializeFMUstate(same) == data  # no address of this instance in it
    two.freeFMUstate(same)
    expected = steps(one, 20)
    one.setFMUstate(state)
    assert steps(one, 20) == expected
    other = two.deSerializeFMUstate(data)
    two.setFMUstate(other)
    assert steps(two, 20) == expected
    one.freeFMUstate(state)
    two.freeFMUstate(other)


def test_a_step_that_is_no_multiple_is_refused_with_the_macro_step(built):
    scene, said = load_scene("mass-on-spring"), []
    h, logged = 1.5 * scene.master.step, {"logger": lambda *message: said.append(message[-1])}
    assert outputs_of(built("mass-on-spring")[0], 3, h, **logged)["time"].max() == 0.0  # FMPy ends at the last successful time
    with pytest.raises(Exception, match="status"):
        outputs_of(built("mass-on-spring")[1], 3, h)
    assert any(f"expected a whole multiple of {scene.master.step!r} s" in str(text) for text in said)


ISOLATED = {"stop_time": 1.0, "units": {"own": {"component": "ServoMotor", "isolation": "process"}}, "master": {"step": 0.01}}
BETWEEN = {"signal": "mass.base_x", "kind": "freeze", "begin": 0.0125}


@pytest.mark.parametrize(
    ("scene", "named"),
    [
        (lambda: load_scene("link-split"), "'iterative'"),
        (lambda: load_scene("en50318-2002-interface-model"), "a contact"),
        (lambda: load_scene("rov-added-mass"), "algebraic loop"),
        (
            lambda: load_scene("mass-on-spring", {"faults": [BETWEEN]}),
            r"faults\[1\].begin: got 0.0125 s, expected a whole multiple",
        ),
        (lambda: read_scene(ISOLATED), "process of its own"),
    ],
)
def test_what_needs_python_or_lies_between_steps_is_named(scene, named):
    with pytest.raises(BadInput, match=named):
        scene_library(scene(), [own_target()])
