"""Sensitivity, uncertainty, fits and designs against closed forms."""

import numpy as np
import pytest
import tomli_w
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.many.sensitivity import analyse, sample, sensitivity
from cosimo.orchestrator.harness.many.uncertainty import plan_of_tolerances, tolerance_rank, uncertainty
from cosimo.orchestrator.harness.sweep import sweep
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.harness.many.points import formula
from cosimo.tests.harness.test_sweep import MASS

UNIT = {"distribution": "uniform", "low": 0.0, "high": 1.0}
ISHIGAMI = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[0.0, 1.0]] * 3}


def ishigami(cube, a=7.0, b=0.1):
    x1, x2, x3 = (np.pi * (2.0 * c - 1.0) for c in cube.T)
    return np.sin(x1) + a * np.sin(x2) ** 2 + b * x3**4 * np.sin(x1)


def test_sobol_indices_of_the_ishigami_function():
    """Closed form (Ishigami and Homma 1990): S1 = V1/V, V2/V, 0; ST = (V1 + V13)/V, V2/V, V13/V."""
    pytest.importorskip("SALib")
    a, b = 7.0, 0.1
    first, second, both = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a * a / 8.0, b * b * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + both
    cube = sample(ISHIGAMI, "sobol", 2048, 1)
    rows, blocks = analyse(ISHIGAMI, "sobol", cube, ishigami(cube), 1)
    assert blocks == 2048
    exact = np.array([[first, first + both], [second, second], [0.0, both]]) / whole
    assert (np.abs(rows[:, [0, 2]] - exact) < 1.5 * rows[:, [1, 3]] + 1e-3).all()  # six intervals of 95 % at once
    assert np.abs(rows[:, [0, 2]] - exact).max() < 0.03


def test_a_failed_run_voids_its_block_alone():
    """SALib gives zeros for a single NaN. The intervals are the same again, by any seed."""
    pytest.importorskip("SALib")
    cube = sample(ISHIGAMI, "sobol", 256, 1)
    y = ishigami(cube)
    y[[7, 503]] = np.nan  # blocks of five
    rows, blocks = analyse(ISHIGAMI, "sobol", cube, y, 0)
    kept = np.repeat(~np.isin(np.arange(256), [1, 100]), 5)
    same, _ = analyse(ISHIGAMI, "sobol", cube[kept], y[kept], 0)
    assert blocks == 254
    assert np.array_equal(rows, same)
    with pytest.raises(BadInput, match="complete blocks"):
        analyse(ISHIGAMI, "sobol", cube, np.full(y.size, np.nan), 1)


