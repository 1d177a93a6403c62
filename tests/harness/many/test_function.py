"""A scene as a function: its numbers are those of runs, a point costs little more than its steps, and what fails is NaN."""

import pickle
import sys

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus.build import build
from cosimo.orchestrator.systems import load_scene, read_scene, run, summary
from cosimo.orchestrator.systems.many import function
from cosimo.tests.harness.many.points import scene as doubler

X = "mass.base_x, maximum"
LARGEST = ["mass.base_x, maximum", "mass.base_x, mean"]
WINDOW = {"stop_time": 1.0, "analysis.transient": 0.0, "analysis.spans": None, "analysis.window": [40.0, 90.0]}


@pytest.fixture(scope="module")
def scene():
    return load_scene("mass-on-spring").with_changes({"stop_time": 0.5})


def expected(scene, **parameters):
    """Largest and mean position of a run of its own."""
    x = run(scene.with_changes({f"units.spring.parameters.{n}": v for n, v in parameters.items()}), in_process=True, verify="no")
    return [x["mass.base_x"].max(), x["mass.base_x"].mean()]


def test_numbers_are_those_of_runs_at_one_point_or_at_many(scene):
    points = np.array([[80.0, 1.0], [120.0, 3.0], [100.0, 2.0], [90.0, 0.0], [110.0, 5.0]])
    runs = np.array([expected(scene, stiffness=k, damping=c) for k, c in points.tolist()])
    with function(scene, ["spring.stiffness", "spring.damping"], LARGEST, threads=2) as f:
        assert f.parameters == ("spring.stiffness", "spring.damping")
        assert f.start.tolist() == [100.0, 4.0]
        assert f.units == ("m", "m")  # before the first call
        assert [f(x).tolist() for x in points] == runs.tolist()
        assert f(points).tolist() == runs.tolist()
        again = pickle.loads(pickle.dumps(f))
        assert again(points[0]).tolist() == runs[0].tolist()
        again.close()


def test_a_single_name_has_no_axis_and_units_are_those_of_the_name(scene):
    whole = [expected(scene, stiffness=k)[0] for k in (90.0, 110.0)]
    with function(scene, "spring.stiffness [kN/m]", X) as f:
        assert f.start == 0.1
        assert f(0.09) == whole[0]
        assert f([0.09, 0.11]).tolist() == whole
        assert isinstance(f(0.09), float)


def test_figures_of_a_system_are_those_of_its_summary():
    scene = load_scene("en50318-2002").with_changes(WINDOW)
    changed = scene.with_changes({"units.pantograph.parameters.static_force": 110.0})
    of_run = {row.name: row.value for row in summary(run(changed, in_process=True, verify="no"))}
    with function(scene, ["pantograph.static_force"], ["pantograph.mean", "pantograph.std"]) as f:
        assert f([110.0]).tolist() == [of_run["pantograph.mean"], of_run["pantograph.std"]]


def test_a_point_that_fails_is_nan_with_its_reason_and_the_next_one_is_whole(scene):
    with function(scene, ["spring.stiffness", "spring.damping"], LARGEST, threads=2) as f:
        whole = f(f.start).tolist()
        assert f.reason == ""
        assert np.isnan(f([1e12, 1.0])).all()
        assert "has grown to" in f.reason
        assert np.isnan(f([-1.0, 1.0])).all()
        assert "expected a value in [0, inf] N/m" in f.reason
        assert np.isnan(f([np.nan, 1.0])).all()
        y = f([f.start, [1e12, 1.0], f.start])
        assert y[0].tolist() == y[2].tolist() == whole
        assert np.isnan(y[1]).all()
        assert [bool(reason) for reason in f.reasons] == [False, True, False]


@pytest.mark.parametrize(
    ("parameters", "figures", "said"),
    [
        (["spring.stifness"], [X], "'spring.stifness', .*Did you mean 'stiffness'"),
        (["sprng.stiffness"], [X], "Did you mean 'spring'"),
        (["spring.stiffness [s]"], [X], "a unit of the dimension of N/m"),
        (["mass.base_x"], [X], "a parameter that is a number, or an input that nothing drives"),
        (["spring.first_position_x"], [X], "expected a parameter, an input"),
        (["spring.stiffness", "spring.stiffness"], [X], "each name once"),
        (["spring.stiffness"], ["mass.base_x, maxmum"], "Did you mean 'maximum'"),
        (["spring.stiffness"], ["mass.base_z, maximum"], "Did you mean 'mass.base_y'"),
        (["spring.stiffness"], ["mass.maximum"], "expected a figure of summary.json"),
        ([], [X], "one or more of both"),
    ],
)
def test_a_wrong_name_is_one_message_at_once(scene, parameters, figures, said):
    with pytest.raises(BadInput, match=said):
        function(scene, parameters, figures)


def test_a_wrong_figure_of_a_system_is_found_by_one_run():
    scene = load_scene("en50318-2002").with_changes(WINDOW)
    with pytest.raises(BadInput, match=r"Did you mean 'pantograph.mean'"):
        function(scene, ["pantograph.static_force"], ["pantograph.mena"])


def test_an_array_of_another_shape_and_a_call_behind_the_end_are_refused(scene):
    f = function(scene, ["spring.stiffness", "spring.damping"], X)
    for wrong in ([1.0], [[1.0, 2.0, 3.0]], 1.0, np.zeros((1, 1, 2))):
        with pytest.raises(BadInput, match=r"\(2,\) or \(n, 2\)"):
            f(wrong)
    f.close()
    with pytest.raises(BadInput, match="function that is closed"):
        f(f.start)


def test_units_that_need_python_are_opened_anew():
    with function(read_scene(doubler()), ["d.value"], ["d.twice, maximum"]) as f:
        assert f([f.start, 2.0 * f.start]).tolist() == [[2.0], [4.0]]


@pytest.mark.full
def test_an_fmu_is_opened_anew(tmp_path):
    fmu = build("CompliantJoint", tmp_path)
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.05})
    with_fmu = scene.with_changes({"units.spring.component": "", "units.spring.fmu": str(fmu)})
    with function(with_fmu, ["spring.stiffness"], LARGEST) as f:
        assert f([[90.0], [120.0]]).tolist() == [expected(scene, stiffness=90.0), expected(scene, stiffness=120.0)]


def calls_of(work):
    """How many functions of Python a piece of work calls."""
    calls = 0

    def count(frame, event, argument):
        nonlocal calls
        calls += event == "call"

    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(None)
    return calls


def test_what_a_point_costs_beside_its_steps_does_not_grow_with_them(scene):
    counted = []
    for stop in (0.5, 5.0):
        with function(scene.with_changes({"stop_time": stop}), ["spring.stiffness"], X, threads=1) as f:
            f([90.0])
            counted.append(calls_of(lambda: f([95.0])))
    assert counted[1] < counted[0] + 200
    assert counted[1] < 800  # about 500; a run that is opened makes 20 000
