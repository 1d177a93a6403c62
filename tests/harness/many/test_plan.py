"""Plans: which points they give, against closed forms, and how they are refused."""

import re

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli.options import ranges_of
from cosimo.orchestrator.harness.many.plan import from_columns, plan_of, plan_settings, quantile
from cosimo.orchestrator.settings.plan import Distribution
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.harness.test_sweep import MASS
from scipy.stats import truncnorm

SCENE = read_scene(MASS)
UNIFORM = {"distribution": "uniform", "low": 100.0, "high": 900.0}
NORMAL = {"distribution": "normal", "mean": 2.0, "deviation": 0.1}
TRIANGULAR = {"distribution": "triangular", "low": 1.0, "mode": 2.0, "high": 4.0}


def planned(**settings):
    return plan_of(SCENE, plan_settings(settings))


def test_a_grid_has_every_combination_and_a_list_its_lines():
    vary = {"m.k": [100.0, 400.0], "m.m": {"from": 1.0, "to": 3.0, "points": 3}}
    grid = planned(vary=vary)
    assert [tuple(grid.values(i).values()) for i in range(grid.size)] == [(k, m) for k in (100.0, 400.0) for m in (1.0, 2.0, 3.0)]
    line = planned(method="list", vary={"m.k": [100.0, 400.0], "m.m": [1.0, 3.0]})
    assert [line.values(i) for i in range(line.size)] == [{"m.k": 100.0, "m.m": 1.0}, {"m.k": 400.0, "m.m": 3.0}]
    assert from_columns({"m.k": np.array([1.0, 2.0])}) == {"method": "list", "vary": {"m.k": [1.0, 2.0]}}


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol", "random"])
def test_samples_have_their_distributions(method):
    """Moments by closed forms; the tolerance is five standard errors of independent samples."""
    n = 4096
    plan = planned(method=method, points=n, seed=5, vary={"m.k": UNIFORM, "m.m": TRIANGULAR, "m.v0": NORMAL})
    for name, mean, variance in (
        ("m.k", 500.0, 800.0**2 / 12.0),
        ("m.v0", 2.0, 0.01),
        ("m.m", 7.0 / 3.0, (1.0 + 4.0 + 16.0 - 2.0 - 4.0 - 8.0) / 18.0),
    ):
        x = plan.columns[name].numbers
        assert abs(x.mean() - mean) < 5.0 * np.sqrt(variance / n)
        assert abs(x.var() / variance - 1.0) < 5.0 * np.sqrt(2.0 / n)
    assert (plan.columns["m.m"].numbers >= 1.0).all()
    assert (plan.columns["m.m"].numbers <= 4.0).all()
    again = planned(method=method, points=n, seed=5, vary={"m.k": UNIFORM, "m.m": TRIANGULAR, "m.v0": NORMAL})
    assert all(np.array_equal(plan.columns[c].numbers, again.columns[c].numbers) for c in plan.columns)
    other = planned(method=method, points=n, seed=6, vary={"m.k": UNIFORM})
    assert not np.array_equal(plan.columns["m.k"].numbers, other.columns["m.k"].numbers)


def test_every_stratum_of_a_latin_hypercube_has_one_point():
    x = planned(method="latin-hypercube", points=50, vary={"m.k": UNIFORM}).columns["m.k"].numbers
    assert np.array_equal(np.sort(((x - 100.0) / 16.0).astype(int)), np.arange(50))


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_more_points_go_on_behind_the_first_ones(method):
    few, many = (planned(method=method, points=n, seed=2, vary={"m.k": UNIFORM}).columns["m.k"].numbers for n in (64, 128))
    assert np.array_equal(few, many[:64])


def test_normal_scores_have_the_correlation_of_the_plan():
    """Standard error of a correlation r of n points: (1 - r²) / √n."""
    n, r = 8192, -0.7
    plan = planned(method="random", points=n, vary={"m.m": NORMAL, "m.v0": NORMAL}, correlation=[["m.m", "m.v0", r]])
    a, b = (plan.columns[c].numbers for c in ("m.m", "m.v0"))
    assert abs(np.corrcoef(a, b)[0, 1] - r) < 5.0 * (1.0 - r * r) / np.sqrt(n)
    with pytest.raises(BadInput, match="positive definite"):
        planned(
            method="random",
            points=8,
            vary={"m.m": NORMAL, "m.v0": NORMAL, "m.k": UNIFORM},
            correlation=[["m.m", "m.v0", 0.9], ["m.v0", "m.k", 0.9], ["m.m", "m.k", -0.9]],
        )


def test_a_normal_distribution_is_cut_off_where_the_plan_says():
    """Mean of a standard normal cut off below its mean: the half-normal's sqrt(2 / pi)."""
    x = planned(method="sobol", points=4096, vary={"m.m": NORMAL | {"low": 2.0}}).columns["m.m"].numbers
    assert x.min() >= 2.0
    assert x.mean() == pytest.approx(2.0 + 0.1 * np.sqrt(2.0 / np.pi), rel=1e-3)