def test_morris_effects_of_a_linear_function():
    """Elementary effects are the coefficients, and have no scatter."""
    pytest.importorskip("SALib")
    cube = sample(ISHIGAMI, "morris", 10, 1)
    assert cube.min() > 0.0
    assert cube.max() < 1.0  # where quantiles are finite
    rows, _ = analyse(ISHIGAMI, "morris", cube, cube @ np.array([3.0, -2.0, 0.0]), 1)
    np.testing.assert_allclose(rows[:, 0], [3.0, 2.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(rows[:, 2], 0.0, atol=1e-9)


def test_morris_effects_of_a_scene_are_changes_per_range():
    """2 a + b over ranges of 3 and 0.5: effects of 6 and 0.5, with no scatter."""
    pytest.importorskip("SALib")
    vary = {"f.a": {"distribution": "uniform", "low": 1.0, "high": 4.0}, "f.b": UNIT | {"high": 0.5}}
    answer = sensitivity(
        read_scene(formula()), {"vary": vary}, quantities=["f.linear, end"], method="morris", samples=8, verify=False
    )
    np.testing.assert_allclose([i.first for i in answer.indices], [6.0, 0.5], rtol=1e-9)
    np.testing.assert_allclose([i.total for i in answer.indices], 0.0, atol=1e-9)


def test_sensitivity_of_a_scene(tmp_path):
    """2 a + b of uniform numbers: four fifths and one fifth of the variance."""
    pytest.importorskip("SALib")
    answer = sensitivity(
        read_scene(formula()),
        {"vary": {"f.a": UNIT, "f.b": UNIT}, "method": "sobol", "points": 1},
        quantities=["f.linear, end"],
        samples=64,
    )
    assert [(i.parameter, i.quantity) for i in answer.indices] == [("f.a", "f.linear, end"), ("f.b", "f.linear, end")]
    for index, exact in zip(answer.indices, (0.8, 0.2), strict=True):
        assert abs(index.first - exact) < 2.0 * index.first_half
        assert abs(index.total - exact) < 2.0 * index.total_half
    assert "quantity" in answer.save(tmp_path).read_text()
    with pytest.raises(BadInput, match="correlated"):
        sensitivity(
            read_scene(formula()),
            {"vary": {"f.a": UNIT, "f.b": UNIT}, "method": "random", "points": 1, "correlation": [["f.a", "f.b", 0.5]]},
            quantities=["f.linear, end"],
        )


def test_answers_in_a_console_are_lines_of_their_numbers():
    """f = 2 a + b: everything follows."""
    scene, vary = read_scene(formula(a=1.0)), {"f.a": {"low": 0.0, "high": 1.0}}
    found = design(scene, {"minimise": ["f.linear, end"], "vary": vary})
    assert repr(found).startswith(
        f"<Design: {len(found.steps)} runs, 1 best>\nf.linear, end {found.steps[found.best].quantity:.5g}"
    )
    fitted = fit(scene, {"vary": vary, "targets": [{"quantity": "f.linear, end", "value": 1.0, "deviation": 0.1}]})
    assert f"f.a: {fitted.fit.values[0]:.6g} ± {fitted.fit.deviations[0]:.2g}" in repr(fitted)
    table = sweep(scene, {"vary": {"f.a": [0.0, 0.25, 0.5]}})
    assert repr(table).splitlines()[1] == "f.a: 0 to 0.5"
    frame = table.to_pandas()
    assert frame["f.linear, maximum"].tolist() == [0.0, 0.5, 1.0]
    assert frame["outcome"].tolist() == ["done"] * 3


def test_tolerance_ranks_are_those_of_wilks():
    """The smallest numbers of samples for two-sided 95 % / 95 %: 93, 153 for the second order statistics (published tables)."""
    assert [tolerance_rank(n) for n in (0, 1, 92, 93, 152, 153)] == [0, 0, 0, 1, 1, 2]
    inside = 0
    rng = np.random.default_rng(4)
    for _ in range(2000):  # of a uniform distribution the content is the distance of the ends
        x = np.sort(rng.random(93))
        inside += x[-1] - x[0] >= 0.95
    assert 0.94 < inside / 2000 < 0.97  # 0.9500 and three standard errors of 0.005 above


def test_the_terminal_says_how_many_samples_a_tolerance_interval_needs(tmp_path, capsys):
    (tmp_path / "s.toml").write_text(tomli_w.dumps(formula(a=1.0, b=3.0)))
    (tmp_path / "plan.toml").write_text(tomli_w.dumps({"method": "random", "points": 20, "vary": {"f.a": UNIT}}))
    assert (
        exit_code(
            "uncertainty",
            tmp_path / "s.toml",
            "--plan",
            tmp_path / "plan.toml",
            "--quantity",
            "f.linear, end",
            "--jobs",
            "1",
            "-o",
            tmp_path / "out",
        )
        == 0
    )
    shown = capsys.readouterr().out
    assert shown.count("needs 93 samples") == 2
    assert "nan" not in shown


def test_uncertainty_of_a_scene():
    """2 a + b of normal numbers with deviations 0.1 and 0.2: sqrt(0.04 + 0.04)."""
    plan = {
        "method": "sobol",
        "points": 256,
        "vary": {
            "f.a": {"distribution": "normal", "mean": 1.0, "deviation": 0.1},
            "f.b": {"distribution": "normal", "mean": 3.0, "deviation": 0.2},
        },
    }
    answer = uncertainty(read_scene(formula(a=1.0, b=3.0)), plan, quantities=["f.linear, end"])
    (spread,) = answer.spreads
    assert spread.mean == pytest.approx(5.0, abs=0.01)
    assert spread.deviation == pytest.approx(np.sqrt(0.08), rel=0.03)
    low, high = spread.tolerance
    assert low < 5.0 - 1.96 * np.sqrt(0.08) < 5.0 + 1.96 * np.sqrt(0.08) < high  # a tolerance interval holds the central 95 %


def measured(folder, k=400.0, m=1.0, v0=2.0, noise=0.002):
    """A file of a mass on a spring with noise, by its closed form x = v0/ω sin ωt."""
    t = np.arange(0.0, 2.0, 0.01)
    omega = np.sqrt(k / m)
    x = v0 / omega * np.sin(omega * t) + noise * np.random.default_rng(8).standard_normal(t.size)
    (folder / "measured.csv").write_text("t,x\n" + "".join(f"{a:.6f},{b:.9f}\n" for a, b in zip(t, x, strict=True)))
    return {"signal": "m.x_out", "file": "measured.csv", "time": "t", "column": "x", "noise": noise}


def test_a_fit_has_the_deviations_of_its_closed_form(tmp_path):
    """Stiffness and speed at the start from a noisy curve; covariance (JᵀJ)⁻¹ σ² with the derivatives of the closed form."""
    curve = measured(tmp_path)
    scene = read_scene(MASS | {"sweep": {}, "master": {"step": 1e-2}})
    settings = {
        "vary": {"m.k": {"low": 300.0, "high": 500.0, "start": 380.0}, "m.v0": {"low": 1.0, "high": 3.0}},
        "curves": [curve],
    }
    answer = fit(scene, settings, folder=tmp_path)
    t, omega, v0 = np.arange(0.0, 2.0, 0.01), 20.0, 2.0
    by_k = v0 * (t * np.cos(omega * t) / omega - np.sin(omega * t) / omega**2) / (2.0 * omega)
    jacobian = np.stack([by_k, np.sin(omega * t) / omega], axis=1)
    exact = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))) * 0.002
    np.testing.assert_allclose(answer.fit.deviations, exact, rtol=0.03)
    assert (np.abs(answer.fit.values - [400.0, 2.0]) < 4.0 * exact).all()
    assert answer.fit.rms == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * t.size))
    assert answer.fit.messages == ()
    assert answer.scene.units["m"].parameters["k"] == answer.fit.values[0]


