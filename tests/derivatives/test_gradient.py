"""Derivatives of figures: against differences of runs, with their errors, refusals and files."""

from __future__ import annotations

import csv
from types import SimpleNamespace

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.derivatives.gradient import _recorded
from cosimo.orchestrator.scene.names import numerical_of
from cosimo.tests.commands import exit_code

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
FIGURE = "mass.base_x, maximum"


@pytest.fixture(scope="module")
def scene():
    return cosimo.load_scene("mass-on-spring").with_changes({"stop_time": 0.5})


@pytest.fixture(scope="module")
def measured(scene):
    return cosimo.gradient(scene, [FIGURE, "spring.second_force_x, last"], ["mass.mass", "spring.stiffness"])


@pytest.mark.parametrize("parameter", ["mass.mass", "spring.stiffness"])
@pytest.mark.parametrize("figure", [FIGURE, "spring.second_force_x, last"])
def test_a_derivative_is_that_of_differences(scene, measured, figure, parameter):
    exact, runs = measured[figure, parameter], cosimo.gradient(scene, figure, parameter, differences=1e-4)[figure, parameter]
    assert exact.how == "exact"
    assert exact.derivative != 0.0
    assert exact.derivative == pytest.approx(runs.derivative, rel=1e-5)
    assert exact.elasticity == pytest.approx(exact.derivative * exact.at / exact.value)


def test_a_function_of_ones_own_gives_figures_with_their_units(scene, measured):
    end = lambda result: {"end": (result["spring.second_force_x"][-1], "N")}  # noqa: E731
    slope = cosimo.gradient(scene, end, "mass.mass")["end", "mass.mass"]
    assert (slope.unit, slope.derivative) == ("N", measured["spring.second_force_x, last", "mass.mass"].derivative)


def test_the_error_is_about_the_change_with_shorter_steps(scene, measured):
    finest = scene.with_changes({"master.step": scene.master.step / 16.0})
    figure = "spring.second_force_x, last"
    true = cosimo.gradient(finest, figure, "mass.mass", halved=False)[figure, "mass.mass"].derivative
    slope = measured[figure, "mass.mass"]
    assert 0.4 * slope.error < abs(slope.derivative - true) < 1.5 * slope.error  # twice the change, of first order


def test_the_largest_elasticity_stands_first(measured):
    elasticities = [abs(s.elasticity) for s in measured.slopes if s.figure == FIGURE]
    assert elasticities == sorted(elasticities, reverse=True)


def test_a_derivative_at_a_boundary_is_refused_or_one_sided():
    """At standstill the law of dry friction jumps: which way the robot starts decides all."""
    scene = cosimo.load_scene("pipe-robot-level").with_changes({"stop_time": 0.05, "analysis.transient": 0.0})
    slope = cosimo.gradient(scene, "bristles.velocity, last", "bristles.start_velocity", halved=False).slopes[0]
    assert slope.how != "exact"
    assert np.isnan(slope.derivative) or slope.how.startswith("one-sided")


def test_the_rate_of_a_joint_that_stands_still_has_a_derivative_on_its_side():
    """A joint with dry friction that starts one way or the other: at rest neither is the derivative, close beside rest each is."""
    scene = cosimo.load_scene("two-link-manipulator").with_changes({"stop_time": 0.05, "analysis.transient": 0.0})
    figure, parameter = "arm.first_angle, last", "arm.start_first_rate"
    slope = cosimo.gradient(scene, figure, parameter, halved=False)[figure, parameter]
    runs = [cosimo.run(scene.with_changes({parameter: d}), in_process=True, verify="no") for d in (0.0, 1e-5, 2e-5)]
    rest, near, far = (run["arm.first_angle"][-1] for run in runs)
    assert slope.how == "one-sided, above"
    assert slope.derivative == pytest.approx((4.0 * near - far - 3.0 * rest) / 2e-5, rel=1e-5)
    assert slope.derivative > 1e-3


@pytest.mark.parametrize(
    ("changes", "by", "words"),
    [
        ({}, "mass.mas", "mass.mass"),
        ({"master.algorithm": "iterative"}, "mass.mass", "iterative"),
        ({"units.mass.isolation": "process"}, "mass.mass", "process of its own"),
    ],
)
def test_what_has_no_derivative_is_refused_by_name(scene, changes, by, words):
    with pytest.raises(BadInput, match=words):
        cosimo.gradient(scene.with_changes(changes), FIGURE, by)