@pytest.mark.parametrize(("low", "high"), [(8.0, 9.0), (8.0, np.inf), (-9.0, -8.0), (30.0, 31.0)])
def test_ends_far_from_the_mean_keep_the_shape_of_the_distribution(low, high):
    """Against `scipy.stats.truncnorm`: quantiles 8 deviations above the mean were multiples of the spacing of 1, or infinite."""
    u = np.linspace(0.01, 0.99, 7)
    far = Distribution("normal", low, high)
    assert quantile(far, u) == pytest.approx(truncnorm.ppf(u, low, high), rel=1e-13)


def test_values_from_a_table_with_and_without_units(tmp_path):
    (tmp_path / "points.csv").write_text('"m.k, N/m",m.m\n100,1\n400.5,2.5\n')
    (tmp_path / "plan.toml").write_text('method = "list"\ntable = "points.csv"\n')
    plan = plan_of(SCENE, plan_settings(tmp_path / "plan.toml"))
    assert [plan.values(i) for i in range(plan.size)] == [{"m.k": 100, "m.m": 1}, {"m.k": 400.5, "m.m": 2.5}]
    (tmp_path / "points.csv").write_text('"m.k, kN/m"\n1.5\n')
    assert plan_of(SCENE, plan_settings(tmp_path / "plan.toml")).values(0) == {"m.k": 1500.0}
    (tmp_path / "points.csv").write_text("m.k [kN/m];m.m\n1,5;0,25\n2;1\n")
    plan = plan_of(SCENE, plan_settings(tmp_path / "plan.toml"))
    assert [plan.values(i) for i in range(plan.size)] == [{"m.k": 1500.0, "m.m": 0.25}, {"m.k": 2000.0, "m.m": 1}]
    (tmp_path / "points.csv").write_text('"m.k, kg"\n1\n')
    with pytest.raises(BadInput, match="unit 'kg', expected a unit of the dimension of N/m"):
        plan_of(SCENE, plan_settings(tmp_path / "plan.toml"))


def test_values_with_their_units():
    """In lists, ranges and distributions, full names and nested tables; 0, or a number beside SI units, needs no unit. A number alone
    beside others with units, and another dimension, are refused."""
    vary = {"m": {"k": ["0.5 kN/m", 0.0]}, "m.m": {"from": "1 kg", "to": "3000 g", "points": 3}, "stop_time": ["1500 ms"]}
    plan = plan_settings({"vary": vary}, scene=SCENE).vary
    assert {name: axis.values for name, axis in plan.items()} == {
        "m.k": (500.0, 0.0),
        "m.m": (1.0, 2.0, 3.0),
        "stop_time": (1.5,),
    }
    far = {"distribution": "normal", "mean": "500 N/m", "deviation": 20.0}
    axis = plan_settings({"method": "sobol", "points": 4, "vary": {"m.k": far}}, scene=SCENE).vary["m.k"]
    assert (axis.mean, axis.deviation) == (500.0, 20.0)
    for wrong in (["5 kg"], {"from": "1 N/m", "to": "2 m", "points": 3}, far | {"deviation": "1 kg"}):
        with pytest.raises(BadInput, match="dimension of N/m"):
            plan_settings({"vary": {"m.k": wrong}}, scene=SCENE)
    for mixed in (["0.5 kN/m", 400.0], {"from": 100.0, "to": "2 kN/m", "points": 3}, far | {"deviation": "0.1 kN/m"}):
        with pytest.raises(BadInput, match="a unit at each number, or at none"):
            plan_settings({"vary": {"m.k": mixed | {"mean": 500.0} if "mean" in mixed else mixed}}, scene=SCENE)
    swept = read_scene(MASS | {"sweep": {"m": {"k": ["0.5 kN/m"]}}})
    assert swept.sweep == {"m.k": (500.0,)}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("m.k=100:300:3", {"from": 100.0, "to": 300.0, "points": 3}),
        ("m.k=1 kN/m:2 kN/m:3", {"from": "1 kN/m", "to": "2 kN/m", "points": 3}),
        ("m.k=100, 2 kN/m", [100.0, "2 kN/m"]),
    ],
)
def test_ranges_and_lists_of_the_command_line(text, values):
    assert ranges_of([text]) == {"m.k": values}


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["m.k=1,2", "m.c=3", "m.k=4:5:2"], "--over: got m.k twice, expected each name once"),
        (["m.k=1,2,1.0"], "--over: got 'm.k=1,2,1.0', with 1.0 twice, expected each value once"),
        (["m.k=1 m,2 m,1 m"], "--over: got 'm.k=1 m,2 m,1 m', with 1 m twice, expected each value once"),
    ],
)
def test_what_is_given_twice_is_refused(texts, message):
    """The last one had been taken, and a value that came twice was run twice, without a word."""
    with pytest.raises(BadInput, match=re.escape(message)):
        ranges_of(texts)


