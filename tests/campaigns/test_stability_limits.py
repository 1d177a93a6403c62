"""The campaign of stability limits: what it finds, and what it calls a failing limit."""

import pytest
from cosimo import load_scene
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.campaigns.stability_limits import at_random, failing, found, row


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_runs_at_shares_of_a_limit_are_kept():
    one = found(load_scene("mass-on-spring"))
    assert float(one["limit"]) == pytest.approx(121.3)
    assert [outcome for outcome, _ in one["runs"]] == ["done", "unstable", "unstable"]
    assert row("mass-on-spring", one).startswith("| mass-on-spring | 121.3 | done, ")


def test_a_limit_fails_where_runs_disagree():
    assert failing([("unstable", 3.0), ("unstable", 9.0), ("failed", 9.0)]) == "unstable below the limit"
    assert failing([("done", 0.01), ("done", 0.02), ("unstable", 9.0)]) == "error below 5 % at 1.3 times the limit"
    assert failing([("unstable", 3.0)]) == "unstable with the longest step that was tried"
    assert not failing([("done", 0.1), ("done", 3.0), ("unstable", 9.0)])


def test_settings_at_random_are_those_of_a_seed():
    drawn = dict(at_random(["mass-on-spring", "lumped-catenary"], 6, 1))
    assert list(drawn) == list(dict(at_random(["mass-on-spring", "lumped-catenary"], 6, 1)))
    for name, scene in drawn.items():
        assert name.split(", ")[:2] == [name[:3] + scene.name, scene.master.algorithm]
        assert f"degree {scene.master.extrapolation}," in name
