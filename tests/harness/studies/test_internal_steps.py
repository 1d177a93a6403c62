"""Measured limits of components' internal steps: RK4's own, and what the components say themselves."""

import csv
import math

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.components.core.integrators import RK4_STABILITY_RADIUS, OdeComponent
from cosimo.components.core.kernels import COMPILED
from cosimo.components.core.variables import Causality
from cosimo.orchestrator.harness.studies.full_model import with_required
from cosimo.orchestrator.harness.studies.internal_steps import internal_steps
from cosimo.tests.commands import exit_code
from cosimo.tests.short_run import ONE_A_SYSTEM, full_but

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
IMAGINARY, REAL = 2.0 * math.sqrt(2.0), 2.785293563405282  # where |1 + z + z²/2 + z³/6 + z⁴/24| = 1 on the two axes
WITHIN = 0.02
INTEGRATED = [
    name
    for name in CATALOGUE
    if issubclass(component_class(name), OdeComponent)
    and any(v.causality is Causality.INPUT and "." not in n for n, v in component_class(name).variables.items())
]


def one(name, effects=(), **parameters):
    (found,) = internal_steps(name, effects=effects, parameters=parameters).steps
    return found


def test_an_undamped_pendulum_has_the_limit_on_the_imaginary_axis():
    """A uniform rod of 1 m: ω² = 3 g / (2 L)."""
    found = one("PlanarLink", ("pinned", "gravity"))
    assert found.longest == pytest.approx(IMAGINARY / math.sqrt(1.5 * 9.81), rel=WITHIN)
    assert found.own == pytest.approx(RK4_STABILITY_RADIUS / math.sqrt(1.5 * 9.81), rel=1e-12)
    assert found.margin == pytest.approx(IMAGINARY / RK4_STABILITY_RADIUS, rel=WITHIN)


def test_strong_damping_has_the_limit_on_the_real_axis():
    """The lumped catenary in mid-span, where it is softest: the faster one of two real eigenvalues."""
    cls = component_class("LumpedCatenary")
    p = cls().parameters
    harmonics = [p[f"harmonic[{n + 1}]"] for n in range(10)]
    k = p["mean_stiffness"] * (1.0 + sum(a * (-1) ** (n + 1) for n, a in enumerate(harmonics)))
    fastest = np.abs(np.roots([p["mass"], p["damping"], k])).max()
    found = one("LumpedCatenary")
    assert found.longest == pytest.approx(REAL / fastest, rel=WITHIN)
    assert found.margin >= 1.0  # what it says itself holds for every place along the span


def test_the_lumped_catenary_promises_no_step_that_is_unstable_anywhere_along_the_span():
    for position in np.linspace(0.0, 60.0, 25):
        catenary = component_class("LumpedCatenary")()
        p = catenary.parameters
        x = 2.0 * math.pi * position / p["span_length"]
        k = p["mean_stiffness"] * (1.0 + sum(p[f"harmonic[{n}]"] * math.cos(n * x) for n in range(1, 11)))
        z = np.roots([p["mass"], p["damping"], k]) * catenary.stable_step()
        assert np.abs(1.0 + z + z**2 / 2.0 + z**3 / 6.0 + z**4 / 24.0).max() <= 1.0


def test_a_free_body_has_no_limit():
    found = one("PlanarLink")
    assert found.longest == found.own == math.inf
    assert math.isnan(found.margin)


@pytest.mark.parametrize("name", full_but(ONE_A_SYSTEM[:1], INTEGRATED))
def test_no_component_promises_more_than_was_measured(name):
    found = one(name)
    assert math.isnan(found.margin) or found.margin >= 1.0 - WITHIN, found


def test_rk4_bears_its_reach_in_every_direction_and_no_more():
    """|1 + z + z²/2 + z³/6 + z⁴/24| over the left half of a circle."""
    z = np.exp(1j * np.linspace(0.5, 1.0, 2001) * math.pi)

    def grows(radius):
        w = radius * z
        return np.abs(1.0 + w + w**2 / 2.0 + w**3 / 6.0 + w**4 / 24.0).max() > 1.0 + 1e-12

    assert not grows(RK4_STABILITY_RADIUS)
    assert grows(1.004 * RK4_STABILITY_RADIUS)


def test_each_effect_is_measured_with_what_it_needs():
    found = internal_steps("PlanarLink")
    assert [s.effects for s in found.steps] == [(), ("pinned",), ("gravity",)]
    cls = component_class("BeamRotor")
    assert with_required(cls, "unbalance") == ("disks", "unbalance")


def test_what_cannot_be_measured_is_said():
    with pytest.raises(BadInput, match="no internal steps"):
        internal_steps("CompliantJoint")
    with pytest.raises(BadInput, match="Did you mean 'PlanarLink'"):
        internal_steps("PlanarLnk")
    refused = one("PlanarLink", ("pinned",), start_velocity_x=1.0)
    assert math.isnan(refused.longest)
    assert "pinned base" in refused.seen


def test_the_command_writes_table_and_page(tmp_path, capsys):
    assert (
        exit_code(
            "stability",
            "component:PlanarLink",
            "--effects",
            "pinned,gravity",
            "--set",
            "length=2",
            "--set",
            "centre=1",
            "-o",
            tmp_path,
        )
        == 0
    )
    rows = list(csv.reader((tmp_path / "stability.csv").open(encoding="utf-8")))
    assert rows[0][:4] == ["effects", "longest stable internal step, s", "own limit, s", "margin, 1"]
    inertia = 1.0 / 12.0 + 1.0
    assert float(rows[1][1]) == pytest.approx(IMAGINARY * math.sqrt(inertia / 9.81), rel=WITHIN)
    assert (tmp_path / "report.html").exists()
    assert "Planar link" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["component:PlanarLink", "--over", "a.b=1:2:3"], "--over"),
        (["component:PlanarLink", "--set", "mass"], "parameter=value"),
        (["mass-on-spring", "--effects", "gravity"], "--effects"),
        (["mass-on-spring", "--algorithm", "jakobi"], "Did you mean 'jacobi'"),
        (["double-pendulum"], "feeds back"),
    ],
)
def test_options_that_would_have_no_effect_are_refused(arguments, said, tmp_path, capsys):
    assert exit_code("stability", *arguments, "-o", str(tmp_path)) == 2
    assert said in capsys.readouterr().err
