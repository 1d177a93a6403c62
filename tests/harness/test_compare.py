"""Runs beside one another: what differs is found and sized, what is the same is not, and errors are taken into account."""

import json

import cosimo
import numpy as np
import pytest
from cosimo import BadInput
from cosimo.orchestrator.harness.compare import Comparison, FigureDifference
from cosimo.tests.commands import exit_code

SHORT = {"stop_time": 2.0}


@pytest.fixture(scope="module")
def scene():
    return cosimo.load_scene("mass-on-spring").with_changes(SHORT)


@pytest.fixture(scope="module")
def two(scene, tmp_path_factory):
    """Directories of two runs: the second with a spring that is four times as stiff, which ends earlier."""
    folder = tmp_path_factory.mktemp("runs")
    other = scene.with_changes({"spring.stiffness": 400.0, "stop_time": 1.0})
    for name, one in (("soft", scene), ("stiff", other)):
        cosimo.run(one, in_process=True, verify="no", output=folder / name)
    return folder / "soft", folder / "stiff"


def figure(values, errors=(np.nan, np.nan)):
    return FigureDifference("m.x", "m", "place", np.array(values), np.array(errors))


def command(arguments, capsys):
    end = exit_code("compare", *map(str, arguments))
    return end, capsys.readouterr()


def test_settings_and_signals_that_differ(two):
    comparison = cosimo.compare(*two)
    assert comparison.names == ("soft", "stiff")
    assert comparison.settings == {"spring.stiffness": ("100", "400"), "stop_time": ("2", "1")}
    first, second = comparison.results
    n = second.time.size
    gap = second["mass.base_x"] - first["mass.base_x"][:n]
    by_name = {one.name: one for one in comparison.signals}
    assert set(by_name) == {"mass.base_x", "mass.base_velocity_x", "spring.second_force_x"}
    # the scale is the deviation of the other run, see run.comparison
    assert by_name["mass.base_x"].rms[0] == pytest.approx(np.sqrt(np.mean(gap**2)) / second["mass.base_x"].std())
    assert "stiffness: 100 | 400" in repr(comparison)


def test_a_run_does_not_differ_from_itself(scene, two):
    again = cosimo.compare(two[0], cosimo.run(scene, in_process=True, verify="no"))
    assert not again.settings
    assert [one.share for one in again.signals] == [0.0] * 3
    assert again.beyond(1e-6) == []
    assert cosimo.compare(two[0], two[0]).names == ("soft (1)", "soft (2)")


def test_errors_say_what_a_difference_is_worth():
    assert figure([2.0, 2.2]).share == pytest.approx(0.1 / 1.1)
    assert not figure([2.0, 2.2]).within_errors
    assert figure([2.0, 2.2], [0.1, 0.11]).within_errors
    assert not figure([2.0, 2.2], [0.1, 0.09]).within_errors
    assert figure([0.0, 0.0]).share == 0.0
    assert np.isnan(figure([2.0, np.nan]).share)
    comparison = Comparison((), (), (figure([2.0, 2.2], [0.1, 0.1]), figure([1.0, np.nan])), (), {}, (), ())
    assert comparison.undecided(0.05) == ["m.x"]  # 0.2 apart, 0.11 allowed, 0.2 unsure
    assert comparison.undecided(0.5) == []
    for errors in ([0.2, np.nan, 0.0], [np.nan, 0.0, 0.2], [0.1, 0.1, np.nan]):  # those that are known count, wherever they stand
        one = figure([2.0, 2.2, 2.1], errors)
        assert Comparison((), (), (one,), (), {}, (), ()).undecided(0.05) == ["m.x"]
    assert figure([2.0, 2.1], [0.2, np.nan]).within_errors
    assert not figure([2.0, 2.1], [0.05, np.nan]).within_errors
    assert comparison.beyond(0.05) == ["m.x by 9.1 %", "m.x: only some runs have it"]


def test_the_command_and_its_files(two, tmp_path, capsys):
    code, said = command([*two, "--within", "1%", "-o", tmp_path], capsys)
    assert code == 1
    assert "more than 1% apart" in said.err
    assert "spring.stiffness" in said.out
    stored = json.loads((tmp_path / "compare.json").read_text())
    assert stored["settings"]["stop_time"] == ["2", "1"]
    page = (tmp_path / "report.html").read_text()
    assert "Differences from soft" in page
    code, said = command([two[0], two[0], "--within", "1%", "--json"], capsys)
    assert (code, json.loads(said.out)["beyond"]) == (0, [])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["mass-on-spring"], "1 run, expected at least two"),
        (["mass-on-spring", "nowhere"], "'nowhere', expected a shipped scene"),
        (["{0}", "{1}", "--within", "1%", "--signal", "mass.x"], "'mass.x', expected a recorded signal of all runs"),
        (["{0}", "{1}", "--signal", "mass.base_x"], "no effect without --within"),
        (["{0}", "{1}", "--within", "3"], "a share with its percent sign"),
    ],
)
def test_bad_input_is_one_message(arguments, message, two, capsys):
    code, said = command([text.format(*two) for text in arguments], capsys)
    assert code == 2
    assert message in said.err
    assert said.err.count("\n") == 1


def test_runs_of_other_scenes_have_nothing_in_common(two):
    with pytest.raises(BadInput, match="no common signal"):
        cosimo.compare(
            two[0], cosimo.load_scene("ball-bearing-clearance").with_changes({"stop_time": 0.01, "analysis.transient": 0.0})
        )
