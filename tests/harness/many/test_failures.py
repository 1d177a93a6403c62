"""Failed points are told in groups: how many failed alike, and why."""

from __future__ import annotations

import pytest
from cosimo.orchestrator.harness.many.failures import failure_groups
from cosimo.tests.commands import exit_code


def test_failures_alike_but_for_their_numbers_are_one_group_and_the_most_frequent_comes_first():
    outcomes = ["other", "done", "unstable at t = 1.5 s", "unstable at t = 1.25e-1 s", "not run"]
    assert failure_groups(outcomes) == ["2 of 5 points failed: such as: unstable at t = 1.5 s", "1 of 5 points failed: other"]
    assert failure_groups(["same"] * 3) == ["3 of 3 points failed: same"]
    assert failure_groups(["done", "not run"]) == []


@pytest.mark.parametrize("text", ["stop_time=3", "master.step=1e-4", "master.algorithm=jacobi"])
def test_what_has_an_option_of_its_own_is_told_so(text, capsys):
    assert exit_code("sweep", "mass-on-spring", "--over", "mass.mass=1:2:2", "--set", text) == 2
    place, _, value = text.partition("=")
    option = {"stop_time": "--stop", "master.step": "--step", "master.algorithm": "--algorithm"}[place]
    assert f"expected {option} {value}" in capsys.readouterr().err


@pytest.mark.full
def test_a_sweep_takes_a_step_and_an_end(tmp_path, capsys):
    out = str(tmp_path / "out")
    assert (
        exit_code(
            "sweep", "mass-on-spring", "--over", "mass.mass=1:2:2", "--stop", "0.1", "--step", "0.01", "-o", out, "--jobs", "1"
        )
        == 0
    )
    assert "0 failed" in capsys.readouterr().out
