"""Several measured runs in one fit: closed forms of linear Gaussian systems, and a run that the model does not explain."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
import tomli_w
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.cli import main
from cosimo.orchestrator.scene.scene import write_scene
from cosimo.tests.estimation.oscillator import SIGNAL, Oscillator
from scipy.linalg import expm
from scipy.stats import multivariate_normal

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
POSITION, SPEED = "mass.start_x", "mass.start_velocity_x"
SCENE = Oscillator(h=0.0002).scene(stop_time=2.05)
TIMES = {"slow": 0.1 * np.arange(1, 21), "fast": 0.02 * np.arange(1, 101)}
NOISES = {"slow": 5e-3, "fast": 2e-3}


def moved(times, mass=1.0, stiffness=100.0, damping=0.4):
    """Position over start position and speed, (n, 2), in closed form."""
    A = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
    return np.array([expm(A * t)[0] for t in times])


def write(path, times, values):
    path.write_text("t,x\n" + "".join(f"{float(t)!r},{float(v)!r}\n" for t, v in zip(times, values, strict=True)))
    return {"signal": SIGNAL, "file": path.name, "time": "t", "column": "x"}


@pytest.fixture
def two(tmp_path):
    """A plan of two runs from different positions with one speed, at two rates, and the closed form: H, y, noise."""
    rng, runs, rows, y, noise = np.random.default_rng(3), [], [], [], []
    for k, (name, x0) in enumerate({"slow": 0.05, "fast": -0.1}.items()):
        M, s = moved(TIMES[name]), NOISES[name]
        values = M @ [x0, 0.8] + s * rng.standard_normal(len(M))
        curve = write(tmp_path / f"{name}.csv", TIMES[name], values) | {"noise": s}
        runs.append({"condition": name, "vary": {POSITION: {"low": -0.5, "high": 0.5}}, "curves": [curve]})
        H = np.zeros((len(M), 3))
        H[:, 0], H[:, 1 + k] = M[:, 1], M[:, 0]
        rows, y, noise = [*rows, H], [*y, values], [*noise, np.full(len(M), s)]
    plan = {"vary": {SPEED: {"low": -4.0, "high": 4.0, "start": 0.1}}, "runs": runs}
    return plan, np.concatenate(rows), np.concatenate(y), np.concatenate(noise)


def test_common_and_own_parameters_are_those_of_the_closed_form(two, tmp_path):
    plan, H, y, noise = two
    W = H / noise[:, None]
    covariance = np.linalg.inv(W.T @ W)
    values, deviations = covariance @ W.T @ (y / noise), np.sqrt(np.diag(covariance))
    answer = cosimo.fit(SCENE, plan | {"profile": True}, tmp_path / "out", folder=tmp_path, verify=False)
    found = answer.fit
    assert found.names == (SPEED, f"slow: {POSITION}", f"fast: {POSITION}")
    assert (found.values - values) / deviations == pytest.approx(np.zeros(3), abs=0.02)
    assert found.covariance == pytest.approx(covariance, rel=0.01, abs=0.01 * covariance.max())
    reach = (found.intervals - found.values[:, None]) / deviations[:, None]
    assert reach == pytest.approx(1.96 * np.array([[-1, 1]] * 3), abs=0.03)
    assert all(how.startswith("exact") for how in answer.derivatives.values())
    assert [(t.run, t.count, t.holds) for t in answer.tests] == [("slow", 20, True), ("fast", 100, True)]
    own = {name: scene.units["mass"].parameters for name, scene in answer.scenes.items()}
    for k, name in enumerate(own):
        assert (own[name]["start_velocity_x"], own[name]["start_x"]) == (found.values[0], found.values[1 + k])
    common = answer.scene.units["mass"]
    assert common.parameters["start_velocity_x"] == found.values[0]
    assert common.parameters.get("start_x") == SCENE.units["mass"].parameters.get("start_x")
    assert common.tolerances["start_velocity_x"] == pytest.approx(deviations[0], rel=0.01)
    assert answer.runs == sum(len(s.outcomes) for s in answer.sweeps)


def test_their_likelihood_and_its_gradient_are_the_closed_form(two, tmp_path):
    plan, H, y, noise = two
    with cosimo.likelihood(SCENE, plan, folder=tmp_path) as likelihood:
        for x in (np.array([0.8, 0.05, -0.1]), np.array([0.5, -0.1, 0.1])):
            exact = multivariate_normal(H @ x, np.diag(noise**2)).logpdf(y)
            assert likelihood(x) == pytest.approx(exact, rel=4e-3)
            assert likelihood.gradient(x) == pytest.approx(H.T @ ((y - H @ x) / noise**2), rel=5e-3, abs=10.0)


def loads(tmp_path, stiffness=(100.0, 100.0, 100.0)):
    """A plan of a mass that is let go with three loads, from a truth in closed form."""
    rng, times, runs = np.random.default_rng(4), 0.02 * np.arange(1, 101), []
    for mass, k in zip((1.0, 2.0, 4.0), stiffness, strict=True):
        x = moved(times, mass, k)[:, 0] * 0.1 + 2e-3 * rng.standard_normal(times.size)
        curve = write(tmp_path / f"{mass:g}.csv", times, x) | {"noise": "2 mm"}
        runs.append({"condition": f"{mass:g} kg", "changes": {"mass.mass": f"{mass * 1e3:g} g"}, "curves": [curve]})
    vary = {"spring.stiffness": {"low": 50.0, "high": 200.0, "start": 90.0}, "spring.damping": {"low": 0.0, "high": 2.0}}
    return {"vary": vary, "runs": runs}


LET_GO = SCENE.with_changes({POSITION: 0.1, SPEED: 0.0, "master.step": 0.002})


def test_runs_at_three_loads_know_a_stiffness_better_than_one(tmp_path):
    plan = loads(tmp_path)
    found = cosimo.fit(LET_GO, plan, folder=tmp_path)
    (stiffness, damping), deviations = found.fit.values, found.fit.deviations
    assert abs(stiffness - 100.0) < 3.0 * deviations[0]
    assert abs(damping - 0.4) < 3.0 * deviations[1]
    assert all(t.holds for t in found.tests)
    alone = cosimo.fit(LET_GO, plan | {"runs": plan["runs"][:1]}, folder=tmp_path)
    assert deviations[0] < 0.9 * alone.fit.deviations[0]
    assert alone.scene.units["mass"].parameters["mass"] == 1.0  # one run: its scene is that of the fit
    assert not alone.scenes


def test_the_run_that_the_model_does_not_explain_is_named(tmp_path, capsys):
    """A spring that is 10 % softer in the last run: the common stiffness explains none, and the message says where."""
    plan = loads(tmp_path, (100.0, 100.0, 90.0))
    (tmp_path / "fit.toml").write_text(tomli_w.dumps(plan))
    write_scene(LET_GO, tmp_path / "scene.toml")
    with pytest.raises(SystemExit, match="0"):
        main(["fit", str(tmp_path / "scene.toml"), "--plan", str(tmp_path / "fit.toml"), "-o", str(tmp_path / "out")])
    said = " ".join("".join(capsys.readouterr()).split())
    assert f"4 kg: the model does not explain {SIGNAL}, since its residuals are" in said
    assert (tmp_path / "out" / "fitted-4 kg.toml").is_file()
    tests = (tmp_path / "out" / "residuals.csv").read_text().splitlines()
    assert len(tests) == 4


def test_an_input_of_a_run_drives_it(tmp_path):
    """A force that is held at 5 N moves the mass at rest to 5 N / k."""
    times = 0.02 * np.arange(1, 101)
    curve = write(tmp_path / "held.csv", times, 0.05 * (1.0 - moved(times)[:, 0])) | {"noise": 1e-4}
    # with damping the step response is x0 (1 - response from rest at distance 1), see `moved`
    (tmp_path / "force.csv").write_text("time [s],mass.tip_force_x [N]\n0,5\n3,5\n")
    vary = {"spring.stiffness": {"low": 50.0, "high": 200.0, "start": 90.0}}
    still = LET_GO.with_changes({POSITION: 0.0})
    plan = {"vary": vary, "runs": [{"condition": "held", "input": "force.csv", "curves": [curve]}]}
    found = cosimo.fit(still, plan, folder=tmp_path)
    assert found.fit.values[0] == pytest.approx(100.0, rel=2e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda p: p["runs"][1].update(condition="slow"), "two of the condition 'slow'"),
        (lambda p: p["vary"].update({POSITION: {"low": 0.0, "high": 1.0}}), "which .vary. has as well"),
        (lambda p: p["runs"][0].update(changes={SPEED: 1.0}), "which is fitted"),
        (lambda p: p.update(curves=p["runs"][0]["curves"]), "beside .*runs"),
        (lambda p: p["runs"][0].update(curves=[]), "runs: slow.*neither curves"),
        (lambda p: p["runs"][0]["curves"][0].pop("noise"), "without the noise of each"),
        (lambda p: p["runs"][0].update(input="none.csv"), "none.csv"),
    ],
)
def test_bad_plans_of_several_runs(two, tmp_path, change, said):
    plan, *_ = two
    change(plan)
    with pytest.raises(BadInput, match=said):
        cosimo.fit(SCENE, plan, folder=tmp_path)
