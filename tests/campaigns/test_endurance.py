"""The endurance runs, in small: `python -m cosimo.tests.campaigns.endurance` makes the large ones."""

import json
import os

import pytest
from cosimo import BadInput, read_result, read_scene
from cosimo.orchestrator.run.run import run
from cosimo.tests.campaigns import endurance
from cosimo.tests.support import two_masses
from cosimo.tests.units.test_sandbox import needs_bubblewrap

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")


@pytest.mark.full
def test_rows_and_kills(tmp_path):
    seen = endurance.rows(20_000, tmp_path / "rows")
    assert (seen["findings"], seen["rows"]) == ([], 20_001)
    assert seen["checkpoint bytes"] < 20_000
    assert endurance.kills(3, tmp_path / "kills", 5)["findings"] == []


@pytest.mark.full
def test_three_processes_build_at_once(tmp_path):
    assert endurance.builds(1, tmp_path, compiled=False)["findings"] == []


@posix
@needs_bubblewrap
@pytest.mark.full
@pytest.mark.parametrize("troubles", [(1, 3), (18, 24)])
def test_ill_behaved_fmus_end_as_documented(troubles, tmp_path):
    seen = endurance.foreign(1, tmp_path, troubles)
    assert seen["findings"] == []
    assert all("exit code" in outcome["in a sandbox"] for outcome in seen["outcomes"].values())


def test_a_run_that_failed_before_its_first_row_can_be_read(tmp_path):
    """Seen with FMUs that crash in their initialization: the directory was refused as none of a run."""
    scene = read_scene({**two_masses("jacobi", 0.05, 1), "stop_time": 1.0})
    run(scene, output=tmp_path)
    (tmp_path / "result.parquet").unlink()
    with pytest.raises(BadInput, match="No such file"):  # it says that it is whole
        read_result(tmp_path)
    info = json.loads((tmp_path / "run.json").read_text())
    (tmp_path / "run.json").write_text(json.dumps(info | {"outcome": "failed"}))
    again = read_result(tmp_path)
    assert (again.outcome, again.rows, dict(again.columns)) == ("failed", 0, {})
