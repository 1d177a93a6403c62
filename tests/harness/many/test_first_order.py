"""Samples by first order: what derivatives predict where runs agree, and all runs where they do not."""

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.harness.many.point_runs import PointRuns

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
QUANTITY = "mass.base_x, maximum"
PLAN = {"method": "sobol", "points": 128}


def varied(share):
    scene = cosimo.load_scene("mass-on-spring").with_changes({"stop_time": 0.5})
    mean, deviation = 100.0, share * 100.0
    vary = {
        "spring.stiffness": {"distribution": "normal", "mean": mean, "deviation": deviation},
        "mass.mass": {"distribution": "uniform", "low": 1.0 - share, "high": 1.0 + share},
    }
    return scene, {**PLAN, "vary": vary}


@pytest.fixture
def runs(monkeypatch):
    """Points that are run, each time."""
    counted = []
    row = PointRuns.row

    def counting(self, values):
        counted.append(values)
        return row(self, values)

    monkeypatch.setattr(PointRuns, "row", counting)
    return counted


def test_little_uncertainty_takes_few_runs_and_gives_the_distribution_of_all(runs):
    scene, plan = varied(0.002)
    short = cosimo.uncertainty(scene, plan, quantities=[QUANTITY], verify=False)
    few = len(runs)
    whole = cosimo.uncertainty(scene, plan, quantities=[QUANTITY], verify=False, first_order=False)
    assert few <= 5
    assert len(runs) - few == 128
    assert short.origin == f"128 samples by first order, {few} of them run"
    (a,), (b,) = short.spreads, whole.spreads
    assert a.count == b.count == 128
    assert a.deviation == pytest.approx(b.deviation, rel=0.02)
    np.testing.assert_allclose(a.percentiles, b.percentiles, atol=0.05 * b.deviation)


def test_where_first_order_leaves_out_much_all_samples_are_run(runs, tmp_path):
    scene, plan = varied(0.3)
    answer = cosimo.uncertainty(scene, plan, tmp_path, quantities=[QUANTITY], verify=False)
    whole = cosimo.uncertainty(scene, plan, quantities=[QUANTITY], verify=False, first_order=False)
    assert answer.origin == "128 samples"
    assert "all samples were run" in answer.messages[0]
    assert answer.spreads == whole.spreads
    assert len(runs) == 2 * 128  # those that judged first order are not run again


def test_few_samples_and_choices_are_run(runs):
    scene, plan = varied(0.002)
    answer = cosimo.uncertainty(scene, {**plan, "points": 16}, quantities=[QUANTITY], verify=False)
    assert (answer.origin, len(runs)) == ("16 samples", 16)
    plan["vary"]["mass.mass"] = [1.0, 1.001]
    assert cosimo.uncertainty(scene, plan, quantities=[QUANTITY], verify=False).origin == "128 samples"


def test_limits_count_predicted_samples():
    scene, plan = varied(0.002)
    middle = cosimo.uncertainty(scene, plan, quantities=[QUANTITY], verify=False).spreads[0].percentiles[2]
    answer = cosimo.uncertainty(scene, {**plan, "limits": {QUANTITY: {"high": middle}}}, verify=False)
    assert (answer.limits[0].count, answer.limits[0].inside) == (128, 64)
