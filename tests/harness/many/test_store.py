"""Where points lie: repeated ones, runs that took the place of failed ones, and what of it is in memory."""

import tracemalloc

import numpy as np
from cosimo.orchestrator.harness.many import store
from cosimo.orchestrator.harness.many.batches import write_part
from cosimo.orchestrator.harness.many.measures import Row
from cosimo.orchestrator.harness.many.plan import plan_of, plan_settings
from cosimo.orchestrator.harness.sweep import collected_sweep
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.harness.many.points import formula


def test_a_run_that_is_done_takes_the_place_of_one_that_failed(tmp_path):
    """In whichever part it lies."""
    write_part(tmp_path, [(k, Row("failed", "once") if k < 3 else Row("done", "", {"a": 10.0 * k})) for k in (4, 1, 2)])
    write_part(tmp_path, [(k, Row("done", "", {"a": 10.0 * k})) for k in (1,)])
    write_part(tmp_path, [(k, Row("done", "", {"a": 10.0 * k})) for k in (9, 2)])
    digests = np.array([1, 2, 4, 7, 2, 9])  # 7 was not run, 2 is there twice
    located = store.locate_points(tmp_path, digests)
    assert located.missing.tolist() == [3]
    collected = store.collect(located, tmp_path)
    np.testing.assert_array_equal(collected.numbers["a"], [10.0, 20.0, 40.0, np.nan, 20.0, 90.0])
    failed = store.locate_points(tmp_path, np.array([1, 2, 4, 5]), retry=True)
    assert failed.missing.tolist() == [3]


def test_memory_of_a_sweep_is_stays_small(tmp_path, monkeypatch):
    """Columns lie in files; in memory are digest, place, outcome, and what sorting takes. Pieces are smaller than
    the sweep, so that they count little."""
    for name, value in {"CHUNK": 512, "PIECE": 2048, "LARGEST_PIECE": 0}.items():
        monkeypatch.setattr(store, name, value)
    scene = read_scene(formula())
    uniform = {"distribution": "uniform", "low": 0.0, "high": 1.0}
    for n in (4096, 16384):  # the first one imports what is needed
        plan = plan_of(scene, plan_settings({"method": "random", "points": n, "vary": {"f.a": uniform, "f.b": uniform}}))
        digests = plan.digests("base")
        folder = store.points_folder(tmp_path / str(n), "base")
        for first in range(0, n, 1024):
            write_part(
                folder,
                [(int(d), Row("done", "", {f"f.x{k}": float(k) for k in range(5)})) for d in digests[first : first + 1024]],
            )
        del digests
        tracemalloc.start()
        result = collected_sweep(scene, plan, tmp_path / str(n), "base")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert result.outcomes.count("done") == n
    assert peak / n < 130.0  # bytes; 169 where outcomes were texts and the data set was written in one piece
