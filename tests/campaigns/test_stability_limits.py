"""The campaign of stability limits: what it finds, and what it calls a failing limit."""

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.campaigns.stability_limits import failing, found, row


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_runs_at_shares_of_a_limit_are_kept():
    one = found("mass-on-spring")
    assert float(one["limit"]) == pytest.approx(121.3)
    assert [outcome for outcome, _ in one["runs"]] == ["done", "unstable", "unstable"]
    assert row("mass-on-spring", one).startswith("| mass-on-spring | 121.3 | done, ")


def test_a_limit_fails_where_runs_disagree():
    assert failing([("unstable", 3.0), ("unstable", 9.0), ("failed", 9.0)]) == "unstable below the limit"
    assert failing([("done", 0.01), ("done", 0.02), ("unstable", 9.0)]) == "error below 5 % at 1.3 times the limit"
    assert not failing([("done", 0.1), ("done", 3.0), ("unstable", 9.0)])
