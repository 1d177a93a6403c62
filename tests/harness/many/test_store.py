"""Where points lie: repeated ones, runs that took the place of failed ones, damaged files, and what of it is in memory."""

import tracemalloc

import numpy as np
import pyarrow.dataset
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.many import files, store
from cosimo.orchestrator.harness.many.files import collect
from cosimo.orchestrator.harness.many.measures import PointResult, Task
from cosimo.orchestrator.harness.many.plan import plan_of, plan_settings
from cosimo.orchestrator.harness.many.store import Store, StoredPlan
from cosimo.orchestrator.harness.sweep import collected_sweep
from cosimo.orchestrator.run.key_results import KeyResults
from cosimo.orchestrator.settings.plan import KeepSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.systems.many import sweep
from cosimo.tests.harness.many.points import formula, scene


def written(folder, *parts):
    """A store of parts, rows of (digest, outcome); the number of a row that is done is ten times its digest."""
    rows = Store(folder)
    for part in parts:
        rows.append(
            [(k, PointResult(o, "", KeyResults({"a": 10.0 * k})) if o == "done" else PointResult(o, "once")) for k, o in part]
        )
        rows.flush()
    return rows


SCENE = read_scene(formula())


def stored(rows, *digests):
    """Points of these digests with a store."""
    plan = plan_of(SCENE, plan_settings({"vary": {"f.a": list(map(float, range(len(digests))))}}))
    points = StoredPlan(Task.of(SCENE, KeepSettings(), None), plan, rows)
    points.__dict__["digests"] = np.array(digests)
    return points


def test_a_run_that_is_done_takes_the_place_of_one_that_failed(tmp_path):
    """In whichever part it lies."""
    parts = [(4, "done"), (1, "failed"), (2, "failed")], [(1, "done")], [(9, "done"), (2, "done")]
    for rows in (written(tmp_path, *parts), Store(tmp_path)):
        points = stored(rows, 1, 2, 4, 7, 2, 9)  # 7 was not run, 2 is there twice
        assert points.missing().tolist() == [3]
        collected = collect(SCENE, points)
        np.testing.assert_array_equal(collected.measures["a"], [10.0, 20.0, 40.0, np.nan, 20.0, 90.0])
        assert collected.kinds.tolist() == ["done", "done", "done", "not run", "done", "done"]


def test_failed_points_are_missing_where_they_are_to_run_again(tmp_path):
    rows = written(tmp_path, [(1, "done"), (2, "failed")], [(3, "failed")])
    points = stored(rows, 3, 1, 2, 4)
    assert points.missing().tolist() == [3]
    assert points.missing(retry=True).tolist() == [0, 2, 3]


def test_a_part_is_written_once_and_other_tools_read_the_folder(tmp_path):
    """Two parts of as many rows that begin with the same point are two files."""
    written(tmp_path, [(1, "failed"), (2, "done")], [(1, "done"), (3, "done")], [(1, "done"), (3, "done")])
    table = pyarrow.dataset.dataset(tmp_path, format="arrow").to_table()
    assert sorted(table.column("digest").to_pylist()) == [1, 1, 2, 3]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
def test_one_flipped_byte_is_one_message_and_its_points_run_again(tmp_path, share, monkeypatch):
    monkeypatch.setattr(store, "WRITE_EVERY", np.inf)  # one file, however slow the machine is
    plan = {"vary": {"d.value": [1.0, 2.0, 3.0]}}
    first = sweep(read_scene(scene()), plan, tmp_path, verify=False)
    (part,) = tmp_path.glob("points/*/*.arrow")
    content = bytearray(part.read_bytes())
    content[int(share * (len(content) - 1))] ^= 0x10
    part.write_bytes(content)
    again = sweep(read_scene(scene()), plan, tmp_path, verify=False)
    assert again.computed == 3
    (remark,) = again.remarks
    assert f"{part.name} in {part.parent.name} was damaged" in remark
    assert again.measures["d.twice, mean"].tobytes() == first.measures["d.twice, mean"].tobytes()
    assert sweep(read_scene(scene()), plan, tmp_path, verify=False).remarks == ()


def test_a_file_that_is_damaged_later_is_one_message(tmp_path):
    rows = written(tmp_path, [(1, "done")])
    (part,) = tmp_path.glob("*.arrow")
    part.write_bytes(part.read_bytes()[:-1])
    with pytest.raises(BadInput, match="damaged"):
        stored(rows, 1).rows([0])


def test_memory_of_a_sweep_is_stays_small(tmp_path, monkeypatch):
    """In memory are columns (5 of 8 bytes here), digest, place, outcome, and what sorting takes. Pieces are smaller than the sweep,
    so that they count little."""
    monkeypatch.setattr(store, "PIECE", 2048)
    monkeypatch.setattr(files, "CHUNK", 512)
    task = Task.of(SCENE, KeepSettings(), None)
    uniform = {"distribution": "uniform", "low": 0.0, "high": 1.0}
    for n in (4096, 16384):  # the first one imports what is needed
        plan = plan_of(SCENE, plan_settings({"method": "random", "points": n, "vary": {"f.a": uniform, "f.b": uniform}}))
        rows = Store.of(task, tmp_path / str(n))
        digests = plan.digests(task.base, task.scene)
        for first in range(0, n, 1024):
            some = digests[first : first + 1024].tolist()
            rows.append([(d, PointResult("done", "", KeyResults({f"f.x{k}": float(k) for k in range(5)}))) for d in some])
            rows.flush()
        del digests
        tracemalloc.start()
        result = collected_sweep(SCENE, StoredPlan(task, plan, rows), tmp_path / str(n))
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert result.outcomes.count("done") == n
    assert peak / n < 210.0  # bytes, of which 40 are columns