def test_differences_serve_what_has_no_derivative(scene, measured):
    iterative = scene.with_changes({"master.algorithm": "iterative"})
    slope = cosimo.gradient(iterative, FIGURE, "mass.mass", differences=1e-4)[FIGURE, "mass.mass"]
    assert slope.how == "differences"
    assert slope.derivative == pytest.approx(measured[FIGURE, "mass.mass"].derivative, rel=0.1)


def test_settings_of_the_numerics_are_refused(scene):
    study = cosimo.gradient(scene.with_changes({"stop_time": 0.1}), FIGURE, ["mass.substep", "mass.mass"], halved=False)
    assert set(study.refused) == {"mass.substep"}
    assert {s.parameter for s in study.slopes} == {"mass.mass"}


def test_settings_of_the_numerics_are_known_in_effects_too():
    names = ["outer_motor.inductance.substep", "outer_motor.inductance.inductance"]
    assert numerical_of(cosimo.load_scene("gimbal-scan"), names).keys() == {"outer_motor.inductance.substep"}


def test_a_transient_longer_than_the_run_is_refused(scene):
    with pytest.raises(BadInput, match="less than the length of the run"):
        cosimo.gradient(scene.with_changes({"analysis.transient": 2.0}), "mass.base_x, last", "mass.mass")


def test_figures_of_snapshots_have_no_derivative():
    """They are not signals, and nothing follows them; a run may have some where figures do not read them."""
    scene = cosimo.load_scene("en50318-2002").with_changes({"stop_time": 0.05, "record.snapshot_interval": 0.01})
    array = scene.record.snapshots[0]
    signal = next(iter(".".join(end) for end in scene.coupling.signals))

    def of_array(result):
        return {"first": (float(result.snapshots[array].values[-1].sum()), "1")}

    def of_signal(result):
        return {"last": (float(result[signal][-1]), "N")}

    with pytest.raises(BadInput, match="snapshots"):
        cosimo.gradient(scene, of_array, "pantograph.static_force", halved=False)
    assert cosimo.gradient(scene, of_signal, "pantograph.static_force", halved=False).slopes[0].how == "exact"


def test_a_figure_that_reads_a_parameter_at_its_limit_has_both_sides(scene):
    """A scene would refuse what lies beyond the limit, and the derivative would be half of what it is."""
    at_limit = scene.with_changes({"spring.damping": 0.0})

    def figure(result):
        return {"twice": (2.0 * result.scene.units["spring"].parameters["damping"], "N.s/m")}

    slope = cosimo.gradient(at_limit, figure, "spring.damping", halved=False).slopes[0]
    assert slope.derivative == pytest.approx(2.0, rel=1e-9)
    assert slope.how == "exact"


def test_a_session_takes_its_parameters_along(scene):
    with cosimo.open(scene) as session:
        session["mass.mass"] = 2.0
        slope = session.gradient(FIGURE, "spring.stiffness", halved=False).slopes[0]
    other = cosimo.gradient(scene.with_changes({"mass.mass": 2.0}), FIGURE, "spring.stiffness", halved=False).slopes[0]
    assert slope == other


def test_the_command_writes_a_table_and_a_page(tmp_path, capsys):
    wanted = ("--of", FIGURE, "--by", "mass.mass", "--stop", "0.2", "-o", str(tmp_path / "out"))
    assert exit_code("gradient", "mass-on-spring", *wanted) == 0
    assert "mass.mass" in capsys.readouterr().out
    rows = list(csv.DictReader((tmp_path / "out" / "gradient.csv").read_text().splitlines()))
    assert [(row["figure"], row["parameter"], row["how"]) for row in rows] == [(FIGURE, "mass.mass", "exact")]
    assert "elasticity" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(("size", "other"), [(1e-15, False), (1e-9, True)])
def test_a_residual_of_rounding_is_no_other_run(size, other):
    """A signal that is what rounding leaves has other digits in machine code with tangents; one that says something has not."""
    time, master = np.array([0.0, 1e-3]), SimpleNamespace(step=1e-3)
    base = SimpleNamespace(time=time, columns={"a.residual": np.full(2, size)}, scene=SimpleNamespace(name="mine", master=master))
    rows = SimpleNamespace(time=time, values=np.full((2, 1), 1.1 * size), tangents=np.zeros((2, 1, 1)))
    if other:
        with pytest.raises(BadInput, match=r"a\.residual of the run with derivatives is another one"):
            _recorded(base, SimpleNamespace(signals=[("a", "residual")]), rows)
    else:
        assert _recorded(base, SimpleNamespace(signals=[("a", "residual")]), rows)["a.residual"].shape == (2, 1)
