"""Failed points are told in groups: how many failed alike, and what distinguishes them from those that are done."""

from __future__ import annotations

import numpy as np
import pytest
from cosimo.orchestrator.cli import main
from cosimo.orchestrator.harness.many.failures import failure_groups

SPEED = np.array([50.0, 60.0, 70.0, 80.0, 90.0])


def test_failures_alike_but_for_their_numbers_are_one_group():
    outcomes = ["done", "done", "unstable at t = 1.5 s", "unstable at t = 1.25e-1 s", "not run"]
    (sentence,) = failure_groups(outcomes, {"pantograph.speed": SPEED})
    assert sentence == ("2 of 5 points failed, all with pantograph.speed of at least 70: such as: unstable at t = 1.5 s")


def test_the_most_frequent_kind_comes_first_and_choices_are_named():
    outcomes = ["other", "same", "same", "done", "done"]
    varied = {"speed": SPEED[::-1], "preset": np.array(["b", "a", "a", "c", "c"]), "constant": np.ones(5)}
    first, second = failure_groups(outcomes, varied)
    assert first == "2 of 5 points failed, all with speed of at least 70 and preset = a: same"
    assert second.startswith("1 of 5 points failed, all with speed of at least 90 and preset = b: other")


def test_where_nothing_is_done_nothing_is_in_common():
    assert failure_groups(["same"] * 3, {"speed": SPEED[:3]}) == ["3 of 3 points failed: same"]
    assert failure_groups(["done", "not run"], {"speed": SPEED[:2]}) == []


@pytest.mark.parametrize("text", ["stop_time=3", "master.step=1e-4", "master.algorithm=jacobi"])
def test_what_has_an_option_of_its_own_is_told_so(text, capsys):
    with pytest.raises(SystemExit) as end:
        main(["sweep", "mass-on-spring", "--over", "mass.mass=1:2:2", "--set", text])
    assert end.value.code == 2
    place, _, value = text.partition("=")
    option = {"stop_time": "--stop", "master.step": "--step", "master.algorithm": "--algorithm"}[place]
    assert f"expected {option} {value}" in capsys.readouterr().err


@pytest.mark.full
def test_a_sweep_takes_a_step_and_an_end(tmp_path, capsys):
    out = str(tmp_path / "out")
    with pytest.raises(SystemExit) as end:
        main(
            ["sweep", "mass-on-spring", "--over", "mass.mass=1:2:2", "--stop", "0.1", "--step", "0.01", "-o", out, "--jobs", "1"]
        )
    assert end.value.code == 0
    assert "0 failed" in capsys.readouterr().out
