"""Points whose units are opened once: every number is that of a scene which is read and opened for the point alone."""

import random
import threading
from itertools import chain

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import Kind
from cosimo.orchestrator.harness.many.execute import by_threads
from cosimo.orchestrator.harness.many.measures import Task
from cosimo.orchestrator.harness.many.point_runs import PointRuns, only_kernels, row_of
from cosimo.orchestrator.harness.many.store import table_of
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings.plan import KeepSettings
from cosimo.orchestrator.systems import load_scene, read_scene, summary
from cosimo.orchestrator.systems.many import run_many, sweep
from cosimo.tests.harness.many.points import scene as doubler
from cosimo.tests.short_run import covering_scenes, full_but

STEPS = 40
FACTORS = (1.03, 0.9, 1e9)  # the last one is refused, fails or grows without bound in many scenes: the next point must not notice
SPRING = {"stop_time": 0.2}


def short(name, **more):
    """A shipped scene of a few steps."""
    scene = load_scene(name)
    return scene.with_changes({"stop_time": STEPS * scene.master.step, "analysis.transient": 0.0} | more)


def task_of(scene):
    return Task.of(scene, KeepSettings(), summary)


def content(get):
    """All that a run gives but its timing; of a refusal its text."""
    try:
        result = get()
    except BadInput as error:
        return str(error)
    info = {key: str(value) for key, value in vars(result.info).items() if key != "timing"}
    columns = {name: column.tobytes() for name, column in result.columns.items()}
    return result.outcome, result.message, result.time.tobytes(), columns, info


@pytest.mark.parametrize("name", full_but(("mass-on-spring",), dict.fromkeys(("mass-on-spring", *covering_scenes()))))
def test_a_point_has_the_bits_of_a_run_of_its_own(name):
    """Scenes with every component and algorithm: that a start follows from nothing before it, whatever is on, the contract shows."""
    runs = PointRuns(task := task_of(short(name)))
    if (open_scene := runs.open_scene({})) is None:
        pytest.skip("needs Python in a step")
    numbers = [
        (f"{unit}.{parameter}", value)
        for unit, simulator in open_scene.units.items()
        for parameter, value in simulator.component.parameters.items()
        if value and (known := type(simulator.component).variables[parameter]).kind is Kind.REAL and not known.structural
    ]
    for parameter, value in random.Random(name).sample(numbers, min(4, len(numbers))):
        for factor in FACTORS:
            point = {parameter: factor * value}
            own = content(lambda: run(runs.scene.with_changes(point), in_process=True))  # noqa: B023
            assert content(lambda: runs.result(point)) == own, point  # noqa: B023
            row = row_of(lambda: run(runs.scene.with_changes(point), in_process=True), task)  # noqa: B023
            assert table_of([(0, runs.row(point))]).equals(table_of([(0, row)]), check_metadata=True), point
    assert runs.open_scene({}) is open_scene
    runs.close()


def test_units_are_opened_once_for_all_points_of_the_same_effects(monkeypatch):
    opened = []
    begin = PointRuns.open_scene
    monkeypatch.setattr(PointRuns, "open_scene", lambda self, changed: opened.append(begin(self, changed)) or opened[-1])
    scene = short("mass-on-spring")
    vary = {"master.step": [1e-2, 5e-3], "spring.stiffness": [80.0, 90.0, 100.0, 110.0]}
    result = sweep(scene, {"vary": vary}, verify=False)
    assert set(result.outcomes) == {"done"}
    assert len({id(one) for one in opened if one is not None}) <= 3  # of each macro step, and of the scene itself
    assert len(set(result.measures["mass.base_x, maximum"].tolist())) == 8


def test_threads_give_the_same_rows_and_end_where_their_caller_leaves_them():
    scene = short("mass-on-spring", stop_time=2.0)
    task = task_of(scene)
    threads = [PointRuns(task) for _ in range(3)]
    assert only_kernels(task, threads[0])
    points = [(k, {"spring.stiffness": 50.0 + k}) for k in range(12)]
    rows = dict(chain.from_iterable(by_threads(threads, iter(points))))
    for k, values in points:
        assert table_of([(k, rows[k])]).equals(table_of([(k, threads[0].row(values))]), check_metadata=True)
    task = task_of(scene.with_changes({"stop_time": 1e5}))
    endless = [PointRuns(task) for _ in range(2)]
    left = by_threads(endless, iter(points))
    assert next(left) == []  # a look at signals
    left.close()
    assert not [t for t in threading.enumerate() if t.name.startswith("cosimo-point")]
    for runs in threads + endless:
        runs.close()


def test_scenes_that_need_python_in_a_step_run_in_processes():
    for scene in (read_scene(doubler()), load_scene("jaw-crusher")):
        assert not only_kernels(task_of(scene), PointRuns(task_of(scene)))


def test_a_table_of_points_in_python():
    scene = load_scene("mass-on-spring").with_changes(SPRING)
    stiffness = np.array([90.0, 100.0, 110.0])
    result = run_many(scene, {"spring.stiffness": stiffness}, threads=2)
    assert result.varied["spring.stiffness"].tolist() == stiffness.tolist()
    alone = [run(scene.with_changes({"spring.stiffness": k}), in_process=True) for k in stiffness.tolist()]
    assert result.measures["mass.base_x, maximum"].tolist() == [one["mass.base_x"].max() for one in alone]
    with pytest.raises(BadInput, match="lists of one length"):
        run_many(scene, {"spring.stiffness": [90.0, 100.0], "spring.damping": [1.0]})