def test_a_fit_says_what_the_data_cannot_tell(tmp_path):
    """Position depends on stiffness over mass alone."""
    curve = measured(tmp_path)
    scene = read_scene(MASS | {"sweep": {}, "master": {"step": 1e-2}})
    answer = fit(
        scene,
        {"vary": {"m.k": {"low": 300.0, "high": 500.0, "start": 410.0}, "m.m": {"low": 0.8, "high": 1.3}}, "curves": [curve]},
        folder=tmp_path,
    )
    assert any("told apart" in text or "do not identify" in text for text in answer.fit.messages)


def test_a_fit_to_numbers_and_bad_fits(tmp_path):
    targets = [
        {"quantity": "f.linear, end", "value": 7.0, "deviation": 0.1},
        {"quantity": "f.total, end", "value": 5.0, "deviation": 0.1},
    ]
    vary = {"f.a": {"low": 0.0, "high": 9.0}, "f.b": {"low": 0.0, "high": 9.0}}
    answer = fit(read_scene(formula()), {"vary": vary, "targets": targets})
    np.testing.assert_allclose(answer.fit.values, [2.0, 3.0], atol=1e-5)
    # a = y1 - y2, b = 2 y2 - y1: deviations sqrt(2) and sqrt(5) times 0.1
    np.testing.assert_allclose(answer.fit.deviations, [0.1 * np.sqrt(2.0), 0.1 * np.sqrt(5.0)], rtol=1e-4)
    for settings, named in (
        ({"vary": vary}, "neither curves nor targets"),
        ({"vary": {}, "targets": targets}, "vary"),
        ({"vary": vary, "targets": [targets[0] | {"quantity": "f.linar, end"}]}, "'f.linear'"),
        ({"vary": {"f.c": vary["f.a"]}, "targets": targets}, "a variable of Formula"),
    ):
        with pytest.raises(BadInput, match=named):
            fit(read_scene(formula()), settings)


