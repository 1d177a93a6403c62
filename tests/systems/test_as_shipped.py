"""Every shipped scene and case once by its command, with the default packaging and its report, as a reader of the README does."""

import json

import pytest
from cosimo.orchestrator.cli import main
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import cases

UNDECIDED = ("passed", "recalled", "undecided")


def done(command, name, folder):
    """Whether a command ends with exit code 0, which a row outside of its range is not."""
    with pytest.raises(SystemExit) as end:
        main([command, name, "-o", str(folder)])
    assert end.value.code == 0


@pytest.mark.full
@pytest.mark.parametrize("name", sorted(scene_files()))
def test_a_scene_runs_by_its_command(name, tmp_path, capsys):
    done("run", name, tmp_path)
    assert (tmp_path / "report.html").stat().st_size > 10_000
    info = json.loads((tmp_path / "run.json").read_text())
    assert info["outcome"] == "done"
    assert info["verification"]["done"], info["verification"]
    printed = capsys.readouterr()
    assert "Traceback" not in printed.out + printed.err


@pytest.mark.full
@pytest.mark.parametrize("name", sorted(cases()))
def test_a_case_is_validated_by_its_command(name, tmp_path, capsys):
    done("validate", name, tmp_path)
    assert (tmp_path / "report.html").stat().st_size > 10_000
    (case,) = json.loads((tmp_path / "validation.json").read_text())["cases"]
    assert case["outcome"] in UNDECIDED, case["verdict"]
    assert "Traceback" not in capsys.readouterr().err