@pytest.mark.parametrize("text", ["m.k", "m.k=", "m.k=1:2", "m.k=1:2:3:4", "m.k=a,b", "m.k=1:2:x"])
def test_other_texts_of_the_command_line_are_refused(text):
    with pytest.raises(BadInput, match="from:to:points or"):
        ranges_of([text])


def test_effects_presets_units_and_the_master_vary():
    scene = load_scene("en50318-2002")
    point = {"catenary.effects.dropper_slackening": False, "master.step": 5e-4, "pantograph.static_force": 80.0}
    one = scene.with_changes(point)
    assert "dropper_slackening" not in one.units["catenary"].effects
    assert (one.master.step, one.units["pantograph"].parameters["static_force"]) == (5e-4, 80.0)
    on = scene.with_changes(point | {"catenary.effects.dropper_slackening": True})
    assert "dropper_slackening" in on.units["catenary"].effects
    other = SCENE.with_changes({"units.m": {"component": "cosimo.tests.support:Probe"}})
    assert other.units["m"].component.endswith("Probe")
    assert dict(other.units["m"].parameters) == {}


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({}, "neither vary nor table"),
        ({"vary": {"m.k": []}}, r"vary\.m\.k"),
        ({"vary": {"m.k": [float("nan")]}}, "finite"),
        ({"vary": {"m.k": UNIFORM}}, "distribution with method 'grid'"),
        ({"method": "sobol", "vary": {"m.k": UNIFORM}}, "points"),
        ({"method": "grid", "points": 4, "vary": {"m.k": [1.0]}}, "points"),
        ({"method": "list", "vary": {"m.k": [1.0], "m.m": [1.0, 2.0]}}, "one length"),
        ({"method": "random", "points": 4, "vary": {"m.k": {"distribution": "norml", "mean": 1.0}}}, "'normal'"),
        ({"method": "random", "points": 4, "vary": {"m.k": {"distribution": "normal", "mean": 1.0}}}, "mean, deviation"),
        ({"method": "random", "points": 4, "vary": {"m.k": {"distribution": "uniform", "low": 2.0, "high": 1.0}}}, "low < high"),
        ({"vary": {"m.kk": [1.0]}}, "'k'"),
        ({"vary": {"m.m": [1.0, -1.0]}}, "m = -1.0"),
        ({"vary": {"n.k": [1.0]}}, "unit 'n'"),
        ({"vary": {"units.m.presett": [""]}}, "'preset'"),
        ({"vary": {"m.effects.wear": [True]}}, "effect of m"),
        ({"vary": {"m.k": [1.0]}, "keep": {"interval": 0.1}}, "signals"),
        ({"vary": {"m.k": [1.0]}, "keep": {"functions": ["here"]}}, "module:function"),
        ({"vary": {"m.k": [1.0]}, "limits": {"a": 3.0}}, r"limits\.a: got 3\.0, expected a table"),
        ({"vary": {"m.k": [1.0]}, "sed": 3}, "'seed'"),
        ({"vary": {"m.k": {"from": 1.0, "to": 1.0, "points": 3}}}, "first value"),
        (
            {
                "method": "random",
                "points": 4,
                "vary": {"m.k": UNIFORM, "m.m": NORMAL},
                "correlation": [["m.k", "m.m", 0.5], ["m.m", "m.k", 0.2]],
            },
            "m.m, m.k twice",
        ),
    ],
)
def test_bad_plans_are_one_message(settings, named):
    with pytest.raises(BadInput, match=named):
        plan_of(SCENE, plan_settings(settings))


def test_a_method_that_does_not_count_may_be_left_out():
    """Of a sensitivity, which takes samples of its own."""
    assert plan_settings({"vary": {"m.k": UNIFORM}}, sampled=False).vary["m.k"].high == UNIFORM["high"]
    with pytest.raises(BadInput, match="'grid'"):
        plan_settings({"vary": {"m.k": UNIFORM}})


def test_a_number_that_is_probably_in_another_unit_is_asked_about_in_every_way(capsys):
    question = "160 km/h or 160 m/s"
    scene = load_scene("en50318-2002").with_changes({"pantograph.speed": 160.0})
    assert any(question in text for text in scene.coupling.interfaces["pantograph"].remarks)
    swept = plan_of(scene, plan_settings({"vary": {"pantograph.speed": [70.0, 160.0]}}))
    assert any(question in text for text in swept.remarks)
    assert exit_code("run", "en50318-2002", "--dry-run", "--set", "pantograph.speed=160") == 2
    assert f"expected a number with its unit. {question}" in capsys.readouterr().err