@pytest.mark.parametrize("method", ["COBYQA", "SLSQP"])
def test_a_design_under_a_constraint(method, tmp_path):
    """(a - 1)² + (b - 2)² with a + b <= 2: at (1/2, 3/2) it is 1/2 (Lagrange)."""
    settings = {
        "vary": {"f.a": {"low": -4.0, "high": 4.0}, "f.b": {"low": -4.0, "high": 4.0}},
        "minimise": "f.parabola, end",
        "constraints": {"f.total, end": {"high": 2.0}},
        "method": method,
    }
    answer = design(read_scene(formula()), settings)
    assert answer.values == {"f.a": pytest.approx(0.5, abs=2e-3), "f.b": pytest.approx(1.5, abs=2e-3)}
    assert answer.steps[answer.best].quantity == pytest.approx(0.5, abs=1e-3)
    assert answer.active == ("f.total, end",)
    assert len(answer.steps) < 100
    assert "f.a" in answer.save(tmp_path).read_text().splitlines()[0]


def test_a_design_that_cannot_be_says_so():
    settings = {
        "vary": {"f.a": {"low": 0.0, "high": 1.0}},
        "maximise": "f.total, end",
        "constraints": {"f.linear, end": {"low": 99.0}},
    }
    answer = design(read_scene(formula()), settings)
    assert answer.best == -1
    assert answer.values == {}
    with pytest.raises(BadInput, match="neither minimise nor maximise"):
        design(read_scene(formula()), {"vary": settings["vary"]})


def test_without_a_plan_all_tolerances_and_seeds_are_drawn(capsys):
    """Normal distributions of the tolerances with their correlations; a seed of each effect that has one; nothing is refused."""
    gusty = {
        "units": {
            "catenary": {
                "component": "Catenary",
                "effects": ["line_table", "scatter", "gusts"],
                "tolerances": {"contact_wire_mass": "2 %"},
            },
            "pantograph": {"component": "Pantograph", "tolerances": {"static_force": 5.0, "head_mass": "3 %"}},
        },
        "correlations": {"pantograph.static_force, pantograph.head_mass": 0.5},
        "stop_time": 1.0,
        "master": {"algorithm": "gauss-seidel", "step": 1e-3},
    }
    plan = plan_of_tolerances(read_scene(gusty), 200)
    assert (plan["method"], plan["points"]) == ("random", 200)
    assert plan["vary"]["pantograph.static_force"] == {"distribution": "normal", "mean": 120.0, "deviation": 5.0}
    assert plan["vary"]["pantograph.head_mass"]["deviation"] == pytest.approx(0.03 * 7.2)
    assert {name for name in plan["vary"] if name.endswith("seed")} == {"catenary.scatter.seed", "catenary.gusts.seed"}
    assert plan["correlation"] == [["pantograph.static_force", "pantograph.head_mass", 0.5]]
    assert exit_code("uncertainty", "mass-on-spring", "--quantity", "mass.base_x, maximum") == 2
    assert "no effect with a seed" in capsys.readouterr().err
    assert exit_code("uncertainty", "mass-on-spring", "--plan", "plan.toml", "--samples", "20") == 2
    assert "--samples: no effect with --plan" in capsys.readouterr().err


def test_samples_of_tolerances_have_their_deviation():
    """2 a + b with deviations 0.1 and 0.2 and a correlation of 0.5: sqrt(0.04 + 0.04 + 0.04)."""
    data = formula(a=1.0, b=3.0) | {"correlations": {"f.a, f.b": 0.5}}
    data["units"]["f"]["tolerances"] = {"a": 0.1, "b": 0.2}
    answer = uncertainty(read_scene(data), samples=256, quantities=["f.linear, end"])
    (spread,) = answer.spreads
    assert spread.count == 256
    assert spread.mean == pytest.approx(5.0, abs=4.0 * np.sqrt(0.12 / 256))
    assert spread.deviation == pytest.approx(np.sqrt(0.12), rel=4.0 / np.sqrt(2.0 * 256))
